//! The same parameters, inputs and random numbers give the same bits, whatever else.
#![allow(clippy::unwrap_used, missing_docs)]

use crbm::{ChainRng, Instructions, Layout, Mask, Policy, Sampling};

/// Sizes that fill groups of three units and of sixteen chains, and that don't; masks.
fn machines() -> Vec<(Layout, Sampling)> {
    let legs: Vec<usize> = (0..24).map(|output| output / 4).collect();
    let legs = Layout::new(Mask::full(48, 30).unwrap(), Mask::blocks(8, &legs).unwrap());
    let sizes =
        [(Layout::full(30, 50, 24), 10, 60), (legs, 10, 60), (Layout::full(7, 11, 35), 3, 112)];
    let small = [(Layout::full(0, 1, 1), 2, 1), (Layout::full(3, 0, 4), 0, 15)];
    let machine = |(layout, gibbs_updates, samples): (Result<Layout, _>, _, _)| {
        (layout.unwrap(), Sampling { gibbs_updates, samples })
    };
    sizes.into_iter().chain(small).map(machine).collect()
}

fn policy(layout: &Layout, sampling: Sampling) -> Policy {
    let parameters = layout.random_parameters(0.5, 1, "determinism").unwrap();
    Policy::new(layout.clone(), sampling, &parameters).unwrap()
}

fn input(layout: &Layout, step: usize) -> Vec<bool> {
    (0..layout.n_inputs()).map(|k| (k * 7 + step * 5).is_multiple_of(3)).collect()
}

/// Actions and the bits of the scores over some steps.
fn run(policy: &mut Policy, rng: &mut ChainRng) -> Vec<(Vec<bool>, Vec<u64>)> {
    let layout = policy.layout().clone();
    (0..5)
        .map(|step| {
            let mut y = vec![false; layout.n_outputs()];
            let mut score = vec![f64::NAN; layout.n_parameters()];
            policy.act_and_score(&input(&layout, step), rng, &mut y, &mut score).unwrap();
            (y, score.into_iter().map(f64::to_bits).collect())
        })
        .collect()
}

#[test]
fn all_instructions_give_the_same_bits() {
    for (layout, sampling) in machines() {
        let mut policy = policy(&layout, sampling);
        policy.set_instructions(Instructions::Portable).unwrap();
        let mut expected_rng = policy.rng(3, "policy");
        let expected = run(&mut policy, &mut expected_rng);
        for instructions in Instructions::available() {
            policy.set_instructions(instructions).unwrap();
            assert_eq!(policy.instructions(), instructions);
            let mut rng = policy.rng(3, "policy");
            assert!(run(&mut policy, &mut rng) == expected, "{instructions:?}, {layout:?}");
            assert!(rng == expected_rng, "{instructions:?}: other random numbers next");
        }
    }
}

/// What this machine gave is what any other and any optimisation level must give: a hash (FNV-1a) of
/// the bits, which tells that something changed, not what is right.
#[test]
fn the_bits_are_those_of_other_machines() {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for (layout, sampling) in machines() {
        let mut policy = policy(&layout, sampling);
        let mut rng = policy.rng(3, "policy");
        for (y, score) in run(&mut policy, &mut rng) {
            for number in y.into_iter().map(u64::from).chain(score) {
                hash = (hash ^ number).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
    }
    assert_eq!(hash, 0xc832_67be_a586_c643, "{hash:#x}");
}

#[test]
fn a_restored_stream_continues() {
    let (layout, sampling) = machines().swap_remove(0);
    let mut policy = policy(&layout, sampling);
    let mut rng = policy.rng(3, "policy");
    run(&mut policy, &mut rng);
    let mut restored = ChainRng::from_words(&rng.words()).unwrap();
    assert!(run(&mut policy, &mut rng) == run(&mut policy, &mut restored));
}

#[test]
fn earlier_calls_leave_no_trace() {
    for (layout, sampling) in machines() {
        let mut fresh = policy(&layout, sampling);
        let mut used = policy(&layout, sampling);
        let other = layout.random_parameters(3.0, 2, "determinism").unwrap();
        used.set_parameters(&other).unwrap();
        let mut other_rng = used.rng(4, "other");
        run(&mut used, &mut other_rng);
        let parameters = layout.random_parameters(0.5, 1, "determinism").unwrap();
        used.set_parameters(&parameters).unwrap();
        let mut rngs = [fresh.rng(3, "policy"), fresh.rng(3, "policy")];
        assert!(run(&mut fresh, &mut rngs[0]) == run(&mut used, &mut rngs[1]));
    }
}

#[test]
fn acting_alone_gives_the_same_actions() {
    for (layout, sampling) in machines() {
        let mut policy = policy(&layout, sampling);
        let mut rng = policy.rng(3, "policy");
        let with_score = run(&mut policy, &mut rng);
        let mut rng = policy.rng(3, "policy");
        for (step, (expected, _)) in with_score.into_iter().enumerate() {
            let mut y = vec![false; layout.n_outputs()];
            policy.act(&input(&layout, step), &mut rng, &mut y).unwrap();
            assert_eq!(y, expected);
        }
    }
}

#[test]
fn the_score_at_the_drawn_action_is_the_one_that_came_with_it() {
    let (layout, sampling) = machines().swap_remove(1);
    let mut policy = policy(&layout, sampling);
    let mut rng = policy.rng(3, "policy");
    let (y, expected) = run(&mut policy, &mut rng).swap_remove(0);
    let mut score = vec![0.0; layout.n_parameters()];
    let mut rng = policy.rng(3, "policy");
    policy.score(&input(&layout, 0), &y, &mut rng, &mut score).unwrap();
    assert!(score.into_iter().map(f64::to_bits).eq(expected));
}

/// A mask is a full machine with zeros, but for the zeros' scores, which it leaves out.
#[test]
fn a_mask_is_zeros_that_stay_zero() {
    let (blocks, sampling) = machines().swap_remove(1);
    // Holes everywhere, in V as in W.
    let inputs = Mask::from_fn(48, 30, |j, k| (j + k) % 3 != 0).unwrap();
    let outputs = Mask::from_fn(48, 24, |j, i| j % 6 == i / 4).unwrap();
    for layout in [blocks, Layout::new(inputs, outputs).unwrap()] {
        assert_mask_is_zeros(&layout, sampling);
    }
}

fn assert_mask_is_zeros(layout: &Layout, sampling: Sampling) {
    let full = Layout::full(layout.n_inputs(), layout.n_hidden(), layout.n_outputs()).unwrap();
    let parameters = layout.random_parameters(0.5, 1, "determinism").unwrap();
    let mut dense = vec![0.0; full.n_parameters()];
    let pairs = layout.input_mask().pairs();
    let mut places: Vec<usize> = pairs.filter_map(|(j, k)| full.input_weight(j, k)).collect();
    places.extend(full.hidden_biases());
    let pairs = layout.output_mask().pairs();
    places.extend(pairs.filter_map(|(j, i)| full.output_weight(j, i)));
    places.extend(full.output_biases());
    places.iter().zip(&parameters).for_each(|(place, parameter)| dense[*place] = *parameter);

    let mut masked = policy(layout, sampling);
    let mut full = Policy::new(full, sampling, &dense).unwrap();
    let mut rngs = [masked.rng(3, "policy"), masked.rng(3, "policy")];
    let of_masked = run(&mut masked, &mut rngs[0]);
    for ((y, score), (full_y, full_score)) in of_masked.iter().zip(run(&mut full, &mut rngs[1])) {
        assert_eq!(*y, full_y);
        assert!(places.iter().map(|place| full_score[*place]).eq(score.iter().copied()));
    }
}

//! What holds for every kind of the list, whatever it is.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

#[allow(unreachable_pub)]
mod common;

use common::{build, inputs, run, small, svenja, variants};
use crbm::MAX_PARAMETER;
use policy::{Error, Group, KindSettings, Policy, Structure};
use proptest::prelude::*;

/// All kinds and their variants, for both robots; the legged one remembers a reading.
fn each(mut check: impl FnMut(&dyn Fn(u64) -> Box<dyn Policy>, &str)) {
    for robot in [small(), Structure { readings: 2, ..svenja() }] {
        for kind in variants(3) {
            check(&|seed| build(&kind, &robot, 0.5, seed), &format!("{kind:?}, {robot:?}"));
        }
    }
}

/// All that a policy is.
fn whole(policy: &dyn Policy) -> (Vec<f64>, Vec<u32>) {
    (policy.parameters().to_vec(), policy.random_state())
}

#[test]
fn a_seed_makes_a_policy() {
    each(|build, what| {
        let (mut one, mut same, other) = (build(1), build(1), build(2));
        assert_eq!(whole(&*one), whole(&*same), "{what}");
        assert_ne!(one.parameters(), other.parameters(), "{what}");
        assert_ne!(one.random_state(), other.random_state(), "{what}");
        assert!(one.parameters().iter().all(|value| *value != 0.0 && value.abs() < 5.0), "{what}");
        assert_eq!(run(&mut *one, 0..3), run(&mut *same, 0..3), "{what}");
        one.draw_from(3, "other");
        assert_ne!(one.random_state(), same.random_state(), "{what}");
        same.draw_from(3, "other");
        assert_eq!(run(&mut *one, 0..3), run(&mut *same, 0..3), "{what}");
    });
}

#[test]
fn acting_alone_gives_the_same_outputs() {
    each(|build, what| {
        let (mut one, mut other) = (build(1), build(1));
        for (step, (expected, _)) in run(&mut *one, 0..20).into_iter().enumerate() {
            let mut y = vec![false; other.n_outputs()];
            other.act(&inputs(&*other, step), &mut y).unwrap();
            assert_eq!(y, expected, "{what}");
        }
    });
}

#[test]
fn a_saved_policy_goes_on_with_the_same_bits() {
    each(|build, what| {
        let (mut one, mut other) = (build(1), build(2));
        run(&mut *one, 0..7);
        let (parameters, state) = whole(&*one);
        run(&mut *other, 0..3);
        other.set_parameters(&parameters).unwrap();
        other.set_random_state(&state).unwrap();
        assert_eq!(whole(&*other), (parameters, state), "{what}");
        assert_eq!(run(&mut *one, 7..15), run(&mut *other, 7..15), "{what}");
    });
}

#[test]
fn files_are_read_as_they_were_written() {
    each(|build, what| {
        let (one, mut other) = (build(1), build(2));
        let bytes = one.to_safetensors().unwrap();
        assert_eq!(bytes, one.to_safetensors().unwrap(), "{what}");
        let before = whole(&*other);
        let parameters = other.read_safetensors(&bytes).unwrap();
        assert_eq!(whole(&*other), before, "{what}");
        assert_eq!(parameters, one.parameters(), "{what}");
        other.set_parameters(&parameters).unwrap();
        assert_eq!(bytes, other.to_safetensors().unwrap(), "{what}");
    });
}

#[test]
fn damaged_files_are_refused() {
    each(|build, what| {
        let policy = build(1);
        let bytes = policy.to_safetensors().unwrap();
        let data = 8 + u64::from_le_bytes(*bytes.first_chunk().unwrap()) as usize;
        for place in (data..bytes.len()).step_by((bytes.len() - data) / 10) {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1;
            assert!(policy.read_safetensors(&damaged).is_err(), "{what}: byte {place}");
        }
        for end in [0, 7, data / 2, data, bytes.len() - 1] {
            assert!(policy.read_safetensors(&bytes[..end]).is_err(), "{what}: {end} bytes");
        }
    });
}

/// Kinds aren't each other's, whatever the tensors.
#[test]
fn files_of_other_kinds_are_refused() {
    for here in KindSettings::all() {
        for there in KindSettings::all().iter().filter(|there| **there != here) {
            let file = build(there, &svenja(), 0.1, 1).to_safetensors().unwrap();
            let error = build(&here, &svenja(), 0.1, 1).read_safetensors(&file).unwrap_err();
            let names = [there, &here].map(KindSettings::name);
            let expected = format!("kind: {} there, {} here", names[0], names[1]);
            assert_eq!(error.to_string(), format!("another policy's parameters: {expected}"));
        }
    }
}

#[test]
fn files_of_other_robots_are_refused() {
    for kind in variants(3) {
        let file = build(&kind, &svenja(), 0.1, 1).to_safetensors().unwrap();
        let error = build(&kind, &small(), 0.1, 1).read_safetensors(&file).unwrap_err();
        assert!(matches!(error, Error::OtherLayout(_)), "{kind:?}: {error}");
        assert!(error.to_string().contains(" there, "), "{error}");
    }
}

#[test]
fn wrong_lengths_are_refused_and_change_nothing() {
    each(|build, what| {
        let mut policy = build(1);
        let before = whole(&*policy);
        let (k, n, p) = (policy.n_inputs(), policy.n_outputs(), policy.parameters().len());
        let words = before.1.len();
        let refused = |result: Result<(), Error>, part: &str| {
            let message = result.unwrap_err().to_string();
            assert!(message.contains(&format!("length of {part} must be")), "{what}: {message}");
        };
        for (k, n, p, part) in
            [(k + 1, n, p, "inputs"), (k, n - 1, p, "outputs"), (k, n, 0, "score")]
        {
            let (x, mut y, mut score) = (vec![true; k], vec![false; n], vec![0.0; p]);
            refused(policy.act_and_score(&x, &mut y, &mut score), part);
            if part != "score" {
                refused(policy.act(&x, &mut y), part);
            }
        }
        refused(policy.set_parameters(&vec![0.0; p + 1]), "parameters");
        refused(policy.set_random_state(&vec![1; words - 1]), "state");
        assert_eq!(whole(&*policy), before, "{what}");
    });
}

#[test]
fn numbers_that_are_none_are_refused_and_change_nothing() {
    each(|build, what| {
        let (mut policy, mut twin) = (build(1), build(1));
        for value in [f64::NAN, f64::NEG_INFINITY, 2.0 * MAX_PARAMETER] {
            let mut parameters = vec![0.0; policy.parameters().len()];
            *parameters.last_mut().unwrap() = value;
            let message = policy.set_parameters(&parameters).unwrap_err().to_string();
            assert!(message.ends_with(&format!("in -1e9..=1e9, got {value}")), "{what}: {message}");
        }
        assert_eq!(run(&mut *policy, 0..3), run(&mut *twin, 0..3), "{what}");
    });
}

#[test]
fn the_largest_parameters_give_scores_that_are_none_but_numbers() {
    each(|build, what| {
        let mut policy = build(1);
        let signs: Vec<f64> = policy.parameters().iter().map(|value| value.signum()).collect();
        for size in [60.0, MAX_PARAMETER] {
            policy
                .set_parameters(&signs.iter().map(|sign| sign * size).collect::<Vec<_>>())
                .unwrap();
            let scores = run(&mut *policy, 0..3).into_iter().flat_map(|(_, score)| score);
            assert!(scores.map(f64::from_bits).all(|score| score.abs() <= 1.0), "{what}");
        }
    });
}

#[test]
fn acting_and_changing_parameters_allocate_nothing() {
    each(|build, what| {
        let mut policy = build(1);
        let x = inputs(&*policy, 0);
        let mut y = vec![false; policy.n_outputs()];
        let parameters = policy.parameters().to_vec();
        let mut score = vec![0.0; parameters.len()];
        let counted = allocation_counter::measure(|| {
            for _ in 0..3 {
                policy.set_parameters(&parameters).unwrap();
                policy.act_and_score(&x, &mut y, &mut score).unwrap();
                policy.act(&x, &mut y).unwrap();
            }
        });
        assert_eq!(counted.count_total, 0, "{what}: {counted:?}");
    });
}

/// E[grad log p(y|x)] = 0 for any p. Some 100 parameters of 10 policies, each within 6 standard
/// errors: false-alarm rate 2e-6.
#[test]
fn scores_have_the_mean_0() {
    for kind in variants(3) {
        let mut policy = build(&kind, &small(), 0.5, 4);
        let (x, n) = (inputs(&*policy, 1), 3000.0);
        let mut y = vec![false; policy.n_outputs()];
        let mut score = vec![0.0; policy.parameters().len()];
        let mut sums = vec![(0.0, 0.0); score.len()];
        for _ in 0..n as usize {
            policy.act_and_score(&x, &mut y, &mut score).unwrap();
            for (sum, score) in sums.iter_mut().zip(&score) {
                *sum = (sum.0 + score, sum.1 + score * score);
            }
        }
        for (place, (sum, squares)) in sums.into_iter().enumerate() {
            let error = f64::sqrt(squares) / n;
            assert!((sum / n).abs() <= 6.0 * error, "{kind:?}: {place}: {} +- {error}", sum / n);
        }
    }
}

/// Robots of all shapes: groups without actuators or inputs, actuators in several groups or none.
fn robots() -> impl Strategy<Value = Structure> {
    let group = |(inputs, actuators): (usize, usize)| {
        let some = |count: usize| proptest::collection::vec(0..count.max(1), 0..4);
        (some(inputs), some(actuators), some(3))
    };
    ((1..7usize, 1..5usize), 1..4usize, 1..3usize).prop_flat_map(move |(counts, readings, bits)| {
        let groups = proptest::collection::vec(group(counts), 3);
        (Just((counts, readings, bits)), groups).prop_map(|((counts, readings, bits), groups)| {
            let groups = groups.into_iter().enumerate().map(|(i, group)| Group {
                name: format!("group {i}"),
                inputs: group.0,
                actuators: group.1,
                neighbours: group.2,
            });
            Structure {
                bits_per_reading: counts.0,
                readings,
                actuators: (0..counts.1).map(|i| i.to_string()).collect(),
                bits_per_actuator: bits,
                groups: groups.collect(),
            }
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn any_robot_gets_a_policy_or_is_told_why_not(robot in robots()) {
        for kind in variants(2) {
            match kind.get().build(&robot) {
                Ok(mut policy) => {
                    prop_assert_eq!(policy.n_inputs(), robot.n_inputs());
                    prop_assert_eq!(policy.n_outputs(), robot.n_outputs());
                    run(&mut *policy, 0..2);
                }
                Err(error) => prop_assert!(error.to_string().ends_with("is in no group"), "{}", error),
            }
        }
    }
}

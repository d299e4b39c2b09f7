//! What is drawn and scored, against enumeration: log p(y|x) of each kind by formulas that share
//! nothing with the policies but the order of the parameters.
//!
//! Every test has a fixed seed. A test's false-alarm rate is the probability that another seed would
//! have failed it, had the code been right.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

#[allow(unreachable_pub)]
mod common;

use common::{build, run, small, svenja, variants};
use crbm::{Exact, Instructions, Layout};
use policy::{
    Connectivity, Crbm, CrbmSettings, Group, Inputs, KindSettings, MachineSettings, Modular,
    ModularSettings, Policy, Structure,
};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// log p(y|x).
fn log_p(kind: &KindSettings, robot: &Structure, theta: &[f64], x: &[bool], y: &[bool]) -> f64 {
    match kind {
        KindSettings::Crbm(settings) => {
            machine(Crbm::new(settings, robot).unwrap().layout(), theta, x, y)
        }
        KindSettings::Modular(settings) => {
            let modular = Modular::new(settings, robot).unwrap();
            let modules = modular.modules().map(|(name, layout, range)| {
                let group = robot.groups.iter().find(|group| group.name == name).unwrap();
                let (x, y) = part(robot, group, settings.inputs, x, y);
                machine(layout, &theta[range], &x, &y)
            });
            modules.sum()
        }
        KindSettings::Logistic(_) => {
            let (weights, biases) = theta.split_at(x.len() * y.len());
            let log_p = |((row, bias), on): ((&[f64], &f64), &bool)| {
                let sum: f64 = row.iter().zip(x).map(|(w, on)| w * f64::from(u8::from(*on))).sum();
                let a = if *on { sum + bias } else { -sum - bias };
                -libm::log1p(libm::exp(-a))
            };
            weights.chunks(x.len()).zip(biases).zip(y).map(log_p).sum()
        }
        other => panic!("no formula for {other:?}"),
    }
}

fn machine(layout: &Layout, theta: &[f64], x: &[bool], y: &[bool]) -> f64 {
    let exact = Exact::new(layout, theta).unwrap();
    exact.log_probabilities(x).unwrap()[exact.number(y).unwrap()]
}

/// What a leg of [`small`] sees, and what is drawn for it; the last reading belongs to no leg.
fn part(
    robot: &Structure,
    group: &Group,
    inputs: Inputs,
    x: &[bool],
    y: &[bool],
) -> (Vec<bool>, Vec<bool>) {
    let mut seen = group.inputs.clone();
    match inputs {
        Inputs::All => seen = (0..3).collect(),
        Inputs::OwnGroup => {}
        Inputs::Neighbours => {
            seen.extend(group.neighbours.iter().flat_map(|&other| &robot.groups[other].inputs));
        }
    }
    seen.push(3);
    seen.sort_unstable();
    (seen.iter().map(|&k| x[k]).collect(), group.actuators.iter().map(|&i| y[i]).collect())
}

fn bits(number: usize, n: usize) -> Vec<bool> {
    (0..n).map(|i| number >> i & 1 == 1).collect()
}

fn number(y: &[bool]) -> usize {
    y.iter().enumerate().map(|(i, on)| usize::from(*on) << i).sum()
}

/// With so many Gibbs updates that the chains' start doesn't matter: for weights of the size below its
/// part in a score is far below the tests' noise (a table of `crbm` has it).
fn sampled_well() -> Vec<KindSettings> {
    let mut all = variants(4);
    for kind in &mut all {
        match kind {
            KindSettings::Crbm(CrbmSettings { machine, .. })
            | KindSettings::Modular(ModularSettings { machine, .. }) => {
                *machine = MachineSettings { hidden_units: 4, gibbs_updates: 20, samples: 20 };
            }
            _ => {}
        }
    }
    // Other kinds have formulas, and tests by them, of their own.
    all.retain(|kind| ["crbm", "modular", "logistic"].contains(&kind.name()));
    let is_first = |&i: &usize| !all[..i].contains(&all[i]);
    (0..all.len()).filter(is_first).map(|i| all[i].clone()).collect()
}

/// Chi-square over all 64 outputs; false-alarm rate 1e-6 for each of some 20.
#[test]
fn outputs_have_the_distribution_of_the_formulas() {
    let robot = small();
    for kind in sampled_well() {
        let mut policy = build(&kind, &robot, 0.8, 3);
        for x in [[true, false, true, true], [false, true, true, false]] {
            let (mut counts, draws) = (vec![0.0; 64], 4000);
            let mut y = [false; 6];
            for _ in 0..draws {
                policy.act(&x, &mut y).unwrap();
                counts[number(&y)] += 1.0;
            }
            let p = |y| log_p(&kind, &robot, policy.parameters(), &x, &bits(y, 6)).exp();
            let expected: Vec<f64> = (0..64).map(|y| p(y) * f64::from(draws)).collect();
            assert!((expected.iter().sum::<f64>() / f64::from(draws) - 1.0).abs() < 1e-12);
            // Rare outputs go together: the statistic's distribution is the limit's from some 10 on.
            let (mut sum, mut cells, mut rest) = (0.0, 0, (0.0, 0.0));
            for (count, expected) in counts.iter().zip(&expected) {
                if *expected < 10.0 {
                    rest = (rest.0 + count, rest.1 + expected);
                } else {
                    sum += (count - expected).powi(2) / expected;
                    cells += 1;
                }
            }
            if rest.1 > 0.0 {
                sum += f64::powi(rest.0 - rest.1, 2) / rest.1.max(1.0);
                cells += 1;
            }
            let tail = ChiSquared::new(f64::from(cells - 1)).unwrap().sf(sum);
            assert!(tail > 1e-6, "{kind:?}: chi-square {sum:.1} of {cells} cells, tail {tail:e}");
        }
    }
}

/// The gradient of log p(y|x), by central differences.
fn differences(kind: &KindSettings, theta: &[f64], x: &[bool], y: &[bool]) -> Vec<f64> {
    let robot = small();
    let h = 1e-5;
    let mut moved = theta.to_vec();
    let difference = |place: usize| {
        let mut at = |step| {
            moved[place] = theta[place] + step;
            log_p(kind, &robot, &moved, x, y)
        };
        let slope = (at(h) - at(-h)) / (2.0 * h);
        moved[place] = theta[place];
        slope
    };
    (0..theta.len()).map(difference).collect()
}

/// Truncation and rounding of differences of step 1e-5 are below 1e-9 for numbers of this size.
#[test]
fn the_logistic_score_is_exact() {
    let kind = KindSettings::all().into_iter().find(|kind| kind.name() == "logistic").unwrap();
    let mut policy = build(&kind, &small(), 0.8, 5);
    let (mut y, mut score) = ([false; 6], vec![0.0; policy.parameters().len()]);
    for step in 0..32 {
        let x = bits(step % 16, 4);
        policy.act_and_score(&x, &mut y, &mut score).unwrap();
        let slopes = differences(&kind, policy.parameters(), &x, &y);
        for (score, slope) in score.iter().zip(slopes) {
            assert!((score - slope).abs() < 1e-9, "{score}, {slope}");
        }
    }
}

/// The mean of the score less the gradient at the drawn output. Each of some 800 parameters within 6
/// standard errors: false-alarm rate 2e-6.
#[test]
fn sampled_scores_are_the_gradient_in_their_mean() {
    for kind in sampled_well().into_iter().filter(|kind| kind.name() != "logistic") {
        let mut policy = build(&kind, &small(), 0.8, 6);
        let (x, calls) = ([true, false, true, true], 1500.0);
        let (mut y, mut score) = ([false; 6], vec![0.0; policy.parameters().len()]);
        let mut slopes: Vec<Option<Vec<f64>>> = vec![None; 64];
        let mut sums = vec![(0.0, 0.0); score.len()];
        for _ in 0..calls as usize {
            policy.act_and_score(&x, &mut y, &mut score).unwrap();
            let slopes = slopes[number(&y)]
                .get_or_insert_with(|| differences(&kind, policy.parameters(), &x, &y));
            for ((sum, score), slope) in sums.iter_mut().zip(&score).zip(slopes) {
                *sum = (sum.0 + (score - *slope), sum.1 + (score - *slope).powi(2));
            }
        }
        for (place, (sum, squares)) in sums.into_iter().enumerate() {
            let (mean, error) = (sum / calls, f64::sqrt(squares) / calls);
            assert!(mean.abs() <= 6.0 * error + 1e-6, "{kind:?}: {place}: {mean} +- {error}");
        }
    }
}

/// The paper's machine through the list is the machine itself: parameters, outputs, scores, random
/// numbers and files.
#[test]
fn the_listed_machine_is_the_machine() {
    let robot = svenja();
    let leg_of_output: Vec<usize> = (0..24).map(|output| output / 4).collect();
    let legs = crbm::Mask::blocks(8, &leg_of_output).unwrap();
    let legs = Layout::new(crbm::Mask::full(48, 30).unwrap(), legs).unwrap();
    let cases = [
        (50, Connectivity::Full, Layout::full(30, 50, 24).unwrap()),
        (8, Connectivity::PerGroup, legs),
    ];
    for (hidden_units, connectivity, layout) in cases {
        let machine = MachineSettings { hidden_units, gibbs_updates: 10, samples: 60 };
        let kind = KindSettings::Crbm(CrbmSettings { machine, connectivity, inputs: Inputs::All });
        let mut policy = build(&kind, &robot, 0.01, 7);
        let parameters = layout.random_parameters(0.01, 7, "start").unwrap();
        let sampling = crbm::Sampling { gibbs_updates: 10, samples: 60 };
        let mut machine = crbm::Policy::new(layout.clone(), sampling, &parameters).unwrap();
        let mut chains = machine.rng(7, "policy");
        assert_eq!(policy.parameters(), parameters);
        for (step, (y, score)) in run(&mut *policy, 0..5).into_iter().enumerate() {
            let x = common::inputs(&*policy, step);
            let (mut own_y, mut own_score) = ([false; 24], vec![0.0; parameters.len()]);
            machine.act_and_score(&x, &mut chains, &mut own_y, &mut own_score).unwrap();
            assert_eq!(y, own_y);
            assert!(score.into_iter().eq(own_score.into_iter().map(f64::to_bits)));
        }
        assert_eq!(policy.random_state(), chains.words());
        assert_eq!(policy.to_safetensors().unwrap(), layout.to_safetensors(&parameters).unwrap());
    }
}

/// If one input alone is on, the weights that have a score are those of the parts that see it; of
/// whichever reading.
#[test]
fn a_leg_sees_what_it_should() {
    let robot = Structure { readings: 2, ..svenja() };
    for kind in variants(3) {
        let inputs = match &kind {
            KindSettings::Crbm(settings) => settings.inputs,
            KindSettings::Modular(settings) => settings.inputs,
            _ => continue,
        };
        let mut policy = build(&kind, &robot, 0.5, 8);
        let (mut y, mut score) = ([false; 24], vec![0.0; policy.parameters().len()]);
        for input in 0..60 {
            let mut x = [false; 60];
            x[input] = true;
            policy.act_and_score(&x, &mut y, &mut score).unwrap();
            let seen_by = legs_with_scores(&kind, &robot, &score);
            for (leg, group) in robot.groups.iter().enumerate() {
                let owns = |leg: usize| robot.groups[leg].inputs.contains(&(input % 30));
                let sees = match inputs {
                    Inputs::All => true,
                    Inputs::OwnGroup => owns(leg),
                    Inputs::Neighbours => owns(leg) || group.neighbours.iter().any(|&i| owns(i)),
                };
                assert_eq!(seen_by[leg], sees, "{kind:?}: input {input}, {}", group.name);
            }
        }
    }
}

/// The legs in whose part a weight of an input has a score.
fn legs_with_scores(kind: &KindSettings, robot: &Structure, score: &[f64]) -> Vec<bool> {
    let mut legs = vec![false; robot.groups.len()];
    match kind {
        KindSettings::Crbm(settings) => {
            let crbm = Crbm::new(settings, robot).unwrap();
            let layout = crbm.layout();
            let hidden_of_leg = layout.n_hidden().div_ceil(legs.len());
            for ((hidden, _), score) in layout.input_mask().pairs().zip(score) {
                // Without blocks every hidden unit is every leg's.
                match settings.connectivity {
                    Connectivity::Full => {
                        if *score != 0.0 {
                            legs.fill(true);
                        }
                    }
                    _ => legs[hidden / hidden_of_leg] |= *score != 0.0,
                }
            }
        }
        KindSettings::Modular(settings) => {
            let modular = Modular::new(settings, robot).unwrap();
            for (leg, (_, layout, range)) in legs.iter_mut().zip(modular.modules()) {
                *leg = score[range][layout.input_weights()].iter().any(|score| *score != 0.0);
            }
        }
        _ => {}
    }
    legs
}

#[test]
fn all_instructions_give_the_same_bits() {
    let robot = svenja();
    let parameters = |n| crbm::random_parameters(n, 0.5, 1, "determinism").unwrap();
    for instructions in Instructions::available() {
        let run = |instructions| {
            let mut crbm = Crbm::new(&CrbmSettings::default(), &robot).unwrap();
            crbm.set_instructions(instructions).unwrap();
            crbm.set_parameters(&parameters(crbm.parameters().len())).unwrap();
            let mut modular = Modular::new(&ModularSettings::default(), &robot).unwrap();
            modular.set_instructions(instructions).unwrap();
            modular.set_parameters(&parameters(modular.parameters().len())).unwrap();
            (run(&mut crbm, 0..5), run(&mut modular, 0..5))
        };
        assert!(run(instructions) == run(Instructions::Portable), "{instructions:?}");
    }
}

/// What this machine gave is what any other and any optimisation level must give: a hash (FNV-1a) of
/// the bits, which tells that something changed, not what is right.
#[test]
fn the_bits_are_those_of_other_machines() {
    let mut hashes = Vec::new();
    for name in ["crbm", "modular", "logistic"] {
        let kind = KindSettings::all().into_iter().find(|kind| kind.name() == name).unwrap();
        let mut hash = 0xcbf2_9ce4_8422_2325u64;
        for (y, score) in run(&mut *build(&kind, &svenja(), 0.5, 1), 0..5) {
            for number in y.into_iter().map(u64::from).chain(score) {
                hash = (hash ^ number).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
        hashes.push(hash);
    }
    let expected = [0xc811_1e4f_56b5_44e9, 0xf927_443a_ec6d_71eb, 0x7d4e_ffab_665d_f1d0];
    assert_eq!(hashes, expected, "{hashes:#x?}");
}

#[test]
fn messages_say_what_differs() {
    let robot = svenja();
    let crbm = |hidden_units, inputs| {
        let machine = MachineSettings { hidden_units, gibbs_updates: 1, samples: 1 };
        let connectivity = Connectivity::PerGroup;
        KindSettings::Crbm(CrbmSettings { machine, connectivity, inputs })
    };
    let refused = |there: &KindSettings, here: &KindSettings| {
        let file = build(there, &robot, 0.1, 1).to_safetensors().unwrap();
        build(here, &robot, 0.1, 1).read_safetensors(&file).unwrap_err().to_string()
    };
    assert_eq!(
        refused(&crbm(2, Inputs::All), &crbm(3, Inputs::All)),
        "another policy's parameters: V: [12, 30] there, [18, 30] here; W: [12, 24] there, [18, 24] \
         here; W_mask: [12, 24] there, [18, 24] here; c: [12] there, [18] here"
    );
    assert_eq!(
        refused(&crbm(2, Inputs::All), &crbm(2, Inputs::OwnGroup)),
        "another policy's parameters: V_mask: none there, [12, 30] here"
    );
    assert_eq!(
        refused(&crbm(2, Inputs::OwnGroup), &crbm(2, Inputs::Neighbours)),
        "another policy's parameters: V_mask: 60 connections there, 200 connections here"
    );
    let modular =
        |inputs| KindSettings::Modular(ModularSettings { inputs, ..ModularSettings::default() });
    assert_eq!(
        refused(&modular(Inputs::OwnGroup), &modular(Inputs::All)),
        "another policy's parameters: centre left/V: [8, 5] there, [8, 30] here; centre right/V: [8, \
         5] there, [8, 30] here; front left/V: [8, 5] there, [8, 30] here; front right/V: [8, 5] \
         there, [8, 30] here; and 2 more"
    );
}

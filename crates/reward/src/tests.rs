//! The contract of every kind of every list, and of the reward made of them.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Point3, Vector3};

use super::{
    BodyState, Error, Group, Reward, RewardSettings, RobotLayout, RobotState, Terms, Transition,
    extrinsic::ExtrinsicSettings,
    intrinsic::{self, IntrinsicSettings},
    mix::MixSettings,
};

fn layout() -> RobotLayout {
    let group = Group { name: "leg".into(), positions: vec![0, 1], contacts: vec![0] };
    RobotLayout {
        n_positions: 3,
        n_contacts: 1,
        n_bins: 4,
        groups: vec![group],
        neighbours: vec![[0, 1], [1, 2]],
        bodies: vec!["trunk".into(), "foot".into()],
        heading_body: 0,
        locomotion_scale: 1.0,
    }
}

/// Some course of things that is the same in every run.
fn bins(t: u64) -> [u64; 4] {
    [t % 4, (t * t) % 4, (t / 3) % 4, t % 2]
}

/// Where it takes the robot, at the end of a control step.
fn state(t: u64) -> RobotState {
    let turn = 0.05 * (t % 31) as f64;
    let body =
        |z: f64| BodyState { pose: Isometry3::translation(0.0, 0.0, z), ..Default::default() };
    RobotState {
        bodies: vec![body(0.3 + 0.01 * (t % 7) as f64), body(0.0)],
        centre_of_gravity_m: Point3::new(0.07 * t as f64, 0.2 * (t % 11) as f64, 0.3),
        heading: Vector3::new(libm::cos(turn), libm::sin(turn), 0.0),
        penalised_contacts: (t % 3) as usize,
        ..RobotState::default()
    }
}

/// The reward of the control step that ends in a state.
fn evaluate(reward: &mut Reward, t: u64, after: &RobotState) -> Result<Terms, Error> {
    let work_j = [0.5 * (t % 5) as f64, -1.0, 0.25];
    let (before, bins) = (state(t - 1), bins(t));
    let step = Transition { bins: &bins, work_j: &work_j, ..Transition::between(&before, after) };
    reward.evaluate(&step, t / 50)
}

/// Every extrinsic kind with every intrinsic kind and every mix, as far as they go together.
fn all_rewards() -> Vec<RewardSettings> {
    let mut rewards = Vec::new();
    for extrinsic in ExtrinsicSettings::all() {
        for intrinsic in IntrinsicSettings::all() {
            for mix in MixSettings::all() {
                let penalty = mix.get().one_percent();
                let (extrinsic, intrinsic) = (extrinsic.clone(), intrinsic.clone());
                rewards.push(RewardSettings { scale: 1.0, penalty, extrinsic, intrinsic, mix });
            }
        }
    }
    rewards
}

fn run(reward: &mut Reward, steps: std::ops::Range<u64>) -> Vec<Terms> {
    steps.map(|t| evaluate(reward, t, &state(t)).unwrap()).collect()
}

#[test]
fn every_reward_continues_from_its_state_with_the_same_bits() {
    for settings in all_rewards() {
        let mut reward = Reward::new(&settings, &layout(), 1).unwrap();
        reward.begin(&bins(0)).unwrap();
        run(&mut reward, 1..130);
        let mut other = Reward::new(&settings, &layout(), 1).unwrap();
        other.restore(&reward.save()).unwrap();
        assert_eq!(run(&mut reward, 130..300), run(&mut other, 130..300), "{settings:?}");
        assert_eq!(reward.save(), other.save());
    }
}

#[test]
fn a_state_of_another_reward_is_refused_and_changes_nothing() {
    for settings in all_rewards() {
        let mut reward = Reward::new(&settings, &layout(), 1).unwrap();
        run(&mut reward, 1..130);
        let state = reward.save();
        let longer = [&state[..], &[1]].concat();
        let mut refused = |other: &[u64]| {
            assert!(reward.restore(other).is_err(), "{settings:?}");
            assert_eq!(reward.save(), state);
        };
        refused(&longer);
        if let Some((_, shorter)) = state.split_first() {
            refused(shorter);
            refused(&[]);
        }
    }
}

/// The bytes of checkpoints made before tasks could have a memory.
#[test]
fn a_task_without_a_memory_adds_nothing_to_the_state() {
    for extrinsic in ExtrinsicSettings::all() {
        let settings = RewardSettings { extrinsic, ..Default::default() };
        let mut reward = Reward::new(&settings, &layout(), 1).unwrap();
        run(&mut reward, 1..130);
        let n_words = match settings.extrinsic.kind() {
            "reach" => 3,
            _ => 0,
        };
        let intrinsic = reward.intrinsic.save();
        assert_eq!(reward.save()[..intrinsic.len()], intrinsic);
        assert_eq!(reward.save().len(), intrinsic.len() + n_words);
    }
}

/// What is told of nowhere must be nothing.
#[test]
fn information_that_is_not_measured_is_always_zero() {
    for settings in IntrinsicSettings::all() {
        let mut intrinsic = settings.get().build(&layout()).unwrap();
        let mut is_zero = true;
        for i in 0..200 {
            intrinsic.push(&bins(i)).unwrap();
            is_zero &= intrinsic.value() == intrinsic::Value::default();
        }
        assert_eq!(!is_zero, settings.get().is_measured(), "{settings:?}");
    }
}

#[test]
fn every_kind_says_what_it_measures() {
    let mut symbols = BTreeSet::new();
    for extrinsic in ExtrinsicSettings::all() {
        let extrinsic = extrinsic.get();
        assert!(["m", "rad"].contains(&extrinsic.unit()));
        assert!(symbols.insert(extrinsic.symbol()), "{} twice", extrinsic.symbol());
    }
    for intrinsic in IntrinsicSettings::all() {
        let intrinsic = intrinsic.get();
        assert_eq!(intrinsic.unit(), "nats");
        assert!(["variable", "link"].contains(&intrinsic.per()));
        assert!(symbols.insert(intrinsic.symbol()), "{} twice", intrinsic.symbol());
    }
}

/// A kind that doesn't ask for work must not need it, and one that does must see it.
#[test]
fn work_counts_where_it_is_asked_for() {
    for extrinsic in ExtrinsicSettings::all() {
        let needs_work = extrinsic.get().needs_work();
        let value = |work_j: &[f64]| {
            let mut task = extrinsic.get().build(&layout(), 1).unwrap();
            let (before, after) = (state(1), state(2));
            let step = Transition { work_j, ..Transition::between(&before, &after) };
            task.value(&step)
        };
        assert_eq!(value(&[]) != value(&[5.0, 3.0]), needs_work, "{extrinsic:?}");
    }
}

/// By powers of 2, which scale without rounding.
#[test]
fn the_scale_of_a_reward_changes_nothing_but_its_scale() {
    for settings in all_rewards() {
        let scaled = RewardSettings { scale: 128.0, ..settings.clone() };
        let terms = |settings| run(&mut Reward::new(settings, &layout(), 1).unwrap(), 1..200);
        for (once, scaled) in terms(&settings).into_iter().zip(terms(&scaled)) {
            let penalty = 128.0 * once.penalty;
            assert_eq!(scaled, Terms { reward: 128.0 * once.reward, penalty, ..once });
        }
    }
}

#[test]
fn every_touching_part_costs_the_same() {
    for settings in all_rewards() {
        let settings = RewardSettings { penalty: 0.25, ..settings };
        let terms = |penalised_contacts| {
            let mut reward = Reward::new(&settings, &layout(), 1).unwrap();
            run(&mut reward, 1..20);
            evaluate(&mut reward, 20, &RobotState { penalised_contacts, ..state(20) }).unwrap()
        };
        let [none, two] = [0, 2].map(terms);
        assert_eq!((none.penalty, two.penalty), (0.0, 0.5));
        // One rounding of numbers below 1.
        assert!((none.reward - two.reward - 0.5).abs() < 1e-15);
    }
}

#[test]
fn every_extrinsic_part_is_raw_times_factor() {
    for extrinsic in ExtrinsicSettings::all() {
        let layout = RobotLayout { locomotion_scale: 2.5, ..layout() };
        let factor = extrinsic.get().factor(&layout);
        let settings = RewardSettings { extrinsic, ..Default::default() };
        let mut reward = Reward::new(&settings, &layout, 1).unwrap();
        for terms in run(&mut reward, 1..50) {
            assert_eq!(terms.extrinsic, factor * terms.extrinsic_raw);
        }
    }
}

#[test]
fn every_intrinsic_part_is_finite_and_not_negative() {
    for intrinsic in IntrinsicSettings::all() {
        let mut intrinsic = intrinsic.get().build(&layout()).unwrap();
        for t in 0..300 {
            intrinsic.push(&bins(t)).unwrap();
            let value = intrinsic.value();
            assert!(value.nats >= 0.0 && value.scaled >= 0.0, "{value:?}");
            assert!(value.nats_corrected.is_finite());
        }
    }
}

#[test]
fn every_mix_has_its_degree_and_grows_with_the_task() {
    for mix in MixSettings::all() {
        let mix = mix.get();
        let (small, large) = (mix.mix(0.5, 0.1, 0.3), mix.mix(0.5, 0.2, 0.6));
        // Four powers, each right to an ulp or so.
        let expected = small * libm::pow(2.0, mix.degree());
        assert!((large - expected).abs() < 8.0 * f64::EPSILON * expected);
        assert!(mix.mix(0.5, 0.2, 0.3) > mix.mix(0.5, 0.1, 0.3));
        assert!(mix.mix(0.5, -0.1, 0.3) < mix.mix(0.5, 0.1, 0.3));
        assert_eq!(mix.mix(1.0, 0.0, 0.3), 0.0);
    }
}

#[test]
fn what_blows_up_is_named() {
    let mut reward = Reward::new(&RewardSettings::default(), &layout(), 1).unwrap();
    let mut after = state(1);
    after.centre_of_gravity_m.x = f64::INFINITY;
    let error = evaluate(&mut reward, 1, &after).unwrap_err();
    assert_eq!(error, Error::NotFinite { term: "extrinsic_raw", value: f64::INFINITY });
    let expected = "the reward's term 'extrinsic_raw' must be a finite number, got inf";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn a_reading_that_does_not_fit_is_refused() {
    let mut reward = Reward::new(&RewardSettings::default(), &layout(), 1).unwrap();
    assert!(reward.begin(&[0; 3]).is_err());
    assert!(reward.begin(&[4, 0, 0, 0]).is_err());
    assert!(reward.begin(&[3, 3, 3, 1]).is_ok());
}

#[test]
fn terms_have_a_name_each() {
    let mut names = Terms::NAMES.to_vec();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), Terms::default().as_array().len());
}

/// The paper's main reward by hand: one of three positions alternates for 100 pairs, e = 0.04, one
/// part touches. Its ln 2 is half of what 4 states allow: i = 0.1 * 1/2 * 1/3 = 1/60, and
/// r = (e^0.75 i^0.25)^2 - 0.0001.
#[test]
fn the_main_reward_worked_by_hand() {
    let mut reward = Reward::new(&RewardSettings::default(), &layout(), 1).unwrap();
    reward.begin(&[0, 1, 1, 0]).unwrap();
    let (before, mut after) = (RobotState::default(), RobotState::default());
    after.centre_of_gravity_m.x = 0.04;
    after.penalised_contacts = 1;
    let mut terms = Terms::default();
    for t in 1..=100 {
        let bins = [t % 2, 1, 1, 0];
        let step = Transition { bins: &bins, ..Transition::between(&before, &after) };
        terms = reward.evaluate(&step, 0).unwrap();
    }
    // sqrt(1/60) * 0.008 - 0.0001, with a few roundings.
    assert!((terms.reward - (0.008 * (1.0_f64 / 60.0).sqrt() - 0.0001)).abs() < 1e-17);
    assert!((terms.intrinsic_nats - std::f64::consts::LN_2 / 3.0).abs() < 1e-15);
    assert_eq!((terms.extrinsic_raw, terms.xi, terms.penalty), (0.04, 0.75, 0.0001));
}

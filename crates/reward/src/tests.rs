//! The contract of every kind of every list, and of the reward made of them.
#![allow(clippy::unwrap_used)]

use super::{
    Error, Group, Reward, RewardSettings, SensorLayout, Step, Terms, extrinsic::ExtrinsicSettings,
    intrinsic::IntrinsicSettings, mix::MixSettings,
};

fn layout() -> SensorLayout {
    let group = Group { name: "leg".into(), positions: vec![0, 1], contacts: vec![0] };
    SensorLayout { n_positions: 3, n_contacts: 1, n_bins: 4, groups: vec![group] }
}

/// Some course of things that is the same in every run.
fn bins(t: u64) -> [u64; 4] {
    [t % 4, (t * t) % 4, (t / 3) % 4, t % 2]
}

fn step(t: u64, bins: &[u64]) -> Step<'_> {
    let advance_m = (t % 7) as f64 * 0.02 - 0.05;
    let heading_change_rad = (t % 5) as f64 * 0.03 - 0.06;
    Step { bins, advance_m, heading_change_rad, penalised_contacts: (t % 3) as usize }
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
    let evaluate = |t| reward.evaluate(&step(t, &bins(t)), t / 50).unwrap();
    steps.map(evaluate).collect()
}

#[test]
fn every_reward_continues_from_its_state_with_the_same_bits() {
    for settings in all_rewards() {
        let mut reward = Reward::new(&settings, &layout(), 1.0).unwrap();
        reward.begin(&bins(0)).unwrap();
        run(&mut reward, 1..130);
        let mut other = Reward::new(&settings, &layout(), 1.0).unwrap();
        other.restore(&reward.save()).unwrap();
        assert_eq!(run(&mut reward, 130..300), run(&mut other, 130..300), "{settings:?}");
        assert_eq!(reward.save(), other.save());
        assert!(other.restore(&[1, 2, 3]).is_err());
    }
}

/// By powers of 2, which scale without rounding.
#[test]
fn the_scale_of_a_reward_changes_nothing_but_its_scale() {
    for settings in all_rewards() {
        let scaled = RewardSettings { scale: 128.0, ..settings.clone() };
        let terms = |settings| run(&mut Reward::new(settings, &layout(), 1.0).unwrap(), 0..200);
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
            let mut reward = Reward::new(&settings, &layout(), 1.0).unwrap();
            run(&mut reward, 0..20);
            reward.evaluate(&Step { penalised_contacts, ..step(20, &bins(20)) }, 0).unwrap()
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
        let factor = extrinsic.get().factor(2.5);
        let settings = RewardSettings { extrinsic, ..Default::default() };
        let mut reward = Reward::new(&settings, &layout(), 2.5).unwrap();
        for terms in run(&mut reward, 0..50) {
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
    let mut reward = Reward::new(&RewardSettings::default(), &layout(), 1.0).unwrap();
    let step = Step { advance_m: f64::INFINITY, ..step(1, &[0; 4]) };
    let error = reward.evaluate(&step, 0).unwrap_err();
    assert_eq!(error, Error::NotFinite { term: "extrinsic_raw", value: f64::INFINITY });
    let expected = "the reward's term 'extrinsic_raw' must be a finite number, got inf";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn a_reading_that_does_not_fit_is_refused() {
    let mut reward = Reward::new(&RewardSettings::default(), &layout(), 1.0).unwrap();
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
    let mut reward = Reward::new(&RewardSettings::default(), &layout(), 1.0).unwrap();
    reward.begin(&[0, 1, 1, 0]).unwrap();
    let mut terms = Terms::default();
    for t in 1..=100 {
        let bins = [t % 2, 1, 1, 0];
        let (advance_m, heading_change_rad) = (0.04, 9.0);
        let step = Step { bins: &bins, advance_m, heading_change_rad, penalised_contacts: 1 };
        terms = reward.evaluate(&step, 0).unwrap();
    }
    // sqrt(1/60) * 0.008 - 0.0001, with a few roundings.
    assert!((terms.reward - (0.008 * (1.0_f64 / 60.0).sqrt() - 0.0001)).abs() < 1e-17);
    assert!((terms.intrinsic_nats - std::f64::consts::LN_2 / 3.0).abs() < 1e-15);
    assert_eq!((terms.extrinsic_raw, terms.xi, terms.penalty), (0.04, 0.75, 0.0001));
}

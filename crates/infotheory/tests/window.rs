//! The window against recounts from scratch, against the batch measures, and against itself,
//! restored.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use Estimator::PlugIn;
use common::{BOTH, RADICES, Random, Recount, World, groups, pairs_of, values};
use infotheory::{Estimator, Window, WindowSettings, each_sensor, mutual_information};

/// At every one of 1,200 steps: the same bits as counting the window's pairs anew, as the batch
/// measure of the same pairs, and, within rounding, as the paper's formula term by term.
fn assert_exact(settings: WindowSettings, seed: u64) {
    let groups = groups();
    let mut window = Window::new(settings, &RADICES, &groups).unwrap();
    let mut world = World::new(seed);
    let mut states: Vec<Vec<Vec<u64>>> = vec![Vec::new(); groups.len()];
    for t in 0..1200 {
        let reading = world.reading();
        window.push(&reading).unwrap();
        for (i, group) in groups.iter().enumerate() {
            states[i].push(group.iter().map(|&sensor| reading[sensor]).collect());
            let keep = settings.pairs + settings.lag + settings.past;
            let recent = &states[i][states[i].len().saturating_sub(keep)..];
            let pairs = pairs_of(recent, &settings);
            assert_eq!(window.n_pairs(), pairs.len());
            let recount = Recount::new(&pairs);
            let found = BOTH.map(|e| window.specific_surprise(i, e).unwrap().nats());
            assert_eq!(found[0].to_bits(), recount.surprise().to_bits(), "step {t}, {group:?}");
            let (plug_in, corrected) = recount.surprise_by_definition();
            // At most 100 terms below 5, each with a few roundings of 2^-53.
            assert!((found[0] - plug_in).abs() < 1e-12, "{} {plug_in}", found[0]);
            assert!((found[1] - corrected).abs() < 1e-12, "{} {corrected}", found[1]);
            if !pairs.is_empty() && t % 10 == 0 {
                assert_is_batch(&window, i, &pairs);
            }
        }
    }
}

fn assert_is_batch<S: Clone + Ord>(window: &Window, variable: usize, pairs: &[(S, S)]) {
    let firsts: Vec<&S> = pairs.iter().map(|pair| &pair.0).collect();
    let seconds: Vec<&S> = pairs.iter().map(|pair| &pair.1).collect();
    for estimator in BOTH {
        assert_eq!(
            window.mutual_information(variable, estimator),
            mutual_information(&firsts, &seconds, estimator)
        );
    }
}

#[test]
fn a_window_is_a_recount_at_every_step() {
    assert_exact(WindowSettings::default(), 1);
}

#[test]
fn a_window_with_lag_and_past_is_a_recount_at_every_step() {
    assert_exact(WindowSettings { pairs: 30, lag: 4, past: 3 }, 2);
}

#[test]
fn small_windows_are_recounts_at_every_step() {
    assert_exact(WindowSettings { pairs: 2, lag: 1, past: 1 }, 3);
    assert_exact(WindowSettings { pairs: 3, lag: 2, past: 2 }, 4);
}

/// A window that slid over 300,000 readings, and a new one that saw the last 101.
#[test]
fn nothing_drifts() {
    let settings = WindowSettings::default();
    let mut old = Window::new(settings, &RADICES, &groups()).unwrap();
    let mut world = World::new(5);
    for _ in 0..300_000 {
        old.push(&world.reading()).unwrap();
    }
    let mut young = Window::new(settings, &RADICES, &groups()).unwrap();
    for _ in 0..101 {
        let reading = world.reading();
        old.push(&reading).unwrap();
        young.push(&reading).unwrap();
    }
    assert_eq!(values(&old), values(&young));
}

/// Renamed into a range of 2^40, the states are counted in hash tables in place of tables.
#[test]
fn tables_and_hash_tables_give_the_same_bits() {
    for settings in [WindowSettings::default(), WindowSettings { pairs: 50, lag: 2, past: 3 }] {
        let mut table = Window::new(settings, &[6], &each_sensor(1)).unwrap();
        let mut hash = Window::new(settings, &[1 << 40], &each_sensor(1)).unwrap();
        let mut world = World::new(6);
        for _ in 0..1000 {
            let die = world.reading()[1];
            table.push(&[die]).unwrap();
            hash.push(&[die * 0x12_3456_789a]).unwrap();
            for estimator in BOTH {
                assert_eq!(
                    table.specific_surprise(0, estimator),
                    hash.specific_surprise(0, estimator)
                );
                assert_eq!(
                    table.mutual_information(0, estimator),
                    hash.mutual_information(0, estimator)
                );
            }
        }
    }
}

#[test]
fn a_restored_window_continues_with_the_same_bits() {
    for settings in [WindowSettings::default(), WindowSettings { pairs: 20, lag: 3, past: 2 }] {
        // Before the first pair, before it's full, and long after.
        for readings in [0, 1, 3, 17, 500] {
            let mut window = Window::new(settings, &RADICES, &groups()).unwrap();
            let mut world = World::new(7);
            for _ in 0..readings {
                window.push(&world.reading()).unwrap();
            }
            let mut words = Vec::new();
            window.save(&mut words);

            let mut other = Window::new(settings, &RADICES, &groups()).unwrap();
            for _ in 0..200 {
                other.push(&[1, 5, 39, 3, 0]).unwrap();
            }
            other.restore(&words).unwrap();
            let mut again = Vec::new();
            other.save(&mut again);
            assert_eq!(words, again);
            for _ in 0..150 {
                assert_eq!(values(&window), values(&other));
                let reading = world.reading();
                window.push(&reading).unwrap();
                other.push(&reading).unwrap();
            }
        }
    }
}

/// s: 0 0 1 1 0 0 1 1 0: pairs 00 01 11 10 00 01 11 10. From 0, half each, as all in all.
/// Then 0 follows: 00 is the new pair, 3 of 0's 5 successors, and 5 of all 9.
#[test]
fn a_window_worked_by_hand() {
    let settings = WindowSettings { pairs: 9, lag: 1, past: 1 };
    let mut window = Window::new(settings, &[2], &each_sensor(1)).unwrap();
    for s in [0, 0, 1, 1, 0, 0, 1, 1, 0] {
        window.push(&[s]).unwrap();
    }
    assert_eq!(window.n_pairs(), 8);
    assert_eq!(window.specific_surprise(0, PlugIn).unwrap().nats(), 0.0);
    window.push(&[0]).unwrap();
    let expected = 0.6 * (0.6_f64 / (5.0 / 9.0)).ln() + 0.4 * (0.4_f64 / (4.0 / 9.0)).ln();
    let found = BOTH.map(|e| window.specific_surprise(0, e).unwrap().nats());
    assert!((found[0] - expected).abs() < 1e-14);
    assert!((found[1] - (expected + 1.0 / 18.0 - 1.0 / 10.0)).abs() < 1e-14);
    let share = window.share_of_maximum(PlugIn);
    assert!((share - expected / 2.0_f64.ln()).abs() < 1e-14, "the maximum is ln 2");
}

/// The series (1, 0, 0, 0, 0, 0, 0, 0, 0) and others of Inform's own tests of active information,
/// which is the mutual information of two past symbols and the next, in bits.
#[test]
fn active_information_published_with_inform() {
    let settings = WindowSettings { pairs: 100, lag: 1, past: 2 };
    for (series, bits) in [
        (&[1, 1, 0, 0, 1, 0, 0, 1][..], 0.918_296),
        (&[1, 0, 0, 0, 0, 0, 0, 0, 0], 0.0),
        (&[0, 0, 1, 1, 1, 1, 0, 0, 0], 0.305_958),
        (&[1, 0, 0, 0, 0, 0, 0, 1, 1], 0.347_458),
        (&[0, 0, 0, 0, 0, 1, 1, 0, 0], 0.399_533),
    ] {
        let mut window = Window::new(settings, &[2], &each_sensor(1)).unwrap();
        for &symbol in series {
            window.push(&[symbol]).unwrap();
        }
        let found = window.mutual_information(0, PlugIn).unwrap().bits();
        assert!((found - bits).abs() < 0.6e-6, "{found} where {bits} was due");
    }
}

#[test]
fn the_mean_over_the_pairs_is_their_mutual_information() {
    let mut random = Random::new(8);
    let states = random.symbols(4, 101);
    let pairs = pairs_of(&states, &WindowSettings::default());
    let recount = Recount::new(&pairs);
    let mut window = Window::new(WindowSettings::default(), &[4], &each_sensor(1)).unwrap();
    for &s in &states {
        window.push(&[s]).unwrap();
    }
    let mean = |value: &dyn Fn((f64, f64)) -> f64| {
        pairs.iter().map(|(s, _)| value(recount.surprise_by_definition_of(s))).sum::<f64>() / 100.0
    };
    for (estimator, mean) in BOTH.into_iter().zip([mean(&|both| both.0), mean(&|both| both.1)]) {
        let found = window.mutual_information(0, estimator).unwrap().nats();
        // A sum of 100 terms below 1.
        assert!((found - mean).abs() < 1e-13, "{estimator:?}: {found} {mean}");
    }
}

/// Independent readings of 4 states, 4,000 windows of 100 pairs. The plug-in value's mean is its
/// bias, (K - 1)^2 / 2T' = 0.045 nats to first order; the corrected one's is of second order.
/// A window's value scatters by about 0.06, the mean by 0.001, so +-0.005 is five of those: a false
/// alarm in less than 10^-6 of seeds.
#[test]
fn the_correction_takes_the_bias_away() {
    let mut random = Random::new(9);
    let mut window = Window::new(WindowSettings::default(), &[4], &each_sensor(1)).unwrap();
    let mut means = [0.0; 2];
    for _ in 0..4000 {
        window.clear();
        for _ in 0..=100 {
            window.push(&[random.below(4)]).unwrap();
        }
        for (mean, estimator) in means.iter_mut().zip(BOTH) {
            *mean += window.specific_surprise(0, estimator).unwrap().nats() / 4000.0;
        }
    }
    assert!((means[0] - 0.045).abs() < 0.005, "{means:?}");
    assert!(means[1].abs() < 0.005, "{means:?}");
}

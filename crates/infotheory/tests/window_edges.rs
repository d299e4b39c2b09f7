//! The window at its edges: nothing, one of all, 64 bits and more, the greatest values, misfits.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use Estimator::PlugIn;
use common::{RADICES, World, groups, values};
use infotheory::{Estimator, Window, WindowSettings, all_sensors, each_sensor};

#[test]
fn words_of_another_window_are_refused_and_change_nothing() {
    let settings = WindowSettings { pairs: 5, lag: 1, past: 1 };
    let mut window = Window::new(settings, &[2, 3], &each_sensor(2)).unwrap();
    for t in 0..20 {
        window.push(&[t % 2, t % 3]).unwrap();
    }
    let before = values(&window);
    let mut good = Vec::new();
    window.save(&mut good);
    let changed = |place: usize, word: u64| {
        let mut words = good.clone();
        words[place] = word;
        words
    };
    for (words, expected) in [
        (vec![], "the length of words must be at least 6, got 0"),
        (changed(0, 6), "pairs must be 5, got 6"),
        (changed(1, 2), "lag must be 1, got 2"),
        (changed(2, 2), "past must be 1, got 2"),
        (changed(3, 1), "the words of a reading must be 2, got 1"),
        (changed(5, 7), "the number of readings must be at most 6, got 7"),
        (
            changed(5, u64::MAX),
            "the number of readings must be at most 6, got 18446744073709551615",
        ),
        (changed(5, 5), "the length of words must be 16, got 18"),
        (changed(17, 3), "a state must be below 3, got 3"),
    ] {
        let error = window.restore(&words).unwrap_err().to_string();
        assert_eq!(error, format!("Window::restore: {expected}"));
        assert_eq!(values(&window), before);
    }
    // Other sensors, and other groups, of as many words.
    for (radices, groups) in [([2, 4], vec![vec![0], vec![1]]), ([2, 3], vec![vec![1], vec![0]])] {
        let mut other = Window::new(settings, &radices, &groups).unwrap();
        let error = other.restore(&good).unwrap_err().to_string();
        assert!(error.starts_with("Window::restore: the sensors' hash must be "), "{error}");
    }
    window.restore(&good).unwrap();
    assert_eq!(values(&window), before);
}

/// Alternating is full information, coming back every two steps with a lag of 2 as well; what is
/// drawn anew has none, but for the bias.
#[test]
fn deterministic_sequences_reach_the_maximum() {
    for (period, lag) in [(2, 1), (2, 2), (2, 7), (5, 1), (5, 3), (50, 1)] {
        let settings = WindowSettings { pairs: 100, lag, past: 1 };
        let mut window = Window::new(settings, &[period], &each_sensor(1)).unwrap();
        for t in 0..300 {
            window.push(&[t % period]).unwrap();
        }
        let share = window.share_of_maximum(PlugIn);
        assert!((share - 1.0).abs() < 1e-12, "{period} {lag}: {share}");
    }
}

/// A rare state's value exceeds the maximum of the mean, up to ln N, and isn't clipped.
#[test]
fn single_values_may_exceed_the_maximum() {
    let mut window = Window::new(WindowSettings::default(), &[2], &each_sensor(1)).unwrap();
    for t in 0..=100 {
        window.push(&[u64::from(t >= 99)]).unwrap();
    }
    // Pairs: 98 of 00, one 01, one 11. p(1|1) = 1, p(1) = 2/100.
    let nats = window.specific_surprise(0, PlugIn).unwrap().nats();
    assert!((nats - 50.0_f64.ln()).abs() < 1e-14, "{nats}");
    assert!(window.share_of_maximum(PlugIn) > 5.0);
}

#[test]
fn before_the_first_pair_values_are_zero() {
    let settings = WindowSettings { pairs: 10, lag: 3, past: 2 };
    let mut window = Window::new(settings, &[2, 1 << 50], &each_sensor(2)).unwrap();
    for t in 0..4 {
        assert_eq!(window.n_pairs(), 0);
        assert!(values(&window).iter().all(|&bits| bits == 0));
        window.push(&[t % 2, t]).unwrap();
    }
    window.push(&[0, 7]).unwrap();
    assert_eq!(window.n_pairs(), 1);
    window.clear();
    assert_eq!(window.n_pairs(), 0);
    assert!(values(&window).iter().all(|&bits| bits == 0));
}

#[test]
fn a_window_of_one_pair_or_one_state_holds_nothing() {
    let one_pair = WindowSettings { pairs: 1, lag: 1, past: 1 };
    let mut window = Window::new(one_pair, &RADICES, &groups()).unwrap();
    let mut world = World::new(10);
    let mut stuck = Window::new(WindowSettings::default(), &[1], &each_sensor(1)).unwrap();
    for _ in 0..200 {
        window.push(&world.reading()).unwrap();
        stuck.push(&[0]).unwrap();
        assert!(values(&window).iter().all(|&bits| bits == 0));
        assert!(values(&stuck).iter().all(|&bits| bits == 0));
    }
    assert_eq!((window.n_pairs(), stuck.n_pairs()), (1, 100));
}

/// 64 binary sensors as one state, and 65: nothing wraps, and states that differ in one end bit
/// stay apart.
#[test]
fn sixty_four_bits_and_more_stay_apart() {
    for n in [64, 65, 200] {
        let mut window =
            Window::new(WindowSettings::default(), &vec![2; n], &all_sensors(n)).unwrap();
        for t in 0..=100 {
            let mut reading = vec![1; n];
            (reading[0], reading[n - 1]) = (t % 2, t / 2 % 2);
            window.push(&reading).unwrap();
        }
        let bits = window.mutual_information(0, PlugIn).unwrap().bits();
        assert!((bits - 2.0).abs() < 1e-12, "{n}: {bits}");
    }
}

#[test]
fn misfits_are_refused_with_place_and_value() {
    let settings = WindowSettings::default();
    let new = |settings: WindowSettings, radices: &[u64], groups: &[Vec<usize>]| {
        Window::new(settings, radices, groups).map(|_| ()).unwrap_err().to_string()
    };
    let with = |pairs, lag, past| new(WindowSettings { pairs, lag, past }, &[2], &each_sensor(1));
    for (found, expected) in [
        (with(0, 1, 1), "pairs must be 1 to 1048576, got 0"),
        (with(1 << 21, 1, 1), "pairs must be 1 to 1048576, got 2097152"),
        (with(1, 0, 1), "lag must be 1 to 1048576, got 0"),
        (with(1, 1, 0), "past must be 1 to 64, got 0"),
        (with(1, 1, 65), "past must be 1 to 64, got 65"),
        (
            new(settings, &[2, 0], &each_sensor(2)),
            "the radix of sensor 1 must be at least 1, got 0",
        ),
        (new(settings, &[2], &[]), "the number of groups must be at least 1, got 0"),
        (new(settings, &[], &each_sensor(0)), "the number of groups must be at least 1, got 0"),
        (new(settings, &[2], &[vec![]]), "group 0 must be of at least 1 sensor, got none"),
        (new(settings, &[2], &[vec![0], vec![1]]), "group 1 must be of sensors below 1, got 1"),
        (new(settings, &[2], &[vec![0, 0]]), "group 0 must be of different sensors, got 0 twice"),
    ] {
        assert_eq!(found, format!("Window::new: {expected}"));
    }

    let mut window = Window::new(settings, &[2, 3], &each_sensor(2)).unwrap();
    for t in 0..10 {
        window.push(&[t % 2, t % 3]).unwrap();
    }
    let before = values(&window);
    assert_eq!(
        window.push(&[1]).unwrap_err().to_string(),
        "Window::push: the length of reading must be 2, got 1"
    );
    assert_eq!(
        window.push(&[1, 3]).unwrap_err().to_string(),
        "Window::push: the symbol of sensor 1 must be below 3, got 3"
    );
    assert_eq!(
        window.specific_surprise(2, PlugIn).unwrap_err().to_string(),
        "Window::specific_surprise: variable must be below 2, got 2"
    );
    assert_eq!(
        window.mutual_information(2, PlugIn).unwrap_err().to_string(),
        "Window::mutual_information: variable must be below 2, got 2"
    );
    assert_eq!(values(&window), before, "a refused reading leaves no trace");
}

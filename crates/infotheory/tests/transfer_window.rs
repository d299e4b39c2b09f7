//! The window of transfer entropy against values by hand, against the batch measure at every step, and
//! against itself, restored.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use std::f64::consts::LN_2;

use common::{BOTH, Random};
use infotheory::{Estimator, History, TransferWindow, transfer_entropy};

const LINKS: [[usize; 2]; 4] = [[0, 1], [1, 0], [1, 2], [3, 1]];
const RADICES: [u64; 4] = [2, 4, 3, u64::MAX];

/// Sensors that copy each other now and then; the last has many states, few of which come twice.
fn readings(seed: u64, n: usize) -> Vec<[u64; 4]> {
    let mut random = Random::new(seed);
    let mut now = [0; 4];
    let mut next = |_| {
        let [a, b, ..] = now;
        let copies = random.chance(0.7);
        let free = [random.below(2), random.below(4), random.below(3)];
        let large = if random.chance(0.5) { 7 } else { random.below(u64::MAX) };
        now = if copies {
            [b % 2, a + 2, (a + b) % 3, large]
        } else {
            [free[0], free[1], free[2], 7]
        };
        now
    };
    (0..n).map(&mut next).collect()
}

fn pushed(steps: usize, readings: &[[u64; 4]]) -> TransferWindow {
    let mut window = TransferWindow::new(steps, &RADICES, &LINKS).unwrap();
    readings.iter().for_each(|reading| window.push(reading).unwrap());
    window
}

fn all_values(window: &TransferWindow) -> Vec<u64> {
    let links = (0..LINKS.len()).flat_map(|link| {
        BOTH.map(|estimator| window.transfer_entropy(link, estimator).unwrap().nats())
    });
    let means = BOTH.map(|estimator| window.mean_transfer_entropy(estimator).nats());
    links.chain(means).chain([window.share_of_maximum()]).map(f64::to_bits).collect()
}

/// The batch measure counts all steps anew, with its own code.
#[test]
fn a_window_is_the_batch_measure_of_its_steps_at_every_step() {
    for steps in [1, 2, 3, 100] {
        let readings = readings(steps as u64, 600);
        let mut window = TransferWindow::new(steps, &RADICES, &LINKS).unwrap();
        for t in 0..readings.len() {
            window.push(&readings[t]).unwrap();
            assert_eq!(window.n_steps(), t.min(steps));
            let seen = &readings[t.saturating_sub(steps)..=t];
            for (link, [source, target]) in LINKS.into_iter().enumerate() {
                let series = |sensor: usize| seen.iter().map(|it| it[sensor]).collect::<Vec<_>>();
                for estimator in BOTH {
                    let found = window.transfer_entropy(link, estimator).unwrap();
                    if t == 0 {
                        assert_eq!(found.nats(), 0.0);
                        continue;
                    }
                    let history = History::default();
                    let (source, target) = (series(source), series(target));
                    let expected = transfer_entropy(&source, &target, history, estimator).unwrap();
                    let (found, expected) = (found.nats(), expected.nats());
                    // Plug-in values are of the same integers; corrections are sums in another order.
                    match estimator {
                        Estimator::PlugIn => assert_eq!(found.to_bits(), expected.to_bits()),
                        Estimator::MillerMadow => assert!((found - expected).abs() < 1e-15),
                    }
                }
            }
        }
    }
}

/// Six steps: x' of x and y. With x = 0: 1 of y = 1 (twice), 0 of y = 0 (once), 1 of y = 0 (once). With
/// x = 1: 0 twice, of either y, which says nothing. So T = 4/6 I, with I of the table [[1, 1], [0, 2]]:
/// 1/4 ln(1/4 / (1/2 1/4)) + 1/4 ln(1/4 / (1/2 3/4)) + 1/2 ln(1/2 / (1/2 3/4)).
#[test]
fn six_steps_by_hand() {
    let x = [0, 0, 1, 0, 1, 0, 1];
    let y = [0, 0, 0, 1, 1, 1, 0];
    let mut window = TransferWindow::new(6, &[2, 2], &[[1, 0]]).unwrap();
    for (&x, &y) in x.iter().zip(&y) {
        window.push(&[x, y]).unwrap();
    }
    let ln = |x: f64| x.ln();
    let of_zero = 0.25 * ln(2.0) + 0.25 * ln(2.0 / 3.0) + 0.5 * ln(4.0 / 3.0);
    let found = window.transfer_entropy(0, Estimator::PlugIn).unwrap().nats();
    // A few roundings of numbers below 1.
    assert!((found - 4.0 / 6.0 * of_zero).abs() < 1e-15, "{found}");
}

/// Fair coins, and a copy a step later: ln 2 one way, nothing the other way, both up to what 100,000
/// coins scatter: the bias is 2 / 2n = 1e-5, with a deviation of as much.
#[test]
fn a_copy_is_told_all_and_independent_coins_nothing() {
    let n = 100_000;
    let mut random = Random::new(3);
    let (mut window, mut last) =
        (TransferWindow::new(n, &[2; 3], &[[0, 1], [1, 0], [2, 0]]).unwrap(), 0);
    for _ in 0..=n {
        let coin = random.below(2);
        window.push(&[coin, last, random.below(2)]).unwrap();
        last = coin;
    }
    let found = [0, 1, 2].map(|it| window.transfer_entropy(it, Estimator::PlugIn).unwrap().nats());
    assert!((found[0] - LN_2).abs() < 1e-4, "{found:?}");
    assert!(found[1] < 1e-4 && found[2] < 1e-4, "{found:?}");
    assert!((window.share_of_maximum() - 1.0 / 3.0).abs() < 1e-4);
}

#[test]
fn a_restored_window_goes_on_with_the_same_bits_and_nothing_drifts() {
    let readings = readings(9, 5000);
    let mut old = pushed(100, &readings[..4000]);
    let mut state = Vec::new();
    old.save(&mut state);
    let mut restored = pushed(100, &readings[..77]);
    restored.restore(&state).unwrap();
    let mut young = pushed(100, &readings[3899..4000]);
    for reading in &readings[4000..] {
        let windows = [&mut old, &mut restored, &mut young].map(|window| {
            window.push(reading).unwrap();
            all_values(window)
        });
        assert!(windows[0] == windows[1] && windows[0] == windows[2]);
    }
}

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let message = |steps, radices: &[u64], links: &[[usize; 2]]| {
        TransferWindow::new(steps, radices, links).unwrap_err().to_string()
    };
    assert!(message(0, &[2, 2], &[[0, 1]]).ends_with("steps must be 1 to 1048576, got 0"));
    assert!(message(9, &[2, 0], &[[0, 1]]).contains("the radix of sensor 1 must be at least 1"));
    assert!(message(9, &[2, 2], &[]).contains("the number of links must be at least 1"));
    for link in [[0, 2], [1, 1]] {
        let expected = format!("two different sensors below 2, got {} and {}", link[0], link[1]);
        assert!(message(9, &[2, 2], &[[0, 1], link]).ends_with(&expected));
    }

    let mut window = pushed(10, &readings(1, 30));
    let before = all_values(&window);
    let mut state = Vec::new();
    window.save(&mut state);
    assert!(
        window.push(&[0, 4, 0, 0]).unwrap_err().to_string().contains("sensor 1 must be below 4")
    );
    assert!(window.push(&[0; 3]).is_err());
    assert!(window.transfer_entropy(4, Estimator::PlugIn).is_err());
    let mut refused = |change: &dyn Fn(&mut Vec<u64>)| {
        let mut bad = state.clone();
        change(&mut bad);
        assert!(window.restore(&bad).is_err());
        assert_eq!(all_values(&window), before);
    };
    refused(&|it| it.clear());
    (0..4).for_each(|place| refused(&|it| it[place] += 1));
    refused(&|it| it[3] = u64::MAX);
    refused(&|it| it[5] = 4);
    refused(&|it| it.truncate(20));
}

#[test]
fn a_step_allocates_nothing() {
    let mut window = pushed(100, &readings(2, 10));
    let readings = readings(3, 20_000);
    let counted = allocation_counter::measure(|| {
        for reading in &readings {
            window.push(reading).unwrap();
            assert!(window.share_of_maximum().is_finite());
        }
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
}

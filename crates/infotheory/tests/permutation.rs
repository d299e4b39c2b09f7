//! Permutation tests: how often they cry wolf, and that they see one.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use Estimator::{MillerMadow, PlugIn};
use common::Random;
use infotheory::{Estimator, History, PermutationTest, mutual_information};

fn test(shuffles: u32, seed: u64) -> PermutationTest {
    PermutationTest { shuffles, seed, estimator: PlugIn }
}

/// Without dependence, p <= 0.05 in at most a twentieth of cases: of 400, 20 +- 4.4. Ties make it
/// rarer, but not by much with 60 samples of 4 x 4 states. Outside of 5 to 38 is beyond four
/// standard deviations below and above if p is uniform: a false alarm in some 10^-4 of seeds.
#[test]
fn false_alarms_are_as_rare_as_the_p_value_says() {
    let mut random = Random::new(1);
    let mut alarms = [0; 3];
    for seed in 0..400 {
        let (x, y) = (random.symbols(4, 60), random.symbols(4, 60));
        let mutual = test(19, seed).mutual_information(&x, &y).unwrap();
        alarms[0] += u32::from(mutual.p_value <= 0.05);

        // Both depend on z, and on each other through nothing else.
        let z = random.symbols(2, 60);
        let tied = |free: &[u64], random: &mut Random| -> Vec<u64> {
            free.iter().zip(&z).map(|(&s, &z)| if random.chance(0.5) { z } else { s }).collect()
        };
        let (x, y) = (tied(&x, &mut random), tied(&y, &mut random));
        let conditional = test(19, seed).conditional_mutual_information(&x, &y, &z).unwrap();
        alarms[1] += u32::from(conditional.p_value <= 0.05);

        let transfer = test(19, seed).transfer_entropy(&x, &z, History::default()).unwrap();
        alarms[2] += u32::from(transfer.p_value <= 0.05);
    }
    assert!(alarms.iter().all(|count| (5..=38).contains(count)), "{alarms:?}");
}

/// The condition explains everything: a test that forgets it would see dependence every time.
#[test]
fn a_common_cause_is_not_mistaken_for_dependence() {
    let mut random = Random::new(2);
    let z = random.symbols(3, 300);
    let noisy = |random: &mut Random| -> Vec<u64> {
        z.iter().map(|&z| if random.chance(0.1) { random.below(3) } else { z }).collect()
    };
    let (x, y) = (noisy(&mut random), noisy(&mut random));
    let smallest = 1.0 / 200.0;
    assert_eq!(test(199, 3).mutual_information(&x, &y).unwrap().p_value, smallest);
    let conditional = test(199, 3).conditional_mutual_information(&x, &y, &z).unwrap();
    assert!(conditional.p_value > 0.05, "{conditional:?}");
}

#[test]
fn a_copy_is_seen_in_one_direction() {
    let mut random = Random::new(4);
    let source = random.symbols(2, 200);
    let mut target = vec![0; 200];
    for t in 1..200 {
        target[t] = if random.chance(0.2) { random.below(2) } else { source[t - 1] };
    }
    let history = History::default();
    let there = test(199, 5).transfer_entropy(&source, &target, history).unwrap();
    let back = test(199, 5).transfer_entropy(&target, &source, history).unwrap();
    assert_eq!(there.p_value, 1.0 / 200.0);
    assert!(back.p_value > 0.05, "{back:?}");
}

/// The mean over shuffles of independent samples is the bias: (4 - 1)(4 - 1) / 2n in nats to first
/// order, 0.0045 with n = 1000, and next to none once corrected. A shuffle's value scatters by
/// about 0.002 (chi-square of 9 degrees over 2n), the mean of 400 by 0.0001; second order is of
/// that size too.
#[test]
fn shuffles_show_the_bias() {
    let mut random = Random::new(6);
    let (x, y) = (random.symbols(4, 1000), random.symbols(4, 1000));
    let plug_in = test(400, 7).mutual_information(&x, &y).unwrap();
    assert!((plug_in.shuffled_mean.nats() - 0.0045).abs() < 0.0006, "{plug_in:?}");
    assert!((plug_in.shuffled_deviation.nats() - 0.0021).abs() < 0.0005, "{plug_in:?}");
    let corrected = PermutationTest { estimator: MillerMadow, ..test(400, 7) };
    let corrected = corrected.mutual_information(&x, &y).unwrap();
    assert!(corrected.shuffled_mean.nats().abs() < 0.0006, "{corrected:?}");
}

/// Tests with so few samples that all orders can be counted.
#[test]
fn a_test_small_enough_to_count() {
    let (x, y) = ([0, 1, 2], [0, 1, 2]);
    let all_alike = test(50, 8).mutual_information(&x, &y).unwrap();
    assert_eq!(all_alike.p_value, 1.0, "every order of different symbols is as informative");
    assert_eq!(all_alike.shuffled_mean, all_alike.observed);
    assert_eq!(all_alike.shuffled_deviation.nats(), 0.0);

    // Of the 6 ways to place the ones of x, 2 are y or its opposite: p is near 1/3. With 3,000
    // shuffles it scatters by 0.0086; five of those are exceeded in less than 10^-6 of seeds.
    let (x, y) = ([0, 0, 1, 1], [0, 0, 1, 1]);
    let p = test(3000, 9).mutual_information(&x, &y).unwrap().p_value;
    assert!((p - 1.0 / 3.0).abs() < 0.043, "{p}");
}

#[test]
fn the_seed_alone_decides() {
    let mut random = Random::new(10);
    let (x, y) = (random.symbols(3, 50), random.symbols(3, 50));
    let of = |seed| test(20, seed).mutual_information(&x, &y).unwrap();
    assert_eq!(of(1), of(1));
    assert_ne!(of(1).shuffled_mean, of(2).shuffled_mean);
    assert_eq!(of(1).observed, mutual_information(&x, &y, PlugIn).unwrap());
}

#[test]
fn no_shuffles_and_no_samples_are_refused() {
    let error = test(0, 1).mutual_information(&[1], &[1]).unwrap_err().to_string();
    assert_eq!(error, "PermutationTest::mutual_information: shuffles must be at least 1, got 0");
    let none: [u8; 0] = [];
    let error = test(1, 1).mutual_information(&none, &none).unwrap_err().to_string();
    assert_eq!(
        error,
        "PermutationTest::mutual_information: the length of x must be 1 to 2^32 - 1, got 0"
    );
    assert!(test(1, 1).conditional_mutual_information(&[1], &[1, 2], &[1]).is_err());
    assert!(test(1, 1).transfer_entropy(&[1], &[1], History::default()).is_err());
}

//! Measures of tables worked by hand, of published examples, and of what they refuse.
#![allow(clippy::unwrap_used, missing_docs)]

use Estimator::{MillerMadow, PlugIn};
use infotheory::{
    Error, Estimator, History, Information, MixedRadix, conditional_entropy,
    conditional_mutual_information, entropy, entropy_of_counts, joint_entropy, multi_information,
    mutual_information, transfer_entropy,
};

const LN_2: f64 = std::f64::consts::LN_2;

/// Exact values here are sums of a few logs below 10: 1e-14 is some fifty roundings.
fn assert_nats(found: Result<Information, Error>, expected: f64) {
    let nats = found.unwrap().nats();
    assert!((nats - expected).abs() < 1e-14, "{nats} where {expected} was due");
}

fn assert_bits(found: Result<Information, Error>, expected: f64, digits: i32) {
    let bits = found.unwrap().bits();
    let tolerance = 0.5 * 10.0_f64.powi(-digits) * 1.001;
    assert!((bits - expected).abs() < tolerance, "{bits} where {expected} was due");
}

/// Rows of data with given counts of (x, y).
fn table(counts: &[&[usize]]) -> (Vec<usize>, Vec<usize>) {
    let mut rows = (Vec::new(), Vec::new());
    for (y, row) in counts.iter().enumerate() {
        for (x, &count) in row.iter().enumerate() {
            rows.0.extend(vec![x; count]);
            rows.1.extend(vec![y; count]);
        }
    }
    rows
}

#[test]
fn a_biased_coin() {
    let flips = [0_u8, 0, 0, 0, 0, 0, 0, 1, 1, 1];
    assert_bits(entropy(&flips, PlugIn), 0.881_290_899_2, 10);
    assert_eq!(entropy_of_counts(&[7, 3], PlugIn), entropy(&flips, PlugIn));
    assert_eq!(entropy_of_counts(&[0, 3, 0, 7], MillerMadow), entropy(&flips, MillerMadow));
    let plug_in = entropy(&flips, PlugIn).unwrap().nats();
    assert_nats(entropy(&flips, MillerMadow), plug_in + 1.0 / 20.0);
}

#[test]
fn mutual_information_of_short_columns() {
    let x = [2, 4, 4, 3, 1, 3, 1, 4, 4, 2];
    let y = [4, 4, 2, 4, 2, 1, 3, 4, 3, 2];
    assert_bits(mutual_information(&x, &y, PlugIn), 0.646_439, 6);
    // 4 states of each, 9 pairs.
    let plug_in = mutual_information(&x, &y, PlugIn).unwrap().nats();
    assert_nats(mutual_information(&x, &y, MillerMadow), plug_in + (4.0 + 4.0 - 9.0 - 1.0) / 20.0);

    let ladder = [1, 2, 3, 4, 5];
    assert_bits(mutual_information(&ladder, &ladder, PlugIn), 2.321_928, 6);
}

/// T. Cover and J. Thomas, Elements of Information Theory, example 2.2.1 and 2.4: probabilities in
/// 32nds, all results are eighths of bits.
#[test]
fn the_table_of_cover_and_thomas() {
    let (x, y) = table(&[&[4, 2, 1, 1], &[2, 4, 1, 1], &[2, 2, 2, 2], &[8, 0, 0, 0]]);
    for (found, bits) in [
        (entropy(&x, PlugIn), 7.0 / 4.0),
        (entropy(&y, PlugIn), 2.0),
        (joint_entropy(&[&x, &y], PlugIn), 27.0 / 8.0),
        (conditional_entropy(&x, &y, PlugIn), 11.0 / 8.0),
        (conditional_entropy(&y, &x, PlugIn), 13.0 / 8.0),
        (mutual_information(&x, &y, PlugIn), 3.0 / 8.0),
        (multi_information(&[&x, &y], PlugIn), 3.0 / 8.0),
    ] {
        assert_nats(found, bits * LN_2);
    }
    // n = 32; 4 and 4 states, 13 pairs.
    for (found, plug_in, correction) in [
        (joint_entropy(&[&x, &y], MillerMadow), 27.0 / 8.0, 12.0 / 64.0),
        (conditional_entropy(&x, &y, MillerMadow), 11.0 / 8.0, (13.0 - 4.0) / 64.0),
        (mutual_information(&x, &y, MillerMadow), 3.0 / 8.0, (4.0 + 4.0 - 13.0 - 1.0) / 64.0),
    ] {
        assert_nats(found, plug_in * LN_2 + correction);
    }
}

/// Z = X xor Y: nothing in any two, one bit in three.
#[test]
fn exclusive_or() {
    let (x, y, z) = ([0, 0, 1, 1], [0, 1, 0, 1], [0, 1, 1, 0]);
    assert_nats(mutual_information(&x, &y, PlugIn), 0.0);
    assert_nats(mutual_information(&x, &z, PlugIn), 0.0);
    assert_nats(conditional_mutual_information(&x, &y, &z, PlugIn), LN_2);
    assert_nats(multi_information(&[&x, &y, &z], PlugIn), LN_2);
    // 4 states of xz, yz and xyz, 2 of each alone, n = 4.
    let correction = (4.0 + 4.0 - 4.0 - 2.0) / 8.0;
    assert_nats(conditional_mutual_information(&x, &y, &z, MillerMadow), LN_2 + correction);
    let correction = (2.0 + 2.0 + 2.0 - 4.0 - 2.0) / 8.0;
    assert_nats(multi_information(&[&x, &y, &z], MillerMadow), LN_2 + correction);
}

/// Examples of `transfer_entropy` in the manual of the R package rinform 1.0.2 (D. Moore and
/// others, *Inform: efficient information-theoretic analysis of collective behaviors*, 2018), in
/// bits, with the source's history of 1.
#[test]
fn transfer_entropies_published_with_inform() {
    let xs = [0, 0, 1, 1, 1, 1, 0, 0, 0];
    let ys = [0, 1, 1, 1, 1, 0, 0, 0, 1];
    let of = |source: &[i32], target: &[i32], k| {
        transfer_entropy(source, target, History { target: k, source: 1 }, PlugIn)
    };
    assert_bits(of(&ys, &xs, 1), 0.811_278_1, 7);
    assert_bits(of(&ys, &xs, 2), 0.679_269_6, 7);
    assert_bits(of(&xs, &ys, 1), 0.216_917_2, 7);
    assert_bits(of(&xs, &ys, 2), 0.0, 7);
}

/// Every pair of the source's and the target's last symbols comes equally often, and the target's
/// next is the source's last: one bit, and nothing back.
#[test]
fn a_copy_transfers_all_of_its_entropy() {
    // A de Bruijn sequence of order 3, once around and two more.
    let source = [0, 0, 0, 1, 0, 1, 1, 1, 0, 0];
    let target = [1, 0, 0, 0, 1, 0, 1, 1, 1, 0];
    let history = History::default();
    // The target's first symbol isn't a copy, but it's only past: 9 samples.
    let bits = transfer_entropy(&source, &target, history, PlugIn).unwrap().bits();
    let entropy = conditional_entropy(&target[1..], &target[..9], PlugIn).unwrap().bits();
    assert!((bits - entropy).abs() < 1e-14, "{bits}, {entropy}");
    assert!(bits > 0.9, "{bits}");

    // Of two steps ago: the last two symbols of the source are needed, the last alone won't do.
    let late: Vec<i32> = [0, 1].into_iter().chain(source[..8].iter().copied()).collect();
    let both = History { target: 1, source: 2 };
    let left = conditional_entropy(&late[2..], &late[1..9], PlugIn).unwrap().nats();
    assert_nats(transfer_entropy(&source, &late, both, PlugIn), left);
}

/// With the wrong radix, 2 for x in place of 3 for y, the states (0, 2) and (1, 0) merge. A
/// published library did, and its joint entropies were too low.
#[test]
fn joint_states_of_unequal_radices_stay_apart() {
    let (x, y) = table(&[&[5, 5], &[5, 5], &[5, 5]]);
    assert_nats(joint_entropy(&[&x, &y], PlugIn), 6.0_f64.ln());
    assert_nats(joint_entropy(&[&y, &x], PlugIn), 6.0_f64.ln());

    let codes = |radices: [u64; 2]| -> Vec<u64> {
        let encoder = MixedRadix::new(&radices).unwrap();
        let code = |(&x, &y): (&usize, &usize)| encoder.encode(&[x as u64, y as u64]).unwrap();
        x.iter().zip(&y).map(code).collect()
    };
    assert_nats(entropy(&codes([2, 3]), PlugIn), 6.0_f64.ln());
    assert_nats(entropy(&codes([7, 5]), PlugIn), 6.0_f64.ln());

    let merged: Vec<usize> = x.iter().zip(&y).map(|(&x, &y)| 2 * x + y).collect();
    assert!(
        entropy(&merged, PlugIn).unwrap().nats() < 6.0_f64.ln() - 0.2,
        "the test shows nothing"
    );
}

#[test]
fn forty_columns_of_sixty_four_bits_stay_apart() {
    let row = |i: u64| -> Vec<u64> { (0..40).map(|j| u64::MAX - (i >> (j % 6) & 1)).collect() };
    let rows: Vec<Vec<u64>> = (0..64).map(row).collect();
    let columns: Vec<Vec<u64>> = (0..40).map(|j| rows.iter().map(|row| row[j]).collect()).collect();
    let columns: Vec<&[u64]> = columns.iter().map(Vec::as_slice).collect();
    assert_nats(joint_entropy(&columns, PlugIn), 64.0_f64.ln());
}

/// Products of margins: what should be 0 comes out as a rounding above it, never below.
#[test]
fn independent_variables_share_nothing() {
    for (a, b, c, d) in (0..625).map(|i| (i % 5 + 1, i / 5 % 5 + 1, i / 25 % 5 + 1, i / 125 + 1)) {
        let (x, y) = table(&[&[a * c, b * c], &[a * d, b * d]]);
        let nats = mutual_information(&x, &y, PlugIn).unwrap().nats();
        assert!((0.0..1e-15).contains(&nats), "{nats}");
    }
}

#[test]
fn one_sample_and_one_state_hold_nothing() {
    for estimator in [PlugIn, MillerMadow] {
        for n in [1, 100] {
            let same = vec!['a'; n];
            assert_eq!(entropy(&same, estimator).unwrap().nats(), 0.0);
            assert_eq!(mutual_information(&same, &same, estimator).unwrap().nats(), 0.0);
        }
    }
}

#[test]
fn a_count_of_nearly_two_to_the_sixty_four_is_fine() {
    let half = u64::MAX / 2;
    assert_nats(entropy_of_counts(&[half, half], PlugIn), LN_2);
    assert_eq!(entropy_of_counts(&[u64::MAX], PlugIn).unwrap().nats(), 0.0);
}

#[test]
fn what_has_no_distribution_is_refused() {
    let none: [u8; 0] = [];
    let history = |target, source| History { target, source };
    let length = "the length of";
    for (found, expected) in [
        (entropy(&none, PlugIn), format!("entropy: {length} x must be 1 to 2^32 - 1, got 0")),
        (
            joint_entropy::<u8>(&[], PlugIn),
            "joint_entropy: the number of columns must be at least 1, got 0".into(),
        ),
        (
            joint_entropy(&[&[1, 2], &[1]], PlugIn),
            format!("joint_entropy: {length} column 1 must be 2, got 1"),
        ),
        (
            multi_information(&[&none[..], &none[..]], PlugIn),
            format!("multi_information: {length} column 0 must be 1 to 2^32 - 1, got 0"),
        ),
        (
            conditional_entropy(&[1, 2], &[1], PlugIn),
            format!("conditional_entropy: {length} y must be 2, got 1"),
        ),
        (
            mutual_information(&[1], &[1, 2], PlugIn),
            format!("mutual_information: {length} y must be 1, got 2"),
        ),
        (
            conditional_mutual_information(&[1], &[1], &none, PlugIn),
            format!("conditional_mutual_information: {length} z must be 1, got 0"),
        ),
        (
            entropy_of_counts(&[0, 0], PlugIn),
            "entropy_of_counts: the sum of counts must be 1 to 2^64 - 1, got 0".into(),
        ),
        (
            entropy_of_counts(&[u64::MAX, 1], PlugIn),
            "entropy_of_counts: the sum of counts must be 1 to 2^64 - 1, got more".into(),
        ),
        (
            transfer_entropy(&[1, 2], &[1], history(1, 1), PlugIn),
            format!("transfer_entropy: {length} target must be 2, got 1"),
        ),
        (
            transfer_entropy(&[1, 2], &[1, 2], history(1, 0), PlugIn),
            "transfer_entropy: history.source must be at least 1, got 0".into(),
        ),
        (
            transfer_entropy(&[1, 2], &[1, 2], history(2, 1), PlugIn),
            format!(
                "transfer_entropy: {length} target must be more than 2, the longer history, got 2"
            ),
        ),
    ] {
        assert_eq!(found.unwrap_err().to_string(), expected);
    }
}

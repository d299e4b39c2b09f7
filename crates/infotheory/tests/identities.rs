//! What holds for any data: the laws of entropies, as properties of random samples.
//!
//! Both sides of a law round some ten times on numbers below 10, so 1e-13 is generous. Where the
//! very same integers are summed, results are equal to the bit.
#![allow(clippy::unwrap_used, missing_docs)]

use Estimator::{MillerMadow, PlugIn};
use infotheory::{
    Estimator, History, conditional_entropy, conditional_mutual_information, entropy,
    joint_entropy, multi_information, mutual_information, transfer_entropy,
};
use proptest::prelude::*;

const ROUNDING: f64 = 1e-13;

fn rows() -> impl Strategy<Value = Vec<[u8; 3]>> {
    // Few states, so that they repeat, in columns of unequal sizes.
    prop::collection::vec((0_u8..2, 0_u8..3, 0_u8..5).prop_map(<[u8; 3]>::from), 1..200)
}

fn columns(rows: &[[u8; 3]]) -> [Vec<u8>; 3] {
    [0, 1, 2].map(|i| rows.iter().map(|row| row[i]).collect())
}

fn tuples(a: &[u8], b: &[u8]) -> Vec<(u8, u8)> {
    a.iter().copied().zip(b.iter().copied()).collect()
}

fn estimators() -> impl Strategy<Value = Estimator> {
    prop_oneof![Just(PlugIn), Just(MillerMadow)]
}

proptest! {
    #[test]
    fn mutual_information_is_symmetric_to_the_bit(rows in rows(), estimator in estimators()) {
        let [x, y, z] = columns(&rows);
        prop_assert_eq!(
            mutual_information(&x, &y, estimator)?,
            mutual_information(&y, &x, estimator)?
        );
        prop_assert_eq!(
            conditional_mutual_information(&x, &y, &z, estimator)?,
            conditional_mutual_information(&y, &x, &z, estimator)?
        );
        prop_assert_eq!(
            multi_information(&[&x, &y, &z], estimator)?,
            multi_information(&[&z, &x, &y], estimator)?
        );
    }

    #[test]
    fn names_and_order_of_samples_do_not_matter_to_the_bit(
        rows in rows(),
        estimator in estimators(),
        names in Just((0_u64..5).map(|i| i * 0x3333_3333_3333_3333).collect::<Vec<_>>())
            .prop_shuffle(),
        turn: prop::sample::Index,
    ) {
        let [x, y, z] = columns(&rows);
        let renamed = |column: &[u8]| -> Vec<u64> {
            let mut column: Vec<u64> = column.iter().map(|&s| names[usize::from(s)]).collect();
            column.rotate_left(turn.index(rows.len()));
            column
        };
        let [x2, y2, z2] = [&x, &y, &z].map(|column| renamed(column));
        prop_assert_eq!(entropy(&z, estimator)?, entropy(&z2, estimator)?);
        prop_assert_eq!(
            mutual_information(&y, &z, estimator)?,
            mutual_information(&y2, &z2, estimator)?
        );
        prop_assert_eq!(
            conditional_mutual_information(&x, &y, &z, estimator)?,
            conditional_mutual_information(&x2, &y2, &z2, estimator)?
        );
    }

    #[test]
    fn information_is_between_zero_and_either_entropy(rows in rows()) {
        let [x, y, z] = columns(&rows);
        let mutual = mutual_information(&y, &z, PlugIn)?;
        let least = entropy(&y, PlugIn)?.nats().min(entropy(&z, PlugIn)?.nats());
        prop_assert!(mutual.nats() >= 0.0);
        prop_assert!(mutual.nats() <= least + ROUNDING);
        let conditional = conditional_mutual_information(&y, &z, &x, PlugIn)?.nats();
        prop_assert!(conditional >= 0.0);
        prop_assert!(conditional <= conditional_entropy(&y, &x, PlugIn)?.nats() + ROUNDING);
        prop_assert!(multi_information(&[&x, &y, &z], PlugIn)?.nats() >= 0.0);
    }

    #[test]
    fn entropy_is_between_zero_and_the_log_of_the_number_of_states(rows in rows()) {
        let [_, _, z] = columns(&rows);
        let mut states = z.clone();
        states.sort_unstable();
        states.dedup();
        let nats = entropy(&z, PlugIn)?.nats();
        prop_assert!(nats >= 0.0 && nats <= (states.len() as f64).ln() + ROUNDING);
    }

    #[test]
    fn chain_rules_hold(rows in rows(), estimator in estimators()) {
        let [x, y, z] = columns(&rows);
        let nats = |found: Result<infotheory::Information, _>| found.unwrap().nats();
        let h_xy = nats(joint_entropy(&[&x, &y], estimator));
        let h = nats(entropy(&x, estimator)) + nats(conditional_entropy(&y, &x, estimator));
        prop_assert!((h_xy - h).abs() < ROUNDING, "H(X,Y) = H(X) + H(Y|X)");

        let i_joint = nats(mutual_information(&x, &tuples(&y, &z), estimator));
        let i = nats(mutual_information(&x, &z, estimator))
            + nats(conditional_mutual_information(&x, &y, &z, estimator));
        prop_assert!((i_joint - i).abs() < ROUNDING, "I(X;Y,Z) = I(X;Z) + I(X;Y|Z)");

        let all = nats(multi_information(&[&x, &y, &z], estimator));
        let parts = nats(mutual_information(&x, &y, estimator))
            + nats(mutual_information(&tuples(&x, &y), &z, estimator));
        prop_assert!((all - parts).abs() < ROUNDING, "M(X,Y,Z) = I(X;Y) + I(X,Y;Z)");
    }

    #[test]
    fn processing_makes_no_information(
        rows in rows(),
        map in prop::array::uniform5(0_u8..3),
    ) {
        let [_, y, z] = columns(&rows);
        let processed: Vec<u8> = z.iter().map(|&s| map[usize::from(s)]).collect();
        let (raw, less) =
            (mutual_information(&y, &z, PlugIn)?, mutual_information(&y, &processed, PlugIn)?);
        prop_assert!(less.nats() <= raw.nats() + ROUNDING);
    }

    #[test]
    fn a_variable_holds_its_entropy_about_itself(rows in rows(), estimator in estimators()) {
        let [x, _, z] = columns(&rows);
        prop_assert_eq!(mutual_information(&z, &z, estimator)?, entropy(&z, estimator)?);
        prop_assert_eq!(conditional_entropy(&z, &z, estimator)?.nats(), 0.0);
        let constant = vec![(); x.len()];
        prop_assert_eq!(mutual_information(&x, &constant, estimator)?.nats(), 0.0);
        prop_assert_eq!(
            conditional_mutual_information(&x, &z, &constant, estimator)?,
            mutual_information(&x, &z, estimator)?
        );
    }

    #[test]
    fn transfer_entropy_is_a_conditional_mutual_information_to_the_bit(
        rows in prop::collection::vec((0_u8..2, 0_u8..3), 4..200),
        estimator in estimators(),
        k in 0_usize..4,
        l in 1_usize..4,
    ) {
        let source: Vec<u8> = rows.iter().map(|row| row.0).collect();
        let target: Vec<u8> = rows.iter().map(|row| row.1).collect();
        let skipped = k.max(l);
        // Pasts as arrays, padded with a constant.
        let past = |series: &[u8], t: usize, length: usize| -> [u8; 3] {
            [1, 2, 3].map(|lag| if lag <= length { series[t - lag] } else { 0 })
        };
        let times = skipped..target.len();
        let x: Vec<[u8; 3]> = times.clone().map(|t| past(&source, t, l)).collect();
        let z: Vec<[u8; 3]> = times.map(|t| past(&target, t, k)).collect();
        prop_assert_eq!(
            transfer_entropy(&source, &target, History { target: k, source: l }, estimator)?,
            conditional_mutual_information(&x, &target[skipped..], &z, estimator)?
        );
    }
}

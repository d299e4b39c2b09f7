//! The parameters of centred units are another way to write the same policies.
#![allow(clippy::unwrap_used, missing_docs)]

#[allow(unreachable_pub, dead_code)]
mod common;

use std::collections::BTreeSet;

use common::{run, svenja, variants};
use policy::{Coding, KindSettings, Policy, PolicySettings, Start};

/// A policy for Svenja in binary and in centred coding. With the same start, they are different ones.
fn both(kind: &KindSettings) -> [Box<dyn Policy>; 2] {
    [Coding::Binary, Coding::Centred].map(|coding| {
        let start = Start::Random(0.5);
        let settings = PolicySettings { kind: kind.clone(), memory: 0, coding, start };
        settings.build(&svenja(), 1).unwrap()
    })
}

/// What binary units need for what centred ones have.
fn binary(policies: &[Box<dyn Policy>; 2]) -> Vec<f64> {
    policies[0].read_safetensors(&policies[1].to_safetensors().unwrap()).unwrap()
}

#[test]
fn a_policy_acts_the_same_in_both() {
    for kind in variants(3) {
        let mut policies = both(&kind);
        assert_eq!(policies[0].parameters(), policies[1].parameters());
        let parameters = binary(&policies);
        policies[0].set_parameters(&parameters).unwrap();
        let [mut one, mut other] = policies;
        // Bits are drawn by the same random numbers; a sum of a hundred numbers of about 1 rounds.
        for ((y, score), (other_y, other_score)) in
            run(&mut *one, 0..30).into_iter().zip(run(&mut *other, 0..30))
        {
            assert_eq!(y, other_y, "{kind:?}");
            let number = |bits: &[u64], i: usize| f64::from_bits(bits[i]);
            for &policy::Link { weight, biases } in &one.links() {
                let of_biases: f64 = biases.iter().flatten().map(|&it| number(&score, it)).sum();
                let expected = number(&score, weight) - of_biases / 2.0;
                assert!((number(&other_score, weight) - expected).abs() < 1e-12, "{kind:?}");
            }
        }
    }
}

/// A small step of the centred parameters changes log p by score times step, which is what it does to
/// the binary ones: the map between them is linear, and files tell it.
#[test]
fn the_score_goes_with_the_parameters() {
    for kind in variants(3) {
        let mut policies = both(&kind);
        let before = binary(&policies);
        policies[0].set_parameters(&before).unwrap();
        let start = policies[1].parameters().to_vec();
        let step: Vec<f64> = (0..start.len()).map(|i| ((i * 7919) % 13) as f64 - 6.0).collect();
        let moved: Vec<f64> = start.iter().zip(&step).map(|(a, b)| a + b).collect();
        policies[1].set_parameters(&moved).unwrap();
        let after = binary(&policies);
        let binary_step: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        policies[1].set_parameters(&start).unwrap();

        let [mut one, mut other] = policies;
        let ((_, score), (_, centred)) =
            (run(&mut *one, 0..1).remove(0), run(&mut *other, 0..1).remove(0));
        let dot = |score: &[u64], step: &[f64]| {
            score.iter().zip(step).map(|(bits, step)| f64::from_bits(*bits) * step).sum::<f64>()
        };
        let (expected, found) = (dot(&score, &binary_step), dot(&centred, &step));
        // Sums of some thousand products below 100.
        assert!((expected - found).abs() < 1e-8, "{kind:?}: {expected} {found}");
    }
}

/// Each weight once, and what isn't a weight is a bias.
#[test]
fn every_parameter_is_a_weight_or_a_bias() {
    for kind in variants(3) {
        let [policy, _] = both(&kind);
        let links = policy.links();
        let weights: BTreeSet<usize> = links.iter().map(|link| link.weight).collect();
        let biases: BTreeSet<usize> = links.iter().flat_map(|link| link.biases).flatten().collect();
        assert_eq!(weights.len(), links.len(), "{kind:?}");
        assert!(weights.is_disjoint(&biases), "{kind:?}");
        assert_eq!(weights.len() + biases.len(), policy.parameters().len(), "{kind:?}");
    }
}

//! What can't be used is refused, with its name, what it should be and what it was.
#![allow(clippy::unwrap_used, missing_docs)]

use crbm::{ChainRng, Layout, Mask, Policy, Sampling};

fn policy() -> Policy {
    let layout = Layout::full(3, 4, 2).unwrap();
    let parameters = layout.random_parameters(1.0, 1, "start").unwrap();
    Policy::new(layout, Sampling { gibbs_updates: 2, samples: 20 }, &parameters).unwrap()
}

#[test]
fn layouts_that_make_no_machine() {
    let message = Layout::full(3, 4, 0).unwrap_err().to_string();
    assert_eq!(message, "Layout::new: number of outputs must be at least 1, got 0");
    let message = Layout::new(Mask::full(3, 1).unwrap(), Mask::full(4, 1).unwrap()).unwrap_err();
    let expected = "Layout::new: rows of the outputs' mask must be 3, as with the inputs, got 4";
    assert_eq!(message.to_string(), expected);
}

#[test]
fn numbers_that_are_none() {
    let mut policy = policy();
    let before = format!("{policy:?}");
    let mut parameters = vec![0.0; 26];
    for value in [f64::NAN, f64::INFINITY, -1.1e9] {
        parameters[25] = value;
        let message = policy.set_parameters(&parameters).unwrap_err().to_string();
        let expected = "Policy::set_parameters: parameter 25, b[1] must be in -1e9..=1e9, got ";
        assert_eq!(message, format!("{expected}{value}"));
    }
    let message = policy.set_parameters(&[0.0; 25]).unwrap_err().to_string();
    assert_eq!(message, "Policy::set_parameters: length of parameters must be 26, got 25");
    assert_eq!(format!("{policy:?}"), before, "the policy is as before");
}

#[test]
fn no_samples() {
    let layout = Layout::full(1, 1, 1).unwrap();
    let sampling = Sampling { gibbs_updates: 1, samples: 0 };
    let message = Policy::new(layout, sampling, &[0.0; 4]).unwrap_err().to_string();
    assert_eq!(message, "Policy::new: samples must be in 1..=1048576, got 0");
}

#[test]
fn slices_of_other_lengths() {
    let mut policy = policy();
    let mut rng = policy.rng(1, "policy");
    let before = rng.clone();
    let mut call = |x: usize, y: usize, score: usize| {
        let (x, mut y, mut score) = (vec![true; x], vec![true; y], vec![0.0; score]);
        policy.act_and_score(&x, &mut rng, &mut y, &mut score).unwrap_err().to_string()
    };
    assert_eq!(call(4, 2, 26), "Policy::act_and_score: length of x must be 3, got 4");
    assert_eq!(call(3, 1, 26), "Policy::act_and_score: length of y must be 2, got 1");
    assert_eq!(call(3, 2, 27), "Policy::act_and_score: length of score must be 26, got 27");
    assert_eq!(
        policy.act(&[true; 3], &mut rng, &mut [true; 4]).unwrap_err().to_string(),
        "Policy::act: length of y must be 2, got 4"
    );
    for length in [3, 44] {
        assert_eq!(
            policy.sample(&[true; 3], &mut rng, &mut vec![true; length]).unwrap_err().to_string(),
            format!("Policy::sample: length of y must be a multiple of 2 up to 42, got {length}")
        );
    }
    assert!(policy.score(&[true; 3], &[true], &mut rng, &mut [0.0; 26]).is_err());
    assert!(rng == before, "nothing was drawn");
    policy.sample(&[true; 3], &mut rng, &mut []).unwrap();
    assert!(rng == before, "no samples take no random numbers");
}

#[test]
fn streams_of_too_few_chains() {
    let mut policy = policy();
    let mut rng = ChainRng::new(1, "policy", 16);
    let message = policy.act_and_score(&[true; 3], &mut rng, &mut [true; 2], &mut [0.0; 26]);
    assert_eq!(
        message.unwrap_err().to_string(),
        "Policy::act_and_score: chains of rng must be at least 21, got 16"
    );
    policy.act(&[true; 3], &mut rng, &mut [true; 2]).unwrap();
}

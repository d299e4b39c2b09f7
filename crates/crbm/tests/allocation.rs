//! No call but the constructors allocates.
#![allow(clippy::unwrap_used, missing_docs)]

use crbm::{Instructions, Layout, Policy, Sampling};

#[test]
fn calls_allocate_nothing() {
    let layout = Layout::full(30, 50, 24).unwrap();
    let parameters = layout.random_parameters(0.01, 1, "start").unwrap();
    let mut score = vec![0.0; layout.n_parameters()];
    let mut policy = Policy::new(layout, Sampling::default(), &parameters).unwrap();
    let mut rng = policy.rng(1, "policy");
    let (x, mut y) = ([true; 30], [false; 24]);
    for instructions in Instructions::available() {
        policy.set_instructions(instructions).unwrap();
        let counted = allocation_counter::measure(|| {
            for _ in 0..3 {
                policy.set_parameters(&parameters).unwrap();
                policy.act_and_score(&x, &mut rng, &mut y, &mut score).unwrap();
                policy.act(&x, &mut rng, &mut y).unwrap();
                policy.score(&x, &y, &mut rng, &mut score).unwrap();
            }
        });
        assert_eq!(counted.count_total, 0, "{instructions:?}: {counted:?}");
    }
}

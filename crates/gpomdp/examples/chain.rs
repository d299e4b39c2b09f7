//! Every optimiser learns the three-state chain from nothing but scores and rewards.
//!
//! ```text
//! cargo run -p gpomdp --release --example chain
//! ```
//!
//! In states A, B and C there are two actions; each leads to C with probability 0.2 or 0.8, and C
//! pays 1. The best policy takes the second action always and gets 0.8 a step; a softmax policy
//! gets there in the limit. Each update is made from 100 steps, with beta = 0.75 and a baseline.
//! What is printed is the exact average reward of the policy after so many updates, from its
//! stationary distribution, and the R that the estimator saw during the last one.

#[path = "../tests/problems/mod.rs"]
mod problems;

use gpomdp::{Error, Estimator, EstimatorSettings};
use problems::{
    Draws, Learner, Problem,
    chain::{Chain, Exact, N_PARAMETERS, probabilities},
    suited_optimisers,
};

const UPDATES: u32 = 400;
const STEPS: u32 = 100;

fn main() -> Result<(), Error> {
    for optimiser in suited_optimisers() {
        println!("{optimiser:?}\n");
        println!("updates  average reward  seen");
        let settings = EstimatorSettings { discount: 0.75, baseline_factor: Some(0.998) };
        let mut learner = Learner {
            estimator: Estimator::new(N_PARAMETERS, &settings)?,
            optimiser: optimiser.build(N_PARAMETERS)?,
            steps: STEPS,
        };
        let mut theta = [0.0; N_PARAMETERS];
        let mut draws = Draws::new(1);
        let mut chain = Chain::stationary(&theta, &mut draws);
        for update in 0..=UPDATES {
            if [0, 1, 2, 5, 10, 20, 50, 100, 200, 400].contains(&update) {
                let exact = Exact::at(&theta).average_reward();
                let seen = match update {
                    0 => "   -".to_owned(),
                    _ => format!("{:.2}", learner.estimator.average_reward()),
                };
                println!("{update:7}  {exact:14.4}  {seen}  {}", bar(exact / chain.optimum()));
            }
            learner.learn(&mut chain, &mut theta, &mut draws)?;
        }
        let p = [0, 1, 2].map(|state| probabilities(&theta, state)[1]);
        println!("optimum  {:14.4}", chain.optimum());
        println!("p(second action) in A, B, C: {:.4}, {:.4}, {:.4}\n", p[0], p[1], p[2]);
    }
    Ok(())
}

/// 50 columns are the optimum.
fn bar(part: f64) -> String {
    "#".repeat((50.0 * part) as usize)
}

//! Bias against beta on the three-state chain: the table of the crate's page.

use gpomdp::{Error, Estimator, EstimatorSettings};

use super::{
    Draws, Problem,
    chain::{Chain, Exact, N_PARAMETERS, Theta},
};

pub const THETA: Theta = [1.0, 1.0, -1.0, -1.0];
const DISCOUNTS: [f64; 6] = [0.0, 0.4, 0.75, 0.9, 0.95, 0.99];
/// Steps of a loop, and how many of them.
const LOOPS: [(u32, u32); 2] = [(100, 4000), (10_000, 400)];

/// The lines of the table, in Markdown.
pub fn table() -> Result<Vec<String>, Error> {
    let exact = Exact::at(&THETA);
    let gradient = exact.gradient();
    let mut lines = vec![
        "| beta | bias | noise, T = 100 | noise, T = 10,000 |".to_owned(),
        "|---|---|---|---|".to_owned(),
    ];
    for discount in DISCOUNTS {
        let expected = exact.discounted_gradient(discount);
        let bias: f64 = expected.iter().zip(gradient).map(|(a, b)| (a - b) * (a - b)).sum();
        let [short, long] = noise(discount, norm(&gradient))?;
        let bias = 100.0 * bias.sqrt() / norm(&gradient);
        lines.push(format!("| {discount} | {bias:.1} % | {short:.0} % | {long:.0} % |"));
    }
    Ok(lines)
}

/// For each length of a loop, the root mean square distance of its estimates from their mean, in
/// percent of `unit`.
fn noise(discount: f64, unit: f64) -> Result<[f64; 2], Error> {
    let settings = EstimatorSettings { discount, ..Default::default() };
    let mut noises = [0.0; 2];
    for (noise, (steps, loops)) in noises.iter_mut().zip(LOOPS) {
        let mut estimator = Estimator::new(N_PARAMETERS, &settings)?;
        let mut draws = Draws::new(1);
        let mut chain = Chain::stationary(&THETA, &mut draws);
        let mut score = [0.0; N_PARAMETERS];
        let (mut sum, mut sum_of_squares) = ([0.0; N_PARAMETERS], 0.0);
        for _ in 0..loops {
            estimator.restart();
            for _ in 0..steps {
                let reward = chain.step(&THETA, &mut draws, &mut score);
                estimator.accumulate(&score, reward)?;
            }
            for (sum, delta) in sum.iter_mut().zip(estimator.gradient()) {
                *sum += delta;
                sum_of_squares += delta * delta;
            }
        }
        let n = f64::from(loops);
        let variance = (sum_of_squares - norm(&sum) * norm(&sum) / n) / (n - 1.0);
        *noise = 100.0 * variance.sqrt() / unit;
    }
    Ok(noises)
}

fn norm(vector: &Theta) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

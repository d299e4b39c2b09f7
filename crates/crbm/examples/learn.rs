//! Learns a small conditional distribution by following the score: maximum likelihood, with the
//! Monte-Carlo score that a policy has, and the exact log-likelihood as the judge.
//!
//! y has three bits: the exclusive or of x's two, which takes hidden units; x's first, but wrong one
//! time in four; the logical and of x's two, wrong one time in four too. The best there is: -0.56
//! nats for each of the noisy bits.
//!
//! `cargo run --release -p crbm --example learn`

use crbm::{Error, Exact, Layout, Policy, Sampling};

type Pair = (Vec<bool>, Vec<bool>);

fn main() -> Result<(), Error> {
    let layout = Layout::full(2, 8, 3)?;
    let mut parameters = layout.random_parameters(0.1, 1, "start")?;
    let mut policy = Policy::new(layout.clone(), Sampling::default(), &parameters)?;
    let mut rng = policy.rng(1, "samples");

    let pairs = pairs();
    let best = best_log_likelihood();
    let mut score = vec![0.0; layout.n_parameters()];
    let mut gradient = vec![0.0; layout.n_parameters()];
    println!("  step   mean log p(y|x), nats; at best {best:.4}");
    for step in 0..=3000 {
        if [0, 10, 30, 100, 200, 300, 500, 1000, 2000, 3000].contains(&step) {
            let log_likelihood = Exact::new(&layout, &parameters)?.log_likelihood(&pairs)?;
            let bar = "#".repeat((60.0 * (best / log_likelihood)) as usize);
            println!("{step:>6}   {log_likelihood:.4}  {bar}");
        }
        gradient.fill(0.0);
        for (x, y) in &pairs {
            policy.score(x, y, &mut rng, &mut score)?;
            gradient.iter_mut().zip(&score).for_each(|(sum, score)| *sum += score);
        }
        for (parameter, gradient) in parameters.iter_mut().zip(&gradient) {
            *parameter += 0.5 * gradient / pairs.len() as f64;
        }
        policy.set_parameters(&parameters)?;
    }

    println!("\n   x   most probable y");
    let exact = Exact::new(&layout, &parameters)?;
    for x in inputs() {
        let logs = exact.log_probabilities(&x)?;
        let mut numbers: Vec<usize> = (0..logs.len()).collect();
        numbers.sort_by(|a, b| logs[*b].total_cmp(&logs[*a]));
        let mut line = format!("  {}", text(&x));
        for &number in &numbers[..4] {
            line += &format!("   {} {:.3}", text(&exact.output(number)), logs[number].exp());
        }
        println!("{line}");
    }
    Ok(())
}

fn inputs() -> [Vec<bool>; 4] {
    [0, 1, 2, 3].map(|number| vec![number & 1 == 1, number & 2 == 2])
}

/// Each pair as often as its probability says: the distribution, as a list.
fn pairs() -> Vec<Pair> {
    let mut pairs = Vec::new();
    for x in inputs() {
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let y = vec![x[0] != x[1], x[0] != (i == 0), (x[0] && x[1]) != (j == 0)];
            pairs.push((x.clone(), y));
        }
    }
    pairs
}

/// Minus the entropy of y given x: of two bits that are wrong one time in four.
fn best_log_likelihood() -> f64 {
    2.0 * (0.25 * 0.25f64.ln() + 0.75 * 0.75f64.ln())
}

fn text(bits: &[bool]) -> String {
    bits.iter().map(|on| if *on { '1' } else { '0' }).collect()
}

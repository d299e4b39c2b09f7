//! How far short chains are off, exactly: the bias of the Monte-Carlo score against the number of
//! Gibbs updates, by enumeration, for weights of several sizes.
//!
//! With G updates from a uniform start, y has a distribution p_G instead of p. The score's second
//! term is then the mean over p_G instead of p, whatever the number of samples, so that the bias is
//! minus the mean of the exact score over p_G. It's given in parts of the score's own size, the
//! root mean square over p; all means over x, and over machines.
//!
//! `cargo run --release -p crbm --example bias`

use crbm::{Error, Exact, Layout};

const UPDATES: [usize; 6] = [1, 2, 5, 10, 20, 50];
const MACHINES: u64 = 20;

fn main() -> Result<(), Error> {
    let layout = Layout::full(3, 8, 6)?;
    println!("3 inputs, 8 hidden units, 6 outputs; parameters N(0, s^2); {MACHINES} machines each");
    println!("size of the bias / size of the score");
    let columns: String = UPDATES.iter().map(|updates| format!("{updates:>10}")).collect();
    println!("   s | G ={}", &columns[3..]);
    for scale in [0.01, 0.5, 1.0, 2.0, 4.0] {
        let (mut biases, mut sizes) = ([0.0; UPDATES.len()], 0.0);
        for seed in 0..MACHINES {
            let parameters = layout.random_parameters(scale, seed, "bias")?;
            let exact = Exact::new(&layout, &parameters)?;
            for x in 0..8 {
                let x = [x & 1 == 1, x & 2 == 2, x & 4 == 4];
                add(&exact, &layout, &x, (&mut biases, &mut sizes))?;
            }
        }
        let line: String =
            biases.iter().map(|bias: &f64| format!("{:>10.1e}", (bias / sizes).sqrt())).collect();
        println!("{scale:>4} |{line}");
    }
    Ok(())
}

/// Adds the squared sizes of the biases and of the score.
fn add(
    exact: &Exact,
    layout: &Layout,
    x: &[bool],
    (biases, size): (&mut [f64], &mut f64),
) -> Result<(), Error> {
    let outputs: Vec<Vec<bool>> =
        (0..1 << layout.n_outputs()).map(|number| exact.output(number)).collect();
    let scores: Result<Vec<_>, _> = outputs.iter().map(|y| exact.score(x, y)).collect();
    let (scores, logs) = (scores?, exact.log_probabilities(x)?);
    for (log, score) in logs.iter().zip(&scores) {
        *size += log.exp() * score.iter().map(|score| score * score).sum::<f64>();
    }
    let transitions = transitions(exact, layout, x, &outputs)?;
    let mut of_y = vec![1.0 / outputs.len() as f64; outputs.len()];
    for updates in 1..=UPDATES[UPDATES.len() - 1] {
        let column = |y: usize| of_y.iter().zip(&transitions).map(move |(p, row)| p * row[y]).sum();
        of_y = (0..outputs.len()).map(column).collect();
        if let Some(place) = UPDATES.iter().position(|&listed| listed == updates) {
            let mean = |k: usize| of_y.iter().zip(&scores).map(|(p, s)| p * s[k]).sum::<f64>();
            biases[place] += (0..layout.n_parameters()).map(|k| mean(k).powi(2)).sum::<f64>();
        }
    }
    Ok(())
}

/// P(y -> y') of one full update, `[2^n_outputs x 2^n_outputs]`.
fn transitions(
    exact: &Exact,
    layout: &Layout,
    x: &[bool],
    outputs: &[Vec<bool>],
) -> Result<Vec<Vec<f64>>, Error> {
    let mut transitions = vec![vec![0.0; outputs.len()]; outputs.len()];
    let hidden: Result<Vec<_>, _> =
        outputs.iter().map(|y| exact.hidden_probabilities(x, y)).collect();
    let hidden = hidden?;
    for number in 0..1 << layout.n_hidden() {
        let h: Vec<bool> = (0..layout.n_hidden()).map(|j| number >> j & 1 == 1).collect();
        let on = exact.output_probabilities(&h)?;
        let to: Vec<f64> = outputs.iter().map(|y| product(&on, y)).collect();
        for (row, hidden) in transitions.iter_mut().zip(&hidden) {
            let of_h = product(hidden, &h);
            row.iter_mut().zip(&to).for_each(|(sum, to)| *sum += of_h * to);
        }
    }
    Ok(transitions)
}

/// The probability of bits that are on independently.
fn product(on: &[f64], bits: &[bool]) -> f64 {
    on.iter().zip(bits).map(|(p, on)| if *on { *p } else { 1.0 - p }).product()
}

//! Bias and noise of the estimate against the discount beta, on the three-state chain: the table
//! of the crate's page.
//!
//! ```text
//! cargo run -p gpomdp --release --example discount_bias
//! ```
//!
//! The bias is exact, from the chain's stationary distribution; the noise is measured, with a
//! fixed seed. `tests/oracles.rs` compares the table with the page.

#[path = "../tests/problems/mod.rs"]
mod problems;

fn main() -> Result<(), gpomdp::Error> {
    println!(
        "In percent of the length of the exact gradient, at theta = {:?}:\n",
        problems::bias::THETA
    );
    for line in problems::bias::table()? {
        println!("{line}");
    }
    Ok(())
}

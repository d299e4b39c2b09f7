//! Shows a model as tables: `cargo run -p svenja --example describe -- models/svenja.toml`.

use std::{env, process::ExitCode};

use svenja::{Describe, Morphology};

fn main() -> ExitCode {
    let path = env::args().nth(1).unwrap_or_else(|| "models/svenja.toml".into());
    match Morphology::open(path.as_ref()) {
        Ok(model) => {
            println!("{}", Describe(&model));
            ExitCode::SUCCESS
        }
        Err(problems) => {
            eprintln!("{problems}");
            ExitCode::FAILURE
        }
    }
}

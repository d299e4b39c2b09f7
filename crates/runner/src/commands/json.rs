//! What commands print with `--json`: one object a line, which says whose it is and the version of its
//! shape. `docs/json.md` has the shapes.

use anyhow::Context;
use serde::Serialize;

use super::print;

/// Counts up when a key changes its meaning or goes; one that is added changes nothing.
const FORMAT: u64 = 1;

#[derive(Serialize)]
struct Object<'a, T> {
    command: &'a str,
    format: u64,
    #[serde(flatten)]
    content: T,
}

/// Prints what a command has to say. Numbers that aren't finite are null.
pub(super) fn print_json(command: &str, content: impl Serialize) -> anyhow::Result<()> {
    let object = Object { command, format: FORMAT, content };
    let mut line = serde_json::to_vec(&object).context("making JSON of what was found")?;
    line.push(b'\n');
    print(&line)
}

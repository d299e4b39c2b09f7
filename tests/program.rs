//! The program as its users run it. All in one binary, since one for each of these files takes longer to
//! build than to run; what needs a browser or a second build is apart: `report.rs`, `contributions.rs`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod bad_experiments;
mod command_line;
mod common;
mod comparison;
mod completions;
mod contributing;
mod crash;
mod determinism;
mod earlier;
mod experiments;
mod export;
mod failures;
mod format;
mod health;
mod imports;
mod json;
mod landscape;
mod learning;
mod memory;
mod plots;
mod policies;
mod publish;
mod readers;
mod replay;
mod rewards;
mod robots;
mod set_up;
mod signals;
mod tasks;
mod workers;

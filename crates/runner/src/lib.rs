//! The lab: experiments from files, trained, recorded, resumed.

#![forbid(unsafe_code)]

pub mod catalogue;
pub mod cli;
pub mod commands;
pub mod experiment;
pub mod gait;
pub mod plain;
pub mod plots;
pub mod progress;
pub mod replay;
pub mod report;
pub mod reward;
pub mod rollout;
pub mod session;
pub mod store;
pub mod training;

mod models;
mod numbers;
mod parallel;
mod rules;

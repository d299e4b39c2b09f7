//! The lab: experiments from files, trained, recorded, resumed.

#![forbid(unsafe_code)]

pub mod catalogue;
pub mod cli;
pub mod clips;
pub mod commands;
pub mod experiment;
pub mod gait;
pub mod progress;
pub mod report;
pub mod rollout;
pub mod session;
pub mod training;

mod models;

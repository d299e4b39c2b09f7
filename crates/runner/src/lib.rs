//! The lab: experiments from files, trained, recorded, resumed; what the binary `itarl` is made of.
//!
//! | file | what |
//! |---|---|
//! | [`experiment`] | experiment files: all settings of a cell, the sweep over some of them |
//! | [`session`] | one cell at work: robot, policy, reward, gradient, step by step |
//! | [`training`] | many cells over threads and lanes, with checkpoints, until done or stopped |
//! | [`models`] | the robots of experiments |
//! | [`catalogue`] | a run's folder with what it's made of: where training and reading begin |
//! | [`comparison`] | one run, or several that are compared |
//! | [`merge`] | run folders put together |
//! | [`rollout`], [`gait`] | a policy or a gait without learning |
//! | [`health`] | what is wrong with how cells learn |
//! | [`publish`] | what others need of a run, in a small folder |
//! | [`tensorboard`] | a cell's rows as an event file of TensorBoard's |
//! | [`landscape`] | how reward, task and information depend on a policy's parameters |
//! | [`clips`], [`report`] | what `scenes` and `figures` show of a run, composed |
//! | [`cli`], [`commands`], [`progress`] | what can be typed, what it does, and how far it is |
//!
//! What always holds: a cell's result depends on its setting and its seed alone. Whoever shows
//! progress observes, and whoever reads results reads files.

#![forbid(unsafe_code)]

pub mod catalogue;
pub mod cli;
pub mod clips;
pub mod commands;
pub mod comparison;
pub mod experiment;
pub mod gait;
pub mod health;
pub mod landscape;
pub mod merge;
pub mod models;
pub mod progress;
pub mod publish;
pub mod report;
pub mod rollout;
pub mod session;
pub mod tensorboard;
pub mod training;

mod policies;

//! What bodies do, against the formulas of mechanics.
//!
//! Where Bullet's integrator (semi-implicit Euler: v' = v + a dt, x' = x + v' dt) has a closed
//! form, trajectories are held to that form, to rounding; else to the continuous formula, within
//! what the step makes of it. Joints' signs and frames are in `tests/joints/`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod contact;
mod drives;
mod friction;
mod lab;
mod motion;
mod motors;

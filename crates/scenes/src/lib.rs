//! Robots to look at: what was recorded of one, as a page, a film, a picture, or a scene for others.
//!
//! A [`Clip`] is a robot and its motion, checked once. What shows it is one file each:
//!
//! | file | what |
//! |---|---|
//! | `clip.rs` | [`Clip`]: a model and a recording of it; [`RewardParts`]: how its reward is called |
//! | [`viewer`], [`page`] | packed for the JavaScript in `assets/viewer/`; one HTML file with all in it |
//! | [`render`] | a ray caster: pictures without a GPU |
//! | [`film`] | frames in a row, as GIF or by ffmpeg |
//! | [`glb`], `mesh.rs` | glTF, for Blender; shapes as triangles |
//! | `three_sides.rs` | [`three_sides`]: a model from three sides, and as it stands there |
//! | `error.rs` | [`Error`] |
//!
//! ```
//! use svenja::Morphology;
//!
//! let ball = r##"
//! name = "Ball"
//! heading = { body = "ball", axis = [0.0, 1.0, 0.0] }
//!
//! [[body]]
//! name = "ball"
//! mass_kg = 1.0
//! position_m = [0.0, 0.0, 0.1]
//! shape = { kind = "sphere", radius_m = 0.1 }
//! colour = "#808080"
//! "##;
//! let picture = scenes::three_sides(&Morphology::parse("ball.toml", ball)?)?;
//! assert!(picture.png()?.starts_with(b"\x89PNG"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What always holds: the same model and recording give the same bytes, on any machine and with any
//! number of threads; no system's sine is asked, no clock is read, and a page asks for nothing that
//! isn't in it. Nothing is simulated here: `svenja` is built without Bullet, and how the reward came
//! about isn't known.

#![forbid(unsafe_code)]

mod clip;
mod error;
pub mod film;
pub mod glb;
mod mesh;
pub mod page;
pub mod render;
mod three_sides;
pub mod viewer;

pub use clip::{Clip, Quantity, RewardParts};
pub use error::Error;
pub use three_sides::three_sides;

/// Liberation Sans, as in `fonts/`: of all words in pictures, so that they're the same bytes
/// everywhere.
pub const FONT: &[u8] = include_bytes!("../fonts/LiberationSans-Regular.ttf");

#[cfg(test)]
mod example;

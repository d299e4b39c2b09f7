//! Robots to look at: what was recorded of one, as a page, a film, a picture, or a scene for others.
//!
//! A [`Clip`] is a robot and its motion. What shows it is one file each: [`viewer`] packs it for the
//! page's JavaScript, [`render`] draws it without a GPU, [`film`] puts frames in a row, [`glb`]
//! writes it for Blender, [`figure`] draws a model from three sides.

mod clip;
pub mod figure;
pub mod film;
pub mod glb;
pub mod page;
pub mod render;
pub mod viewer;

pub use clip::Clip;

#[cfg(test)]
mod example;

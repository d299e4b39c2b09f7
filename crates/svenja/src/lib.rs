//! Robots from model files: read, checked, built in a world, sensed and actuated.
//!
//! A [`Morphology`] is a body plan: a tree of rigid bodies with joints, servos and sensors, read
//! from a TOML file that `docs/formats.md` explains. A [`Robot`] is one of them in a world of the
//! `bullet` crate.
//!
//! ```
//! # #[cfg(feature = "bullet")] {
//! use bullet::{World, WorldSettings};
//! use svenja::{Morphology, Readings, Robot, add_ground};
//!
//! # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/svenja.toml");
//! let morphology = Morphology::open(path.as_ref())?;
//! let mut world = World::new(&WorldSettings::default())?; // 100 Hz
//! add_ground(&mut world)?;
//! let mut robot = Robot::spawn(&morphology, &mut world)?;
//!
//! let mut readings = Readings::default();
//! for _ in 0..20 {
//!     robot.actuate(&vec![0.0; morphology.actuators().len()])?; // the middle of all ranges
//!     robot.step(&mut world, 10)?; // held for 0.1 s
//!     robot.sense(&world, &mut readings)?;
//! }
//! let n_feet_down = readings.values[morphology.sensors().len()..].iter().sum::<f64>();
//! assert!(n_feet_down >= 3.0 && robot.n_penalised_contacts() == 0);
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//! SI units and radians in code, degrees in files. All angles are right-handed, and positions are 0 as
//! the model is drawn. A reading of -1 to 1 covers an axis' range, or a whole turn if it has none, and
//! so does a command to a servo of position; those of speed and torque take a share of their limit.
//!
//! # Features
//! `bullet`, on by default: robots in worlds. Without it the crate needs no Bullet, and models can
//! be read, checked and [described](Describe). `float64`: Bullet in double precision.

#![forbid(unsafe_code)]

#[cfg(feature = "bullet")]
mod axes;
#[cfg(feature = "bullet")]
mod build;
mod check;
mod describe;
mod file;
mod gravity;
mod hull;
mod inertia;
mod joint;
mod mesh;
mod morphology;
mod parts;
#[cfg(feature = "bullet")]
mod robot;
mod rotation;
mod servo;
mod shape;
mod warn;

pub use config::{Problem, Problems};
pub use describe::Describe;
pub use gravity::centre_of_gravity_m;
pub use hull::{Hull, MOST_POINTS};
pub use inertia::Inertia;
pub use joint::{Freedom, Joint, JointAxis, JointKind, Resistance, Servo, ServoKind, Spring, Stop};
pub use morphology::{AxisId, Body, Group, Heading, Mesh, Morphology};
#[cfg(feature = "bullet")]
pub use robot::{Error, Readings, Robot, add_ground};
pub use rotation::Turn;
pub use servo::{ServoCommand, servo_command, servo_velocity};
pub use shape::{Collider, Rod, Shape};

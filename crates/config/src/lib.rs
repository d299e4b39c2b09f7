//! TOML files read key by key: models and experiments say what is wrong where, all at once.
//!
//! A [`Document`] is a file as it was written, every value with its [`Place`]. [`Document::read`]
//! hands it over as a [`Section`], a table that is asked for its keys, each with a [`Rule`] that
//! says what the value must be. What doesn't fit is collected, and so are keys that nobody asked
//! for; the reader gets either what it made or all [`Problems`].
//!
//! The code that reads a key is also its declaration: a rule may have what the value is
//! [about](Rule::about), and [`settings`] asks a reader, without a file, for all keys with their
//! meanings, ranges and defaults, those of every [kind](Section::kind) among them.
//!
//! ```
//! use config::{Document, above, text};
//!
//! let file = "name = 'worm'\nmass_kgs = 2.0\nlength_m = -1\n";
//! let problems = Document::parse("worm.toml", file)?
//!     .read(|worm| {
//!         let name = worm.required("name", text());
//!         let mass = worm.required("mass_kg", above(0.0));
//!         let length = worm.or("length_m", above(0.0), 1.0);
//!         Some((name?, mass?, length))
//!     })
//!     .unwrap_err();
//! assert_eq!(
//!     problems.to_string(),
//!     "worm.toml:1:1: 'mass_kg' is missing: a number above 0\n\
//!      worm.toml:2:1: unknown key 'mass_kgs', did you mean 'mass_kg'?\n\
//!      worm.toml:3:12: length_m must be a number above 0, got -1"
//! );
//! # Ok::<(), config::Problems>(())
//! ```

#![forbid(unsafe_code)]

mod change;
mod compound;
mod document;
mod foreign;
mod problem;
mod rule;
mod section;
mod setting;
mod value;

pub use compound::{Placed, list, or_false, or_word, placed, vector};
pub use document::{Document, LARGEST_FILE, read_text};
pub use problem::{MOST_PROBLEMS, Place, Problem, Problems};
pub use rule::{
    Mismatch, Rule, above, angle_deg, at_least, count, flag, integer, name, number, one_of, text,
    within,
};
pub use section::{Section, suggestion};
pub use setting::{About, Only, Presence, Setting, settings};
pub use value::{Key, Node, Value, shown};

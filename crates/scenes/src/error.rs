//! What can go wrong with a scene.

use std::{io, path::PathBuf};

/// Why there's nothing to look at.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A recording that isn't of this robot, or shows nothing.
    #[error("{0}")]
    Recording(String),
    /// More than a file format can hold.
    #[error("{0}")]
    TooLarge(&'static str),
    /// A film can't be written.
    #[error("{}: writing: {cause}", path.display())]
    Io {
        /// The film.
        path: PathBuf,
        /// Why it didn't work. Not called `source`: whoever prints a chain of errors has it already.
        cause: io::Error,
    },
    /// ffmpeg isn't there.
    #[error(
        "--mp4 needs ffmpeg on the path (`apt-get install ffmpeg`); --gif works without it: {cause}"
    )]
    NoFfmpeg {
        /// Why it couldn't be started.
        cause: io::Error,
    },
    /// ffmpeg began and didn't end well.
    #[error("{}: ffmpeg failed ({how}): {said}", path.display())]
    Ffmpeg {
        /// The film.
        path: PathBuf,
        /// How it ended.
        how: String,
        /// What it said.
        said: String,
    },
    /// The font, which is in the program.
    #[error("the font: {0}")]
    Font(ab_glyph::InvalidFont),
    /// A picture that PNG refuses.
    #[error(transparent)]
    Png(#[from] png::EncodingError),
    /// A picture that GIF refuses.
    #[error(transparent)]
    Gif(#[from] gif::EncodingError),
    /// A number that JSON refuses.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

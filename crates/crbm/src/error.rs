//! What can go wrong, with the place, what was expected there and what was found.

/// What the crate refused. Nothing has changed when it's returned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument that can't be used.
    #[error("{place}: {argument} must be {expected}, got {value}")]
    Argument {
        /// The function that refused.
        place: &'static str,
        /// Its argument, or the part of it.
        argument: String,
        /// What it should be.
        expected: String,
        /// What it was.
        value: String,
    },
    /// More than there is memory for.
    #[error("{place}: it takes {:.0} MB, and there is no memory for them", *bytes as f64 / 1e6)]
    Memory {
        /// The function that refused.
        place: &'static str,
        /// What it would have taken.
        bytes: usize,
    },
    /// Bytes that aren't the parameters of such a machine.
    #[error("safetensors: {part} must be {expected}, got {value}")]
    File {
        /// The tensor, or the part of the file.
        part: String,
        /// What it should be.
        expected: String,
        /// What it was.
        value: String,
    },
}

impl Error {
    pub(crate) fn argument(
        place: &'static str,
        argument: impl Into<String>,
        expected: impl Into<String>,
        value: impl ToString,
    ) -> Self {
        let (argument, expected) = (argument.into(), expected.into());
        Self::Argument { place, argument, expected, value: value.to_string() }
    }

    pub(crate) fn file(
        part: impl Into<String>,
        expected: impl Into<String>,
        value: impl ToString,
    ) -> Self {
        Self::File { part: part.into(), expected: expected.into(), value: value.to_string() }
    }
}

/// Refuses what there is no room for, where an allocation that fails would end the program.
pub(crate) fn check_room(place: &'static str, bytes: usize) -> Result<(), Error> {
    let room = Vec::<u8>::new().try_reserve_exact(bytes);
    room.map_err(|_| Error::Memory { place, bytes })
}

/// A slice's length.
pub(crate) fn check_length(
    place: &'static str,
    argument: &str,
    expected: usize,
    got: usize,
) -> Result<(), Error> {
    if expected == got {
        return Ok(());
    }
    Err(Error::argument(place, format!("length of {argument}"), expected.to_string(), got))
}

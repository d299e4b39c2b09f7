//! What can go wrong, with the call, the argument, what it should be and what it was.

/// What a function of this crate refused. Nothing was changed by the call.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument without meaning here.
    #[error("{call}: {argument} must be {expected}, got {value}")]
    Argument {
        /// The function that refused.
        call: &'static str,
        /// Its argument, or the part of it.
        argument: String,
        /// What it should be.
        expected: String,
        /// What it was.
        value: String,
    },
    /// Joint states that 64 bits can't number.
    #[error("{call}: radices must multiply to at most 2^64, got more with the first {n_radices}")]
    TooManyStates {
        /// The function that refused.
        call: &'static str,
        /// How many of the radices it took to get there.
        n_radices: usize,
    },
    /// More than there is memory for.
    #[error("{call}: it takes {:.0} MB, and there is no memory for them", *bytes as f64 / 1e6)]
    Memory {
        /// The function that refused.
        call: &'static str,
        /// What it would have taken.
        bytes: usize,
    },
}

/// A refused argument. The only place where messages are put together, and off the hot path.
#[cold]
pub(crate) fn refused(
    call: &'static str,
    argument: impl Into<String>,
    expected: impl Into<String>,
    value: impl ToString,
) -> Error {
    Error::Argument {
        call,
        argument: argument.into(),
        expected: expected.into(),
        value: value.to_string(),
    }
}

/// Refuses what there is no room for, where an allocation that fails would end the program.
pub(crate) fn check_room(call: &'static str, bytes: usize) -> Result<(), Error> {
    let room = Vec::<u8>::new().try_reserve_exact(bytes);
    room.map_err(|_| Error::Memory { call, bytes })
}

/// A slice whose length must be `expected`.
pub(crate) fn check_length(
    call: &'static str,
    argument: &str,
    expected: usize,
    found: usize,
) -> Result<(), Error> {
    if found == expected {
        return Ok(());
    }
    Err(refused(call, format!("the length of {argument}"), expected.to_string(), found))
}

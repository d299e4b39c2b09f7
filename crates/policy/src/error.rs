//! What can go wrong, with the place, what was expected there and what was found.

use std::fmt;

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
    /// Settings that don't fit the robot.
    #[error("{key}: {message}")]
    Misfit {
        /// The setting.
        key: &'static str,
        /// What doesn't fit.
        message: String,
    },
    /// More parameters than there is memory for.
    #[error(
        "{parameters} parameters take {:.0} MB, and there is no memory for them",
        8e-6 * *parameters as f64
    )]
    Memory {
        /// Their number.
        parameters: usize,
    },
    /// Bytes that aren't the parameters of a policy.
    #[error("safetensors: {part} must be {expected}, got {value}")]
    File {
        /// The tensor, or the part of the file.
        part: String,
        /// What it should be.
        expected: String,
        /// What it was.
        value: String,
    },
    /// The parameters of a policy of another kind, of other sizes or with other connections.
    #[error("another policy's parameters: {}", list(.0))]
    OtherLayout(Vec<Difference>),
    /// What a conditional restricted Boltzmann machine refused.
    #[error(transparent)]
    Machine(#[from] crbm::Error),
}

/// What a file has otherwise than a policy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The tensor, or the part of the file.
    pub part: String,
    /// In the file.
    pub there: String,
    /// In the policy.
    pub here: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {} there, {} here", self.part, self.there, self.here)
    }
}

/// Differences that a message lists; what there are more is counted.
const LISTED: usize = 4;

fn list(differences: &[Difference]) -> String {
    let mut items: Vec<_> = differences.iter().take(LISTED).map(ToString::to_string).collect();
    if differences.len() > LISTED {
        items.push(format!("and {} more", differences.len() - LISTED));
    }
    items.join("; ")
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

    pub(crate) fn misfit(key: &'static str, message: impl Into<String>) -> Self {
        Self::Misfit { key, message: message.into() }
    }

    pub(crate) fn file(
        part: impl Into<String>,
        expected: impl Into<String>,
        value: impl ToString,
    ) -> Self {
        Self::File { part: part.into(), expected: expected.into(), value: value.to_string() }
    }
}

/// Parameters that are 0. An allocation that fails otherwise ends the program.
pub(crate) fn zeros(n: usize) -> Result<Vec<f64>, Error> {
    let mut zeros = Vec::new();
    zeros.try_reserve_exact(n).map_err(|_| Error::Memory { parameters: n })?;
    zeros.resize(n, 0.0);
    Ok(zeros)
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn what_there_is_no_memory_for_is_refused_with_its_size() {
        let message = zeros(1 << 57).unwrap_err().to_string();
        let expected = "144115188075855872 parameters take 1152921504607 MB, and there is no \
                        memory for them";
        assert_eq!(message, expected);
        assert_eq!(zeros(2).unwrap(), [0.0; 2]);
    }
}

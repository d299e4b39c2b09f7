//! What can go wrong with a reward.

/// Why there's no reward.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The information between the robot's groups is asked for, and it has none.
    #[error(
        "reward.intrinsic.group = \"group\" needs a model with groups, got one without; \
         add [[group]] to the model, or choose \"sensor\" or \"body\""
    )]
    NoGroups,
    /// There's nothing to measure information of.
    #[error(
        "reward.intrinsic must have at least one sensor in {place}, got none with \
         sensors = \"{sensors}\""
    )]
    NoSensors {
        /// `the model` or `group 'left'`.
        place: String,
        /// The setting.
        sensors: &'static str,
    },
    /// A term that is NaN or infinite.
    #[error("the reward's term '{term}' must be a finite number, got {value}")]
    NotFinite {
        /// One of [`Terms::NAMES`](super::Terms::NAMES).
        term: &'static str,
        /// What it is.
        value: f64,
    },
    /// A body that the model doesn't have.
    #[error(
        "reward.extrinsic.body must be one of the model's bodies, {known}; got '{name}'{suggestion}"
    )]
    UnknownBody {
        /// The setting.
        name: String,
        /// `, did you mean 'head'?`, or nothing.
        suggestion: String,
        /// All that there are.
        known: String,
    },
    /// Information that passes between joints is asked for, and no two of them are neighbours.
    #[error(
        "reward.intrinsic.kind = \"transfer_entropy\" needs joints of which one moves the body that \
         the other is fixed to, both with sensors, got a model without; choose \
         \"mutual_information\" or \"none\""
    )]
    NoNeighbours,
    /// A saved state of another reward.
    #[error("a reward's state must be {expected}, got {found}")]
    State {
        /// What this one's is.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// A reading that doesn't fit the layout, or a state that doesn't fit the window.
    #[error(transparent)]
    Information(#[from] infotheory::Error),
}

impl Error {
    /// For what has nothing to restore.
    pub(crate) fn expect_no_state(state: &[u64]) -> Result<(), Self> {
        match state {
            [] => Ok(()),
            _ => Err(Self::State { expected: "empty", found: format!("{} words", state.len()) }),
        }
    }
}

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
    /// A saved state of another reward.
    #[error("a reward without a window must have an empty state, got {n_words} words")]
    State {
        /// Its length.
        n_words: usize,
    },
    /// A reading that doesn't fit the layout, or a state that doesn't fit the window.
    #[error(transparent)]
    Information(#[from] infotheory::Error),
}

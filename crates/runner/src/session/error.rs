//! Why a cell can't begin, or ends.

/// What went wrong in a cell.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Settings of a policy that don't fit the model.
    #[error(transparent)]
    Policy(#[from] policy::Error),
    /// A file with the parameters at the beginning that aren't those of such a policy.
    #[error("policy.initial: {path}: {cause}")]
    Initial {
        /// The file.
        path: String,
        /// What is wrong with it.
        cause: policy::Error,
    },
    /// A cell that blew up: it can't go on.
    #[error("{when}: {message}")]
    BlewUp {
        /// The control step, counted from 1 after settling, or the update.
        when: String,
        /// What blew up, and where.
        message: String,
    },
    /// Something that isn't the cell's fault: it can be gone on with from its checkpoint.
    #[error("{when}: {message}")]
    Interrupted {
        /// The control step, counted from 1 after settling.
        when: String,
        /// What the world says.
        message: String,
    },
    /// A checkpoint's section that doesn't fit the cell.
    #[error("the checkpoint's section '{section}' doesn't fit: {message}")]
    Checkpoint {
        /// Its name.
        section: String,
        /// What is wrong with it.
        message: String,
    },
    /// Building the cell.
    #[error("building the cell: {0}")]
    Build(String),
}

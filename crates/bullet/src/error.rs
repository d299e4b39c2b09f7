//! What can go wrong, with the call, the argument, what it should be and what it was.

use crate::{BodyId, SnapshotError};

/// What a [`World`](crate::World) refused, or what became of its state.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument that Bullet couldn't use. The world is as before the call.
    #[error("{call}: {argument} must be {expected}, got {value}")]
    Argument {
        /// The function that refused.
        call: String,
        /// Its argument, or the part of it.
        argument: String,
        /// What it should be.
        expected: String,
        /// What it was.
        value: String,
    },
    /// An id of nothing in this world. The world is as before the call.
    #[error("{call}: {argument} {id} doesn't exist: {reason}")]
    UnknownId {
        /// The function that refused.
        call: String,
        /// Its argument, or the part of it.
        argument: String,
        /// The slot that was asked for.
        id: String,
        /// Why there is nothing in it.
        reason: String,
    },
    /// The simulation blew up: a number isn't finite, or beyond 1e18; or a body is farther out than
    /// 1e9 m, or goes farther than 5e5 m in a step, which Bullet doesn't follow. The world refuses
    /// to go on, until a snapshot is restored.
    #[error("step {step}: the {quantity} of body {} blew up: {value}", body.slot)]
    BlewUp {
        /// The first body that is affected.
        body: BodyId,
        /// Steps made, with the one that blew up.
        step: u64,
        /// Position, rotation, a velocity, a joint's force or torque, or a contact's impulse.
        quantity: String,
        /// Its three components.
        value: String,
    },
    /// Bytes that can't be restored.
    #[error("snapshot: {0}")]
    Snapshot(SnapshotError),
    /// Something that C++ threw and the shim didn't foresee, out of memory for one.
    #[error("C++: {0}")]
    Cpp(String),
}

impl From<SnapshotError> for Error {
    fn from(error: SnapshotError) -> Self {
        Self::Snapshot(error)
    }
}

/// Takes apart the record of `cpp/refusal.h`.
impl From<cxx::Exception> for Error {
    fn from(exception: cxx::Exception) -> Self {
        let record = exception.what();
        let fields: Vec<&str> = record.split('\u{1f}').collect();
        match fields[..] {
            ["A", call, argument, expected, value] => Error::Argument {
                call: call.into(),
                argument: argument.into(),
                expected: expected.into(),
                value: value.into(),
            },
            ["U", call, argument, id, reason] => Error::UnknownId {
                call: call.into(),
                argument: argument.into(),
                id: id.into(),
                reason: reason.into(),
            },
            ["N", slot, step, quantity, value] => match (slot.parse(), step.parse()) {
                (Ok(slot), Ok(step)) => Error::BlewUp {
                    body: BodyId { slot },
                    step,
                    quantity: quantity.into(),
                    value: value.into(),
                },
                _ => Error::Cpp(record.into()),
            },
            ["I", reason] => Error::Cpp(reason.into()),
            ["S", reason] => SnapshotError::Malformed(reason.into()).into(),
            _ => Error::Cpp(record.into()),
        }
    }
}

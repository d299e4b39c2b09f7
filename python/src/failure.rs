//! What goes wrong, as exceptions of Python.

use std::sync::{Mutex, TryLockError};

use pyo3::{
    PyErr, create_exception,
    exceptions::{PyRuntimeError, PyValueError},
};

create_exception!(
    itarl,
    Error,
    PyValueError,
    "What the lab refused, or couldn't do: a file, a folder, a setting, a value."
);

/// A failure to be raised once the interpreter is held again.
pub(crate) enum Failure {
    /// Another thread is at the object.
    Busy(&'static str),
    /// The object was closed.
    Closed(&'static str),
    /// What the lab says.
    Refused(anyhow::Error),
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Refused(error.into())
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Busy(what) => {
                PyRuntimeError::new_err(format!("{what} is used by another thread just now"))
            }
            Failure::Closed(what) => PyRuntimeError::new_err(format!("{what} was closed")),
            Failure::Refused(error) => Error::new_err(format!("{error:#}")),
        }
    }
}

/// An object that one thread uses at a time, until it's closed.
pub(crate) struct Exclusive<T> {
    what: &'static str,
    inner: Mutex<Option<T>>,
}

impl<T> Exclusive<T> {
    pub(crate) fn new(what: &'static str, inner: T) -> Self {
        Self { what, inner: Mutex::new(Some(inner)) }
    }

    /// Does something with it; nobody waits for anybody.
    pub(crate) fn with<R>(
        &self,
        act: impl FnOnce(&mut T) -> Result<R, Failure>,
    ) -> Result<R, Failure> {
        match self.inner.try_lock() {
            Ok(mut inner) => act(inner.as_mut().ok_or(Failure::Closed(self.what))?),
            Err(TryLockError::WouldBlock) => Err(Failure::Busy(self.what)),
            // What panicked half-way is of no use.
            Err(TryLockError::Poisoned(_)) => Err(Failure::Closed(self.what)),
        }
    }

    /// Gives back what it has. Closing twice is no mistake.
    pub(crate) fn close(&self) -> Result<(), Failure> {
        match self.inner.try_lock() {
            Ok(mut inner) => *inner = None,
            Err(TryLockError::WouldBlock) => return Err(Failure::Busy(self.what)),
            Err(TryLockError::Poisoned(poisoned)) => *poisoned.into_inner() = None,
        }
        Ok(())
    }
}

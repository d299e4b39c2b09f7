//! No intrinsic reward: the task alone.
//!
//! A geometric mix with 0 is 0 for every xi below 1, and nothing would ever be learned; a linear
//! one would only be smaller. So xi must be 1 with it: 0^0 = 1, and the extrinsic part stays.

use config::Section;
use serde::Serialize;

use super::{Build, Intrinsic, Value};
use crate::{Error, RobotLayout};

/// There is nothing to set.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct NoneSettings {}

impl NoneSettings {
    pub(super) fn read(_: &mut Section<'_>) -> Option<Self> {
        Some(Self {})
    }
}

impl Build for NoneSettings {
    fn build(&self, _: &RobotLayout) -> Result<Box<dyn Intrinsic>, Error> {
        Ok(Box::new(Nothing))
    }

    fn symbol(&self) -> &'static str {
        "none"
    }

    fn is_measured(&self) -> bool {
        false
    }
}

#[derive(Debug)]
struct Nothing;

impl Intrinsic for Nothing {
    fn push(&mut self, _: &[u64]) -> Result<(), Error> {
        Ok(())
    }

    fn value(&self) -> Value {
        Value::default()
    }

    fn save(&self) -> Vec<u64> {
        Vec::new()
    }

    fn restore(&mut self, state: &[u64]) -> Result<(), Error> {
        Error::expect_no_state(state)
    }
}

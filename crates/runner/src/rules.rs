//! Rules for values that several sections of an experiment file share, besides those of `config`.

use std::marker::PhantomData;

use config::{Mismatch, Node, Rule, Section, Value, integer};
use serde::Serializer;

/// A whole number within bounds, as a Rust integer.
pub(crate) struct Count<T> {
    low: i64,
    high: i64,
    integer: PhantomData<T>,
}

/// A whole number between two bounds, which it may reach.
pub(crate) fn count<T: TryFrom<i64>>(low: i64, high: i64) -> Count<T> {
    Count { low, high, integer: PhantomData }
}

impl<T: TryFrom<i64>> Rule for Count<T> {
    type Out = T;

    fn expected(&self) -> String {
        integer(self.low, self.high).expected()
    }

    fn take(&self, node: &Node) -> Result<T, Mismatch> {
        let value = integer(self.low, self.high).take(node)?;
        T::try_from(value).map_err(|_| self.refuse(node))
    }
}

/// A word in place of a value that there isn't, so that "none" can be written and swept too.
pub(crate) struct OrWord<R> {
    rule: R,
    word: Value,
}

/// A value, or this word for none.
pub(crate) fn or_word<R: Rule>(rule: R, word: &str) -> OrWord<R> {
    OrWord { rule, word: Value::Text(word.into()) }
}

/// A value, or false for none.
pub(crate) fn or_false<R: Rule>(rule: R) -> OrWord<R> {
    OrWord { rule, word: Value::Flag(false) }
}

impl<R: Rule> Rule for OrWord<R> {
    type Out = Option<R::Out>;

    fn expected(&self) -> String {
        format!("{} or {}", self.rule.expected(), self.word)
    }

    fn take(&self, node: &Node) -> Result<Self::Out, Mismatch> {
        if node.value == self.word {
            return Ok(None);
        }
        self.rule.take(node).map(Some).map_err(|_| self.refuse(node))
    }
}

/// Writes what [`or_false`] reads.
pub(crate) fn write_or_false<S: Serializer>(
    value: &Option<f64>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match value {
        Some(value) => serializer.serialize_f64(*value),
        None => serializer.serialize_bool(false),
    }
}

/// A value, or its default where the key isn't there; None if the value doesn't fit. For values
/// that others are checked against: a default in place of a bad one would only make more problems.
pub(crate) fn given_or<R: Rule>(
    section: &mut Section<'_>,
    key: &str,
    rule: R,
    default: R::Out,
) -> Option<R::Out> {
    let given = section.has(key);
    let value = section.optional(key, rule);
    if given { value } else { Some(default) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use config::{Document, within};

    use super::*;

    fn read<T>(text: &str, rule: impl Rule<Out = T>) -> Result<T, String> {
        let document = Document::parse("f", text).unwrap();
        document.read(|root| root.required("x", rule)).map_err(|problems| problems.to_string())
    }

    #[test]
    fn a_count_says_its_bounds() {
        assert_eq!(read("x = 3", count::<usize>(1, 3)), Ok(3));
        let expected = "f:1:5: x must be a whole number from 1 to 3, got 4";
        assert_eq!(read("x = 4", count::<usize>(1, 3)), Err(expected.into()));
        // Beyond the type, too.
        assert!(read("x = 300", count::<u8>(0, 1000)).is_err());
    }

    #[test]
    fn a_word_stands_for_none() {
        assert_eq!(read("x = 0.5", or_false(within(0.0, 1.0))), Ok(Some(0.5)));
        assert_eq!(read("x = false", or_false(within(0.0, 1.0))), Ok(None));
        assert_eq!(read("x = 'model'", or_word(within(0.0, 1.0), "model")), Ok(None));
        let expected = "f:1:5: x must be a number from 0 to 1 or false, got true";
        assert_eq!(read("x = true", or_false(within(0.0, 1.0))), Err(expected.into()));
    }
}

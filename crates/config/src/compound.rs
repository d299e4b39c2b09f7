//! Rules made of other rules: a value or a word for none, lists, a value with its place.

use crate::{Mismatch, Node, Place, Rule, Value};

/// A value, or a word in its place for none, so that "none" can be written and swept too.
#[derive(Clone, Debug)]
pub struct OrWord<R> {
    rule: R,
    word: Value,
}

/// A value, or this word for none.
pub fn or_word<R: Rule>(rule: R, word: &str) -> OrWord<R> {
    OrWord { rule, word: Value::Text(word.into()) }
}

/// A value, or false for none.
pub fn or_false<R: Rule>(rule: R) -> OrWord<R> {
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

    fn written(&self, value: &Self::Out) -> String {
        value.as_ref().map_or_else(|| self.word.to_string(), |value| self.rule.written(value))
    }
}

/// A list of values that all fit one rule.
#[derive(Clone, Copy, Debug)]
pub struct List<R>(R);

/// A list, of any length, of values that all fit one rule.
pub fn list<R: Rule>(rule: R) -> List<R> {
    List(rule)
}

impl<R: Rule> Rule for List<R> {
    type Out = Vec<R::Out>;

    fn expected(&self) -> String {
        format!("a list, each {}", self.0.expected())
    }

    fn take(&self, node: &Node) -> Result<Self::Out, Mismatch> {
        let Value::List(items) = &node.value else { return Err(self.refuse(node)) };
        let one = |(i, item): (usize, &Node)| {
            self.0
                .take(item)
                .map_err(|inner| Mismatch { part: format!("[{i}]{}", inner.part), ..inner })
        };
        items.iter().enumerate().map(one).collect()
    }

    fn written(&self, values: &Self::Out) -> String {
        written_list(&self.0, values)
    }
}

fn written_list<R: Rule>(rule: &R, values: &[R::Out]) -> String {
    let items: Vec<_> = values.iter().map(|value| rule.written(value)).collect();
    format!("[{}]", items.join(", "))
}

/// A list of a fixed length.
#[derive(Clone, Copy, Debug)]
pub struct Vector<R, const N: usize>(R);

/// A list of exactly `N` values that all fit one rule.
pub fn vector<R: Rule, const N: usize>(rule: R) -> Vector<R, N> {
    Vector(rule)
}

impl<R: Rule, const N: usize> Rule for Vector<R, N> {
    type Out = [R::Out; N];

    fn expected(&self) -> String {
        format!("a list of {N}, each {}", self.0.expected())
    }

    fn take(&self, node: &Node) -> Result<Self::Out, Mismatch> {
        match &node.value {
            Value::List(items) if items.len() == N => {}
            _ => return Err(self.refuse(node)),
        }
        List(&self.0).take(node)?.try_into().map_err(|_| self.refuse(node))
    }

    fn written(&self, values: &Self::Out) -> String {
        written_list(&self.0, values)
    }
}

/// A value that keeps its place, for checks that need more than the value.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed<T> {
    /// The value that the rule made of what stands there.
    pub value: T,
    /// The value's place in the file.
    pub place: Place,
}

/// Keeps the place of what fits another rule.
#[derive(Clone, Copy, Debug)]
pub struct WithPlace<R>(R);

/// A value that fits another rule, with its place.
pub fn placed<R: Rule>(rule: R) -> WithPlace<R> {
    WithPlace(rule)
}

impl<R: Rule> Rule for WithPlace<R> {
    type Out = Placed<R::Out>;

    fn expected(&self) -> String {
        self.0.expected()
    }

    fn take(&self, node: &Node) -> Result<Self::Out, Mismatch> {
        self.0.take(node).map(|value| Placed { value, place: node.place.clone() })
    }

    fn written(&self, placed: &Self::Out) -> String {
        self.0.written(&placed.value)
    }

    fn meaning(&self) -> &'static str {
        self.0.meaning()
    }

    fn range(&self) -> String {
        self.0.range()
    }
}

impl<R: Rule> Rule for &R {
    type Out = R::Out;

    fn expected(&self) -> String {
        (*self).expected()
    }

    fn take(&self, node: &Node) -> Result<R::Out, Mismatch> {
        (*self).take(node)
    }

    fn written(&self, value: &R::Out) -> String {
        (*self).written(value)
    }

    fn meaning(&self) -> &'static str {
        (*self).meaning()
    }

    fn range(&self) -> String {
        (*self).range()
    }
}

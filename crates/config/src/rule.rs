//! What a value must be, in words and in code.

use crate::{Node, Place, Value, section::advice};

/// Turns a value into what the reader needs, or says what it should have been.
pub trait Rule {
    /// What the reader gets.
    type Out;

    /// In words, after "must be".
    fn expected(&self) -> String;

    /// The value, if it fits.
    fn take(&self, node: &Node) -> Result<Self::Out, Mismatch>;

    /// That the value doesn't fit.
    fn refuse(&self, node: &Node) -> Mismatch {
        Mismatch {
            place: node.place.clone(),
            part: String::new(),
            expected: self.expected(),
            found: node.value.to_string(),
        }
    }
}

/// A value, or part of one, that doesn't fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Mismatch {
    /// Of the part.
    pub place: Place,
    /// `[2]` for a list's third value; empty for the whole.
    pub part: String,
    /// In words.
    pub expected: String,
    /// In words.
    pub found: String,
}

/// A number within bounds.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    low: f64,
    high: f64,
    open: bool,
}

/// Any finite number.
pub fn number() -> Number {
    within(f64::MIN, f64::MAX)
}

/// A finite number above a bound.
pub fn above(low: f64) -> Number {
    Number { low, high: f64::MAX, open: true }
}

/// A finite number not below a bound.
pub fn at_least(low: f64) -> Number {
    within(low, f64::MAX)
}

/// A number between two bounds, which it may reach.
pub fn within(low: f64, high: f64) -> Number {
    Number { low, high, open: false }
}

impl Rule for Number {
    type Out = f64;

    fn expected(&self) -> String {
        let Self { low, high, open } = self;
        match (*low == f64::MIN, *high == f64::MAX) {
            (true, true) => "a finite number".into(),
            (false, true) if *open => format!("a number above {low}"),
            (false, true) => format!("a number of at least {low}"),
            _ => format!("a number from {low} to {high}"),
        }
    }

    fn take(&self, node: &Node) -> Result<f64, Mismatch> {
        let value = match node.value {
            Value::Number(value) => value,
            Value::Integer(value) => value as f64,
            _ => return Err(self.refuse(node)),
        };
        // NaN fits nowhere.
        let fits = value >= self.low && value <= self.high && !(self.open && value == self.low);
        if fits { Ok(value) } else { Err(self.refuse(node)) }
    }
}

/// A number in degrees that arrives in radians.
#[derive(Clone, Copy, Debug)]
pub struct AngleDeg(Number);

/// An angle within half a turn of 0, written in degrees, read in radians.
pub fn angle_deg() -> AngleDeg {
    AngleDeg(within(-180.0, 180.0))
}

impl Rule for AngleDeg {
    type Out = f64;

    fn expected(&self) -> String {
        self.0.expected()
    }

    fn take(&self, node: &Node) -> Result<f64, Mismatch> {
        self.0.take(node).map(f64::to_radians)
    }
}

/// A whole number within bounds.
#[derive(Clone, Copy, Debug)]
pub struct Integer {
    low: i64,
    high: i64,
}

/// A whole number between two bounds, which it may reach. `i64::MAX` is no bound.
pub fn integer(low: i64, high: i64) -> Integer {
    Integer { low, high }
}

impl Rule for Integer {
    type Out = i64;

    fn expected(&self) -> String {
        match self.high {
            i64::MAX => format!("a whole number of at least {}", self.low),
            high => format!("a whole number from {} to {high}", self.low),
        }
    }

    fn take(&self, node: &Node) -> Result<i64, Mismatch> {
        match node.value {
            Value::Integer(value) if (self.low..=self.high).contains(&value) => Ok(value),
            _ => Err(self.refuse(node)),
        }
    }
}

/// true or false.
#[derive(Clone, Copy, Debug)]
pub struct Flag;

/// true or false.
pub fn flag() -> Flag {
    Flag
}

impl Rule for Flag {
    type Out = bool;

    fn expected(&self) -> String {
        "true or false".into()
    }

    fn take(&self, node: &Node) -> Result<bool, Mismatch> {
        match node.value {
            Value::Flag(value) => Ok(value),
            _ => Err(self.refuse(node)),
        }
    }
}

/// A text.
#[derive(Clone, Copy, Debug)]
pub struct Text;

/// A text that isn't empty.
pub fn text() -> Text {
    Text
}

impl Rule for Text {
    type Out = String;

    fn expected(&self) -> String {
        "a text".into()
    }

    fn take(&self, node: &Node) -> Result<String, Mismatch> {
        match &node.value {
            Value::Text(text) if !text.trim().is_empty() => Ok(text.clone()),
            _ => Err(self.refuse(node)),
        }
    }
}

/// One of some words.
#[derive(Clone, Debug)]
pub struct OneOf<'a, T>(&'a [(&'a str, T)]);

/// One of some words, each with what it stands for.
pub fn one_of<'a, T: Clone>(choices: &'a [(&'a str, T)]) -> OneOf<'a, T> {
    OneOf(choices)
}

impl<T: Clone> Rule for OneOf<'_, T> {
    type Out = T;

    fn expected(&self) -> String {
        let words: Vec<_> = self.0.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        words.join(" or ")
    }

    fn take(&self, node: &Node) -> Result<T, Mismatch> {
        let Value::Text(text) = &node.value else { return Err(self.refuse(node)) };
        if let Some((_, meaning)) = self.0.iter().find(|(word, _)| word == text) {
            return Ok(meaning.clone());
        }
        let mut mismatch = self.refuse(node);
        let advice = advice(text, self.0.iter().map(|(word, _)| *word));
        if advice.contains("did you mean") {
            mismatch.found += &advice;
        }
        Err(mismatch)
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
}

impl<R: Rule> Rule for &R {
    type Out = R::Out;

    fn expected(&self) -> String {
        (*self).expected()
    }

    fn take(&self, node: &Node) -> Result<R::Out, Mismatch> {
        (*self).take(node)
    }
}

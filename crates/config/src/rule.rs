//! What a value must be, in words and in code.

use std::{fmt::Display, marker::PhantomData};

use crate::{About, Node, Place, Value, suggestion};

/// Turns a value into what the reader needs, or says what it should have been.
pub trait Rule {
    /// What the reader gets.
    type Out;

    /// In words, after "must be".
    fn expected(&self) -> String;

    /// The value, if it fits.
    fn take(&self, node: &Node) -> Result<Self::Out, Mismatch>;

    /// A value as a file has it, in TOML: what [`take`](Self::take) takes for it.
    fn written(&self, value: &Self::Out) -> String;

    /// With what the value means, in words that stand in a table: "share of the extrinsic part". A
    /// unit is in the key's name or in these.
    fn about(self, meaning: &'static str) -> About<Self>
    where
        Self: Sized,
    {
        About::new(self, meaning)
    }

    /// What the value means; empty if nobody says.
    fn meaning(&self) -> &'static str {
        ""
    }

    /// What the value must be, with what is checked after the rule.
    fn range(&self) -> String {
        self.expected()
    }

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
    /// The place of the part that is wrong.
    pub place: Place,
    /// `[2]` for a list's third value; empty for the whole.
    pub part: String,
    /// What would have been right, in words.
    pub expected: String,
    /// What stands there, in words.
    pub found: String,
}

/// A number within bounds.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    low: f64,
    high: f64,
    /// Whether it must be above `low`.
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

impl Number {
    /// With an upper bound, which it may reach.
    #[must_use]
    pub fn up_to(self, high: f64) -> Self {
        Self { high, ..self }
    }
}

impl Rule for Number {
    type Out = f64;

    fn expected(&self) -> String {
        let Self { low, high, open } = self;
        match (*low == f64::MIN, *high == f64::MAX) {
            (true, true) => "a finite number".into(),
            (false, true) if *open => format!("a number above {}", bound(*low)),
            (false, true) => format!("a number of at least {}", bound(*low)),
            _ if *open => format!("a number above {}, up to {}", bound(*low), bound(*high)),
            _ => format!("a number from {} to {}", bound(*low), bound(*high)),
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

    fn written(&self, value: &f64) -> String {
        bound(*value)
    }
}

/// Without a row of zeros to count.
fn bound(value: f64) -> String {
    match value.abs() {
        size if size != 0.0 && !(1e-4..1e6).contains(&size) => format!("{value:e}"),
        _ => value.to_string(),
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

    fn written(&self, angle: &f64) -> String {
        bound(angle.to_degrees())
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

    fn written(&self, value: &i64) -> String {
        value.to_string()
    }
}

/// A whole number within bounds, as a Rust integer.
#[derive(Clone, Copy, Debug)]
pub struct Count<T> {
    whole: Integer,
    integer: PhantomData<T>,
}

/// A whole number between two bounds, which it may reach, as a Rust integer. `i64::MAX` is no bound.
pub fn count<T: TryFrom<i64> + Display>(low: i64, high: i64) -> Count<T> {
    Count { whole: integer(low, high), integer: PhantomData }
}

impl<T: TryFrom<i64> + Display> Rule for Count<T> {
    type Out = T;

    fn expected(&self) -> String {
        self.whole.expected()
    }

    fn take(&self, node: &Node) -> Result<T, Mismatch> {
        T::try_from(self.whole.take(node)?).map_err(|_| self.refuse(node))
    }

    fn written(&self, value: &T) -> String {
        value.to_string()
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

    fn written(&self, value: &bool) -> String {
        value.to_string()
    }
}

/// A rule for a text that isn't empty.
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
            Value::Text(text) if text.trim().is_empty() => {
                Err(Mismatch { expected: "a text that isn't empty".into(), ..self.refuse(node) })
            }
            Value::Text(text) => Ok(text.clone()),
            _ => Err(self.refuse(node)),
        }
    }

    fn written(&self, text: &String) -> String {
        format!("{text:?}")
    }
}

/// A rule for the name of a thing.
#[derive(Clone, Copy, Debug)]
pub struct Name;

/// Characters of a name at most: it's on one line of a message with something else.
const LONGEST_NAME: usize = 60;

/// A text that can be part of a message and of a path.
pub fn name() -> Name {
    Name
}

impl Name {
    /// What a name looks like.
    pub(crate) fn form() -> String {
        format!("1 to {LONGEST_NAME} characters on one line, without /")
    }

    /// Whether a text is a name.
    pub(crate) fn fits(text: &str) -> bool {
        !text.trim().is_empty()
            && text.chars().count() <= LONGEST_NAME
            && !text.chars().any(|character| character.is_control() || character == '/')
    }
}

impl Rule for Name {
    type Out = String;

    fn expected(&self) -> String {
        "a name".into()
    }

    fn take(&self, node: &Node) -> Result<String, Mismatch> {
        match &node.value {
            Value::Text(text) if Self::fits(text) => Ok(text.clone()),
            Value::Text(_) => Err(Mismatch { expected: Self::form(), ..self.refuse(node) }),
            _ => Err(self.refuse(node)),
        }
    }

    fn written(&self, name: &String) -> String {
        format!("{name:?}")
    }
}

/// One of some words.
#[derive(Clone, Debug)]
pub struct OneOf<'a, T>(&'a [(&'a str, T)]);

/// One of some words, each with what it stands for.
pub fn one_of<'a, T: Clone + PartialEq>(choices: &'a [(&'a str, T)]) -> OneOf<'a, T> {
    OneOf(choices)
}

impl<T: Clone + PartialEq> Rule for OneOf<'_, T> {
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
        mismatch.found += &suggestion(text, self.0.iter().map(|(word, _)| *word));
        Err(mismatch)
    }

    fn written(&self, value: &T) -> String {
        let word = self.0.iter().find(|(_, meaning)| meaning == value).map(|(word, _)| *word);
        format!("{:?}", word.unwrap_or_default())
    }
}

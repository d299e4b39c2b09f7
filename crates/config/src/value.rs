//! A TOML value with the place where it stands.

use std::{fmt, sync::Arc};

use toml::de::DeValue;

use crate::{Place, Problem};

/// A value and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Of its first character.
    pub place: Place,
    /// What stands there.
    pub value: Value,
}

/// A key and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Of its first character.
    pub place: Place,
    /// Without quotes.
    pub name: String,
}

/// TOML's types.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A string.
    Text(String),
    /// A whole number without a point.
    Integer(i64),
    /// A number with a point or an exponent, an infinity or NaN.
    Number(f64),
    /// true or false
    Flag(bool),
    /// A date or a time, as written. No rule takes one.
    Date(String),
    /// An array.
    List(Vec<Node>),
    /// A table, in the order of the file.
    Table(Vec<(Key, Node)>),
}

/// As an error message shows it: short, in TOML's spelling.
impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) if text.chars().count() > 60 => {
                write!(formatter, "a text of {} characters", text.chars().count())
            }
            Self::Text(text) => write!(formatter, "{text:?}"),
            Self::Integer(value) => write!(formatter, "{value}"),
            // With a point, so that 1.0 is told from 1; TOML writes NaN small.
            Self::Number(value) if value.is_nan() => write!(formatter, "nan"),
            Self::Number(value) => write!(formatter, "{value:?}"),
            Self::Flag(value) => write!(formatter, "{value}"),
            Self::Date(text) => write!(formatter, "the date {text}"),
            Self::List(nodes) if nodes.len() <= 6 && nodes.iter().all(is_plain) => {
                let items: Vec<_> = nodes.iter().map(|node| node.value.to_string()).collect();
                write!(formatter, "[{}]", items.join(", "))
            }
            Self::List(nodes) => write!(formatter, "a list of {}", nodes.len()),
            Self::Table(_) => write!(formatter, "a table"),
        }
    }
}

fn is_plain(node: &Node) -> bool {
    !matches!(node.value, Value::List(_) | Value::Table(_))
}

/// Tells line and column of a byte.
pub(crate) struct Lines<'a> {
    source: Arc<str>,
    text: &'a str,
    /// First byte of each line.
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(source: &str, text: &'a str) -> Self {
        let after_newlines = text.match_indices('\n').map(|(newline, _)| newline + 1);
        Self {
            source: source.into(),
            text,
            starts: [0].into_iter().chain(after_newlines).collect(),
        }
    }

    pub(crate) fn place(&self, byte: usize) -> Place {
        let line = self.starts.partition_point(|&start| start <= byte);
        let start = self.starts[line - 1];
        let before = self.text.get(start..byte.min(self.text.len())).unwrap_or_default();
        Place { source: self.source.clone(), line, column: before.chars().count() + 1 }
    }

    /// What the TOML parser found, as ours. Numbers beyond 64 bits become problems.
    pub(crate) fn node(
        &self,
        value: &toml::Spanned<DeValue<'_>>,
        problems: &mut Vec<Problem>,
    ) -> Node {
        let place = self.place(value.span().start);
        let mut too_large = |written: &str| {
            let message = format!("a number of 64 bits expected, got {written}");
            problems.push(Problem { place: place.clone(), message });
        };
        let value = match value.get_ref() {
            DeValue::String(text) => Value::Text(text.to_string()),
            DeValue::Integer(written) => {
                let parsed = i64::from_str_radix(written.as_str(), written.radix());
                Value::Integer(parsed.unwrap_or_else(|_| {
                    too_large(&written.to_string());
                    0
                }))
            }
            DeValue::Float(written) => {
                let parsed: f64 = written.as_str().parse().unwrap_or(f64::NAN);
                if parsed.is_infinite() && !written.as_str().contains("inf") {
                    too_large(written.as_str());
                }
                Value::Number(parsed)
            }
            DeValue::Boolean(value) => Value::Flag(*value),
            DeValue::Datetime(date) => Value::Date(date.to_string()),
            DeValue::Array(items) => {
                Value::List(items.iter().map(|item| self.node(item, problems)).collect())
            }
            DeValue::Table(table) => Value::Table(self.entries(table, problems)),
        };
        Node { place, value }
    }

    pub(crate) fn entries(
        &self,
        table: &toml::de::DeTable<'_>,
        problems: &mut Vec<Problem>,
    ) -> Vec<(Key, Node)> {
        let entry = |(key, value): (&toml::Spanned<_>, &_)| {
            let name: &std::borrow::Cow<'_, str> = key.get_ref();
            let key = Key { place: self.place(key.span().start), name: name.to_string() };
            (key, self.node(value, problems))
        };
        table.iter().map(entry).collect()
    }
}

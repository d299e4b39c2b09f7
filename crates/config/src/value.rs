//! A TOML value with the place where it stands.

use std::{fmt, sync::Arc};

use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

use crate::{Place, Problem};

/// A value and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The place of its first character.
    pub place: Place,
    /// The value that stands there.
    pub value: Value,
}

/// A key and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// The place of its first character.
    pub place: Place,
    /// The key's text, without its quotes.
    pub name: String,
}

/// As error messages show it.
impl fmt::Display for Key {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&shown(&self.name))
    }
}

/// A value of one of TOML's types.
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

/// Levels that tables and lists may lie in each other. Dotted keys in inline tables would take the
/// TOML parser's own limit of 80 to thousands, too many for what goes down them call by call.
pub(crate) const DEEPEST: usize = 32;
pub(crate) const TOO_DEEP: &str =
    "at most 32 tables and lists within each other expected, got more";

/// Characters of a text that a message shows.
const SHOWN: usize = 60;

/// A text as error messages show it: on one line, and not all of a long one.
#[must_use]
pub fn shown(text: &str) -> String {
    let (head, more) = match text.char_indices().nth(SHOWN) {
        Some((end, _)) => (&text[..end], "..."),
        None => (text, ""),
    };
    let quoted = format!("{head:?}");
    format!("{}{more}", &quoted[1..quoted.len() - 1])
}

/// As error messages show it: short, in TOML's spelling.
impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => write!(formatter, "\"{}\"", shown(text)),
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
pub(crate) struct Lines {
    source: Arc<str>,
    /// First byte of each line.
    starts: Vec<usize>,
    /// The bytes that don't begin a character.
    inner: Vec<usize>,
}

impl Lines {
    pub(crate) fn new(source: &str, text: &str) -> Self {
        let after_newlines = text.match_indices('\n').map(|(newline, _)| newline + 1);
        Self {
            source: source.into(),
            starts: [0].into_iter().chain(after_newlines).collect(),
            inner: (0..text.len()).filter(|&byte| !text.is_char_boundary(byte)).collect(),
        }
    }

    pub(crate) fn place(&self, byte: usize) -> Place {
        let line = self.starts.partition_point(|&start| start <= byte);
        let start = self.starts[line - 1];
        let inner_before = |end| self.inner.partition_point(|&inner| inner < end);
        let column = 1 + byte - start - (inner_before(byte) - inner_before(start));
        Place { source: self.source.clone(), line, column }
    }

    /// What the TOML parser found, as ours; what can't be is a problem.
    pub(crate) fn root(&self, table: &DeTable<'_>, problems: &mut Vec<Problem>) -> Node {
        Node { place: self.place(0), value: Value::Table(self.entries(table, 0, problems)) }
    }

    /// A single value, likewise.
    pub(crate) fn value(&self, value: &Spanned<DeValue<'_>>, problems: &mut Vec<Problem>) -> Node {
        self.node(value, 0, problems)
    }

    fn node(
        &self,
        value: &Spanned<DeValue<'_>>,
        depth: usize,
        problems: &mut Vec<Problem>,
    ) -> Node {
        let place = self.place(value.span().start);
        let mut complain = |message| problems.push(Problem { place: place.clone(), message });
        let too_large = |written: &str| {
            format!("a number that 64 bits can hold expected, got {}", shown(written))
        };
        let value = match value.get_ref() {
            DeValue::Array(_) | DeValue::Table(_) if depth == DEEPEST => {
                complain(TOO_DEEP.into());
                Value::List(Vec::new())
            }
            DeValue::String(text) => Value::Text(text.to_string()),
            DeValue::Integer(written) => {
                let parsed = i64::from_str_radix(written.as_str(), written.radix());
                Value::Integer(parsed.unwrap_or_else(|_| {
                    complain(too_large(&written.to_string()));
                    0
                }))
            }
            DeValue::Float(written) => {
                let parsed: f64 = written.as_str().parse().unwrap_or(f64::NAN);
                if parsed.is_infinite() && !written.as_str().contains("inf") {
                    complain(too_large(written.as_str()));
                }
                Value::Number(parsed)
            }
            DeValue::Boolean(value) => Value::Flag(*value),
            DeValue::Datetime(date) => Value::Date(date.to_string()),
            DeValue::Array(items) => {
                Value::List(items.iter().map(|item| self.node(item, depth + 1, problems)).collect())
            }
            DeValue::Table(table) => Value::Table(self.entries(table, depth + 1, problems)),
        };
        Node { place, value }
    }

    fn entries(
        &self,
        table: &DeTable<'_>,
        depth: usize,
        problems: &mut Vec<Problem>,
    ) -> Vec<(Key, Node)> {
        let mut entries = Vec::with_capacity(table.len());
        for (key, value) in table {
            let place = self.place(key.span().start);
            let key = Key { place, name: key.get_ref().to_string() };
            entries.push((key, self.node(value, depth, problems)));
        }
        entries
    }
}

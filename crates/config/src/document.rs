//! A whole file.

use std::{fs::File, io::Read, path::Path};

use toml::de::{DeTable, DeValue};

use crate::{
    Key, Node, Place, Problem, Problems, Section, Value, shown,
    value::{DEEPEST, Lines, TOO_DEEP},
};

/// Bytes that a file may have: thousands of times what a model or an experiment takes.
pub const LARGEST_FILE: u64 = 1 << 20;

/// A TOML file as it was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    root: Node,
}

impl Document {
    /// Reads and parses a file; problems name it as it's given here.
    pub fn open(path: &Path) -> Result<Self, Problems> {
        let source = path.display().to_string();
        let bytes = read_bytes(path).map_err(|error| {
            Problems::one(Place::whole(&source), format!("can't be read: {error}"))
        })?;
        if bytes.len() as u64 > LARGEST_FILE {
            let place = Place { source: source.as_str().into(), line: 1, column: 1 };
            return Err(Problems::one(place, "a TOML file of at most 1 MiB expected, got more"));
        }
        match str::from_utf8(&bytes) {
            Ok(text) => Self::parse(&source, text),
            Err(error) => {
                let (good, bad) = bytes.split_at(error.valid_up_to());
                let good = String::from_utf8_lossy(good);
                let place = Lines::new(&source, &good).place(good.len());
                let message = format!("text in UTF-8 expected, got the byte 0x{:02x}", bad[0]);
                Err(Problems::one(place, message))
            }
        }
    }

    /// Parses a text; problems name it `source`.
    pub fn parse(source: &str, text: &str) -> Result<Self, Problems> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let lines = Lines::new(source, text);
        let (table, errors) = DeTable::parse_recoverable(text);
        let mut problems: Vec<_> =
            errors.iter().map(|error| not_toml(error, &lines, text)).collect();
        if !problems.is_empty() {
            // What the parser stumbles over further on in a line mostly follows from the first.
            problems.sort();
            problems.dedup_by_key(|problem| problem.place.line);
            return Err(Problems::new(problems));
        }
        let root = lines.root(table.get_ref(), &mut problems);
        if problems.is_empty() { Ok(Self { root }) } else { Err(Problems::new(problems)) }
    }

    /// Overrides one value, as in `learning.rate=0.3`: a key path, an equals sign and a value in
    /// TOML. Later problems with it name `source` and this text.
    pub fn set(&mut self, source: &str, assignment: &str) -> Result<(), Problems> {
        let place = Place::whole(&format!("{source} {assignment}"));
        let (path, text) = match assignment.split_once('=') {
            Some((path, text)) if path.split('.').all(|name| !name.trim().is_empty()) => {
                (path, text.trim())
            }
            _ => {
                let message = format!("key=value expected, as in {source} learning.rate=0.3");
                return Err(Problems::one(place, message));
            }
        };
        let value = DeValue::parse(text).map_err(|error| {
            let message = format!(
                "a value in TOML expected (a text in quotes), got {}: {}",
                shown(text),
                error.message()
            );
            Problems::one(place.clone(), message)
        })?;
        let mut problems = Vec::new();
        let mut node = Lines::new(source, text).value(&value, &mut problems);
        if !problems.is_empty() {
            problems.iter_mut().for_each(|problem| problem.place = place.clone());
            return Err(Problems::new(problems));
        }
        move_to(&mut node, &place);
        self.replace(path, &place, node)
    }

    /// Puts a value at a path of keys with dots between, in place of what stood there. Keys that
    /// aren't there yet are made, at `place`.
    ///
    /// # Errors
    /// A path through something that isn't a table, or of more keys than tables may lie in each other.
    pub fn replace(&mut self, path: &str, place: &Place, node: Node) -> Result<(), Problems> {
        let names: Vec<&str> = path.split('.').map(str::trim).collect();
        if names.len() > DEEPEST {
            return Err(Problems::one(place.clone(), TOO_DEEP));
        }
        match slot(&mut self.root, &names, place) {
            Some(slot) => *slot = node,
            None => {
                let message = format!("{} lies within something that isn't a table", shown(path));
                return Err(Problems::one(place.clone(), message));
            }
        }
        Ok(())
    }

    /// Takes a table or value out of the document's top level.
    pub fn take(&mut self, key: &str) -> Option<Node> {
        let Value::Table(entries) = &mut self.root.value else { return None };
        let index = entries.iter().position(|(found, _)| found.name == key)?;
        Some(entries.remove(index).1)
    }

    /// Hands the top level to a reader.
    ///
    /// # Errors
    /// All problems that the reader met, keys that it didn't ask for among them. A reader that
    /// gives None must have met one.
    pub fn read<T>(
        &self,
        reader: impl FnOnce(&mut Section<'_>) -> Option<T>,
    ) -> Result<T, Problems> {
        Section::read_root(&self.root, reader)
    }

    /// The value at a path of keys with dots between.
    pub fn get(&self, path: &str) -> Option<&Node> {
        path.split('.').try_fold(&self.root, |node, name| match &node.value {
            Value::Table(entries) => {
                entries.iter().find(|(key, _)| key.name == name).map(|(_, node)| node)
            }
            _ => None,
        })
    }
}

fn not_toml(error: &toml::de::Error, lines: &Lines, text: &str) -> Problem {
    let span = error.span().unwrap_or_default();
    let message = match (error.message(), text.get(span.clone()).unwrap_or_default()) {
        (message, _) if message.contains("recurs") => TOO_DEEP.into(),
        // The parser takes nothing for a text without quotes.
        (message, "") if message.starts_with("string values must be quoted") => {
            "not TOML: a value expected, got nothing".into()
        }
        (message, "") => format!("not TOML: {message}"),
        (message, found) => format!("not TOML: {message}, got `{}`", shown(found)),
    };
    Problem { place: lines.place(span.start), message }
}

/// What stands at a path, with tables and an empty one in the end made where nothing does.
fn slot<'a>(node: &'a mut Node, path: &[&str], place: &Place) -> Option<&'a mut Node> {
    let Some((first, rest)) = path.split_first() else { return Some(node) };
    let Value::Table(entries) = &mut node.value else { return None };
    let index = entries.iter().position(|(key, _)| key.name == *first).unwrap_or_else(|| {
        let key = Key { place: place.clone(), name: (*first).into() };
        entries.push((key, Node { place: place.clone(), value: Value::Table(Vec::new()) }));
        entries.len() - 1
    });
    slot(&mut entries[index].1, rest, place)
}

/// Never more than one byte beyond the limit, whatever the file is.
fn read_bytes(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(LARGEST_FILE + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A value from the command line has no lines.
fn move_to(node: &mut Node, place: &Place) {
    node.place = place.clone();
    match &mut node.value {
        Value::List(items) => items.iter_mut().for_each(|item| move_to(item, place)),
        Value::Table(entries) => {
            for (key, node) in entries {
                key.place = place.clone();
                move_to(node, place);
            }
        }
        _ => {}
    }
}

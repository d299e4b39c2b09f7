//! A whole file.

use std::{fs::File, io::Read, path::Path};

use toml::de::{DeTable, DeValue};

use crate::{
    Key, Node, Place, Problem, Problems, Section, Value,
    foreign::foreign,
    section::Reading,
    shown,
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
        Self::parse(&path.display().to_string(), &read_text(path)?)
    }

    /// Parses a text; problems name it `source`.
    pub fn parse(source: &str, text: &str) -> Result<Self, Problems> {
        let text = without_mark(text);
        refuse_foreign(source, text)?;
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
    ///
    /// # Errors
    /// What isn't an assignment, and all that [`Document::set_value`] refuses.
    pub fn set(&mut self, source: &str, assignment: &str) -> Result<(), Problems> {
        let place = Place::whole(&format!("{source} {assignment}"));
        match assignment.split_once('=') {
            Some((path, text)) if path.split('.').all(|name| !name.trim().is_empty()) => {
                self.set_value(&place, path, text.trim())
            }
            _ => {
                let message = format!("key=value expected, as in {source} learning.rate=0.3");
                Err(Problems::one(place, message))
            }
        }
    }

    /// Overrides the value at a path of keys with dots between by one in TOML; problems name
    /// `place`, which has no line. Of a table the keys that it has are overridden, and no others.
    ///
    /// # Errors
    /// What isn't a value, an empty table, a path through something that isn't a table, and what has
    /// been overridden before.
    pub fn set_value(&mut self, place: &Place, path: &str, text: &str) -> Result<(), Problems> {
        let value = DeValue::parse(text).map_err(|error| {
            let message = format!(
                "a value in TOML expected (a text in quotes), got {}: {}",
                shown(text),
                error.message()
            );
            Problems::one(place.clone(), message)
        })?;
        let mut problems = Vec::new();
        let mut node = Lines::new("", text).value(&value, &mut problems);
        move_to(&mut node, place);
        if problems.is_empty() {
            let path: Vec<_> = path.split('.').map(|name| name.trim().to_owned()).collect();
            self.merge(&path, node, &mut problems);
        }
        if problems.is_empty() {
            return Ok(());
        }
        problems.iter_mut().for_each(|problem| problem.place = place.clone());
        Err(Problems::new(problems))
    }

    /// Puts a value from the command line at a path, of a table each of its own values.
    fn merge(&mut self, path: &[String], node: Node, problems: &mut Vec<Problem>) {
        let place = node.place.clone();
        let name = path.join(".");
        let found = match node.value {
            Value::Table(entries) if entries.is_empty() => {
                Err(format!("{} must be a value or a table with keys, got {{}}", shown(&name)))
            }
            Value::Table(entries) => {
                for (key, node) in entries {
                    self.merge(&[path, &[key.name]].concat(), node, problems);
                }
                Ok(())
            }
            _ => match find(&self.root, path).and_then(overridden) {
                Some(other) => {
                    Err(format!("{} is set by {other}, too: one has to go", shown(&name)))
                }
                None => self.put(path, &place, node),
            },
        };
        problems.extend(found.err().map(|message| Problem { place, message }));
    }

    /// Puts a value at a path of keys with dots between, in place of what stood there. Keys that
    /// aren't there yet are made, at `place`.
    ///
    /// # Errors
    /// A path through something that isn't a table, or of more keys than tables may lie in each other.
    pub fn replace(&mut self, path: &str, place: &Place, node: Node) -> Result<(), Problems> {
        let names: Vec<_> = path.split('.').collect();
        self.put(&names, place, node).map_err(|message| Problems::one(place.clone(), message))
    }

    fn put<S: AsRef<str>>(&mut self, path: &[S], place: &Place, node: Node) -> Result<(), String> {
        if path.len() > DEEPEST {
            return Err(TOO_DEEP.into());
        }
        let Some(slot) = slot(&mut self.root, path, place) else {
            let names: Vec<_> = path.iter().map(AsRef::as_ref).collect();
            let path = names.join(".");
            return Err(format!("{} lies within something that isn't a table", shown(&path)));
        };
        *slot = node;
        Ok(())
    }

    /// The top level.
    pub(crate) fn root_mut(&mut self) -> &mut Node {
        &mut self.root
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
        let reading = Reading::default();
        let made = Section::read_root(&self.root, &reading, reader);
        let problems = reading.into_problems();
        match made {
            Some(made) if problems.is_empty() => Ok(made),
            _ => Err(Problems::new(problems)),
        }
    }

    /// The value at a path of keys with dots between.
    pub fn get(&self, path: &str) -> Option<&Node> {
        find(&self.root, &path.split('.').collect::<Vec<_>>())
    }
}

/// What stands at a path.
fn find<'a, S: AsRef<str>>(root: &'a Node, path: &[S]) -> Option<&'a Node> {
    if path.is_empty() {
        return Some(root);
    }
    let Value::Table(entries) = &root.value else { return None };
    let (index, names) = next(entries, path)?;
    find(&entries[index].1, &path[names..])
}

/// The entry that a path goes through, and how many of its names that takes: one, or more where a key
/// has dots in itself, as `"reward.mix.xi"` in a sweep.
fn next<S: AsRef<str>>(entries: &[(Key, Node)], path: &[S]) -> Option<(usize, usize)> {
    let mut name = String::new();
    path.iter().enumerate().find_map(|(last, part)| {
        name += if last == 0 { "" } else { "." };
        name += part.as_ref();
        Some((entries.iter().position(|(key, _)| key.name == name)?, last + 1))
    })
}

/// A file's text, if it can be TOML; problems name the file as it's given here.
///
/// # Errors
/// What can't be read, is larger than [`LARGEST_FILE`], isn't text, or is in another format.
pub fn read_text(path: &Path) -> Result<String, Problems> {
    let source = path.display().to_string();
    let bytes = read_bytes(path)
        .map_err(|error| Problems::one(Place::whole(&source), format!("can't be read: {error}")))?;
    // Before its size and its letters, which may be wrong because of what it is.
    refuse_foreign(&source, without_mark(&String::from_utf8_lossy(&bytes)))?;
    if bytes.len() as u64 > LARGEST_FILE {
        let place = Place { source: source.as_str().into(), line: 1, column: 1 };
        return Err(Problems::one(place, "a TOML file of at most 1 MiB expected, got more"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let (good, bad) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
        let good = String::from_utf8_lossy(good);
        let place = Lines::new(&source, &good).place(good.len());
        let message = format!("text in UTF-8 expected, got the byte 0x{:02x}", bad[0]);
        Problems::one(place, message)
    })
}

/// A byte order mark isn't a character of the text.
fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

fn refuse_foreign(source: &str, text: &str) -> Result<(), Problems> {
    foreign(text).map_or(Ok(()), |(start, what)| {
        let place = Lines::new(source, text).place(start);
        Err(Problems::one(place, format!("a file in TOML expected, got {what}")))
    })
}

/// Where a value, or one within it, comes from, if that's the command line, which has no lines.
fn overridden(node: &Node) -> Option<&Place> {
    match &node.value {
        Value::Table(entries) => entries.iter().find_map(|(_, node)| overridden(node)),
        _ => (node.place.line == 0).then_some(&node.place),
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
fn slot<'a, S: AsRef<str>>(node: &'a mut Node, path: &[S], place: &Place) -> Option<&'a mut Node> {
    let Some((first, rest)) = path.split_first() else { return Some(node) };
    let Value::Table(entries) = &mut node.value else { return None };
    if let Some((index, names)) = next(entries, path) {
        return slot(&mut entries[index].1, &path[names..], place);
    }
    let key = Key { place: place.clone(), name: first.as_ref().into() };
    entries.push((key, Node { place: place.clone(), value: Value::Table(Vec::new()) }));
    slot(&mut entries.last_mut()?.1, rest, place)
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

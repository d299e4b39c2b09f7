//! A table that is asked for its keys.

use std::cell::RefCell;

use crate::{
    Key, MOST_PROBLEMS, Mismatch, Node, Place, Problem, Problems, Rule, Value, rule::Name,
};

/// Keys more alike than this (0 to 1, Jaro-Winkler) are taken for misspellings.
const ALIKE: f64 = 0.8;

/// Bytes; longer texts aren't misspelt names.
const LONGEST_COMPARED: usize = 256;

/// A table being read. Problems are collected; what was asked for is known.
pub struct Section<'a> {
    entries: &'a [(Key, Node)],
    place: Place,
    /// What messages about it begin with: `joint 'knee': `.
    subject: String,
    asked: Vec<String>,
    /// Keys that stand here too, and aren't read here.
    elsewhere: Vec<String>,
    accepts_all: bool,
    problems: &'a RefCell<Vec<Problem>>,
}

impl<'a> Section<'a> {
    pub(crate) fn read_root<T>(
        root: &Node,
        reader: impl FnOnce(&mut Section<'_>) -> Option<T>,
    ) -> Result<T, Problems> {
        let problems = RefCell::new(Vec::new());
        let made = Section::read(root, String::new(), &problems, reader);
        let problems = problems.into_inner();
        match made {
            Some(made) if problems.is_empty() => Ok(made),
            _ => Err(Problems::new(problems)),
        }
    }

    /// Reads one table from its first key to the complaint about those that nobody asked for.
    fn read<T>(
        node: &Node,
        subject: String,
        problems: &RefCell<Vec<Problem>>,
        reader: impl FnOnce(&mut Section<'_>) -> Option<T>,
    ) -> Option<T> {
        let Value::Table(entries) = &node.value else { return None };
        let place = node.place.clone();
        let mut section = Section {
            entries,
            place,
            subject,
            asked: Vec::new(),
            elsewhere: Vec::new(),
            accepts_all: false,
            problems,
        };
        let made = reader(&mut section);
        if !section.accepts_all {
            section.refuse_unknown_keys();
        }
        made
    }

    fn refuse_unknown_keys(&self) {
        for (key, _) in self.entries {
            if self.has_enough() {
                break;
            }
            if !self.asked.contains(&key.name) {
                let known = self.asked.iter().chain(&self.elsewhere).map(String::as_str);
                let advice = advice(&key.name, known);
                let message = format!("unknown key '{key}'{advice}");
                // Line and column say which table it is, but not what is called there; and the
                // command line has none.
                if key.place.line > 0 && !self.subject.contains('\'') {
                    let place = key.place.clone();
                    self.problems.borrow_mut().push(Problem { place, message });
                } else {
                    self.complain(&key.place, message);
                }
            }
        }
    }

    /// One more problem than is shown tells that there are more.
    fn has_enough(&self) -> bool {
        self.problems.borrow().len() > MOST_PROBLEMS
    }

    /// What stands at a key.
    fn node(&self, key: &str) -> Option<&'a Node> {
        self.entries.iter().find(|(found, _)| found.name == key).map(|(_, node)| node)
    }

    /// What stands at a key, which is known from now on.
    fn find(&mut self, key: &str) -> Option<&'a Node> {
        if !self.asked.iter().any(|asked| asked == key) {
            self.asked.push(key.into());
        }
        self.node(key)
    }

    /// What messages about this table begin with from now on, as in `joint 'knee'`.
    pub fn call(&mut self, subject: impl Into<String>) {
        self.subject = subject.into() + ": ";
    }

    /// The place at which the table begins.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// Where a key's value stands, or the table if there is none.
    pub fn place_of(&self, key: &str) -> Place {
        self.node(key).map_or(&self.place, |node| &node.place).clone()
    }

    /// Whether a key is given.
    pub fn has(&self, key: &str) -> bool {
        self.node(key).is_some()
    }

    /// How many items a key's list or table has as it is written, those that don't fit among them;
    /// 0 for anything else. The key counts as asked for.
    pub fn count(&mut self, key: &str) -> usize {
        match self.find(key).map(|node| &node.value) {
            Some(Value::List(items)) => items.len(),
            Some(Value::Table(entries)) => entries.len(),
            _ => 0,
        }
    }

    /// Names a key that the file may have here and whose value has been taken out of it: what is like
    /// it is a misspelling of it.
    pub fn mention(&mut self, key: &str) {
        self.elsewhere.push(key.into());
    }

    /// Takes all keys for known: where it can't be told which of them are.
    pub fn accept_all(&mut self) {
        self.accepts_all = true;
    }

    /// Adds a problem.
    pub fn complain(&self, place: &Place, message: impl AsRef<str>) {
        if !self.has_enough() {
            let message = format!("{}{}", self.subject, message.as_ref());
            self.problems.borrow_mut().push(Problem { place: place.clone(), message });
        }
    }

    /// Adds the problem that a key's value doesn't fit for a reason that no rule can see.
    pub fn refuse(&self, key: &str, expected: &str, found: impl std::fmt::Display) {
        let message = format!("{key} must be {expected}, got {found}");
        self.complain(&self.place_of(key), message);
    }

    /// Likewise, with the value as it's written for what was found.
    pub fn refuse_value(&self, key: &str, expected: &str) {
        match self.node(key) {
            Some(node) => self.refuse(key, expected, &node.value),
            None => self.refuse(key, expected, "nothing"),
        }
    }

    /// A value that must be there; None if it isn't or doesn't fit, which is then a problem.
    pub fn required<R: Rule>(&mut self, key: &str, rule: R) -> Option<R::Out> {
        if self.find(key).is_none() {
            self.miss(key, &rule.expected());
        }
        self.optional(key, rule)
    }

    /// A value that may be there; None if it isn't or, which is a problem, doesn't fit.
    pub fn optional<R: Rule>(&mut self, key: &str, rule: R) -> Option<R::Out> {
        let node = self.find(key)?;
        match rule.take(node) {
            Ok(value) => Some(value),
            Err(Mismatch { place, part, expected, found }) => {
                self.complain(&place, format!("{key}{part} must be {expected}, got {found}"));
                None
            }
        }
    }

    /// A value, or what it is by default.
    pub fn or<R: Rule>(&mut self, key: &str, rule: R, default: R::Out) -> R::Out {
        self.optional(key, rule).unwrap_or(default)
    }

    /// A value, or what it is by default if it isn't there; None if it doesn't fit. For values that
    /// others are checked against: a default in place of a bad one would only make more problems.
    pub fn given_or<R: Rule>(&mut self, key: &str, rule: R, default: R::Out) -> Option<R::Out> {
        let is_given = self.has(key);
        let value = self.optional(key, rule);
        if is_given { value } else { Some(default) }
    }

    /// A table that may be there.
    pub fn table<T>(
        &mut self,
        key: &str,
        reader: impl FnOnce(&mut Section<'_>) -> Option<T>,
    ) -> Option<T> {
        let node = self.find(key)?;
        let subject = format!("{}{key}: ", self.subject);
        self.expect_table(key, node).then(|| Section::read(node, subject, self.problems, reader))?
    }

    /// A table that must be there.
    pub fn required_table<T>(
        &mut self,
        key: &str,
        reader: impl FnOnce(&mut Section<'_>) -> Option<T>,
    ) -> Option<T> {
        if self.find(key).is_none() {
            self.miss(key, "a table");
        }
        self.table(key, reader)
    }

    /// A table whose keys all have defaults: read as an empty one if it isn't there.
    pub fn table_or_empty<T>(
        &mut self,
        key: &str,
        reader: impl FnOnce(&mut Section<'_>) -> Option<T>,
    ) -> Option<T> {
        if self.find(key).is_some() {
            return self.table(key, reader);
        }
        let empty = Node { place: self.place.clone(), value: Value::Table(Vec::new()) };
        Section::read(&empty, format!("{}{key}: ", self.subject), self.problems, reader)
    }

    /// The tables of a list; none if there is no such key. Those that can't be read are problems.
    pub fn tables<T>(
        &mut self,
        key: &str,
        mut reader: impl FnMut(&mut Section<'_>) -> Option<T>,
    ) -> Vec<T> {
        let Some(node) = self.find(key) else { return Vec::new() };
        let Value::List(items) = &node.value else {
            let expected = "a list of tables, [{ ... }] or [[...]]";
            let message = format!("{key} must be {expected}, got {}", node.value);
            self.complain(&node.place, message);
            return Vec::new();
        };
        let mut made = Vec::new();
        for (i, item) in items.iter().enumerate() {
            let name = format!("{key}[{i}]");
            if self.expect_table(&name, item) {
                let subject = format!("{}{name}: ", self.subject);
                made.extend(Section::read(item, subject, self.problems, &mut reader));
            }
        }
        made
    }

    /// The entries of a table whose keys are names of the user's choice.
    pub fn named_tables<T>(
        &mut self,
        key: &str,
        mut reader: impl FnMut(&Key, &mut Section<'_>) -> Option<T>,
    ) -> Vec<T> {
        let Some(node) = self.find(key) else { return Vec::new() };
        if !self.expect_table(key, node) {
            return Vec::new();
        }
        let Value::Table(entries) = &node.value else { return Vec::new() };
        let mut made = Vec::new();
        for (name, node) in entries {
            let path = format!("{key}.{name}");
            if !Name::fits(&name.name) {
                let message = format!("{key}.NAME must be {}, got \"{name}\"", Name::form());
                self.complain(&name.place, message);
            } else if self.expect_table(&path, node) {
                let subject = format!("{}{path}: ", self.subject);
                let read = |section: &mut Section<'_>| reader(name, section);
                made.extend(Section::read(node, subject, self.problems, read));
            }
        }
        made
    }

    fn expect_table(&self, name: &str, node: &Node) -> bool {
        let fits = matches!(node.value, Value::Table(_));
        if !fits {
            self.complain(&node.place, format!("{name} must be a table, got {}", node.value));
        }
        fits
    }

    fn miss(&self, key: &str, expected: &str) {
        self.complain(&self.place, format!("'{key}' is missing: {expected}"));
    }
}

/// `, did you mean 'x'?`, or the list of what there is if nothing is alike.
fn advice<'a>(found: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    let suggestion = suggestion(found, known.clone());
    if !suggestion.is_empty() {
        return suggestion;
    }
    let names: Vec<_> = known.map(|name| format!("'{name}'")).collect();
    match names.len() {
        0 => ", expected none".into(),
        1 => format!(", expected {}", names[0]),
        _ => format!(", expected one of {}", names.join(", ")),
    }
}

/// `, did you mean 'x'?`, or nothing if nothing is alike.
#[must_use]
pub fn suggestion<'a>(found: &str, known: impl Iterator<Item = &'a str>) -> String {
    // Comparing takes the time of both lengths' product.
    if found.len() > LONGEST_COMPARED {
        return String::new();
    }
    known
        .map(|name| (strsim::jaro_winkler(found, name), name))
        .filter(|(likeness, _)| *likeness >= ALIKE)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map_or_else(String::new, |(_, name)| format!(", did you mean '{name}'?"))
}

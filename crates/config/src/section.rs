//! A table that is asked for its keys.

use std::cell::RefCell;

use crate::{Key, Mismatch, Node, Place, Problem, Problems, Rule, Value};

/// Keys more alike than this (0 to 1, Jaro-Winkler) are taken for misspellings.
const ALIKE: f64 = 0.8;

/// A table being read. Problems are collected; what was asked for is known.
pub struct Section<'a> {
    entries: &'a [(Key, Node)],
    place: Place,
    /// What messages about it begin with: `joint 'knee': `.
    subject: String,
    asked: Vec<String>,
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
        let mut section = Section { entries, place, subject, asked: Vec::new(), problems };
        let made = reader(&mut section);
        section.refuse_unknown_keys();
        made
    }

    fn refuse_unknown_keys(&self) {
        for (key, _) in self.entries {
            if !self.asked.contains(&key.name) {
                let advice = advice(&key.name, self.asked.iter().map(String::as_str));
                self.complain(&key.place, format!("unknown key '{}'{advice}", key.name));
            }
        }
    }

    fn find(&mut self, key: &str) -> Option<&'a Node> {
        if !self.asked.iter().any(|asked| asked == key) {
            self.asked.push(key.into());
        }
        self.entries.iter().find(|(found, _)| found.name == key).map(|(_, node)| node)
    }

    /// What messages about this table begin with from now on, as in `joint 'knee'`.
    pub fn call(&mut self, subject: impl Into<String>) {
        self.subject = subject.into() + ": ";
    }

    /// Where the table begins.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// Where a key's value stands, or the table if there is none.
    pub fn place_of(&self, key: &str) -> Place {
        let entry = self.entries.iter().find(|(found, _)| found.name == key);
        entry.map_or(&self.place, |(_, node)| &node.place).clone()
    }

    /// Whether a key is given.
    pub fn has(&self, key: &str) -> bool {
        self.entries.iter().any(|(found, _)| found.name == key)
    }

    /// Adds a problem.
    pub fn complain(&self, place: &Place, message: impl AsRef<str>) {
        let message = format!("{}{}", self.subject, message.as_ref());
        self.problems.borrow_mut().push(Problem { place: place.clone(), message });
    }

    /// Adds the problem that a key's value doesn't fit for a reason that no rule can see.
    pub fn refuse(&self, key: &str, expected: &str, found: impl std::fmt::Display) {
        let message = format!("{key} must be {expected}, got {found}");
        self.complain(&self.place_of(key), message);
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
            let message = format!("{key} must be a list of tables, got {}", node.value);
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
            let path = format!("{key}.{}", name.name);
            if self.expect_table(&path, node) {
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
pub(crate) fn advice<'a>(found: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    let likeness = |name: &str| strsim::jaro_winkler(found, name);
    let best = known.clone().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    match best {
        Some(best) if likeness(best) >= ALIKE => format!(", did you mean '{best}'?"),
        Some(_) => {
            let names: Vec<_> = known.map(|name| format!("'{name}'")).collect();
            format!(", expected one of {}", names.join(", "))
        }
        None => ", expected none".into(),
    }
}

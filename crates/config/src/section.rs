//! A table that is asked for its keys.

use std::cell::RefCell;

use crate::{
    Key, MOST_PROBLEMS, Mismatch, Node, Only, Place, Presence, Problem, Rule, Setting, Value,
    one_of, rule::Name,
};

/// Keys more alike than this (0 to 1, Jaro-Winkler) are taken for misspellings.
const ALIKE: f64 = 0.8;

/// Bytes; longer texts aren't misspelt names.
const LONGEST_COMPARED: usize = 256;

/// What all tables of a file share while it's read.
#[derive(Default)]
pub(crate) struct Reading {
    problems: RefCell<Vec<Problem>>,
    /// The keys that are asked for, if these are wanted, and not what stands there.
    settings: Option<RefCell<Vec<Setting>>>,
}

impl Reading {
    /// A reading that is after the keys.
    pub(crate) fn of_settings() -> Self {
        Self { settings: Some(RefCell::default()), ..Self::default() }
    }

    /// The keys that were asked for, in that order.
    pub(crate) fn into_settings(self) -> Vec<Setting> {
        self.settings.map(RefCell::into_inner).unwrap_or_default()
    }

    /// The problems that were met.
    pub(crate) fn into_problems(self) -> Vec<Problem> {
        self.problems.into_inner()
    }
}

/// A table being read. Problems are collected; what was asked for is known.
pub struct Section<'a> {
    entries: &'a [(Key, Node)],
    place: Place,
    /// What messages about it begin with: `joint 'knee': `.
    subject: String,
    /// What its keys have before them: `reward.mix.`.
    path: String,
    /// The kind whose keys are read: the key that chooses it, and its word.
    kind: Option<(String, String)>,
    asked: Vec<String>,
    /// Keys that stand here too, and aren't read here.
    elsewhere: Vec<String>,
    accepts_all: bool,
    reading: &'a Reading,
}

impl<'a> Section<'a> {
    /// Reads a file's top level.
    pub(crate) fn read_root<T>(
        root: &Node,
        reading: &Reading,
        reader: impl FnOnce(&mut Section<'_>) -> Option<T>,
    ) -> Option<T> {
        Section::of(root, reading)?.read(reader)
    }

    /// The table that a node is, with no name.
    fn of(node: &'a Node, reading: &'a Reading) -> Option<Self> {
        let Value::Table(entries) = &node.value else { return None };
        Some(Section {
            entries,
            place: node.place.clone(),
            subject: String::new(),
            path: String::new(),
            kind: None,
            asked: Vec::new(),
            elsewhere: Vec::new(),
            accepts_all: false,
            reading,
        })
    }

    /// Reads a table within this one, which messages call by `name`.
    fn read_inner<T>(
        &self,
        name: &str,
        node: &Node,
        reader: impl FnOnce(&mut Section<'_>) -> Option<T>,
    ) -> Option<T> {
        let mut inner = Section::of(node, self.reading)?;
        inner.subject = format!("{}{name}: ", self.subject);
        inner.path = format!("{}{name}.", self.path);
        inner.kind.clone_from(&self.kind);
        inner.read(reader)
    }

    /// Reads the table from its first key to the complaint about those that nobody asked for.
    fn read<T>(mut self, reader: impl FnOnce(&mut Section<'_>) -> Option<T>) -> Option<T> {
        let made = reader(&mut self);
        if !self.accepts_all {
            self.refuse_unknown_keys();
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
                    self.reading.problems.borrow_mut().push(Problem { place, message });
                } else {
                    self.complain(&key.place, message);
                }
            }
        }
    }

    /// One more problem than is shown tells that there are more.
    fn has_enough(&self) -> bool {
        self.reading.problems.borrow().len() > MOST_PROBLEMS
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
            self.reading.problems.borrow_mut().push(Problem { place: place.clone(), message });
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
        self.declare(key, &rule, |_| Presence::Required);
        if self.find(key).is_none() {
            self.miss(key, &rule.expected());
        }
        self.take(key, &rule)
    }

    /// A value that may be there; None if it isn't or, which is a problem, doesn't fit.
    pub fn optional<R: Rule>(&mut self, key: &str, rule: R) -> Option<R::Out> {
        self.declare(key, &rule, |_| Presence::Optional);
        self.take(key, &rule)
    }

    /// A value, or what it is by default.
    pub fn or<R: Rule>(&mut self, key: &str, rule: R, default: R::Out) -> R::Out {
        self.declare(key, &rule, |rule| Presence::Default(rule.written(&default)));
        self.take(key, &rule).unwrap_or(default)
    }

    /// A value, or what it is by default if it isn't there; None if it doesn't fit. For values that
    /// others are checked against: a default in place of a bad one would only make more problems.
    pub fn given_or<R: Rule>(&mut self, key: &str, rule: R, default: R::Out) -> Option<R::Out> {
        self.declare(key, &rule, |rule| Presence::Default(rule.written(&default)));
        let value = self.take(key, &rule);
        if self.has(key) { value } else { Some(default) }
    }

    /// A key that chooses among some kinds, each a word and what it is, and the other keys of the
    /// kind: what `reader` makes of them, which is told the word. The first kind is the default; None
    /// if another word stands there, and then nothing is said of other keys.
    pub fn kind<T>(
        &mut self,
        key: &str,
        about: &'static str,
        kinds: &[(&str, &str)],
        mut reader: impl FnMut(&mut Section<'_>, &str) -> Option<T>,
    ) -> Option<T> {
        let words: Vec<_> = kinds.iter().map(|&(word, _)| (word, word)).collect();
        let &(first, _) = words.first()?;
        if self.is_described() {
            return self.declare_kinds(key, about, kinds, reader);
        }
        match self.given_or(key, one_of(&words), first) {
            Some(word) => reader(self, word),
            None => {
                self.accept_all();
                None
            }
        }
    }

    /// A table that may be there.
    pub fn table<T>(
        &mut self,
        key: &str,
        reader: impl FnOnce(&mut Section<'_>) -> Option<T>,
    ) -> Option<T> {
        if self.is_described() {
            return self.table_or_empty(key, reader);
        }
        let node = self.find(key)?;
        self.expect_table(key, node).then(|| self.read_inner(key, node, reader))?
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
        self.read_inner(key, &empty, reader)
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
                made.extend(self.read_inner(&name, item, &mut reader));
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
                made.extend(self.read_inner(&path, node, |section| reader(name, section)));
            }
        }
        made
    }

    /// The value that stands at a key, if it fits; a problem if it doesn't.
    fn take<R: Rule>(&mut self, key: &str, rule: &R) -> Option<R::Out> {
        let node = self.find(key)?;
        match rule.take(node) {
            Ok(value) => Some(value),
            Err(Mismatch { place, part, expected, found }) => {
                self.complain(&place, format!("{key}{part} must be {expected}, got {found}"));
                None
            }
        }
    }

    /// Whether the keys are wanted, and not what stands there.
    fn is_described(&self) -> bool {
        self.reading.settings.is_some()
    }

    /// Takes down what a key is, if that is wanted.
    fn declare<R: Rule>(&self, key: &str, rule: &R, presence: impl FnOnce(&R) -> Presence) {
        let Some(settings) = &self.reading.settings else { return };
        let only = self.kind.clone().map(|(key, word)| Only { key, kinds: vec![word] });
        settings.borrow_mut().push(Setting {
            key: format!("{}{key}", self.path),
            about: rule.meaning().into(),
            expected: rule.range(),
            presence: presence(rule),
            only,
            kinds: Vec::new(),
        });
    }

    /// Takes down a key that chooses, and the keys of each of its kinds. Goes on with the first.
    fn declare_kinds<T>(
        &mut self,
        key: &str,
        about: &'static str,
        kinds: &[(&str, &str)],
        mut reader: impl FnMut(&mut Section<'_>, &str) -> Option<T>,
    ) -> Option<T> {
        let words: Vec<_> = kinds.iter().map(|&(word, _)| (word, word)).collect();
        self.given_or(key, one_of(&words).about(about), words.first()?.0);
        if let Some(chooses) = self.reading.settings.as_ref()?.borrow_mut().last_mut() {
            let owned = |&(word, about): &(&str, &str)| (word.to_owned(), about.to_owned());
            chooses.kinds = kinds.iter().map(owned).collect();
        }
        let around = self.kind.take();
        let made: Vec<_> = words
            .iter()
            .map(|(word, _)| {
                self.kind = Some((format!("{}{key}", self.path), (*word).to_owned()));
                reader(self, word)
            })
            .collect();
        self.kind = around;
        made.into_iter().next()?
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

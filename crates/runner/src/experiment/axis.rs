//! A swept key: its values, the keys that each of them sets, and what folders call it.

use std::collections::{BTreeMap, BTreeSet};

use config::{Key, Node, Place, Problem, Value};

use super::files::{INITIAL, MODEL, below, policy_names, stem};

/// The key of a swept table that names it, and sets nothing.
const LABEL: &str = "label";

/// Characters of a label at most.
const LONGEST_LABEL: usize = 60;

/// A swept key.
pub(super) struct Axis {
    /// With dots, from the top of the file.
    pub(super) key: String,
    pub(super) place: Place,
    /// What folders call it.
    pub(super) name: String,
    pub(super) points: Vec<Point>,
    /// The keys that are set by one value or another.
    pub(super) paths: BTreeSet<String>,
}

/// Keys that are set, none of them a table, each with its value.
type Leaves = Vec<(String, Node)>;

/// One of the values of a swept key.
pub(super) struct Point {
    pub(super) node: Node,
    /// What folders call it.
    pub(super) name: String,
    /// The keys that it sets.
    pub(super) leaves: Leaves,
}

impl Axis {
    /// Reads a key's values. Problems are added to `problems`.
    pub(super) fn read(
        key: &str,
        place: &Place,
        items: &[Node],
        problems: &mut Vec<Problem>,
    ) -> Self {
        let leaves: Vec<_> = items.iter().map(|item| leaves(key, item)).collect();
        let policies = policy_names(leaves.iter().flatten().filter_map(initial));
        let names: Vec<_> = items.iter().map(|item| name(key, item, &policies)).collect();
        let paths = leaves.iter().flatten().map(|(path, _)| path.clone()).collect();
        let parts = items.iter().zip(names).zip(leaves);
        let point =
            |((node, name), leaves): ((&Node, _), _)| Point { node: node.clone(), name, leaves };
        let points = parts.map(point).collect();
        let axis = Self { key: key.into(), place: place.clone(), name: key.into(), points, paths };
        axis.check(problems);
        axis
    }

    /// One of its values as folders call it: `xi=0.75`.
    pub(super) fn named(&self, point: &Point) -> String {
        format!("{}={}", self.name, point.name)
    }

    /// Refuses values that name the same folder, and those that set nothing or one key twice.
    fn check(&self, problems: &mut Vec<Problem>) {
        let mut complain = |place: &Place, i: usize, message: &str| {
            problems.push(in_sweep(place, format!("{}[{i}]{message}", self.key)));
        };
        let mut names: BTreeMap<&str, usize> = BTreeMap::new();
        for (i, Point { node, name, leaves }) in self.points.iter().enumerate() {
            let label = label(&node.value);
            if let Some(label) = label.filter(|label| !is_label(&label.value)) {
                let message = format!(
                    ".label must be 1 to {LONGEST_LABEL} letters, digits, '.', '_', '+', '-', got {}",
                    label.value
                );
                complain(&label.place, i, &message);
                continue;
            }
            // A label alone stands for what the rest of the file says, beside others that change it.
            if leaves.is_empty() && (label.is_none() || self.paths.is_empty()) {
                complain(&node.place, i, " must set at least one key, got none");
                continue;
            }
            if let Some(path) = set_twice(leaves) {
                complain(&node.place, i, &format!(" sets {path} twice"));
            }
            if let Some(other) = names.get(name.as_str()) {
                let hint = match node.value {
                    Value::Table(_) => "; labels of their own tell them apart",
                    _ => "",
                };
                let message = format!(" gives the same folder as [{other}], \"{name}\"{hint}");
                complain(&node.place, i, &message);
            } else {
                names.insert(name, i);
            }
        }
    }
}

/// What folders call a value.
fn name(key: &str, node: &Node, policies: &BTreeMap<&str, String>) -> String {
    match label(&node.value).map(|label| &label.value) {
        Some(Value::Text(label)) => label.clone(),
        _ => name_of(key, &node.value, policies),
    }
}

/// The path of a policy's file.
fn initial((key, node): &(String, Node)) -> Option<&str> {
    match &node.value {
        Value::Text(path) if key == INITIAL => Some(path),
        _ => None,
    }
}

/// What a swept table is called, if it says.
fn label(value: &Value) -> Option<&Node> {
    let Value::Table(entries) = value else { return None };
    entries.iter().find(|(key, _)| key.name == LABEL).map(|(_, node)| node)
}

fn is_label(value: &Value) -> bool {
    let Value::Text(text) = value else { return false };
    (1..=LONGEST_LABEL).contains(&text.len()) && safe(text) == *text
}

/// What a value sets.
fn leaves(key: &str, node: &Node) -> Leaves {
    let mut leaves = Vec::new();
    match &node.value {
        Value::Table(entries) => {
            for (inner, node) in entries.iter().filter(|(inner, _)| inner.name != LABEL) {
                collect_leaves(&below(key, &inner.name), node, &mut leaves);
            }
        }
        _ => leaves.push((key.into(), node.clone())),
    }
    leaves
}

fn collect_leaves(path: &str, node: &Node, leaves: &mut Leaves) {
    match &node.value {
        Value::Table(entries) => {
            for (key, node) in entries {
                collect_leaves(&below(path, &key.name), node, leaves);
            }
        }
        _ => leaves.push((path.into(), node.clone())),
    }
}

/// A key that is set twice by one value, which dots in quotes make possible.
fn set_twice(leaves: &[(String, Node)]) -> Option<&str> {
    let mut known = BTreeMap::new();
    leaves.iter().map(|(path, _)| path.as_str()).find(|path| {
        let twice = touched(&known, path).is_some();
        known.insert((*path).to_owned(), ());
        twice
    })
}

/// What is known of a key, or of one within it or around it.
pub(super) fn touched<'a, T>(known: &'a BTreeMap<String, T>, key: &str) -> Option<&'a T> {
    let ends = key.match_indices('.').map(|(dot, _)| dot).chain([key.len()]);
    let around = ends.filter_map(|end| known.get(&key[..end])).next();
    around.or_else(|| {
        let within = format!("{key}.");
        let (path, found) = known.range(within.clone()..).next()?;
        path.starts_with(&within).then_some(found)
    })
}

/// A value at a key as a part of a folder's name; policies' files are called as these names say.
fn name_of(key: &str, value: &Value, policies: &BTreeMap<&str, String>) -> String {
    match value {
        Value::Number(number) if number.fract() == 0.0 && number.abs() < 1e15 => number.to_string(),
        Value::List(items) => {
            let items = items.iter().map(|item| name_of(key, &item.value, policies));
            items.collect::<Vec<_>>().join("-")
        }
        Value::Table(entries) => {
            let entry = |(inner, node): &(Key, Node)| {
                let value = name_of(&below(key, &inner.name), &node.value, policies);
                format!("{}-{value}", safe(&inner.name))
            };
            entries.iter().map(entry).collect::<Vec<_>>().join("-")
        }
        Value::Text(path) if key == MODEL => safe(&stem(path)),
        Value::Text(path) if key == INITIAL => {
            policies.get(path.as_str()).cloned().unwrap_or_default()
        }
        Value::Text(text) => safe(text),
        other => safe(&other.to_string()),
    }
}

/// With nothing in it that a file system or a shell takes for something else.
pub(crate) fn safe(text: &str) -> String {
    let harmless = |c: char| c.is_ascii_alphanumeric() || "._+-".contains(c);
    text.chars().map(|c| if harmless(c) { c } else { '-' }).collect()
}

pub(super) fn in_sweep(place: &Place, message: String) -> Problem {
    Problem { place: place.clone(), message: format!("sweep: {message}") }
}

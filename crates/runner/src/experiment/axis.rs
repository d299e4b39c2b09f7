//! A swept key: its values, the keys that each of them sets, and what folders call it.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use config::{Key, Node, Place, Problem, Value};

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

/// One of the values of a swept key.
pub(super) struct Point {
    pub(super) node: Node,
    /// What folders call it.
    pub(super) name: String,
    /// The keys that it sets, none of them a table.
    pub(super) leaves: Vec<(String, Node)>,
}

impl Axis {
    /// Reads a key's values. Problems are added to `problems`.
    pub(super) fn read(
        key: &str,
        place: &Place,
        items: &[Node],
        problems: &mut Vec<Problem>,
    ) -> Self {
        let points: Vec<_> = items.iter().map(|item| Point::of(key, item)).collect();
        let leaves = points.iter().flat_map(|point| &point.leaves);
        let paths = leaves.map(|(path, _)| path.clone()).collect();
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

impl Point {
    fn of(key: &str, node: &Node) -> Self {
        let mut leaves = Vec::new();
        let name = match &node.value {
            Value::Table(entries) => {
                for (inner, node) in entries.iter().filter(|(inner, _)| inner.name != LABEL) {
                    collect_leaves(&format!("{key}.{}", inner.name), node, &mut leaves);
                }
                match label(&node.value).map(|label| &label.value) {
                    Some(Value::Text(label)) => label.clone(),
                    _ => name_of(&node.value),
                }
            }
            value => {
                leaves.push((key.into(), node.clone()));
                match value {
                    Value::Text(path) if key == "model" => {
                        let stem = Path::new(path).file_stem().unwrap_or_default();
                        safe(&stem.to_string_lossy())
                    }
                    value => name_of(value),
                }
            }
        };
        Self { node: node.clone(), name, leaves }
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

fn collect_leaves(path: &str, node: &Node, leaves: &mut Vec<(String, Node)>) {
    match &node.value {
        Value::Table(entries) => {
            for (key, node) in entries {
                collect_leaves(&format!("{path}.{}", key.name), node, leaves);
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

/// A value as a part of a folder's name.
fn name_of(value: &Value) -> String {
    match value {
        Value::Number(number) if number.fract() == 0.0 && number.abs() < 1e15 => number.to_string(),
        Value::List(items) => {
            let items: Vec<_> = items.iter().map(|item| name_of(&item.value)).collect();
            items.join("-")
        }
        Value::Table(entries) => {
            let entry =
                |(key, node): &(Key, Node)| format!("{}-{}", safe(&key.name), name_of(&node.value));
            entries.iter().map(entry).collect::<Vec<_>>().join("-")
        }
        Value::Text(text) => safe(text),
        other => safe(&other.to_string()),
    }
}

/// With nothing in it that a file system or a shell takes for something else.
pub(super) fn safe(text: &str) -> String {
    let harmless = |c: char| c.is_ascii_alphanumeric() || "._+-".contains(c);
    text.chars().map(|c| if harmless(c) { c } else { '-' }).collect()
}

pub(super) fn in_sweep(place: &Place, message: String) -> Problem {
    Problem { place: place.clone(), message: format!("sweep: {message}") }
}

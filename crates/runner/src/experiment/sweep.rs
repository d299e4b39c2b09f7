//! The table `sweep`: values for some keys, each combined with each, and seeds.
//!
//! A key is written with dots, in quotes or not, or as nested tables. A value that is a table sets
//! several keys together: `codec = [{ sensor_bits = 1 }, { sensor_bits = 2, actuator_bits = 2 }]`.

use std::{collections::BTreeSet, path::Path};

use config::{Document, Mismatch, Node, Place, Problem, Rule, Value};

use crate::rules::count;

/// Cells that a file may have.
pub const MOST_CELLS: usize = 100_000;

/// Characters of a folder's name: file systems take 255 bytes.
const LONGEST_NAME: usize = 200;

/// What is swept, in the order of the file.
pub(super) struct Sweep {
    pub(super) axes: Vec<Axis>,
    pub(super) seeds: Vec<u64>,
}

/// A swept key.
pub(super) struct Axis {
    /// With dots, from the top of the file.
    pub(super) key: String,
    place: Place,
    /// What folders call it.
    name: String,
    pub(super) points: Vec<Point>,
}

/// One of the values of a swept key.
pub(super) struct Point {
    pub(super) node: Node,
    /// What folders call it.
    name: String,
    /// The keys that it sets, none of them a table.
    leaves: Vec<(String, Node)>,
}

impl Sweep {
    /// Reads the table, if there is one. Problems are added to `problems`.
    pub(super) fn read(node: Option<&Node>, problems: &mut Vec<Problem>) -> Self {
        let mut sweep = Self { axes: Vec::new(), seeds: vec![1] };
        let Some(node) = node else { return sweep };
        let Value::Table(entries) = &node.value else {
            let message = format!("sweep must be a table, got {}", node.value);
            problems.push(Problem { place: node.place.clone(), message });
            return sweep;
        };
        for (key, node) in entries {
            if key.name == "seeds" {
                sweep.seeds = seeds(node).unwrap_or_else(|mismatch| {
                    problems.push(problem("seeds", mismatch));
                    vec![1]
                });
            } else {
                sweep.read_axes(&key.name, &key.place, node, problems);
            }
        }
        sweep.name_axes();
        sweep.check_size(&node.place, problems);
        sweep
    }

    fn read_axes(&mut self, path: &str, place: &Place, node: &Node, problems: &mut Vec<Problem>) {
        let items = match &node.value {
            Value::Table(entries) => {
                for (key, node) in entries {
                    self.read_axes(&format!("{path}.{}", key.name), &key.place, node, problems);
                }
                return;
            }
            Value::List(items) if !items.is_empty() => items,
            _ => {
                let message =
                    format!("{path} must be a list of at least one value, got {}", node.value);
                problems.push(in_sweep(&node.place, message));
                return;
            }
        };
        let axis = Axis {
            key: path.into(),
            place: place.clone(),
            name: path.into(),
            points: items.iter().map(|item| Point::new(path, item)).collect(),
        };
        axis.check(problems);
        if let Some((other, key)) = self.axes.iter().find_map(|other| {
            axis.paths().iter().find(|path| other.touches(path)).map(|path| (other, *path))
        }) {
            let message = format!("{key} is swept twice, by {} too", other.place);
            problems.push(in_sweep(place, message));
            return;
        }
        self.axes.push(axis);
    }

    /// By the last part of the key, where no other swept key ends in it.
    fn name_axes(&mut self) {
        let last = |key: &str| key.rsplit('.').next().unwrap_or(key).to_owned();
        let ends: Vec<_> = self.axes.iter().map(|axis| last(&axis.key)).collect();
        for (axis, end) in self.axes.iter_mut().zip(&ends) {
            let alone = ends.iter().filter(|other| *other == end).count() == 1;
            axis.name = safe(if alone { end } else { &axis.key });
        }
    }

    fn check_size(&self, place: &Place, problems: &mut Vec<Problem>) {
        let sizes = self.axes.iter().map(|axis| axis.points.len()).chain([self.seeds.len()]);
        let n_cells = sizes.fold(1, usize::saturating_mul);
        if n_cells > MOST_CELLS {
            let message = format!("sweep must make at most {MOST_CELLS} cells, got {n_cells}");
            problems.push(Problem { place: place.clone(), message });
        }
        let longest = |axis: &Axis| {
            let value = axis.points.iter().map(|point| point.name.len()).max().unwrap_or(0);
            axis.name.len() + value + 2
        };
        let length: usize = self.axes.iter().map(longest).sum();
        if length > LONGEST_NAME {
            let message = format!(
                "sweep must name folders with at most {LONGEST_NAME} characters, got {length}; \
                 sweep fewer keys or shorter values"
            );
            problems.push(Problem { place: place.clone(), message });
        }
    }

    /// Refuses keys that the rest of the file sets, or the command line.
    pub(super) fn check_against(&self, document: &Document, problems: &mut Vec<Problem>) {
        for axis in &self.axes {
            for key in axis.paths() {
                let Some(node) = document.get(key) else { continue };
                let message = match node.place.line {
                    0 => format!("{key} is swept by {}, so it can't be set", axis.place),
                    _ => format!("{key} is set here and swept in {}: one has to go", axis.place),
                };
                problems.push(Problem { place: node.place.clone(), message });
            }
        }
    }

    /// All combinations, the first key slowest: the point of each axis.
    pub(super) fn combinations(&self) -> impl Iterator<Item = Vec<&Point>> {
        let n: usize = self.axes.iter().map(|axis| axis.points.len()).product();
        (0..n).map(|index| {
            let mut rest = index;
            let digit = |axis: &'_ Axis| {
                let point = rest % axis.points.len();
                rest /= axis.points.len();
                point
            };
            let mut digits: Vec<_> = self.axes.iter().rev().map(digit).collect();
            digits.reverse();
            self.axes.iter().zip(digits).map(|(axis, digit)| &axis.points[digit]).collect()
        })
    }

    /// Every value once, with the first of all other keys: what is checked where combinations are
    /// too many, or not what is meant.
    pub(super) fn one_by_one(&self) -> impl Iterator<Item = Vec<&Point>> {
        let first = || self.axes.iter().map(|axis| &axis.points[0]).collect::<Vec<_>>();
        let others = self.axes.iter().enumerate().flat_map(move |(i, axis)| {
            axis.points[1..].iter().map(move |point| {
                let mut points = first();
                points[i] = point;
                points
            })
        });
        [first()].into_iter().chain(others)
    }

    /// Puts the values of a combination into a document.
    pub(super) fn put(
        &self,
        points: &[&Point],
        document: &mut Document,
        problems: &mut BTreeSet<Problem>,
    ) {
        for (axis, point) in self.axes.iter().zip(points) {
            for (key, node) in &point.leaves {
                if let Err(found) = document.replace(key, &axis.place, node.clone()) {
                    problems.extend(Vec::from(found));
                }
            }
        }
    }

    /// `xi=0.75,power=2`, or `base` where nothing is swept.
    pub(super) fn name(&self, points: &[&Point]) -> String {
        if points.is_empty() {
            return "base".into();
        }
        let named = self.axes.iter().zip(points);
        let parts: Vec<_> =
            named.map(|(axis, point)| format!("{}={}", axis.name, point.name)).collect();
        parts.join(",")
    }

    /// Paths of models are made absolute by `resolve`.
    pub(super) fn resolve_models(&mut self, resolve: impl Fn(&mut Node)) {
        for axis in self.axes.iter_mut().filter(|axis| axis.key == "model") {
            for point in &mut axis.points {
                resolve(&mut point.node);
                point.leaves.iter_mut().for_each(|(_, node)| resolve(node));
            }
        }
    }
}

impl Axis {
    /// The keys that are set by one value or another.
    pub(super) fn paths(&self) -> BTreeSet<&str> {
        let leaves = self.points.iter().flat_map(|point| &point.leaves);
        leaves.map(|(path, _)| path.as_str()).collect()
    }

    /// Whether it sets a key, or something within it or around it.
    fn touches(&self, key: &str) -> bool {
        let within = |inner: &str, outer: &str| {
            inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        self.paths().into_iter().any(|path| within(path, key) || within(key, path))
    }

    /// Refuses values that name the same folder, and those that set nothing.
    fn check(&self, problems: &mut Vec<Problem>) {
        let mut complain = |i: usize, message: &str| {
            let message = format!("{}[{i}] {message}", self.key);
            problems.push(in_sweep(&self.points[i].node.place, message));
        };
        let mut names: Vec<&str> = Vec::new();
        for (i, Point { name, leaves, .. }) in self.points.iter().enumerate() {
            if leaves.is_empty() {
                complain(i, "must set at least one key, got {}");
            } else if let Some(other) = names.iter().position(|known| known == name) {
                complain(i, &format!("gives the same folder as [{other}], \"{name}\""));
            }
            names.push(name);
        }
    }
}

impl Point {
    fn new(key: &str, node: &Node) -> Self {
        let mut leaves = Vec::new();
        collect_leaves(key, node, &mut leaves);
        let name = match &node.value {
            Value::Text(path) if key == "model" => {
                let stem = Path::new(path).file_stem().unwrap_or_default();
                safe(&stem.to_string_lossy())
            }
            value => name_of(value),
        };
        Self { node: node.clone(), name, leaves }
    }
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

/// A value as a part of a folder's name.
fn name_of(value: &Value) -> String {
    match value {
        Value::Number(number) if number.fract() == 0.0 && number.abs() < 1e15 => number.to_string(),
        Value::List(items) => {
            let items: Vec<_> = items.iter().map(|item| name_of(&item.value)).collect();
            items.join("-")
        }
        Value::Table(entries) => {
            let entry = |(key, node): &(config::Key, Node)| {
                format!("{}-{}", safe(&key.name), name_of(&node.value))
            };
            entries.iter().map(entry).collect::<Vec<_>>().join("-")
        }
        Value::Text(text) => safe(text),
        other => safe(&other.to_string()),
    }
}

/// With nothing in it that a file system or a shell takes for something else.
fn safe(text: &str) -> String {
    let harmless = |c: char| c.is_ascii_alphanumeric() || "._+-".contains(c);
    text.chars().map(|c| if harmless(c) { c } else { '-' }).collect()
}

/// A number of seeds, from 1, or a list of them.
fn seeds(node: &Node) -> Result<Vec<u64>, Mismatch> {
    let Value::List(items) = &node.value else {
        let n = count(1, MOST_CELLS as i64).take(node).map_err(|mismatch| Mismatch {
            expected: format!("{} or a list of seeds", mismatch.expected),
            ..mismatch
        })?;
        return Ok((1..=n).collect());
    };
    let refuse = |node: &Node, part: String, expected: &str| Mismatch {
        place: node.place.clone(),
        part,
        expected: expected.into(),
        found: node.value.to_string(),
    };
    if items.is_empty() {
        return Err(refuse(
            node,
            String::new(),
            "a number of seeds or a list of at least one seed",
        ));
    }
    let mut seeds = Vec::new();
    for (i, item) in items.iter().enumerate() {
        let inside = |mismatch| Mismatch { part: format!("[{i}]"), ..mismatch };
        let seed = count(0, i64::MAX).take(item).map_err(inside)?;
        if seeds.contains(&seed) {
            return Err(refuse(item, format!("[{i}]"), "a seed that isn't in the list yet"));
        }
        seeds.push(seed);
    }
    Ok(seeds)
}

fn problem(key: &str, mismatch: Mismatch) -> Problem {
    let Mismatch { place, part, expected, found } = mismatch;
    in_sweep(&place, format!("{key}{part} must be {expected}, got {found}"))
}

fn in_sweep(place: &Place, message: String) -> Problem {
    Problem { place: place.clone(), message: format!("sweep: {message}") }
}

//! The table `sweep`: values for some keys, each combined with each, and seeds.
//!
//! A key is written with dots, in quotes or not, or as nested tables. A value that is a table sets
//! several keys together: `codec = [{ sensor_bits = 1 }, { sensor_bits = 2, actuator_bits = 2 }]`.

use std::collections::{BTreeMap, BTreeSet};

use config::{Document, Mismatch, Node, Place, Problem, Rule, Value, count};

use super::axis::{Axis, Point, in_sweep, safe, touched};

/// Cells that a file may have.
pub const MOST_CELLS: usize = 100_000;

/// Characters of a folder's name: file systems take 255 bytes.
const LONGEST_NAME: usize = 200;

/// What is swept, in the order of the file.
pub(super) struct Sweep {
    pub(super) axes: Vec<Axis>,
    pub(super) seeds: Vec<u64>,
    /// Where each key that is swept stands.
    swept: BTreeMap<String, Place>,
}

impl Sweep {
    /// Reads the table, if there is one. Problems are added to `problems`.
    pub(super) fn read(node: Option<&Node>, problems: &mut Vec<Problem>) -> Self {
        let mut sweep = Self { axes: Vec::new(), seeds: vec![1], swept: BTreeMap::new() };
        let Some(node) = node else { return sweep };
        let Value::Table(entries) = &node.value else {
            let message = format!("sweep must be a table, got {}", node.value);
            problems.push(Problem { place: node.place.clone(), message });
            return sweep;
        };
        for (key, node) in entries {
            if key.name == "sweep" || key.name.starts_with("sweep.") {
                problems.push(in_sweep(&key.place, "a sweep can't be swept".into()));
            } else if key.name == "seeds" {
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
        let axis = Axis::read(path, place, items, problems);
        let twice = |key: &String| touched(&self.swept, key).map(|other| (key.clone(), other));
        if let Some((key, other)) = axis.paths.iter().find_map(twice) {
            problems.push(in_sweep(place, format!("{key} is swept twice, by {other} too")));
            return;
        }
        self.swept.extend(axis.paths.iter().map(|key| (key.clone(), place.clone())));
        self.axes.push(axis);
    }

    /// By the last part of the key, where no other swept key ends in it.
    fn name_axes(&mut self) {
        fn last(key: &str) -> &str {
            key.rsplit('.').next().unwrap_or(key)
        }
        let mut ends: BTreeMap<String, usize> = BTreeMap::new();
        for axis in &self.axes {
            *ends.entry(last(&axis.key).to_owned()).or_default() += 1;
        }
        for axis in &mut self.axes {
            let end = last(&axis.key);
            axis.name = safe(if ends.get(end) == Some(&1) { end } else { &axis.key });
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
                 sweep fewer keys or shorter values, or give tables a label"
            );
            problems.push(Problem { place: place.clone(), message });
        }
    }

    /// Refuses keys that the rest of the file sets, or the command line.
    pub(super) fn check_against(&self, document: &Document, problems: &mut Vec<Problem>) {
        for (key, place) in &self.swept {
            let Some(node) = document.get(key) else { continue };
            let message = match node.place.line {
                0 => format!("{key} is swept by {place}, so it can't be set"),
                _ => format!("{key} is set here and swept in {place}: one has to go"),
            };
            problems.push(Problem { place: node.place.clone(), message });
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
        named.map(|(axis, point)| axis.named(point)).collect::<Vec<_>>().join(",")
    }
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
    let (mut seeds, mut known) = (Vec::new(), BTreeSet::new());
    for (i, item) in items.iter().enumerate() {
        let inside = |mismatch| Mismatch { part: format!("[{i}]"), ..mismatch };
        let seed = count(0, i64::MAX).take(item).map_err(inside)?;
        if !known.insert(seed) {
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;

    fn read(text: &str) -> (Sweep, Vec<Problem>) {
        let mut problems = Vec::new();
        let node = Document::parse("f", text).unwrap().take("sweep");
        (Sweep::read(node.as_ref(), &mut problems), problems)
    }

    /// Values compared with all others, or keys, or seeds, would take many minutes.
    #[test]
    fn long_sweeps_are_read_in_no_time() {
        let start = Instant::now();
        let n = 300_000;
        let list = |n: usize| (0..n).map(|i| i.to_string()).collect::<Vec<_>>().join(", ");
        let (sweep, problems) = read(&format!("[sweep]\na = [{}]", list(n)));
        assert_eq!((sweep.axes[0].points.len(), problems.len()), (n, 1), "{problems:?}");
        let (sweep, problems) = read(&format!("[sweep]\nseeds = [{}]", list(n)));
        assert_eq!((sweep.seeds.len(), problems.len()), (n, 1), "{problems:?}");
        let keys: String = (0..n / 3).map(|i| format!("a{i} = [0]\n")).collect();
        let (sweep, problems) = read(&format!("[sweep]\n{keys}"));
        assert_eq!((sweep.axes.len(), problems.len()), (n / 3, 1), "{problems:?}");
        let keys: Vec<_> = (0..n / 3).map(|i| format!("a{i} = 0")).collect();
        let (sweep, _) = read(&format!("[sweep]\nx = [{{ {} }}]\ny = [1]", keys.join(", ")));
        assert_eq!(sweep.axes[0].paths.len(), n / 3);
        assert!(start.elapsed() < Duration::from_secs(120), "{:?}", start.elapsed());
    }

    #[test]
    fn keys_touch_those_around_and_within_them() {
        let known = BTreeMap::from([("a.b".to_owned(), 1), ("a.bc.d".to_owned(), 2)]);
        for (key, expected) in [
            ("a", Some(1)),
            ("a.b", Some(1)),
            ("a.b.x", Some(1)),
            ("a.bc", Some(2)),
            ("a.bc.d.e", Some(2)),
            ("a.bc.x", None),
            ("a.", None),
            ("b", None),
            ("", None),
        ] {
            assert_eq!(touched(&known, key).copied(), expected, "{key}");
        }
    }
}

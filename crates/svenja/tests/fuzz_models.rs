//! Random changes to the models of `models/`: whatever becomes of them is read in time and refused
//! with places that are in the file, or is a robot that hangs together.
//!
//! `FUZZ_MODELS` sets the number of changed models, and makes them other ones in every run.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::{
    cell::Cell,
    collections::BTreeSet,
    fs,
    ops::Range,
    path::Path,
    time::{Duration, Instant},
};

use proptest::{
    collection::vec,
    prelude::*,
    sample::{Index, select},
    test_runner::{RngSeed, TestRunner},
};
use svenja::{AxisId, Morphology, Problems};
use tempfile::TempDir;

/// Changed models, if `FUZZ_MODELS` doesn't say otherwise.
const MODELS: u32 = 2000;
/// A model takes a millisecond.
const PATIENCE: Duration = Duration::from_secs(2);

/// What a number may become and the model stay a robot, with luck.
const USUAL: [&str; 6] = ["0.3", "0.05", "-0.02", "12", "-25.0", "1e-3"];

/// What else it may become.
const NASTY: [&str; 24] = [
    "nan",
    "-nan",
    "inf",
    "-inf",
    "0",
    "-0.0",
    "-1",
    "1e-300",
    "5e-324",
    "1e300",
    "-1e300",
    "1e999",
    "180",
    "180.00000000000003",
    "90.1",
    "-360",
    "99999999999999999999",
    "0x7fffffffffffffff",
    "''",
    "'1'",
    "true",
    "[]",
    "{}",
    "2024-02-29",
];

/// What may come anywhere.
const JUNK: [&[u8]; 12] = [
    b"[[body]]\n",
    b"[[joint]]\n",
    b"[servo.'']\n",
    b"[[",
    b"]",
    b"{",
    b"=",
    b"'''",
    b"#",
    b"\0",
    b"\xff\xfe",
    b"\xc3\xa4\xe2\x82\xac",
];

/// One change. Places are parts of however many there are then.
#[derive(Clone, Debug)]
enum Change {
    DeleteLines(Index, usize),
    RepeatLines(Index, usize, Index),
    SwapLines(Index, Index),
    SwapWords(Index, Index),
    CopyWord(Index, Index),
    ReplaceNumber(Index, &'static str),
    Insert(Index, &'static [u8]),
    ReplaceBytes(Index, Vec<u8>),
    Truncate(Index),
}

fn change() -> impl Strategy<Value = Change> {
    let index = any::<Index>;
    prop_oneof![
        4 => (index(), 1..12_usize).prop_map(|(at, n)| Change::DeleteLines(at, n)),
        4 => (index(), 1..12_usize, index()).prop_map(|(at, n, to)| Change::RepeatLines(at, n, to)),
        2 => (index(), index()).prop_map(|(a, b)| Change::SwapLines(a, b)),
        6 => (index(), index()).prop_map(|(a, b)| Change::SwapWords(a, b)),
        6 => (index(), index()).prop_map(|(from, to)| Change::CopyWord(from, to)),
        12 => (index(), select(&USUAL[..])).prop_map(|(at, new)| Change::ReplaceNumber(at, new)),
        6 => (index(), select(&NASTY[..])).prop_map(|(at, new)| Change::ReplaceNumber(at, new)),
        1 => (index(), select(&JUNK[..])).prop_map(|(at, junk)| Change::Insert(at, junk)),
        1 => (index(), vec(any::<u8>(), 1..6)).prop_map(|(at, new)| Change::ReplaceBytes(at, new)),
        1 => index().prop_map(Change::Truncate),
    ]
}

/// Quoted texts, and runs of what keys and numbers are made of.
fn words(text: &[u8]) -> Vec<Range<usize>> {
    let in_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"_.+-".contains(byte);
    let mut words = Vec::new();
    let mut at = 0;
    while at < text.len() {
        let rest = &text[at..];
        let length = match rest[0] {
            b'"' => rest[1..].iter().position(|&byte| byte == b'"').map_or(1, |end| end + 2),
            _ => rest.iter().take_while(|byte| in_word(byte)).count(),
        };
        if length > 0 {
            words.push(at..at + length);
        }
        at += length.max(1);
    }
    words
}

fn splice(text: &mut Vec<u8>, range: Range<usize>, new: &[u8]) {
    text.splice(range, new.iter().copied());
}

impl Change {
    fn apply(&self, text: &mut Vec<u8>) {
        match self {
            Self::DeleteLines(..) | Self::RepeatLines(..) | Self::SwapLines(..) => {
                self.apply_to_lines(text);
            }
            Self::SwapWords(..) | Self::CopyWord(..) | Self::ReplaceNumber(..) => {
                self.apply_to_words(text);
            }
            Self::Insert(at, junk) => {
                let at = at.index(text.len() + 1);
                splice(text, at..at, junk);
            }
            Self::ReplaceBytes(at, new) => {
                let at = at.index(text.len() + 1);
                let end = text.len().min(at + new.len());
                splice(text, at..end, new);
            }
            Self::Truncate(at) => text.truncate(at.index(text.len() + 1)),
        }
    }

    fn apply_to_lines(&self, text: &mut Vec<u8>) {
        let mut lines: Vec<_> = text.split_inclusive(|&byte| byte == b'\n').collect();
        if lines.is_empty() {
            return;
        }
        let some = |at: &Index, n: usize| {
            let at = at.index(lines.len());
            at..lines.len().min(at + n)
        };
        match self {
            Self::DeleteLines(at, n) => drop(lines.drain(some(at, *n))),
            Self::RepeatLines(at, n, to) => {
                let (copy, to) = (lines[some(at, *n)].to_vec(), to.index(lines.len()));
                lines.splice(to..to, copy);
            }
            Self::SwapLines(a, b) => {
                let (a, b) = (a.index(lines.len()), b.index(lines.len()));
                lines.swap(a, b);
            }
            _ => {}
        }
        *text = lines.concat();
    }

    fn apply_to_words(&self, text: &mut Vec<u8>) {
        let words = words(text);
        let word = |at: &Index| words.get(at.index(words.len().max(1))).cloned().unwrap_or(0..0);
        match self {
            Self::SwapWords(a, b) => {
                let (a, b) = (word(a), word(b));
                let (a, b) = if a.start <= b.start { (a, b) } else { (b, a) };
                let (first, last) = (text[a.clone()].to_vec(), text[b.clone()].to_vec());
                splice(text, b, &first);
                splice(text, a, &last);
            }
            Self::CopyWord(from, to) => {
                let copy = text[word(from)].to_vec();
                splice(text, word(to), &copy);
            }
            Self::ReplaceNumber(at, new) => {
                let is_number = |word: &&Range<usize>| text[word.end - 1].is_ascii_digit();
                let numbers: Vec<_> = words.iter().filter(is_number).cloned().collect();
                if !numbers.is_empty() {
                    splice(text, at.get(&numbers).clone(), new.as_bytes());
                }
            }
            _ => {}
        }
    }
}

/// A place in the file, or the file as a whole, and one line of text.
fn check_problems(path: &Path, text: &[u8], problems: &Problems) {
    let text = String::from_utf8_lossy(text);
    let lengths: Vec<_> = text.split('\n').map(|line| line.chars().count()).collect();
    assert!(problems.iter().next().is_some(), "refused without a problem");
    for problem in problems.iter() {
        let (line, column) = (problem.place.line, problem.place.column);
        assert_eq!(*problem.place.source, *path.display().to_string());
        let is_whole = (line, column) == (0, 0);
        let is_inside =
            line >= 1 && column >= 1 && column <= lengths.get(line - 1).unwrap_or(&0) + 1;
        assert!(is_whole || is_inside, "{problem}");
        assert!(!problem.message.trim().is_empty(), "{problem}");
        assert!(!problem.message.contains(char::is_control), "{problem:?}");
    }
}

fn all_different<T: Ord>(items: impl Iterator<Item = T>) -> bool {
    let mut seen = BTreeSet::new();
    items.into_iter().all(|item| seen.insert(item))
}

/// What [`Morphology`] promises.
fn check_morphology(robot: &Morphology) {
    let (bodies, joints) = (robot.bodies(), robot.joints());
    assert!(all_different(bodies.iter().map(|body| &body.name)));
    let names = joints.iter().map(|joint| &joint.name);
    assert!(all_different(names.chain(robot.groups().iter().map(|group| &group.name))));
    check_tree(robot);
    for body in bodies {
        assert!(body.mass_kg > 0.0 && body.mass_kg.is_finite());
        let inertia = body.inertia().moments_kg_m2;
        assert!(inertia.iter().all(|moment| moment.is_finite() && *moment > 0.0), "{inertia}");
        assert!(body.pose.to_matrix().iter().all(|number| number.is_finite()));
    }
    for axis in joints.iter().flat_map(|joint| &joint.axes) {
        let [lower, upper] = axis.range.unwrap_or([-4.0, 4.0]);
        assert!(lower <= 0.0 && upper >= 0.0 && lower < upper);
        assert!(axis.spring.is_none_or(|spring| (lower..=upper).contains(&spring.equilibrium)));
    }
    let in_range = |id: &AxisId| joints.get(id.joint).is_some_and(|j| id.axis < j.axes.len());
    for axes in [robot.sensors(), robot.actuators()] {
        assert!(axes.iter().all(in_range));
        assert!(all_different(axes.iter().map(|id| (id.joint, id.axis))));
    }
    assert!(robot.actuators().iter().all(|&id| robot.axis(id).servo.is_some()));
    for list in [robot.contacts(), robot.feet(), robot.penalised()] {
        assert!(list.iter().all(|&body| body < bodies.len()) && all_different(list.iter()));
    }
    for group in robot.groups() {
        assert!(group.joints.iter().all(|&joint| joint < joints.len()));
        assert!(group.contacts.iter().all(|body| robot.contacts().contains(body)));
    }
    assert!(robot.heading().body < bodies.len());
    // Three products and a root round.
    assert!((robot.heading().axis.norm() - 1.0).abs() < 1e-12);
}

/// One body hangs on none; from every other one the way up ends there.
fn check_tree(robot: &Morphology) {
    let mut parents = vec![None; robot.bodies().len()];
    for joint in robot.joints() {
        assert_eq!(parents[joint.child].replace(joint.parent), None, "two parents");
    }
    let parents: Vec<Option<usize>> = parents.into_iter().map(Option::flatten).collect();
    assert_eq!(parents.iter().filter(|parent| parent.is_none()).count(), 1, "roots");
    for body in 0..parents.len() {
        let ways_up = std::iter::successors(Some(body), |&body| parents[body]);
        assert!(ways_up.take(parents.len() + 1).count() <= parents.len(), "a cycle");
    }
}

/// What is accepted can be built.
#[cfg(feature = "bullet")]
fn check_spawn(robot: &Morphology) {
    let mut world = bullet::World::new(&bullet::WorldSettings::default()).unwrap();
    svenja::add_ground(&mut world).unwrap();
    svenja::Robot::spawn(robot, &mut world).unwrap_or_else(|error| panic!("{error}"));
}

/// Texts of `models/`.
fn models() -> Vec<Vec<u8>> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models");
    let paths = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let mut paths: Vec<_> =
        paths.filter(|path| path.extension().is_some_and(|kind| kind == "toml")).collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

fn runner() -> TestRunner {
    TestRunner::new(ProptestConfig {
        // A failure prints the changes; a file of seeds would mean nothing once a model changes.
        failure_persistence: None,
        ..match std::env::var("FUZZ_MODELS") {
            Ok(number) => ProptestConfig::with_cases(number.parse().unwrap()),
            // The same in every run of the suite: what's new is found by asking for it.
            Err(_) => {
                ProptestConfig { rng_seed: RngSeed::Fixed(1), ..ProptestConfig::with_cases(MODELS) }
            }
        }
    })
}

#[test]
fn a_changed_model_is_a_robot_or_gets_messages_with_places() {
    let models = models();
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("model.toml");
    let (robots, refusals) = (Cell::new(0), Cell::new(0));
    let one = |(model, changes): (Index, Vec<Change>)| {
        let mut text = model.get(&models).clone();
        changes.iter().for_each(|change| change.apply(&mut text));
        fs::write(&path, &text).unwrap();
        let start = Instant::now();
        let read = Morphology::open(&path);
        assert!(start.elapsed() < PATIENCE, "took {:?}", start.elapsed());
        match read {
            Ok(robot) => {
                check_morphology(&robot);
                #[cfg(feature = "bullet")]
                check_spawn(&robot);
                robots.set(robots.get() + 1);
            }
            Err(problems) => {
                check_problems(&path, &text, &problems);
                refusals.set(refusals.get() + 1);
            }
        }
        Ok(())
    };
    runner().run(&(any::<Index>(), vec(change(), 1..4)), one).unwrap();
    // Changes that always broke something, or never, would test one half only.
    let (robots, refusals) = (robots.get(), refusals.get());
    let few = (robots + refusals) / 50;
    assert!(robots > few && refusals > few, "{robots} robots, {refusals} refusals");
}

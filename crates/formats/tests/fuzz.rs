//! Files that are nearly right: whatever is in them, an import ends soon, with a model file of finite
//! numbers or with problems that have their places.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::{fs, path::Path};

use formats::{Options, import_text};
use proptest::{collection::vec, prelude::*, sample::Index};

/// One small robot a format, with most of what it can have.
const ROBOTS: [&str; 4] = [
    include_str!("robots/all.urdf"),
    include_str!("robots/all.mjcf"),
    include_str!("robots/all.sdf"),
    include_str!("robots/all.rosiml"),
];

/// What numbers, names and words are replaced with.
const WORDS: [&str; 20] = [
    "0",
    "-1",
    "1e308",
    "-1e-308",
    "nan",
    "inf",
    "1e999",
    "-1.57.",
    "3.2",
    "1 2",
    "",
    "a",
    "base",
    "world",
    "revolute",
    "ball",
    "slide",
    "true",
    "${x}",
    "\u{fffd}\u{1f916}",
];

#[derive(Clone, Debug)]
enum Change {
    /// The text between two quotes, or between two tags.
    Word(Index, Index),
    /// A line, taken out.
    Without(Index),
    /// A line, written twice.
    Twice(Index),
    /// The text ends here.
    Cut(Index),
    /// A character, put in.
    Insert(Index, char),
}

fn change() -> impl Strategy<Value = Change> {
    let index = any::<Index>;
    prop_oneof![
        8 => (index(), index()).prop_map(|(at, word)| Change::Word(at, word)),
        3 => index().prop_map(Change::Without),
        3 => index().prop_map(Change::Twice),
        1 => index().prop_map(Change::Cut),
        1 => (index(), prop::char::any()).prop_map(|(at, c)| Change::Insert(at, c)),
    ]
}

fn changed(text: &str, change: &Change) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let boundary = |at: &Index| {
        let at = at.index(text.len().max(1));
        (0..=at).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0)
    };
    match change {
        Change::Word(at, word) => {
            let ends: Vec<usize> = text.match_indices(['"', '>', '<']).map(|(at, _)| at).collect();
            if ends.len() < 2 {
                return text.into();
            }
            let i = at.index(ends.len() - 1);
            let word = WORDS[word.index(WORDS.len())];
            format!("{}{word}{}", &text[..=ends[i]], &text[ends[i + 1]..])
        }
        Change::Without(at) if !lines.is_empty() => {
            let at = at.index(lines.len());
            [&lines[..at], &lines[at + 1..]].concat().join("\n")
        }
        Change::Twice(at) if !lines.is_empty() => {
            let at = at.index(lines.len());
            [&lines[..=at], &lines[at..]].concat().join("\n")
        }
        Change::Cut(at) => text[..boundary(at)].into(),
        Change::Insert(at, c) => {
            let at = boundary(at);
            format!("{}{c}{}", &text[..at], &text[at..])
        }
        _ => text.into(),
    }
}

/// A model file has no number that isn't one; a problem has a place in the file.
fn ends_well(text: String) {
    match import_text(Path::new("robots/robot.xml"), text, &Options::default()) {
        Ok(imported) => {
            let model = imported.text.lines().filter(|line| !line.starts_with('#'));
            for line in model.filter(|line| !line.contains("name =")) {
                let numbers = line.split(['[', ']', ',', ' ', '{', '}', '=']);
                let mut bad = numbers.filter(|word| ["NaN", "inf", "-inf"].contains(word));
                assert_eq!(bad.next(), None, "{line}");
            }
            assert!(!imported.robot.links.is_empty());
        }
        Err(problems) => {
            assert!(problems.iter().next().is_some());
            for problem in problems.iter() {
                assert!(
                    !problem.message.is_empty() && !problem.message.contains('\n'),
                    "{problem}"
                );
            }
        }
    }
}

#[test]
fn each_robot_is_imported_as_it_is() {
    for text in ROBOTS {
        let imported = import_text(Path::new("robots/robot.xml"), text.into(), &Options::default());
        let imported = imported.unwrap_or_else(|problems| panic!("{problems}"));
        assert!(imported.robot.links.len() > 2, "{}", imported.text);
    }
}

proptest! {
    #[test]
    fn a_robot_with_mistakes_is_imported_or_refused(which in 0..4_usize, changes in vec(change(), 1..6)) {
        let text = changes.iter().fold(ROBOTS[which].to_owned(), |text, it| changed(&text, it));
        ends_well(text);
    }

    #[test]
    fn any_text_is_refused_or_imported(text in any::<String>()) {
        ends_well(text);
    }
}

/// Elements in each other, attributes, includes and copies by the thousand.
#[test]
fn large_and_deep_files_end_soon() {
    let deep = |n: usize| {
        let body = "<body><geom size=\"1\"/><joint/>";
        format!("<mujoco><worldbody>{}{}</worldbody></mujoco>", body.repeat(n), "</body>".repeat(n))
    };
    ends_well(deep(100));
    ends_well(deep(1000));
    ends_well(deep(100_000));
    let chain: String = (1..3000)
        .map(|i| {
            let up = i - 1;
            format!(
                "<link name=\"l{i}\"/><joint name=\"j{i}\" type=\"continuous\"><parent link=\"l{up}\"/>\
                 <child link=\"l{i}\"/></joint>"
            )
        })
        .collect();
    ends_well(format!("<robot name=\"r\"><link name=\"l0\"/>{chain}</robot>"));
    let replicas = "<replicate count=\"1000\">".repeat(20) + "<body><geom size=\"1\"/></body>";
    let replicas = replicas + &"</replicate>".repeat(20);
    ends_well(format!("<mujoco><worldbody>{replicas}</worldbody></mujoco>"));
    let attributes: String = (0..50_000).map(|i| format!(" a{i}=\"1\"")).collect();
    ends_well(format!("<robot name=\"r\"{attributes}><link name=\"a\"/></robot>"));
    ends_well(format!("<robot name=\"r\">{}</robot>", "<a/>".repeat(600_000)));
}

/// Includes by a person's mistake, and by somebody's malice.
#[test]
fn includes_end() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let body = "<worldbody><body><geom size=\"1\"/></body></worldbody>";
    // Each includes the next one twice: 2^30 bodies, if that were done.
    for i in 0..30 {
        let next = format!("<include file=\"{}.xml\"/>", i + 1).repeat(2);
        fs::write(at(&format!("{i}.xml")), format!("<mujoco>{next}</mujoco>")).unwrap();
    }
    fs::write(at("30.xml"), format!("<mujoco>{body}</mujoco>")).unwrap();
    fs::write(at("round.xml"), format!("<mujoco>{body}<include file=\"round.xml\"/></mujoco>"))
        .unwrap();
    for (name, message) in [
        ("0.xml", "29.xml:1:48: file of <include> must not be included again"),
        ("round.xml", "round.xml:1:76: file of <include> must not be included again"),
    ] {
        let problems = formats::import(&at(name), &Options::default()).unwrap_err().to_string();
        assert!(problems.contains(message), "{problems}");
    }
}

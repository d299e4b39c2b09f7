//! Names that a model file takes: 1 to 60 characters on one line, without slashes, and each once.

use std::collections::BTreeSet;

use crate::{robot::Robot, xml::Log};

const LONGEST: usize = 60;

/// Gives all parts names that are legal and their own.
pub(crate) fn mend(robot: &mut Robot, log: &Log) {
    let links = robot.links.iter_mut().map(|link| &mut link.name);
    each_its_own(links, "body", log);
    let joints = robot.joints.iter_mut().map(|joint| &mut joint.name);
    each_its_own(joints, "joint", log);
    for joint in &mut robot.joints {
        if joint.axes.len() > 1 {
            each_its_own(joint.axes.iter_mut().map(|axis| &mut axis.name), "axis", log);
        }
    }
    robot.name = legal(&robot.name, "robot");
}

/// A name for people.
pub(crate) fn quoted(name: &str) -> String {
    format!("'{}'", config::shown(name))
}

fn each_its_own<'a>(names: impl Iterator<Item = &'a mut String>, kind: &str, log: &Log) {
    let mut taken = BTreeSet::new();
    for name in names {
        let own = legal(name, kind);
        let mut unique = own.clone();
        let mut number = 1;
        while !taken.insert(unique.clone()) {
            number += 1;
            let ending = format!(" {number}");
            let kept: String = own.chars().take(LONGEST - ending.len()).collect();
            unique = format!("{kept}{ending}");
        }
        if *name != unique {
            if !name.is_empty() {
                log.chose(
                    "a name that is taken or not legal: another",
                    &format!("'{}' is '{unique}'", config::shown(name)),
                );
            }
            *name = unique;
        }
    }
}

fn legal(name: &str, kind: &str) -> String {
    let plain = |c: char| {
        if c == '/' {
            '.'
        } else if c.is_control() {
            ' '
        } else {
            c
        }
    };
    let name: String = name.trim().chars().map(plain).take(LONGEST).collect();
    let name = name.trim();
    // The world isn't a body.
    if name.is_empty() {
        kind.into()
    } else if name == "world" {
        format!("world {kind}")
    } else {
        name.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_legal_and_each_its_own() {
        let long = "x".repeat(80);
        let mut names =
            ["a", "a", "a/b", " \n", long.as_str(), long.as_str(), "world"].map(String::from);
        each_its_own(names.iter_mut(), "body", &Log::default());
        let expected = ["a", "a 2", "a.b", "body"].map(String::from);
        assert_eq!(names[..4], expected);
        assert_eq!(names[4], "x".repeat(60));
        assert_eq!(names[5], format!("{} 2", "x".repeat(58)));
        assert_eq!(names[6], "world body");
    }
}

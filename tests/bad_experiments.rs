//! Every file of tests/experiments/bad is refused with exactly the problems that it begins with.
//!
//! Lines `# expect: PROBLEM`, one for each line of the message, where the file is called by its
//! name alone, and `...` stands for the kinds of an open list; lines `# set: key=value` are overrides.

use std::{
    fs,
    path::{Path, PathBuf},
};

use runner::experiment::Plan;

fn files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/experiments/bad");
    let mut files: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// What follows a mark in the comments that a file begins with.
fn comments<'a>(text: &'a str, mark: &'a str) -> impl Iterator<Item = &'a str> {
    text.lines()
        .take_while(|line| line.starts_with('#'))
        .filter_map(move |line| line.strip_prefix(mark))
}

/// How the problems of a file differ from those that it expects; empty if they don't.
fn difference(path: &Path) -> String {
    // Some files are bad because they aren't UTF-8.
    let text = String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
    let folder = format!("{}/", path.parent().unwrap().display());
    let overrides: Vec<_> = comments(&text, "# set: ").map(str::to_owned).collect();
    let found = match Plan::open(path, &overrides) {
        Ok(_) => String::new(),
        Err(problems) => problems.to_string().replace(&folder, ""),
    };
    let expected: Vec<_> = comments(&text, "# expect: ").collect();
    let found: Vec<_> = found.lines().collect();
    let pairs = || expected.iter().zip(&found);
    if found.len() == expected.len() && !found.is_empty() && pairs().all(|(e, f)| is(e, f)) {
        return String::new();
    }
    let missing = expected.iter().filter(|line| !found.iter().any(|it| is(line, it)));
    let missing = missing.map(|line| format!("- {line}\n"));
    let new = found.iter().filter(|line| !expected.iter().any(|it| is(it, line)));
    let new = new.map(|line| format!("+ {line}\n"));
    let lines: String = missing.chain(new).collect();
    format!("{}\n{lines}", path.file_name().unwrap().display())
}

/// Whether a line is the expected one.
fn is(expected: &str, found: &str) -> bool {
    match expected.split_once("...") {
        None => found == expected,
        Some((begin, end)) => found.strip_prefix(begin).is_some_and(|rest| rest.ends_with(end)),
    }
}

#[test]
fn every_bad_file_is_refused_with_the_problems_that_it_expects() {
    let differences: String = files().iter().map(|path| difference(path)).collect();
    assert!(
        differences.is_empty(),
        "- expected and not found, + found and not expected:\n{differences}"
    );
}

#[test]
fn there_are_enough_bad_files() {
    assert!(files().len() >= 40, "{}", files().len());
}

//! Where something stands, in whatever text: characters are counted, not bytes.
#![allow(clippy::unwrap_used, missing_docs)]

use std::fs;

use config::{Document, LARGEST_FILE, Place, Problem, Problems};
use tempfile::TempDir;

fn place_of(text: &str, path: &str) -> String {
    Document::parse("f", text).unwrap().get(path).unwrap().place.to_string()
}

fn refused(text: &str) -> String {
    Document::parse("f", text).unwrap_err().to_string()
}

#[test]
fn columns_count_characters() {
    assert_eq!(place_of("x = 1", "x"), "f:1:5");
    // Two, three and four bytes; a letter and its accent are two characters.
    assert_eq!(place_of("'ä' = 1", "ä"), "f:1:7");
    assert_eq!(place_of("a = ['ä€😀', 3]\nb = '😀'", "b"), "f:2:5");
    assert_eq!(place_of("a = { 'ä€😀' = 1, x = 2 }", "a.x"), "f:1:22");
    assert_eq!(place_of("a = { 'e\u{301}' = 1, x = 2 }", "a.x"), "f:1:21");
}

#[test]
fn lines_end_in_either_way() {
    assert_eq!(place_of("a = 1\r\n\r\nb = 2", "b"), "f:3:5");
    assert_eq!(place_of("a = '''\n\n'''\nb = 2", "b"), "f:4:5");
    // A byte order mark isn't a character of the text.
    assert_eq!(place_of("\u{feff}a = 1", "a"), "f:1:5");
}

#[test]
fn tables_stand_where_they_begin() {
    assert_eq!(place_of("\n[a.b]\nc = 1", "a.b.c"), "f:3:5");
    assert_eq!(place_of("a.b = { c = 1 }", "a.b"), "f:1:7");
}

#[test]
fn what_is_no_toml_has_a_place() {
    assert_eq!(refused("ä = 1").lines().count(), 1);
    assert!(refused("'ä' = 1\n'ö' = ").starts_with("f:2:7: not TOML: "), "{}", refused("'ö' = "));
    let twice = refused("a = 1\nb = 2\na = 3");
    assert!(twice.starts_with("f:3:1: not TOML: duplicate key"), "{twice}");
    let several = refused("a = \nb = 2\nc = [\n");
    assert!(several.starts_with("f:1:") && several.lines().count() == 2, "{several}");
}

#[test]
fn a_file_is_called_what_it_was_called() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("x.toml");
    fs::write(&path, "x = 1").unwrap();
    let place = &Document::open(&path).unwrap().get("x").unwrap().place.clone();
    assert_eq!(place.to_string(), format!("{}:1:5", path.display()));
}

#[test]
fn what_is_no_text_is_refused_at_its_first_bad_byte() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("x.toml");
    fs::write(&path, b"a = 1\nb = '\xc3\xa4\xff'").unwrap();
    let expected = format!("{}:2:7: text in UTF-8 expected, got the byte 0xff", path.display());
    assert_eq!(Document::open(&path).unwrap_err().to_string(), expected);
}

#[test]
fn what_is_too_large_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("x.toml");
    fs::write(&path, "#".repeat(LARGEST_FILE as usize)).unwrap();
    assert!(Document::open(&path).is_ok());
    fs::write(&path, "#".repeat(LARGEST_FILE as usize + 1)).unwrap();
    let expected =
        format!("{}:1:1: a TOML file of at most 1 MiB expected, got more", path.display());
    assert_eq!(Document::open(&path).unwrap_err().to_string(), expected);
}

#[test]
fn what_is_not_there_has_no_line() {
    let message = Document::open("nowhere/x.toml".as_ref()).unwrap_err().to_string();
    assert_eq!(message, "nowhere/x.toml: can't be read: No such file or directory (os error 2)");
}

/// As where several readings of a file are put together.
#[test]
fn problems_put_together_are_sorted_and_told_once() {
    let problem = |line, message: &str| Problem {
        place: Place { source: "f".into(), line, column: 1 },
        message: message.into(),
    };
    let some = Problems::new(vec![problem(10, "b"), problem(9, "c"), problem(9, "a")]);
    let twice = some.iter().chain(some.iter()).cloned().collect();
    assert_eq!(Problems::new(twice), some);
    assert_eq!(some.to_string(), "f:9:1: a\nf:9:1: c\nf:10:1: b");
    let many = Problems::new((1..=150).map(|line| problem(line, "x")).collect());
    assert_eq!(many.iter().count(), 101);
    assert_eq!(Problems::new(many.clone().into()), many);
}

/// One line, whatever the size and the letters, and not one for each of its own.
#[test]
fn a_file_in_another_format_is_called_by_its_name() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("arm.toml");
    let link = "  <link name=\"a\"><inertial/></link>\n";
    let urdf =
        |n: usize| format!("<robot name=\"arm\">\n{}</robot>\n", link.repeat(n)).into_bytes();
    let large = LARGEST_FILE as usize / link.len() + 1;
    let marked = ["\u{feff}".as_bytes(), &urdf(3)].concat();
    let latin1 = b"<?xml version='1.0' encoding='latin1'?>\n<robot name='\xe4'/>".to_vec();
    for bytes in [urdf(81), urdf(large), marked, latin1] {
        fs::write(&path, bytes).unwrap();
        let expected =
            format!("{}:1:1: a file in TOML expected, got XML, a robot in URDF", path.display());
        assert_eq!(Document::open(&path).unwrap_err().to_string(), expected);
    }
    assert_eq!(refused("\n{ \"a\": 1,\n\"b\": 2\n}"), "f:2:1: a file in TOML expected, got JSON");
}

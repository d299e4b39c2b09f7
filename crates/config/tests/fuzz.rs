//! Whatever stands in a file: places lie in it, and nothing panics or overflows.
#![allow(clippy::unwrap_used, missing_docs)]

use config::{Document, Node, Problems, Section, Value, list, name, number};
use proptest::prelude::*;

/// Pieces of which most texts are nearly TOML.
fn nearly_toml() -> impl Strategy<Value = String> {
    let piece = prop_oneof![
        Just("a"),
        Just("b.c"),
        Just("ä"),
        Just("'€'"),
        Just("\"😀\""),
        Just(" = "),
        Just("= "),
        Just("1"),
        Just("-2.5e3"),
        Just("nan"),
        Just("true"),
        Just("2024-01-01"),
        Just("["),
        Just("]"),
        Just("[["),
        Just("]]"),
        Just("{ "),
        Just(" }"),
        Just(", "),
        Just("."),
        Just("#"),
        Just("\n"),
        Just("\r\n"),
        Just("'''"),
        Just("\"\"\""),
        Just("\\u00e4"),
        Just("\u{0}"),
        Just("x = 1\n"),
        Just("[t]\n"),
        Just("l = [1, 'a']\n"),
        Just("99999999999999999999"),
    ];
    prop::collection::vec(piece, 0..40).prop_map(|pieces| pieces.concat())
}

fn read(document: &Document) -> Result<(), Problems> {
    document.read(|root| {
        root.optional("a", number());
        root.optional("l", list(number()));
        root.required("name", name());
        let inner = |inner: &mut Section<'_>| inner.optional("c", number());
        root.table_or_empty("b", inner);
        root.tables("t", |_| Some(()));
        root.named_tables("x", |_, _| Some(()));
        Some(())
    })
}

/// All places are in the text, and messages on one line.
fn check(text: &str, problems: &Problems) {
    let lines: Vec<_> = text.split('\n').map(|line| line.chars().count()).collect();
    for problem in problems.iter().filter(|problem| problem.place.line > 0) {
        let (line, column) = (problem.place.line, problem.place.column);
        assert!((1..=lines.len()).contains(&line), "{problem}");
        assert!((1..=lines[line - 1] + 1).contains(&column), "{problem}");
        assert!(!problem.message.contains('\n'), "{problem}");
    }
}

fn try_all(text: &str) {
    match Document::parse("f", text) {
        Ok(document) => check(text, &read(&document).err().unwrap_or(Problems::new(vec![]))),
        Err(problems) => check(text, &problems),
    }
    let mut document = Document::parse("f", "a = 1\nb.c = 2").unwrap();
    if document.set("--set", text).is_ok() {
        drop(read(&document));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..Default::default() })]

    #[test]
    fn any_text_is_read_or_refused(text in any::<String>()) {
        try_all(&text);
    }

    #[test]
    fn what_is_nearly_toml_is_read_or_refused(text in nearly_toml()) {
        try_all(&text);
    }

    /// Against a search for the place itself.
    #[test]
    fn values_stand_where_they_are_found(before in "[ä€😀a ]{0,12}", lines in 0_usize..4) {
        let text = format!("{}k = {{ '{before}' = 0, x = 12345 }}", "# ö\n".repeat(lines));
        let node = Document::parse("f", &text).unwrap().get("k.x").unwrap().clone();
        let last = text.lines().last().unwrap();
        let column = last.split("12345").next().unwrap().chars().count() + 1;
        prop_assert_eq!((node.place.line, node.place.column), (lines + 1, column));
    }
}

#[test]
fn deep_nesting_is_refused() {
    let deep = "at most 32 tables and lists within each other expected, got more";
    for (open, close) in [("[", "]"), ("{a=", "}")] {
        for n in [33, 81, 200_000] {
            for close in [close, ""] {
                let text = format!("a = {}1{}", open.repeat(n), close.repeat(n));
                let message = Document::parse("f", &text).unwrap_err().to_string();
                let refused = message.contains(deep) || (close.is_empty() && n == 33);
                assert!(refused, "{open} {n}: {message}");
                assert!(Document::parse("f", "").unwrap().set("--set", &text).is_err());
            }
        }
    }
    let keys = format!("{}a = 1", "a.".repeat(200_000));
    assert_eq!(Document::parse("f", &keys).unwrap_err().to_string(), format!("f:1:1: {deep}"));
}

/// The limit itself is all right.
#[test]
fn thirty_two_levels_are_read() {
    let text = format!("a = {}1{}", "[".repeat(32), "]".repeat(32));
    let mut node: Node = Document::parse("f", &text).unwrap().get("a").unwrap().clone();
    let mut levels = 0;
    while let Value::List(items) = &node.value {
        levels += 1;
        node = items[0].clone();
    }
    assert_eq!((levels, node.value), (32, Value::Integer(1)));
}

/// A path from the command line may be as long as a command line.
#[test]
fn a_long_path_is_refused() {
    let mut document = Document::parse("f", "").unwrap();
    let mut set = |n: usize| document.set("--set", &format!("{}=1", vec!["a"; n].join(".")));
    assert!(set(20_000).unwrap_err().to_string().contains(": at most 32 tables and lists within"));
    assert!(set(33).is_err());
    assert_eq!(set(32), Ok(()));
}

//! Values from the command line.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use config::{Document, Value, number};

fn document() -> Document {
    Document::parse("f", "model = 'm'\n[learning]\nrate = 1\n").unwrap()
}

fn set(assignment: &str) -> Result<Document, String> {
    let mut document = document();
    document.set("--set", assignment).map_err(|problems| problems.to_string())?;
    Ok(document)
}

#[test]
fn values_are_replaced_and_added() {
    let value = |assignment, path| set(assignment).unwrap().get(path).unwrap().value.clone();
    assert_eq!(value("learning.rate=0.5", "learning.rate"), Value::Number(0.5));
    assert_eq!(value(" learning . rate = 2 ", "learning.rate"), Value::Integer(2));
    assert_eq!(value("reward.mix.xi=1", "reward.mix.xi"), Value::Integer(1));
    assert_eq!(value("model='a=b'", "model"), Value::Text("a=b".into()));
    assert_eq!(value("learning={ rate = 3 }", "learning.rate"), Value::Integer(3));
}

#[test]
fn a_table_is_merged_key_by_key() {
    let file = "[a]\nx = 1\n[a.b]\ny = 2\nz = 3\n";
    let mut document = Document::parse("f", file).unwrap();
    document.set("--set", "a={ x = 7, b = { z = 8, new = 9 } }").unwrap();
    document.set("--set", "a.b={ 'with.dots' = 10 }").unwrap();
    let value = |path| document.get(path).map(|node| node.value.clone());
    let expected = [("a.x", 7), ("a.b.y", 2), ("a.b.z", 8), ("a.b.new", 9)];
    for (path, number) in expected {
        assert_eq!(value(path), Some(Value::Integer(number)), "{path}");
    }
    // In quotes it's one key, and not a way.
    assert_eq!(value("a.b.with"), None);
    let empty = document.set("--set", "a.b={ c = {} }").unwrap_err().to_string();
    let expected = "--set a.b={ c = {} }: a.b.c must be a value or a table with keys, got {}";
    assert_eq!(empty, expected);
}

#[test]
fn a_path_finds_a_key_that_has_dots_in_itself() {
    let file = "[sweep]\n'reward.mix.xi' = [0, 1]\n'a.b' = { c = 1 }\nseeds = 2\n";
    let mut document = Document::parse("f", file).unwrap();
    for assignment in ["sweep.reward.mix.xi=1", "sweep.a.b.c=2", "sweep.reward.power=3"] {
        document.set("--set", assignment).unwrap();
    }
    let sweep = document.take("sweep").unwrap();
    let Value::Table(entries) = &sweep.value else { panic!("{sweep:?}") };
    let keys: Vec<_> = entries.iter().map(|(key, _)| key.name.as_str()).collect();
    assert_eq!(keys, ["reward.mix.xi", "a.b", "seeds", "reward"]);
    assert_eq!(entries[0].1.value, Value::Integer(1));
    let Value::Table(inner) = &entries[1].1.value else { panic!("{sweep:?}") };
    assert_eq!((inner.len(), &inner[0].1.value), (1, &Value::Integer(2)));
}

/// Whatever the order, and whether it's the key itself, a table around it or a value in its place.
#[test]
fn what_is_set_twice_is_refused_with_both() {
    for (one, other, key) in [
        ("a=1", "a=2", "a"),
        ("a=1", " a =1", "a"),
        ("a.b=1", "a={ b = 2 }", "a.b"),
        ("a={ b = 2, c = 3 }", "a.c=1", "a.c"),
        ("a.b.c=1", "a=2", "a"),
        ("a.b.c=1", "a.b=2", "a.b"),
        ("learning.rate=1", "learning={ rate = 2 }", "learning.rate"),
        ("learning.rate=1", "learning=[2]", "learning"),
    ] {
        let mut document = document();
        document.set("--set", one).unwrap();
        let expected = format!("--set {other}: {key} is set by --set {one}, too: one has to go");
        assert_eq!(document.set("--set", other).unwrap_err().to_string(), expected);
    }
    // Beside each other.
    let mut document = document();
    for assignment in ["a.b=1", "a.c=1", "a={ d = 1 }", "learning.rate=3"] {
        document.set("--set", assignment).unwrap();
    }
}

/// There's no line to tell, so the whole argument is the place, of a part of the value too.
#[test]
fn later_problems_name_the_argument() {
    let read = |assignment| {
        let document = set(assignment).unwrap();
        let read = document.read(|root| {
            root.accept_all();
            root.table("learning", |learning| learning.required("rate", number()))
        });
        read.unwrap_err().to_string()
    };
    let expected = "--set learning.rate='x': learning: rate must be a finite number, got \"x\"";
    assert_eq!(read("learning.rate='x'"), expected);
    let expected = "--set learning.rat=2: learning: unknown key 'rat', did you mean 'rate'?";
    assert_eq!(read("learning.rat=2"), expected);
    let nested = read("learning={ rate = 1, x = 2 }");
    let expected = "--set learning={ rate = 1, x = 2 }: learning: unknown key 'x', expected 'rate'";
    assert_eq!(nested, expected);
}

#[test]
fn what_is_no_assignment_is_refused() {
    for assignment in ["", "learning.rate", "=3", "a..b=3", ".a=3", "a.=3"] {
        let expected =
            format!("--set {assignment}: key=value expected, as in --set learning.rate=0.3");
        assert_eq!(set(assignment).unwrap_err(), expected);
    }
}

#[test]
fn what_is_no_value_is_refused() {
    for (assignment, found) in [("model=svenja", "svenja"), ("a=", ""), ("a=1 2", "1 2")] {
        let message = set(assignment).unwrap_err();
        let expected = format!(
            "--set {assignment}: a value in TOML expected (a text in quotes), got {found}: "
        );
        assert!(message.starts_with(&expected), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    let message = set("a=1e999").unwrap_err();
    let expected = "--set a=1e999: a number that 64 bits can hold expected, got 1e999";
    assert_eq!(message, expected);
}

#[test]
fn nothing_is_put_into_what_is_no_table() {
    let expected = "--set model.x=1: model.x lies within something that isn't a table";
    assert_eq!(set("model.x=1").unwrap_err(), expected);
}

#[test]
fn a_table_can_be_taken_out() {
    let mut document = document();
    assert!(matches!(document.take("learning").unwrap().value, Value::Table(_)));
    assert_eq!(document.take("learning"), None);
    assert!(document.get("learning.rate").is_none());
    assert!(document.get("model.x").is_none());
}

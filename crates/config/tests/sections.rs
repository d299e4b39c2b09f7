//! Tables that are asked for their keys: what is missing, unknown, or not a table.
#![allow(clippy::unwrap_used, missing_docs)]

use config::{Document, MOST_PROBLEMS, Section, above, flag, integer, list, number, text};

/// What is said about a file; nothing about a good one.
fn says<T>(file: &str, reader: impl FnOnce(&mut Section<'_>) -> Option<T>) -> String {
    let document = Document::parse("f", file).unwrap();
    document.read(reader).map_or_else(|problems| problems.to_string(), |_| String::new())
}

#[test]
fn all_mistakes_are_told_in_the_order_of_the_file() {
    let file = "colour = 'red'\nlength_m = 'long'\n[wheel]\nradius_m = -1\nspokes = 2.5\n";
    let found = says(file, |root| {
        let name = root.required("name", text());
        let length = root.required("length_m", above(0.0));
        root.table("wheel", |wheel| {
            let spokes = wheel.required("spokes", integer(0, 100));
            wheel.required("radius_m", above(0.0)).zip(spokes)
        });
        name.zip(length)
    });
    assert_eq!(
        found,
        "f:1:1: 'name' is missing: a text\n\
         f:1:1: unknown key 'colour', expected one of 'name', 'length_m', 'wheel'\n\
         f:2:12: length_m must be a number above 0, got \"long\"\n\
         f:4:12: wheel: radius_m must be a number above 0, got -1\n\
         f:5:10: wheel: spokes must be a whole number from 0 to 100, got 2.5"
    );
}

#[test]
fn unknown_keys_are_answered_with_what_is_alike() {
    let reader = |keys: &'static [&'static str]| {
        move |root: &mut Section<'_>| {
            keys.iter().for_each(|key| assert_eq!(root.optional(key, text()), None));
            Some(())
        }
    };
    assert_eq!(says("x = 1", reader(&[])), "f:1:1: unknown key 'x', expected none");
    assert_eq!(says("x = 1", reader(&["mass"])), "f:1:1: unknown key 'x', expected 'mass'");
    let suggested = "f:1:1: unknown key 'mas', did you mean 'mass'?";
    assert_eq!(says("mas = 1", reader(&["mash_up", "mass"])), suggested);
    // Quotes and line ends of a key's name don't break the message.
    let odd = says("\"a\\n'\" = 1", reader(&["b"]));
    assert_eq!(odd, "f:1:1: unknown key 'a\\n'', expected 'b'");
}

#[test]
fn a_table_in_a_list_is_called_by_its_index_or_as_it_likes() {
    let file = "part = [{ mass = 1 }, { mass = 'x' }, 3]\n[[other]]\nname = 'knee'\nmass = true\n";
    let found = says(file, |root| {
        let parts = root.tables("part", |part| part.required("mass", number()));
        assert_eq!(parts, [1.0]);
        root.tables("other", |other| {
            let name = other.required("name", text())?;
            other.call(format!("joint '{name}'"));
            other.required("mass", number())
        });
        Some(())
    });
    assert_eq!(
        found,
        "f:1:32: part[1]: mass must be a finite number, got \"x\"\n\
         f:1:39: part[2] must be a table, got 3\n\
         f:4:8: joint 'knee': mass must be a finite number, got true"
    );
    let no_list = "f:1:8: part must be a list of tables, [{ ... }] or [[...]], got 3";
    let parts = |root: &mut Section<'_>| Some(root.tables("part", |_| Some(())));
    assert_eq!(says("part = 3", parts), no_list);
    assert_eq!(says("", parts), "");
}

#[test]
fn tables_of_named_tables_check_the_names() {
    let file = "[servo]\n'' = {}\nhip = { speed = 'x' }\nknee = 3\n";
    let found = says(file, |root| {
        let read = root.named_tables("servo", |_, servo| servo.required("speed", number()));
        assert!(read.is_empty());
        Some(())
    });
    assert_eq!(
        found,
        "f:2:1: servo.NAME must be 1 to 60 characters on one line, without /, got \"\"\n\
         f:3:17: servo.hip: speed must be a finite number, got \"x\"\n\
         f:4:8: servo.knee must be a table, got 3"
    );
}

#[test]
fn tables_may_be_required_optional_or_of_defaults() {
    let speed = |table: &mut Section<'_>| Some(table.or("speed", number(), 7.0));
    let required = |root: &mut Section<'_>| root.required_table("servo", speed);
    assert_eq!(says("", required), "f:1:1: 'servo' is missing: a table");
    assert_eq!(says("servo = 3", required), "f:1:9: servo must be a table, got 3");
    let document = Document::parse("f", "").unwrap();
    assert_eq!(document.read(|root| root.table_or_empty("servo", speed)), Ok(7.0));
    assert_eq!(document.read(|root| Some(root.table("servo", speed))), Ok(None));
}

#[test]
fn a_reader_may_accept_all_keys() {
    let document = Document::parse("f", "x = 1\ny = 2").unwrap();
    let read = document.read(|root| {
        root.accept_all();
        Some(())
    });
    assert_eq!(read, Ok(()));
}

#[test]
fn a_reader_may_complain_for_reasons_of_its_own() {
    let found = says("low = 3\nhigh = 2\nhalf = 'x'", |root| {
        let low = root.required("low", number())?;
        let high = root.required("high", number())?;
        root.optional("half", text());
        root.refuse("high", "at least low", high);
        root.refuse_value("half", "a half");
        root.refuse_value("more", "something");
        (low <= high).then_some(())
    });
    assert_eq!(
        found,
        "f:1:1: more must be something, got nothing\n\
         f:2:8: high must be at least low, got 2\n\
         f:3:8: half must be a half, got \"x\""
    );
}

#[test]
fn lists_and_tables_are_counted_as_they_are_written() {
    let document = Document::parse("f", "a = [1, 'x']\nb = { c = 1 }\nd = 4").unwrap();
    let counts = document.read(|root| Some(["a", "b", "d", "e"].map(|key| root.count(key))));
    assert_eq!(counts, Ok([2, 1, 0, 0]));
}

#[test]
fn nonsense_gets_a_hundred_messages() {
    let file: String = (0..5000).map(|i| format!("k{i} = 1\n")).collect();
    let found = says(&file, |root| Some(root.or("x", flag(), true)));
    let mut lines = found.lines();
    assert_eq!(lines.next(), Some("f: more than 100 problems, among them:"));
    assert_eq!(lines.next(), Some("f:1:1: unknown key 'k0', expected 'x'"));
    assert_eq!(lines.count(), MOST_PROBLEMS - 1);
}

#[test]
fn the_same_problem_is_told_once() {
    let found = says("x = [1]", |root| {
        root.optional("x", list(flag()));
        root.optional("x", list(flag()))
    });
    assert_eq!(found, "f:1:6: x[0] must be true or false, got 1");
}

#[test]
fn a_key_that_is_read_elsewhere_is_suggested() {
    let says = |file| {
        says(file, |root| {
            root.mention("sweep");
            root.optional("model", text());
            Some(())
        })
    };
    assert_eq!(says("[sweeps]"), "f:1:2: unknown key 'sweeps', did you mean 'sweep'?");
    assert_eq!(says("[x]"), "f:1:2: unknown key 'x', expected one of 'model', 'sweep'");
}

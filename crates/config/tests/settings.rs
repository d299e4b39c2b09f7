//! Readers that are asked for their keys.
#![allow(clippy::unwrap_used, missing_docs)]

use std::fmt::Debug;

use config::{
    Document, Presence, Rule, Section, Setting, above, angle_deg, count, flag, integer, list, name,
    number, one_of, or_false, or_word, placed, settings, text, vector, within,
};

/// Of each key its name, what holds without it, and the kinds that have it.
fn rows(all: &[Setting]) -> Vec<(&str, &str, String)> {
    fn row(setting: &Setting) -> (&str, &str, String) {
        let presence = match &setting.presence {
            Presence::Required => "required",
            Presence::Optional => "optional",
            Presence::Default(value) => value,
        };
        let only = setting.only.as_ref();
        let only = only.map(|only| format!("{} = {}", only.key, only.kinds.join(" or ")));
        (&setting.key, presence, only.unwrap_or_default())
    }
    all.iter().map(row).collect()
}

/// A robot's leg, as some reader might have it.
fn leg(leg: &mut Section<'_>) -> Option<()> {
    let name = leg.required("name", text().about("what it's called"));
    let foot = leg.table("foot", |foot| {
        foot.or("radius_m", above(0.0).about("of the foot").condition("below `length_m`"), 0.5);
        Some(())
    });
    leg.kind(
        "drive",
        "what moves it",
        &[("servo", "A motor."), ("spring", "None.")],
        |leg, kind| {
            leg.or("damping", number().about("of the joint"), 0.0);
            if kind == "servo" {
                leg.or("torque_nm", above(0.0).about("the largest"), 2.0);
                leg.or("gain", above(0.0).about("of the servo"), 1.0);
                leg.table_or_empty("law", |law| {
                    law.kind("kind", "its law", &[("p", "P."), ("pd", "P and D.")], |law, kind| {
                        (kind == "pd").then(|| law.or("d", number().about("D"), 0.25))
                    })
                });
            } else {
                leg.or("gain", above(0.0).about("of the spring"), 9.0);
            }
            Some(())
        },
    );
    // Only then, as a reader should.
    name.zip(foot)?;
    Some(())
}

#[test]
fn every_key_of_every_kind_is_told_once() {
    let all = settings(leg);
    let of = |kind: &str| format!("drive = {kind}");
    assert_eq!(
        rows(&all),
        [
            ("name", "required", String::new()),
            ("foot.radius_m", "0.5", String::new()),
            ("drive", "\"servo\"", String::new()),
            ("damping", "0", String::new()),
            ("torque_nm", "2", of("servo")),
            ("gain", "1", of("servo")),
            ("gain", "9", of("spring")),
            ("law.kind", "\"p\"", of("servo")),
            ("law.d", "0.25", "law.kind = pd".into()),
        ]
    );
    let about: Vec<_> = all.iter().map(|setting| setting.about.as_str()).collect();
    assert_eq!(about[..3], ["what it's called", "of the foot", "what moves it"]);
    assert_eq!(all[0].expected, "a text");
    assert_eq!(all[1].expected, "a number above 0, below `length_m`");
    assert_eq!(all[2].expected, "\"servo\" or \"spring\"");
    let kinds = [("servo".to_owned(), "A motor.".to_owned()), ("spring".into(), "None.".into())];
    assert_eq!(all[2].kinds, kinds);
    assert!(all[3].kinds.is_empty());
}

#[test]
fn a_kind_is_chosen_and_a_wrong_one_hides_the_rest() {
    let says = |file: &str| {
        let problems = Document::parse("f", file).unwrap().read(leg).unwrap_err();
        problems.to_string().replace("f:", "")
    };
    assert_eq!(
        says("name = 'a'\nfoot = {}\ngains = 1"),
        "3:1: unknown key 'gains', did you mean 'gain'?"
    );
    assert_eq!(
        says("name = 'a'\nfoot = {}\ndrive = 'spring'\ntorque_nm = 1"),
        "4:1: unknown key 'torque_nm', expected one of 'name', 'foot', 'drive', 'damping', 'gain'"
    );
    let expected =
        "3:9: drive must be \"servo\" or \"spring\", got \"sprint\", did you mean 'spring'?";
    assert_eq!(says("name = 'a'\nfoot = {}\ndrive = 'sprint'\ntorque_nm = 1"), expected);
}

/// What a rule makes of a value, written, is that value again.
fn comes_back<R: Rule<Out: PartialEq + Debug>>(rule: R, values: &[&str]) {
    for value in values {
        let take = |value: &str| {
            let document = Document::parse("f", &format!("x = {value}")).unwrap();
            document.read(|root| root.required("x", &rule)).unwrap()
        };
        let made = take(value);
        assert_eq!(take(&rule.written(&made)), made, "{value}");
    }
}

#[test]
fn every_rule_writes_what_it_takes() {
    let numbers = ["0", "-0.0", "1", "-2.5", "1e-5", "1e300", "1e6", "123456.5", "0.1"];
    comes_back(number(), &numbers);
    comes_back(number().about("x").condition("y"), &numbers);
    comes_back(angle_deg(), &["0", "90", "-180", "45"]);
    comes_back(integer(i64::MIN, i64::MAX), &["0", "-7", "9223372036854775807"]);
    comes_back(count::<u32>(0, 10), &["0", "10"]);
    comes_back(or_false(number()), &["false", "2"]);
    comes_back(or_word(count::<u8>(0, 10), "none"), &["'none'", "2"]);
    comes_back(flag(), &["true", "false"]);
    comes_back(text(), &["'a'", "'é \"x\"'", "\"a\\\\b\\n'c'\""]);
    comes_back(name(), &["'front left'"]);
    comes_back(one_of(&[("one", 1), ("two", 2)]), &["'one'", "'two'"]);
    comes_back(list(vector::<_, 2>(within(0.0, 1.0))), &["[]", "[[0, 1], [0.25, 1]]"]);
}

#[test]
fn a_place_is_kept_with_the_meaning() {
    let all = settings(|root| root.required("x", placed(number().about("how far"))));
    assert_eq!((all[0].about.as_str(), all[0].expected.as_str()), ("how far", "a finite number"));
    comes_back(vector::<_, 1>(placed(number())), &["[1]"]);
}

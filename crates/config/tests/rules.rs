//! Every rule: what it takes, and what it says about what it doesn't.
#![allow(clippy::unwrap_used, missing_docs)]

use std::fmt::Debug;

use config::{
    Document, Placed, Rule, above, angle_deg, at_least, count, flag, integer, list, name, number,
    one_of, or_false, or_word, placed, text, vector, within,
};

/// `x = value` read by a rule.
fn read<R: Rule>(rule: R, value: &str) -> Result<R::Out, String> {
    let document = Document::parse("f", &format!("x = {value}")).unwrap();
    document.read(|root| root.required("x", rule)).map_err(|problems| problems.to_string())
}

/// What a rule says after `x must be`, for a value at column 5.
fn says<R: Rule<Out: Debug>>(rule: R, value: &str) -> String {
    let message = read(rule, value).unwrap_err();
    message.strip_prefix("f:1:5: x must be ").unwrap_or(&message).to_owned()
}

#[test]
fn numbers_keep_their_bounds() {
    assert_eq!(read(number(), "-1.5"), Ok(-1.5));
    assert_eq!(read(number(), "3"), Ok(3.0), "a whole one, too");
    assert_eq!(read(within(0.0, 1.0), "0"), Ok(0.0));
    assert_eq!(read(within(0.0, 1.0), "1"), Ok(1.0));
    assert_eq!(read(above(0.0), "1e-300"), Ok(1e-300));
    assert_eq!(read(above(0.0).up_to(2.0), "2"), Ok(2.0));
    assert_eq!(read(at_least(2.0), "2"), Ok(2.0));
}

#[test]
fn numbers_say_their_bounds() {
    assert_eq!(says(number(), "inf"), "a finite number, got inf");
    assert_eq!(says(number(), "-nan"), "a finite number, got nan");
    assert_eq!(says(number(), "true"), "a finite number, got true");
    assert_eq!(says(within(0.0, 1.0), "1.5"), "a number from 0 to 1, got 1.5");
    assert_eq!(says(within(0.0, 1.0), "nan"), "a number from 0 to 1, got nan");
    assert_eq!(says(within(0.0, 1.0), "-1"), "a number from 0 to 1, got -1");
    assert_eq!(says(above(0.0), "0.0"), "a number above 0, got 0.0");
    assert_eq!(says(above(0.0).up_to(1e9), "2e9"), "a number above 0, up to 1e9, got 2000000000.0");
    assert_eq!(says(at_least(0.5), "0.25"), "a number of at least 0.5, got 0.25");
    assert_eq!(says(within(1e-6, 1e6), "0"), "a number from 1e-6 to 1e6, got 0");
}

#[test]
fn angles_arrive_in_radians() {
    assert_eq!(read(angle_deg(), "180"), Ok(std::f64::consts::PI));
    assert_eq!(says(angle_deg(), "181"), "a number from -180 to 180, got 181");
}

#[test]
fn whole_numbers_have_no_point() {
    assert_eq!(read(integer(1, 8), "8"), Ok(8));
    assert_eq!(read(integer(0, 255), "0xff"), Ok(255));
    assert_eq!(says(integer(1, 8), "9"), "a whole number from 1 to 8, got 9");
    assert_eq!(says(integer(1, 8), "2.0"), "a whole number from 1 to 8, got 2.0");
    assert_eq!(says(integer(1, i64::MAX), "0"), "a whole number of at least 1, got 0");
}

#[test]
fn a_count_fits_its_integer() {
    assert_eq!(read(count::<usize>(1, 3), "3"), Ok(3));
    assert_eq!(says(count::<usize>(1, 3), "4"), "a whole number from 1 to 3, got 4");
    // Beyond the type, too.
    assert_eq!(says(count::<u8>(0, 1000), "300"), "a whole number from 0 to 1000, got 300");
}

#[test]
fn a_word_stands_for_none() {
    assert_eq!(read(or_false(within(0.0, 1.0)), "0.5"), Ok(Some(0.5)));
    assert_eq!(read(or_false(within(0.0, 1.0)), "false"), Ok(None));
    assert_eq!(read(or_word(within(0.0, 1.0), "model"), "'model'"), Ok(None));
    assert_eq!(says(or_false(within(0.0, 1.0)), "true"), "a number from 0 to 1 or false, got true");
}

#[test]
fn flags_are_words() {
    assert_eq!(read(flag(), "true"), Ok(true));
    assert_eq!(says(flag(), "1"), "true or false, got 1");
    assert_eq!(says(flag(), "'yes'"), "true or false, got \"yes\"");
}

#[test]
fn texts_have_letters() {
    assert_eq!(read(text(), "'a b'"), Ok("a b".into()));
    assert_eq!(says(text(), "' '"), "a text that isn't empty, got \" \"");
    assert_eq!(says(text(), "2024-02-29"), "a text, got the date 2024-02-29");
    assert_eq!(says(text(), "{ a = 1 }"), "a text, got a table");
}

#[test]
fn names_fit_into_a_message_and_a_path() {
    let form = "1 to 60 characters on one line, without /";
    assert_eq!(read(name(), "'zwölf'"), Ok("zwölf".into()));
    assert_eq!(read(name(), &format!("'{}'", "ö".repeat(60))), Ok("ö".repeat(60)));
    assert_eq!(says(name(), "'a/b'"), format!("{form}, got \"a/b\""));
    assert_eq!(says(name(), r#""a\nb""#), format!(r#"{form}, got "a\nb""#));
    assert_eq!(says(name(), "3"), "a name, got 3");
    let long = says(name(), &format!("'{}'", "a".repeat(61)));
    assert_eq!(long, format!("{form}, got \"{}...\"", "a".repeat(60)));
}

#[test]
fn words_are_suggested() {
    let choices = [("geometric", 1), ("linear", 2)];
    assert_eq!(read(one_of(&choices), "'linear'"), Ok(2));
    let words = "\"geometric\" or \"linear\"";
    let expected = format!("{words}, got \"geometrik\", did you mean 'geometric'?");
    assert_eq!(says(one_of(&choices), "'geometrik'"), expected);
    assert_eq!(says(one_of(&choices), "'sum'"), format!("{words}, got \"sum\""));
    assert_eq!(says(one_of(&choices), "2"), format!("{words}, got 2"));
}

/// Within a list the place is that of the value.
#[test]
fn lists_tell_which_value() {
    assert_eq!(read(list(flag()), "[]"), Ok(vec![]));
    assert_eq!(says(list(flag()), "true"), "a list, each true or false, got true");
    let expected = "f:1:13: x[2] must be true or false, got 0";
    assert_eq!(read(list(flag()), "[true,  0]"), Err(expected.replace("[2]", "[1]")));
    let nested = list(list(integer(0, 1)));
    let expected = "f:1:15: x[1][1] must be a whole number from 0 to 1, got 2";
    assert_eq!(read(nested, "[[0], [1, 2]]"), Err(expected.into()));
}

#[test]
fn vectors_have_a_length() {
    assert_eq!(read(vector(number()), "[1, 2.5]"), Ok([1.0, 2.5]));
    let three = vector::<_, 3>(within(0.0, 1.0));
    let expected = "a list of 3, each a number from 0 to 1, got [0.0, 1.0]";
    assert_eq!(says(three, "[0.0, 1.0]"), expected);
    let expected = "f:1:12: x[2] must be a number from 0 to 1, got 7";
    assert_eq!(read(three, "[0, 1, 7]"), Err(expected.into()));
    let long = says(three, &format!("[{}]", "0,".repeat(50)));
    assert_eq!(long, "a list of 3, each a number from 0 to 1, got a list of 50");
}

#[test]
fn places_are_kept_on_demand() {
    let Placed { value, place } = read(placed(list(placed(flag()))), "[false]").unwrap();
    assert_eq!(place.to_string(), "f:1:5");
    assert_eq!(value[0].place.to_string(), "f:1:6");
    assert_eq!(says(placed(flag()), "0"), "true or false, got 0");
}

#[test]
fn numbers_that_64_bits_cannot_hold_are_no_numbers() {
    let refused =
        |value: &str| Document::parse("f", &format!("x = {value}")).unwrap_err().to_string();
    let expected = "f:1:5: a number that 64 bits can hold expected, got ";
    assert_eq!(refused("9223372036854775808"), format!("{expected}9223372036854775808"));
    assert_eq!(refused("1e999"), format!("{expected}1e999"));
    assert!(Document::parse("f", "x = -9223372036854775808").is_ok());
}

//! Settings as a flat list of keys and values: to write them, and to compare them.

use serde::Serialize;
use toml::{Table, Value};

/// Settings as a TOML table.
pub(super) fn table(settings: &impl Serialize) -> Table {
    // Plain structs of numbers and texts can always be written: there's nothing to report.
    Table::try_from(settings).unwrap_or_default()
}

/// All keys that hold no table, with dots between, in the order of the table.
pub(super) fn leaves(table: &Table) -> Vec<(String, Value)> {
    let mut all = Vec::new();
    collect("", table, &mut all);
    all
}

fn collect(path: &str, table: &Table, all: &mut Vec<(String, Value)>) {
    for (name, value) in table {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        match value {
            Value::Table(inner) => collect(&path, inner, all),
            _ => all.push((path, value.clone())),
        }
    }
}

/// What stands at a path of keys with dots between.
pub(super) fn get<'a>(table: &'a Table, path: &str) -> Option<&'a Value> {
    match path.split_once('.') {
        None => table.get(path),
        Some((first, rest)) => get(table.get(first)?.as_table()?, rest),
    }
}

/// Puts a value at a path of keys with dots between.
pub(super) fn put(table: &mut Table, path: &str, value: Value) {
    match path.split_once('.') {
        None => {
            table.insert(path.into(), value);
        }
        Some((first, rest)) => {
            let inner = table.entry(first).or_insert_with(|| Table::new().into());
            if let Value::Table(inner) = inner {
                put(inner, rest, value);
            }
        }
    }
}

/// A value on one line, with the keys of tables in their order: TOML's own writer puts plain values
/// before tables, and what a swept value is called depends on the order.
pub(super) fn inline(value: &Value) -> String {
    match value {
        Value::Array(items) => {
            let items: Vec<_> = items.iter().map(inline).collect();
            format!("[{}]", items.join(", "))
        }
        Value::Table(table) if table.is_empty() => "{}".into(),
        Value::Table(table) => {
            let entry =
                |(name, value): (&String, &Value)| format!("{} = {}", key(name), inline(value));
            format!("{{ {} }}", table.iter().map(entry).collect::<Vec<_>>().join(", "))
        }
        plain => plain.to_string(),
    }
}

/// A name as the key of a line, in quotes where it needs them.
pub(super) fn key(name: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
    match !name.is_empty() && name.chars().all(is_bare) {
        true => name.into(),
        false => Value::from(name).to_string(),
    }
}

/// A value as a person would write it: 1 for 1.0.
pub(super) fn shown(value: &Value) -> String {
    match value {
        Value::Float(number) if number.fract() == 0.0 && number.abs() < 1e15 => number.to_string(),
        Value::Float(number) => format!("{number:?}"),
        Value::Array(items) => {
            let items: Vec<_> = items.iter().map(shown).collect();
            format!("[{}]", items.join(", "))
        }
        Value::Table(table) => {
            let entries: Vec<_> =
                table.iter().map(|(key, value)| format!("{key} = {}", shown(value))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn leaves_put_back_make_the_table() {
        let table: Table = "a = 1\n[b]\nc = [1, 2]\n[b.d]\ne = 'x'".parse().unwrap();
        let mut other = Table::new();
        for (path, value) in leaves(&table) {
            put(&mut other, &path, value);
        }
        assert_eq!(other, table);
    }

    #[test]
    fn a_value_on_one_line_keeps_its_order() {
        let text = r#"[{ mix = { power = 1.5, xi = 0 }, "a.b" = [true, "c"], scale = 10 }, {}]"#;
        let table: Table = format!("x = {text}").parse().unwrap();
        assert_eq!(inline(&table["x"]), text);
        assert_eq!(key("reward.mix.xi"), "\"reward.mix.xi\"");
    }

    #[test]
    fn numbers_are_shown_as_people_write_them() {
        let shown = |text: &str| shown(&text.parse::<Table>().unwrap()["x"]);
        assert_eq!(shown("x = 1.0"), "1");
        assert_eq!(shown("x = 1e-5"), "1e-5");
        assert_eq!(shown("x = [0.5, 2.0]"), "[0.5, 2]");
        assert_eq!(shown("x = { a = 'b' }"), "{ a = \"b\" }");
    }
}

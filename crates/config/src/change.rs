//! A value changed in a document by a path that finds tables of lists by their names, and may mean
//! several of them.

use crate::{
    Document, Key, Node, Place, Problems, Value, shown, suggestion,
    value::{DEEPEST, TOO_DEEP},
};

/// In a path: whatever there is.
const EACH: &str = "*";

impl Document {
    /// Puts a value at a path of keys with dots between, as [`Document::replace`] does; but a path
    /// goes through a list of tables by the `name` of one of them, `body.torso.mass_kg`, and by `*`
    /// through each table or item there is: `servo.*.torque_limit_nm`.
    ///
    /// # Errors
    /// Those of [`Document::replace`]; a name that no table of a list has; `*` where there is nothing.
    pub fn change(&mut self, path: &str, place: &Place, node: &Node) -> Result<(), Problems> {
        let refuse = |message: String| Problems::one(place.clone(), message);
        let names: Vec<_> = path.split('.').collect();
        if names.len() > DEEPEST {
            return Err(refuse(TOO_DEEP.into()));
        }
        put(self.root_mut(), &names, place, node)
            .map_err(|why| refuse(format!("{} lies within {why}", shown(path))))
    }
}

/// If it can't be put there, what the path runs into.
fn put(at: &mut Node, path: &[&str], place: &Place, node: &Node) -> Result<(), String> {
    let Some((first, rest)) = path.split_first() else {
        *at = node.clone();
        return Ok(());
    };
    let found: Vec<&mut Node> = match &mut at.value {
        Value::Table(entries) => {
            if *first != EACH && entries.iter().all(|(key, _)| key.name != *first) {
                let key = Key { place: place.clone(), name: (*first).into() };
                let empty = Node { place: place.clone(), value: Value::Table(Vec::new()) };
                entries.push((key, empty));
            }
            let is_meant = |name: &str| [EACH, name].contains(first);
            entries
                .iter_mut()
                .filter(|(key, _)| is_meant(&key.name))
                .map(|(_, node)| node)
                .collect()
        }
        Value::List(items) if items.iter().all(|item| name(item).is_some()) => {
            let alike = suggestion(first, items.iter().filter_map(name));
            let is_meant = |item: &&mut Node| *first == EACH || name(item) == Some(first);
            let meant: Vec<_> = items.iter_mut().filter(is_meant).collect();
            if meant.is_empty() {
                let first = shown(first);
                return Err(format!("a list in which nothing is called '{first}'{alike}"));
            }
            meant
        }
        _ => return Err("something that isn't a table".into()),
    };
    if found.is_empty() {
        return Err("an empty table".into());
    }
    found.into_iter().try_for_each(|inner| put(inner, rest, place, node))
}

/// The `name` that a table has.
fn name(node: &Node) -> Option<&str> {
    let Value::Table(entries) = &node.value else { return None };
    entries.iter().find_map(|(key, node)| match &node.value {
        Value::Text(name) if key.name == "name" => Some(name.as_str()),
        _ => None,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const FILE: &str = "speeds = [1, 2]\n\
        [servo.'front hip']\nspeed = 1\n[servo.knee]\nspeed = 2\n\
        [[body]]\nname = 'torso'\n[[body]]\nname = 'head'\nshape.radius_m = 1\n";

    fn changed(path: &str) -> Result<Document, String> {
        let mut document = Document::parse("f", FILE).unwrap();
        let node = Document::parse("g", "x = 7").unwrap().get("x").unwrap().clone();
        let place = Place { line: 3, column: 5, source: "experiment".into() };
        match document.change(path, &place, &node) {
            Ok(()) => Ok(document),
            Err(problems) => Err(problems.to_string()),
        }
    }

    /// A document without places.
    fn plain(node: &Node) -> String {
        match &node.value {
            Value::Table(entries) => {
                let entry = |(key, node): &(Key, Node)| format!("{} = {}", key.name, plain(node));
                format!("{{{}}}", entries.iter().map(entry).collect::<Vec<_>>().join(", "))
            }
            Value::List(items) => format!("{:?}", items.iter().map(plain).collect::<Vec<_>>()),
            other => other.to_string(),
        }
    }

    #[test]
    fn a_path_finds_keys_names_and_all_there_are() {
        for (path, from, to) in [
            ("servo.front hip.speed", "speed = 1", "speed = 7"),
            (
                "servo.*.speed",
                "speed = 1\n[servo.knee]\nspeed = 2",
                "speed = 7\n[servo.knee]\nspeed = 7",
            ),
            ("servo.knee.force", "speed = 2", "speed = 2\nforce = 7"),
            ("body.torso.mass_kg", "name = 'torso'", "name = 'torso'\nmass_kg = 7"),
            ("body.head.shape.*", "radius_m = 1", "radius_m = 7"),
            ("start.x", "radius_m = 1\n", "radius_m = 1\n[start]\nx = 7"),
            ("speeds", "speeds = [1, 2]", "speeds = 7"),
        ] {
            let mut expected = Document::parse("f", &FILE.replace(from, to)).unwrap();
            let mut found = changed(path).unwrap();
            assert_eq!(plain(found.root_mut()), plain(expected.root_mut()), "{path}");
        }
    }

    #[test]
    fn what_a_path_runs_into_is_named() {
        for (path, why) in [
            (
                "body.trso.mass_kg",
                "a list in which nothing is called 'trso', did you mean 'torso'?",
            ),
            ("body.torso.name.x", "something that isn't a table"),
            ("body.*.shape.*", "an empty table"),
            ("speeds.*", "something that isn't a table"),
        ] {
            let expected = format!("experiment:3:5: {path} lies within {why}");
            assert_eq!(changed(path).unwrap_err(), expected);
        }
        let deep = changed(&["x"; 33].join(".")).unwrap_err();
        assert_eq!(deep, format!("experiment:3:5: {TOO_DEEP}"));
    }
}

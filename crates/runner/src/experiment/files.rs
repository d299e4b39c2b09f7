//! Settings that are paths of files: the model, and the policy that a cell starts from. Where they
//! are found, what folders and copies call them, and how a plan is written with other paths.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use config::{Node, Value};

use super::axis::safe;

/// The robot.
pub(super) const MODEL: &str = "model";

/// The parameters at the beginning.
pub(super) const INITIAL: &str = "policy.initial";

/// The keys that hold a path.
pub(super) const KEYS: [&str; 2] = [MODEL, INITIAL];

/// Makes paths absolute that stand at a key of an experiment, below it or in lists there. They are
/// relative to `folder`, or to the current one if they are from the command line.
pub(super) fn make_absolute(key: &str, node: &mut Node, folder: &Path) {
    match &mut node.value {
        Value::Table(entries) => {
            for (inner, node) in entries {
                make_absolute(&below(key, &inner.name), node, folder);
            }
        }
        Value::List(items) => items.iter_mut().for_each(|item| make_absolute(key, item, folder)),
        Value::Text(text) if KEYS.contains(&key) && !text.trim().is_empty() => {
            let folder = if node.place.line == 0 { Path::new("") } else { folder };
            *text = absolute(&folder.join(&text));
        }
        _ => {}
    }
}

/// A path as experiments have those of their files: absolute, and the file's own where it is there
/// and the path leads to it by links. If it isn't, whoever opens it will say so.
#[must_use]
pub fn absolute(path: &Path) -> String {
    let found = path.canonicalize().or_else(|_| std::path::absolute(path));
    found.as_deref().unwrap_or(path).to_string_lossy().into_owned()
}

/// A value at a key with other paths in it.
pub(super) fn with_paths(
    key: &str,
    value: toml::Value,
    other: &impl Fn(&str) -> String,
) -> toml::Value {
    match value {
        toml::Value::String(path) if KEYS.contains(&key) => other(&path).into(),
        toml::Value::Table(table) => {
            let entry = |(name, value): (String, toml::Value)| {
                let value = with_paths(&below(key, &name), value, other);
                (name, value)
            };
            table.into_iter().map(entry).collect::<toml::Table>().into()
        }
        value => value,
    }
}

/// The key of what stands in a table.
pub(super) fn below(key: &str, name: &str) -> String {
    if key.is_empty() { name.into() } else { format!("{key}.{name}") }
}

/// What a model's file is called, without its ending.
pub(super) fn stem(path: &str) -> String {
    Path::new(path).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// What folders and copies call policies' files, by their paths. An export is called by its cell,
/// `xi-1-seed-3`, another file by its own name, and those that come later by a number more, where
/// several would be called the same. Files in `policies/` with these names, in the same order, are
/// called the same again.
pub fn policy_names<'a>(paths: impl IntoIterator<Item = &'a str>) -> BTreeMap<&'a str, String> {
    let (mut names, mut taken, mut last) = (BTreeMap::new(), BTreeSet::new(), BTreeMap::new());
    for path in paths {
        if names.contains_key(path) {
            continue;
        }
        let own = policy_name(Path::new(path));
        let mut name = own.clone();
        let number = last.entry(own.clone()).or_insert(1);
        while !taken.insert(name.clone()) {
            *number += 1;
            name = format!("{own}-{number}");
        }
        names.insert(path, name);
    }
    names
}

fn policy_name(path: &Path) -> String {
    let name = |path: Option<&Path>| {
        path.and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned()
    };
    let folder = path.parent();
    let seed = name(folder);
    if name(Some(path)) == "policy.safetensors" && seed.starts_with("seed=") {
        let setting = name(folder.and_then(Path::parent));
        return safe(&format!("{setting},{seed}"));
    }
    safe(&stem(&path.to_string_lossy()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exports_are_called_by_their_cells_and_all_by_names_of_their_own() {
        let paths = [
            "/runs/a/cells/xi=0.75,power=2/seed=3/policy.safetensors",
            "/runs/b/cells/xi=0.75,power=2/seed=3/policy.safetensors",
            "/runs/a/cells/xi=0.75,power=2/seed=3/policy.safetensors",
            "/b/good-2.safetensors",
            "/b/good.safetensors",
            "/c/good.safetensors",
            "/c/a good one",
            "/policies/policy.safetensors",
        ];
        let expected = [
            "xi-0.75-power-2-seed-3",
            "xi-0.75-power-2-seed-3-2",
            "xi-0.75-power-2-seed-3",
            "good-2",
            "good",
            "good-3",
            "a-good-one",
            "policy",
        ];
        let names = policy_names(paths);
        assert_eq!(paths.map(|path| names[path].as_str()), expected);
        let copies: Vec<_> =
            expected.iter().map(|name| format!("/run/policies/{name}.safetensors")).collect();
        let names = policy_names(copies.iter().map(String::as_str));
        let again: Vec<_> = copies.iter().map(|copy| names[copy.as_str()].as_str()).collect();
        assert_eq!(again, expected);
    }
}

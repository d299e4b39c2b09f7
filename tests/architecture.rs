//! ARCHITECTURE.md and docs/ say what is true.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{
    collections::BTreeSet,
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn read(file: &str) -> String {
    fs::read_to_string(root().join(file)).unwrap()
}

/// The text between ```` ```kind ```` and the next fence.
fn fenced(text: &str, kind: &str) -> String {
    let start = text.find(&format!("```{kind}\n")).unwrap() + kind.len() + 4;
    let end = text[start..].find("```").unwrap();
    text[start..start + end].into()
}

/// "from -> to" for every dependency of one of our crates on another, and our crates' names.
fn arrows_in_the_workspace() -> (BTreeSet<String>, BTreeSet<String>) {
    let metadata = cargo_metadata::MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        .no_deps()
        .exec()
        .unwrap();
    let names: BTreeSet<String> = metadata.packages.iter().map(|p| p.name.to_string()).collect();
    let arrows = metadata
        .packages
        .iter()
        .flat_map(|package| {
            package.dependencies.iter().map(move |to| format!("{} -> {}", package.name, to.name))
        })
        .filter(|arrow| names.contains(arrow.split(" -> ").nth(1).unwrap()))
        .collect();
    (arrows, names)
}

#[test]
fn crates_depend_on_each_other_as_the_architecture_says() {
    let allowed: BTreeSet<String> =
        fenced(&read("ARCHITECTURE.md"), "arrows").lines().map(str::to_owned).collect();
    let (arrows, _) = arrows_in_the_workspace();
    let others: Vec<_> = arrows.difference(&allowed).collect();
    assert!(others.is_empty(), "not among the arrows of ARCHITECTURE.md: {others:?}");
    let missing: Vec<_> = allowed.difference(&arrows).collect();
    assert!(missing.is_empty(), "arrows of ARCHITECTURE.md that nothing follows: {missing:?}");
}

/// All that is built for a crate alone, by name.
fn built_for(name: &str) -> BTreeSet<String> {
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--edges", "normal,build", "--prefix", "none", "-p", name])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
    let lines = String::from_utf8(tree.stdout).unwrap();
    lines.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect()
}

/// The features of others are no arrow, and could bring Bullet in: `svenja` has one that does.
#[test]
fn what_reads_and_draws_is_built_without_physics_and_training() {
    let (_, ours) = arrows_in_the_workspace();
    for (name, others) in [
        ("runs", &[][..]),
        ("scenes", &["config", "runs", "svenja"]),
        ("figures", &["config", "runs", "scenes", "svenja"]),
    ] {
        let built = built_for(name);
        let built: Vec<_> = built.intersection(&ours).filter(|it| *it != name).collect();
        assert_eq!(built, others, "built for {name}");
    }
    assert!(built_for("runner").contains("bullet"));
}

#[test]
fn every_crate_has_its_row_in_the_architecture() {
    let page = read("ARCHITECTURE.md");
    let (_, names) = arrows_in_the_workspace();
    for name in names {
        // What isn't only Rust has a folder beside them.
        let rows = ["crates/", ""].map(|folder| format!("| `{folder}{name}/` | "));
        let is_row = |line: &str| rows.iter().any(|row| line.starts_with(row));
        assert!(page.lines().any(is_row), "{name}");
    }
}

/// A column that says the same of all tells nothing.
#[test]
fn every_column_of_the_architecture_tells_rows_apart() {
    let page = read("ARCHITECTURE.md");
    let is_row = |line: &&str| line.starts_with('|');
    for table in page.split("\n\n") {
        let rows: Vec<Vec<&str>> = table
            .lines()
            .filter(is_row)
            .skip(2)
            .map(|row| row.trim_matches('|').split(" | ").map(str::trim).collect())
            .collect();
        let n_columns = rows.iter().map(Vec::len).min().unwrap_or(0);
        for column in (0..n_columns).filter(|_| rows.len() > 1) {
            let is_same = |row: &Vec<&str>| row[column] == rows[0][column];
            assert!(!rows.iter().all(is_same), "{:?} in all rows", rows[0][column]);
        }
    }
}

/// The figure is what the commands beside it make: `quick.toml`, all of its updates and seeds.
#[test]
fn the_figure_of_the_readme_is_of_its_experiment() {
    let quick = read("experiments/quick.toml");
    let value = |key: &str| {
        let line = quick.lines().find_map(|line| line.strip_prefix(key)).unwrap();
        line.trim_start_matches([' ', '=']).parse::<u64>().unwrap()
    };
    let (updates, seeds) = (value("updates"), value("seeds"));
    let readme = read("README.md");
    let figure = format!("over {updates} updates](docs/images/learning-curves.svg)");
    assert!(readme.contains(&figure), "README.md should have a figure {figure}");
    assert!(readme.contains(&format!("In updates 145 to {updates} ")));

    let svg = read("docs/images/learning-curves.svg");
    let texts: Vec<_> = svg.lines().map(str::trim).filter(|line| !line.contains('<')).collect();
    for text in [&format!("n = {seeds}"), "ξ = 0.75", "ξ = 1"] {
        assert!(texts.contains(&text), "no {text:?} in the figure");
    }
    let numbers = texts.iter().filter_map(|text| text.parse::<u64>().ok());
    let last = numbers.max().unwrap();
    assert!((updates * 3 / 4..=updates).contains(&last), "the axis of updates ends at {last}");
}

/// Every file of the repository, as git lists them.
fn files() -> Vec<String> {
    let list = Command::new("git").arg("ls-files").current_dir(root()).output().unwrap();
    String::from_utf8(list.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// `crates/bullet/src/body.rs`, `tests/fidelity.rs`, `state.h`, `cpp/`: by the end of a path, or as a
/// folder. What's "to come" needn't be there.
#[test]
fn files_named_in_documents_exist() {
    let files = files();
    for document in ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "docs/bindings.md"] {
        let text = read(document);
        let prose = text.split("```").step_by(2).flat_map(str::lines);
        for line in prose.filter(|line| !line.contains("to come")) {
            let names = line
                .split('`')
                .skip(1)
                .step_by(2)
                .chain(line.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()));
            for name in names.filter(|name| is_path(name)) {
                let name = name.trim_start_matches("../").trim_end_matches('/');
                let there = files.iter().any(|file| {
                    file == name
                        || file.ends_with(&format!("/{name}"))
                        || format!("/{file}").contains(&format!("/{name}/"))
                });
                assert!(there, "{document} names {name}");
            }
        }
    }
}

fn is_path(name: &str) -> bool {
    let plain = name.chars().all(|c| c.is_ascii_alphanumeric() || "._/-".contains(c));
    let file = [".rs", ".cc", ".h", ".md", ".toml"].iter().any(|end| name.ends_with(end));
    plain && (file || name.contains('/')) && !name.starts_with('/')
}

/// Of a source file.
const MOST_LINES: usize = 500;
/// Of a function's body, tests aside.
const MOST_LINES_OF_A_FUNCTION: usize = 50;

/// A file is one concept, and a function can be read at one look.
#[test]
fn files_and_functions_are_short() {
    let is_source = |file: &&String| {
        let (_, extension) = file.rsplit_once('.').unwrap_or_default();
        ["rs", "cc", "h", "inc", "js"].contains(&extension) && !file.contains("/assets/three/")
    };
    let (mut too_long, mut n_functions) = (Vec::new(), 0);
    for file in files().iter().filter(is_source) {
        let text = read(file);
        let n_lines = text.lines().count();
        if n_lines > MOST_LINES {
            too_long.push(format!("{file}: {n_lines} lines"));
        }
        for (line, n_lines) in functions(file, &text) {
            n_functions += 1;
            if n_lines > MOST_LINES_OF_A_FUNCTION {
                too_long.push(format!("{file}:{line}: a function of {n_lines} lines"));
            }
        }
    }
    assert!(n_functions > 2000, "{n_functions} functions found");
    assert!(too_long.is_empty(), "\n{}", too_long.join("\n"));
}

#[test]
fn functions_are_counted_as_they_are_formatted() {
    let rust = "impl A {\n    pub(crate) fn a(\n        &self,\n    ) -> u8 {\n        1\n    }\n}\n\n\
                fn b() {\n    if a {\n        2\n    }\n}\n#[cfg(test)]\nmod tests {\n    fn c() {\n\
                    }\n}\n";
    assert_eq!(functions("crates/a/src/lib.rs", rust), [(2, 1), (9, 3)]);
    assert_eq!(functions("crates/a/tests/a.rs", rust), []);
    let cpp = "namespace a {\n\nint A::b(int c,\n         int d) const {\n  if (c) {\n    return 1;\n  }\n\
               \n  return d;\n}\n\n}  // namespace a\n";
    assert_eq!(functions("cpp/a.cc", cpp), [(4, 5), (5, 1)]);
}

/// The line of each function's head, and the number of lines of its body: by the indentation, which
/// formatters see to. In C++ also of blocks with a condition, which are within a function.
fn functions(file: &str, text: &str) -> Vec<(usize, usize)> {
    let is_rust = file.ends_with(".rs");
    let is_test = file.contains("/tests") || file.starts_with("tests/");
    if is_test || is_rust && !file.contains("/src/") {
        return Vec::new();
    }
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let indentation = |line: &str| line.len() - line.trim_start().len();
    let is_head = |line: &str| match is_rust {
        true => !line.starts_with("//") && (line.starts_with("fn ") || line.contains(" fn ")),
        false => line.ends_with('{') && line.contains(')'),
    };
    let mut functions = Vec::new();
    for head in (0..lines.len()).filter(|&i| is_head(lines[i].trim_start())) {
        let is_end = |it: &&str| ['{', ';', '}'].iter().any(|&end| it.ends_with(end));
        let n_head = lines[head..].iter().position(|it| is_end(&it.trim_end())).unwrap();
        let body = &lines[head + n_head + 1..];
        if lines[head + n_head].ends_with('{') {
            let goes_on = |it: &&&str| {
                let text = it.trim();
                !text.is_empty() && !text.starts_with("//") && !text.ends_with([';', '{', '}', ':'])
            };
            // In C++ a signature may begin some lines above.
            let first = head - lines[..head].iter().rev().take_while(goes_on).count();
            let outer = indentation(lines[if is_rust { head } else { first }]);
            let closes = |it: &&str| it.trim_start().starts_with('}') && indentation(it) <= outer;
            functions.push((head + 1, body.iter().position(closes).unwrap()));
        }
    }
    functions
}

/// The page binds a class that isn't bound, as a diff: it must still fit the code.
#[test]
fn the_example_of_a_new_binding_applies() {
    let diff = fenced(&read("docs/bindings.md"), "diff");
    let mut patch = Command::new("git")
        .args(["apply", "--check", "-"])
        .current_dir(root())
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    patch.stdin.take().unwrap().write_all(diff.as_bytes()).unwrap();
    assert!(patch.wait().unwrap().success(), "the diff in docs/bindings.md no longer applies");
}

/// Rustdoc shows a field or a variant alone: what leans on its neighbours says nothing there.
#[test]
fn public_items_are_explained_in_sentences() {
    const LEANING: [&str; 22] = [
        "As above",
        "As there",
        "Among them",
        "From 0.",
        "From 1",
        "Of ",
        "In kg",
        "In m.",
        "In m/",
        "In rad",
        "In N",
        "In words",
        "In pixels",
        "Both",
        "All.",
        "All of them",
        "Each by itself",
        "Nothing.",
        "Anywhere",
        "Where.",
        "What.",
        "How far.",
    ];
    let mut leaning = Vec::new();
    let mut folders = vec![root().join("crates")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
            let path = entry.path();
            if path.is_dir() && entry.file_name() != "tests" && entry.file_name() != "benches" {
                folders.push(path);
            } else if path.extension().is_some_and(|it| it == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                for (line, document) in documents(&text) {
                    let is_short = document.split_whitespace().count() < 2;
                    if is_short
                        || LEANING.iter().any(|start| document.starts_with(start))
                        || document.ends_with("As there.")
                    {
                        leaning.push(format!("{}:{line}: {document}", path.display()));
                    }
                }
            }
        }
    }
    assert!(leaning.is_empty(), "\n{}", leaning.join("\n"));
}

/// The comments of public items, and of their fields and variants, up to a file's tests; each with the
/// number of its first line.
fn documents(text: &str) -> Vec<(usize, String)> {
    let text = text.split("#[cfg(test)]").next().unwrap_or_default();
    let mut documents = Vec::new();
    let mut open: Option<(usize, String)> = None;
    for (i, line) in text.lines().map(str::trim).enumerate() {
        if let Some(comment) = line.strip_prefix("///") {
            let (_, document) = open.get_or_insert((i + 1, String::new()));
            document.push_str(comment);
        } else if !line.starts_with("#[") {
            let is_variant = || {
                let name = line.split(['(', ' ', ',', '{']).next().unwrap_or_default();
                let is_name = name.chars().all(|c| c.is_ascii_alphanumeric());
                is_name && name.starts_with(|c: char| c.is_ascii_uppercase())
            };
            let is_public = line.starts_with("pub ") || is_variant();
            documents.extend(open.take().filter(|_| is_public));
        }
    }
    documents.into_iter().map(|(line, text)| (line, text.trim().to_owned())).collect()
}

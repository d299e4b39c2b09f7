//! CONTRIBUTING.md adds one of each thing, as diffs: they fit the code, and touch one new file, one list and
//! the docs. (`contributions.rs` applies them.)

#[path = "common/diffs.rs"]
mod diffs;

use diffs::{apply, diffs, root};

#[test]
fn each_addition_is_one_new_file_and_one_list_and_docs() {
    let headings: Vec<_> = diffs().into_iter().map(|(heading, _)| heading).collect();
    let expected =
        ["An extrinsic reward", "An intrinsic reward", "A policy", "A robot", "A figure"];
    assert_eq!(headings, expected);
    for (heading, diff) in diffs() {
        apply(&root(), &["--check"], &diff, &heading);
        let files = diff.split("diff --git ").skip(1);
        let (new, changed): (Vec<_>, Vec<_>) =
            files.partition(|file| file.contains("\nnew file mode"));
        assert_eq!(new.len(), 1, "new files of {heading:?}");
        let is_doc = |file: &&str| file.lines().next().unwrap().ends_with(".md");
        // All files of models/ are robots: that list is its page.
        let n_lists = usize::from(heading != "A robot");
        let lists = changed.iter().filter(|file| !is_doc(file)).count();
        assert_eq!(lists, n_lists, "changed files of {heading:?} that are no docs");
    }
}

//! Landscapes: their points are rollouts, whoever makes them and whatever comes between.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;
use tempfile::TempDir;

/// Four cells that have learned for 30 updates.
fn done() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &[]).ends(DONE);
    (folder, run)
}

/// `itarl landscape` of a cell with small rollouts, and more words.
fn words<'a>(cell: &'a Path, out: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
    let words = ["landscape", text(cell), "--points", "5", "--steps", "40", "--repeats", "2"];
    [&words[..], &["--seed", "3", "--out", text(out)], more].concat()
}

/// Its rows by column names.
fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

/// Columns of the table of `itarl rollout`.
fn rollout(cell: &Path, seed: &str, columns: &[&str]) -> Vec<Vec<f64>> {
    let table = cell.with_extension("csv");
    let words = ["rollout", text(cell), "--steps", "40", "--seed", seed, "--csv", text(&table)];
    itarl(&words).ends(DONE);
    let rows = rows(&table);
    let of = |column: &&str| rows.iter().map(|row| row[*column].parse().unwrap()).collect();
    columns.iter().map(of).collect()
}

/// The numbers of a file in NumPy's format.
fn numbers(path: &Path) -> Vec<f64> {
    let bytes = fs::read(path).unwrap();
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    bytes[header..].as_chunks().0.iter().map(|it| f64::from_le_bytes(*it)).collect()
}

const TERMS: [&str; 8] = [
    "reward",
    "extrinsic_raw",
    "extrinsic",
    "intrinsic_nats",
    "intrinsic_nats_corrected",
    "intrinsic",
    "penalty",
    "xi",
];

/// Of each repeat, to the last bit; and so are the means over a rollout.
#[test]
fn the_middle_of_a_slice_is_a_rollout() {
    let (folder, run) = done();
    let (cell, out) = (run.join("cells/xi=0.75/seed=2"), folder.path().join("out"));
    itarl(&words(&cell, &out, &["--directions", "1"])).ends(DONE);
    let slice = fs::read_dir(out.join("rollouts")).unwrap().next().unwrap().unwrap().path();
    let mut means = vec![vec![]; 3];
    for seed in ["3", "4"] {
        let found = numbers(&slice.join(format!("{seed}-0.npy")));
        assert_eq!(found.len(), 5 * 40 * TERMS.len());
        let middle = &found[2 * 40 * TERMS.len()..][..40 * TERMS.len()];
        let expected = rollout(&cell, seed, &TERMS);
        for (step, found) in middle.chunks(TERMS.len()).enumerate() {
            for (term, found) in found.iter().enumerate() {
                let expected = expected[term][step];
                assert_eq!(found.to_bits(), expected.to_bits(), "{} {step}", TERMS[term]);
            }
        }
        // As the rollout's own report has them; the cell's own xi is .75.
        let advance = rollout(&cell, seed, &["advance_m", "intrinsic_nats", "reward"]);
        for (means, values) in means.iter_mut().zip(advance) {
            means.push(values.iter().fold(0.0, |sum, value| sum + value / 40.0));
        }
    }
    let points = rows(&out.join("points.csv"));
    for (function, means) in ["R_Loc", "R_MI", "xi=0.75"].iter().zip(means) {
        let row = points.iter().find(|row| row["function"] == *function && row["point"] == "2");
        let row = row.unwrap();
        assert_eq!(row["t1"], "0.0");
        assert_eq!(row["mean"].parse::<f64>().unwrap(), (means[0] + means[1]) / 2.0, "{function}");
    }
}

/// All kinds of slices, and gradients: the same bytes whoever steps the worlds, on how many threads and
/// lanes; whatever was there already; and after a death.
#[test]
fn bytes_do_not_depend_on_how_they_are_made() {
    let (folder, run) = done();
    let [a, b, c] =
        ["xi=0.75/seed=1", "xi=0.75/seed=2", "xi=1/seed=1"].map(|it| run.join("cells").join(it));
    let [one, other, third] = ["one", "other", "third"].map(|it| folder.path().join(it));
    let slices = [
        &["--directions", "2", "--plane", "--along-training", "--gradients", "3"][..],
        &["--between", text(&a), text(&b), "--between", text(&a), text(&c)],
    ]
    .concat();
    let all = |out: &Path, more: &[&str]| {
        let cells = [text(&b), text(&c)];
        itarl(&[&words(&a, out, &cells), &slices[..], more].concat()).ends(DONE)
    };
    let said = all(&one, &["--threads", "1", "--lanes", "1", "--solver", "bullet"]).out;
    for name in ["points.csv", "measures.csv", "summary.csv", "landscape-curves.svg"] {
        assert!(said.contains(name), "{said}");
    }
    all(&other, &["--threads", "3", "--lanes", "3"]);
    assert_same(&tree(&one), &tree(&other));

    // Some of it, then all.
    itarl(&words(&a, &third, &["--directions", "1"])).ends(DONE);
    let mut child = start(&[&words(&a, &third, &[text(&b), text(&c)]), &slices[..]].concat());
    let n_slices = || fs::read_dir(third.join("rollouts")).unwrap().count();
    wait_until(|| n_slices() > 2 || child.try_wait().unwrap().is_some());
    child.kill().ok();
    end(child);
    all(&third, &[]);
    // What a death leaves half is written over.
    assert_same(&tree(&one), &tree(&third));
}

#[test]
fn a_signal_stops_it_with_what_is_made() {
    let (folder, run) = done();
    let (cell, out) = (run.join("cells/xi=1/seed=1"), folder.path().join("out"));
    let child = start(&words(&cell, &out, &["--directions", "2000", "--threads", "1"]));
    let rollouts = out.join("rollouts");
    wait_until(|| rollouts.exists() && fs::read_dir(&rollouts).unwrap().count() > 2);
    signal(&child, "TERM");
    end(child).ends(STOPPED).complains(&["stopped; the same command goes on"]);
    assert!(tree(&rollouts).keys().all(|name| name.ends_with(".npy")));
    assert!(!out.join("summary.csv").exists());
}

/// The same rollouts have all mixes in them.
#[test]
fn another_mix_takes_no_rollout() {
    let (folder, run) = done();
    let (cell, out) = (run.join("cells/xi=1/seed=1"), folder.path().join("out"));
    itarl(&words(&cell, &out, &[])).ends(DONE);
    let before = tree(&out.join("rollouts"));
    // Were one made, its folder would have to be.
    let more = ["--xi", "0.1,0.9", "--mix", "kind = 'linear'"];
    itarl(&words(&cell, &out, &more)).ends(DONE);
    assert_same(&before, &tree(&out.join("rollouts")));
    let mut functions: Vec<_> =
        rows(&out.join("points.csv")).into_iter().map(|row| row["function"].clone()).collect();
    functions.sort();
    functions.dedup();
    assert_eq!(functions, ["R_Loc", "R_MI", "xi=0.1", "xi=0.9"]);
    // More repeats leave those that are there.
    itarl(&words(&cell, &out, &[])).ends(DONE);
    let more = words(&cell, &out, &[]).into_iter().map(|it| if it == "2" { "3" } else { it });
    itarl(&more.collect::<Vec<_>>()).ends(DONE);
    let after = tree(&out.join("rollouts"));
    assert_eq!(after.len(), before.len() / 2 * 3);
    assert!(before.iter().all(|(name, bytes)| after[name] == *bytes));
}

/// One repeat is drawn, and says nothing of its noise.
#[test]
fn one_repeat_makes_pictures_and_no_measures() {
    let (folder, run) = done();
    let (cell, out) = (run.join("cells/xi=1/seed=1"), folder.path().join("out"));
    let words = words(&cell, &out, &["--plane"]);
    let once: Vec<_> = words.iter().map(|it| if *it == "2" { "1" } else { it }).collect();
    itarl(&once).ends(DONE);
    assert!(rows(&out.join("measures.csv")).is_empty());
    assert!(rows(&out.join("summary.csv")).is_empty());
    let points = rows(&out.join("points.csv"));
    // Two lines of 5 points and a plane of 25, and R_Loc, R_MI and five mixes of each.
    assert_eq!(points.len(), 7 * (2 * 5 + 25));
    for point in &points {
        assert!(point["mean"].parse::<f64>().unwrap().is_finite());
        assert_eq!(point["standard_error"], "");
    }
    for picture in ["landscape-curves.svg", "landscape-maps.svg"] {
        assert!(!fs::read_to_string(out.join(picture)).unwrap().contains("NaN"), "{picture}");
    }
    // A second repeat uses the first, and then there are measures.
    itarl(&words).ends(DONE);
    assert!(!rows(&out.join("summary.csv")).is_empty());
}

#[test]
fn what_cannot_be_measured_is_said() {
    let (folder, run) = done();
    let (cell, out) = (run.join("cells/xi=1/seed=1"), folder.path().join("out"));
    let refused = |more: &[&str], what: &str| {
        itarl(&words(&cell, &out, more)).ends(FAILED).complains(&[what]);
    };
    refused(&["--span", "0"], "--span must be more than 0 and at most 1000000, got 0");
    refused(&["--xi", "0.5,1.5"], "--xi must be from 0 to 1, got 1.5");
    refused(&["--mix", "kind = 'cubic'"], "--mix:1:8: ");
    refused(&["--along-training"], "at least three cells expected that don't lie in a line");
    let even = ["landscape", text(&cell), "--points", "4", "--out", text(&out)];
    itarl(&even)
        .ends(FAILED)
        .complains(&["--points must be odd, so that one is the policy itself"]);
    let model = ["landscape", "tests/models/crawler.toml", "--out", text(&out)];
    itarl(&model).ends(FAILED).complains(&["crawler.toml: a cell's folder expected"]);
    itarl(&["landscape", "--out", text(&out)]).ends(USAGE);

    let other = folder.path().join("other");
    train(&other, &["--set", "policy.hidden_units=5"]).ends(DONE);
    let other = other.join("cells/xi=1/seed=1");
    let between = ["landscape", "--between", text(&cell), text(&other), "--out", text(&out)];
    itarl(&between).ends(FAILED).complains(&["two cells with the same policy expected"]);

    itarl(&words(&cell, &out, &["--directions", "1"])).ends(DONE);
    let (name, _) = tree(&out.join("rollouts")).into_iter().next().unwrap();
    let part = out.join("rollouts").join(name);
    let bytes = fs::read(&part).unwrap();
    fs::write(&part, &bytes[..bytes.len() / 2]).unwrap();
    refused(&["--directions", "1"], "if it's damaged, remove it, and it's made again");
    fs::remove_file(&part).unwrap();
    itarl(&words(&cell, &out, &["--directions", "1"])).ends(DONE);
    assert_eq!(fs::read(&part).unwrap(), bytes);
}

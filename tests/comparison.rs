//! Several runs side by side: `itarl summary`, `plot`, `report` and `findings` of more than one, with
//! numbers that are worked out again here from the recorded files.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;
use tempfile::TempDir;

/// Runs in one folder, each with other settings.
fn runs<const N: usize>(settings: [&[&str]; N]) -> (TempDir, [PathBuf; N]) {
    let folder = tempfile::tempdir().unwrap();
    let runs = std::array::from_fn(|i| folder.path().join(format!("run-{}", i + 1)));
    for (run, settings) in runs.iter().zip(settings) {
        let sets = settings.iter().flat_map(|it| ["--set", it]);
        let short = ["--set", "learning.updates=20"];
        train(run, &short.into_iter().chain(sets).collect::<Vec<_>>()).ends(DONE);
    }
    (folder, runs)
}

/// The mean of the last two of twenty updates of each cell of a setting.
fn last_windows(run: &Path, setting: &str) -> Vec<f64> {
    let mut all = Vec::new();
    for seed in fs::read_dir(run.join("cells").join(setting)).unwrap() {
        let text = fs::read_to_string(seed.unwrap().path().join("metrics.csv")).unwrap();
        let place = text.lines().next().unwrap().split(',').position(|it| it == "R_Loc").unwrap();
        let value = |line: &str| line.split(',').nth(place).unwrap().parse::<f64>().unwrap();
        let values: Vec<_> = text.lines().skip(1).map(value).collect();
        assert_eq!(values.len(), 20);
        all.push((values[18] + values[19]) / 2.0);
    }
    all
}

fn rows(csv: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(csv).unwrap().deserialize().map(|row| row.unwrap()).collect()
}

fn is_near(found: &str, expected: f64) {
    let found: f64 = found.parse().unwrap();
    assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
}

/// Of pairs, those in which the first is higher; ties count half.
fn improvement(x: &[f64], y: &[f64]) -> f64 {
    let win = |x: &f64, y: &f64| if x > y { 1.0 } else { f64::from(u8::from(x == y)) / 2.0 };
    let wins: f64 = x.iter().flat_map(|x| y.iter().map(move |y| win(x, y))).sum();
    wins / (x.len() * y.len()) as f64
}

/// Without a quarter at each end.
fn interquartile_mean(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let kept = &values[values.len() / 4..values.len() - values.len() / 4];
    kept.iter().sum::<f64>() / kept.len() as f64
}

#[test]
fn tables_of_two_runs_have_the_numbers_of_their_cells() {
    let seeds = "sweep.seeds=6";
    let (folder, [slow, fast]) = runs([&[seeds], &[seeds, "learning.rate=3.5"]]);
    let out = folder.path().join("both");
    let words = ["plot", text(&slow), text(&fast), "--out", text(&out), "--format", "svg,png"];
    itarl(&words).ends(DONE);
    let names: Vec<String> = tree(&out).into_keys().collect();
    for name in ["final.png", "profile.svg", "efficiency.svg", "learning-curves.svg"] {
        assert!(names.iter().any(|it| it == name), "{names:?}");
    }
    let settings = rows(&out.join("settings.csv"));
    let own: Vec<_> =
        rows(&out.join("instances.csv")).iter().map(|it| it["setting"].clone()).collect();
    assert_eq!(own.len(), 24);
    let mut last = BTreeMap::new();
    for row in &settings {
        let (rate, setting) = row["setting"].split_once(',').unwrap();
        let run = if rate == "rate=3.5" { &fast } else { &slow };
        let values = last_windows(run, setting);
        is_near(&row["R_Loc_IQM_m"], interquartile_mean(values.clone()));
        is_near(&row["R_Loc_maximum_m"], values.iter().copied().fold(f64::MIN, f64::max));
        assert!(!row["R_Loc_IQM_low_m"].is_empty());
        last.insert(row["setting"].clone(), values);
    }
    assert_eq!(last.len(), 4, "{last:?}");
    let improvements = rows(&out.join("improvement.csv"));
    assert_eq!(improvements.len(), 12);
    for row in &improvements {
        is_near(&row["probability"], improvement(&last[&row["setting"]], &last[&row["over"]]));
    }
    for row in rows(&out.join("profile.csv")) {
        let (values, score) =
            (&last[&row["setting"]], row["R_Loc_score_m"].parse::<f64>().unwrap());
        let above = values.iter().filter(|&&it| it > score).count();
        is_near(&row["share_above"], above as f64 / values.len() as f64);
    }
    // Twenty updates of 20 points: each is an update, and the last one is all control steps.
    let points = rows(&out.join("efficiency.csv"));
    assert_eq!(points.len(), 4 * 20);
    let steps = fs::read_to_string(slow.join("cells/xi=1/seed=1/metrics.csv")).unwrap();
    let steps = steps.lines().last().unwrap().split(',').nth(1).unwrap().to_owned();
    is_near(&points[19]["control_steps"], steps.parse().unwrap());

    let said = itarl(&["summary", text(&slow), text(&fast)]).ends(DONE);
    for (i, j) in [("xi=0.75", "xi=0.75"), ("xi=1", "xi=1")] {
        let [a, b] = [(&slow, i), (&fast, j)].map(|(run, it)| last_windows(run, it));
        let told = figures::three_digits(improvement(&a, &b));
        let line = said.out.lines().find(|it| it.contains(&format!("{i} over rate=3.5,{j}: ")));
        assert!(line.unwrap().contains(&format!(": {told} [")), "{line:?} {told}");
    }
    said.prints(&["| learning.rate |", "all other settings agree", "rate=3.5,xi=1 "]);
}

#[test]
fn runs_that_differ_in_their_folders_alone_are_called_by_them() {
    let (_folder, [a, b]) = runs([&[], &["sweep.seeds=[5,6]", "record.steps=7"]]);
    let said = itarl(&["summary", text(&a), text(&b)]).ends(DONE);
    said.prints(&["| run-1,xi=0.75 |", "| run-2,xi=1 ", "all settings agree"]);
    let said = itarl(&["findings", text(&a), text(&b)]).ends(DONE);
    said.prints(&["run-1\n", "run-2\n"]);
    let twice = a.join("../run-1");
    itarl(&["summary", text(&a), text(&twice)]).ends(FAILED).complains(&["it's the same run as"]);
}

#[test]
fn other_tasks_are_refused_and_both_are_named() {
    let (_folder, [walking, turning]) = runs([&[], &["reward.extrinsic.kind='turning'"]]);
    let both = [
        format!("{} is judged by locomotion R_Loc in m", text(&walking)),
        format!("{} by turning in rad", text(&turning)),
    ];
    let both = [&*both[0], &both[1]];
    for command in ["summary", "plot", "report", "findings"] {
        itarl(&[command, text(&walking), text(&turning)]).ends(FAILED).complains(&both);
    }
}

#[test]
fn published_runs_are_compared_as_they_are() {
    let (folder, [a, b]) = runs([&[], &["codec.sensor_bits=2"]]);
    let published = folder.path().join("published");
    itarl(&["publish", text(&a), "--out", text(&published), "--every", "2"]).ends(DONE);
    let settings = |first: &Path| {
        let out = folder.path().join("out");
        itarl(&["plot", text(first), text(&b), "final", "--out", text(&out)]).ends(DONE);
        rows(&out.join("settings.csv"))
    };
    for (whole, thin) in settings(&a).iter().zip(settings(&published)) {
        assert_eq!(whole["setting"], thin["setting"]);
        let [whole, thin] = [whole, &thin].map(|it| it["R_Loc_IQM_m"].parse::<f64>().unwrap());
        // Seven digits are published.
        assert!((whole - thin).abs() <= 1e-6 * whole.abs(), "{whole} {thin}");
    }
    itarl(&["summary", text(&published), text(&b)])
        .ends(DONE)
        .prints(&["sensor_bits=2,xi=1", "published: published, to be read"]);
}

#[test]
fn a_report_of_two_runs_has_both_and_what_differs() {
    let (folder, [a, b]) = runs([&[], &["learning.rate=3.5"]]);
    let page = folder.path().join("both.html");
    itarl(&["report", text(&a), text(&b), "--out", text(&page)]).ends(DONE);
    let page = fs::read_to_string(&page).unwrap();
    assert!(page.contains("<h1>run-1, run-2</h1>"));
    let (_, differences) = page.split_once("What differs").unwrap();
    assert!(differences.contains("<code>learning.rate</code>"));
    // Best and median of two settings of each.
    for name in ["rate=3.5,xi=0.75", "rate=3.5,xi=1"] {
        assert!(page.matches(name).count() > 4, "{name}");
    }
}

#[test]
fn json_has_a_line_for_each_run_as_it_has_it_alone() {
    let (_folder, [a, b]) = runs([&[], &["learning.rate=3.5"]]);
    let json = |runs: &[&Path]| {
        let words: Vec<_> = runs.iter().map(|it| text(it)).collect();
        itarl(&[&["summary", "--json"], &words[..]].concat()).ends(DONE).out
    };
    assert_eq!(json(&[&a, &b]), json(&[&a]) + &json(&[&b]));
}

/// What is told of an older run's first updates is what was told of it at that age.
#[test]
fn cells_of_unequal_age_are_asked_at_the_same_one() {
    let (folder, [older]) = runs([&[]]);
    let younger = folder.path().join("younger");
    train(&younger, &["--set", "learning.updates=12"]).ends(DONE);
    let was = itarl(&["findings", text(&younger)]).ends(DONE).out;
    let said = itarl(&["findings", text(&older), "--until", "12"]).ends(DONE);
    assert_eq!(said.out, was + "cells that have 12 updates, as they were then\n");
    let figures = |run: &Path, more: &[&str]| {
        let out = folder.path().join("out");
        itarl(&[&["plot", text(run), "final", "--out", text(&out)], more].concat()).ends(DONE);
        fs::read(out.join("settings.csv")).unwrap()
    };
    assert_eq!(figures(&older, &["--until", "12"]), figures(&younger, &[]));

    itarl(&["findings", text(&older), "--until", "21"])
        .ends(FAILED)
        .complains(&["run-1: no cell has 21 updates: `itarl status "]);
    let unequal = folder.path().join("unequal");
    for (index, updates) in ["4", "8"].iter().enumerate() {
        let index = index.to_string();
        let cell = ["cell", CRAWLER, "--out", text(&unequal), "--stop-after", updates];
        itarl(&[&cell[..], &["--index", &index]].concat()).ends(STOPPED);
    }
    let counted = |more: &[&str]| {
        let said = itarl(&[&["findings", text(&unequal)], more].concat()).ends(DONE).out;
        said.lines().nth(2).unwrap().split('|').nth(2).unwrap().trim().to_owned()
    };
    assert_eq!(counted(&[]), "2");
    assert_eq!(counted(&["--until", "4"]), "2");
    assert_eq!(counted(&["--until", "8"]), "1");

    // Published: r is over rows, of the cell that has no more of them, too.
    let published = folder.path().join("published");
    itarl(&["publish", text(&unequal), "--out", text(&published), "--every", "2"]).ends(DONE);
    itarl(&["findings", text(&published), "--until", "1"])
        .ends(FAILED)
        .complains(&["published: it has means over 2 updates, so the first 1 can't be told apart"]);
    let mut pairs = Vec::new();
    for seed in ["1", "2"] {
        let of = published.join("cells/xi=0.75/seed=".to_owned() + seed).join("metrics.csv");
        let number = |row: &BTreeMap<String, String>, key: &str| row[key].parse::<f64>().unwrap();
        let both = |row| (number(row, "R_Loc"), number(row, "R_MI_nats"));
        pairs.extend(rows(&of).iter().take(2).map(both));
    }
    let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
    let (x, y) = (mean(|it| it.0), mean(|it| it.1));
    let sum =
        |of: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|it| of(it.0 - x, it.1 - y)).sum::<f64>();
    let r = sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt();
    let told = format!("over all updates: {}\n", figures::three_digits(r));
    itarl(&["findings", text(&published), "--until", "4"]).ends(DONE).prints(&[&told]);
}

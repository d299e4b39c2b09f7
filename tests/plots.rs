//! `itarl plot`: figures and tables of runs that are done, damaged, empty, small and large.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use crate::common::*;
use figures::FIGURES;
use resvg::{tiny_skia::Pixmap, usvg::roxmltree};
use runner::experiment::Plan;
use runs::{Bullet, Cell, NewRun, Precision, Row, Run, header_line};
use tempfile::TempDir;

/// A sweep of one setting, `xi=1`.
const XI_1: &str = "\"reward.mix.xi\" = [1]";
const TABLES: [&str; 6] =
    ["correlation", "efficiency", "improvement", "instances", "profile", "settings"];

fn folder() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    (folder, run)
}

/// Four cells of 30 updates, really trained.
fn done() -> (TempDir, PathBuf) {
    let (folder, run) = folder();
    train(&run, &[]).ends(DONE);
    (folder, run)
}

fn plot(run: &Path, more: &[&str]) -> Said {
    itarl(&[&["plot", text(run)], more].concat())
}

/// A run with made-up metrics and no more; `sweep` is what it sweeps beside its seeds.
fn made_up(folder: &Path, sweep: &str, n_seeds: u64, n_updates: u64) {
    let experiment = format!(
        "model = \"models/crawler.toml\"\n[learning]\nupdates = 300\n\
         [sweep]\n{sweep}\nseeds = {n_seeds}\n"
    );
    let file = folder.with_extension("toml");
    fs::write(&file, &experiment).unwrap();
    let plan = Plan::open(&file, &[]).unwrap();
    let cells = plan.listing();
    let cells = cells.map(|(index, setting, seed)| Cell { index, setting: setting.into(), seed });
    let model = fs::read(root().join("tests/models/crawler.toml")).unwrap();
    let run = NewRun {
        experiment,
        itarl: "0.1.0".into(),
        bullet: Bullet { version: 325, precision: Precision::Single },
        models: vec![("crawler.toml".into(), model)],
        policies: Vec::new(),
        seeds: plan.seeds().to_vec(),
        cells: cells.collect(),
    };
    let run = Run::create(folder, &run).unwrap();
    for cell in &run.manifest().cells {
        let mut csv = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        for update in 1..=n_updates {
            let value = (update * (cell.index as u64 + 3) % 101) as f64 * 1e-3;
            let row = Row {
                update,
                control_steps: 100 * update,
                reward: value * value,
                intrinsic_nats: 0.2 - value,
                advance_m: value,
                task: value,
                ..Row::default()
            };
            csv.serialize(row).unwrap();
        }
        let rows = csv.into_inner().unwrap();
        fs::create_dir_all(run.cell(cell).path()).unwrap();
        let bytes = [header_line().as_bytes(), &rows].concat();
        fs::write(run.cell(cell).metrics(), bytes).unwrap();
    }
}

/// A table's rows, each by the names of its columns.
fn table(run: &Path, name: &str) -> Vec<BTreeMap<String, String>> {
    let path = run.join("plots").join(format!("{name}.csv"));
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().map(|row| row.unwrap()).collect()
}

fn svg(run: &Path, figure: &str) -> String {
    fs::read_to_string(run.join("plots").join(format!("{figure}.svg"))).unwrap()
}

/// What stands in a figure, text by text; panics if it's no XML.
fn texts(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    texts.map(|node| node.text().unwrap().trim().to_owned()).collect()
}

#[test]
fn every_figure_and_table_is_written_and_nothing_else() {
    let (_folder, run) = done();
    let before = tree(&run);
    let said = plot(&run, &["--format", "svg,png"]).ends(DONE);
    let mut after = tree(&run);
    let mut written: Vec<_> = said.out.lines().map(|line| line.to_owned()).collect();
    written.sort();
    let figures = FIGURES.iter().map(|it| it.name);
    let figures = figures.flat_map(|it| [format!("{it}.png"), format!("{it}.svg")]);
    let mut names: Vec<_> = figures.chain(TABLES.map(|it| format!("{it}.csv"))).collect();
    names.sort();
    let named: Vec<_> = names.iter().map(|it| format!("{}/plots/{it}", text(&run))).collect();
    assert_eq!(written, named);
    let plots: Vec<_> = after.keys().filter_map(|it| it.strip_prefix("plots/")).collect();
    assert_eq!(plots, names);
    for figure in FIGURES.map(|it| it.name) {
        let drawn = svg(&run, figure);
        // The robot is a picture.
        assert!(figure == "robot" || texts(&drawn).iter().any(|it| it == "ξ = 0.75"), "{figure}");
        let png = &after[&format!("plots/{figure}.png")];
        let pixels = Pixmap::decode_png(png).unwrap();
        let document = roxmltree::Document::parse(&drawn).unwrap();
        let size = |name| document.root_element().attribute(name).unwrap().parse::<u32>().unwrap();
        assert_eq!((pixels.width(), pixels.height()), (2 * size("width"), 2 * size("height")));
        let first = pixels.pixels()[0];
        assert!(pixels.pixels().iter().any(|it| *it != first), "{figure} is blank");
    }
    let plots = after.clone();
    after.retain(|name, _| !name.starts_with("plots/"));
    assert_same(&after, &before);

    // And again: the same bytes.
    plot(&run, &["--format", "png,svg"]).ends(DONE);
    assert_same(&tree(&run), &plots);
}

#[test]
fn tables_are_of_what_was_recorded() {
    let (_folder, run) = done();
    plot(&run, &["final", "scatter"]).ends(DONE);
    assert!(!run.join("plots/feet.svg").exists());
    let (settings, instances) = (table(&run, "settings"), table(&run, "instances"));
    assert_eq!((settings.len(), instances.len(), table(&run, "improvement").len()), (2, 4, 2));
    for setting in &settings {
        // A tenth of 30 updates.
        assert_eq!(setting["window_updates"], "3");
        let last = |seed: u64| {
            let cell = run.join("cells").join(&setting["setting"]).join(format!("seed={seed}"));
            let values = column(&cell, "R_Loc");
            values[27..].iter().sum::<f64>() / 3.0
        };
        let [a, b] = [last(1), last(2)];
        let number = |name: &str| setting[name].parse::<f64>().unwrap();
        assert_eq!(number("R_Loc_maximum_m"), a.max(b));
        // Both are the mean of two, but for a rounding.
        for name in ["R_Loc_mean_m", "R_Loc_median_m", "R_Loc_IQM_m"] {
            assert!((number(name) - (a + b) / 2.0).abs() < 1e-15, "{name}");
        }
        let recorded = instances.iter().filter(|it| it["setting"] == setting["setting"]);
        let recorded: Vec<f64> =
            recorded.map(|it| it["R_Loc_last_window_m"].parse().unwrap()).collect();
        assert_eq!(recorded, [a, b]);
    }
    let correlations = table(&run, "correlation");
    assert_eq!(correlations[2]["setting"], "all");
    assert_eq!(correlations[2]["updates"], "120");
}

#[test]
fn damaged_cells_are_named_and_left_out() {
    let (_folder, run) = done();
    let cell = |name: &str| run.join("cells").join(name);
    // Half of a row, as if it were just being written, is no damage.
    let metrics = cell("xi=0.75/seed=1").join("metrics.csv");
    let text = fs::read_to_string(&metrics).unwrap();
    fs::write(&metrics, format!("{text}31,310,0.0")).unwrap();
    fs::write(cell("xi=0.75/seed=2").join("metrics.csv"), "no numbers\n").unwrap();
    // A number is lost, and a later update follows.
    let metrics = cell("xi=1/seed=1").join("metrics.csv");
    let lines = fs::read_to_string(&metrics).unwrap();
    let lines: Vec<_> = lines.lines().enumerate().filter(|(i, _)| *i != 7).map(|it| it.1).collect();
    fs::write(&metrics, lines.join("\n") + "\n").unwrap();
    let replay = cell("xi=1/seed=2").join("replay.safetensors");
    let mut bytes = fs::read(&replay).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&replay, bytes).unwrap();

    plot(&run, &[]).ends(FAILED).complains(&[
        "xi=0.75/seed=2: left out: ",
        "seed=2/metrics.csv: damaged: 11 bytes, and the checkpoint goes on from ",
        "xi=1/seed=1: left out: ",
        "seed=1/metrics.csv: damaged: ",
        "xi=1/seed=2: left out: ",
        "replay.safetensors: damaged: its checksum is wrong",
    ]);
    let settings = table(&run, "settings");
    let n: Vec<_> = settings.iter().map(|it| it["instances"].as_str()).collect();
    assert_eq!(n, ["1", "1"]);
    let texts = texts(&svg(&run, "feet"));
    assert!(texts.contains(&"nothing recorded".to_owned()), "{texts:?}");
}

/// Of rows that no checkpoint knows yet.
#[test]
fn values_that_are_none_are_named_with_their_line() {
    let (_folder, run) = folder();
    made_up(&run, XI_1, 3, 20);
    let edit = |seed: u64, line: usize, change: fn(&mut Vec<String>)| {
        let metrics = run.join(format!("cells/xi=1/seed={seed}/metrics.csv"));
        let text = fs::read_to_string(&metrics).unwrap();
        let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
        let mut values: Vec<_> = lines[line - 1].split(',').map(str::to_owned).collect();
        change(&mut values);
        lines[line - 1] = values.join(",");
        fs::write(&metrics, lines.join("\n") + "\n").unwrap();
    };
    edit(1, 8, |values| values[0] = "8".into());
    edit(2, 4, |values| values[6] = "NaN".into());
    plot(&run, &["final"]).ends(FAILED).complains(&[
        "seed=1/metrics.csv: damaged: line 8: update 7 expected, got 8",
        "seed=2/metrics.csv: damaged: line 4: R_Loc must be within -1e100 to 1e100, got NaN",
    ]);
    assert_eq!(table(&run, "settings")[0]["instances"], "1");
}

#[test]
fn without_an_update_there_is_advice() {
    let (_folder, run) = folder();
    made_up(&run, XI_1, 2, 0);
    let advice = format!("no cell has an update yet: `itarl resume {}` trains", text(&run));
    plot(&run, &[]).ends(FAILED).complains(&[&advice]);
    fs::remove_dir_all(run.join("cells")).unwrap();
    plot(&run, &[]).ends(FAILED).complains(&[&advice]);
    assert!(!run.join("plots").exists());
    plot(&run.join("nowhere"), &[]).ends(FAILED).complains(&["there's nothing here; `itarl train"]);

    let (_folder, run) = folder();
    made_up(&run, XI_1, 2, 3);
    for seed in ["seed=1", "seed=2"] {
        fs::write(run.join("cells/xi=1").join(seed).join("metrics.csv"), "?\n").unwrap();
    }
    plot(&run, &[]).ends(FAILED).complains(&[
        "no cell that has an update can be read\n  xi=1/seed=1: left out: ",
        "\n  xi=1/seed=2: left out: ",
    ]);
    assert!(!run.join("plots").exists());
}

#[test]
fn an_unfinished_run_is_drawn() {
    let (_folder, run) = folder();
    train(&run, &["--stop-after", "1"]).ends(STOPPED);
    itarl(&["cell", CRAWLER, "--index", "3", "--out", text(&run), "--stop-after", "8"])
        .ends(STOPPED);
    plot(&run, &[]).ends(DONE);
    let instances = table(&run, "instances");
    let updates: Vec<_> = instances.iter().map(|it| it["updates"].as_str()).collect();
    assert_eq!(updates, ["1", "1", "1", "9"]);
    assert_eq!(table(&run, "settings")[1]["instances_behind"], "1");
}

#[test]
fn from_one_cell_to_twelve_settings_of_thirty() {
    let (_folder, run) = folder();
    made_up(&run, "", 1, 40);
    // Only the figure of feet is missed: nothing was recorded for it.
    plot(&run, &[]).ends(DONE).complains(&["left out feet: "]);
    assert!(texts(&svg(&run, "learning-curves")).contains(&"base".to_owned()));
    assert_eq!(table(&run, "improvement").len(), 0);
    plot(&run, &["feet"]).ends(FAILED).complains(&["feet: the chosen cells have no replay"]);

    let (_folder, run) = folder();
    let twelve = "\"policy.hidden_units\" = [1, 2, 3]\n\"reward.mix.xi\" = [0.1, 0.2, 0.3, 0.4]";
    made_up(&run, twelve, 30, 200);
    plot(&run, &[]).ends(DONE);
    assert_eq!(table(&run, "improvement").len(), 12 * 11);
    for figure in ["learning-curves", "close-up", "scatter", "final"] {
        let drawn = svg(&run, figure);
        assert!(drawn.len() < 300_000, "{figure}: {} bytes", drawn.len());
        assert!(texts(&drawn).iter().any(|it| it.contains("30")), "{figure}");
    }
}

/// One seed, as of a first look: nothing is said that one cell can't tell.
#[test]
fn one_cell_gives_neither_interval_nor_probability() {
    let (_folder, run) = folder();
    train(&run, &["--set", "sweep.seeds=1"]).ends(DONE);
    plot(&run, &["final"]).ends(DONE);
    for pair in table(&run, "improvement") {
        let numbers = ["probability", "low", "high"].map(|name| pair[name].as_str());
        assert_eq!(numbers, [""; 3], "{pair:?}");
    }
    for setting in table(&run, "settings") {
        let ends = ["R_Loc_IQM_low_m", "R_Loc_IQM_high_m"].map(|name| setting[name].as_str());
        assert_eq!(ends, [""; 2], "{setting:?}");
        assert_eq!(setting["R_Loc_IQM_m"], setting["R_Loc_mean_m"]);
    }
    let drawn = texts(&svg(&run, "final"));
    assert!(drawn.iter().any(|it| it.contains("One cell of a setting gives")), "{drawn:?}");
    itarl(&["report", text(&run)]).ends(DONE);
    let page = fs::read_to_string(run.join("report.html")).unwrap();
    assert!(page.contains("One cell of a setting gives neither an interval nor a probability."));
}

#[test]
fn what_is_drawn_can_be_chosen() {
    let (_folder, run) = done();
    let said = plot(&run, &["--setting", "xi=1", "close-up"]).ends(DONE);
    assert_eq!(said.out.lines().count(), 1);
    let drawn = texts(&svg(&run, "close-up"));
    assert!(drawn.contains(&"ξ = 1".to_owned()) && !drawn.contains(&"ξ = 0.75".to_owned()));
    plot(&run, &["--two-best", "feet"]).ends(DONE);
    let drawn = texts(&svg(&run, "feet"));
    assert!(drawn.iter().any(|it| it.starts_with("second best: seed ")), "{drawn:?}");
    plot(&run, &["--setting", "xi=2", "close-up"])
        .ends(FAILED)
        .complains(&["no setting \"xi=2\" has an update; there are xi=0.75, xi=1"]);
    plot(&run, &["robots"]).ends(USAGE).complains(&["learning-curves, close-up, feet"]);
    plot(&run, &["--format", "gif"]).ends(USAGE).complains(&["svg, png"]);
}

#[test]
fn what_cannot_be_written_is_reported() {
    let (_folder, run) = done();
    fs::write(run.join("plots"), "").unwrap();
    plot(&run, &["final"]).ends(FAILED).complains(&["run/plots: "]);
    fs::remove_file(run.join("plots")).unwrap();
    fs::create_dir_all(run.join("plots/final.svg/in the way")).unwrap();
    plot(&run, &["final"]).ends(FAILED).complains(&["final.svg: renaming the temporary file: "]);
}

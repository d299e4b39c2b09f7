//! What can be typed, what it prints, and how it ends.

use std::{
    collections::BTreeSet,
    fs, io,
    path::{Path, PathBuf},
    process::Stdio,
};

use crate::common::*;
use tempfile::TempDir;

const COMMANDS: [&[&str]; 23] = [
    &["train"],
    &["resume"],
    &["cell"],
    &["slurm"],
    &["status"],
    &["merge"],
    &["summary"],
    &["export"],
    &["plot"],
    &["findings"],
    &["check"],
    &["publish"],
    &["config"],
    &["report"],
    &["replay"],
    &["rollout"],
    &["model", "check"],
    &["model", "show"],
    &["model", "import"],
    &["bench"],
    &["landscape"],
    &["man"],
    &["completions"],
];

/// A run that is done.
fn done() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--set", "learning.updates=6"]).ends(DONE);
    (folder, run)
}

#[test]
fn every_command_has_help_with_an_example() {
    let help = itarl(&["--help"]).ends(DONE).prints(&["Exit codes: 0 ", "75 ", "Example"]);
    let begin = help.out.find("Commands:").unwrap();
    let listed = help.out[begin..].lines().skip(1).take_while(|line| line.starts_with("  "));
    let listed: BTreeSet<_> =
        listed.map(|line| line.split_whitespace().next().unwrap().to_owned()).collect();
    let mut known: BTreeSet<_> = COMMANDS.iter().map(|words| words[0].to_owned()).collect();
    known.insert("help".into());
    assert_eq!(listed, known, "COMMANDS has all commands");
    for words in COMMANDS {
        let name = format!("  itarl {}", words.join(" "));
        itarl(&[words, &["--help"]].concat()).ends(DONE).prints(&["Example", &name]);
    }
    itarl(&["--version"]).ends(DONE).prints(&["itarl 0."]);
}

#[test]
fn ends_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    for words in [
        &["train"][..],
        &["trian", CRAWLER],
        &["train", CRAWLER, "--threads", "0"],
        &["train", CRAWLER, "--stop-after", "x"],
        &["resume", "a", "b"],
        &["model", "check"],
        &["cell", CRAWLER, "--out", "x"],
        &["rollout", "x", "--steps", "0"],
        &["completions", "basic"],
        &["config"],
        &["config", "--help", "reward.mix.xii"],
        &[],
    ] {
        let said = itarl(words).ends(USAGE);
        assert!(said.err.contains("Usage: ") || said.err.contains("--help"), "{said:?}");
        assert_eq!(said.out, "");
    }
    train(&run, &["--stop-after", "3"]).ends(STOPPED).prints(&["0 of 4 cells done, 4 to go on"]);
    itarl(&["resume", text(&run)]).ends(DONE).prints(&["4 of 4 cells done"]);
    let words = ["cell", CRAWLER, "--index", "4", "--out", text(&run)];
    itarl(&words).ends(FAILED).complains(&["--index must be a cell's number from 0 to 3, got 4"]);
}

#[test]
fn a_configuration_gives_itself_again() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("again.toml");
    let sets = ["--set", "learning.rate=0.3", "--set", "policy.connectivity=\"per_actuator\""];
    let first = itarl(&[&["config", CRAWLER], &sets[..]].concat()).ends(DONE);
    first.prints(&["rate = 0.3", "connectivity = \"per_actuator\"", "discount = 0.75"]);
    for (sets, experiment) in [(&sets[..], CRAWLER), (&[], "experiments/legs-2bit.toml")] {
        let printed = itarl(&[&["config", experiment], sets].concat()).ends(DONE).out;
        fs::write(&file, &printed).unwrap();
        assert_eq!(itarl(&["config", text(&file)]).ends(DONE).out, printed);
        let list = |file: &str| itarl(&["train", file, "--list"]).ends(DONE).out;
        assert_eq!(list(text(&file)), list(experiment));
    }
    // The same run, too: its folder takes both.
    let run = folder.path().join("run");
    train(&run, &["--stop-after", "1"]).ends(STOPPED);
    fs::write(&file, itarl(&["config", CRAWLER]).out).unwrap();
    itarl(&["train", text(&file), "--out", text(&run)]).ends(DONE);
}

#[test]
fn a_setting_is_explained_by_its_key() {
    let explained = |key: &str| itarl(&["config", "--help", key]).ends(DONE).out;
    assert_eq!(
        explained("reward.mix.power"),
        "reward.mix.power\n meaning     the power of the whole\n \
         value       a number from 0.01 to 100\n default     2\n \
         only where  reward.mix.kind is \"geometric\"\n"
    );
    // Of a table all, each with the kinds that have it, and the kinds with what they are.
    let policy = explained("policy");
    for line in ["policy.memory", "policy.hidden_units", " only where  policy.kind is \"modular\""]
    {
        assert!(policy.lines().any(|found| found == line), "{policy}");
    }
    assert!(policy.contains("\"logistic\": Each bit by itself"), "{policy}");
    assert!(policy.lines().all(|line| line.chars().count() <= 100), "{policy}");
    itarl(&["config", "--help", "reward.mix.xii"])
        .ends(USAGE)
        .complains(&["no such setting, did you mean 'reward.mix.xi'?"]);
    // Without a key it's the command's help, wherever it stands.
    let help =
        itarl(&["config", "--help"]).ends(DONE).prints(&["Usage: itarl config", "<FILE>"]).out;
    for words in [&["config", "-h"][..], &["help", "config"], &["config", CRAWLER, "--help"]] {
        assert_eq!(itarl(words).ends(DONE).out, help, "{words:?}");
    }
}

#[test]
fn settings_from_the_command_line_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let sets = ["learning.rat=3", "reward.mix.xi=1", "sweep.seeds=0", "learning.discount=2"];
    let sets: Vec<_> = sets.iter().flat_map(|it| ["--set", it]).collect();
    let swept = format!("reward.mix.xi is swept by {CRAWLER}:");
    let said = train(&run, &sets).ends(FAILED).complains(&[
        "--set learning.rat=3: learning: unknown key 'rat', did you mean 'rate'?",
        &swept,
        "--set sweep.seeds=0: sweep: seeds must be ",
        "--set learning.discount=2: learning: discount must be a number from 0 to 1, got 2",
    ]);
    assert_eq!(said.err.lines().count(), 4, "{said:?}");
    train(&run, &["--set", "learning.rate"]).ends(FAILED).complains(&["key=value expected"]);
    let nowhere = ["--set", "model=\"nowhere.toml\""];
    train(&run, &nowhere).ends(FAILED).complains(&["nowhere.toml: ", "No such file"]);
    assert!(!run.exists());
    itarl(&["train", "nowhere.toml"]).ends(FAILED).complains(&["nowhere.toml: ", "No such file"]);
}

#[test]
fn cells_are_listed_in_a_stable_order() {
    let said = itarl(&["train", CRAWLER, "--list"]).ends(DONE);
    assert_eq!(said.out, "0\txi=0.75/seed=1\n1\txi=0.75/seed=2\n2\txi=1/seed=1\n3\txi=1/seed=2\n");
    let figure2 = itarl(&["train", "experiments/figure2.toml", "--list"]).ends(DONE).out;
    assert_eq!(figure2.lines().count(), 150);
    assert_eq!(figure2.lines().last(), Some("149\txi=1/seed=30"));
}

/// The words between the bars of a table's row.
fn row(table: &str, index: usize) -> Vec<String> {
    let line = table.lines().nth(index + 2).unwrap();
    line.trim_matches('|').split('|').map(|word| word.trim().to_owned()).collect()
}

#[test]
fn status_tells_where_cells_stand() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--stop-after", "0"]).ends(STOPPED);
    itarl(&["status", text(&run)]).ends(STOPPED).prints(&["4 cells: "]);

    let long = ["--set", "learning.updates=100000", "--threads", "1", "--lanes", "1"];
    let run = folder.path().join("long run");
    let child = start(&train_words(&run, &long));
    let metrics = run.join("cells/xi=0.75/seed=1/metrics.csv");
    wait_until(|| fs::read_to_string(&metrics).is_ok_and(|it| it.lines().count() > 8));
    let said = itarl(&["status", text(&run)]).ends(STOPPED).prints(&["1 running, 3 waiting"]);
    let cell = row(&said.out, 0);
    assert_eq!(cell[..4], ["0", "xi=0.75", "1", "running"]);
    let update: u64 = cell[4].strip_suffix("/100000").unwrap().parse().unwrap();
    assert!(update >= 7, "{cell:?}");
    assert_eq!(row(&said.out, 3)[..5], ["3", "xi=1", "2", "waiting", "0/100000"]);
    signal(&child, "TERM");
    end(child).ends(STOPPED);
    let said = itarl(&["status", text(&run)]).ends(STOPPED).prints(&["1 stopped, 3 waiting"]);
    assert_eq!(row(&said.out, 0)[3], "stopped");

    let (_folder, run) = done();
    let said = itarl(&["status", text(&run)]).ends(DONE).prints(&["4 cells: 4 done"]);
    let cell = row(&said.out, 2);
    assert_eq!(cell[..5], ["2", "xi=1", "1", "done", "6/6"]);
    let newest = column(&run.join("cells/xi=1/seed=1"), "R_Loc").pop().unwrap();
    assert_eq!(cell[7], format!("{newest:.4}"));
}

#[test]
fn summary_compares_early_with_late() {
    let (_folder, run) = done();
    let words = ["summary", text(&run), "--early", "1-2", "--late", "4-6"];
    let said = itarl(&words).ends(DONE).prints(&["1-2", "4-6"]);
    let late: f64 = [1, 2]
        .map(|seed| column(&run.join(format!("cells/xi=1/seed={seed}")), "R_Loc"))
        .map(|advance_m| advance_m[3..].iter().sum::<f64>() / 3.0)
        .iter()
        .sum();
    assert!(said.out.contains(&format!("{:+.5}", late / 2.0)), "{late}: {said:?}");
    itarl(&["summary", text(&run), "--early", "2-1"]).ends(USAGE);
}

/// One cell has gone on, and one has hardly begun.
#[test]
fn summary_leaves_no_more_cells_out_than_it_must() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let cell = |which: &[&str]| itarl(&[&["cell", CRAWLER, "--out", text(&run)], which].concat());
    cell(&["--index", "0"]).ends(DONE);
    cell(&["--cells", "1-2", "--stop-after", "20"]).ends(STOPPED);
    cell(&["--index", "3", "--stop-after", "3"]).ends(STOPPED);
    let said = itarl(&["summary", text(&run)]).ends(DONE);
    let said = said.prints(&[
        "means over updates 1-2 (early) and 19-20 (late)",
        "seed=2/metrics.csv: left out: it has 3 updates, and not all of 1-2 and 19-20",
    ]);
    assert_eq!([2, 3].map(|index| row(&said.out, index)[1].clone()), ["2", "1"]);
}

#[test]
fn summary_tells_nothing_of_one_seed() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--set", "learning.updates=6", "--set", "sweep.seeds=1"]).ends(DONE);
    let said = itarl(&["summary", text(&run)]).ends(DONE);
    for index in 1..=2 {
        let cells = row(&said.out, index);
        let deviation_t_p = [6, 8, 9].map(|column| cells[column].as_str());
        assert_eq!((cells[1].as_str(), deviation_t_p), ("1", ["-"; 3]), "{said:?}");
    }
}

#[test]
fn models_are_checked_and_shown() {
    let bad = "tests/models/bad/mass_zero.toml";
    let good = "tests/models/crawler.toml";
    let fine = format!("{good}: Crawler, 3 bodies, 2 actuators: fine\n");
    assert_eq!(itarl(&["model", "check", good]).ends(DONE).out, fine);
    let said = itarl(&["model", "check", bad, good, "nowhere.toml"]).ends(FAILED);
    assert_eq!(said.out, fine);
    said.complains(&[&format!("{bad}:8:11: "), "nowhere.toml: "]);
    let shown = ["Crawler", "| shoulder ", "| forearm ", "heading along (0, 1, 0) of 'block'"];
    itarl(&["model", "show", good]).ends(DONE).prints(&shown);
    itarl(&["model", "show", bad]).ends(FAILED);
}

/// A copy of the crawler's model, changed.
fn changed_model(folder: &Path, change: impl Fn(&str) -> String) -> PathBuf {
    let file = folder.join("model.toml");
    let model = fs::read_to_string(root().join("tests/models/crawler.toml")).unwrap();
    fs::write(&file, change(&model)).unwrap();
    file
}

#[test]
fn what_a_model_had_better_not_say_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let far = |model: &str| {
        let axis = "axes = [{ about = \"x\", range_deg = [-30.0, 30.0], servo";
        let far = "axes = [{ about = \"y\", range_deg = [-75.0, 30.0], servo";
        model.replace("hinge", "spherical").replace(axis, far)
    };
    let file = changed_model(folder.path(), far);
    let said = itarl(&["model", "check", text(&file)]).ends(DONE).prints(&[": fine\n"]);
    let place = format!("{}:52:36: warning: joint 'elbow': axes[0]: ", text(&file));
    assert!(said.err.starts_with(&place) && said.err.lines().count() == 1, "{said:?}");
    itarl(&["rollout", text(&file), "--steps", "1"]).ends(DONE);
}

/// Texts of files are shown, and a terminal doesn't obey them.
#[test]
fn escape_codes_in_files_do_not_reach_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    // A title, a colour, a line that goes back over what stood there, and a bell.
    let code = "\\u001b]0;owned\\u0007\\u001b[31m\\rfine\\u009b2J";
    let file = changed_model(folder.path(), |model| {
        let name = format!("name = \"Crawler{code}\"\ndescription = \"{code}\"");
        model.replacen("name = \"Crawler\"", &name, 1)
    });
    let bad = folder.path().join("bad.toml");
    fs::write(&bad, format!("\"{code}\" = \"{code}\"\nname = \"\"")).unwrap();
    let experiment = folder.path().join("experiment.toml");
    let crawler = fs::read_to_string(root().join(CRAWLER)).unwrap();
    let model = crawler.lines().find(|line| line.starts_with("model = ")).unwrap();
    let described = format!("description = \"{code}\"\nmodel = \"model.toml\"");
    fs::write(&experiment, crawler.replacen(model, &described, 1)).unwrap();
    let run = folder.path().join("run");
    train(&run, &["--stop-after", "2"]).ends(STOPPED);
    // As of a run that somebody sent.
    let failed = run.join("cells/xi=1/seed=1/failed");
    fs::write(failed, "\u{1b}[31mblew up\u{7}\r\n").unwrap();
    for words in [
        &["model", "check", text(&file), text(&bad)][..],
        &["model", "show", text(&file)],
        &["rollout", text(&file), "--steps", "1"],
        &["config", text(&experiment)],
        &["train", text(&bad)],
        &["status", text(&run)],
    ] {
        let said = itarl(words);
        assert!(!said.out.is_empty() || !said.err.is_empty());
        for text in [&said.out, &said.err] {
            let code = text.chars().find(|it| it.is_control() && !matches!(it, '\n' | '\t'));
            assert_eq!(code, None, "{words:?}: {said:?}");
        }
    }
    let shown = itarl(&["model", "show", text(&file)]).ends(DONE);
    shown.prints(&["Crawler\\u{1b}]0;owned\\u{7}\\u{1b}[31m\\rfine\\u{9b}2J: "]);
}

/// The rows of a CSV file, the columns' names first.
fn table(path: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn rollouts_report_and_write_a_table() {
    let (folder, run) = done();
    let csv = folder.path().join("walk.csv");
    let cell = run.join("cells/xi=1/seed=1");
    let roll = |what: &Path, policy: &[&str]| {
        fs::remove_file(&csv).ok();
        let words = ["rollout", text(what), "--steps", "50", "--csv", text(&csv)];
        let said = itarl(&[&words, policy].concat()).ends(DONE);
        let said = said.prints(&["Crawler, policy ", "50 control steps", "speed along heading"]);
        (said.out, table(&csv))
    };
    let (model, gait) = (Path::new("tests/models/crawler.toml"), "tests/models/gaits/crawler.toml");
    let (mut advances, mut stills) = (Vec::new(), Vec::new());
    for (what, policy) in [
        (&*cell, &[][..]),
        (&cell, &["--policy", "random"]),
        (&cell, &["--policy", "neutral"]),
        (&cell, &["--policy", gait]),
        (model, &[]),
        (model, &["--policy", gait]),
    ] {
        let (said, rows) = roll(what, policy);
        let name = match (policy.last(), what == model) {
            (Some(name), _) => name,
            (None, true) => "neutral",
            (None, false) => "learned",
        };
        assert!(said.contains(&format!("policy {name},")), "{said}");
        assert_eq!(rows.len(), 51);
        let columns =
            ["step", "x_m", "y_m", "z_m", "advance_m", "heading_change_rad", "penalised_contacts"];
        let robot = [
            "sensor shoulder",
            "sensor elbow",
            "contact forearm",
            "target shoulder",
            "target elbow",
        ];
        assert_eq!(rows[0][..7], columns);
        assert_eq!(rows[0][rows[0].len() - 5..], robot);
        assert!(rows.iter().all(|row| row.len() == rows[0].len()));
        assert!(rows[1..].iter().flatten().all(|it| it.parse::<f64>().unwrap().is_finite()));
        let advance_m: f64 = rows[1..].iter().map(|row| row[4].parse::<f64>().unwrap()).sum();
        assert!(said.contains(&format!("{:+.4} m per control step", advance_m / 50.0)), "{said}");
        // One change in 50 steps is 2 % of them.
        let n = rows[0].len();
        let is_still = |&column: &usize| rows[1..].iter().all(|row| row[column] == rows[1][column]);
        let n_still = (n - 2..n).filter(is_still).count();
        assert!(said.contains(&format!("actuators at rest    {n_still} of 2\n")), "{said}");
        stills.push(n_still);
        advances.push(advance_m);
    }
    // Whoever stands keeps both still, the gait moves both.
    assert_eq!([2, 3, 4, 5].map(|i| stills[i]), [2, 0, 2, 0]);
    // The gait crawls, and nothing that holds still does.
    assert!(advances[3] > 0.3, "{advances:?}");
    assert!(advances[2].abs() < 0.01 && advances[4].abs() < 0.01, "{advances:?}");

    let seeds = ["1", "1", "2"].map(|seed| roll(&cell, &["--seed", seed]).1);
    assert!(seeds[0] == seeds[1] && seeds[0] != seeds[2]);
}

#[test]
fn rollouts_say_what_they_cannot_do() {
    let (folder, run) = done();
    let roll =
        |what: &str, policy: &str| itarl(&["rollout", what, "--policy", policy]).ends(FAILED);
    let model = "tests/models/crawler.toml";
    roll(model, "learned").complains(&["a model alone has learned nothing"]);
    roll(model, "sit").complains(&["--policy must be ", ", got sit"]);
    roll(model, "models/gaits/svenja.toml").complains(&["models/gaits/svenja.toml:", "2 digits"]);
    roll(text(&run), "neutral").complains(&["a cell's folder expected"]);
    roll(text(folder.path()), "neutral").complains(&["a cell's folder expected"]);
    roll("nowhere.toml", "neutral").complains(&["nowhere.toml: "]);
    roll(text(&run.join("cells/xi=1/seed=9")), "neutral").complains(&["seed=9"]);
}

#[test]
fn a_bench_begins_with_a_plain_number() {
    let said = itarl(&["bench", CRAWLER, "--seconds", "0.2"]).ends(DONE);
    let (speed, _) = said.out.split_once(" control steps/s with ").unwrap();
    assert!(speed.chars().all(|c| c.is_ascii_digit()) && speed.parse::<u64>().unwrap() > 0);
    said.prints(&["  physics ", "  policy ", "  rest ", "  sweep ", "--solver bullet", "mode: "]);
    itarl(&["bench", CRAWLER, "--seconds", "0.1", "--lanes", "3"])
        .prints(&["with 3 cells in lanes"]);
    for seconds in ["-1", "nan", "inf"] {
        let words = ["bench", CRAWLER, &format!("--seconds={seconds}")];
        itarl(&words).ends(FAILED).complains(&["--seconds must be a length of time"]);
    }
}

/// A row for each number of cells, and one for all cores where there are several; of models, too.
#[test]
fn a_table_of_costs_has_a_row_for_each_size_of_work() {
    let words = ["bench", "--table", "--seconds", "0.01", CRAWLER, "tests/models/crawler.toml"];
    let said = itarl(&[&words[..], &["--json"]].concat()).ends(DONE);
    let rows: Vec<serde_json::Value> =
        said.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of_one_thread: Vec<_> = rows.iter().filter(|row| row["threads"] == 1).collect();
    let cells: Vec<_> = of_one_thread.iter().map(|row| row["cells"].as_u64().unwrap()).collect();
    assert_eq!(cells, [[1, 2, 4, 8, 16]; 2].concat());
    for row in &rows {
        assert!(row["control_steps_per_second"].as_f64().unwrap() > 0.0, "{row}");
        assert!(row["state_bytes"].as_u64().unwrap() > 0 && row["name"] == "crawler", "{row}");
    }
    itarl(&words).ends(DONE).prints(&["cells on each", "| crawler |"]);
    itarl(&["bench", CRAWLER, CRAWLER])
        .ends(FAILED)
        .complains(&["several files are measured with --table"]);
}

/// A pipe that nobody reads.
fn closed_pipe() -> Stdio {
    let (reader, writer) = io::pipe().unwrap();
    drop(reader);
    writer.into()
}

#[test]
fn whoever_has_read_enough_hears_of_no_panic() {
    let (_folder, run) = done();
    for words in [
        &["config", CRAWLER][..],
        &["train", CRAWLER, "--list"],
        &["model", "show", "models/svenja.toml"],
        &["status", text(&run)],
        &["summary", text(&run)],
        &["completions", "bash"],
        &["--help"],
        &["resume", text(&run)],
    ] {
        let child = command(words).stdout(closed_pipe()).stderr(Stdio::piped()).spawn().unwrap();
        end(child).ends(DONE);
    }
}

/// As under `itarl train ... 2>&1 | head -1`.
#[test]
fn training_goes_on_when_nobody_listens() {
    let folder = tempfile::tempdir().unwrap();
    let [run, other] = ["run", "other"].map(|name| folder.path().join(name));
    let words = train_words(&run, &[]);
    let status = command(&words).stdout(closed_pipe()).stderr(closed_pipe()).status().unwrap();
    assert_eq!(status.code(), Some(DONE));
    train(&other, &[]).ends(DONE);
    assert_same(&results(&run), &results(&other));
    // Nor does a mistake become another one.
    let status = command(&["train", "nowhere.toml"]).stderr(closed_pipe()).status().unwrap();
    assert_eq!(status.code(), Some(FAILED));
}

#[test]
fn without_a_terminal_progress_is_plain_lines() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let said = train(&run, &[]).ends(DONE);
    let expected: BTreeSet<_> = ["xi=0.75/seed=1", "xi=0.75/seed=2", "xi=1/seed=1", "xi=1/seed=2"]
        .iter()
        .map(|cell| format!("{}: {cell}: done", run.display()))
        .collect();
    assert_eq!(said.err.lines().map(str::to_owned).collect::<BTreeSet<_>>(), expected);
    assert!(!said.err.contains('\u{1b}') && !said.err.contains('\r'), "{said:?}");
    assert_eq!(said.out, format!("{}: 4 of 4 cells done\n", run.display()));
}

//! Completions: what the program offers to a shell that asks, and what bash makes of it.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use crate::common::*;
use tempfile::TempDir;

/// What is offered for the last of these words, as a shell hears it: each with what is said of it.
fn offered(words: &[&str]) -> Vec<(String, String)> {
    let mut command = command(&[&["--", "itarl"], words].concat());
    let said = Said::of(command.env("ITARL_COMPLETE", "fish").output().unwrap()).ends(DONE);
    assert_eq!(said.err, "");
    let both = said.out.lines().map(|line| line.split_once('\t').unwrap_or((line, "")));
    both.map(|(value, about)| (value.into(), about.into())).collect()
}

fn values(words: &[&str]) -> Vec<String> {
    offered(words).into_iter().map(|it| it.0).collect()
}

/// A run with four cells.
fn begun() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--stop-after", "1"]).ends(STOPPED);
    (folder, run)
}

const CELLS: [&str; 4] = ["xi=0.75/seed=1", "xi=0.75/seed=2", "xi=1/seed=1", "xi=1/seed=2"];

#[test]
fn cells_are_those_of_the_run() {
    let (folder, run) = begun();
    let cell = |name: &str| format!("{}/cells/{name}", run.display());
    for command in [&["replay"][..], &["rollout"], &["landscape"], &["landscape", "--between"]] {
        let of = |word: &str| values(&[command, &[word]].concat());
        for way in ["", "/", "/cells", "/cells/xi="] {
            assert_eq!(
                of(&format!("{}{way}", run.display())),
                CELLS.map(cell),
                "{command:?} {way}"
            );
        }
        assert_eq!(of(&cell("xi=1/")), CELLS[2..].iter().map(|it| cell(it)).collect::<Vec<_>>());
        assert_eq!(of(&cell("xi=2")), [""; 0]);
        // Until there.
        assert_eq!(of(&format!("{}/r", folder.path().display())), [format!("{}/", run.display())]);
    }
    let second = ["landscape", "--between", &cell(CELLS[0]), &cell("xi=1/seed=2")];
    assert_eq!(values(&second), [cell(CELLS[3])]);
    assert_eq!(values(&["rollout", "models/svenja."]), ["models/svenja.toml"]);
    assert_eq!(values(&["plot", text(&run), "--setting", "xi=1"]), ["xi=1"]);
    assert_eq!(values(&["plot", text(&run), "fi"]), ["final"]);
    assert!(values(&["rollout", &cell(CELLS[0]), "--policy", "l"]).contains(&"learned".into()));
    for file in ["manifest.json", "experiment.toml"] {
        std::fs::write(run.join(file), "?").unwrap();
        assert_eq!(values(&["replay", text(&run)]), [""; 0], "what can't be read offers nothing");
    }
}

#[test]
fn keys_are_those_of_the_experiment_on_the_line() {
    let of = |words: &[&str]| offered(words);
    let scale = of(&["train", "--set", "reward.sc"]);
    let told = itarl(&["config", "--help", "reward.scale"]).ends(DONE).out;
    assert!(scale[0].0 == "reward.scale=" && told.contains(&scale[0].1), "{scale:?}");
    let with = |changes: &[&str], word: &str| {
        values(&[&["train", CRAWLER], changes, &["--set", word]].concat())
    };
    assert_eq!(with(&[], "sweep.s"), ["sweep.seeds="]);
    // Locomotion has none.
    let radius = "reward.extrinsic.radius_m=";
    assert_eq!(values(&["train", "--set", "reward.extrinsic.ra"]), [radius]);
    assert_eq!(with(&[], "reward.extrinsic.ra"), [""; 0]);
    let reach = ["--set", "reward.extrinsic.kind='reach'"];
    assert_eq!(with(&reach, "reward.extrinsic.ra"), [radius]);
    assert_eq!(with(&["--set", "learning.rate=wrong"], "reward.sc"), ["reward.scale="]);
    for command in ["config", "cell", "slurm"] {
        assert_eq!(values(&[command, CRAWLER, "--set", "reward.pen"]), ["reward.penalty="]);
    }
    let keys = ["reward.mix", "reward.mix.kind", "reward.mix.power", "reward.mix.schedule"];
    let found = values(&["config", "--help", "reward.mix"]);
    assert_eq!(found[..4], keys);

    let cells = of(&["cell", CRAWLER, "--index", ""]);
    let expected: Vec<_> =
        CELLS.iter().enumerate().map(|(i, name)| (i.to_string(), (*name).to_owned())).collect();
    assert_eq!(cells, expected);
    assert_eq!(values(&["cell", CRAWLER, "--cells", "0,3"]), ["0,3"]);
    assert_eq!(values(&["cell", "nowhere.toml", "--index", ""]), [""; 0]);
}

/// What bash has for a line with the cursor at its end, cut into words as its readline does.
fn bash(line: &str) -> Vec<String> {
    let script = itarl(&["completions", "bash"]).ends(DONE).out;
    let test = r#"
        COMP_LINE=$1 COMP_POINT=${#1} COMP_WORDS=() word=
        for ((i = 0; i < ${#1}; i++)); do
            letter=${1:i:1}
            case $letter in
            ' ') [[ -z $word ]] || COMP_WORDS+=("$word"); word= ;;
            =) [[ -z $word ]] || COMP_WORDS+=("$word"); COMP_WORDS+=("="); word= ;;
            *) word+=$letter ;;
            esac
        done
        current=$word
        [[ -z $word && $letter == = ]] || COMP_WORDS+=("$word")
        COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
        _itarl itarl "$current" ''
        printf '%s\n' "${COMPREPLY[@]}"
    "#;
    let words = ["-c", &(script + test), "bash", line];
    let output = Command::new("bash").args(words).current_dir(root()).output().unwrap();
    let out = String::from_utf8(output.stdout).unwrap();
    out.lines().filter(|line| !line.is_empty()).map(str::to_owned).collect()
}

#[test]
fn bash_completes_commands_and_options() {
    let commands = bash("itarl ");
    for line in itarl(&["--help"]).out.lines().skip_while(|it| *it != "Commands:").skip(1) {
        let Some(name) = line.split_whitespace().next() else { break };
        assert!(commands.contains(&name.to_owned()), "{name}: {commands:?}");
    }
    assert_eq!(bash("itarl summary --ea"), ["--early"]);
    assert_eq!(bash("itarl train --solver b"), ["bullet"]);
    assert_eq!(
        bash("itarl train --solver=b"),
        ["bullet"],
        "the shell has what is before the stroke"
    );
}

/// Whose words have a `=` in them, at which bash cuts words.
#[test]
fn bash_completes_cells_and_keys() {
    let (_folder, run) = begun();
    let run = run.display();
    let cells = CELLS.map(|it| format!("{run}/cells/{it}"));
    assert_eq!(bash(&format!("itarl replay {run}/")), cells);
    for (word, rest) in [
        ("xi=", &["0.75/seed=1", "0.75/seed=2", "1/seed=1", "1/seed=2"][..]),
        ("xi=0.7", &["0.75/seed=1", "0.75/seed=2"]),
        ("xi=0.75/se", &["0.75/seed=1", "0.75/seed=2"]),
        ("xi=0.75/seed=", &["1", "2"]),
        ("xi=1/seed=2", &["2"]),
    ] {
        assert_eq!(bash(&format!("itarl replay {run}/cells/{word}")), rest, "{word}");
    }
    // Behind words that were cut.
    let line = format!("itarl rollout {run}/cells/xi=1/seed=1 --policy ra");
    assert_eq!(bash(&line), ["random"]);
    assert_eq!(bash(&format!("itarl plot {run} --setting xi=1")), ["1"]);
    assert_eq!(bash(&format!("itarl train {CRAWLER} --set reward.pe")), ["reward.penalty="]);
    let line = format!("itarl train {CRAWLER} --set learning.rate=2 --set reward.pe");
    assert_eq!(bash(&line), ["reward.penalty="]);
}

#[test]
fn every_shell_has_a_script_and_the_program_answers_only_when_asked() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = itarl(&["completions", shell]).ends(DONE).out;
        assert!(script.contains("ITARL_COMPLETE"), "{script}");
        // Wherever the shell goes.
        let program = Path::new(env!("CARGO_BIN_EXE_itarl")).canonicalize().unwrap();
        assert!(script.contains(text(&program)), "{script}");
    }
    for value in ["", "0"] {
        let output = command(&["--version"]).env("ITARL_COMPLETE", value).output().unwrap();
        Said::of(output).ends(DONE).prints(&["itarl 0."]);
    }
}

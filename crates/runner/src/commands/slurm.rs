//! `itarl slurm`: a batch script that starts workers on a cluster. It's printed, and nothing is
//! submitted.
//!
//! Which cell is trained where is up to the workers, and when they run is up to Slurm.

use std::{
    env,
    fmt::Write,
    path::{Path, PathBuf, absolute},
    time::Duration,
};

use anyhow::{Context, bail};

use super::{Outcome, open, print, train::default_folder};
use crate::{
    cli::Slurm,
    experiment::Plan,
    models, policies,
    session::{Session, Solver, recorded_layout},
    training::check_files,
};

/// Cores of a worker, unless more are asked for: few nodes have as many free at a time.
const MOST_CPUS: usize = 16;

/// Memory of the program itself, and of a world in Bullet and in a solver's lanes. Beside them, a cell
/// takes a few times what it saves: as it lives, as sections, as files.
const PROGRAM_MIB: usize = 128;
const WORLD_MIB: usize = 4;
const COPIES: usize = 4;

/// Seconds before a job's end at which Slurm asks a worker to stop, if that hasn't yet.
const NOTICE: u32 = 90;

pub(super) fn slurm(arguments: &Slurm) -> anyhow::Result<Outcome> {
    let plan = open(&arguments.experiment)?;
    check_files(&plan)?;
    print(script(arguments, &plan)?.as_bytes())?;
    Ok(Outcome::Done)
}

fn script(arguments: &Slurm, plan: &Plan) -> anyhow::Result<String> {
    let file = &arguments.experiment.file;
    let out = absolute(arguments.out.clone().unwrap_or_else(|| default_folder(file)))?;
    let (Some(name), Some(parent)) = (out.file_name(), out.parent()) else {
        bail!("{}: a folder with a name expected", out.display());
    };
    if !parent.is_dir() {
        bail!("{}: there's no such folder, and Slurm writes logs beside the run", parent.display());
    }
    let lanes = Solver::lockstep()?.lanes();
    let worlds: usize = plan.cells().iter().map(|cell| cell.experiment.learning.worlds).sum();
    let fill = worlds.div_ceil(lanes).div_ceil(usize::from(arguments.nodes));
    let cpus = arguments.cpus.map_or(fill.min(MOST_CPUS), usize::from);
    let name = name.to_string_lossy();
    let log = format!("{}/{name}.%A_%a.log", parent.display().to_string().replace('%', "%%"));

    let mut options = vec![
        format!("--job-name={}", quoted(&format!("itarl-{name}"))),
        format!("--array=1-{}", arguments.nodes),
        "--nodes=1 --ntasks=1".into(),
        format!("--cpus-per-task={cpus}"),
        format!("--mem={}M", memory_mib(plan, cpus * lanes)?),
        format!("--time={}", minutes(arguments.time)?),
        "--requeue".into(),
        format!("--signal=B:USR1@{NOTICE}"),
        "--open-mode=append".into(),
        format!("--output={}", quoted(&log)),
        format!("--chdir={}", quoted(&text(&env::current_dir()?)?)),
    ];
    let named = [("account", &arguments.account), ("partition", &arguments.partition)];
    options.extend(
        named.iter().filter_map(|(key, value)| Some(format!("--{key}={}", value.as_deref()?))),
    );
    options.extend(arguments.sbatch.iter().cloned());

    let mut words = vec![text(&program()?)?, "train".into(), text(&absolute(file)?)?];
    words.extend(arguments.experiment.set.iter().flat_map(|set| ["--set".into(), set.clone()]));
    words.extend(["--out".into(), text(&out)?, "--threads".into(), cpus.to_string()]);
    let command = words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ");
    Ok(written(&options, &command))
}

/// A shell doesn't pass signals on, and a second one would end its waiting: so the first is passed
/// on and all others are none. A worker that stopped, or that left cells to others, is started again.
fn written(options: &[String], command: &str) -> String {
    let mut script = "#!/bin/bash\n".to_owned();
    for option in options {
        // Writing to a string can't fail.
        let _ = writeln!(script, "#SBATCH {option}");
    }
    script
        + &format!(
            "\n\
             trap 'trap \"\" USR1 TERM; kill -USR1 $!' USR1 TERM\n\
             {command} &\n\
             wait $!\n\
             wait $!  # a signal ends the first wait, and not the worker\n\
             code=$?\n\
             if test $code -eq 75; then\n  \
               scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID\"\n\
             fi\n\
             exit $code\n"
        )
}

/// What so many worlds at a time take, by the state of the first cell.
fn memory_mib(plan: &Plan, worlds: usize) -> anyhow::Result<usize> {
    let cell = plan.cells().first().context("no cells")?;
    let experiment = &cell.experiment;
    let morphology = models::open(experiment)?;
    let initial = experiment.initial().map(policies::open).transpose()?;
    let mut session = Session::build(experiment, &morphology, initial.as_deref(), cell.seed)?;
    let state: usize = session.save()?.values().map(Vec::len).sum();
    let layout = recorded_layout(experiment, &morphology);
    let poses = 7 * size_of::<f32>() * layout.frames_per_step * layout.bodies.len();
    let numbers = layout.sensors.len() + layout.actuators.len() + 2 * layout.terms.len();
    let step = poses + size_of::<f32>() * numbers + layout.bodies.len();
    let recorded = usize::try_from(experiment.record.steps).unwrap_or(usize::MAX);
    let saved = state.saturating_add(recorded.saturating_mul(step));
    let cells = worlds.div_ceil(experiment.learning.worlds).min(plan.cells().len());
    let bytes = saved.saturating_mul(COPIES * cells);
    Ok(PROGRAM_MIB + WORLD_MIB * worlds + bytes.div_ceil(1 << 20))
}

/// Where the program is. One from an archive of `make dist` is started by a loader of its own, and told.
fn program() -> anyhow::Result<PathBuf> {
    let told = env::var_os("ITARL_PROGRAM").map(PathBuf::from);
    told.map_or_else(|| env::current_exe().context("asking where the program is"), Ok)
}

/// As Slurm counts.
fn minutes(time: Duration) -> anyhow::Result<u64> {
    match time.as_secs().div_ceil(60) {
        0 => bail!("--time must be a minute or more"),
        minutes => Ok(minutes),
    }
}

fn text(path: &Path) -> anyhow::Result<String> {
    let text = path.to_str().with_context(|| format!("{}: not in UTF-8", path.display()))?;
    match text.contains('\n') {
        true => bail!("{text:?}: a script can't have a line break in a path"),
        false => Ok(text.into()),
    }
}

/// As one word of a shell, and of sbatch, which knows the same quotes.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:%+@".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.into(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn words_are_read_back_by_a_shell() {
        for word in ["", "a b", "it's", "$HOME `x` \"y\"", "learning.optimiser=\"adam\"", "xi=1"] {
            let script = format!("printf %s {}", quoted(word));
            let said = Command::new("bash").args(["-c", &script]).output().unwrap();
            assert_eq!(String::from_utf8(said.stdout).unwrap(), word);
        }
    }

    /// Signalled twice it waits for its worker, passes one on, and asks for another go after 75 alone.
    #[test]
    fn the_script_passes_the_first_signal_on_and_ends_as_its_worker() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).display().to_string();
        for (code, signals) in [(0, 0), (75, 0), (1, 0), (75, 1), (75, 2)] {
            let (worker, log) = (path("worker"), path("log"));
            // What the worker gets, and what scontrol is asked for, is logged.
            let body = match signals {
                0 => format!("exit {code}"),
                _ => format!(
                    "trap 'echo USR1 >> {log}; sleep 0.4; exit {code}' USR1; echo ready >> {log}\n\
                     while :; do sleep 0.05; done"
                ),
            };
            std::fs::write(&worker, body).unwrap();
            std::fs::write(&log, "").unwrap();
            let script = written(&["--requeue".into()], &format!("bash {worker}"));
            let script = format!("scontrol() {{ echo \"$@\" >> {log}; }}\n{script}");
            let mut command = Command::new("bash");
            command.args(["-c", &script]).env("SLURM_ARRAY_JOB_ID", "7");
            let mut shell = command.env("SLURM_ARRAY_TASK_ID", "2").spawn().unwrap();
            if signals > 0 {
                while !std::fs::read_to_string(&log).unwrap().contains("ready") {
                    std::thread::sleep(Duration::from_millis(5));
                }
            }
            for _ in 0..signals {
                let kill = format!("kill -USR1 {}", shell.id());
                Command::new("bash").args(["-c", &kill]).status().unwrap();
                std::thread::sleep(Duration::from_millis(50));
            }
            assert_eq!(shell.wait().unwrap().code(), Some(code));
            let log = std::fs::read_to_string(&log).unwrap();
            assert_eq!(log.matches("USR1").count(), signals.min(1), "{log}");
            assert_eq!(log.contains("requeue 7_2"), code == 75, "{log}");
        }
    }

    #[test]
    fn times_are_rounded_up_to_minutes() {
        let of = |seconds| minutes(Duration::from_secs(seconds));
        assert_eq!([60, 61, 3600].map(|it| of(it).unwrap()), [1, 2, 60]);
        assert!(of(0).is_err());
    }
}

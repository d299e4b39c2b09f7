//! Landscapes: how a cell's reward, its task and its information depend on the policy's parameters, on
//! slices through the space of these.
//!
//! | file | what |
//! |---|---|
//! | `mod.rs` | [`Survey`]: cells, slices and rollouts; what is made, kept and read |
//! | `slice.rs` | [`Slice`]: lines and planes through parameters |
//! | `rollouts.rs` | policies at work beside each other; gradients |
//! | `store.rs` | arrays in files |
//! | `values.rs` | [`Functions`]: task, information and mixes of the same control steps |
//! | `measures.rs` | [`measure`]: roughness of each function on each slice; means over cells |
//! | [`tables`] | tables and figures of these |
//!
//! The measures themselves are the crate `landscape`'s. Each point of a slice is rolled out several
//! times: repeat r with the seed + r, the same at every point, so that the middle of a slice is what
//! `itarl rollout` does. Of a rollout all terms of all steps are kept, from which the landscape of any mix
//! is made without another step.

mod measures;
mod rollouts;
mod slice;
mod store;
pub mod tables;
mod values;

use std::{
    ops::Range,
    path::PathBuf,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use reward::Terms;
use svenja::Morphology;
use xxhash_rust::xxh3::xxh3_64;

pub use measures::{Measured, Row, Summary, align, measure, predict, summarise};
pub use slice::{Kind, Slice};
pub use values::Functions;

use crate::{experiment::Experiment, session::Solver, training::SolverKind};
use rollouts::Job;

/// A trained policy, through which slices go.
#[derive(Clone, Debug)]
pub struct Centre {
    /// The cell's name, `SETTING/seed=N`.
    pub name: String,
    /// The cell's settings.
    pub experiment: Experiment,
    /// Its robot.
    pub morphology: Morphology,
    /// What was learned, `[n_parameters]`.
    pub parameters: Vec<f64>,
    /// A number for settings and robot.
    pub identity: u64,
}

/// What is rolled out, and where it's kept.
#[derive(Clone, Debug)]
pub struct Survey {
    /// The cells.
    pub centres: Vec<Centre>,
    /// The slices through them.
    pub slices: Vec<Slice>,
    /// Control steps of a rollout.
    pub n_steps: u64,
    /// The seed of each first repeat.
    pub seed: u64,
    /// Rollouts of each point.
    pub n_repeats: usize,
    /// Rollouts of each centre by which its gradients are estimated.
    pub n_gradients: usize,
    /// Where everything goes.
    pub folder: PathBuf,
}

/// How it's done: nothing of this changes a result.
#[derive(Clone, Copy, Debug)]
pub struct How {
    /// Threads, at least 1.
    pub threads: usize,
    /// Who steps the worlds.
    pub solver: SolverKind,
    /// Worlds that a thread steps at a time; as many as the solver has lanes by default.
    pub lanes: Option<usize>,
}

/// Rollouts that are one file.
const PART: usize = 64;

/// What one thread does in one go.
#[derive(Clone, Debug)]
enum Part {
    /// Some points of a slice, with this seed.
    Rollouts { slice: usize, seed: u64, points: Range<usize> },
    /// Some repeats at a centre.
    Gradients { centre: usize, repeats: Range<usize> },
}

impl Survey {
    /// What the task's value is called, if all cells have the same task.
    #[must_use]
    pub fn task(&self) -> String {
        let symbol = |it: &Centre| it.experiment.reward.extrinsic.get().symbol();
        let mut symbols = self.centres.iter().map(symbol);
        let first = symbols.next().unwrap_or("R_Loc");
        if symbols.all(|it| it == first) { first.to_owned() } else { "task".into() }
    }

    /// What the information is called; none if no cell measures any.
    #[must_use]
    pub fn information(&self) -> Option<String> {
        let kinds = self.centres.iter().map(|it| it.experiment.reward.intrinsic.get());
        let mut symbols = kinds.filter(|it| it.is_measured()).map(|it| it.symbol());
        let first = symbols.next()?;
        Some(if symbols.all(|it| it == first) { first } else { "information" }.into())
    }

    /// What a slice counts for in means: its cell, or its pair of cells.
    #[must_use]
    pub fn unit<'a>(&'a self, slice: &'a Slice) -> &'a str {
        match slice.kind {
            Kind::Between => &slice.name,
            _ => &self.centres[slice.centre].name,
        }
    }

    /// Makes what isn't there yet; whether all of it is there now. `progress` is told how many of how many
    /// parts are there.
    ///
    /// # Errors
    /// Of the file system; settings that don't fit. What other threads have made by then is kept.
    pub fn make(
        &self,
        functions: &[Functions],
        how: How,
        is_stopped: &(dyn Fn() -> bool + Sync),
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> anyhow::Result<bool> {
        let all = self.parts();
        let n = all.len();
        let missing: Vec<_> =
            all.into_iter().filter(|part| !self.path(part, functions).exists()).collect();
        let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(n - missing.len()));
        let failed: Mutex<Option<anyhow::Error>> = Mutex::new(None);
        let work = || -> anyhow::Result<()> {
            let mut solver = match how.solver {
                SolverKind::Lockstep => Solver::lockstep()?,
                SolverKind::Bullet => Solver::bullet(),
            };
            while let Some(part) = missing.get(next.fetch_add(1, Ordering::Relaxed)) {
                if is_stopped() || lock(&failed).is_some() {
                    break;
                }
                let lanes = how.lanes.unwrap_or(solver.lanes());
                if self.make_part(part, functions, (&mut solver, lanes), is_stopped)? {
                    progress(done.fetch_add(1, Ordering::Relaxed) + 1, n);
                }
            }
            Ok(())
        };
        let thread = || {
            if let Err(error) = work() {
                lock(&failed).get_or_insert(error);
            }
        };
        thread::scope(|scope| {
            for _ in 0..how.threads.min(missing.len()) {
                scope.spawn(thread);
            }
        });
        match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(error),
            None => Ok(done.into_inner() == n),
        }
    }

    fn parts(&self) -> Vec<Part> {
        let mut parts = Vec::new();
        for seed in (self.seed..).take(self.n_repeats) {
            for (slice, laid) in self.slices.iter().enumerate() {
                let points = chunks(laid.places.len());
                parts.extend(points.map(|points| Part::Rollouts { slice, seed, points }));
            }
        }
        for centre in 0..self.centres.len() {
            let repeats = chunks(self.n_gradients);
            parts.extend(repeats.map(|repeats| Part::Gradients { centre, repeats }));
        }
        parts
    }

    /// Where a part is. What a file is known by is all that it depends on.
    fn path(&self, part: &Part, functions: &[Functions]) -> PathBuf {
        let (kind, identity, file) = match part {
            Part::Rollouts { slice, seed, points } => {
                let slice = &self.slices[*slice];
                let identity = slice.identity(&self.centres[slice.centre], self.n_steps);
                ("rollouts", identity, format!("{seed}-{}", points.start))
            }
            Part::Gradients { centre, repeats } => {
                let Centre { identity, parameters, .. } = &self.centres[*centre];
                let (n, functions) = (self.n_steps, &functions[*centre]);
                let text = format!("{identity:016x} {n} {functions:?} {parameters:?}");
                let Range { start, end } = repeats;
                ("gradients", xxh3_64(text.as_bytes()), format!("{}-{start}-{end}", self.seed))
            }
        };
        self.folder.join(kind).join(format!("{identity:016x}")).join(format!("{file}.npy"))
    }

    fn make_part(
        &self,
        part: &Part,
        functions: &[Functions],
        (solver, lanes): (&mut Solver, usize),
        is_stopped: &dyn Fn() -> bool,
    ) -> anyhow::Result<bool> {
        let path = self.path(part, functions);
        let (centre, jobs) = self.jobs(part);
        let mut values = Vec::new();
        for group in jobs.chunks(lanes.max(1)) {
            let Some(of_group) = (match part {
                Part::Rollouts { .. } => rollouts::roll_out(
                    &self.centres[centre],
                    group,
                    self.n_steps,
                    solver,
                    is_stopped,
                )?
                .map(|rolled| rolled.iter().flatten().flat_map(Terms::as_array).collect()),
                Part::Gradients { .. } => {
                    let rewards = |terms: &Terms| functions[centre].of(terms);
                    let centre = &self.centres[centre];
                    rollouts::gradients(centre, group, self.n_steps, solver, &rewards, is_stopped)?
                        .map(|gradients| gradients.concat().concat())
                }
            }) else {
                return Ok(false);
            };
            let of_group: Vec<f64> = of_group;
            values.extend(of_group);
        }
        store::write(&path, self.shape(part, functions), values.into_iter())?;
        Ok(true)
    }

    /// The centre whose world it is, and who acts in it.
    fn jobs(&self, part: &Part) -> (usize, Vec<Job>) {
        match part {
            Part::Rollouts { slice, seed, points } => {
                let slice = &self.slices[*slice];
                let job = |point| Job { parameters: slice.parameters(point), seed: *seed };
                (slice.centre, points.clone().map(job).collect())
            }
            Part::Gradients { centre, repeats } => {
                let parameters = &self.centres[*centre].parameters;
                let job = |r: usize| Job {
                    parameters: parameters.clone(),
                    seed: self.seed.wrapping_add(r as u64),
                };
                (*centre, repeats.clone().map(job).collect())
            }
        }
    }

    fn shape(&self, part: &Part, functions: &[Functions]) -> [usize; 3] {
        match part {
            Part::Rollouts { points, .. } => {
                [points.len(), self.n_steps as usize, Terms::NAMES.len()]
            }
            Part::Gradients { centre, repeats } => {
                [repeats.len(), functions[*centre].n(), self.centres[*centre].parameters.len()]
            }
        }
    }

    fn read(&self, part: &Part, functions: &[Functions]) -> anyhow::Result<Vec<f64>> {
        let path = self.path(part, functions);
        let read = store::read(&path, self.shape(part, functions))?;
        read.ok_or_else(|| anyhow::anyhow!("{}: it's gone", path.display()))
    }

    /// The values of each function on a slice, `[n_functions][n_repeats][n_points]`.
    ///
    /// # Errors
    /// What isn't there, or is damaged.
    pub fn values(
        &self,
        slice: usize,
        functions: &[Functions],
    ) -> anyhow::Result<Vec<Vec<Vec<f64>>>> {
        let laid = &self.slices[slice];
        let of = &functions[laid.centre];
        let mut values = vec![vec![Vec::new(); self.n_repeats]; of.n()];
        for (r, seed) in (self.seed..).take(self.n_repeats).enumerate() {
            for points in chunks(laid.places.len()) {
                let part = Part::Rollouts { slice, seed, points };
                let steps = self.read(&part, functions)?;
                for rollout in steps.chunks(self.n_steps as usize * Terms::NAMES.len()) {
                    let terms: Vec<_> = rollout.chunks(Terms::NAMES.len()).map(terms).collect();
                    for (values, mean) in values.iter_mut().zip(of.means(&terms)) {
                        values[r].push(mean);
                    }
                }
            }
        }
        Ok(values)
    }

    /// Estimates of each function's gradient at a centre, `[n_functions][n_gradients][n_parameters]`.
    ///
    /// # Errors
    /// As [`Survey::values`].
    pub fn gradients(
        &self,
        centre: usize,
        functions: &[Functions],
    ) -> anyhow::Result<Vec<Vec<Vec<f64>>>> {
        let n = self.centres[centre].parameters.len();
        let mut gradients = vec![Vec::new(); functions[centre].n()];
        for repeats in chunks(self.n_gradients) {
            let values = self.read(&Part::Gradients { centre, repeats }, functions)?;
            for repeat in values.chunks(n * gradients.len()) {
                let estimates = repeat.chunks(n).map(<[f64]>::to_vec);
                gradients.iter_mut().zip(estimates).for_each(|(all, one)| all.push(one));
            }
        }
        Ok(gradients)
    }
}

/// In the order of [`Terms::NAMES`].
fn terms(values: &[f64]) -> Terms {
    let at = |i: usize| values.get(i).copied().unwrap_or(f64::NAN);
    Terms {
        reward: at(0),
        extrinsic_raw: at(1),
        extrinsic: at(2),
        intrinsic_nats: at(3),
        intrinsic_nats_corrected: at(4),
        intrinsic: at(5),
        penalty: at(6),
        xi: at(7),
    }
}

fn chunks(n: usize) -> impl Iterator<Item = Range<usize>> {
    (0..n).step_by(PART).map(move |start| start..(start + PART).min(n))
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

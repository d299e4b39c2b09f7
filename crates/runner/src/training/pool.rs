//! Cells over threads and lanes. A cell's result doesn't depend on which thread trains it, or beside
//! which others.
//!
//! Each thread has a batch of cells that take their control steps together, as many as there are
//! lanes for their worlds. A cell that ends makes room for one that waits; once none waits, a thread
//! without work takes over half a batch from another one.
//!
//! Other processes may be at cells of the same run. So that each has full lanes, cells are taken in
//! groups: where another process is at one, its neighbours are left to it until nothing else waits.

use std::{
    collections::{BTreeSet, VecDeque},
    sync::{Condvar, Mutex, MutexGuard, PoisonError},
    thread,
};

use bullet::LockstepCounts;
use runs::{Header, Row};

use super::{
    Ending, How, OpenRun, RunCell, SolverKind, StopSignal,
    cell::{ActiveCell, Build},
    room::Room,
};
use crate::session::{Session, Solver, control_step};

/// Is told how training goes, from all threads.
pub trait Observer: Sync {
    /// A cell goes on from so many control steps, 0 at its beginning.
    fn begin(&self, cell: &RunCell, control_steps: u64);
    /// A cell made an update.
    fn row(&self, cell: &RunCell, row: &Row);
    /// A cell's training ended in this call.
    fn end(&self, cell: &RunCell, ending: &Ending);
}

/// How training ended.
#[derive(Debug)]
pub struct Trained {
    /// The endings of the cells, in their order; one that wasn't begun counts as stopped.
    pub endings: Vec<Ending>,
    /// What became of the steps in lanes, all threads together.
    pub counts: LockstepCounts,
    /// Why a cell couldn't be begun when its turn came, if the system had no files for it.
    pub crowded: Option<anyhow::Error>,
}

/// Trains cells of a run, in their order as lanes get free. Those that another process is at are
/// looked at again at the end, and trained as far as it has left them.
///
/// # Errors
/// Vector instructions that the environment asks for and the processor doesn't have.
pub fn train_all(
    open_run: &OpenRun,
    cells: &[&RunCell],
    how: &How,
    stop: &StopSignal,
    observer: &dyn Observer,
) -> anyhow::Result<Trained> {
    let endings = cells.iter().map(|_| Ending::Elsewhere).collect();
    let mut trained = Trained { endings, counts: LockstepCounts::default(), crowded: None };
    loop {
        let left = trained.elsewhere();
        let these: Vec<_> = left.iter().map(|&index| cells[index]).collect();
        let round = train_once(open_run, &these, how, stop, observer)?;
        add(&mut trained.counts, &round.counts);
        trained.crowded = trained.crowded.or(round.crowded);
        for (&index, ending) in left.iter().zip(round.endings) {
            trained.endings[index] = ending;
        }
        let n_elsewhere = trained.elsewhere().len();
        // If all of them still are, there was nothing to do meanwhile.
        if n_elsewhere == 0 || n_elsewhere == left.len() || stop.is_requested() {
            return Ok(trained);
        }
    }
}

impl Trained {
    /// The cells that another process is at, by index.
    fn elsewhere(&self) -> Vec<usize> {
        let endings = self.endings.iter().enumerate();
        endings.filter(|(_, it)| matches!(it, Ending::Elsewhere)).map(|(index, _)| index).collect()
    }
}

fn train_once(
    open_run: &OpenRun,
    cells: &[&RunCell],
    how: &How,
    stop: &StopSignal,
    observer: &dyn Observer,
) -> anyhow::Result<Trained> {
    let n_threads = how.threads.clamp(1, cells.len().max(1));
    let mut solvers = (0..n_threads)
        .map(|_| match how.solver {
            SolverKind::Bullet => Ok(Solver::bullet()),
            SolverKind::Lockstep => Solver::lockstep(),
        })
        .collect::<Result<Vec<_>, _>>()?;
    let lanes = how.lanes.unwrap_or_else(|| solvers[0].lanes()).max(1);
    let Room { threads, lanes } = Room::make(Room { threads: n_threads, lanes });
    solvers.truncate(threads);
    let (waiting, n_to_do) = order(cells);
    let n_worlds = waiting.iter().take(n_to_do).map(|&index| worlds(cells[index])).sum();
    let batch_size = batch_size(n_worlds, threads, lanes);
    let pool = Pool {
        open_run,
        cells,
        how,
        stop,
        observer,
        lanes,
        shared: Mutex::new(Shared {
            waiting,
            left: BTreeSet::new(),
            handed_over: Vec::new(),
            idle: 0,
            at_work: threads,
            endings: cells.iter().map(|_| None).collect(),
            counts: LockstepCounts::default(),
            crowded: None,
        }),
        changed: Condvar::new(),
    };
    thread::scope(|scope| {
        for solver in solvers {
            let pool = &pool;
            scope.spawn(move || {
                Batch { pool, solver, members: Vec::new(), size: batch_size }.work()
            });
        }
    });
    let Shared { endings, counts, crowded, .. } =
        pool.shared.into_inner().unwrap_or_else(PoisonError::into_inner);
    let endings = endings.into_iter().map(|ending| ending.unwrap_or(Ending::Stopped)).collect();
    Ok(Trained { endings, counts, crowded })
}

/// So many worlds for each thread at a time that all threads have about the same in every round: a
/// batch costs less for each world the larger it is, but a thread without one costs most.
fn batch_size(n_worlds: usize, n_threads: usize, lanes: usize) -> usize {
    let rounds = n_worlds.div_ceil(n_threads * lanes).max(1);
    n_worlds.div_ceil(n_threads * rounds).max(1)
}

/// Cells by index, those that are done behind the others: they have no more to do than to be looked
/// at. And how many wait before them.
fn order(cells: &[&RunCell]) -> (VecDeque<usize>, usize) {
    let is_done = runs::parallel::map(cells, |cell| {
        let header = Header::read(&cell.folder.checkpoint());
        // What can't be read is told when it's opened.
        header.is_ok_and(|it| it.is_some_and(|it| it.updates >= cell.expected().updates))
    });
    let (done, waiting): (Vec<_>, Vec<_>) = (0..cells.len()).partition(|&index| is_done[index]);
    let n_waiting = waiting.len();
    (waiting.into_iter().chain(done).collect(), n_waiting)
}

fn worlds(cell: &RunCell) -> usize {
    cell.cell.experiment.learning.worlds
}

struct Pool<'a> {
    open_run: &'a OpenRun,
    cells: &'a [&'a RunCell],
    how: &'a How,
    stop: &'a StopSignal,
    observer: &'a dyn Observer,
    lanes: usize,
    shared: Mutex<Shared<'a>>,
    /// A batch was handed over, or a thread came to its end.
    changed: Condvar,
}

struct Shared<'a> {
    /// Not begun, by index.
    waiting: VecDeque<usize>,
    /// Groups that another process was at, whose cells wait behind all others.
    left: BTreeSet<usize>,
    /// For threads without work.
    handed_over: Vec<Vec<Member<'a>>>,
    /// Threads without work, and those with.
    idle: usize,
    at_work: usize,
    endings: Vec<Option<Ending>>,
    counts: LockstepCounts,
    crowded: Option<anyhow::Error>,
}

/// A cell in a batch, with its index.
struct Member<'a> {
    index: usize,
    active: ActiveCell<'a>,
}

struct Batch<'a, 'b> {
    pool: &'b Pool<'a>,
    solver: Solver,
    members: Vec<Member<'a>>,
    /// Worlds that its members may have, but for a single one, which may have any number.
    size: usize,
}

impl<'a> Pool<'a> {
    fn lock(&self) -> MutexGuard<'_, Shared<'a>> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets the neighbours of a cell that is elsewhere wait behind all others.
    fn leave_group(&self, index: usize) {
        let size = (self.lanes / worlds(self.cells[index])).max(1);
        let group_of = |index: usize| self.cells[index].cell.index / size;
        let group = group_of(index);
        let mut shared = self.lock();
        if !shared.left.insert(group) {
            return;
        }
        let (neighbours, others) =
            shared.waiting.drain(..).partition::<Vec<_>, _>(|&it| group_of(it) == group);
        shared.waiting = others.into_iter().chain(neighbours).collect();
    }

    fn end(&self, index: usize, ending: Ending) {
        self.observer.end(self.cells[index], &ending);
        self.lock().endings[index] = Some(ending);
    }
}

impl Batch<'_, '_> {
    fn work(mut self) {
        let _guard = AtWork(self.pool);
        loop {
            self.fill();
            if self.members.is_empty() && !self.take_over() {
                break;
            }
            self.step();
            self.hand_over();
        }
        add(&mut self.pool.lock().counts, &self.solver.counts());
    }

    /// Takes waiting cells that can be stepped with those that are here.
    fn fill(&mut self) {
        let Pool { open_run, cells, how, stop, observer, .. } = *self.pool;
        while !stop.is_requested() {
            let build = self.members.first().map(|member| Build::of(member.active.cell));
            let left = self.size.saturating_sub(self.worlds());
            let fits = |&index: &usize| {
                build.is_none_or(|it| it == Build::of(cells[index]) && worlds(cells[index]) <= left)
            };
            let mut shared = self.pool.lock();
            let Some(place) = shared.waiting.iter().position(fits) else { break };
            let Some(index) = shared.waiting.remove(place) else { break };
            drop(shared);
            match ActiveCell::begin(open_run, cells[index], how.limits, observer) {
                Ok(active) => self.members.push(Member { index, active }),
                Err(Ending::Crowded(error)) => {
                    self.shrink(index, error);
                    break;
                }
                Err(ending) => {
                    if matches!(ending, Ending::Elsewhere) {
                        self.pool.leave_group(index);
                    }
                    self.pool.end(index, ending);
                }
            }
        }
    }

    fn worlds(&self) -> usize {
        self.members.iter().map(|member| member.active.session.worlds()).sum()
    }

    /// There are no files for more members than it has. The cell waits for one of them to end, or
    /// for another batch.
    fn shrink(&mut self, index: usize, error: anyhow::Error) {
        self.size = self.worlds();
        let mut shared = self.pool.lock();
        shared.waiting.push_front(index);
        shared.crowded.get_or_insert(error);
    }

    /// A control step of all members; those that came to their end leave.
    fn step(&mut self) {
        let mut sessions: Vec<&mut Session> =
            self.members.iter_mut().map(|member| &mut member.active.session).collect();
        let results = control_step(&mut sessions, &mut self.solver);
        let mut results = results.into_iter();
        let (pool, is_to_stop) = (self.pool, self.pool.stop.is_requested());
        self.members.retain_mut(|member| {
            let active = &mut member.active;
            // As many results as members, in their order.
            let mut ending =
                results.next().and_then(|result| active.after_step(result, pool.observer));
            if is_to_stop && ending.is_none() {
                ending = Some(active.stop());
            }
            let stays = ending.is_none();
            if let Some(ending) = ending {
                pool.end(member.index, ending);
            }
            stays
        });
    }

    /// Half of the batch goes to a thread that has no work.
    fn hand_over(&mut self) {
        if self.members.len() < 2 {
            return;
        }
        let mut shared = self.pool.lock();
        if shared.idle > shared.handed_over.len() {
            let half = self.members.split_off(self.members.len().div_ceil(2));
            shared.handed_over.push(half);
            self.pool.changed.notify_all();
        }
    }

    /// Waits for half a batch; false once there won't be one.
    fn take_over(&mut self) -> bool {
        let mut shared = self.pool.lock();
        shared.idle += 1;
        shared.at_work -= 1;
        self.pool.changed.notify_all();
        loop {
            if let Some(members) = shared.handed_over.pop() {
                self.members = members;
                shared.idle -= 1;
                shared.at_work += 1;
                return true;
            }
            if shared.at_work == 0 {
                return false;
            }
            let woken = self.pool.changed.wait(shared);
            shared = woken.unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Lets the other threads know of one that panics, so that they don't wait for it.
struct AtWork<'a, 'b>(&'b Pool<'a>);

impl Drop for AtWork<'_, '_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.lock().at_work -= 1;
            self.0.changed.notify_all();
        }
    }
}

fn add(sum: &mut LockstepCounts, more: &LockstepCounts) {
    sum.swept += more.swept;
    sum.sweeps += more.sweeps;
    sum.idle += more.idle;
    sum.separate_groups += more.separate_groups;
    sum.unsupported += more.unsupported;
    sum.maybe_converged += more.maybe_converged;
    sum.not_finite += more.not_finite;
    sum.bullet_rows += more.bullet_rows;
    sum.bullet_moves += more.bullet_moves;
    sum.bullet_contacts += more.bullet_contacts;
}

#[cfg(test)]
mod tests {
    use super::batch_size;

    #[test]
    fn crews_fill_threads_and_rounds_evenly() {
        // 150 cells on two threads of 16 lanes take 5 rounds in any case: 15 at a time do.
        assert_eq!(batch_size(150, 2, 16), 15);
        assert_eq!(batch_size(16, 2, 16), 8);
        assert_eq!(batch_size(33, 2, 16), 9);
        assert_eq!(batch_size(3, 3, 16), 1);
        assert_eq!(batch_size(5, 1, 1), 1);
        assert_eq!(batch_size(0, 1, 16), 1);
    }
}

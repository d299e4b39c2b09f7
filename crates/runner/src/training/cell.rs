//! One cell from where it stands to where it's to stop.

use anyhow::Context;
use runs::{CellFolder, OpenCell, Recording, Snapshot, atomic, is_locked};
use svenja::Morphology;

use super::{Limits, Observer, OpenRun, RunCell};
use crate::{
    experiment::{ControlSettings, Experiment, PhysicsSettings},
    session::{self, Session, build_policy},
};

/// How a cell's training ended in this call.
#[derive(Debug)]
pub enum Ending {
    /// It has all its updates.
    Done,
    /// It stands at a checkpoint, to be gone on from.
    Stopped,
    /// Another process is at it.
    Elsewhere,
    /// There was no room for its files. It's as it was, or stands at its last checkpoint, to be gone
    /// on from once there is.
    Crowded(anyhow::Error),
    /// It blew up, now or before, for this reason.
    Failed(String),
    /// Its files can't be read or written. It can be gone on with once they can.
    Broken(anyhow::Error),
}

impl Ending {
    /// Of a cell whose files couldn't be had.
    fn of(error: anyhow::Error) -> Self {
        match error.downcast_ref() {
            Some(runs::Error::Locked { .. }) => Self::Elsewhere,
            Some(lack) if lack.is_lack_of_files() => Self::Crowded(error),
            _ => Self::Broken(error),
        }
    }
}

/// A cell at work. What it learned is in its folder at every checkpoint.
pub(super) struct ActiveCell<'a> {
    pub(super) cell: &'a RunCell,
    pub(super) session: Session,
    open: OpenCell,
    /// Control steps at the last checkpoint.
    saved: u64,
    /// Updates at the end of this call, and in all.
    last: u64,
    target: u64,
}

/// What cells must share to be stepped together.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Build<'a> {
    robot: usize,
    physics: &'a PhysicsSettings,
    control: &'a ControlSettings,
}

impl<'a> Build<'a> {
    pub(super) fn of(cell: &'a RunCell) -> Self {
        let experiment = &cell.cell.experiment;
        let (physics, control) = (&experiment.physics, &experiment.control);
        Self { robot: cell.robot, physics, control }
    }
}

impl<'a> ActiveCell<'a> {
    /// A cell opened for work; or its ending, if there is nothing to do.
    pub(super) fn begin(
        open_run: &OpenRun,
        cell: &'a RunCell,
        limits: Limits,
        observer: &dyn Observer,
    ) -> Result<Self, Ending> {
        let active = Self::open(open_run, cell, limits).map_err(Ending::of)??;
        observer.begin(cell, active.session.control_steps());
        Ok(active)
    }

    fn open(
        open_run: &OpenRun,
        cell: &'a RunCell,
        limits: Limits,
    ) -> anyhow::Result<Result<Self, Ending>> {
        // Before anything is read: others may be at most of a run's cells.
        if is_locked(&cell.folder.lock())? {
            return Ok(Err(Ending::Elsewhere));
        }
        // Before it's opened, which would cut the rows behind its checkpoint.
        if let Some(reason) = cell.folder.failure()? {
            return Ok(Err(Ending::Failed(reason)));
        }
        let (settings, morphology) = (&cell.cell.experiment, open_run.morphology(cell));
        // Whose bytes are as they were, `itarl status --check` tells.
        if cell.folder.is_complete(cell.expected(), settings.learning.worlds as u64) {
            return Ok(Err(Ending::Done));
        }
        check_exports(&cell.folder, settings, morphology)?;
        let (mut open, checkpoint) = open_run
            .catalogue()
            .expecting(cell, |expected| OpenCell::open(cell.folder.clone(), expected))?;
        let mut session = open_run.session(cell)?;
        if let Some(checkpoint) = &checkpoint {
            let path = cell.folder.checkpoint();
            session.restore(checkpoint).with_context(|| path.display().to_string())?;
        }
        let target = settings.learning.updates;
        if session.updates() >= target {
            // A process killed right after the last checkpoint left the exports of the one before.
            open.export(&session.policy_file()?, &session.recording().encode()?)?;
            return Ok(Err(Ending::Done));
        }
        let last =
            limits.stop_after.map_or(target, |n| target.min(session.updates().saturating_add(n)));
        if session.updates() == last {
            return Ok(Err(Ending::Stopped));
        }
        let saved = session.control_steps();
        open.sign()?;
        Ok(Ok(Self { cell, session, open, saved, last, target }))
    }

    /// After a control step: learns if it's time to. An ending if that was the last one.
    pub(super) fn after_step(
        &mut self,
        result: Result<(), session::Error>,
        observer: &dyn Observer,
    ) -> Option<Ending> {
        let ending = match result {
            Err(error @ session::Error::Interrupted { .. }) => Err(error.into()),
            Err(error) => self.fail(&error),
            Ok(()) if self.session.is_to_learn() => self.learn(observer),
            Ok(()) => return None,
        };
        ending.unwrap_or_else(|error| Some(Ending::of(error)))
    }

    fn learn(&mut self, observer: &dyn Observer) -> anyhow::Result<Option<Ending>> {
        match self.session.learn() {
            Ok(row) => {
                self.open.append(&row)?;
                observer.row(self.cell, &row);
            }
            Err(error) => return self.fail(&error),
        }
        let updates = self.session.updates();
        let is_last = updates == self.last;
        if is_last || updates.is_multiple_of(self.cell.cell.experiment.checkpoint.every) {
            self.save()?;
        }
        Ok(is_last.then(|| self.stopped()))
    }

    /// Stops it where it stands, between two control steps.
    pub(super) fn stop(&mut self) -> Ending {
        match self.save() {
            Ok(()) => self.stopped(),
            Err(error) => Ending::of(error),
        }
    }

    fn stopped(&self) -> Ending {
        if self.session.updates() == self.target { Ending::Done } else { Ending::Stopped }
    }

    fn save(&mut self) -> anyhow::Result<()> {
        let session = &mut self.session;
        // While it settles, too.
        if session.control_steps() == self.saved {
            return Ok(());
        }
        let recording = session.recording().encode()?;
        self.open.save(Snapshot {
            updates: session.updates(),
            control_steps: session.control_steps(),
            sections: session.save()?,
            policy: &session.policy_file()?,
            replay: &recording,
        })?;
        self.saved = session.control_steps();
        Ok(())
    }

    fn fail(&mut self, error: &session::Error) -> anyhow::Result<Option<Ending>> {
        let reason = error.to_string();
        self.open.fail(&reason)?;
        Ok(Some(Ending::Failed(reason)))
    }
}

/// Exports may be missing, or older than the checkpoint; damaged ones are for a person to look at.
fn check_exports(
    folder: &CellFolder,
    experiment: &Experiment,
    morphology: &Morphology,
) -> anyhow::Result<()> {
    let advice = "delete it, and a resume makes it again from the checkpoint";
    if let Some(bytes) = atomic::read(&folder.policy())? {
        build_policy(experiment, morphology, 0)?
            .read_safetensors(&bytes)
            .with_context(|| format!("{}: damaged: {advice}", folder.policy().display()))?;
    }
    Recording::read(&folder.replay()).context(advice)?;
    Ok(())
}

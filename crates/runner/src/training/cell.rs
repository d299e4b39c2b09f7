//! One cell from where it stands to where it's to stop.

use anyhow::Context;
use crbm::Layout;

use super::{Lab, LabCell, Limits, Observer, Stop};
use crate::{
    session::{Error, Session},
    store::{CellFolder, OpenCell, Recording, Snapshot, atomic},
};

/// How a cell's training ended in this call.
#[derive(Debug)]
pub enum Ending {
    /// It has all its updates.
    Done,
    /// It stands at a checkpoint, to be gone on from.
    Stopped,
    /// It blew up, now or before, for this reason.
    Failed(String),
    /// Its files can't be read or written. It can be gone on with once they can.
    Broken(anyhow::Error),
}

/// Trains a cell. What it learned is in its folder at every checkpoint.
#[must_use]
pub fn train_cell(
    lab: &Lab,
    cell: &LabCell,
    limits: Limits,
    stop: &Stop,
    observer: &dyn Observer,
) -> Ending {
    train(lab, cell, limits, stop, observer).unwrap_or_else(Ending::Broken)
}

fn train(
    lab: &Lab,
    cell: &LabCell,
    limits: Limits,
    stop: &Stop,
    observer: &dyn Observer,
) -> anyhow::Result<Ending> {
    let settings = &cell.cell.experiment;
    // Before it's opened, which would cut the rows behind its checkpoint.
    if let Some(reason) = cell.folder.failure()? {
        return Ok(Ending::Failed(reason));
    }
    check_exports(&cell.folder)?;
    let (mut open, checkpoint) = OpenCell::open(cell.folder.clone(), cell.identity)?;
    let target = settings.learning.updates;
    let saved = checkpoint.as_ref().map_or(0, |checkpoint| checkpoint.header.updates);
    let morphology = lab.morphology(cell);
    let mut session = match &checkpoint {
        Some(checkpoint) => {
            let mut session = Session::build(settings, morphology, cell.cell.seed)?;
            let path = cell.folder.checkpoint();
            session.restore(checkpoint).with_context(|| path.display().to_string())?;
            session
        }
        None => match Session::start(settings, morphology, cell.cell.seed) {
            Err(error) => return failed(&mut open, &error),
            Ok(session) => session,
        },
    };
    if saved >= target {
        // A process killed right after the last checkpoint left the exports of the one before.
        open.export(&session.policy_file()?, &session.recording().encode()?)?;
        return Ok(Ending::Done);
    }
    observer.begin(cell, session.updates());

    let last = limits.stop_after.map_or(target, |n| target.min(saved.saturating_add(n)));
    let mut saved = saved;
    while session.updates() < last && !stop.is_wished() {
        match session.update() {
            Ok(row) => {
                open.append(&row)?;
                observer.row(cell, &row);
            }
            Err(error) => return failed(&mut open, &error),
        }
        if session.updates().is_multiple_of(settings.checkpoint.every) {
            save(&mut open, &mut session)?;
            saved = session.updates();
        }
    }
    if session.updates() > saved {
        save(&mut open, &mut session)?;
    }
    Ok(if session.updates() == target { Ending::Done } else { Ending::Stopped })
}

/// Exports may be missing, or older than the checkpoint; damaged ones are for a person to look at.
fn check_exports(folder: &CellFolder) -> anyhow::Result<()> {
    let advice = "delete it, and a resume makes it again from the checkpoint";
    if let Some(bytes) = atomic::read(&folder.policy())? {
        Layout::from_safetensors(&bytes)
            .with_context(|| format!("{}: damaged: {advice}", folder.policy().display()))?;
    }
    Recording::read(&folder.replay()).context(advice)?;
    Ok(())
}

fn save(open: &mut OpenCell, session: &mut Session) -> anyhow::Result<()> {
    let recording = session.recording().encode()?;
    open.save(Snapshot {
        updates: session.updates(),
        control_steps: session.control_steps(),
        sections: session.save()?,
        policy: &session.policy_file()?,
        replay: &recording,
    })?;
    Ok(())
}

fn failed(open: &mut OpenCell, error: &Error) -> anyhow::Result<Ending> {
    let reason = error.to_string();
    open.fail(&reason)?;
    Ok(Ending::Failed(reason))
}

//! The policies that cells of a run start from: its copies of their files, found and read.

use std::{fs, io};

use config::{Place, Problems};
use runs::Run;

use crate::experiment::absolute;

/// Where the copies are, in the order of the manifest, as experiments name them.
pub(crate) fn paths(run: &Run) -> Vec<String> {
    run.manifest().policies.iter().map(|copy| absolute(&run.policy_path(&copy.file))).collect()
}

/// All copies, in the order of the manifest.
///
/// # Errors
/// A copy that isn't what the run was made with.
pub(crate) fn read(run: &Run) -> Result<Vec<Vec<u8>>, runs::Error> {
    run.manifest().policies.iter().map(|copy| run.policy(copy)).collect()
}

/// The bytes of a policy's file, wherever it is.
///
/// # Errors
/// What isn't a file, or can't be read.
pub(crate) fn open(path: &str) -> Result<Vec<u8>, Problems> {
    let refuse = |message: String| Problems::one(Place::whole(path), message);
    let unreadable = |error: io::Error| refuse(format!("can't be read: {error}"));
    // Reading what isn't a file may never end.
    if !fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(refuse("a file expected, as a cell's policy.safetensors".into()));
    }
    fs::read(path).map_err(unreadable)
}

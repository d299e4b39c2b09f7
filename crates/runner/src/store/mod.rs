//! What a run leaves on disk, so that it can be killed at any moment and go on exactly.
//!
//! `docs/run-folders.md` has every file, column and tensor. Three rules keep it whole:
//!
//! 1. A file is either replaced as a whole, by one rename ([`atomic`]), or only grows
//!    ([`Appended`]). The run folder itself appears by one rename ([`Run::create`]).
//! 2. A cell's truth is its checkpoint. It has the length and the hash of what `metrics.csv` held
//!    then; rows after it are cut off when the cell goes on. The exports are derived from it.
//! 3. One process at a time writes to a cell ([`Lock`]). Reading needs no lock, and believes what a
//!    resume would go on from ([`CellFolder::rows`]).

mod appended;
pub mod atomic;
mod cell;
mod checkpoint;
mod error;
mod lock;
mod manifest;
mod metrics;
mod record;
mod replay;
mod run;
mod settings;
mod status;

pub use appended::{Appended, Extent};
pub use cell::{CellFolder, OpenCell, Snapshot};
pub use checkpoint::{Checkpoint, Expected, Header};
pub use error::{Difference, Error};
pub use lock::{Lock, is_locked};
pub use manifest::{Bullet, Cell, FileCopy, Hash, MODELS, Manifest, POLICIES, Precision};
pub use metrics::{COLUMNS, Row, header_line, read_all, read_last};
pub use replay::{Layout, Recording, Ring, Step, TENSORS};
pub(crate) use run::MANIFEST;
pub use run::{NewRun, Run};
pub use status::{CellStatus, Look, State};

#[cfg(test)]
mod tests {
    use super::*;

    /// Each name that a reader of the files meets is explained.
    #[test]
    fn the_document_has_every_name() {
        let document = include_str!("../../../../docs/run-folders.md");
        let folder = CellFolder::new("cells/xi=0.75/seed=1");
        let files = [
            folder.metrics(),
            folder.checkpoint(),
            folder.policy(),
            folder.replay(),
            folder.failed(),
            folder.lock(),
        ];
        for path in files {
            let name = path.file_name().unwrap().to_str().unwrap();
            assert!(document.contains(&format!("\n    {name} ")), "{name}");
        }
        for name in COLUMNS.iter().chain(&TENSORS) {
            assert!(document.contains(&format!("\n| `{name}` |")), "{name}");
        }
    }
}

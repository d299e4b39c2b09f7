//! What a run leaves on disk, so that it can be killed at any moment and go on exactly.
//!
//! Whoever trains writes here, and whoever reads results reads here; neither physics nor learning is
//! known. `docs/run-folders.md` has every file, column and tensor.
//!
//! | file | what |
//! |---|---|
//! | `run.rs`, `create.rs`, `grow.rs` | [`Run`]: the folder as a whole; [`NewRun`]: made by one rename; with more cells |
//! | `manifest.rs`, `differences.rs` | [`Manifest`]: what it's made of; what may differ from it |
//! | `cell.rs` | [`CellFolder`]: a cell's files; [`OpenCell`]: writing them, and in which order |
//! | `checkpoint.rs` | [`Checkpoint`]: the whole state, in an envelope that says whose it is |
//! | `row.rs`, `metrics.rs` | [`Row`]: one update; [`COLUMNS`]: what is known of it; reading `metrics.csv` |
//! | `appended.rs` | [`Appended`]: a file that only grows, cut back to its checkpoint |
//! | `replay/` | [`Recording`]: the last control steps; [`Ring`]: as they're kept while training |
//! | `record.rs`, `status.rs` | a cell as a reader may believe it; [`CellStatus`]: where it stands |
//! | `complete.rs` | whether nothing is left to do at a cell |
//! | `publish.rs` | [`Publication`]: what others need of a run, in a small folder; [`Published`]: what is read of it |
//! | `lock.rs`, `writer.rs` | [`Lock`]: one writer at a time; [`Writer`]: who that is |
//! | `atomic.rs` | [`atomic`]: whole files |
//! | `error.rs` | [`Error`]: which file, what was being done, what to do about it |
//! | `parallel.rs` | many cells read at a time |
//!
//! ```no_run
//! let run = runs::Run::open("runs/quick".as_ref())?;
//! for cell in &run.manifest().cells {
//!     let latest = runs::read_last(&run.cell(cell).metrics())?;
//!     println!("{} seed {}: {:?}", cell.setting, cell.seed, latest.map(|row| row.reward));
//! }
//! # Ok::<(), runs::Error>(())
//! ```
//!
//! Three rules keep a run whole:
//!
//! 1. A file is either replaced as a whole, by one rename ([`atomic`]), or only grows
//!    ([`Appended`]). The run folder itself appears by one rename ([`Run::create`]).
//! 2. A cell's truth is its checkpoint. It has the length and the hash of what `metrics.csv` held
//!    then; rows after it are cut off when the cell goes on. The exports are derived from it.
//! 3. One process at a time writes to a cell ([`Lock`]). Reading needs no lock, and believes what a
//!    resume would go on from ([`CellFolder::rows`]).

#![forbid(unsafe_code)]

mod appended;
pub mod atomic;
mod cell;
mod checkpoint;
mod complete;
mod create;
mod differences;
mod error;
mod grow;
mod lock;
mod manifest;
mod metrics;
pub mod parallel;
mod publish;
mod record;
mod replay;
mod row;
mod run;
mod status;
mod writer;

pub use appended::{Appended, Extent};
pub use atomic::make_folder;
pub use cell::{CellFolder, OpenCell, Snapshot};
pub use checkpoint::{Checkpoint, Expected, Header};
pub use create::NewRun;
pub use error::{Difference, Error};
pub use lock::{Lock, is_locked, require_locks};
pub use manifest::{Bullet, Cell, FileCopy, Hash, MODELS, Manifest, POLICIES, Precision};
pub use metrics::{read_all, read_last};
pub use publish::{Moments, Publication, Published, PublishedCell};
pub use replay::{Packing, Recording, RecordingLayout, Ring, Step, TENSORS};
pub use row::{COLUMNS, Column, Row, header_line};
pub use run::{CELLS, MANIFEST, Run};
pub use status::{CellStatus, Inspection, Look, State};
pub use writer::{Signature, Writer};

#[cfg(test)]
mod tests {
    use super::*;

    /// Each name that a reader of the files meets is explained.
    #[test]
    fn the_document_has_every_name() {
        let document = include_str!("../../../docs/run-folders.md");
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
        for Column { name, unit, .. } in &COLUMNS {
            assert!(document.contains(&format!("\n| `{name}` | {unit}")), "{name}, {unit}");
        }
        for name in &TENSORS {
            assert!(document.contains(&format!("\n| `{name}` |")), "{name}");
        }
    }
}

//! To come.
use super::{Drawing, Error, Figure, Options, Run};
pub(super) const FIGURE: Figure =
    Figure { name: "close-up", title: "", caption: "", draw, tables: |_| Vec::new() };
fn draw(_: &Run, _: &Options) -> Result<Drawing, Error> {
    Err(Error::Nothing { figure: FIGURE.name, why: "to come".into() })
}

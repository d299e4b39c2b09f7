//! Values of arguments that are several in one word.

use std::{
    ffi::OsString,
    ops::Range,
    path::{Path, PathBuf},
    str::FromStr,
};

use figures::FIGURES;

/// Some cells in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells {
    /// The first cell, counted from 0.
    pub first: usize,
    /// The last cell, which belongs to them.
    pub last: usize,
}

/// One of some parts, about equally long, of all cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Task {
    /// Which part, from 1.
    pub number: usize,
    /// How many parts there are.
    pub of: usize,
}

/// The size of a picture in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// The width in pixels, 16 to 4096.
    pub width: usize,
    /// The height in pixels, 16 to 4096.
    pub height: usize,
}

/// What `itarl plot` takes: a run, or a figure by its name. A run in a folder that is called like a figure
/// is named by `./final`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Shown {
    /// A run's folder.
    Run(PathBuf),
    /// A figure's name.
    Figure(&'static str),
}

impl Shown {
    /// A word of the command line.
    ///
    /// # Errors
    /// One that is neither.
    pub fn parse(word: OsString) -> Result<Self, String> {
        let mut names = FIGURES.iter().map(|it| it.name);
        if let Some(name) = names.clone().find(|name| word == **name) {
            return Ok(Self::Figure(name));
        }
        let path = Path::new(&word);
        // A path is told by its parts, and what's wrong with it by whoever opens it.
        if path.exists() || path.components().count() > 1 {
            return Ok(Self::Run(path.into()));
        }
        let names: Vec<_> = names.by_ref().collect();
        Err(format!("neither a run's folder nor a figure; figures: {}", names.join(", ")))
    }
}

impl FromStr for Cells {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (first, last) = text.split_once('-').unwrap_or((text, text));
            let (first, last) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
            (first <= last).then_some(Self { first, last })
        };
        parse().ok_or_else(|| format!("a cell or FIRST-LAST expected, as in 0-15, got {text}"))
    }
}

impl FromStr for Task {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (number, of) = text.split_once('/')?;
            let (number, of) = (number.parse().ok()?, of.parse().ok()?);
            (1..=of).contains(&number).then_some(Self { number, of })
        };
        parse().ok_or_else(|| format!("K/N expected, K from 1 to N, as in 1/10, got {text}"))
    }
}

impl Task {
    /// Its cells, of so many.
    #[must_use]
    pub fn cells(self, n: usize) -> Range<usize> {
        let begin = |number: usize| (number as u128 * n as u128 / self.of as u128) as usize;
        begin(self.number - 1)..begin(self.number)
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (width, height) = text.split_once('x')?;
            let (width, height) = (width.parse().ok()?, height.parse().ok()?);
            let fits = |side| (16..=4096).contains(&side);
            (fits(width) && fits(height)).then_some(Self { width, height })
        };
        parse()
            .ok_or_else(|| format!("WxH expected, each from 16 to 4096, as in 640x360, got {text}"))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn ranges_and_parts_are_read_and_nothing_else() {
        assert_eq!("3".parse(), Ok(Cells { first: 3, last: 3 }));
        assert_eq!("0-15".parse(), Ok(Cells { first: 0, last: 15 }));
        for wrong in ["", "-", "3-", "-3", "4-3", "a", "1-2-3", "1.5"] {
            assert!(wrong.parse::<Cells>().is_err(), "{wrong}");
        }
        assert_eq!("1/10".parse(), Ok(Task { number: 1, of: 10 }));
        for wrong in ["", "1", "0/4", "5/4", "1/0", "a/b", "1/2/3", "-1/2"] {
            assert!(wrong.parse::<Task>().is_err(), "{wrong}");
        }
    }

    proptest! {
        #[test]
        fn parts_have_each_cell_once_and_are_about_equally_long(n in 0_usize..5000, of in 1_usize..300) {
            let parts: Vec<_> = (1..=of).map(|number| Task { number, of }.cells(n)).collect();
            let cells: Vec<_> = parts.iter().cloned().flatten().collect();
            prop_assert_eq!(cells, (0..n).collect::<Vec<_>>());
            for part in parts {
                prop_assert!((n / of..=n.div_ceil(of)).contains(&part.len()));
            }
        }
    }
}

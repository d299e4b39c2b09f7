//! What is wrong with a file, and where.

use std::{fmt, sync::Arc};

/// Problems that are kept of one file: enough to see what is wrong, and nonsense may make a million.
pub const MOST_PROBLEMS: usize = 100;

/// Where something stands: a line and a column (in characters), both from 1.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// The file as the user named it, or the command-line argument.
    pub source: Arc<str>,
    /// 0: the source as a whole, which has no lines.
    pub line: usize,
    /// 0 where `line` is.
    pub column: usize,
}

impl Place {
    /// A source as a whole.
    #[must_use]
    pub fn whole(source: &str) -> Self {
        Self { source: source.into(), line: 0, column: 0 }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { source, line, column } = self;
        match line {
            0 => write!(formatter, "{source}"),
            _ => write!(formatter, "{source}:{line}:{column}"),
        }
    }
}

/// One mistake: `place: what is wrong, what was expected, what was found`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Problem {
    /// The place in the file.
    pub place: Place,
    /// What was expected there, and what was found.
    pub message: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}", self.place, self.message)
    }
}

/// The mistakes of a file, in its order; shown one a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problems(Vec<Problem>);

impl Problems {
    /// Puts them into the order of their places, and leaves out those beyond [`MOST_PROBLEMS`], with
    /// a first line that says so. At least one should be there.
    #[must_use]
    pub fn new(mut problems: Vec<Problem>) -> Self {
        problems.sort();
        problems.dedup();
        // Problems of several readings may have been put together.
        let message = format!("more than {MOST_PROBLEMS} problems, among them:");
        let had_more = problems.iter().any(|problem| problem.message == message);
        problems.retain(|problem| problem.message != message);
        if (had_more || problems.len() > MOST_PROBLEMS) && !problems.is_empty() {
            problems.truncate(MOST_PROBLEMS);
            let place = Place::whole(&problems[0].place.source);
            problems.insert(0, Problem { place, message });
        }
        Self(problems)
    }

    /// A single one.
    #[must_use]
    pub fn one(place: Place, message: impl Into<String>) -> Self {
        Self(vec![Problem { place, message: message.into() }])
    }

    /// All problems, in the order of their places.
    pub fn iter(&self) -> impl Iterator<Item = &Problem> {
        self.0.iter()
    }
}

impl From<Problems> for Vec<Problem> {
    fn from(problems: Problems) -> Self {
        problems.0
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.0.iter().enumerate() {
            write!(formatter, "{}{problem}", if i == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

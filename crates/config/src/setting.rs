//! What a reader asks for, told without a file: every key with its meaning, its default and what it
//! may be. So the code that reads a key is all that declares it, and no page about it can be wrong.
//!
//! ```
//! use config::{Presence, Rule, settings, within};
//!
//! let all = settings(|mix| {
//!     Some(mix.or("xi", within(0.0, 1.0).about("share of the extrinsic part"), 0.75))
//! });
//! assert_eq!(all[0].key, "xi");
//! assert_eq!(all[0].about, "share of the extrinsic part");
//! assert_eq!(all[0].expected, "a number from 0 to 1");
//! assert_eq!(all[0].presence, Presence::Default("0.75".into()));
//! ```

use crate::{Mismatch, Node, Place, Rule, Section, Value, section::Reading};

/// A key that a reader asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// The key, with dots from the top of the file: `reward.mix.xi`.
    pub key: String,
    /// What it means, in words; empty if its reader doesn't say.
    pub about: String,
    /// What the value must be, in words.
    pub expected: String,
    /// Whether it must be there, and what holds if it isn't.
    pub presence: Presence,
    /// The kinds whose key it is; None if it belongs to all.
    pub only: Option<Only>,
    /// The kinds that it chooses from, each with what it is; empty if it's another key.
    pub kinds: Vec<(String, String)>,
}

/// Whether a key must be there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Presence {
    /// It must be there.
    Required,
    /// Nothing stands for it if it isn't there.
    Optional,
    /// This value, as a file has it, if it isn't there.
    Default(String),
}

/// The kinds that a key belongs to, where others don't have it or have another one of its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Only {
    /// The key that chooses the kind.
    pub key: String,
    /// What it has to be: one of these words.
    pub kinds: Vec<String>,
}

/// All keys that a reader asks for, in its order, those of every kind among them
/// ([`Section::kind`]).
///
/// The reader is given an empty file, and its complaints aren't heard. It should ask for all its keys
/// before it gives up; a list of tables, or a table with names for keys, isn't looked into.
pub fn settings<T>(reader: impl FnOnce(&mut Section<'_>) -> Option<T>) -> Vec<Setting> {
    let reading = Reading::of_settings();
    let nothing = Node { place: Place::whole(""), value: Value::Table(Vec::new()) };
    Section::read_root(&nothing, &reading, reader);
    of_all_kinds(beside_each_other(reading.into_settings()))
}

/// Makes one of what several kinds declare alike, and puts what they declare differently beside it.
fn beside_each_other(declared: Vec<Setting>) -> Vec<Setting> {
    let mut all: Vec<Setting> = Vec::new();
    for setting in declared {
        if let Some(same) = all.iter_mut().find(|other| are_alike(other, &setting)) {
            if let (Some(only), Some(more)) = (&mut same.only, setting.only) {
                only.kinds.extend(more.kinds);
                only.kinds.dedup();
            }
        } else {
            let last = all.iter().rposition(|other| other.key == setting.key);
            all.insert(last.map_or(all.len(), |last| last + 1), setting);
        }
    }
    all
}

/// Whether two declarations are the same but for the kind that makes them.
fn are_alike(one: &Setting, other: &Setting) -> bool {
    fn parts(it: &Setting) -> (&str, &str, &str, &Presence, Option<&str>) {
        let chosen_by = it.only.as_ref().map(|only| only.key.as_str());
        (&it.key, &it.about, &it.expected, &it.presence, chosen_by)
    }
    parts(one) == parts(other)
}

/// What every kind has isn't of some kinds only.
fn of_all_kinds(mut all: Vec<Setting>) -> Vec<Setting> {
    let choices: Vec<_> = all.iter().filter(|setting| !setting.kinds.is_empty()).cloned().collect();
    for setting in &mut all {
        let Some(only) = &setting.only else { continue };
        let choice = choices.iter().find(|choice| choice.key == only.key);
        if let Some(choice) = choice.filter(|choice| choice.kinds.len() == only.kinds.len()) {
            setting.only = choice.only.clone();
        }
    }
    all
}

/// A rule with the meaning of the value that it's for; made by [`Rule::about`].
#[derive(Clone, Copy, Debug)]
pub struct About<R> {
    rule: R,
    about: &'static str,
    condition: Option<&'static str>,
}

impl<R: Rule> About<R> {
    pub(crate) fn new(rule: R, about: &'static str) -> Self {
        Self { rule, about, condition: None }
    }

    /// With what else the value must be, which its reader checks after the rule: as in "at most
    /// `every`".
    #[must_use]
    pub fn condition(self, condition: &'static str) -> Self {
        Self { condition: Some(condition), ..self }
    }
}

impl<R: Rule> Rule for About<R> {
    type Out = R::Out;

    fn expected(&self) -> String {
        self.rule.expected()
    }

    fn take(&self, node: &Node) -> Result<R::Out, Mismatch> {
        self.rule.take(node)
    }

    fn written(&self, value: &R::Out) -> String {
        self.rule.written(value)
    }

    fn meaning(&self) -> &'static str {
        self.about
    }

    fn range(&self) -> String {
        match self.condition {
            Some(condition) => format!("{}, {condition}", self.rule.range()),
            None => self.rule.range(),
        }
    }
}

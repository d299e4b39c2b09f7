//! The table `robot`: keys of the model file that have another value here. What they mean, and what
//! they may be, is the model's to say.

use config::{Document, Mismatch, Node, Place, Problems, Rule, Section, Value};
use serde::{Serialize, Serializer};

use super::{files::below, leaves, plan::toml_value};

/// In what a robot isn't as its model file says. Two are equal if they say the same, wherever that
/// stands.
#[derive(Clone, Debug, Default)]
pub struct RobotSettings(Vec<Change>);

#[derive(Clone, Debug)]
struct Change {
    /// In the model file, with dots.
    path: String,
    /// Where it stands in the experiment.
    place: Place,
    /// The value, which is no table.
    node: Node,
}

impl RobotSettings {
    pub(super) fn read(root: &mut Section<'_>) -> Self {
        let changes = Changes.about(
            "what is other than the model file says, by the file's own keys, which have their own \
             ranges; in lists (`body`, `joint`) by names, `robot.body.torso.mass_kg = 2`; and by `*` \
             for all that are there, `robot.servo.*.speed_limit_rad_s = 1`, but for those that are \
             named",
        );
        root.optional("robot", changes).unwrap_or_default()
    }

    /// Whether the robot is as its model file says.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Puts the values into a model file. What is wrong with one of them is told with its place in
    /// the experiment.
    ///
    /// # Errors
    /// Paths that the file can't have.
    pub fn change(&self, model: &mut Document) -> Result<(), Problems> {
        let mut problems = Vec::new();
        for Change { path, place, node } in &self.0 {
            let found = model.change(path, place, node).err();
            problems.extend(found.map(Vec::from).unwrap_or_default());
        }
        if problems.is_empty() { Ok(()) } else { Err(Problems::new(problems)) }
    }

    /// As the experiment has it.
    #[must_use]
    pub fn to_table(&self) -> toml::Table {
        let mut table = toml::Table::new();
        for Change { path, node, .. } in &self.0 {
            leaves::put(&mut table, path, toml_value(&node.value));
        }
        table
    }

    fn collect(&mut self, path: &str, entries: &[(config::Key, Node)]) {
        for (key, node) in entries {
            let (path, place) = (below(path, &key.name), key.place.clone());
            match &node.value {
                Value::Table(inner) => self.collect(&path, inner),
                _ => self.0.push(Change { path, place, node: node.clone() }),
            }
        }
    }
}

impl PartialEq for RobotSettings {
    fn eq(&self, other: &Self) -> bool {
        self.to_table() == other.to_table()
    }
}

impl Serialize for RobotSettings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.to_table().serialize(serializer)
    }
}

/// Takes a table of whatever there is.
struct Changes;

impl Rule for Changes {
    type Out = RobotSettings;

    fn expected(&self) -> String {
        "a table of the model file's keys".into()
    }

    fn take(&self, node: &Node) -> Result<RobotSettings, Mismatch> {
        let Value::Table(entries) = &node.value else { return Err(self.refuse(node)) };
        let mut changes = RobotSettings::default();
        changes.collect("", entries);
        // What is said of all comes before what is said of one; otherwise the order in which they
        // are written doesn't matter.
        let n_named = |path: &str| path.split('.').filter(|name| *name != "*").count();
        changes.0.sort_by(|a, b| (n_named(&a.path), &a.path).cmp(&(n_named(&b.path), &b.path)));
        Ok(changes)
    }

    fn written(&self, robot: &RobotSettings) -> String {
        leaves::inline(&robot.to_table().into())
    }
}

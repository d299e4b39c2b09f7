//! What the cells of a run are judged by: the task's own value, or what cells of several tasks have
//! in common; and what is told beside it, the information in the reward.

use runs::{Moments, Row};

use super::{Information, information::named, statistics};

/// A value of each update by which cells are compared, with its name on axes and in tables.
#[derive(Clone, Debug)]
pub struct Measure {
    /// What it measures, in a word: the task, as experiment files call it.
    pub what: String,
    /// Its symbol, `R_Loc`.
    pub symbol: String,
    /// The unit of a control step's value.
    pub unit: String,
    /// The information in the reward; none if no cell measures any.
    pub information: Option<Information>,
    /// What to keep in mind, in sentences: why it isn't the task's own value.
    pub caveats: Vec<String>,
    value: fn(&Row) -> f64,
}

impl Measure {
    /// The task's own value: the task's name, its symbol and its unit. Of information nothing is known.
    #[must_use]
    pub fn of_task(what: &str, symbol: &str, unit: &str) -> Self {
        let [what, symbol, unit] = [&what.replace('_', " "), symbol, unit].map(str::to_owned);
        Self { what, symbol, unit, information: None, caveats: Vec::new(), value: |row| row.task }
    }

    /// R_Loc, which is measured whatever the task, for a run whose settings have these tasks.
    #[must_use]
    pub fn common(tasks: &[&str]) -> Self {
        let caveat = format!(
            "The settings have different tasks ({}), whose values can't be compared: they are judged \
             by R_Loc, which is measured in all of them.",
            tasks.join(", ")
        );
        let task = Self::of_task("locomotion", "R_Loc", "m");
        Self { caveats: vec![caveat], value: |row| row.advance_m, ..task }
    }

    /// With information beside it, and what to keep in mind of that.
    #[must_use]
    pub fn with(mut self, information: Option<Information>, caveat: Option<String>) -> Self {
        self.information = information;
        self.caveats.extend(caveat);
        self
    }

    /// The value of an update.
    #[must_use]
    pub fn of(&self, row: &Row) -> f64 {
        (self.value)(row)
    }

    /// The moments of the value and of the information in nats over some rows.
    #[must_use]
    pub fn moments(&self, rows: &[Row]) -> Moments {
        statistics::moments(rows.iter().map(|row| (self.of(row), row.intrinsic_nats)))
    }

    /// Whether it's R_Loc, which each update has beside its task.
    pub(crate) fn is_advance(&self) -> bool {
        self.symbol == "R_Loc"
    }

    /// `locomotion R_Loc`; `turning`, where that's its symbol, too.
    #[must_use]
    pub fn name(&self) -> String {
        named(&self.what, &self.symbol)
    }

    /// Its symbol and its unit, the head of a column: `R_Loc m`.
    #[must_use]
    pub fn heading(&self) -> String {
        format!("{} {}", self.symbol, self.unit)
    }

    /// The unit beside an axis.
    pub(crate) fn axis_unit(&self) -> String {
        format!("{} per control step", self.unit)
    }

    /// The name of a table's column: `R_Loc_mean_m`.
    pub(crate) fn column(&self, what: &str) -> String {
        format!("{}_{what}_{}", self.symbol, self.unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_is_called_as_its_kind_calls_it() {
        let row = Row { advance_m: 1.0, task: 2.0, ..Row::default() };
        let walking = Measure::of_task("efficient_locomotion", "R_Eff", "m");
        assert_eq!(walking.name(), "efficient locomotion R_Eff");
        assert_eq!((walking.of(&row), walking.caveats.len()), (2.0, 0));
        let turning = Measure::of_task("turning", "turning", "rad");
        assert_eq!(
            (turning.name().as_str(), turning.column("mean")),
            ("turning", "turning_mean_rad".into())
        );
    }

    #[test]
    fn several_tasks_have_the_way_in_common() {
        let row = Row { advance_m: 1.0, task: 2.0, ..Row::default() };
        let common = Measure::common(&["locomotion", "turning"]);
        assert_eq!((common.of(&row), common.name().as_str()), (1.0, "locomotion R_Loc"));
        assert!(common.caveats[0].contains("(locomotion, turning)"));
    }
}

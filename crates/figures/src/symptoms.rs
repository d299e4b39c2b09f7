//! Symptoms: what is wrong with how a cell learns, seen in its rows, with the update where it began.
//!
//! [`KINDS`] lists them, each with what to try; `docs/health.md` says how each is found. A symptom is one
//! that lasts: it holds from some update to the cell's end, and that's at least a tenth of its updates.
//! Columns are looked at in the windows that they're kept in, up to 256 of a cell, so an update is right to
//! a window.

use runs::COLUMNS;

use super::{CellResults, Contacts, Information, Results, Setting, numbers::three_digits};

/// Nats per bit: what of 0.693 is left if one bit in 300 isn't as expected.
const FROZEN_NATS: f64 = 0.02;
/// Nats per variable: of a window of 100 readings in two bins, less than a single one that's out of turn.
const SILENT_NATS: f64 = 1e-4;
/// The norm of a gradient that is noise alone has about its standard error; the ratio's square has a mean
/// of 1, and a gradient of which half is signal has 2.
const LOST: f64 = 1.2;
/// Of the largest that it was.
const VANISHED: f64 = 1e-6;
/// Root mean square: a logistic unit with one input of this weight is 0.99995 sure.
const LARGE_PARAMETER: f64 = 10.0;
/// Relative change of the parameters' norm over all of the training.
const IDLE: f64 = 1e-3;
/// Of all readings.
const CLIPPED: f64 = 0.01;
/// Parts that touch and shouldn't, for each control step.
const FALLEN: f64 = 0.5;
/// Of the information, the correction of its bias.
const BIASED: f64 = 0.3;
/// Nats per variable that the correction is then. Of 100 readings in two bins it's 0.005 nats: where there's
/// hardly any information, that is all of what is measured, and nothing is wrong with the window.
const BIAS_NATS: f64 = 0.01;
/// Updates below which none of what takes time is told.
const FEWEST_UPDATES: usize = 10;
/// Recorded control steps likewise.
const FEWEST_STEPS: usize = 20;

/// A kind of symptom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// In a few words.
    pub name: &'static str,
    /// What to try.
    pub advice: &'static str,
}

/// A symptom of a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symptom {
    /// Which one.
    pub kind: &'static Kind,
    /// The update where it began; none if that has no update.
    pub since: Option<u64>,
    /// What was found, with its numbers.
    pub found: String,
}

impl Symptom {
    /// The symptom of a cell that ended for a reason, after so many updates.
    #[must_use]
    pub fn failed(updates: u64, reason: String) -> Self {
        Self { kind: &FAILED, since: Some(updates), found: reason }
    }
}

/// What isn't in a cell's rows.
#[derive(Clone, Debug, Default)]
pub struct Facts {
    /// Parameters of its policy.
    pub n_parameters: usize,
    /// Readings of an update that have a range, over all control steps and worlds.
    pub readings_per_update: f64,
    /// Its last recorded control steps, if there are any.
    pub contacts: Option<Contacts>,
}

macro_rules! kinds {
    ($($constant:ident: $name:literal, $advice:literal;)+) => {
        $(static $constant: Kind = Kind { name: $name, advice: $advice };)+

        /// All kinds.
        pub static KINDS: &[&Kind] = &[$(&$constant),+];
    };
}

kinds! {
    FAILED: "failed", "`itarl status` has the whole reason; a smaller `learning.rate`, or a robot that Bullet \
        holds better (`itarl model check`)";
    BEHIND: "behind", "`itarl resume` goes on with it, unless a process is at it (`itarl status`)";
    FROZEN_POLICY: "policy frozen", "a smaller `learning.rate` or `policy.initial_scale`, or a `learning.decay` \
        above 0: the policy does one thing whatever it sees, and its gradient is gone";
    SILENT: "no information", "look at the robot (`itarl replay`): it stands, lies, or repeats one pose; \
        more `policy.initial_scale`, or less weight of the task (`reward.mix.xi`) early on";
    BIAS: "information biased", "a longer `reward.intrinsic.window`, or fewer `codec.sensor_bits`: what is \
        counted is too little for a distribution";
    LOST_IN_NOISE: "gradient lost in noise", "more `learning.worlds` or `learning.steps_per_update`, a \
        `learning.baseline`, or a smaller `learning.discount`";
    NO_GRADIENT: "no gradient", "a smaller `learning.rate`, if the parameters are large; else `reward.scale`, \
        which may be too small to be seen";
    RUNNING_AWAY: "parameters running away", "a smaller `learning.rate` or `reward.scale`, or a `learning.decay` \
        above 0";
    IDLE_PARAMETERS: "parameters hardly move", "a larger `learning.rate` or `reward.scale`";
    CLIPPED_READINGS: "readings clipped", "wider ranges of the joints in the model file, or slower servos: \
        what is beyond a range is seen as its end";
    FALLEN_ROBOT: "parts touch that shouldn't", "look at the robot (`itarl replay`): it may have fallen; more \
        `reward.penalty`, or a model that stands more safely";
    STUCK_CONTACTS: "contacts never change", "look at the robot (`itarl replay`): feet that always or never \
        touch tell the policy nothing";
}

/// What is wrong with a cell of a setting, if anything; what can't be told isn't.
#[must_use]
pub fn symptoms(
    run: &Results,
    setting: &Setting,
    cell: &CellResults,
    facts: &Facts,
) -> Vec<Symptom> {
    let view = View { information: run.measure.information.as_ref(), setting, cell, facts };
    type Check<'a> = fn(&View<'a>) -> Option<Symptom>;
    let checks: [Check<'_>; 10] = [
        View::frozen,
        View::silent,
        View::bias,
        View::lost_in_noise,
        View::no_gradient,
        View::running_away,
        View::idle,
        View::clipped,
        View::fallen,
        View::stuck_contacts,
    ];
    let behind = behind(run, setting, cell);
    behind.into_iter().chain(checks.iter().filter_map(|check| check(&view))).collect()
}

/// More than a tenth of what the longest cell of its run has is missing.
fn behind(run: &Results, setting: &Setting, cell: &CellResults) -> Option<Symptom> {
    // Of its run, which has the same windows.
    let same = run.settings.iter().filter(|it| it.window == setting.window);
    let longest = same.flat_map(|it| &it.cells).map(CellResults::updates).max()?;
    let updates = cell.updates();
    let found = || format!("{updates} of {longest} updates");
    let is_behind = cell.outcome.is_behind && 10 * updates < 9 * longest;
    is_behind.then(|| Symptom { kind: &BEHIND, since: Some(updates as u64), found: found() })
}

/// A cell as it's looked at.
struct View<'a> {
    /// None where it isn't measured, and so can't be missing.
    information: Option<&'a Information>,
    setting: &'a Setting,
    cell: &'a CellResults,
    facts: &'a Facts,
}

/// A window's first update, and its mean of a column.
type Point = (u64, f64);

impl View<'_> {
    /// A column's windows.
    fn column(&self, name: &str) -> Vec<Point> {
        let place = COLUMNS.iter().position(|it| it.name == name);
        let Some(thinned) = place.and_then(|it| self.cell.columns.get(it)) else {
            return Vec::new();
        };
        let length = thinned.window() * self.setting.every;
        let points = thinned.over(thinned.window(), self.setting.every).into_iter().enumerate();
        points.map(|(i, [_, mean])| ((i * length) as u64 + 1, mean)).collect()
    }

    /// A function of two columns.
    fn both(&self, names: [&str; 2], of: fn(f64, f64) -> f64) -> Vec<Point> {
        let [a, b] = names.map(|name| self.column(name));
        a.into_iter().zip(b).map(|((update, a), (_, b))| (update, of(a, b))).collect()
    }

    /// A symptom, if something holds of the windows from one of them to the end.
    fn lasting(
        &self,
        kind: &'static Kind,
        points: &[Point],
        holds: impl Fn(f64) -> bool,
        found: impl Fn(f64) -> String,
    ) -> Option<Symptom> {
        let holds = |(_, value): &Point| value.is_finite() && holds(*value);
        let begin = points.iter().rposition(|it| !holds(it)).map_or(0, |last| last + 1);
        let last = &points[begin..];
        let &(since, _) = last.first()?;
        let is_long = self.cell.updates() >= FEWEST_UPDATES && 10 * last.len() >= points.len();
        let mean = last.iter().map(|(_, value)| value).sum::<f64>() / last.len() as f64;
        is_long.then(|| Symptom { kind, since: Some(since), found: found(mean) })
    }

    fn frozen(&self) -> Option<Symptom> {
        let entropy = self.column("output_entropy_nats");
        self.lasting(
            &FROZEN_POLICY,
            &entropy,
            |it| it < FROZEN_NATS,
            |mean| format!("outputs have {mean:.2e} nats per bit of 0.693"),
        )
    }

    fn silent(&self) -> Option<Symptom> {
        let information = self.information?;
        let nats = self.column("R_MI_nats");
        self.lasting(
            &SILENT,
            &nats,
            |it| it.abs() < SILENT_NATS,
            |mean| format!("{} is {mean:.2e} {}", information.symbol, information.axis_unit()),
        )
    }

    fn bias(&self) -> Option<Symptom> {
        let information = self.information?;
        let nats = self.both(["R_MI_nats", "R_MI_miller_madow_nats"], |nats, corrected| {
            let bias = (corrected - nats).abs();
            if bias > BIAS_NATS { bias / nats } else { f64::NAN }
        });
        self.lasting(
            &BIAS,
            &nats,
            |it| it > BIASED,
            |mean| {
                let Information { symbol, .. } = information;
                format!("the correction of its bias is {:.0} % of {symbol}", 100.0 * mean)
            },
        )
    }

    fn lost_in_noise(&self) -> Option<Symptom> {
        let ratio = self.both(["gradient_norm", "gradient_error"], |norm, error| norm / error);
        self.lasting(
            &LOST_IN_NOISE,
            &ratio,
            |it| it < LOST,
            |mean| format!("the gradient's norm is {mean:.2} of its standard error"),
        )
    }

    fn no_gradient(&self) -> Option<Symptom> {
        let norm = self.column("gradient_norm");
        let largest = norm.iter().map(|(_, norm)| *norm).fold(0.0, f64::max);
        self.lasting(
            &NO_GRADIENT,
            &norm,
            |it| it <= VANISHED * largest,
            |mean| format!("the gradient's norm is {mean:.2e}, and was {largest:.2e}"),
        )
    }

    fn running_away(&self) -> Option<Symptom> {
        let limit = LARGE_PARAMETER * (self.facts.n_parameters as f64).sqrt();
        let norm = self.column("parameter_norm");
        if self.facts.n_parameters == 0 {
            return None;
        }
        self.lasting(
            &RUNNING_AWAY,
            &norm,
            |it| it > limit,
            |mean| {
                let rms = mean / (self.facts.n_parameters as f64).sqrt();
                format!("parameters are {} in the root mean square", three_digits(rms))
            },
        )
    }

    fn idle(&self) -> Option<Symptom> {
        let norm = self.column("parameter_norm");
        let first = norm.first()?.1;
        let near = |it: f64| (it - first).abs() <= IDLE * first;
        let symptom = self.lasting(&IDLE_PARAMETERS, &norm, near, |mean| {
            let change = 100.0 * (mean - first).abs() / first.max(f64::MIN_POSITIVE);
            format!("their norm has changed by {change:.2e} % of {first:.3}")
        })?;
        // From the first update on; those that came back moved.
        (symptom.since == Some(1)).then_some(symptom)
    }

    fn clipped(&self) -> Option<Symptom> {
        let clipped = self.column("clipped_readings");
        let all = self.facts.readings_per_update;
        if all <= 0.0 {
            return None;
        }
        self.lasting(
            &CLIPPED_READINGS,
            &clipped,
            |it| it > CLIPPED * all,
            |mean| format!("{:.1} % of the readings are beyond their range", 100.0 * mean / all),
        )
    }

    fn fallen(&self) -> Option<Symptom> {
        let steps = self.setting.steps_per_update;
        let contacts = self.column("penalised_contacts");
        self.lasting(
            &FALLEN_ROBOT,
            &contacts,
            |it| it > FALLEN * steps,
            |mean| format!("{:.2} such parts touch the ground in a control step", mean / steps),
        )
    }

    /// In what is recorded, which has no updates.
    fn stuck_contacts(&self) -> Option<Symptom> {
        let contacts = self.facts.contacts.as_ref()?;
        let (n, n_feet) = (contacts.n_steps(), contacts.feet.len());
        let steps = || contacts.touching.chunks_exact(n_feet.max(1));
        let first = steps().next()?;
        let is_stuck = steps().all(|step| step == first);
        let found = || {
            let named = |touches: bool| -> Vec<&str> {
                let feet = contacts.feet.iter().zip(first).filter(|it| *it.1 == touches);
                feet.map(|(name, _)| name.as_str()).collect()
            };
            let [always, never] = [("always", true), ("never", false)].map(|(when, touches)| {
                let feet = named(touches);
                if feet.is_empty() { None } else { Some(format!("{when}: {}", feet.join(", "))) }
            });
            let all: Vec<_> = [always, never].into_iter().flatten().collect();
            format!("in the last {n} control steps touch {}", all.join("; "))
        };
        (is_stuck && n_feet > 0 && n >= FEWEST_STEPS).then(|| Symptom {
            kind: &STUCK_CONTACTS,
            since: None,
            found: found(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{curves::Thinned, example::run_of};
    use runs::Row;

    /// A cell of forty updates with these rows.
    fn of(rows: impl Fn(u64) -> Row, facts: &Facts) -> Vec<Symptom> {
        let mut run = run_of(&[("a", vec![vec![0.0; 40]])]);
        let rows: Vec<_> = (1..=40).map(|update| Row { update, ..rows(update) }).collect();
        run.settings[0].cells[0].columns = Thinned::of(&rows);
        symptoms(&run, &run.settings[0], &run.settings[0].cells[0], facts)
    }

    /// With which nothing is wrong.
    fn well(update: u64) -> Row {
        Row {
            intrinsic_nats: 0.2,
            intrinsic_nats_corrected: 0.18,
            output_entropy_nats: 0.5,
            parameter_norm: 1.0 + 0.1 * update as f64,
            gradient_norm: 2.0,
            gradient_error: 0.5,
            ..Row::default()
        }
    }

    fn facts() -> Facts {
        Facts { n_parameters: 100, readings_per_update: 1000.0, contacts: None }
    }

    fn told(found: &[Symptom]) -> Vec<(&'static str, Option<u64>)> {
        found.iter().map(|it| (it.kind.name, it.since)).collect()
    }

    #[test]
    fn a_healthy_cell_has_none_and_unknown_columns_tell_nothing() {
        assert_eq!(of(well, &facts()), []);
        let old = |update| Row {
            output_entropy_nats: f64::NAN,
            gradient_error: f64::NAN,
            ..well(update)
        };
        assert_eq!(of(old, &Facts::default()), []);
    }

    #[test]
    fn each_symptom_is_told_with_the_update_where_it_began() {
        type Change = fn(&mut Row);
        let changes: [(&Kind, Change); 9] = [
            (&FROZEN_POLICY, |row| row.output_entropy_nats = 0.001),
            (&SILENT, |row| row.intrinsic_nats = 1e-6),
            (&BIAS, |row| row.intrinsic_nats_corrected = 0.01),
            (&LOST_IN_NOISE, |row| row.gradient_error = 2.0),
            (&NO_GRADIENT, |row| row.gradient_norm = 0.0),
            (&RUNNING_AWAY, |row| row.parameter_norm = 1e4),
            (&CLIPPED_READINGS, |row| row.clipped_readings = 20.0),
            (&FALLEN_ROBOT, |row| row.penalised_contacts = 60.0),
            (&IDLE_PARAMETERS, |row| row.parameter_norm = 1.0),
        ];
        for (kind, change) in changes {
            let begun = if *kind == IDLE_PARAMETERS { 1 } else { 31 };
            let from = |first: u64| {
                move |update: u64| {
                    let mut row = well(update);
                    if update >= first {
                        change(&mut row);
                    }
                    row
                }
            };
            let found = of(from(begun), &facts());
            assert!(told(&found).contains(&(kind.name, Some(begun))), "{}: {found:?}", kind.name);
            assert!(!of(from(38), &facts()).iter().any(|it| it.kind == kind), "too short to last");
            // What is over isn't told.
            let over = |update: u64| if update < 35 { from(1)(update) } else { well(update) };
            assert!(!of(over, &facts()).iter().any(|it| it.kind == kind), "{}", kind.name);
        }
    }

    /// A robot that hardly moves, with the paper's window: what is measured is the bias, 0.005 nats.
    #[test]
    fn the_bias_of_almost_no_information_is_no_symptom() {
        let still = |nats: f64, bias: f64| {
            let row = move |update| Row {
                intrinsic_nats: nats,
                intrinsic_nats_corrected: nats - bias,
                ..well(update)
            };
            told(&of(row, &facts()))
        };
        for nats in [0.002, 0.005, 0.015] {
            assert_eq!(still(nats, 0.005), [], "{nats}");
        }
        assert_eq!(still(0.1, 0.045), [(BIAS.name, Some(1))], "four bins");
        assert_eq!(still(0.4, 0.25), [(BIAS.name, Some(1))], "a window of two readings");
    }

    #[test]
    fn feet_that_never_change_are_named() {
        let contacts = |touching: Vec<bool>| {
            let feet = ["left", "right"].map(str::to_owned).into();
            Facts { contacts: Some(Contacts { feet, seconds_per_step: 0.1, touching }), ..facts() }
        };
        let stuck = of(well, &contacts([true, false].repeat(50)));
        assert_eq!(told(&stuck), [(STUCK_CONTACTS.name, None)]);
        assert_eq!(stuck[0].found, "in the last 50 control steps touch always: left; never: right");
        let mut moving = [true, false].repeat(50);
        moving[41] = true;
        assert_eq!(of(well, &contacts(moving)), []);
        assert_eq!(of(well, &contacts([true, false].repeat(5))), [], "too few to tell");
    }

    #[test]
    fn a_cell_behind_others_of_its_run_is_told() {
        let run = run_of(&[("a", vec![vec![0.0; 40], vec![0.0; 12]])]);
        let found = |i: usize| {
            let setting = &run.settings[0];
            told(&symptoms(&run, setting, &setting.cells[i], &Facts::default()))
        };
        assert!(found(1).contains(&(BEHIND.name, Some(12))));
        assert!(found(0).iter().all(|it| it.0 != BEHIND.name));
    }

    #[test]
    fn the_document_has_every_symptom_and_what_to_try() {
        let document = include_str!("../../../docs/health.md");
        for kind in KINDS {
            let line = document.lines().find(|it| it.starts_with(&format!("| {} |", kind.name)));
            assert!(line.is_some_and(|it| it.contains(kind.advice)), "{kind:?}");
        }
    }
}

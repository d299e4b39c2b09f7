//! A row of `metrics.csv`, and the columns that a file may have.
//!
//! To add a column: a field at the end of [`Row`], with the default that says that it's absent, a line
//! in [`Row::mean`], and a line at the end of [`COLUMNS`]. Files that were begun before it go on without
//! it.

use std::io;

use serde::{Deserialize, Serialize, Serializer};

/// One update, or the mean of several. Unless it says otherwise, a value is the mean over the update's
/// control steps.
///
/// The fields' order is that of [`COLUMNS`]. A value of a column that the file doesn't have is NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Number of the update, from 1; of several, that of the last one.
    pub update: u64,
    /// Control steps done by its end.
    pub control_steps: u64,
    /// R: the reward that is optimised, with everything in it.
    #[serde(rename = "R")]
    pub reward: f64,
    /// The information as it is, in nats: R_MI by mutual information, or what the intrinsic kind measures.
    #[serde(rename = "R_MI_nats")]
    pub intrinsic_nats: f64,
    /// The information with the Miller-Madow correction of its bias, in nats.
    #[serde(rename = "R_MI_miller_madow_nats")]
    pub intrinsic_nats_corrected: f64,
    /// The information as scaled for the mix.
    #[serde(rename = "R_MI")]
    pub intrinsic: f64,
    /// R_Loc, metres along the heading for each control step, whatever the task.
    #[serde(rename = "R_Loc")]
    pub advance_m: f64,
    /// The extrinsic reward as scaled for the mix.
    pub extrinsic: f64,
    /// What was subtracted for touching parts.
    pub penalty: f64,
    /// The share of the extrinsic reward in the mix, 0 to 1.
    pub xi: f64,
    /// Metres in the XY plane from where the update began to where it ended.
    pub net_displacement_m: f64,
    /// How far the heading turned over the update, rad, counter-clockwise.
    pub heading_change_rad: f64,
    /// How often a part that shouldn't touched the ground: control steps times parts, a sum over the
    /// update.
    #[serde(serialize_with = "count")]
    pub penalised_contacts: f64,
    /// How many readings lay outside of their range, a sum over the update.
    #[serde(serialize_with = "count")]
    pub clipped_readings: f64,
    /// Euclidean norm of the parameters after the update.
    pub parameter_norm: f64,
    /// Euclidean norm of the gradient that the update followed.
    pub gradient_norm: f64,
    /// The extrinsic reward as it is: the task's own value, in the unit of its kind.
    #[serde(default = "absent")]
    pub task: f64,
    /// How uncertain the policy's outputs were given the inputs: nats for each bit, 0 to log 2.
    #[serde(default = "absent")]
    pub output_entropy_nats: f64,
    /// Standard error of the gradient that the update followed, as its norm is; NaN where it isn't known.
    #[serde(default = "absent")]
    pub gradient_error: f64,
}

fn absent() -> f64 {
    f64::NAN
}

/// A whole number has no decimals; the mean of some need not be whole.
fn count<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    let whole = *value as u64;
    match whole as f64 == *value {
        true => serializer.serialize_u64(whole),
        false => serializer.serialize_f64(*value),
    }
}

/// To seven significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

impl Row {
    /// The mean of some updates that follow each other, at least one, numbered as the last of them.
    /// That of several has seven significant digits: more is noise, and twice as long in a file.
    #[must_use]
    pub fn mean(rows: &[Self]) -> Self {
        let mean = |value: fn(&Self) -> f64| {
            let mean = rows.iter().map(value).sum::<f64>() / rows.len() as f64;
            if rows.len() == 1 { mean } else { rounded(mean) }
        };
        let last = rows.last().copied().unwrap_or_default();
        Self {
            update: last.update,
            control_steps: last.control_steps,
            reward: mean(|row| row.reward),
            intrinsic_nats: mean(|row| row.intrinsic_nats),
            intrinsic_nats_corrected: mean(|row| row.intrinsic_nats_corrected),
            intrinsic: mean(|row| row.intrinsic),
            advance_m: mean(|row| row.advance_m),
            extrinsic: mean(|row| row.extrinsic),
            penalty: mean(|row| row.penalty),
            xi: mean(|row| row.xi),
            net_displacement_m: mean(|row| row.net_displacement_m),
            heading_change_rad: mean(|row| row.heading_change_rad),
            penalised_contacts: mean(|row| row.penalised_contacts),
            clipped_readings: mean(|row| row.clipped_readings),
            parameter_norm: mean(|row| row.parameter_norm),
            gradient_norm: mean(|row| row.gradient_norm),
            task: mean(|row| row.task),
            output_entropy_nats: mean(|row| row.output_entropy_nats),
            gradient_error: mean(|row| row.gradient_error),
        }
    }
}

/// A column of `metrics.csv`.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// As the file's first line calls it.
    pub name: &'static str,
    /// What it is, in a few words.
    pub label: &'static str,
    /// The unit of its values; empty for numbers without one, and for the task's own value, whose
    /// kind knows it.
    pub unit: &'static str,
    /// Its value in a row.
    pub value: fn(&Row) -> f64,
}

const fn column(
    name: &'static str,
    label: &'static str,
    unit: &'static str,
    value: fn(&Row) -> f64,
) -> Column {
    Column { name, label, unit, value }
}

/// All columns, in their order.
#[rustfmt::skip]
pub const COLUMNS: [Column; 19] = [
    column("update", "update", "", |row| row.update as f64),
    column("control_steps", "control steps", "", |row| row.control_steps as f64),
    column("R", "reward", "reward", |row| row.reward),
    column("R_MI_nats", "information", "nats", |row| row.intrinsic_nats),
    column("R_MI_miller_madow_nats", "information, corrected", "nats", |row| row.intrinsic_nats_corrected),
    column("R_MI", "information in the mix", "reward", |row| row.intrinsic),
    column("R_Loc", "way along the heading", "m per control step", |row| row.advance_m),
    column("extrinsic", "task in the mix", "reward", |row| row.extrinsic),
    column("penalty", "penalty", "reward", |row| row.penalty),
    column("xi", "the task's share \u{3be}", "0 to 1", |row| row.xi),
    column("net_displacement_m", "net displacement", "m per update", |row| row.net_displacement_m),
    column("heading_change_rad", "turn of the heading", "rad per update", |row| row.heading_change_rad),
    column("penalised_contacts", "penalised contacts", "count per update", |row| row.penalised_contacts),
    column("clipped_readings", "readings out of range", "count per update", |row| row.clipped_readings),
    column("parameter_norm", "norm of the parameters", "", |row| row.parameter_norm),
    column("gradient_norm", "norm of the gradient", "", |row| row.gradient_norm),
    column("task", "the task's own value", "", |row| row.task),
    column("output_entropy_nats", "entropy of the outputs", "nats per bit", |row| row.output_entropy_nats),
    column("gradient_error", "standard error of the gradient", "", |row| row.gradient_error),
];

/// Those of the first version, which every file has.
const N_FIRST: usize = 16;

/// The first line of a file with all columns, with its line break.
#[must_use]
pub fn header_line() -> String {
    Columns::all().header_line()
}

/// The columns of a file: the first ones, and those of the later ones that there were when it was
/// begun.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Columns(Vec<&'static str>);

impl Columns {
    /// Those of a new file.
    pub(crate) fn all() -> Self {
        Self(COLUMNS.iter().map(|column| column.name).collect())
    }

    /// Those that a first line names, without its line break; none if it's no such line.
    pub(crate) fn of(line: &[u8]) -> Option<Self> {
        let named: Vec<_> = str::from_utf8(line).ok()?.split(',').collect();
        let Self(all) = Self::all();
        let is_old = |name| all[..N_FIRST].contains(&name);
        let expected: Vec<_> =
            all.iter().copied().filter(|name| is_old(*name) || named.contains(name)).collect();
        (named == expected).then_some(Self(expected))
    }

    /// Names that every file has, and those that only later ones have.
    pub(crate) fn required_and_later() -> [Vec<&'static str>; 2] {
        let Self(mut first) = Self::all();
        let later = first.split_off(N_FIRST);
        [first, later]
    }

    /// Their names, in the file's order.
    pub(crate) fn names(&self) -> &[&'static str] {
        &self.0
    }

    /// Whether none is missing in between: a column's place is then that of its field.
    pub(crate) fn are_the_first(&self) -> bool {
        self.0.iter().zip(&COLUMNS).all(|(name, column)| *name == column.name)
    }

    /// The file's first line, with its line break.
    pub(crate) fn header_line(&self) -> String {
        self.0.join(",") + "\n"
    }

    /// A row's line, with its line break.
    pub(crate) fn line(&self, row: &Row) -> io::Result<String> {
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        writer.serialize(row)?;
        let line = writer.into_inner().map_err(csv::IntoInnerError::into_error)?;
        let line = String::from_utf8(line).map_err(io::Error::other)?;
        // Numbers have no comma in them.
        let values = line.trim_end().split(',').zip(&COLUMNS);
        let kept = values.filter(|(_, column)| self.0.contains(&column.name));
        Ok(kept.map(|(value, _)| value).collect::<Vec<_>>().join(",") + "\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_are_the_fields() {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.serialize(Row::default()).unwrap();
        let text = String::from_utf8(writer.into_inner().unwrap()).unwrap();
        assert_eq!(text.lines().next().unwrap(), header_line().trim_end());
    }

    /// Each column's value is its field: fields are told apart by their place in a line.
    #[test]
    fn the_columns_have_the_values_of_the_fields() {
        let line = (1..=COLUMNS.len()).map(|i| i.to_string()).collect::<Vec<_>>().join(",");
        let text = header_line() + &line;
        let row: Row =
            csv::Reader::from_reader(text.as_bytes()).deserialize().next().unwrap().unwrap();
        let values: Vec<_> = COLUMNS.iter().map(|column| (column.value)(&row) as usize).collect();
        assert_eq!(values, (1..=COLUMNS.len()).collect::<Vec<_>>());
    }

    /// Every column of the mean is the mean of the columns; what counts is that of the last row.
    #[test]
    fn a_mean_is_numbered_as_its_last_row() {
        let row = |from: usize| -> Row {
            let line = (0..COLUMNS.len()).map(|i| (from + 3 * i).to_string());
            let text = header_line() + &line.collect::<Vec<_>>().join(",");
            csv::Reader::from_reader(text.as_bytes()).deserialize().next().unwrap().unwrap()
        };
        let mean = Row::mean(&[row(1), row(2)]);
        for (i, column) in COLUMNS.iter().enumerate() {
            let expected = 3.0 * i as f64 + if i < 2 { 2.0 } else { 1.5 };
            assert_eq!((column.value)(&mean), expected, "{}", column.name);
        }
        assert_eq!(Row::mean(&[row(7)]), row(7));
        let thirds = [0.0, 0.0, 1.0].map(|task| Row { task, ..row(0) });
        assert_eq!((Row::mean(&thirds).task, Row::mean(&thirds[..1]).task), (0.333_333_3, 0.0));
        // Counts that are whole are written as before there were others.
        let line =
            Columns::all().line(&Row { penalised_contacts: 2.0, clipped_readings: 0.5, ..row(0) });
        assert!(line.unwrap().contains(",2,0.5,"));
    }

    #[test]
    fn a_first_line_has_all_first_columns_and_any_of_the_later() {
        let names: Vec<_> = COLUMNS.iter().map(|column| column.name).collect();
        for later in 0..1 << (names.len() - N_FIRST) {
            let is_there = |i: usize| i < N_FIRST || later >> (i - N_FIRST) & 1 == 1;
            let there: Vec<_> =
                (0..names.len()).filter(|&i| is_there(i)).map(|i| names[i]).collect();
            let columns = Columns::of(there.join(",").as_bytes()).unwrap();
            assert_eq!(columns.names(), there);
            assert_eq!(columns.are_the_first(), names.starts_with(&there));
            let row = Row { update: 3, gradient_norm: 0.5, task: 0.25, ..Row::default() };
            let line = columns.line(&row).unwrap();
            assert_eq!(line.trim_end().split(',').count(), there.len());
            assert!(line.starts_with("3,0,0.0,"));
        }
        let of = |names: &[&str]| Columns::of(names.join(",").as_bytes());
        let mut swapped = names.clone();
        swapped.swap(3, 4);
        let refused: [&[&str]; 6] = [
            &[],
            &names[1..],
            &names[..N_FIRST - 1],
            &swapped,
            &[&names[..], &["task"]].concat(),
            &[&names[..N_FIRST], &["entropy?"]].concat(),
        ];
        for names in refused {
            assert_eq!(of(names), None, "{names:?}");
        }
        assert_eq!(Columns::of(&[0xff]), None);
    }
}

//! The numbers beside the figures, as tables.
//!
//! | table | a row |
//! |---|---|
//! | `instances` | an instance: windows, progress, collapse |
//! | `settings` | a setting: the paper's findings as numbers, IQM with its interval |
//! | `improvement` | two settings: how probably the first is better |
//! | `correlation` | a setting, and all: Pearson's r of R_Loc and R_MI |

use super::{
    Instance, Results, Setting,
    statistics::{
        Interval, bootstrap, interquartile_mean, mean, pearson, probability_of_improvement,
        quantile, sorted,
    },
};

/// Replicates of the bootstraps, as many as rliable makes.
const IQM_REPLICATES: usize = 50_000;
const IMPROVEMENT_REPLICATES: usize = 2_000;

/// A table; all rows are as long as the header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// The name of its file, without `.csv`.
    pub name: &'static str,
    /// Names of the columns, with units.
    pub header: Vec<&'static str>,
    /// As in the file. A number has as few digits as give the same f64 again; what can't be told is
    /// empty.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// The bytes of a CSV file.
    #[must_use]
    pub fn csv(&self) -> Vec<u8> {
        let field = |text: &str| match text.contains(['"', ',', '\n', '\r']) {
            true => format!("\"{}\"", text.replace('"', "\"\"")),
            false => text.to_owned(),
        };
        let line = |fields: &mut dyn Iterator<Item = &str>| {
            fields.map(field).collect::<Vec<_>>().join(",") + "\n"
        };
        let header = line(&mut self.header.iter().copied());
        let rows = self.rows.iter().map(|row| line(&mut row.iter().map(String::as_str)));
        [header].into_iter().chain(rows).collect::<String>().into_bytes()
    }
}

fn number(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}

fn told(value: Option<bool>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

pub(super) fn instances(run: &Results) -> Table {
    let header = vec![
        "setting",
        "seed",
        "updates",
        "R_Loc_first_window_m",
        "R_Loc_best_window_m",
        "R_Loc_last_window_m",
        "significant_progress",
        "collapsed",
    ];
    let row = |setting: &Setting, instance: &Instance| {
        let outcome = &instance.outcome;
        vec![
            setting.name.clone(),
            instance.seed.to_string(),
            instance.updates().to_string(),
            number(outcome.first),
            number(outcome.best),
            number(outcome.last),
            told(outcome.progressed),
            told(outcome.collapsed),
        ]
    };
    let rows = run
        .settings
        .iter()
        .flat_map(|setting| setting.instances.iter().map(move |instance| row(setting, instance)));
    Table { name: "instances", header, rows: rows.collect() }
}

pub(super) fn settings(run: &Results) -> Table {
    let header = vec![
        "setting",
        "instances",
        "instances_behind",
        "window_updates",
        "R_Loc_maximum_m",
        "R_Loc_mean_m",
        "R_Loc_median_m",
        "R_Loc_IQM_m",
        "R_Loc_IQM_low_m",
        "R_Loc_IQM_high_m",
        "share_without_significant_progress",
        "share_collapsed",
    ];
    let row = |setting: &Setting| {
        let values = sorted(&setting.last());
        let (iqm, interval) = iqm(setting);
        let behind = setting.instances.iter().filter(|it| it.outcome.is_behind).count();
        vec![
            setting.name.clone(),
            values.len().to_string(),
            behind.to_string(),
            run.window.to_string(),
            number(quantile(&values, 1.0)),
            number(mean(&values)),
            number(quantile(&values, 0.5)),
            number(iqm),
            number(interval.low),
            number(interval.high),
            number(share(setting, |it| it.outcome.progressed.map(|it| !it))),
            number(share(setting, |it| it.outcome.collapsed)),
        ]
    };
    Table { name: "settings", header, rows: run.settings.iter().map(row).collect() }
}

/// Of the instances of which it can be told; NaN if there's none.
pub(super) fn share(setting: &Setting, of: fn(&Instance) -> Option<bool>) -> f64 {
    let told: Vec<_> = setting.instances.iter().filter_map(of).collect();
    told.iter().filter(|&&it| it).count() as f64 / told.len() as f64
}

/// The interquartile mean of the last window's R_Loc over a setting's instances.
pub(super) fn iqm(setting: &Setting) -> (f64, Interval) {
    let values = setting.last();
    let interval = bootstrap(&[&values], IQM_REPLICATES, |drawn| interquartile_mean(&drawn[0]));
    (interquartile_mean(&values), interval)
}

/// The probability that an instance of setting `i` has a higher last window than one of setting `j`.
pub(super) fn improvement_of(settings: &[Setting], i: usize, j: usize) -> (f64, Interval) {
    if i > j {
        // So that the two directions agree: other random numbers would give another interval.
        let (probability, Interval { low, high }) = improvement_of(settings, j, i);
        return (1.0 - probability, Interval { low: 1.0 - high, high: 1.0 - low });
    }
    let [x, y] = [i, j].map(|it| settings[it].last());
    let interval = bootstrap(&[&x, &y], IMPROVEMENT_REPLICATES, |drawn| {
        probability_of_improvement(&drawn[0], &drawn[1])
    });
    (probability_of_improvement(&x, &y), interval)
}

pub(super) fn improvement(run: &Results) -> Table {
    let header = vec!["setting", "over", "probability", "low", "high"];
    let settings = &run.settings;
    let pairs = (0..settings.len())
        .flat_map(|i| (0..settings.len()).map(move |j| (i, j)))
        .filter(|(i, j)| i != j);
    let row = |(i, j): (usize, usize)| {
        let (probability, interval) = improvement_of(settings, i, j);
        let names = [&settings[i], &settings[j]].map(|it| it.name.clone());
        let numbers = [probability, interval.low, interval.high].map(number);
        names.into_iter().chain(numbers).collect()
    };
    Table { name: "improvement", header, rows: pairs.map(row).collect() }
}

/// Pearson's r of R_Loc and R_MI over all updates of some settings' instances.
pub(super) fn correlation_of(settings: &[Setting]) -> Option<f64> {
    let instances = settings.iter().flat_map(|setting| &setting.instances);
    pearson(instances.flat_map(|instance| {
        instance.locomotion_m.iter().copied().zip(instance.information_nats.iter().copied())
    }))
}

pub(super) fn correlation(run: &Results) -> Table {
    let header = vec!["setting", "updates", "pearson_R_Loc_R_MI"];
    let row = |name: &str, settings: &[Setting]| {
        let instances = settings.iter().flat_map(|setting| &setting.instances);
        let updates: usize = instances.map(Instance::updates).sum();
        vec![
            name.to_owned(),
            updates.to_string(),
            correlation_of(settings).map_or(String::new(), number),
        ]
    };
    let each = run.settings.iter().map(|it| row(&it.name, std::slice::from_ref(it)));
    let rows = each.chain([row("all", &run.settings)]).collect();
    Table { name: "correlation", header, rows }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::run_of;

    /// Twenty updates: a first window of 2 at `first`, the rest at `last`.
    fn curve(first: f64, last: f64) -> Vec<f64> {
        [vec![first; 2], vec![last; 18]].concat()
    }

    fn column<'a>(table: &'a Table, name: &str) -> Vec<&'a str> {
        let index = table.header.iter().position(|column| *column == name).unwrap();
        table.rows.iter().map(|row| row[index].as_str()).collect()
    }

    /// Last windows 1, 2, 3 and 10 of one setting, 2 of the other.
    fn run() -> Results {
        let some = [1.0, 2.0, 3.0, 10.0].map(|last| curve(0.0, last));
        run_of(&[("a", some.into()), ("b,c=\"d\"", vec![curve(0.0, 2.0)])])
    }

    #[test]
    fn settings_have_the_papers_findings_as_numbers() {
        let table = settings(&run());
        assert_eq!(column(&table, "R_Loc_maximum_m"), ["10.0", "2.0"]);
        assert_eq!(column(&table, "R_Loc_mean_m"), ["4.0", "2.0"]);
        assert_eq!(column(&table, "R_Loc_median_m"), ["2.5", "2.0"]);
        // Without the 1 and the 10.
        assert_eq!(column(&table, "R_Loc_IQM_m"), ["2.5", "2.0"]);
        assert_eq!(column(&table, "R_Loc_IQM_low_m")[1], "2.0");
        assert_eq!(column(&table, "window_updates"), ["2", "2"]);
        // The largest gain is 10, so that a gain of 1 just counts.
        assert_eq!(column(&table, "share_without_significant_progress"), ["0.0", "0.0"]);
        assert_eq!(column(&table, "share_collapsed"), ["0.0", "0.0"]);
    }

    #[test]
    fn improvement_is_of_one_setting_over_another() {
        let table = improvement(&run());
        assert_eq!(column(&table, "setting"), ["a", "b,c=\"d\""]);
        // Of 1, 2, 3 and 10 two are larger than 2 and one is as large.
        assert_eq!(column(&table, "probability"), ["0.625", "0.375"]);
        let ends = ["low", "high"].map(|name| column(&table, name));
        let end = |i: usize, j: usize| ends[i][j].parse::<f64>().unwrap();
        assert_eq!([end(0, 1), end(1, 1)], [1.0 - end(1, 0), 1.0 - end(0, 0)]);
    }

    /// R_MI is half of R_Loc in these runs.
    #[test]
    fn correlation_is_over_all_updates() {
        let table = correlation(&run());
        assert_eq!(column(&table, "setting"), ["a", "b,c=\"d\"", "all"]);
        assert_eq!(column(&table, "updates"), ["80", "20", "100"]);
        let r: Vec<f64> =
            column(&table, "pearson_R_Loc_R_MI").iter().map(|it| it.parse().unwrap()).collect();
        assert!(r.iter().all(|r| (r - 1.0).abs() < 1e-12), "{r:?}");
        let constant = correlation(&run_of(&[("a", vec![vec![1.0; 5]])]));
        assert_eq!(column(&constant, "pearson_R_Loc_R_MI"), ["", ""]);
    }

    #[test]
    fn what_cannot_be_told_is_empty_and_csv_is_quoted() {
        let mut short = run();
        short.settings.push(run_of(&[("e", vec![vec![1.0]])]).settings.remove(0));
        let csv = String::from_utf8(instances(&short).csv()).unwrap();
        let lines: Vec<_> = csv.lines().collect();
        assert_eq!(lines[1], "a,1,20,0.0,1.0,1.0,true,false");
        assert_eq!(lines[5], "\"b,c=\"\"d\"\"\",1,20,0.0,2.0,2.0,true,false");
        assert_eq!(lines[6], "e,1,1,1.0,1.0,1.0,,");
    }
}

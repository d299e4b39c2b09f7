//! The numbers beside the figures, as tables.
//!
//! Those of curves are beside their figures.
//!
//! | table | a row |
//! |---|---|
//! | `instances` | a cell: windows, progress, collapse |
//! | `settings` | a setting: the paper's findings as numbers, IQM with its interval |
//! | `improvement` | two settings: how probably the first is better |
//! | `correlation` | a setting, and all: Pearson's r of what the run is judged by and the information |

use runs::Moments;

use super::{
    CellResults, Measure, Results, Setting,
    numbers::three_digits,
    statistics::{
        FEWEST_FOR_INTERVAL, Interval, bootstrap, interquartile_mean, mean, pearson,
        probability_of_improvement, quantile, sorted, together,
    },
};

/// Replicates of the bootstraps, as many as rliable makes.
const IQM_REPLICATES: usize = 50_000;
const IMPROVEMENT_REPLICATES: usize = 2_000;
/// Of each point of a curve.
pub(super) const CURVE_REPLICATES: usize = 2_000;

/// A table; all rows are as long as the header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// The name of its file, without `.csv`.
    pub name: &'static str,
    /// Names of the columns, with units.
    pub header: Vec<String>,
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
        let header = line(&mut self.header.iter().map(String::as_str));
        let rows = self.rows.iter().map(|row| line(&mut row.iter().map(String::as_str)));
        [header].into_iter().chain(rows).collect::<String>().into_bytes()
    }
}

pub(super) fn number(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}

/// A statistic of some cells, with its interval if they are enough for one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The statistic of the cells.
    pub value: f64,
    /// Its 95 % interval; none of fewer than 6 cells.
    pub interval: Option<Interval>,
}

/// Whether all strata have so many values that an interval can be told.
pub(super) fn enough_for_interval(strata: &[&[f64]]) -> bool {
    strata.iter().all(|stratum| stratum.len() >= FEWEST_FOR_INTERVAL)
}

impl std::fmt::Display for Estimate {
    /// With three digits: `0.0812 [0.0743, 0.0880]`.
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(&three_digits(self.value))?;
        match self.interval.map(|it| [it.low, it.high].map(three_digits)) {
            Some([low, high]) => write!(formatter, " [{low}, {high}]"),
            None => Ok(()),
        }
    }
}

impl Estimate {
    /// Of some strata of cells.
    pub(super) fn of<const N: usize>(
        strata: [&[f64]; N],
        n_replicates: usize,
        statistic: impl Fn([&[f64]; N]) -> f64,
    ) -> Self {
        let interval = enough_for_interval(&strata).then(|| {
            bootstrap(&strata, n_replicates, |drawn| {
                statistic(std::array::from_fn(|i| drawn[i].as_slice()))
            })
        });
        Self { value: statistic(strata), interval }
    }

    /// Of what is left to 1.
    fn complement(self) -> Self {
        let interval = self
            .interval
            .map(|Interval { low, high }| Interval { low: 1.0 - high, high: 1.0 - low });
        Self { value: 1.0 - self.value, interval }
    }

    /// Value, lower end, upper end.
    pub(super) fn fields(this: Option<Self>) -> [String; 3] {
        let end = |of: fn(Interval) -> f64| {
            this.and_then(|it| it.interval).map_or(String::new(), |it| number(of(it)))
        };
        let value = this.map_or(String::new(), |it| number(it.value));
        [value, end(|it| it.low), end(|it| it.high)]
    }
}

/// What can't be told of settings with few cells, or of several tasks, in sentences.
pub fn caveats(run: &Results) -> Vec<String> {
    let any = |few: fn(usize) -> bool| run.settings.iter().any(|it| few(it.cells.len()));
    let one = "One cell of a setting gives neither an interval nor a probability.";
    let few = format!(
        "Fewer than {FEWEST_FOR_INTERVAL} cells give no 95 % interval: with a probability of \
         2^(1-n), more than 5 %, all n lie on one side of the median."
    );
    let one = any(|n| n == 1).then(|| one.to_owned());
    let few = any(|n| (2..FEWEST_FOR_INTERVAL).contains(&n)).then_some(few);
    run.with_caveats(one.into_iter().chain(few).collect())
}

fn told(value: Option<bool>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

pub(super) fn cells(run: &Results) -> Table {
    let of = |what| run.measure.column(what);
    let header = vec![
        "setting".into(),
        "seed".into(),
        "updates".into(),
        of("first_window"),
        of("best_window"),
        of("last_window"),
        "significant_progress".into(),
        "collapsed".into(),
    ];
    let row = |setting: &Setting, cell: &CellResults| {
        let outcome = &cell.outcome;
        vec![
            setting.name.clone(),
            cell.seed.to_string(),
            cell.updates().to_string(),
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
        .flat_map(|setting| setting.cells.iter().map(move |cell| row(setting, cell)));
    Table { name: "instances", header, rows: rows.collect() }
}

pub(super) fn settings(run: &Results) -> Table {
    let of = |what| run.measure.column(what);
    let header = vec![
        "setting".into(),
        "instances".into(),
        "instances_behind".into(),
        "window_updates".into(),
        of("maximum"),
        of("mean"),
        of("median"),
        of("IQM"),
        of("IQM_low"),
        of("IQM_high"),
        "share_without_significant_progress".into(),
        "share_collapsed".into(),
    ];
    let row = |setting: &Setting| {
        let values = sorted(&setting.last());
        let [iqm, low, high] = Estimate::fields(Some(iqm(&setting.last())));
        let behind = setting.cells.iter().filter(|it| it.outcome.is_behind).count();
        vec![
            setting.name.clone(),
            values.len().to_string(),
            behind.to_string(),
            setting.window.to_string(),
            number(quantile(&values, 1.0)),
            number(mean(&values)),
            number(quantile(&values, 0.5)),
            iqm,
            low,
            high,
            number(share(setting, |it| it.outcome.progressed.map(|it| !it))),
            number(share(setting, |it| it.outcome.collapsed)),
        ]
    };
    Table { name: "settings", header, rows: run.settings.iter().map(row).collect() }
}

/// Of the cells of which it can be told; NaN if there's none.
pub(super) fn share(setting: &Setting, of: fn(&CellResults) -> Option<bool>) -> f64 {
    let told: Vec<_> = setting.cells.iter().filter_map(of).collect();
    told.iter().filter(|&&it| it).count() as f64 / told.len() as f64
}

/// The interquartile mean of some cells' values.
#[must_use]
pub fn iqm(values: &[f64]) -> Estimate {
    Estimate::of([values], IQM_REPLICATES, |[values]| interquartile_mean(values))
}

/// The probability that a value of one side is higher than one of the other; none if either has one
/// value only.
#[must_use]
pub fn improvement(x: &[f64], y: &[f64]) -> Option<Estimate> {
    (x.len() > 1 && y.len() > 1).then(|| {
        Estimate::of([x, y], IMPROVEMENT_REPLICATES, |[x, y]| probability_of_improvement(x, y))
    })
}

/// The probability that a cell of setting `i` has a higher last window than one of setting `j`;
/// none if either has one cell only.
pub(super) fn improvement_of(settings: &[Setting], i: usize, j: usize) -> Option<Estimate> {
    if i > j {
        // So that the two directions agree: other random numbers would give another interval.
        return improvement_of(settings, j, i).map(Estimate::complement);
    }
    improvement(&settings[i].last(), &settings[j].last())
}

pub(super) fn improvements(run: &Results) -> Table {
    let header = ["setting", "over", "probability", "low", "high"].map(str::to_owned).into();
    let settings = &run.settings;
    let pairs = (0..settings.len())
        .flat_map(|i| (0..settings.len()).map(move |j| (i, j)))
        .filter(|(i, j)| i != j);
    let row = |(i, j): (usize, usize)| {
        let names = [&settings[i], &settings[j]].map(|it| it.name.clone());
        names.into_iter().chain(Estimate::fields(improvement_of(settings, i, j))).collect()
    };
    Table { name: "improvement", header, rows: pairs.map(row).collect() }
}

/// Pearson's r of what the run is judged by and the information, over all updates of some settings' cells.
pub(super) fn correlation_of(settings: &[Setting]) -> Option<f64> {
    pearson(moments_of(settings))
}

/// Over all updates of some settings' cells.
fn moments_of(settings: &[Setting]) -> Moments {
    let cells = settings.iter().flat_map(|setting| &setting.cells);
    cells.map(|cell| cell.moments).fold(Moments::default(), together)
}

/// None of a run that measures no information.
pub(super) fn correlation(run: &Results) -> Option<Table> {
    let Measure { symbol, information, .. } = &run.measure;
    let r = format!("pearson_{symbol}_{}", information.as_ref()?.symbol);
    let header = vec!["setting".into(), "updates".into(), r];
    let row = |name: &str, settings: &[Setting]| {
        let moments = moments_of(settings);
        let r = pearson(moments).map_or(String::new(), number);
        vec![name.to_owned(), moments.n.to_string(), r]
    };
    let each = run.settings.iter().map(|it| row(&it.name, std::slice::from_ref(it)));
    let rows = each.chain([row("all", &run.settings)]).collect();
    Some(Table { name: "correlation", header, rows })
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
        assert_eq!(column(&table, "R_Loc_IQM_low_m"), ["", ""], "too few for an interval");
        assert_eq!(column(&table, "window_updates"), ["2", "2"]);
        // The largest gain is 10, so that a gain of 1 just counts.
        assert_eq!(column(&table, "share_without_significant_progress"), ["0.0", "0.0"]);
        assert_eq!(column(&table, "share_collapsed"), ["0.0", "0.0"]);
    }

    /// Settings with last windows of 0 to n - 1.
    fn counting(settings: &[(&str, usize)]) -> Results {
        let curves = |n: usize| (0..n).map(|last| curve(0.0, last as f64)).collect();
        run_of(&settings.iter().map(|&(name, n)| (name, curves(n))).collect::<Vec<_>>())
    }

    #[test]
    fn improvement_is_of_one_setting_over_another() {
        let table = improvements(&counting(&[("a", 6), ("b", 8)]));
        assert_eq!(column(&table, "setting"), ["a", "b"]);
        // Of the pairs of 0 to 5 with 0 to 7, 6 are equal, and in 15 the first is larger.
        assert_eq!(column(&table, "probability"), ["0.375", "0.625"]);
        let ends = ["low", "high"].map(|name| column(&table, name));
        let end = |i: usize, j: usize| ends[i][j].parse::<f64>().unwrap();
        assert_eq!([end(0, 1), end(1, 1)], [1.0 - end(1, 0), 1.0 - end(0, 0)]);
        assert!(end(0, 0) < 0.375 && 0.375 < end(1, 0));
    }

    /// A single cell would give a probability of 0, 1/2 or 1 with an interval of no width, and
    /// two an interval of all that they span.
    #[test]
    fn few_cells_tell_little() {
        for n in 1..=7 {
            let run = counting(&[("a", n), ("b", 9)]);
            let (settings, improvement) = (settings(&run), improvements(&run));
            let is_told = |table: &Table, name: &str| !column(table, name)[0].is_empty();
            assert!(is_told(&settings, "R_Loc_IQM_m"));
            assert_eq!(is_told(&improvement, "probability"), n > 1, "{n}");
            for name in ["R_Loc_IQM_low_m", "R_Loc_IQM_high_m"] {
                assert_eq!(is_told(&settings, name), n > 5, "{name} of {n}");
            }
            assert!(!column(&settings, "R_Loc_IQM_low_m")[1].is_empty());
            for name in ["low", "high"] {
                let told = column(&improvement, name).iter().all(|it| !it.is_empty());
                assert_eq!(told, n > 5, "{name} of {n}");
            }
            let said = caveats(&run).concat();
            assert_eq!(said.contains("One cell"), n == 1, "{said}");
            assert_eq!(said.contains("Fewer than 6"), (2..6).contains(&n), "{said}");
        }
    }

    /// R_MI is half of R_Loc in these runs.
    #[test]
    fn correlation_is_over_all_updates() {
        let table = correlation(&run()).unwrap();
        assert_eq!(column(&table, "setting"), ["a", "b,c=\"d\"", "all"]);
        assert_eq!(column(&table, "updates"), ["80", "20", "100"]);
        let r: Vec<f64> =
            column(&table, "pearson_R_Loc_R_MI").iter().map(|it| it.parse().unwrap()).collect();
        assert!(r.iter().all(|r| (r - 1.0).abs() < 1e-12), "{r:?}");
        let constant = correlation(&run_of(&[("a", vec![vec![1.0; 5]])])).unwrap();
        assert_eq!(column(&constant, "pearson_R_Loc_R_MI"), ["", ""]);
    }

    #[test]
    fn what_cannot_be_told_is_empty_and_csv_is_quoted() {
        let mut short = run();
        short.settings.push(run_of(&[("e", vec![vec![1.0]])]).settings.remove(0));
        let csv = String::from_utf8(cells(&short).csv()).unwrap();
        let lines: Vec<_> = csv.lines().collect();
        assert_eq!(lines[1], "a,1,20,0.0,1.0,1.0,true,false");
        assert_eq!(lines[5], "\"b,c=\"\"d\"\"\",1,20,0.0,2.0,2.0,true,false");
        assert_eq!(lines[6], "e,1,1,1.0,1.0,1.0,,");
    }
}

//! What a survey came to, as files: tables, and figures of the same numbers.

use ::landscape::Estimate;
use figures::{Drawing, LandscapeMap, LandscapeProfile, Table, statistics::Interval};

use super::{Functions, Measured, Row, Summary, Survey, align, measure, predict, summarise};

/// What a survey came to.
#[derive(Clone, Debug)]
pub struct Findings {
    /// The functions' names, the task first.
    pub names: Vec<String>,
    /// The slices, measured; none where a robot blew up.
    pub slices: Vec<Option<Measured>>,
    /// The measures of all slices, and of gradients.
    pub rows: Vec<Row>,
    /// Means over cells.
    pub summary: Vec<Summary>,
    /// What had to be left out, and why.
    pub omitted: Vec<String>,
}

impl Findings {
    /// Reads a survey that is made, and measures it.
    ///
    /// # Errors
    /// Rollouts that can't be read.
    pub fn of(
        survey: &Survey,
        functions: &[Functions],
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> anyhow::Result<Self> {
        let task = survey.task();
        let reference = functions.first().map(Functions::reference).unwrap_or_default();
        let information = survey.information();
        let both = [&task, information.as_deref().unwrap_or_default()];
        let names = functions.first().map(|it| it.names(both)).unwrap_or_default();
        let names = told(names, information.is_some());
        let (mut slices, mut rows, mut omitted) = (Vec::new(), Vec::new(), Vec::new());
        for (i, slice) in survey.slices.iter().enumerate() {
            let values = told(survey.values(i, functions)?, information.is_some());
            match measure(slice, survey.unit(slice), &names, values) {
                Ok(measured) => {
                    rows.extend(measured.rows.iter().cloned());
                    slices.push(Some(measured));
                }
                Err(error) => {
                    omitted.push(format!("left out {}: {error}", slice.name));
                    slices.push(None);
                }
            }
            progress(i + 1, survey.slices.len());
        }
        if survey.n_gradients > 1 {
            for (i, centre) in survey.centres.iter().enumerate() {
                let gradients = told(survey.gradients(i, functions)?, information.is_some());
                rows.extend(align(&centre.name, &names, &gradients));
                for slice in survey.slices.iter().filter(|slice| slice.centre == i) {
                    rows.extend(predict(slice, survey.unit(slice), &names, &gradients));
                }
            }
        }
        Ok(Self { summary: summarise(&rows, &task, &reference), names, slices, rows, omitted })
    }
}

/// What is told of each function: nothing of information that isn't measured.
fn told<T>(mut of_each: Vec<T>, has_information: bool) -> Vec<T> {
    if !has_information && of_each.len() > Functions::INFORMATION {
        of_each.remove(Functions::INFORMATION);
    }
    of_each
}

/// The files of a survey, by name.
///
/// # Errors
/// Of drawing.
pub fn files(survey: &Survey, findings: &Findings) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let tables = [points(survey, findings), measures(findings), summary(findings)];
    let mut files: Vec<_> =
        tables.iter().map(|table| (format!("{}.csv", table.name), table.csv())).collect();
    for drawing in drawings(survey, findings)? {
        files.push((format!("{}.svg", drawing.file_stem), drawing.svg.into_bytes()));
    }
    Ok(files)
}

fn drawings(survey: &Survey, findings: &Findings) -> Result<Vec<Drawing>, figures::Error> {
    let (mut profiles, mut maps) = (Vec::new(), Vec::new());
    for (slice, measured) in survey.slices.iter().zip(&findings.slices) {
        let Some(Measured { means, errors, .. }) = measured.clone() else { continue };
        let title = slice.name.clone();
        if slice.is_plane() {
            let reach = slice.places.iter().flatten().fold(0.0, |most: f64, it| most.max(it.abs()));
            maps.push(LandscapeMap { title, reach, values: means });
        } else {
            let t = slice.places.iter().map(|place| place[0]).collect();
            profiles.push(LandscapeProfile { title, t, values: means, errors });
        }
    }
    let names = &findings.names;
    let curves = (!profiles.is_empty()).then(|| figures::landscape_curves(names, &profiles));
    let maps = (!maps.is_empty()).then(|| figures::landscape_maps(names, &maps));
    curves.into_iter().chain(maps).collect()
}

/// Each point of each slice.
fn points(survey: &Survey, findings: &Findings) -> Table {
    let mut rows = Vec::new();
    for (slice, measured) in survey.slices.iter().zip(&findings.slices) {
        let Some(measured) = measured else { continue };
        for (f, name) in findings.names.iter().enumerate() {
            for (point, [a, b]) in slice.places.iter().enumerate() {
                let mut row = vec![slice.name.clone(), name.clone(), point.to_string()];
                let (mean, error) = (measured.means[f][point], measured.errors[f][point]);
                row.extend([*a, *b, mean, error].map(number));
                rows.push(row);
            }
        }
    }
    table("points", &["slice", "function", "point", "t1", "t2", "mean", "standard_error"], rows)
}

fn measures(findings: &Findings) -> Table {
    let row = |row: &Row| {
        let Estimate { value, low, high } = row.estimate;
        let texts = [&row.place, row.kind, &row.function, row.measure].map(str::to_owned);
        texts.into_iter().chain([value, low, high].map(number)).collect()
    };
    let header = ["slice", "kind", "function", "measure", "value", "low", "high"];
    table("measures", &header, findings.rows.iter().map(row).collect())
}

fn summary(findings: &Findings) -> Table {
    let ends = |it: Option<Interval>| it.map_or([f64::NAN; 2], |it| [it.low, it.high]).map(number);
    let row = |it: &Summary| {
        let (difference, of_difference) = it.difference.unwrap_or((f64::NAN, None));
        let mut row = vec![it.kind.to_owned(), it.measure.to_owned(), it.function.clone()];
        row.extend([it.n.to_string(), number(it.mean)]);
        row.extend(ends(it.interval));
        row.push(number(difference));
        row.extend(ends(of_difference));
        row
    };
    let header = [
        "kind",
        "measure",
        "function",
        "n",
        "mean",
        "low",
        "high",
        "difference",
        "difference_low",
        "difference_high",
    ];
    table("summary", &header, findings.summary.iter().map(row).collect())
}

fn table(name: &'static str, header: &[&str], rows: Vec<Vec<String>>) -> Table {
    Table { name, header: header.iter().map(|it| (*it).to_owned()).collect(), rows }
}

/// What isn't finite is empty.
fn number(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}

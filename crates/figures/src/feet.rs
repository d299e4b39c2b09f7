//! Feet (the paper's figure 4): which foot touched the ground when, for two cells of each
//! setting.

use plotters::style::{RGBColor, text_anchor::HPos};

use super::{
    CellResults, Choice, Contacts, Drawing, Error, Figure, Measure, Options, Results, Setting,
    axis::Axis,
    best_and_median,
    canvas::{
        Area, GREY, INK, PAGE, Rect, SMALL, fill, font, line, notes_height, paint, setting_lines,
        stroke, write, write_notes,
    },
};

pub(super) const FIGURE: Figure = Figure {
    name: "feet",
    title: |_| "Feet on the ground".into(),
    caption: |measure| {
        format!(
            "Contacts of the feet in the last control steps of two cells of each setting, light \
             where a foot touches the ground; cells are chosen by the mean {} of their last \
             window.",
            measure.symbol
        )
    },
    draw,
    tables: |_| Vec::new(),
};

/// Control steps that are shown: each is wide enough to be seen.
const STEPS: f64 = 200.0;

const DARK: RGBColor = RGBColor(38, 48, 66);
const LIGHT: RGBColor = RGBColor(250, 224, 130);

const NAME: f64 = 116.0;
const NAME_LINE: f64 = 17.0;
const NUMBERS: f64 = 24.0;
const FOOT: f64 = 15.0;
const ABOVE: f64 = 24.0;
const BELOW: f64 = 8.0;
const TIME: f64 = 52.0;

/// A raster and what is said above it.
struct Raster<'a> {
    contacts: Option<&'a Contacts>,
    title: String,
}

fn draw(run: &Results, options: &Options) -> Result<Drawing, Error> {
    let rows: Vec<_> = run
        .settings
        .iter()
        .zip(best_and_median(run))
        .map(|(setting, choice)| {
            (setting, rasters(&run.measure, setting, choice, options.two_best))
        })
        .collect();
    let recorded = || rows.iter().flat_map(|(_, rasters)| rasters).filter_map(|it| it.contacts);
    let shown: Vec<_> = recorded().filter(|it| it.n_steps() > 0).collect();
    let Some(seconds) = duration(&shown) else {
        return Err(Error::Nothing { figure: FIGURE.name, why: why_nothing(recorded().next()) });
    };
    let n_feet = shown.iter().map(|it| it.feet.len()).max().unwrap_or(1);
    let frame_height = n_feet as f64 * FOOT;
    let names = run.settings.iter().map(|it| name_lines(it).len()).max().unwrap_or(1);
    let row_height = ABOVE + frame_height.max(names as f64 * NAME_LINE) + BELOW;
    let bottom = rows.len() as f64 * row_height;
    let notes = notes(run, &shown);
    let caption = FIGURE.caption_with(run, &notes);
    paint(&FIGURE, bottom + TIME + notes_height(&notes) + 6.0, caption, |area| {
        for (i, (setting, rasters)) in rows.iter().enumerate() {
            let y = i as f64 * row_height + ABOVE;
            draw_name(area, setting, y + (row_height - ABOVE - BELOW) / 2.0)?;
            for (column, raster) in rasters.iter().enumerate() {
                let frame = Rect { y, height: frame_height, ..column_frame(column) };
                draw_raster(area, frame, raster, seconds)?;
            }
        }
        let n_columns = rows.iter().map(|(_, rasters)| rasters.len()).max().unwrap_or(1);
        for column in 0..n_columns {
            draw_time(area, Rect { y: bottom, ..column_frame(column) }, seconds)?;
        }
        write_notes(area, bottom + TIME + 2.0, &notes)
    })
}

fn rasters<'a>(
    measure: &Measure,
    setting: &'a Setting,
    choice: Choice,
    two_best: bool,
) -> Vec<Raster<'a>> {
    let second = match (two_best, choice.second) {
        (true, second) => second.map(|it| (it, "second best")),
        (false, Some(_)) => Some((choice.median, "median")),
        // One cell is both.
        (false, None) => None,
    };
    let raster = |(index, why): (usize, &str)| {
        let cell: &CellResults = &setting.cells[index];
        let CellResults { seed, outcome, .. } = cell;
        let title = format!("{why}: seed {seed}, {} {:.4}", measure.symbol, outcome.last);
        Raster { contacts: cell.contacts.as_ref(), title: title.replace('-', "−") }
    };
    [Some((choice.best, "best")), second].into_iter().flatten().map(raster).collect()
}

/// The time that is shown, in s; none if there's nothing to show.
fn duration(shown: &[&Contacts]) -> Option<f64> {
    let step = shown.iter().map(|it| it.seconds_per_step).min_by(f64::total_cmp)?;
    let recorded = |it: &&Contacts| it.n_steps() as f64 * it.seconds_per_step;
    let longest = shown.iter().map(recorded).max_by(f64::total_cmp)?;
    let seconds = longest.min(STEPS * step);
    (seconds.is_finite() && seconds > 0.0).then_some(seconds)
}

fn why_nothing(recorded: Option<&Contacts>) -> String {
    match recorded {
        None => "the chosen cells have no replay.safetensors yet; it comes with a checkpoint",
        Some(contacts) if contacts.feet.is_empty() => "the robot has no contact sensors",
        Some(_) => "no control steps were recorded (record.steps of the experiment is 0)",
    }
    .into()
}

fn notes(run: &Results, shown: &[&Contacts]) -> Vec<String> {
    let windows = format!(
        "Light: contact. Cells are chosen by their mean {}, in {}, over their last {} updates.",
        run.measure.symbol,
        run.measure.axis_unit(),
        run.windows()
    );
    let mut notes = run.with_caveats(vec![windows]);
    // Settings may have different robots.
    for contacts in shown {
        let feet = contacts.feet.iter().enumerate();
        let feet: Vec<_> = feet.map(|(i, name)| format!("{} {name}", i + 1)).collect();
        let note = format!("Feet: {}.", feet.join(", "));
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    notes
}

/// Of the left or the right column; its height is open.
fn column_frame(column: usize) -> Rect {
    let width = (PAGE - NAME - 2.0 * NUMBERS - 14.0) / 2.0;
    let x = NAME + NUMBERS + column as f64 * (width + NUMBERS);
    Rect { x, y: 0.0, width, height: 0.0 }
}

fn name_lines(setting: &Setting) -> Vec<String> {
    setting_lines(&setting.name, SMALL, NAME - 10.0)
}

fn draw_name(area: &Area<'_>, setting: &Setting, middle: f64) -> Result<(), Error> {
    let lines = name_lines(setting);
    let top = middle - (lines.len() as f64 - 1.0) * NAME_LINE / 2.0;
    for (i, text) in lines.iter().enumerate() {
        let at = (10.0, top + i as f64 * NAME_LINE);
        write(area, text, at, &font(SMALL, INK, HPos::Left))?;
    }
    Ok(())
}

fn draw_raster(
    area: &Area<'_>,
    frame: Rect,
    raster: &Raster<'_>,
    seconds: f64,
) -> Result<(), Error> {
    let title = (frame.x, frame.y - 9.0);
    write(area, &raster.title, title, &font(SMALL, INK, HPos::Left))?;
    let Some(contacts) = raster.contacts.filter(|it| it.n_steps() > 0) else {
        let middle = (frame.x + frame.width / 2.0, frame.y + frame.height / 2.0);
        return write(area, "nothing recorded", middle, &font(SMALL, GREY, HPos::Center));
    };
    let step = contacts.seconds_per_step;
    let n_shown = ((seconds / step).round() as usize).min(contacts.n_steps());
    let first = contacts.n_steps() - n_shown;
    let x = |step_of_all: usize| {
        let time = (step_of_all - first) as f64 * step;
        frame.x + (time / seconds).min(1.0) * frame.width
    };
    let [left, right] = [frame.x, x(contacts.n_steps())];
    for foot in 0..contacts.feet.len() {
        let top = frame.y + foot as f64 * FOOT;
        let bottom = top + FOOT - 1.0;
        fill(area, &[(left, top), (right, top), (right, bottom), (left, bottom)], DARK)?;
        // One outline that goes along the bottom between stances: a file of single rectangles
        // would be twice as long.
        let stances = contacts.stances(foot, first..contacts.n_steps());
        let outline: Vec<_> = stances
            .iter()
            .flat_map(|&[begin, end]| {
                let (begin, end) = (x(begin), x(end));
                [(begin, bottom), (begin, top), (end, top), (end, bottom)]
            })
            .collect();
        if !outline.is_empty() {
            fill(area, &outline, LIGHT)?;
        }
        let number = (frame.x - 8.0, top + FOOT / 2.0);
        write(area, &(foot + 1).to_string(), number, &font(12.0, INK, HPos::Center))?;
    }
    Ok(())
}

/// The axis of time, from the beginning of what is shown.
fn draw_time(area: &Area<'_>, frame: Rect, seconds: f64) -> Result<(), Error> {
    line(area, &[(frame.x, frame.y), (frame.right(), frame.y)], stroke(INK, 1.0))?;
    let axis = Axis::new(0.0..seconds, 8);
    for (value, text) in axis.ticks() {
        let x = frame.x + value / seconds * frame.width;
        line(area, &[(x, frame.y), (x, frame.y + 4.0)], stroke(INK, 1.0))?;
        write(area, &text, (x, frame.y + 14.0), &font(SMALL, INK, HPos::Center))?;
    }
    let label = match axis.multiplier() {
        Some(multiplier) => format!("time / {multiplier} s"),
        None => "time / s".to_owned(),
    };
    let middle = (frame.x + frame.width / 2.0, frame.y + 32.0);
    write(area, &label, middle, &font(SMALL, INK, HPos::Center))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::run_of;

    fn contacts(n_steps: usize, seconds_per_step: f64) -> Contacts {
        Contacts { feet: vec!["foot".into()], seconds_per_step, touching: vec![true; n_steps] }
    }

    #[test]
    fn what_is_shown_fits_the_steps_and_the_recordings() {
        let [long, short, slow] = [contacts(600, 0.1), contacts(50, 0.1), contacts(600, 0.2)];
        assert_eq!(duration(&[&long, &short]), Some(20.0));
        assert_eq!(duration(&[&short]), Some(5.0));
        assert_eq!(duration(&[&slow, &long]), Some(20.0));
        assert_eq!(duration(&[]), None);
        assert_eq!(duration(&[&contacts(600, 0.0)]), None);
    }

    #[test]
    fn a_run_without_feet_says_so() {
        let mut run = run_of(&[("a", vec![vec![1.0; 20]])]);
        let why = |run: &Results| draw(run, &Options::default()).unwrap_err().to_string();
        assert!(why(&run).starts_with("feet: the chosen cells have no replay.safetensors yet"));
        let none = Contacts { feet: vec![], ..contacts(0, 0.1) };
        run.settings[0].cells[0].contacts = Some(none);
        assert_eq!(why(&run), "feet: the robot has no contact sensors");
        run.settings[0].cells[0].contacts = Some(contacts(0, 0.1));
        assert!(why(&run).contains("record.steps"));
    }

    #[test]
    fn the_second_raster_is_the_median_or_the_second_best() {
        let flat = |value: f64| vec![value; 20];
        let run = run_of(&[("a", vec![flat(1.0), flat(-3.0), flat(2.0)]), ("b", vec![flat(1.0)])]);
        let titles = |setting: usize, two_best| {
            let choice = best_and_median(&run)[setting];
            let rasters = rasters(&run.measure, &run.settings[setting], choice, two_best);
            rasters.into_iter().map(|it| it.title).collect::<Vec<_>>()
        };
        let best = "best: seed 3, R_Loc 2.0000";
        assert_eq!(titles(0, false), [best, "median: seed 1, R_Loc 1.0000"]);
        assert_eq!(titles(0, true), [best, "second best: seed 1, R_Loc 1.0000"]);
        assert_eq!(titles(1, false), ["best: seed 1, R_Loc 1.0000"]);
    }
}

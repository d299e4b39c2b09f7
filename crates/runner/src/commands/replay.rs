//! `itarl replay`: a robot to look at.

use std::path::{Path, PathBuf};

use anyhow::bail;
use maud::html;
use runs::atomic;
use scenes::{
    Clip,
    film::{Film, GIF_HZ, MP4_HZ},
    glb,
    page::page,
    three_sides, viewer,
};
use svenja::Morphology;

use super::{Outcome, print_line, subject::Subject};
use crate::{
    catalogue::Catalogue,
    cli::{Replay, Size},
    clips, models,
    progress::Counter,
    rollout::record,
};

const GIF_SIZE: Size = Size { width: 480, height: 320 };
const MP4_SIZE: Size = Size { width: 1280, height: 720 };

pub(super) fn replay(arguments: &Replay) -> anyhow::Result<Outcome> {
    if !(arguments.seconds > 0.0 && arguments.seconds <= 3600.0) {
        bail!("--seconds must be above 0 to 3600, got {}", arguments.seconds);
    }
    let Replay { what, html, glb, gif, mp4, png, .. } = arguments;
    if let Some(path) = png {
        write(path, &three_sides(&model(what)?)?.png()?)?;
    }
    let moves = [html, glb, gif, mp4].into_iter().any(Option::is_some);
    if png.is_some() && !moves {
        return Ok(Outcome::Done);
    }
    let clip = match (&arguments.policy, what.is_dir()) {
        (None, true) => recorded(what)?,
        (policy, _) => rolled_out(arguments, policy.as_deref())?,
    };
    let default = (!moves).then(|| page_name(what));
    if let Some(path) = html.as_ref().or(default.as_ref()) {
        write(path, self::html(&clip)?.as_bytes())?;
    }
    if let Some(path) = glb {
        write(path, &glb::encode(&clip)?)?;
    }
    if let Some(path) = gif {
        let film = film(&clip, arguments, GIF_SIZE, GIF_HZ);
        write(path, &film.gif(counter(path, &film))?)?;
    }
    if let Some(path) = mp4 {
        let film = film(&clip, arguments, MP4_SIZE, MP4_HZ);
        film.mp4(path, counter(path, &film))?;
        print_line(path.display())?;
    }
    Ok(Outcome::Done)
}

/// The robot alone: a model file needn't be set in motion for it.
fn model(what: &Path) -> anyhow::Result<Morphology> {
    if what.is_dir() {
        return Ok(recorded(what)?.morphology().clone());
    }
    Ok(models::open_model(what)?)
}

fn film<'a>(clip: &'a Clip, arguments: &Replay, size: Size, hz: f64) -> Film<'a> {
    let Size { width, height } = arguments.size.unwrap_or(size);
    Film::new(clip, [width, height], arguments.seconds, hz)
}

/// For whoever waits.
fn counter(path: &Path, film: &Film<'_>) -> impl Fn(usize) + use<> {
    let (counter, n) = (Counter::new(path.display().to_string()), film.n_pictures());
    move |done| counter.report(done, n, "pictures")
}

fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    atomic::write(path, bytes)?;
    print_line(path.display())?;
    Ok(())
}

/// `xi=1-seed=8.html` for a cell, `svenja.html` for a model file; in the current folder.
fn page_name(what: &Path) -> PathBuf {
    let name = |path: Option<&Path>| {
        let name = path.and_then(Path::file_name).unwrap_or_default();
        name.to_string_lossy().into_owned()
    };
    let what = what.canonicalize().unwrap_or_else(|_| what.into());
    let stem = match what.is_dir() {
        true => format!("{}-{}", name(what.parent()), name(Some(&what))),
        false => what.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
    };
    PathBuf::from(format!("{stem}.html"))
}

/// What a cell has recorded.
fn recorded(folder: &Path) -> anyhow::Result<Clip> {
    let (catalogue, cell) = Catalogue::of_cell(folder)?;
    catalogue.check(&cell)?;
    clips::of_cell(&catalogue, &cell)
}

/// What a policy does now.
fn rolled_out(arguments: &Replay, policy: Option<&str>) -> anyhow::Result<Clip> {
    let subject = Subject::open(&arguments.what)?;
    let policy = policy.unwrap_or("random");
    let mut driver = subject.driver(policy, arguments.seed)?;
    let Subject { experiment, morphology, .. } = subject;
    let driver = (&mut driver, arguments.seed);
    let recording = record(&experiment, &morphology, driver, arguments.steps)?;
    let title = match policy {
        "learned" | "random" => format!("policy {policy}, seed {}", arguments.seed),
        _ => format!("policy {policy}"),
    };
    Ok(clips::of_recording(title, &experiment, morphology, recording)?)
}

fn html(clip: &Clip) -> anyhow::Result<String> {
    let mut packed = viewer::Packed::default();
    packed.add("", clip.title(), clip, viewer::PAGE_BYTES);
    let name = clip.morphology().name();
    let body = html! {
        h1 { (name) }
        p { (clip.title()) }
        (packed.markup(true))
    };
    Ok(page(&format!("{name}: {}", clip.title()), &body, &packed)?)
}

//! The robots from three sides: figure 1 of the paper. The one figure that is a picture, drawn by
//! the software renderer, so its SVG holds it as PNG.

use base64::{Engine, engine::general_purpose::STANDARD};
use svenja::Morphology;

use super::{Drawing, Error, Figure, Options, Run};
use crate::{
    replay::{figure::three_sides, render::Picture},
    store,
};

pub(super) const FIGURE: Figure = Figure {
    name: "robot",
    title: "The robot",
    caption: "Each of the run's models from its right, its front and above, to one scale, and as it \
              stands there, in the pose that its file draws.",
    draw,
    tables: |_| Vec::new(),
};

/// White, between two models.
const GAP: usize = 20;

fn draw(run: &Run, _: &Options) -> Result<Drawing, Error> {
    let models = models(run)?;
    let refused = |error: anyhow::Error| Error::Drawing(format!("{error:#}"));
    let pictures: Result<Vec<_>, _> = models.iter().map(three_sides).collect();
    let picture = stacked(&pictures.map_err(refused)?);
    let png = picture.png().map_err(refused)?;
    // As those of the other figures: two pixels a px.
    let [width, height] = [picture.width(), picture.height()].map(|pixels| pixels as u32 / 2);
    let names: Vec<_> = models.iter().map(Morphology::name).collect();
    let caption = format!("{}: {}", names.join(", "), FIGURE.caption);
    let label = super::canvas::escaped(&caption);
    let data = STANDARD.encode(&png);
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{label}\"><image \
         width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{data}\"/></svg>\n"
    );
    Ok(Drawing { file_stem: FIGURE.name, svg, width, height, caption, picture: Some(png) })
}

/// The run's copies.
fn models(run: &Run) -> Result<Vec<Morphology>, Error> {
    let run = store::Run::open(&run.folder)?;
    let nothing = |why: String| Error::Nothing { figure: FIGURE.name, why };
    let model = |listed: &store::Model| {
        let source = run.model_path(&listed.file).display().to_string();
        let text = String::from_utf8(run.model(listed)?)
            .map_err(|_| nothing(format!("{source}: not UTF-8")))?;
        Morphology::parse(&source, &text).map_err(|problems| nothing(problems.to_string()))
    };
    let models: Vec<_> = run.manifest().models.iter().map(model).collect::<Result<_, _>>()?;
    if models.is_empty() { Err(nothing("the run lists no model".into())) } else { Ok(models) }
}

fn stacked(pictures: &[Picture]) -> Picture {
    let width = pictures.iter().map(Picture::width).max().unwrap_or(0);
    let heights = pictures.iter().map(|picture| picture.height() + GAP);
    let mut all = Picture::filled(width, heights.sum::<usize>() - GAP, [0xff; 3]);
    let mut y = 0;
    for picture in pictures {
        all.put(picture, 0, y);
        y += picture.height() + GAP;
    }
    all
}

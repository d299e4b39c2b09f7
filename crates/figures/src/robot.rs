//! The robots from three sides: figure 1 of the paper. The one figure that is a picture, drawn by
//! the software renderer, so its SVG holds it as PNG.

use std::collections::BTreeSet;

use base64::{Engine, engine::general_purpose::STANDARD};
use scenes::{render::Picture, three_sides};
use svenja::Morphology;

use super::{Drawing, Error, Figure, Options, Results};

pub(super) const FIGURE: Figure = Figure {
    name: "robot",
    title: |_| "The robot".into(),
    caption: |_| {
        "Each of the models from its right, its front and above, to one scale, and as it \
         stands there, in the pose that its file draws."
            .into()
    },
    draw,
    tables: |_| Vec::new(),
};

/// White, between two models.
const GAP: usize = 20;

fn draw(run: &Results, _: &Options) -> Result<Drawing, Error> {
    let models = models(run)?;
    let refused = |error: scenes::Error| Error::Drawing(error.to_string());
    let pictures: Result<Vec<_>, _> = models.iter().map(three_sides).collect();
    let picture = stacked(&pictures.map_err(refused)?);
    let png = picture.png().map_err(refused)?;
    // As those of the other figures: two pixels a px.
    let [width, height] = [picture.width(), picture.height()].map(|pixels| pixels as u32 / 2);
    let names: Vec<_> = models.iter().map(Morphology::name).collect();
    let caption = FIGURE.caption_with(run, &[format!("Here: {}.", names.join(", "))]);
    let label = super::canvas::escaped(&caption);
    let data = STANDARD.encode(&png);
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{label}\"><image \
         width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{data}\"/></svg>\n"
    );
    Ok(Drawing { file_stem: FIGURE.name, svg, width, height, caption, picture: Some(png) })
}

/// The runs' copies, each once.
fn models(results: &Results) -> Result<Vec<Morphology>, Error> {
    let nothing = |why: String| Error::Nothing { figure: FIGURE.name, why };
    let (mut models, mut known) = (Vec::new(), BTreeSet::new());
    for folder in &results.folders {
        let run = runs::Run::open(folder)?;
        for listed in &run.manifest().models {
            let source = run.model_path(&listed.file).display().to_string();
            let text = run.model(listed)?;
            if known.insert(listed.xxh3.0) {
                let model = Morphology::parse(&source, &text);
                models.push(model.map_err(|problems| nothing(problems.to_string()))?);
            }
        }
    }
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

#[cfg(test)]
mod tests {
    use runs::{Bullet, NewRun, Precision};

    use super::*;
    use crate::example::{locomotion, run_of};

    /// A run folder with these model files, and nothing trained in it.
    fn run(models: &[&str]) -> (tempfile::TempDir, Results) {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("run");
        let text = |file: &str| {
            let path = format!("{}/../../models/{file}", env!("CARGO_MANIFEST_DIR"));
            std::fs::read(path).unwrap()
        };
        let new = NewRun {
            experiment: "learning.updates = 1".into(),
            itarl: "0.1.0".into(),
            bullet: Bullet { version: 325, precision: Precision::Single },
            models: models.iter().map(|file| ((*file).to_owned(), text(file))).collect(),
            policies: Vec::new(),
            seeds: Vec::new(),
            cells: Vec::new(),
        };
        runs::Run::create(&folder, &new).unwrap();
        let run = Results { folders: vec![folder], ..run_of(&[("base", vec![vec![0.0]])]) };
        (parent, run)
    }

    #[test]
    fn all_models_of_the_run_are_drawn_one_below_the_other() {
        let (_folder, both) = run(&["worm.toml", "hexapod.toml"]);
        let (_other, worm) = run(&["worm.toml"]);
        let options = Options::default();
        let [both, worm] = [both, worm].map(|run| draw(&run, &options).unwrap());
        assert_eq!(both.width, worm.width);
        assert!(both.height > worm.height + GAP as u32 / 2);
        assert!(both.caption.ends_with("Here: Worm, Hexapod."), "{}", both.caption);
        assert!(both.caption.starts_with(&FIGURE.caption(&locomotion())));
        assert!(both.svg.contains("href=\"data:image/png;base64,iVBOR"));
        let png = both.png().unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(&png)).read_info().unwrap();
        assert_eq!(reader.info().size(), (2 * both.width, 2 * both.height));
    }

    #[test]
    fn a_damaged_model_is_named() {
        let (_folder, run) = run(&["worm.toml"]);
        std::fs::write(run.folders[0].join("models/worm.toml"), "name = 1").unwrap();
        let error = draw(&run, &Options::default()).unwrap_err().to_string();
        assert!(error.contains("worm.toml: damaged"), "{error}");
    }
}

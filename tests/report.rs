//! Reports and replays as a person sees them: in a browser, from the disk.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

#[path = "common/browser.rs"]
mod browser;
mod common;

use std::{
    fs,
    path::{Path, PathBuf},
};

use browser::{Browser, changed, n_colours};
use common::*;
use runs::Recording;
use serde_json::json;
use svenja::Morphology;
use tempfile::TempDir;

const STAGE: &str = "[data-part=scene]";
const STRIP: &str = "[data-part=strip]";
const DESKTOP: [u32; 2] = [1280, 800];
const PHONE: [u32; 2] = [390, 844];

/// A run that is done, with its tables as CSV and its report.
fn reported(more: &[&str]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &[&["--set", "learning.updates=12"], more].concat()).ends(DONE);
    itarl(&["plot", text(&run)]).ends(DONE);
    let page = run.join("report.html");
    itarl(&["report", text(&run)]).ends(DONE).prints(&[text(&page)]);
    (folder, run)
}

/// The rows of a CSV file without its header. No field of these has a comma in it.
fn csv(path: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(path).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// Pairs of boxes that overlap, and boxes that stick out to the right. What is within one another
/// may overlap, and what scrolls may stick out of what it scrolls in.
const CLASHES: &str = r#"
(() => {
  const inside = (element) => element.closest(".scroll, pre") !== null && !element.matches(".scroll, pre");
  const shown = (element) => {
    const { width, height } = element.getBoundingClientRect();
    return width > 0 && height > 0 && element.checkVisibility() && !inside(element);
  };
  const kinds = "h1, h2, h3, p, dt, dd, li, button, select, input, output, canvas, img, figcaption, summary, .scroll, .legend span";
  const boxes = [...document.querySelectorAll(kinds)].filter(shown);
  const name = (element) => `${element.tagName} ${element.dataset.part ?? element.textContent.slice(0, 30)}`;
  const found = [];
  boxes.forEach((one, i) => {
    const a = one.getBoundingClientRect();
    if (a.right > document.documentElement.clientWidth + 1 || a.left < -1) found.push(`${name(one)} sticks out`);
    boxes.slice(i + 1).forEach((other) => {
      if (one.contains(other) || other.contains(one)) return;
      const b = other.getBoundingClientRect();
      const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (across > 1 && down > 1) found.push(`${name(one)} and ${name(other)} overlap`);
    });
  });
  const { scrollWidth, clientWidth } = document.documentElement;
  if (scrollWidth > clientWidth) found.push(`the page is ${scrollWidth} wide in ${clientWidth}`);
  return found;
})()"#;

/// Where the recording has the centre of gravity at a frame.
fn recorded_centre(run: &Path, cell: &str, frame: usize) -> [f64; 3] {
    let path = run.join("cells").join(cell).join("replay.safetensors");
    let recording = Recording::read(&path).unwrap().unwrap();
    let model = Morphology::open(&run.join("models/crawler.toml")).unwrap();
    let n = model.bodies().len();
    let centre = |axis: usize| {
        let bodies = model.bodies().iter().enumerate();
        let moment: f64 = bodies
            .map(|(i, body)| body.mass_kg * f64::from(recording.poses[(frame * n + i) * 7 + axis]))
            .sum();
        moment / model.total_mass_kg()
    };
    [centre(0), centre(1), centre(2)]
}

/// The numbers behind x, y and z in "centre of gravity x 0.10, y -0.20, z 0.30 m".
fn shown_centre(text: &str) -> [f64; 3] {
    let text = text.replace('\u{2212}', "-");
    ["x ", "y ", "z "].map(|letter| {
        let (_, rest) = text.split_once(&format!(" {letter}")).unwrap();
        rest.split([',', ' ']).next().unwrap().parse().unwrap()
    })
}

#[test]
fn a_report_works_from_the_disk_alone() {
    let (_folder, run) = reported(&[]);
    let mut browser = Browser::start(true);
    browser.resize(DESKTOP[0], DESKTOP[1]);
    browser.open(&run.join("report.html"));

    // Something is drawn, and it moves when it plays.
    let before = browser.pixels(STAGE);
    assert!(n_colours(&before) > 100, "{} colours", n_colours(&before));
    let strip = browser.pixels(STRIP);
    assert!(n_colours(&strip) > 10);
    browser.run("document.querySelector('[data-part=play]').click()");
    browser.wait_until("document.querySelector('[data-part=slider]').value > 0.8");
    browser.run("document.querySelector('[data-part=play]').click()");
    assert!(changed(&before, &browser.pixels(STAGE)) > 0.002);
    assert!(changed(&strip, &browser.pixels(STRIP)) > 0.002);

    // The slider moves the robot to where it was recorded.
    let label = browser.run("document.querySelector('[data-part=clip] option').label");
    let label = label.as_str().unwrap();
    let seed = label.split_once("seed ").unwrap().1.split(',').next().unwrap();
    let setting = browser.run("document.querySelector('[data-part=clip] optgroup').label");
    let cell = format!("{}/seed={seed}", setting.as_str().unwrap());
    let mut last = Vec::new();
    for (end, frame) in [("min", 0), ("max", last_frame(&run, &cell))] {
        browser.run(&format!(
            "(() => {{ const slider = document.querySelector('[data-part=slider]');
               slider.value = slider.{end}; slider.dispatchEvent(new Event('input')); }})()"
        ));
        browser.settle();
        let shown = shown_centre(&browser.text("[data-part=where]"));
        for (shown, recorded) in shown.iter().zip(recorded_centre(&run, &cell, frame)) {
            // Half of the last digit shown, and the packing.
            assert!((shown - recorded).abs() < 0.006, "{end} of {cell}: {shown}, not {recorded}");
        }
        let pixels = browser.pixels(STAGE);
        assert!(last.is_empty() || changed(&last, &pixels) > 0.002);
        last = pixels;
    }

    // Keys do what the page says.
    browser.run("document.querySelector('[data-viewer]').focus()");
    for (key, end) in [("Home", "min"), ("End", "max")] {
        browser.run(&format!(
            "document.activeElement.dispatchEvent(
                new KeyboardEvent('keydown', {{ key: '{key}', bubbles: true }}))"
        ));
        browser.settle();
        let off = "(({ value, END }) => Math.abs(value - END) < 1e-6)(document.querySelector('[data-part=slider]'))";
        assert_eq!(browser.run(&off.replace("END", end)), json!(true), "{key}");
    }

    // The tables have the numbers of the files.
    for name in ["settings", "instances", "improvement", "correlation"] {
        let shown = browser.run(&format!(
            "[...document.querySelectorAll('#table-{name} tbody tr')].map(
                (row) => [...row.querySelectorAll('data')].map((it) => it.value))"
        ));
        let file = csv(&run.join(format!("plots/{name}.csv")));
        assert!(!file.is_empty());
        assert_eq!(shown, json!(file), "{name}");
    }
    assert_eq!(browser.run("[...document.images].every((it) => it.naturalWidth > 0)"), json!(true));
    assert!(browser.run("document.images.length").as_u64().unwrap() >= 5);

    for [width, height] in [DESKTOP, PHONE] {
        browser.resize(width, height);
        let open = "document.querySelectorAll('details').forEach((it) => { it.open = true; })";
        browser.run(open);
        browser.settle();
        assert_eq!(browser.run(CLASHES), json!([]), "at {width} x {height}");
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

fn last_frame(run: &Path, cell: &str) -> usize {
    let path = run.join("cells").join(cell).join("replay.safetensors");
    let recording = Recording::read(&path).unwrap().unwrap();
    recording.n_steps * recording.layout.frames_per_step - 1
}

#[test]
fn without_webgl_all_else_is_there() {
    let (_folder, run) = reported(&[]);
    let mut browser = Browser::start(false);
    browser.resize(PHONE[0], PHONE[1]);
    browser.open(&run.join("report.html"));
    let message = "getComputedStyle(document.querySelector('[data-part=no-webgl]')).display";
    assert_ne!(browser.run(message), json!("none"));
    assert!(browser.text("[data-part=no-webgl]").contains("no WebGL"));
    assert!(n_colours(&browser.pixels(STRIP)) > 10);
    assert_eq!(
        browser.run("document.querySelectorAll('#table-settings tbody tr').length > 0"),
        json!(true)
    );
    assert_eq!(browser.run(CLASHES), json!([]));
    browser.run("document.querySelector('[data-part=play]').click()");
    browser.wait_until("document.querySelector('[data-part=slider]').value > 0.5");
}

#[test]
fn names_are_text_wherever_they_stand() {
    let nasty = "</script><i id='in'>&<!--";
    let folder = tempfile::tempdir().unwrap();
    let model = fs::read_to_string(root().join("tests/models/crawler.toml")).unwrap();
    let model = model.replace("\"Crawler\"", &format!("\"{nasty}\""));
    // Names of bodies have no slash.
    let model = model.replace("\"forearm\"", "\"<i id='in'>&<!--\"");
    let path = folder.path().join("nasty.toml");
    fs::write(&path, model).unwrap();
    let run = folder.path().join("run <b>");
    let sets = [
        format!("model=\"{}\"", text(&path)),
        format!("description=\"{nasty}\""),
        "learning.updates=3".to_owned(),
    ];
    let sets: Vec<_> = sets.iter().flat_map(|set| ["--set", set]).collect();
    train(&run, &sets).ends(DONE);
    itarl(&["report", text(&run)]).ends(DONE);
    let page = folder.path().join("cell.html");
    let cell = run.join("cells/xi=1/seed=1");
    itarl(&["replay", text(&cell), "--html", text(&page)]).ends(DONE);

    let mut browser = Browser::start(true);
    for (page, heading) in [(&run.join("report.html"), "run <b>"), (&page, nasty)] {
        browser.open(page);
        assert_eq!(browser.text("h1"), heading);
        assert_eq!(browser.run("document.querySelector('#in')"), json!(null));
        assert!(n_colours(&browser.pixels(STAGE)) > 100);
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// The robot of docs/formats.md, which has shapes of all kinds, several in a body and none.
#[test]
fn shapes_of_all_kinds_are_drawn() {
    let page = fs::read_to_string(root().join("docs/formats.md")).unwrap();
    let snippets = page.split("```toml\n").skip(2).map(|rest| rest.split_once("```").unwrap().0);
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("robot.toml");
    fs::write(&model, snippets.collect::<String>()).unwrap();
    let page = folder.path().join("robot.html");
    itarl(&["replay", text(&model), "--steps", "5", "--html", text(&page)]).ends(DONE);
    let mut browser = Browser::start(true);
    browser.open(&page);
    assert!(n_colours(&browser.pixels(STAGE)) > 300);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// A quadruped in URDF, and an ant in MJCF.
#[test]
fn robots_in_other_formats_are_drawn_and_move() {
    let folder = tempfile::tempdir().unwrap();
    let mut browser = Browser::start(true);
    for robot in ["unitree/go2.urdf", "gymnasium/ant.xml"] {
        let file = root().join("tests/robots").join(robot);
        let page = folder.path().join("robot.html");
        let words = ["--policy", "random", "--steps", "20", "--html", text(&page)];
        itarl(&[&["replay", text(&file)], &words[..]].concat()).ends(DONE);
        browser.open(&page);
        let before = browser.pixels(STAGE);
        assert!(n_colours(&before) > 300, "{robot}: {} colours", n_colours(&before));
        browser.run("document.querySelector('[data-part=play]').click()");
        browser.wait_until("document.querySelector('[data-part=slider]').value > 0.8");
        browser.run("document.querySelector('[data-part=play]').click()");
        assert!(changed(&before, &browser.pixels(STAGE)) > 0.002, "{robot}");
        // It hasn't sunk into the ground, and hasn't left it.
        let [_, _, z] = shown_centre(&browser.text("[data-part=where]"));
        assert!((0.05..1.0).contains(&z), "{robot}: {z} m");
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn damaged_cells_are_named_and_the_rest_is_shown() {
    let (_folder, run) = reported(&[]);
    let file = |cell: &str, name: &str| run.join("cells").join(cell).join(name);
    for seed in ["seed=1", "seed=2"] {
        let path = file(&format!("xi=0.75/{seed}"), "replay.safetensors");
        let mut bytes = fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(path, bytes).unwrap();
    }
    fs::write(file("xi=1/seed=1", "metrics.csv"), "nonsense\n").unwrap();
    itarl(&["report", text(&run)]).ends(FAILED).complains(&[
        "xi=0.75/seed=1: left out: ",
        "replay.safetensors: damaged",
        "xi=1/seed=1: left out: ",
    ]);
    let mut browser = Browser::start(true);
    browser.open(&run.join("report.html"));
    let problems = browser.text(".problems");
    for cell in ["xi=0.75/seed=1", "xi=0.75/seed=2", "xi=1/seed=1"] {
        assert!(problems.contains(&format!("{cell}: ")), "{problems}");
    }
    let shown = "[...document.querySelectorAll('[data-part=clip] option')].map((it) => it.label.split(',')[0])";
    assert_eq!(browser.run(shown), json!(["best and median of xi=1: seed 2"]));
    let rows = "document.querySelectorAll('#table-instances tbody tr').length";
    assert_eq!(browser.run(rows), json!(3));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn an_empty_run_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--stop-after", "1"]).ends(STOPPED);
    fs::remove_dir_all(run.join("cells")).unwrap();
    itarl(&["report", text(&run)]).ends(FAILED).complains(&["itarl resume"]);
    itarl(&["report", text(folder.path())]).ends(FAILED).complains(&["not the folder of a run"]);
    assert!(!run.join("report.html").exists());
}

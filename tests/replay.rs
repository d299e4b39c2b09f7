//! `itarl replay`: what it writes, where, and what it says when it can't.

use std::{
    fs,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
};

use crate::common::*;
use tempfile::TempDir;

const MODEL: &str = "tests/models/crawler.toml";

/// A run that is done, and one of its cells.
fn cell() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    train(&run, &["--set", "learning.updates=6"]).ends(DONE);
    (folder, run.join("cells/xi=1/seed=2"))
}

#[test]
fn every_format_is_written_and_twice_the_same() {
    let (folder, cell) = cell();
    let write = |name: &str| {
        let path = |end: &str| folder.path().join(format!("{name}.{end}"));
        let paths = ["html", "glb", "gif", "png"].map(path);
        let [html, glb, gif, png] = paths.each_ref().map(|path| text(path));
        let words = ["--html", html, "--glb", glb, "--gif", gif, "--png", png, "--seconds", "1"];
        let words = [&["replay", text(&cell), "--size", "48x32"], &words[..]].concat();
        itarl(&words).ends(DONE).prints(&[html, glb, gif, png]);
        paths.map(|path| fs::read(path).unwrap())
    };
    let [html, glb, gif, png] = write("one");
    assert!(html.starts_with(b"<!DOCTYPE html>"));
    assert!(glb.starts_with(b"glTF\x02\0\0\0"));
    assert!(gif.starts_with(b"GIF89a\x30\0\x20\0"));
    assert!(png.starts_with(b"\x89PNG\r\n"));
    assert_eq!(write("two"), [html, glb, gif, png]);
}

#[test]
fn a_page_has_the_name_of_what_it_shows() {
    let (_folder, cell) = cell();
    let here = tempfile::tempdir().unwrap();
    for (what, page) in [(cell, "xi=1-seed=2.html"), (root().join(MODEL), "crawler.html")] {
        let mut command = command(&["replay", text(&what), "--steps", "3"]);
        let output = command.current_dir(here.path()).output().unwrap();
        assert_eq!(String::from_utf8(output.stdout).unwrap(), format!("{page}\n"));
        assert!(fs::read_to_string(here.path().join(page)).unwrap().contains("Crawler"));
    }
    // Nothing else was written, and a model isn't set in motion for its picture.
    let png = here.path().join("it.png");
    itarl(&["replay", MODEL, "--png", text(&png)]).ends(DONE);
    let names: Vec<_> = tree(here.path()).into_keys().collect();
    assert_eq!(names, ["crawler.html", "it.png", "xi=1-seed=2.html"]);
}

/// In the place of ffmpeg.
fn program(folder: &Path, script: &str) {
    let path = folder.join("ffmpeg");
    fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn films_go_through_ffmpeg_or_say_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let bin = folder.path().join("bin");
    fs::create_dir(&bin).unwrap();
    let film = folder.path().join("film.mp4");
    let run = |path: &str| {
        let words = ["replay", MODEL, "--steps", "10", "--seconds", "0.4", "--size", "32x18"];
        let mut command = command(&[&words[..], &["--mp4", text(&film)]].concat());
        let output = command.env("PATH", path).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, said) = run(text(&bin));
    assert_eq!(code, Some(FAILED));
    assert!(said.contains("--mp4 needs ffmpeg on the path (`apt-get install ffmpeg`)"), "{said}");

    let path = format!("{}:/usr/bin:/bin", text(&bin));
    program(&bin, "echo no such codec >&2; exit 3");
    let (code, said) = run(&path);
    assert_eq!(code, Some(FAILED));
    assert!(said.contains("ffmpeg failed (exit status: 3): no such codec"), "{said}");
    assert!(!film.exists());

    // The raw pictures: 0.4 s at 25 a second of 32 x 18 pixels.
    program(&bin, "for last; do :; done; cat >\"$last\"");
    assert_eq!(run(&path).0, Some(DONE));
    assert_eq!(fs::read(&film).unwrap().len(), 10 * 32 * 18 * 3);
    let names: Vec<_> = tree(folder.path()).into_keys().collect();
    assert_eq!(names, ["bin/ffmpeg", "film.mp4"]);
}

#[test]
fn mistakes_are_explained() {
    let (folder, cell) = cell();
    let page = folder.path().join("page.html");
    let replay = |what: &Path, more: &[&str]| {
        itarl(&[&["replay", text(what), "--html", text(&page)], more].concat())
    };
    replay(folder.path(), &[]).ends(FAILED).complains(&["a cell's folder expected"]);
    replay(Path::new("nowhere.toml"), &[]).ends(FAILED).complains(&["nowhere.toml: ", "No such"]);
    let model = root().join(MODEL);
    replay(&model, &["--policy", "learned"]).ends(FAILED).complains(&["has learned nothing"]);
    replay(&model, &["--seconds", "0"]).ends(FAILED).complains(&["--seconds must be above 0"]);
    replay(&model, &["--size", "640"]).ends(USAGE).complains(&["WxH expected"]);

    let recording = cell.join("replay.safetensors");
    let bytes = fs::read(&recording).unwrap();
    fs::write(&recording, &bytes[..bytes.len() / 2]).unwrap();
    replay(&cell, &[]).ends(FAILED).complains(&["replay.safetensors: damaged: "]);
    fs::remove_file(&recording).unwrap();
    replay(&cell, &[]).ends(FAILED).complains(&["there's none before the first checkpoint"]);
    assert!(!page.exists());
    // What was learned is there all the same.
    replay(&cell, &["--policy", "learned", "--steps", "5"]).ends(DONE);
}

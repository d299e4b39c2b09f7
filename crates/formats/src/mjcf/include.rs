//! `<include file="..."/>`: the children of another file's root in its place.
//!
//! Each file is included once, as MuJoCo has it, so that a model is never longer than its files.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use config::Problem;

use crate::{
    files::Files,
    xml::{self, Element, LARGEST_FILE, Log},
};

pub(super) struct Includer<'a> {
    files: &'a Files,
    log: &'a Log,
    seen: BTreeSet<PathBuf>,
    bytes: u64,
}

impl<'a> Includer<'a> {
    /// For a model's own file, which must not be included either.
    pub(super) fn new(root: &Element, files: &'a Files, log: &'a Log) -> Self {
        let own = Path::new(&*root.place().source).canonicalize();
        Self { files, log, seen: own.into_iter().collect(), bytes: 0 }
    }

    /// The element with all that it includes.
    pub(super) fn expand(&mut self, mut element: Element) -> Element {
        let children = std::mem::take(&mut element.children);
        for child in children {
            if child.name == "include" {
                element.children.extend(self.included(&child));
            } else {
                let child = self.expand(child);
                element.children.push(child);
            }
        }
        element
    }

    fn included(&mut self, include: &Element) -> Vec<Element> {
        let Some(file) = include.required("file", self.log) else { return Vec::new() };
        let refuse = |message: String| {
            self.log.problem(Problem { place: include.place_of("file"), message });
            Vec::new()
        };
        let path = match self.files.resolve(file) {
            Ok(path) => path,
            Err(why) => return refuse(format!("file of <include> {why}")),
        };
        let real = path.canonicalize().unwrap_or_else(|_| path.clone());
        if !self.seen.insert(real) {
            return refuse("file of <include> must not be included again".into());
        }
        let read = xml::read(&path).and_then(|text| {
            self.bytes += text.len() as u64;
            xml::parse(&path.display().to_string(), text)
        });
        match read {
            Err(_) if self.bytes > LARGEST_FILE => refuse("too much".into()),
            Ok(_) if self.bytes > LARGEST_FILE => refuse(format!(
                "file of <include>: a model of at most {} MiB expected, got more",
                LARGEST_FILE >> 20
            )),
            Ok(root) => self.expand(root).children,
            // Where the file can't be read, the place is that of the include.
            Err(problems) => {
                for problem in Vec::from(problems) {
                    if problem.place.line == 0 {
                        let message = format!("file of <include>: {problem}");
                        self.log.problem(Problem { place: include.place_of("file"), message });
                    } else {
                        self.log.problem(problem);
                    }
                }
                Vec::new()
            }
        }
    }
}

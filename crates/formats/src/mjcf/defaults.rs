//! Default classes: attributes that elements have where they don't say otherwise.

use std::collections::BTreeMap;

use config::{Problem, shown};

use crate::xml::{Attribute, Element, Log};

/// The outermost class, whatever it's called in the file.
const MAIN: &str = "main";

/// Each has all that is in the classes around it.
const MOST_CLASSES: usize = 1000;

/// Elements whose defaults matter.
const ELEMENTS: [&str; 13] = [
    "geom",
    "joint",
    "mesh",
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "freejoint",
];

/// Several ways to say the same: one of an element's own replaces a default in any of them.
const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];

/// Classes by name; each has the attributes of the one around it, too.
#[derive(Debug, Default)]
pub(super) struct Defaults {
    classes: BTreeMap<String, BTreeMap<String, Vec<Attribute>>>,
}

impl Defaults {
    pub(super) fn read(root: &Element, log: &Log) -> Self {
        let mut defaults = Self::default();
        for element in root.children("default") {
            let main = defaults.classes.get(MAIN).cloned().unwrap_or_default();
            defaults.class(element, MAIN, main, log);
        }
        defaults
    }

    fn class(
        &mut self,
        element: &Element,
        name: &str,
        mut attributes: BTreeMap<String, Vec<Attribute>>,
        log: &Log,
    ) {
        if self.classes.len() > MOST_CLASSES {
            let message = format!("at most {MOST_CLASSES} classes expected, got more");
            log.problem(element.problem(message));
            return;
        }
        for child in element.children.iter().filter(|child| ELEMENTS.contains(&child.name.as_str()))
        {
            let known = attributes.entry(child.name.clone()).or_default();
            *known = merged(&child.attributes, known);
        }
        for inner in element.children("default") {
            if let Some(name) = inner.required("class", log) {
                self.class(inner, name, attributes.clone(), log);
            }
        }
        // A class of several pieces.
        let whole = self.classes.entry(name.into()).or_default();
        for (element, attributes) in attributes {
            let known = whole.entry(element).or_default();
            *known = merged(&attributes, known);
        }
    }

    /// An element with its defaults: those of its own class, or of the class around it.
    pub(super) fn apply(&self, element: &Element, around: &str, log: &Log) -> Element {
        let class = element.get("class").unwrap_or(around);
        self.check(element, "class", log);
        let mut whole = element.clone();
        let class = self.classes.get(class).or_else(|| self.classes.get(MAIN));
        if let Some(defaults) = class.and_then(|class| class.get(&element.name)) {
            whole.attributes = merged(&element.attributes, defaults);
        }
        whole
    }

    /// Complains about an attribute that names a class that isn't there.
    pub(super) fn check(&self, element: &Element, attribute: &str, log: &Log) {
        let Some(class) = element.get(attribute) else { return };
        if class == MAIN || self.classes.contains_key(class) {
            return;
        }
        let likely = log.likely(class, self.classes.keys().map(String::as_str));
        log.problem(Problem {
            place: element.place_of(attribute),
            message: format!(
                "{attribute} of <{}> must be the class of a <default>, got \"{}\"{likely}",
                element.name,
                shown(class)
            ),
        });
    }
}

/// Own attributes, and those defaults that they leave.
fn merged(own: &[Attribute], defaults: &[Attribute]) -> Vec<Attribute> {
    let is_orientation = |it: &Attribute| ORIENTATIONS.contains(&it.name.as_str());
    let turned = own.iter().any(is_orientation);
    let left = defaults.iter().filter(|default| {
        let named = own.iter().any(|it| it.name == default.name);
        !(named || turned && is_orientation(default))
    });
    own.iter().chain(left).cloned().collect()
}

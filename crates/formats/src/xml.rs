//! An XML file as owned elements that know their places, numbers read from it, and the limits that
//! keep a bad file from taking long or much.
//!
//! roxmltree parses. It refuses DTDs, and with them entities of one's own; the further limits are
//! [`LARGEST_FILE`], [`MOST_NODES`] and [`DEEPEST`].

use std::{cell::RefCell, fs::File, io::Read, path::Path, rc::Rc, sync::Arc};

use config::{Place, Problem, Problems, shown};
use nalgebra::Vector3;
use roxmltree::{Document, Error, Node, ParsingOptions};

/// Bytes that a file, or all that belong to a model, may have: hundreds of times what a robot takes.
pub const LARGEST_FILE: u64 = 16 << 20;

/// Elements, texts and comments that a file may have.
const MOST_NODES: u32 = 500_000;

/// How deep elements may stand in each other. Readers descend by calling themselves.
const DEEPEST: usize = 200;

/// What is beyond is this: all formats write "no limit" with numbers of this size and above, and
/// nothing that is computed from it becomes infinite.
pub(crate) const LARGEST: f64 = 1e16;

/// Where lines begin in a file.
#[derive(Debug)]
struct Lines {
    source: Arc<str>,
    text: String,
    starts: Vec<usize>,
}

impl Lines {
    fn new(source: &str, text: String) -> Self {
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1));
        Self { source: source.into(), starts: starts.collect(), text }
    }

    fn place(&self, at: usize) -> Place {
        let line = self.starts.partition_point(|start| *start <= at);
        let start = self.starts[line - 1];
        let column = self.text.get(start..at).map_or(0, |before| before.chars().count()) + 1;
        Place { source: self.source.clone(), line, column }
    }
}

/// An element with all that is in it.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    /// As written, with its prefix: `xacro:include`.
    pub(crate) name: String,
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) children: Vec<Element>,
    /// The text directly in it, trimmed.
    pub(crate) text: String,
    lines: Rc<Lines>,
    at: usize,
    text_at: usize,
}

#[derive(Clone, Debug)]
pub(crate) struct Attribute {
    pub(crate) name: String,
    pub(crate) value: String,
    /// Its own, since it may be from elsewhere: a default of MJCF's.
    lines: Rc<Lines>,
    at: usize,
}

/// Reads a file's bytes as text, none of it beyond the limit.
pub(crate) fn read(path: &Path) -> Result<String, Problems> {
    let source = path.display().to_string();
    let whole = |message: String| Problems::one(Place::whole(&source), message);
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(LARGEST_FILE + 1).read_to_end(&mut bytes))
        .map_err(|error| whole(format!("can't be read: {error}")))?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(whole(format!(
            "a file of at most {} MiB expected, got more",
            LARGEST_FILE >> 20
        )));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let good = String::from_utf8_lossy(&error.as_bytes()[..at]).into_owned();
        let place = Lines::new(&source, good).place(at);
        let byte = error.as_bytes()[at];
        Problems::one(place, format!("text in UTF-8 expected, got the byte 0x{byte:02x}"))
    })
}

/// Parses a text; problems name it `source`.
pub(crate) fn parse(source: &str, text: String) -> Result<Element, Problems> {
    // A byte order mark isn't a character of the text.
    let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
    let lines = Rc::new(Lines::new(source, text));
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(&lines.text, options)
        .map_err(|error| not_xml(&error, &lines))?;
    element(document.root_element(), &lines, 0)
}

fn element(node: Node<'_, '_>, lines: &Rc<Lines>, depth: usize) -> Result<Element, Problems> {
    let at = node.range().start;
    if depth > DEEPEST {
        let message = format!("at most {DEEPEST} elements in each other expected, got more");
        return Err(Problems::one(lines.place(at), message));
    }
    let written = &lines.text[at + 1..];
    let end = written.find(|c: char| c.is_whitespace() || c == '>' || c == '/');
    let attributes = node.attributes().map(|attribute| Attribute {
        name: attribute.name().into(),
        value: attribute.value().into(),
        lines: lines.clone(),
        at: attribute.range_value().start,
    });
    let attributes = attributes.collect();
    let text = node
        .children()
        .find(|child| child.is_text() && child.text().is_some_and(|text| !text.trim().is_empty()));
    let text_at = text.map_or(at, |text| {
        let written = &lines.text[text.range()];
        text.range().start + (written.len() - written.trim_start().len())
    });
    let children = node.children().filter(Node::is_element);
    Ok(Element {
        name: written[..end.unwrap_or(written.len())].into(),
        attributes,
        children: children
            .map(|child| element(child, lines, depth + 1))
            .collect::<Result<_, _>>()?,
        text: text.and_then(|text| text.text()).unwrap_or_default().trim().into(),
        lines: lines.clone(),
        at,
        text_at,
    })
}

fn not_xml(error: &Error, lines: &Lines) -> Problems {
    let find = |what: &str| lines.text.find(what).unwrap_or_default();
    let (place, message) = match error {
        Error::DtdDetected => (
            lines.place(find("<!DOCTYPE")),
            "a file without a DTD expected, got one: take it out, and entities with it".into(),
        ),
        Error::NodesLimitReached => {
            (lines.place(0), format!("at most {MOST_NODES} elements and texts expected, got more"))
        }
        Error::NoRootNode | Error::UnclosedRootNode | Error::UnexpectedEndOfStream => {
            let end = lines.text.trim_end().len();
            (lines.place(end), "not well-formed XML: the file ends too early".into())
        }
        _ => {
            let at = error.pos();
            let place = Place {
                source: lines.source.clone(),
                line: at.row as usize,
                column: at.col as usize,
            };
            // The parser ends its messages with the place.
            let message = error.to_string();
            let message = message.split(" at ").next().unwrap_or_default();
            (place, format!("not well-formed XML: {message}"))
        }
    };
    Problems::one(place, message)
}

impl Element {
    /// The same by another name.
    pub(crate) fn renamed(&self, name: &str) -> Self {
        Self { name: name.into(), ..self.clone() }
    }

    pub(crate) fn place(&self) -> Place {
        self.lines.place(self.at)
    }

    pub(crate) fn problem(&self, message: impl Into<String>) -> Problem {
        Problem { place: self.place(), message: message.into() }
    }

    pub(crate) fn children<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Self> + 'a {
        self.children.iter().filter(move |child| child.name == name)
    }

    pub(crate) fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.attribute(name).is_some()
    }

    pub(crate) fn get(&self, name: &str) -> Option<&str> {
        self.attribute(name).map(|attribute| attribute.value.as_str())
    }

    fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    pub(crate) fn place_of(&self, attribute: &str) -> Place {
        self.attribute(attribute).map_or_else(|| self.place(), |it| it.lines.place(it.at))
    }

    /// A number in an attribute.
    pub(crate) fn number(&self, name: &str, log: &Log) -> Option<f64> {
        self.numbers::<1>(name, log).map(|[number]| number)
    }

    /// So many numbers in an attribute.
    pub(crate) fn numbers<const N: usize>(&self, name: &str, log: &Log) -> Option<[f64; N]> {
        let list = self.list(name, log)?;
        self.exactly(name, &list, log)
    }

    pub(crate) fn vector(&self, name: &str, log: &Log) -> Option<Vector3<f64>> {
        self.numbers::<3>(name, log).map(Vector3::from)
    }

    /// Any count of numbers in an attribute.
    pub(crate) fn list(&self, name: &str, log: &Log) -> Option<Vec<f64>> {
        let attribute = self.attribute(name)?;
        numbers(
            &attribute.value,
            &format!("{name} of <{}>", self.name),
            |offset| attribute.lines.place(attribute.at + offset),
            log,
        )
    }

    fn exactly<const N: usize>(&self, name: &str, list: &[f64], log: &Log) -> Option<[f64; N]> {
        let found = list.try_into().ok();
        if found.is_none() {
            log.problem(Problem {
                place: self.place_of(name),
                message: format!(
                    "{name} of <{}> must have {}, got {}",
                    self.name,
                    counted(N),
                    list.len()
                ),
            });
        }
        found
    }

    /// The numbers that are the text of a child, as SDF has them.
    pub(crate) fn numbers_in<const N: usize>(&self, child: &str, log: &Log) -> Option<[f64; N]> {
        self.child(child)?.own_numbers(log)
    }

    pub(crate) fn number_in(&self, child: &str, log: &Log) -> Option<f64> {
        self.numbers_in::<1>(child, log).map(|[number]| number)
    }

    /// Any count of numbers that are its text.
    pub(crate) fn own_list(&self, log: &Log) -> Option<Vec<f64>> {
        let place = |offset| self.lines.place(self.text_at + offset);
        numbers(&self.text, &format!("<{}>", self.name), place, log)
    }

    pub(crate) fn own_numbers<const N: usize>(&self, log: &Log) -> Option<[f64; N]> {
        let list = self.own_list(log)?;
        let found = list.as_slice().try_into().ok();
        if found.is_none() {
            let (wanted, found) = (counted(N), list.len());
            log.problem(self.problem(format!("<{}> must have {wanted}, got {found}", self.name)));
        }
        found
    }

    /// An attribute that has to be there.
    pub(crate) fn required(&self, name: &str, log: &Log) -> Option<&str> {
        let found = self.get(name).map(str::trim).filter(|value| !value.is_empty());
        if found.is_none() {
            let known = self.get("name").map(|own| format!(" '{}'", shown(own)));
            log.problem(self.problem(format!(
                "<{}>{} must have {name}=\"...\", got none",
                self.name,
                known.unwrap_or_default()
            )));
        }
        found
    }

    /// One word of several.
    pub(crate) fn word<'w>(&self, name: &str, words: &[&'w str], log: &Log) -> Option<&'w str> {
        let value = self.get(name)?;
        let found = words.iter().find(|word| **word == value.trim()).copied();
        if found.is_none() {
            log.problem(Problem {
                place: self.place_of(name),
                message: format!(
                    "{name} of <{}> must be one of {}, got \"{}\"",
                    self.name,
                    words.join(", "),
                    shown(value)
                ),
            });
        }
        found
    }
}

fn counted(n: usize) -> String {
    if n == 1 { "one number".into() } else { format!("{n} numbers") }
}

/// Numbers between spaces. One that goes on with a second point, `-1.57.`, is read as what stands
/// before it, which others do in silence; everything else that isn't a number is a problem.
fn numbers(text: &str, what: &str, place: impl Fn(usize) -> Place, log: &Log) -> Option<Vec<f64>> {
    let mut list = Vec::new();
    for word in text.split_ascii_whitespace() {
        let offset = word.as_ptr() as usize - text.as_ptr() as usize;
        let refuse = |message: String| log.problem(Problem { place: place(offset), message });
        let number = match word.parse::<f64>() {
            Ok(number) => number,
            Err(_) => match word.strip_suffix('.').and_then(|word| word.parse::<f64>().ok()) {
                Some(number) => {
                    let at = place(offset);
                    log.chose(
                        &format!("{what}: `{}`, which isn't a number", shown(word)),
                        &format!("{number} ({}:{})", at.line, at.column),
                    );
                    number
                }
                None => {
                    let hint = match () {
                        () if word.contains("${") || word.contains("$(") => {
                            " (a leftover of xacro: run xacro first)"
                        }
                        () if word.contains(',') => " (numbers stand between spaces, with points)",
                        () => "",
                    };
                    refuse(format!("{what} must be a number, got \"{}\"{hint}", shown(word)));
                    return None;
                }
            },
        };
        if !number.is_finite() {
            refuse(format!("{what} must be a finite number, got {}", shown(word)));
            return None;
        }
        list.push(number.clamp(-LARGEST, LARGEST));
    }
    Some(list)
}

/// What a reader found wrong, left out or chose on its way.
#[derive(Debug, Default)]
pub(crate) struct Log {
    problems: RefCell<Vec<Problem>>,
    pub(crate) report: RefCell<crate::report::Report>,
}

impl Log {
    /// One more problem than is shown tells that there are more.
    pub(crate) fn problem(&self, problem: Problem) {
        let mut problems = self.problems.borrow_mut();
        if problems.len() <= config::MOST_PROBLEMS {
            problems.push(problem);
        }
    }

    /// What `element` is, a path of names, isn't carried over.
    pub(crate) fn left_out(&self, element: &str, place: Place) {
        self.left_out_since(element, place, "");
    }

    /// As [`Log::left_out`], with the reason.
    pub(crate) fn left_out_since(&self, element: &str, place: Place, why: &str) {
        self.report.borrow_mut().left_out(element, place, why);
    }

    /// As [`Log::left_out`], of what is no part of a robot: looks, and settings of a simulator.
    pub(crate) fn set_aside(&self, element: &str, place: Place) {
        self.report.borrow_mut().set_aside(element, place);
    }

    pub(crate) fn chose(&self, what: &str, value: &str) {
        self.report.borrow_mut().chose(what, value);
    }

    /// All problems so far, if there are any.
    pub(crate) fn result(&self) -> Result<(), Problems> {
        let problems = self.problems.borrow();
        if problems.is_empty() { Ok(()) } else { Err(Problems::new(problems.clone())) }
    }
}

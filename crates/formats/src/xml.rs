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

/// Namespaces that a file may use without declaring them.
const MOST_PREFIXES: usize = 9;

/// Attributes that an element may have: a few times what MJCF's have.
const MOST_ATTRIBUTES: usize = 200;

/// How deep elements may stand in each other. Readers descend by calling themselves.
const DEEPEST: usize = 200;

/// What is beyond is this: all formats write "no limit" with numbers of this size and above, and
/// nothing that is computed from it becomes infinite.
pub(crate) const LARGEST: f64 = 1e16;

/// Where lines begin in a file.
#[derive(Clone, Debug)]
struct Lines {
    source: Arc<str>,
    text: Rc<str>,
    starts: Vec<usize>,
    /// Where something was written into the text that isn't in the file, and how long it is.
    inserted: (usize, usize),
}

impl Lines {
    fn new(source: &str, text: String) -> Self {
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1));
        let starts = starts.collect();
        Self { source: source.into(), starts, text: text.into(), inserted: (0, 0) }
    }

    /// Declares a namespace in the root, where a file uses one without, as many do. Whether it could.
    fn declare(&mut self, prefix: &str) -> bool {
        let is_start =
            |at: usize| self.text[at + 1..].starts_with(|c: char| c.is_alphabetic() || c == '_');
        let root = self.text.match_indices('<').map(|(at, _)| at).find(|at| is_start(*at));
        let Some(root) = root else { return false };
        let end = self.text[root..].find(|c: char| c.is_whitespace() || c == '>' || c == '/');
        let Some(end) = end else { return false };
        let declaration = format!(" xmlns:{prefix}=\"{prefix}\"");
        let mut text = self.text.to_string();
        text.insert_str(root + end, &declaration);
        let inserted = (root + end, self.inserted.1 + declaration.len());
        *self = Self { inserted, ..Self::new(&self.source, text) };
        true
    }

    fn place(&self, at: usize) -> Place {
        let line = self.starts.partition_point(|start| *start <= at);
        let start = self.starts[line - 1];
        let mut column = self.text.get(start..at).map_or(0, |before| before.chars().count()) + 1;
        let (inserted, length) = self.inserted;
        if inserted >= start && at >= inserted + length {
            column -= length;
        }
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
    let mut lines = Lines::new(source, text);
    if let Some(at) = crowded_element(&lines.text) {
        let message = format!("at most {MOST_ATTRIBUTES} attributes expected, got more");
        return Err(Problems::one(lines.place(at), message));
    }
    for _ in 0..MOST_PREFIXES {
        let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
        let prefix = match Document::parse_with_options(&lines.text, options) {
            Ok(document) => {
                // The text is the elements' own, so that it's theirs together.
                let root = document.root_element();
                let shared = Rc::new(lines.clone());
                return element(root, &shared, 0);
            }
            Err(Error::UnknownNamespace(prefix, _)) => prefix,
            Err(error) => return Err(not_xml(&error, &lines)),
        };
        if !lines.declare(&prefix) {
            break;
        }
    }
    let message = "namespaces must be declared, as in xmlns:drake=\"...\"";
    Err(Problems::one(lines.place(0), message))
}

/// Where an element begins that has too many attributes. The parser compares each with all others.
fn crowded_element(text: &str) -> Option<usize> {
    let mut at = 0;
    while let Some(start) = text[at..].find('<').map(|found| at + found) {
        let rest = &text[start..];
        // Text that isn't an element's may have any number of these signs in it.
        let other = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
        if let Some((opening, closing)) = other.iter().find(|(it, _)| rest.starts_with(it)) {
            let end = rest[opening.len()..].find(closing)?;
            at = start + opening.len() + end + closing.len();
            continue;
        }
        let (mut quote, mut attributes, mut end) = (None, 0, rest.len());
        for (i, c) in rest.char_indices().skip(1) {
            match (quote, c) {
                (None, '>' | '<') => {
                    end = i;
                    break;
                }
                (None, '=') => attributes += 1,
                (None, '"' | '\'') => quote = Some(c),
                (Some(open), c) if open == c => quote = None,
                _ => {}
            }
        }
        if attributes > MOST_ATTRIBUTES {
            return Some(start);
        }
        at = start + end;
    }
    None
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
            // The parser has the place in its messages, too.
            let message = error.to_string().replace(&format!(" at {at}"), "");
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

    /// The first of a list, which has to be long enough.
    fn exactly<const N: usize>(&self, name: &str, list: &[f64], log: &Log) -> Option<[f64; N]> {
        let place = self.place_of(name);
        first(list, &format!("{name} of <{}>", self.name), place, log)
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
        first(&self.own_list(log)?, &format!("<{}>", self.name), self.place(), log)
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

/// Of more numbers than there should be the first ones, as others take them in silence.
fn first<const N: usize>(list: &[f64], what: &str, place: Place, log: &Log) -> Option<[f64; N]> {
    let found = list.first_chunk::<N>().copied();
    if found.is_none() {
        let message = format!("{what} must have {}, got {}", counted(N), list.len());
        log.problem(Problem { place, message });
    } else if list.len() > N {
        log.chose(
            &format!("{what} with {} numbers: the first {N}", list.len()),
            &format!("line {}", place.line),
        );
    }
    found
}

fn counted(n: usize) -> String {
    if n == 1 { "one number".into() } else { format!("{n} numbers") }
}

/// Numbers between spaces. What others read in silence is read, and said: commas between them, and one
/// that goes on with a second point, `-1.57.`. Everything else that isn't a number is a problem.
fn numbers(text: &str, what: &str, place: impl Fn(usize) -> Place, log: &Log) -> Option<Vec<f64>> {
    let is_gap = |c: char| c.is_ascii_whitespace() || c == ',';
    if let Some(comma) = text.find(',') {
        let place = place(comma);
        log.chose(&format!("{what} with commas: they are spaces"), &format!("line {}", place.line));
    }
    let mut list = Vec::new();
    for word in text.split(is_gap).filter(|word| !word.is_empty()) {
        let offset = word.as_ptr() as usize - text.as_ptr() as usize;
        let refuse = |message: String| log.problem(Problem { place: place(offset), message });
        let twice = || word.strip_suffix('.').and_then(|word| word.parse::<f64>().ok());
        let Some(number) = word.parse::<f64>().ok().or_else(twice) else {
            let xacro = word.contains("${") || word.contains("$(");
            let hint = if xacro { " (a leftover of xacro: run xacro first)" } else { "" };
            refuse(format!("{what} must be a number, got \"{}\"{hint}", shown(word)));
            return None;
        };
        if !number.is_finite() {
            refuse(format!("{what} must be a finite number, got {}", shown(word)));
            return None;
        }
        if word.parse::<f64>().is_err() {
            let line = place(offset).line;
            let read = format!("{what}: `{}`, which isn't a number: {number}", shown(word));
            log.chose(&read, &format!("line {line}"));
        }
        list.push(number.clamp(-LARGEST, LARGEST));
    }
    Some(list)
}

/// Names that are compared with one that isn't known.
const MOST_NAMES: usize = 1000;

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

    /// The name among those known that was most likely meant, behind a comma. Looking for it takes
    /// time, so it's looked for as long as problems are kept.
    pub(crate) fn likely<'n>(&self, name: &str, known: impl Iterator<Item = &'n str>) -> String {
        if self.problems.borrow().len() > config::MOST_PROBLEMS {
            return String::new();
        }
        config::suggestion(name, known.take(MOST_NAMES))
    }

    /// All problems so far, if there are any.
    pub(crate) fn result(&self) -> Result<(), Problems> {
        let problems = self.problems.borrow();
        if problems.is_empty() { Ok(()) } else { Err(Problems::new(problems.clone())) }
    }
}

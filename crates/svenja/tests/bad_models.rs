//! What is said about broken models: the files of `tests/models/bad`, which begin with the messages
//! that they get, and files that no repository would keep.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{
    fmt::Write as _,
    fs::{self, File},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use svenja::Morphology;
use tempfile::TempDir;

/// Milliseconds are usual; what goes wrong with the square of a length takes minutes.
const PATIENCE: Duration = Duration::from_secs(5);

/// What is said about a file, with `FILE` for its path; nothing about a good one.
fn complaint(path: &Path) -> String {
    let start = Instant::now();
    let complaint = match Morphology::open(path) {
        Ok(_) => String::new(),
        Err(problems) => problems.to_string(),
    };
    let time = start.elapsed();
    assert!(time < PATIENCE, "{} took {time:?}", path.display());
    complaint.replace(&path.display().to_string(), "FILE")
}

fn files() -> Vec<PathBuf> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/models/bad");
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let mut files: Vec<_> = files.filter(|path| path.extension().unwrap() == "toml").collect();
    files.sort();
    files
}

/// The first lines of a file: `# expect: MESSAGE`, one a message.
fn expected(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let messages: Vec<_> = text.lines().map_while(|line| line.strip_prefix("# expect: ")).collect();
    messages.join("\n")
}

/// Lines of one that aren't in the other, and the other way round.
fn difference(expected: &str, got: &str) -> String {
    let mut difference = String::new();
    for line in expected.lines().filter(|line| !got.lines().any(|other| other == *line)) {
        writeln!(difference, "  - {line}").unwrap();
    }
    for line in got.lines().filter(|line| !expected.lines().any(|other| other == *line)) {
        writeln!(difference, "  + {line}").unwrap();
    }
    difference
}

#[test]
fn every_broken_model_gets_exactly_the_messages_that_it_expects() {
    let files = files();
    assert!(files.len() >= 40, "only {} files", files.len());
    let mut report = String::new();
    for path in files {
        let (expected, got) = (expected(&path), complaint(&path));
        assert!(!expected.is_empty(), "{} expects nothing", path.display());
        if expected != got {
            let difference = difference(&expected, &got);
            writeln!(report, "{} (- expected, + got)\n{difference}", path.display()).unwrap();
        }
    }
    assert!(report.is_empty(), "\n{report}");
}

/// The worm that most of the broken ones were made from.
#[test]
fn without_a_mistake_the_worm_is_a_model() {
    let good = r#"
        name = "worm"
        heading = { body = "head" }
        sensors = ["neck"]
        actuators = ["neck"]
        feet = ["head"]
        servo.neck = { speed_limit_rad_s = 1.0, torque_limit_nm = 2.0 }

        [[body]]
        name = "head"
        mass_kg = 1.0
        shape = { kind = "sphere", radius_m = 0.1 }

        [[body]]
        name = "tail"
        mass_kg = 1.0
        shape = { kind = "sphere", radius_m = 0.1 }

        [[joint]]
        name = "neck"
        kind = "hinge"
        parent = "head"
        child = "tail"
        anchor_m = [0.0, 0.1, 0.0]
        axes = [{ about = "x", range_deg = [-30.0, 30.0], servo = "neck" }]
    "#;
    Morphology::parse("worm", good).unwrap();
}

/// Each number of a model in turn is no number: nothing that follows from it is a second mistake.
#[test]
fn one_mistake_is_one_message() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models");
    let mut n_numbers = 0;
    for file in ["svenja.toml", "quadruped.toml", "biped.toml"] {
        let text = fs::read_to_string(Path::new(folder).join(file)).unwrap();
        let is_part = |c: char| c.is_ascii_alphanumeric() || "._+-\"#".contains(c);
        let mut at = 0;
        for word in text.split_inclusive(|c| !is_part(c)) {
            let number = word.trim_end_matches(|c| !is_part(c));
            let line = &text[text[..at].rfind('\n').map_or(0, |newline| newline + 1)..at];
            let is_text = line.contains('#') || line.starts_with("description");
            if number.parse::<f64>().is_ok() && line.contains('=') && !is_text {
                let broken = format!("{}true{}", &text[..at], &text[at + number.len()..]);
                let said = Morphology::parse(file, &broken).map(|_| ()).unwrap_err().to_string();
                assert_eq!(said.lines().count(), 1, "{number} after {line}: {said}");
                n_numbers += 1;
            }
            at += word.len();
        }
    }
    assert!(n_numbers > 300, "{n_numbers}");
}

/// A file with some bytes, and what is said about it.
fn of_bytes(bytes: impl AsRef<[u8]>) -> String {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("model.toml");
    fs::write(&path, bytes).unwrap();
    complaint(&path)
}

const NOTHING_IN_IT: &str = "FILE:1:1: 'heading' is missing: a table\n\
                             FILE:1:1: 'name' is missing: a text\n\
                             FILE:1:1: a robot must have a [[body]], got none";

#[test]
fn an_empty_file_lacks_what_a_model_has() {
    assert_eq!(of_bytes(""), NOTHING_IN_IT);
    assert_eq!(of_bytes("\u{feff}"), NOTHING_IN_IT, "a byte order mark alone");
    assert_eq!(of_bytes("\n\r\n# nothing\n"), NOTHING_IN_IT);
}

#[test]
fn what_cannot_be_read_has_no_line() {
    let folder = TempDir::new().unwrap();
    assert_eq!(complaint(folder.path()), "FILE: can't be read: Is a directory (os error 21)");
    let missing = folder.path().join("model.toml");
    let expected = "FILE: can't be read: No such file or directory (os error 2)";
    assert_eq!(complaint(&missing), expected);
}

#[test]
fn a_huge_file_is_not_read() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("model.toml");
    File::create(&path).unwrap().set_len(100_000_000).unwrap();
    let expected = "FILE:1:1: a TOML file of at most 1 MiB expected, got more";
    assert_eq!(complaint(&path), expected);
    assert_eq!(of_bytes("#".repeat(1 << 20)), NOTHING_IN_IT, "1 MiB");
    assert_eq!(of_bytes("#".repeat((1 << 20) + 1)), expected, "one byte more");
}

/// A place behind characters of two, three and four bytes counts characters.
#[test]
fn text_that_is_not_utf_8_is_shown_by_its_first_bad_byte() {
    let bad = [b"name = \"worm\"\n# \xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80".as_slice(), b"\xe4\n"];
    assert_eq!(of_bytes(bad.concat()), "FILE:2:6: text in UTF-8 expected, got the byte 0xe4");
    let utf_16 = b"\xff\xfen\0a\0m\0e\0";
    assert_eq!(of_bytes(utf_16), "FILE:1:1: text in UTF-8 expected, got the byte 0xff");
    let cut_off = b"# \xe2\x82";
    assert_eq!(of_bytes(cut_off), "FILE:1:3: text in UTF-8 expected, got the byte 0xe2");
}

#[test]
fn binary_junk_is_refused() {
    let elf = b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0\x03\0>\0\x01\0\0\0\x40\xf5";
    assert_eq!(of_bytes(elf), "FILE:1:26: text in UTF-8 expected, got the byte 0xf5");
    let zeros = of_bytes([0; 10_000]);
    assert!(zeros.starts_with("FILE:1:1: not TOML: "), "{zeros}");
    // Xorshift: all bytes, the same at every run.
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state as u8
    };
    let junk: Vec<_> = (0..1 << 20).map(|_| random()).collect();
    let ascii: Vec<_> = junk.iter().map(|byte| byte & 0x7f).collect();
    assert!(of_bytes(junk).contains("text in UTF-8 expected"));
    let ascii = of_bytes(ascii);
    assert!(ascii.starts_with("FILE: more than 100 problems, among them:\nFILE:1:"), "{ascii}");
    assert_eq!(ascii.lines().count(), 101);
}

#[test]
fn what_is_nested_deeply_is_refused() {
    const N: usize = 500_000;
    let deep = "at most 32 tables and lists within each other expected, got more";
    let list = format!("a = {}{}", "[".repeat(N), "]".repeat(N));
    assert_eq!(of_bytes(list), format!("FILE:1:85: {deep}"));
    let unclosed = of_bytes(format!("a = {}", "[".repeat(N)));
    assert_eq!(unclosed, format!("FILE:1:85: {deep}"));
    let tables = of_bytes(format!("a = {}", "{a=".repeat(N / 2)));
    assert_eq!(tables, format!("FILE:1:245: {deep}"));
    assert_eq!(of_bytes(format!("{}a = 1", "a.".repeat(N))), format!("FILE:1:1: {deep}"));
    assert_eq!(of_bytes(format!("[{}a]", "a.".repeat(N))), format!("FILE:1:1: {deep}"));
    // Below the parser's own limits, which multiply: some six thousand levels.
    let keys = ["a"; 79].join(".");
    let multiplied =
        format!("[{keys}]\n{keys} = {}1{}", format!("{{{keys} = ").repeat(78), "}".repeat(78));
    assert_eq!(of_bytes(multiplied), format!("FILE:1:66: {deep}"));
}

#[test]
fn many_parts_are_refused() {
    let bodies = "[[body]]\n".repeat((1 << 20) / 9);
    let missing = "FILE:1:1: 'heading' is missing: a table\nFILE:1:1: 'name' is missing: a text\n";
    let expected = format!("{missing}FILE:1:1: body must be at most 1000 tables, got 116508");
    assert_eq!(of_bytes(bodies), expected);
    let mut servos = String::new();
    for i in 0..30_000 {
        writeln!(servos, "servo.s{i} = {{}}").unwrap();
    }
    let expected = format!("{missing}FILE:1:1: servo must be at most 1000 tables, got 30000");
    assert_eq!(of_bytes(servos), expected);
}

const HEAD: &str = "name = 'worm'\n\
                    heading.body = 'head'\n\
                    body = [{ name = 'head', mass_kg = 1, shape.kind = 'sphere', shape.radius_m = 1 }]\n";

/// The first of a hundred messages, and how many there are.
fn first_of_many(text: &str) -> String {
    let complaint = of_bytes(text);
    let mut lines = complaint.lines();
    assert_eq!(lines.next(), Some("FILE: more than 100 problems, among them:"));
    let first = lines.next().unwrap().to_owned();
    assert_eq!(lines.count(), 99);
    first
}

#[test]
fn many_names_are_looked_up_in_time() {
    let unknown = format!("{HEAD}sensors = [{}]", "'a',".repeat(250_000));
    let expected = "FILE:4:12: sensors[0] must be the name of a group, of a joint or of a joint's \
                    axis (\"joint/axis\"), got \"a\"";
    assert_eq!(first_of_many(&unknown), expected);
    let repeated = format!("{HEAD}feet = [{}]", "'head',".repeat(140_000));
    let expected = "FILE:4:16: feet[1] must not repeat a body, got \"head\"";
    assert_eq!(first_of_many(&repeated), expected);
    let keys: String = (0..100_000).map(|i| format!("k{i}=1\n")).collect();
    assert!(first_of_many(&format!("{HEAD}{keys}")).starts_with("FILE:4:1: unknown key 'k0', "));
}

/// Comparing two of them letter by letter would take half an hour.
#[test]
fn long_names_are_refused() {
    let (a, b) = ("a".repeat(400_000), "ab".repeat(200_000));
    let text = HEAD.replacen("'head'", &format!("'{a}'"), 1).replace("'head'", &format!("'{b}'"));
    let shown = |name: &str| format!("got \"{}...\"", &name[..60]);
    let expected = format!(
        "FILE:2:16: heading: body must be 1 to 60 characters on one line, without /, {}\n\
         FILE:3:18: body[0]: name must be 1 to 60 characters on one line, without /, {}",
        shown(&a),
        shown(&b)
    );
    assert_eq!(of_bytes(text), expected);
    let key = format!("{HEAD}\"{a}\" = 1");
    assert!(of_bytes(key).starts_with(&format!("FILE:4:1: unknown key '{}...', ", &a[..60])));
}

/// Each name would become one of a megabyte.
#[test]
fn a_mirror_cannot_make_long_names() {
    let text = format!("mirror = {{ from = 'a', to = '{}' }}\n{HEAD}", "b".repeat(900_000));
    let expected = "FILE:1:29: mirror: to must be 1 to 60 characters on one line, without /, got";
    assert!(of_bytes(text).starts_with(expected));
}

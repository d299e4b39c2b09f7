//! `manifest.json`: what a run is made of: programs, models, seeds, cells.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Component, Path},
};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use super::{Difference, Error, Published};

/// Version of the run folder's format.
pub(crate) const FORMAT: u64 = 1;
/// Version of a published folder's format: readers of runs alone refuse it.
pub(crate) const PUBLISHED_FORMAT: u64 = 2;

/// The folder of the copies of models.
pub const MODELS: &str = "models";
/// The folder of the copies of policies that cells start from.
pub const POLICIES: &str = "policies";

/// What a run is made of. Written when the run folder appears, and when it gets more cells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of the run folder's format.
    pub(crate) format: u64,
    /// Version of the itarl that made it.
    pub itarl: String,
    /// The physics engine that it was made with.
    pub bullet: Bullet,
    /// Hash of all settings in `experiment.toml` but `learning.updates`.
    pub settings_xxh3: Hash,
    /// The model files, in `models/`.
    pub models: Vec<FileCopy>,
    /// The files of policies that cells start from, in `policies/`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub policies: Vec<FileCopy>,
    /// The seeds, in the order of the experiment.
    pub seeds: Vec<u64>,
    /// The cells, in the order of their indices.
    pub cells: Vec<Cell>,
    /// What was published of each cell; none in a run's own folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published: Option<Published>,
}

/// A physics engine: results are the same bits for the same one only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bullet {
    /// The version as Bullet counts it: 325 is 3.25.
    pub version: u32,
    /// The precision of its numbers.
    pub precision: Precision,
}

/// The precision of Bullet's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Numbers have 32 bits.
    Single,
    /// Numbers have 64 bits.
    Double,
}

/// A copy of a file that settings name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileCopy {
    /// Its name in its folder.
    pub file: String,
    /// The hash of its bytes.
    pub xxh3: Hash,
}

/// One training instance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Its number, from 0.
    pub index: usize,
    /// The swept settings, as its folder is named; `base` if nothing is swept.
    pub setting: String,
    /// The seed that its random numbers come from.
    pub seed: u64,
}

/// XXH3, 64 bits; 16 hexadecimal digits in JSON, whose numbers hold 53 bits in many readers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hash(pub u64);

impl Serialize for Hash {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{:016x}", self.0))
    }
}

impl<'de> Deserialize<'de> for Hash {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let is_hex = text.len() == 16 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        let number = u64::from_str_radix(&text, 16).ok().filter(|_| is_hex);
        number.map(Self).ok_or_else(|| {
            de::Error::invalid_value(de::Unexpected::Str(&text), &"16 hexadecimal digits")
        })
    }
}

/// What is read first: another version may have other keys.
#[derive(Deserialize)]
struct Format {
    format: u64,
}

impl Manifest {
    /// The file's bytes, the same ones for the same content.
    pub(crate) fn encode(&self) -> Result<Vec<u8>, Error> {
        let mut bytes = serde_json::to_vec_pretty(self).map_err(|error| {
            Error::argument("Run::create", "the manifest", "what JSON can hold", error)
        })?;
        bytes.push(b'\n');
        Ok(bytes)
    }

    /// The content of a file's bytes. `path` is for the messages.
    pub(crate) fn decode(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let damaged = |error: serde_json::Error| Error::damaged(path, error.to_string());
        let Format { format: found } = serde_json::from_slice(bytes).map_err(damaged)?;
        if ![FORMAT, PUBLISHED_FORMAT].contains(&found) {
            return Err(Error::Version { path: path.into(), found, expected: FORMAT });
        }
        let manifest: Self = serde_json::from_slice(bytes).map_err(damaged)?;
        manifest.check().map_err(|what| Error::damaged(path, what))?;
        Ok(manifest)
    }

    /// What the types don't say: indices count up, names stay in their folders.
    pub(crate) fn check(&self) -> Result<(), String> {
        let mut cells = BTreeMap::new();
        for (i, cell) in self.cells.iter().enumerate() {
            if cell.index != i {
                return Err(format!("cell {i} has index {}", cell.index));
            }
            if !is_a_name(&cell.setting) {
                return Err(format!("cell {i}: {:?} can't be a folder's name", cell.setting));
            }
            if let Some(other) = cells.insert((&cell.setting, cell.seed), i) {
                return Err(format!("cells {other} and {i} have the same setting and seed"));
            }
        }
        check_copies("model", "models", &self.models)?;
        check_copies("policy", "policies", &self.policies)?;
        let is_published = self.published.is_some();
        if is_published != (self.format == PUBLISHED_FORMAT) {
            return Err(format!("format {} and `published` don't go together", self.format));
        }
        self.published.as_ref().map_or(Ok(()), |published| published.check(self.cells.len()))
    }

    /// The hashes of all copies, by where they are in the run.
    fn hashes(&self) -> BTreeMap<String, u64> {
        let folders = [(MODELS, &self.models), (POLICIES, &self.policies)];
        let copies = folders.iter().flat_map(|(folder, copies)| {
            copies.iter().map(move |copy| (format!("{folder}/{}", copy.file), copy.xxh3.0))
        });
        copies.collect()
    }

    /// In what another run differs, its settings aside. The version of itarl may change: what
    /// can't be read any more has a format version of its own.
    pub(crate) fn differences(&self, here: &Self) -> Vec<Difference> {
        let mut differences = self.bullet.differences(here.bullet);
        let (of_there, of_here) = (self.hashes(), here.hashes());
        let mut compare = |what: String, there: Option<String>, here: Option<String>| {
            if there != here {
                let [there, here] =
                    [there, here].map(|value| value.unwrap_or_else(|| "nothing".into()));
                differences.push(Difference { what, there, here });
            }
        };
        for file in of_there.keys().chain(of_here.keys()).collect::<BTreeSet<_>>() {
            let hash = |hashes: &BTreeMap<_, u64>| Some(format!("XXH3 {:016x}", hashes.get(file)?));
            compare(file.clone(), hash(&of_there), hash(&of_here));
        }
        // Whatever their order: cells that a run got later are behind the others.
        let folders = |manifest: &Self| manifest.cells.iter().map(Cell::folder).collect();
        let [there, beside]: [BTreeSet<String>; 2] = [folders(self), folders(here)];
        for cell in self.cells.iter().filter(|cell| !beside.contains(&cell.folder())) {
            compare(format!("cell {}", cell.index), Some(cell.folder()), None);
        }
        for cell in here.cells.iter().filter(|cell| !there.contains(&cell.folder())) {
            compare(format!("cell {}", cell.index), None, Some(cell.folder()));
        }
        let seeds = |manifest: &Self| Some(format!("{:?}", manifest.seeds));
        compare("seeds".into(), seeds(self), seeds(here));
        differences
    }

    /// What of it isn't in another one, or isn't the same there.
    pub(crate) fn lost(&self, here: &Self) -> Vec<Difference> {
        let mut differences = self.differences(here);
        differences.retain(|it| it.there != "nothing" && it.what != "seeds");
        differences
    }
}

/// That copies have names of their own, in their folder.
fn check_copies(one: &str, several: &str, copies: &[FileCopy]) -> Result<(), String> {
    let mut names = BTreeSet::new();
    for FileCopy { file, .. } in copies {
        if !is_a_name(file) {
            return Err(format!("{one} {file:?} can't be a file's name"));
        }
        if !names.insert(file) {
            return Err(format!("two {several} are called {file:?}"));
        }
    }
    Ok(())
}

impl Bullet {
    pub(crate) fn differences(self, here: Self) -> Vec<Difference> {
        if self == here {
            return Vec::new();
        }
        let [there, here] = [self, here].map(|bullet| {
            format!("{} in {:?} precision", bullet.version, bullet.precision).to_lowercase()
        });
        vec![Difference { what: "Bullet".into(), there, here }]
    }
}

impl Cell {
    /// `<setting>/seed=<n>`, below `cells/`.
    #[must_use]
    pub fn folder(&self) -> String {
        format!("{}/seed={}", self.setting, self.seed)
    }
}

/// Whether it names something in a folder and not elsewhere.
fn is_a_name(text: &str) -> bool {
    let mut components = Path::new(text).components();
    let first = components.next();
    // Path drops a slash or a dot at the end, and so would make two names one.
    matches!(first, Some(Component::Normal(name)) if name == text)
        && components.next().is_none()
        && !text.contains('\0')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest() -> Manifest {
        let cell = |index, setting: &str, seed| Cell { index, setting: setting.into(), seed };
        Manifest {
            format: FORMAT,
            itarl: "0.1.0".into(),
            bullet: Bullet { version: 325, precision: Precision::Single },
            settings_xxh3: Hash(0x0123_4567_89ab_cdef),
            models: vec![FileCopy { file: "svenja.toml".into(), xxh3: Hash(1) }],
            policies: Vec::new(),
            seeds: vec![1, 2],
            cells: vec![cell(0, "xi=0.75", 1), cell(1, "xi=0.75", 2)],
            published: None,
        }
    }

    fn decode(text: &str) -> Result<Manifest, Error> {
        Manifest::decode(Path::new("manifest.json"), text.as_bytes())
    }

    fn text() -> String {
        String::from_utf8(manifest().encode().unwrap()).unwrap()
    }

    #[test]
    fn what_was_encoded_is_decoded() {
        assert_eq!(decode(&text()).unwrap(), manifest());
        assert!(text().contains("\"settings_xxh3\": \"0123456789abcdef\""));
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        let refused = |from: &str, to: &str, message: &str| {
            assert!(text().contains(from), "{from}");
            let error = decode(&text().replacen(from, to, 1)).unwrap_err().to_string();
            assert_eq!(error, format!("manifest.json: {message}"));
        };
        refused("325", "x", "damaged: expected value at line 5 column 16");
        refused(
            "\"format\": 1",
            "\"format\": 3, \"more\": 1",
            "format version 3, and this program reads 1: go on with the itarl that wrote it",
        );
        refused(
            "\"format\": 1",
            "\"format\": 2",
            "damaged: format 2 and `published` don't go together",
        );
        refused("\"index\": 1", "\"index\": 3", "damaged: cell 1 has index 3");
        for name in ["..", "/etc", "a/b", "a/", ".", ""] {
            let message = format!("damaged: cell 0: {name:?} can't be a folder's name");
            refused("xi=0.75", name, &message);
        }
        refused("svenja.toml", "", "damaged: model \"\" can't be a file's name");
        refused(
            "\"seed\": 2",
            "\"seed\": 1",
            "damaged: cells 0 and 1 have the same setting and seed",
        );
        let error = decode(&text().replacen("89ab", "89+b", 1)).unwrap_err().to_string();
        assert!(error.contains("expected 16 hexadecimal digits at line 8"), "{error}");
        assert!(matches!(decode(&text()[..100]), Err(Error::Damaged { .. })));
    }

    /// Manifests of runs whose cells start from no file are as they were before there were any.
    #[test]
    fn policies_are_there_where_cells_start_from_some() {
        assert!(!text().contains("policies"));
        let mut with = manifest();
        let copy = FileCopy { file: "a.safetensors".into(), xxh3: Hash(3) };
        with.policies = vec![copy.clone()];
        let bytes = with.encode().unwrap();
        assert_eq!(Manifest::decode(Path::new("m"), &bytes).unwrap(), with);
        let found: Vec<_> = manifest().differences(&with).iter().map(ToString::to_string).collect();
        assert_eq!(found, ["policies/a.safetensors: nothing there, XXH3 0000000000000003 here"]);
        with.policies.push(copy);
        assert_eq!(with.check().unwrap_err(), "two policies are called \"a.safetensors\"");
        with.policies[0].file = "../x".into();
        assert_eq!(with.check().unwrap_err(), "policy \"../x\" can't be a file's name");
    }

    #[test]
    fn differences_are_named() {
        let mut here = manifest();
        here.itarl = "0.2.0".into();
        assert!(manifest().differences(&here).is_empty());
        here.bullet.precision = Precision::Double;
        here.models[0].xxh3 = Hash(2);
        here.cells.pop();
        here.seeds.pop();
        let found: Vec<_> = manifest().differences(&here).iter().map(ToString::to_string).collect();
        assert_eq!(
            found,
            [
                "Bullet: 325 in single precision there, 325 in double precision here",
                "models/svenja.toml: XXH3 0000000000000001 there, XXH3 0000000000000002 here",
                "cell 1: xi=0.75/seed=2 there, nothing here",
                "seeds: [1, 2] there, [1] here",
            ]
        );
    }
}

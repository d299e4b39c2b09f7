//! Parameters as safetensors: which tensors a flat vector is made of, and how a file that has others
//! is told from one that fits.
//!
//! Tensors are dense, row-major, `F64`; `F32` is read too. The metadata's one entry has the kind as
//! its key, and as its value the sizes for a human reader and the XXH3 of the tensors' names and
//! bytes, which is compared where it's there. (One entry, because the format's library writes
//! several in any order.)

use std::collections::{BTreeMap, HashMap};

use crbm::MAX_PARAMETER;
use safetensors::{
    Dtype, SafeTensors,
    tensor::{TensorView, serialize},
};
use xxhash_rust::xxh3::Xxh3;

use crate::{Error, error::Difference, error::check_length};

/// Before the hash in the metadata.
const HASH: &str = "xxh3=";

/// The tensors that a flat vector of parameters is made of, one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Tensors {
    kind: &'static str,
    /// Names and shapes.
    entries: Vec<(String, Vec<usize>)>,
}

impl Tensors {
    pub(crate) fn new(kind: &'static str, entries: Vec<(String, Vec<usize>)>) -> Self {
        Self { kind, entries }
    }

    pub(crate) fn n_parameters(&self) -> usize {
        self.entries.iter().map(|(_, shape)| size(shape)).sum()
    }

    /// That parameters have the right number and are finite and in range.
    pub(crate) fn check(&self, place: &'static str, parameters: &[f64]) -> Result<(), Error> {
        check_length(place, "parameters", self.n_parameters(), parameters.len())?;
        let bad = |value: &f64| value.is_nan() || value.abs() > MAX_PARAMETER;
        match parameters.iter().position(bad) {
            None => Ok(()),
            Some(index) => {
                let expected = format!("in -{MAX_PARAMETER:e}..={MAX_PARAMETER:e}");
                let argument = format!("parameter {index}, {}", self.name(index));
                Err(Error::argument(place, argument, expected, parameters[index]))
            }
        }
    }

    /// `W[3,1]`, for messages.
    fn name(&self, mut index: usize) -> String {
        for (name, shape) in &self.entries {
            if index < size(shape) {
                return match shape[..] {
                    [_, n_columns] => {
                        format!("{name}[{},{}]", index / n_columns, index % n_columns)
                    }
                    _ => format!("{name}[{index}]"),
                };
            }
            index -= size(shape);
        }
        "beyond the last".into()
    }

    /// The bytes of a file, the same ones for the same parameters; `sizes` is for its readers.
    pub(crate) fn write(&self, sizes: &str, parameters: &[f64]) -> Result<Vec<u8>, Error> {
        self.check("Policy::to_safetensors", parameters)?;
        let bytes: Vec<u8> = parameters.iter().flat_map(|value| value.to_le_bytes()).collect();
        let mut rest = bytes.as_slice();
        let (mut views, mut hash) = (Vec::new(), Xxh3::new());
        let refuse = |error| Error::file("tensors", "what the format can hold", error);
        for (name, shape) in &self.entries {
            let (own, others) = rest.split_at(8 * size(shape));
            rest = others;
            update(&mut hash, name, own);
            let view = TensorView::new(Dtype::F64, shape.clone(), own).map_err(refuse)?;
            views.push((name.as_str(), view));
        }
        let about = format!("{sizes} {HASH}{:016x}", hash.digest());
        serialize(views, Some(HashMap::from([(self.kind.to_owned(), about)]))).map_err(refuse)
    }

    /// The parameters in the bytes of a file that has been told to be of this layout.
    pub(crate) fn read(&self, bytes: &[u8]) -> Result<Vec<f64>, Error> {
        let file = parse(bytes)?;
        let (mut parameters, mut hash) = (Vec::with_capacity(self.n_parameters()), Xxh3::new());
        for (name, _) in &self.entries {
            let tensor = file
                .tensor(name)
                .map_err(|_| Error::file(format!("tensor {name}"), "in the file", "none"))?;
            update(&mut hash, name, tensor.data());
            parameters.extend(numbers(name, &tensor)?);
        }
        let found = format!("{:016x}", hash.digest());
        if let Some((_, written)) = about(bytes)?
            && found != written
        {
            let expected = format!("{written}, as was written");
            return Err(Error::file("the XXH3 of the tensors", expected, found));
        }
        self.check("Policy::read_safetensors", &parameters)?;
        Ok(parameters)
    }
}

fn size(shape: &[usize]) -> usize {
    shape.iter().product()
}

fn update(hash: &mut Xxh3, name: &str, bytes: &[u8]) {
    hash.update(name.as_bytes());
    hash.update(bytes);
}

fn parse(bytes: &[u8]) -> Result<SafeTensors<'_>, Error> {
    SafeTensors::deserialize(bytes).map_err(|error| Error::file("the file", "in the format", error))
}

fn numbers(name: &str, tensor: &TensorView<'_>) -> Result<Vec<f64>, Error> {
    let bytes = tensor.data();
    match tensor.dtype() {
        Dtype::F64 => Ok(bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect()),
        Dtype::F32 => {
            Ok(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b).into()).collect())
        }
        other => Err(Error::file(format!("type of {name}"), "F64 or F32", format!("{other:?}"))),
    }
}

/// The kind and the hash that a file of ours says; files of other programs say none.
fn about(bytes: &[u8]) -> Result<Option<(String, String)>, Error> {
    let (_, header) = SafeTensors::read_metadata(bytes)
        .map_err(|error| Error::file("the file", "in the format", error))?;
    let entries = header.metadata().iter().flatten();
    let mut ours = entries.filter_map(|(kind, text)| {
        text.split_once(HASH).map(|(_, hash)| (kind.clone(), hash.to_owned()))
    });
    Ok(ours.next())
}

/// That a file has the tensors of another one, which is a policy's own: the same names and shapes,
/// and the same connections.
pub(crate) fn expect_same_layout(there: &[u8], here: &[u8]) -> Result<(), Error> {
    let kind = |bytes| about(bytes).map(|about| about.map(|(kind, _)| kind));
    if let (Some(there), Some(here)) = (kind(there)?, kind(here)?)
        && there != here
    {
        return Err(Error::OtherLayout(vec![Difference { part: "kind".into(), there, here }]));
    }
    let (there, here) = (shapes(there)?, shapes(here)?);
    let names: std::collections::BTreeSet<_> = there.keys().chain(here.keys()).collect();
    let differences: Vec<_> = names
        .into_iter()
        .filter_map(|name| compare(name, there.get(name), here.get(name)))
        .collect();
    if differences.is_empty() { Ok(()) } else { Err(Error::OtherLayout(differences)) }
}

/// A tensor's shape, and which bits are on if it has bits: they say what is connected.
type Shape = (Vec<usize>, Option<Vec<u8>>);

fn shapes(bytes: &[u8]) -> Result<BTreeMap<String, Shape>, Error> {
    let shape = |(name, tensor): (&str, TensorView<'_>)| {
        let bits = (tensor.dtype() == Dtype::BOOL).then(|| tensor.data().to_vec());
        (name.to_owned(), (tensor.shape().to_vec(), bits))
    };
    Ok(parse(bytes)?.iter().map(shape).collect())
}

fn compare(name: &str, there: Option<&Shape>, here: Option<&Shape>) -> Option<Difference> {
    let shown =
        |shape: Option<&Shape>| shape.map_or("none".into(), |(shape, _)| format!("{shape:?}"));
    let on = |shape: Option<&Shape>| {
        let bits = shape.and_then(|(_, bits)| bits.as_ref());
        bits.map(|bits| bits.iter().filter(|bit| **bit != 0).count())
    };
    let (mut of_there, mut of_here) = (shown(there), shown(here));
    if of_there == of_here {
        if there.map(|(_, bits)| bits) == here.map(|(_, bits)| bits) {
            return None;
        }
        let (there, here) = (on(there).unwrap_or(0), on(here).unwrap_or(0));
        of_there = format!("{there} connections");
        of_here = match here == there {
            true => format!("{here} others"),
            false => format!("{here} connections"),
        };
    }
    Some(Difference { part: name.into(), there: of_there, here: of_here })
}

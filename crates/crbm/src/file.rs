//! Parameters as safetensors, which NumPy and PyTorch open: `V` `[n_hidden x n_inputs]`, `c`
//! `[n_hidden]`, `W` `[n_hidden x n_outputs]`, `b` `[n_outputs]`, dense, row-major, `F64`, with
//! zeros where nothing is connected.
//!
//! If connections are restricted, `V_mask` or `W_mask` (`BOOL`, the shape of V or W) say which
//! there are. The metadata's one entry, `crbm`, has the sizes for a human reader and the XXH3 of the
//! tensors' bytes, which is compared where it's there. (One entry, because the format's library
//! writes several in any order.)

use std::collections::HashMap;

use safetensors::{
    Dtype, SafeTensors,
    tensor::{TensorView, serialize},
};
use xxhash_rust::xxh3::Xxh3;

use crate::{Error, Layout, Mask};

impl Layout {
    /// The bytes of a safetensors file with the parameters, the same ones for the same parameters.
    ///
    /// # Errors
    /// If their number is wrong, or one is NaN or beyond [`MAX_PARAMETER`](crate::MAX_PARAMETER).
    pub fn to_safetensors(&self, parameters: &[f64]) -> Result<Vec<u8>, Error> {
        self.check("Layout::to_safetensors", parameters)?;
        let (m, k, n) = (self.n_hidden(), self.n_inputs(), self.n_outputs());
        let v = dense(self.input_mask(), &parameters[self.input_weights()]);
        let w = dense(self.output_mask(), &parameters[self.output_weights()]);
        let mut tensors = vec![
            ("V", Dtype::F64, vec![m, k], bytes(&v)),
            ("c", Dtype::F64, vec![m], bytes(&parameters[self.hidden_biases()])),
            ("W", Dtype::F64, vec![m, n], bytes(&w)),
            ("b", Dtype::F64, vec![n], bytes(&parameters[self.output_biases()])),
        ];
        for (name, mask) in [("V_mask", self.input_mask()), ("W_mask", self.output_mask())] {
            if !mask.is_full() {
                let connected = dense(mask, &vec![1; mask.n_pairs()]);
                tensors.push((name, Dtype::BOOL, vec![m, mask.n_columns()], connected));
            }
        }
        let views: Result<Vec<_>, _> = tensors
            .iter()
            .map(|(name, dtype, shape, bytes)| {
                TensorView::new(*dtype, shape.clone(), bytes).map(|view| (*name, view))
            })
            .collect();
        let sizes = format!("n_inputs={k} n_hidden={m} n_outputs={n}");
        let hash = hash(tensors.iter().map(|(name, _, _, bytes)| (*name, bytes.as_slice())));
        let sizes = format!("{sizes} {HASH}{hash:016x}");
        let metadata = HashMap::from([("crbm".to_string(), sizes)]);
        views
            .and_then(|views| serialize(views, Some(metadata)))
            .map_err(|error| Error::file("tensors", "what the format can hold", error))
    }

    /// The layout and the parameters in the bytes of a safetensors file. `F32` tensors are read
    /// too; other tensors than those above are left alone.
    ///
    /// # Errors
    /// If the bytes aren't a safetensors file, a tensor is missing or has another type or shape, a
    /// number is NaN or beyond [`MAX_PARAMETER`](crate::MAX_PARAMETER), one isn't zero where nothing is
    /// connected, or the bytes aren't those that were written.
    pub fn from_safetensors(bytes: &[u8]) -> Result<(Self, Vec<f64>), Error> {
        let file = SafeTensors::deserialize(bytes)
            .map_err(|error| Error::file("the file", "in the format", error))?;
        check_hash(bytes, &file)?;
        let [n_outputs] = shape(&file, "b", "[n_outputs]")?;
        let [n_hidden] = shape(&file, "c", "[n_hidden]")?;
        let [_, n_inputs] = shape(&file, "V", "[n_hidden x n_inputs]")?;
        let inputs = read_mask(&file, "V_mask", [n_hidden, n_inputs])?;
        let outputs = read_mask(&file, "W_mask", [n_hidden, n_outputs])?;
        let mut parameters = read_connected(&file, "V", &inputs)?;
        parameters.extend(read_numbers(&file, "c", &[n_hidden])?);
        parameters.extend(read_connected(&file, "W", &outputs)?);
        parameters.extend(read_numbers(&file, "b", &[n_outputs])?);
        let layout = Self::new(inputs, outputs)?;
        layout.check("Layout::from_safetensors", &parameters)?;
        Ok((layout, parameters))
    }
}

/// Before the hash in the metadata.
const HASH: &str = "xxh3=";

/// Of the names and bytes of tensors.
fn hash<'a>(tensors: impl Iterator<Item = (&'a str, &'a [u8])>) -> u64 {
    let mut hash = Xxh3::new();
    for (name, bytes) in tensors {
        hash.update(name.as_bytes());
        hash.update(bytes);
    }
    hash.digest()
}

/// Files of other programs have no hash, and no bit of theirs is known to be wrong.
fn check_hash(bytes: &[u8], file: &SafeTensors<'_>) -> Result<(), Error> {
    let (_, header) = SafeTensors::read_metadata(bytes)
        .map_err(|error| Error::file("the file", "in the format", error))?;
    let entry = header.metadata().as_ref().and_then(|metadata| metadata.get("crbm"));
    let Some((_, written)) = entry.and_then(|entry| entry.split_once(HASH)) else { return Ok(()) };
    let names = ["V", "c", "W", "b", "V_mask", "W_mask"];
    let tensors: Vec<_> =
        names.iter().filter_map(|name| file.tensor(name).ok().map(|it| (*name, it))).collect();
    let found = hash(tensors.iter().map(|(name, tensor)| (*name, tensor.data())));
    let found = format!("{found:016x}");
    if found == written {
        return Ok(());
    }
    Err(Error::file("the XXH3 of the tensors", format!("{written}, as was written"), found))
}

/// `[n_rows x n_columns]`, with zeros where nothing is connected.
fn dense<T: Copy + Default>(mask: &Mask, connected: &[T]) -> Vec<T> {
    let mut dense = vec![T::default(); mask.n_rows() * mask.n_columns()];
    for ((row, column), value) in mask.pairs().zip(connected) {
        dense[row * mask.n_columns() + column] = *value;
    }
    dense
}

fn bytes(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn tensor<'a>(file: &SafeTensors<'a>, name: &str) -> Result<TensorView<'a>, Error> {
    file.tensor(name).map_err(|_| Error::file(format!("tensor {name}"), "in the file", "none"))
}

fn shape<const N: usize>(file: &SafeTensors, name: &str, sizes: &str) -> Result<[usize; N], Error> {
    let tensor = tensor(file, name)?;
    let shape = tensor.shape();
    shape
        .try_into()
        .map_err(|_| Error::file(format!("shape of {name}"), sizes, format!("{shape:?}")))
}

fn checked<'a>(
    file: &SafeTensors<'a>,
    name: &str,
    shape: &[usize],
) -> Result<TensorView<'a>, Error> {
    let tensor = tensor(file, name)?;
    if tensor.shape() != shape {
        let (expected, got) = (format!("{shape:?}"), format!("{:?}", tensor.shape()));
        return Err(Error::file(format!("shape of {name}"), expected, got));
    }
    Ok(tensor)
}

fn read_numbers(file: &SafeTensors, name: &str, shape: &[usize]) -> Result<Vec<f64>, Error> {
    let tensor = checked(file, name, shape)?;
    let bytes = tensor.data();
    match tensor.dtype() {
        Dtype::F64 => Ok(bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect()),
        Dtype::F32 => {
            Ok(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b).into()).collect())
        }
        other => Err(Error::file(format!("type of {name}"), "F64 or F32", format!("{other:?}"))),
    }
}

fn read_mask(file: &SafeTensors, name: &str, shape: [usize; 2]) -> Result<Mask, Error> {
    if file.tensor(name).is_err() {
        return Mask::full(shape[0], shape[1]);
    }
    let tensor = checked(file, name, &shape)?;
    if tensor.dtype() != Dtype::BOOL {
        let got = format!("{:?}", tensor.dtype());
        return Err(Error::file(format!("type of {name}"), "BOOL", got));
    }
    let bytes = tensor.data();
    Mask::from_fn(shape[0], shape[1], |row, column| bytes[row * shape[1] + column] != 0)
}

/// A dense matrix's connected entries; all others must be zero.
fn read_connected(file: &SafeTensors, name: &str, mask: &Mask) -> Result<Vec<f64>, Error> {
    let mut dense = read_numbers(file, name, &[mask.n_rows(), mask.n_columns()])?;
    let mut connected = Vec::with_capacity(mask.n_pairs());
    for (row, column) in mask.pairs() {
        connected.push(std::mem::take(&mut dense[row * mask.n_columns() + column]));
    }
    match dense.iter().position(|value| *value != 0.0) {
        None => Ok(connected),
        Some(place) => {
            let part = format!("{name}[{},{}]", place / mask.n_columns(), place % mask.n_columns());
            Err(Error::file(part, "0, since nothing is connected there", dense[place]))
        }
    }
}

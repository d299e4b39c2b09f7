//! Reading what was written, and refusing what wasn't.
#![allow(clippy::unwrap_used, missing_docs)]

use crbm::{Error, Layout, MAX_PARAMETER, Mask};
use proptest::prelude::*;
use safetensors::{
    Dtype, SafeTensors,
    tensor::{TensorView, serialize},
};

fn layouts() -> impl Strategy<Value = Layout> {
    (0..5usize, 0..7usize, 1..6usize)
        .prop_flat_map(|(k, m, n)| {
            let bits = |length| proptest::collection::vec(any::<bool>(), length);
            (Just((k, m, n)), bits(m * k), bits(m * n), any::<[bool; 2]>())
        })
        .prop_map(|((k, m, n), v, w, full)| {
            let inputs = Mask::from_fn(m, k, |j, i| full[0] || v[j * k + i]).unwrap();
            let outputs = Mask::from_fn(m, n, |j, i| full[1] || w[j * n + i]).unwrap();
            Layout::new(inputs, outputs).unwrap()
        })
}

fn machines() -> impl Strategy<Value = (Layout, Vec<f64>)> {
    layouts().prop_flat_map(|layout| {
        let parameters =
            proptest::collection::vec(-MAX_PARAMETER..=MAX_PARAMETER, layout.n_parameters());
        (Just(layout), parameters)
    })
}

proptest! {
    #[test]
    fn what_was_written_is_read((layout, parameters) in machines()) {
        let bytes = layout.to_safetensors(&parameters).unwrap();
        prop_assert_eq!(&bytes, &layout.to_safetensors(&parameters).unwrap());
        let (read, values) = Layout::from_safetensors(&bytes).unwrap();
        prop_assert_eq!(read, layout);
        prop_assert_eq!(values, parameters);
    }

    #[test]
    fn damaged_bytes_are_refused_or_read_but_nothing_worse(
        (layout, parameters) in machines(),
        place in any::<prop::sample::Index>(),
        byte in any::<u8>(),
        end in any::<prop::sample::Index>(),
    ) {
        let mut bytes = layout.to_safetensors(&parameters).unwrap();
        prop_assert!(Layout::from_safetensors(&bytes[..end.index(bytes.len())]).is_err());
        let place = place.index(bytes.len());
        bytes[place] = byte;
        if let Ok((layout, parameters)) = Layout::from_safetensors(&bytes) {
            prop_assert_eq!(layout.n_parameters(), parameters.len());
        }
    }
}

#[test]
fn other_programs_find_names_shapes_and_zeros() {
    let layout = Layout::new(Mask::full(2, 1).unwrap(), Mask::blocks(1, &[0, 1]).unwrap()).unwrap();
    let bytes = layout.to_safetensors(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]).unwrap();
    let file = SafeTensors::deserialize(&bytes).unwrap();
    let tensor = |name, shape: &[usize]| {
        let tensor = file.tensor(name).unwrap();
        assert_eq!((tensor.dtype(), tensor.shape()), (Dtype::F64, shape), "{name}");
        let numbers = tensor.data().as_chunks().0.iter().map(|b| f64::from_le_bytes(*b));
        numbers.collect::<Vec<_>>()
    };
    assert_eq!(tensor("V", &[2, 1]), [1.0, 2.0]);
    assert_eq!(tensor("c", &[2]), [3.0, 4.0]);
    assert_eq!(tensor("W", &[2, 2]), [5.0, 0.0, 0.0, 6.0]);
    assert_eq!(tensor("b", &[2]), [7.0, 8.0]);
    assert_eq!(file.tensor("W_mask").unwrap().data(), [1, 0, 0, 1]);
    assert!(file.tensor("V_mask").is_err(), "full");
    let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
    let metadata = header.metadata().as_ref().unwrap();
    assert_eq!(metadata.len(), 1, "several would come in any order");
    assert!(
        metadata["crbm"].starts_with("n_inputs=1 n_hidden=2 n_outputs=2 xxh3="),
        "{metadata:?}"
    );
}

/// Not a bit of a number can change without being noticed.
#[test]
fn a_flipped_bit_of_a_tensor_is_refused() {
    let layout = Layout::full(2, 1, 1).unwrap();
    let good = layout.to_safetensors(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
    for place in good.len() - 5 * 8..good.len() {
        for bit in 0..8 {
            let mut bytes = good.clone();
            bytes[place] ^= 1 << bit;
            let message = Layout::from_safetensors(&bytes).unwrap_err().to_string();
            assert!(
                message.starts_with("safetensors: the XXH3 of the tensors must be "),
                "{message}"
            );
        }
    }
}

#[test]
fn single_precision_is_read() {
    let numbers = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
    let file = File { v: numbers(&[1.0, 2.0]), dtype: Dtype::F32, ..File::good() };
    let (_, parameters) = Layout::from_safetensors(&file.bytes()).unwrap();
    assert_eq!(parameters, [1.0, 2.0, 3.0, 4.0, 5.0]);
}

#[test]
fn messages_name_what_is_wrong() {
    let numbers = |values: &[f64]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
    let cases = [
        (File { v_name: "U", ..File::good() }, "tensor V must be in the file, got none"),
        (File { v_shape: vec![2, 1], ..File::good() }, "shape of V must be [1, 1], got [2, 1]"),
        (
            File { v_shape: vec![2], ..File::good() },
            "shape of V must be [n_hidden x n_inputs], got [2]",
        ),
        (File { dtype: Dtype::I64, ..File::good() }, "type of V must be F64 or F32, got I64"),
        (
            File { mask: Some(vec![1, 0]), ..File::good() },
            "V[0,1] must be 0, since nothing is connected there, got 2",
        ),
    ];
    for (file, expected) in cases {
        let message = Layout::from_safetensors(&file.bytes()).unwrap_err().to_string();
        assert_eq!(message, format!("safetensors: {expected}"));
    }
    let file = File { v: numbers(&[1.0, f64::INFINITY]), ..File::good() };
    assert_eq!(
        Layout::from_safetensors(&file.bytes()).unwrap_err().to_string(),
        "Layout::from_safetensors: parameter 1, V[0,1] must be in -1e9..=1e9, got inf"
    );
    assert!(matches!(Layout::from_safetensors(b"not at all"), Err(Error::File { .. })));
}

/// A file of one hidden unit, two inputs, one output, with what may be wrong about it.
struct File {
    v_name: &'static str,
    v_shape: Vec<usize>,
    v: Vec<u8>,
    dtype: Dtype,
    mask: Option<Vec<u8>>,
}

impl File {
    fn good() -> Self {
        let v = [1.0f64, 2.0].iter().flat_map(|value| value.to_le_bytes()).collect();
        Self { v_name: "V", v_shape: vec![1, 2], v, dtype: Dtype::F64, mask: None }
    }

    fn bytes(&self) -> Vec<u8> {
        let [c, w, b] = [3.0f64, 4.0, 5.0].map(f64::to_le_bytes);
        let view = |shape, bytes| TensorView::new(Dtype::F64, shape, bytes).unwrap();
        let mut tensors = vec![
            (self.v_name, TensorView::new(self.dtype, self.v_shape.clone(), &self.v).unwrap()),
            ("c", view(vec![1], &c)),
            ("W", view(vec![1, 1], &w)),
            ("b", view(vec![1], &b)),
        ];
        if let Some(mask) = &self.mask {
            tensors.push(("V_mask", TensorView::new(Dtype::BOOL, vec![1, 2], mask).unwrap()));
        }
        serialize(tensors, None).unwrap()
    }
}

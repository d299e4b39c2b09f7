//! TensorBoard's event files: a cell's rows as curves that TensorBoard draws.
//!
//! A file is a head and an event for each row, each an `Event` of TensorFlow's
//! [event.proto](https://github.com/tensorflow/tensorboard/blob/master/tensorboard/compat/proto/event.proto),
//! in the frame of a TFRecord, all in little-endian:
//!
//! ```text
//! u64 length    u32 masked CRC-32C of the length    the event    u32 masked CRC-32C of the event
//! ```
//!
//! Its time is the robot's and not the clock's: control steps, those of all worlds of a cell together, over
//! their frequency. So the same rows give the same bytes, and those of a run that has gone on begin with
//! those of before.

use crc::{CRC_32_ISCSI, Crc};
use figures::Measure;
use prost::Message;
use runs::{COLUMNS, Column, Row};

use crate::catalogue::RunCell;

/// What an event file is called, in a folder of its own.
pub const FILE_NAME: &str = "events.out.tfevents.itarl";

/// The version of all event files.
const VERSION: &str = "brain.Event:2";

/// CRC-32C, as it's also called.
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);

/// Columns that count the rows: one is the step, and the other is it over a constant.
const COUNTS: [&str; 2] = ["update", "control_steps"];

/// Columns by what they tell of: a section of TensorBoard's page each. What is in none is of learning.
const SECTIONS: [(&str, &[&str]); 3] = [
    ("reward", &["R", "extrinsic", "R_MI", "penalty", "xi"]),
    ("information", &["R_MI_nats", "R_MI_miller_madow_nats"]),
    (
        "robot",
        &[
            "task",
            "R_Loc",
            "net_displacement_m",
            "heading_change_rad",
            "penalised_contacts",
            "clipped_readings",
        ],
    ),
];

/// Fields have the numbers of event.proto and summary.proto.
#[derive(Clone, PartialEq, Message)]
struct Event {
    #[prost(double, tag = "1")]
    wall_time: f64,
    #[prost(int64, tag = "2")]
    step: i64,
    #[prost(string, optional, tag = "3")]
    file_version: Option<String>,
    #[prost(message, optional, tag = "5")]
    summary: Option<Summary>,
    #[prost(message, optional, tag = "10")]
    source: Option<SourceMetadata>,
}

#[derive(Clone, PartialEq, Message)]
struct SourceMetadata {
    #[prost(string, tag = "1")]
    writer: String,
}

#[derive(Clone, PartialEq, Message)]
struct Summary {
    #[prost(message, repeated, tag = "1")]
    values: Vec<Value>,
}

#[derive(Clone, PartialEq, Message)]
struct Value {
    #[prost(string, tag = "1")]
    tag: String,
    /// TensorBoard draws no other precision.
    #[prost(float, optional, tag = "2")]
    simple_value: Option<f32>,
    #[prost(message, optional, tag = "9")]
    metadata: Option<SummaryMetadata>,
}

#[derive(Clone, PartialEq, Message)]
struct SummaryMetadata {
    #[prost(message, optional, tag = "1")]
    plugin: Option<PluginData>,
    #[prost(string, tag = "3")]
    description: String,
    #[prost(int32, tag = "4")]
    data_class: i32,
}

#[derive(Clone, PartialEq, Message)]
struct PluginData {
    #[prost(string, tag = "1")]
    name: String,
}

impl SummaryMetadata {
    /// Of a curve.
    fn of_scalars(description: String) -> Self {
        const SCALAR: i32 = 1;
        let plugin = PluginData { name: "scalars".into() };
        Self { plugin: Some(plugin), description, data_class: SCALAR }
    }
}

/// The first bytes of a cell's event file, by which it's known as such.
#[must_use]
pub fn head(cell: &RunCell) -> Vec<u8> {
    record(&Event {
        file_version: Some(VERSION.into()),
        source: Some(SourceMetadata { writer: format!("itarl, cell {:016x}", cell.identity) }),
        ..Event::default()
    })
}

/// The bytes of a cell's event file. What a row doesn't know, NaN, has no point.
#[must_use]
pub fn event_file(cell: &RunCell, rows: &[Row]) -> Vec<u8> {
    let measure = cell.task();
    let tags: Vec<_> = COLUMNS
        .iter()
        .filter(|column| is_curve(column, &measure))
        .map(|column| (column, tag(column)))
        .collect();
    let frequency_hz = cell.cell.experiment.control.frequency_hz;
    let mut bytes = head(cell);
    let mut described = vec![false; tags.len()];
    for row in rows {
        let mut values = Vec::with_capacity(tags.len());
        for ((column, tag), described) in tags.iter().zip(&mut described) {
            let value = (column.value)(row);
            if value.is_nan() {
                continue;
            }
            // Once for each curve.
            let metadata =
                (!*described).then(|| SummaryMetadata::of_scalars(description(column, &measure)));
            *described = true;
            values.push(Value { tag: tag.clone(), simple_value: Some(value as f32), metadata });
        }
        bytes.extend(record(&Event {
            wall_time: row.control_steps as f64 / frequency_hz,
            step: row.control_steps as i64,
            summary: Some(Summary { values }),
            ..Event::default()
        }));
    }
    bytes
}

/// Where no information is measured, its columns are no curves.
fn is_curve(column: &Column, measure: &Measure) -> bool {
    let is_information = column.name.starts_with("R_MI");
    !COUNTS.contains(&column.name) && (measure.information.is_some() || !is_information)
}

/// `robot/R_Loc`: TensorBoard has a section for each of what is before the stroke.
fn tag(column: &Column) -> String {
    let section = SECTIONS.iter().find(|(_, names)| names.contains(&column.name));
    format!("{}/{}", section.map_or("learning", |it| it.0), column.name)
}

/// What a column is, with its unit; of the task and the information as their kinds call them.
fn description(column: &Column, measure: &Measure) -> String {
    let unit = match (column.name, &measure.information) {
        ("task", _) => format!("{} in {} per control step", measure.name(), measure.unit),
        ("R_MI" | "R_MI_nats" | "R_MI_miller_madow_nats", Some(it)) if column.unit == "nats" => {
            format!("{} in {}", it.name(), it.axis_unit())
        }
        ("R_MI", Some(it)) => it.name(),
        // The section says so.
        _ if column.unit == "reward" => String::new(),
        _ => column.unit.into(),
    };
    if unit.is_empty() { column.label.into() } else { format!("{}: {unit}", column.label) }
}

/// An event in its frame.
fn record(event: &Event) -> Vec<u8> {
    let event = event.encode_to_vec();
    let length = (event.len() as u64).to_le_bytes();
    [&length[..], &masked(&length), &event, &masked(&event)].concat()
}

/// A checksum, turned and moved: that of bytes that have their own checksum in them is a constant
/// otherwise.
fn masked(bytes: &[u8]) -> [u8; 4] {
    CRC.checksum(bytes).rotate_right(15).wrapping_add(0xa282_ead8).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use std::{collections::BTreeMap, path::Path};

    use runs::CellFolder;

    use super::*;
    use crate::experiment::Plan;

    fn cell(settings: &str) -> RunCell {
        let plan =
            Plan::written(Path::new("/x.toml"), &format!("model = '/m'\n{settings}")).unwrap();
        let (cell, folder) = (plan.cells()[0].clone(), CellFolder::new("cell"));
        RunCell { cell, folder, identity: 0xabc, model: 0, robot: 0, initial: None }
    }

    fn row(update: u64) -> Row {
        let value = 0.1 * update as f64;
        let mut row =
            Row { update, control_steps: 50 * update, advance_m: value, ..Row::default() };
        (row.task, row.gradient_error) = (value, f64::NAN);
        row
    }

    /// CRC-32C bit by bit, with the reflected polynomial of RFC 3720.
    fn crc(bytes: &[u8]) -> u32 {
        let mut crc = u32::MAX;
        for byte in bytes {
            crc ^= u32::from(*byte);
            for _ in 0..8 {
                crc = if crc & 1 == 1 { crc >> 1 ^ 0x82f6_3b78 } else { crc >> 1 };
            }
        }
        !crc
    }

    fn number<const N: usize>(bytes: &mut &[u8]) -> [u8; N] {
        let (number, rest) = bytes.split_first_chunk().unwrap();
        *bytes = rest;
        *number
    }

    /// The records of a file, as TFRecord is described.
    fn records(mut bytes: &[u8]) -> Vec<&[u8]> {
        let mut all = Vec::new();
        let check = |of: &[u8], found: [u8; 4]| {
            let crc = crc(of);
            let masked = crc.rotate_right(15).wrapping_add(0xa282_ead8);
            assert_eq!(u32::from_le_bytes(found), masked);
        };
        while !bytes.is_empty() {
            let length = number::<8>(&mut bytes);
            check(&length, number(&mut bytes));
            let (record, rest) = bytes.split_at(u64::from_le_bytes(length) as usize);
            bytes = rest;
            check(record, number(&mut bytes));
            all.push(record);
        }
        all
    }

    fn varint(bytes: &mut &[u8]) -> u64 {
        let mut value = 0;
        for i in 0.. {
            let [byte] = number(bytes);
            value |= u64::from(byte & 0x7f) << (7 * i);
            if byte < 0x80 {
                break;
            }
        }
        value
    }

    /// The fields of a message, each with its bytes, by the encoding of protocol buffers.
    fn fields(mut bytes: &[u8]) -> Vec<(u64, Vec<u8>)> {
        let mut all = Vec::new();
        while !bytes.is_empty() {
            let key = varint(&mut bytes);
            let length = match key & 7 {
                0 => {
                    all.push((key >> 3, varint(&mut bytes).to_le_bytes().into()));
                    continue;
                }
                1 => 8,
                2 => varint(&mut bytes) as usize,
                5 => 4,
                other => panic!("wire type {other}"),
            };
            let (field, rest) = bytes.split_at(length);
            all.push((key >> 3, field.into()));
            bytes = rest;
        }
        all
    }

    fn field(fields: &[(u64, Vec<u8>)], number: u64) -> Option<Vec<u8>> {
        fields.iter().find(|it| it.0 == number).map(|it| it.1.clone())
    }

    /// Time, step, and the values and the descriptions by tag.
    type Read = (f64, u64, BTreeMap<String, f32>, BTreeMap<String, String>);

    fn read(event: &[u8]) -> Read {
        let event = fields(event);
        let time = field(&event, 1).map_or(0.0, |it| f64::from_le_bytes(it.try_into().unwrap()));
        let step = field(&event, 2).map_or(0, |it| u64::from_le_bytes(it.try_into().unwrap()));
        let (mut values, mut about) = (BTreeMap::new(), BTreeMap::new());
        for (_, value) in fields(&field(&event, 5).unwrap()) {
            let value = fields(&value);
            let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
            let tag = text(field(&value, 1).unwrap());
            let number = f32::from_le_bytes(field(&value, 2).unwrap().try_into().unwrap());
            values.insert(tag.clone(), number);
            if let Some(metadata) = field(&value, 9) {
                about.insert(tag, text(field(&fields(&metadata), 3).unwrap()));
            }
        }
        (time, step, values, about)
    }

    #[test]
    fn checksums_are_those_of_the_standard() {
        // RFC 3720, B.4: 32 bytes of zeros.
        assert_eq!((crc(&[0; 32]), CRC.checksum(&[0; 32])), (0x8a91_36aa, 0x8a91_36aa));
    }

    #[test]
    fn a_row_is_an_event_with_each_number_that_is_known() {
        let rows: Vec<_> = (1..=3).map(row).collect();
        let bytes = event_file(&cell("control.frequency_hz = 5"), &rows);
        let records = records(&bytes);
        assert_eq!(records.len(), 4);
        let first = fields(records[0]);
        assert_eq!(field(&first, 3).unwrap(), b"brain.Event:2");
        assert_eq!(
            field(&fields(&field(&first, 10).unwrap()), 1).unwrap(),
            b"itarl, cell 0000000000000abc"
        );
        for (row, record) in rows.iter().zip(&records[1..]) {
            let (time, step, values, about) = read(record);
            assert_eq!((time, step), (10.0 * row.update as f64, 50 * row.update));
            assert_eq!(values.len(), COLUMNS.len() - COUNTS.len() - 1, "{values:?}");
            assert!(!values.contains_key("learning/gradient_error"));
            for name in ["robot/R_Loc", "robot/task"] {
                assert_eq!(values[name], 0.1 * row.update as f32);
            }
            assert_eq!(values["learning/gradient_norm"], 0.0);
            // Once for each.
            assert_eq!(about.len(), if row.update == 1 { values.len() } else { 0 });
        }
        let (.., about) = read(records[1]);
        assert_eq!(about["robot/R_Loc"], "way along the heading: m per control step");
        assert_eq!(
            about["robot/task"],
            "the task's own value: locomotion R_Loc in m per control step"
        );
    }

    /// TensorBoard, which has read a part of a file, reads on from there.
    #[test]
    fn a_run_that_has_gone_on_begins_with_what_it_was() {
        let (cell, rows) = (cell(""), (1..=9).map(row).collect::<Vec<_>>());
        let whole = event_file(&cell, &rows);
        for n in 0..9 {
            assert!(whole.starts_with(&event_file(&cell, &rows[..n])));
        }
        assert_eq!(event_file(&cell, &[]), head(&cell));
    }

    #[test]
    fn information_is_called_by_its_kind_and_left_out_where_there_is_none() {
        let described =
            |settings: &str| read(records(&event_file(&cell(settings), &[row(1)]))[1]).3;
        let flow = described("reward.intrinsic.kind = 'transfer_entropy'");
        assert!(flow["information/R_MI_nats"].ends_with("transfer entropy R_TE in nats per link"));
        let none = described("reward.intrinsic.kind = 'none'\nreward.mix.xi = 1");
        assert!(none.keys().all(|tag| !tag.contains("R_MI")), "{none:?}");
        assert_eq!(none.len() + 3, flow.len());
    }

    #[test]
    fn sections_name_columns_that_there_are() {
        for name in SECTIONS.iter().flat_map(|it| it.1).chain(&COUNTS) {
            assert!(COLUMNS.iter().any(|column| column.name == *name), "{name}");
        }
    }
}

//! The same table in every format, read back by other means: the Parquet library, a small reader of `.npy`, the CSV library, serde_json.

mod common;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex};

use common::trace;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use rayreel_columns::{Column, Data, Encoder, Format, Selection, Sink, Use, What};
use rayreel_formats::Trace;
use rayreel_machine::NamedMachine;
use rayreel_replay::NamedPolicy;

/// Writes a table, and gives the number of rows.
fn write(data: &Data<'_>, format: Format, columns: &[&str], file: &Path) -> u64 {
    let head = data.head().unwrap();
    let head = if columns.is_empty() { head } else { head.only(columns).unwrap() };
    let encoder = Encoder::new(format, head).unwrap();
    let mut sink = Sink::file(&encoder, file).unwrap();
    let mut take = |encoded, _| sink.append(encoded);
    data.run(Use { make: &|batch| encoder.encode(batch), take: &mut take }).unwrap();
    sink.finish().unwrap()
}

/// A table as text, by column; floats by their bits.
type Cells = BTreeMap<String, Vec<String>>;

fn bits(value: f32) -> String {
    if value.is_nan() { "NaN".into() } else { format!("{:08x}", value.to_bits()) }
}

fn collected(data: &Data<'_>) -> Cells {
    let batch = data.collect().unwrap();
    let text = |column: &Column| -> Vec<String> {
        match column {
            Column::U8(values) => values.iter().map(u8::to_string).collect(),
            Column::I8(values) => values.iter().map(i8::to_string).collect(),
            Column::U16(values) => values.iter().map(u16::to_string).collect(),
            Column::U32(values) => values.iter().map(u32::to_string).collect(),
            Column::I32(values) => values.iter().map(i32::to_string).collect(),
            Column::U64(values) => values.iter().map(u64::to_string).collect(),
            Column::I64(values) => values.iter().map(i64::to_string).collect(),
            Column::F32(values) => values.iter().map(|value| bits(*value)).collect(),
            Column::Bool(values) => values.iter().map(bool::to_string).collect(),
            Column::Word(words) => words.codes.iter().map(|&code| words.names.get(code).to_string()).collect(),
        }
    };
    data.what.table().columns.iter().map(|c| c.name.to_string()).zip(batch.columns.iter().map(text)).collect()
}

fn parquet(file: &Path) -> Cells {
    let reader = SerializedFileReader::new(std::fs::File::open(file).unwrap()).unwrap();
    let mut cells = Cells::new();
    for row in reader.get_row_iter(None).unwrap() {
        for (name, field) in row.unwrap().get_column_iter() {
            let text = match field {
                Field::Float(value) => bits(*value),
                Field::Str(text) => text.clone(),
                other => other.to_string(),
            };
            cells.entry(name.clone()).or_default().push(text);
        }
    }
    cells
}

/// Reads an array of records by what its header says.
fn npy(file: &Path) -> Cells {
    let bytes = std::fs::read(file).unwrap();
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let length = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!(length % 64, 0);
    let header = std::str::from_utf8(&bytes[10..length]).unwrap();
    let inside = header.split_once("'descr': [").unwrap().1.split_once(']').unwrap().0;
    let words: Vec<&str> = inside.split('\'').skip(1).step_by(2).collect();
    let rows: usize = header.split_once("'shape': (").unwrap().1.split_once(',').unwrap().0.parse().unwrap();
    let size = |kind: &str| kind[2..].parse::<usize>().unwrap();
    let stride: usize = words.chunks(2).map(|pair| size(pair[1])).sum();
    assert_eq!(bytes.len(), length + rows * stride);
    let mut cells = Cells::new();
    for row in bytes[length..].chunks(stride) {
        let mut at = 0;
        for pair in words.chunks(2) {
            let value = &row[at..at + size(pair[1])];
            at += value.len();
            let mut wide = [0; 8];
            wide[..value.len().min(8)].copy_from_slice(&value[..value.len().min(8)]);
            let text = match &pair[1][1..] {
                "i1" => (value[0] as i8).to_string(),
                "b1" => (value[0] == 1).to_string(),
                "i4" => i32::from_le_bytes(value.try_into().unwrap()).to_string(),
                "f4" => bits(f32::from_le_bytes(value.try_into().unwrap())),
                kind if kind.starts_with('S') => {
                    String::from_utf8(value.to_vec()).unwrap().trim_end_matches('\0').to_string()
                }
                _ => u64::from_le_bytes(wide).to_string(),
            };
            cells.entry(pair[0].to_string()).or_default().push(text);
        }
    }
    cells
}

/// Floats are found by the table.
fn float(what: What, name: &str) -> bool {
    what.table().columns.iter().any(|column| column.name == name && column.kind.name() == "f32")
}

fn csv(what: What, file: &Path) -> Cells {
    let mut reader = csv::Reader::from_path(file).unwrap();
    let names = reader.headers().unwrap().clone();
    let mut cells = Cells::new();
    for record in reader.records() {
        for (name, cell) in names.iter().zip(&record.unwrap()) {
            let text = if float(what, name) { bits(cell.parse().unwrap()) } else { cell.to_string() };
            cells.entry(name.to_string()).or_default().push(text);
        }
    }
    cells
}

/// What is not finite is `null` here.
fn jsonl(what: What, file: &Path) -> Cells {
    let mut cells = Cells::new();
    for line in std::fs::read_to_string(file).unwrap().lines() {
        let row: BTreeMap<String, serde_json::Value> = serde_json::from_str(line).unwrap();
        for (name, value) in row {
            let text = match value {
                serde_json::Value::String(text) => text,
                serde_json::Value::Null => "null".into(),
                value if float(what, &name) => bits(value.to_string().parse().unwrap()),
                value => value.to_string(),
            };
            cells.entry(name).or_default().push(text);
        }
    }
    cells
}

/// Infinities and what is no number, by their bits, as `null`.
fn with_nulls(cells: Cells, what: What) -> Cells {
    let null = |name: &str, cell: String| {
        let special = ["NaN", "7f800000", "ff800000"].contains(&cell.as_str());
        if special && float(what, name) { "null".into() } else { cell }
    };
    cells.into_iter().map(|(name, cells)| (name.clone(), cells.into_iter().map(|c| null(&name, c)).collect())).collect()
}

/// Few rows of a table: under a policy that traces little, of one tile where there are tiles.
fn data<'a>(trace: &'a Trace, (machine, policy): (&'a NamedMachine, &'a NamedPolicy), what: What) -> Data<'a> {
    let machine = what.takes_machine().then_some(machine);
    let all = Selection::all(trace.meta());
    let selection = if what.takes_tiles() { all.tiles("1").unwrap() } else { all };
    let policy = what.takes_policy().then_some(policy);
    let interval = (what == What::Counters).then_some(5000);
    Data { machine, policy, selection, interval, ..Data::new(trace, what) }
}

#[test]
fn every_format_says_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let machine = NamedMachine::load("sgrt-ti2", &[]).unwrap();
    let policy = NamedPolicy::load("aggressive", &[]).unwrap();
    let trace = trace("cornell");
    for what in What::ALL {
        let data = data(&trace, (&machine, &policy), what);
        let expected = collected(&data);
        let rows = expected.values().next().unwrap().len() as u64;
        assert!(rows > 0, "{}", what.name());
        let file = |format: Format| folder.path().join(format!("t.{}", format.name()));
        for format in Format::ALL {
            assert_eq!(write(&data, *format, &[], &file(*format)), rows);
            assert_eq!(Format::of(&file(*format)), Some(*format));
        }
        assert!(parquet(&file(Format::Parquet)) == expected, "{} as Parquet", what.name());
        assert!(npy(&file(Format::Npy)) == expected, "{} as npy", what.name());
        assert!(csv(what, &file(Format::Csv)) == expected, "{} as CSV", what.name());
        assert!(jsonl(what, &file(Format::Jsonl)) == with_nulls(expected, what), "{} as JSON", what.name());
    }
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let machine = NamedMachine::load("sgrt-ti2", &[]).unwrap();
    let policy = NamedPolicy::load("aggressive", &[]).unwrap();
    for (scene, what) in
        [("teapot", What::Rays), ("teapot", What::Steps), ("teapot", What::Samples), ("cornell", What::Lookups)]
    {
        let trace = trace(scene);
        let data = Data { selection: Selection::all(trace.meta()), ..data(&trace, (&machine, &policy), what) };
        for format in [Format::Parquet, Format::Npy] {
            let file = folder.path().join("t");
            let bytes = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| write(&data, format, &[], &file));
                std::fs::read(&file).unwrap()
            };
            assert!(bytes(1) == bytes(3), "{} as {}", what.name(), format.name());
        }
    }
}

#[test]
fn only_some_columns_in_the_order_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let (trace, file) = (trace("cornell"), folder.path().join("t.csv"));
    let rays = Data::new(&trace, What::Rays);
    let expected = collected(&rays);
    write(&rays, Format::Csv, &["t", "kind", "x"], &file);
    assert!(std::fs::read_to_string(&file).unwrap().starts_with("t,kind,x\n"));
    let found = csv(What::Rays, &file);
    assert!(found.len() == 3 && found.iter().all(|(name, cells)| cells == &expected[name]));
    let error = |names: &[&str]| rays.head().unwrap().only(names).unwrap_err().to_string();
    assert!(error(&["t", "colour"]).starts_with("table rays has no column \"colour\"; it has frame, tile, x, y"));
    assert!(error(&["t", "t"]).contains("asked for twice"));
}

/// A file appears when it is finished, and not before; what is dropped leaves nothing.
#[test]
fn files_are_whole_or_absent() {
    let folder = tempfile::tempdir().unwrap();
    let (trace, file) = (trace("cornell"), folder.path().join("t.npy"));
    let data = Data::new(&trace, What::Hits);
    let encoder = Encoder::new(Format::Npy, data.head().unwrap()).unwrap();
    let mut sink = Sink::file(&encoder, &file).unwrap();
    sink.append(encoder.encode(data.collect().unwrap()).unwrap()).unwrap();
    assert!(!file.exists());
    drop(sink);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    let missing = Sink::file(&encoder, &folder.path().join("no/t.npy")).err().unwrap().to_string();
    assert!(missing.starts_with("cannot write") && missing.contains("no/t.npy"), "{missing}");
}

/// A stream that others can look at.
#[derive(Clone, Default)]
struct Pipe(Arc<Mutex<Vec<u8>>>);

impl std::io::Write for Pipe {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn text_can_be_piped_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let (trace, file) = (trace("cornell"), folder.path().join("t"));
    let data = Data::new(&trace, What::Nodes);
    for format in Format::ALL {
        let (encoder, pipe) = (Encoder::new(*format, data.head().unwrap()).unwrap(), Pipe::default());
        match Sink::stream(&encoder, "a pipe", Box::new(pipe.clone())) {
            Ok(mut sink) => {
                sink.append(encoder.encode(data.collect().unwrap()).unwrap()).unwrap();
                sink.finish().unwrap();
                write(&data, *format, &[], &file);
                assert!(*pipe.0.lock().unwrap() == std::fs::read(&file).unwrap(), "{}", format.name());
            }
            Err(error) => {
                assert!(!format.is_text() && error.to_string().contains("cannot be piped"));
            }
        }
    }
}

/// Parquet's metadata hold the declared table, as JSON that can be read.
#[test]
fn parquet_says_what_its_columns_are() {
    let folder = tempfile::tempdir().unwrap();
    let machine = NamedMachine::load("sgrt-ti2", &[]).unwrap();
    let policy = NamedPolicy::load("aggressive", &[]).unwrap();
    let (trace, file) = (trace("cornell"), folder.path().join("t.parquet"));
    for what in What::ALL {
        write(&data(&trace, (&machine, &policy), what), Format::Parquet, &[], &file);
        let reader = SerializedFileReader::new(std::fs::File::open(&file).unwrap()).unwrap();
        let pairs = reader.metadata().file_metadata().key_value_metadata().unwrap();
        let text = pairs.iter().find(|pair| pair.key == rayreel_columns::sink::KEY).unwrap().value.clone().unwrap();
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!((json["table"].as_str(), json["row"].as_str()), (Some(what.name()), Some(what.table().row)));
        for (column, said) in what.table().columns.iter().zip(json["columns"].as_array().unwrap()) {
            let said = ["name", "unit", "meaning"].map(|key| said[key].as_str().unwrap());
            assert_eq!(said, [column.name, column.unit, column.meaning]);
        }
    }
}

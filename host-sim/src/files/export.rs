//! Tables in the formats that other tools read: Parquet (pandas, Polars, DuckDB), MCAP (PlotJuggler,
//! Foxglove, Rerun), NumPy's `.npz`, CSV; by the file's extension.

use crate::error::{Failure, Outcome};
use crate::files::output;
use mcap::records::MessageHeader;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use std::path::Path;
use std::sync::Arc;
use twinrotor_sim::flight::{Reading, Row};
use zip::write::SimpleFileOptions;

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// Of numbers.
    Numbers(Vec<f64>),
    /// Of words.
    Words(Vec<String>),
}

/// Columns of the same length with their names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// In order.
    pub columns: Vec<(String, Column)>,
}

/// What a path's extension may be.
const EXTENSIONS: [&str; 4] = ["parquet", "mcap", "npz", "csv"];

fn extension(path: &Path) -> Option<&str> {
    path.extension().and_then(|e| e.to_str()).filter(|e| EXTENSIONS.contains(e))
}

/// Refuses, before any work is done, a path that could not be written or whose extension says nothing. Only
/// what has a time can be a `.mcap`.
pub fn check(flag: &str, path: &Path, timed: bool) -> Outcome<()> {
    match extension(path) {
        Some("mcap") if !timed => {}
        Some(_) => return output::check(flag, path),
        None => {}
    }
    let allowed = if timed { ".parquet, .mcap, .npz or .csv" } else { ".parquet, .npz or .csv" };
    Err(Failure::Input(format!("{flag} is '{}'; allowed: a name that ends in {allowed}", path.display())))
}

fn failed(path: &Path, error: impl std::fmt::Display) -> Failure {
    Failure::Run(format!("{}: cannot be written: {error}", path.display()))
}

impl Table {
    /// A flight, SI units, the columns of `simulate --csv`.
    pub fn of_flight(rows: &[Row]) -> Self {
        let columns: [(&str, Reading); 11] = [
            ("t", |r| (r.time * 1e6).round() / 1e6),
            ("theta", |r| r.state.angle.pitch),
            ("theta_dot", |r| r.state.rate.pitch),
            ("psi", |r| r.state.angle.yaw),
            ("psi_dot", |r| r.state.rate.yaw),
            ("theta_ref", |r| r.reference.pitch),
            ("psi_ref", |r| r.reference.yaw),
            ("v_main", |r| r.volts.main),
            ("v_tail", |r| r.volts.tail),
            ("dist_main", |r| r.disturbance.main),
            ("dist_tail", |r| r.disturbance.tail),
        ];
        let mut table = Self::default();
        for (name, of) in columns {
            table.push(name, Column::Numbers(rows.iter().map(of).collect()));
        }
        table
    }

    /// Adds a column, as long as those before it.
    pub fn push(&mut self, name: &str, column: Column) {
        self.columns.push((name.to_owned(), column));
    }

    fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| match column {
            Column::Numbers(x) => x.len(),
            Column::Words(x) => x.len(),
        })
    }

    /// Writes it in the format that the path's extension names, which [`check`] has approved.
    pub fn write(&self, path: &Path) -> Outcome<()> {
        let bytes = match extension(path) {
            Some("parquet") => self.to_parquet().map_err(|e| failed(path, e))?,
            Some("mcap") => self.to_mcap().map_err(|e| failed(path, e))?,
            Some("npz") => self.to_npz().map_err(|e| failed(path, e))?,
            _ => self.to_csv().into_bytes(),
        };
        output::write(path, &bytes)
    }

    /// Shortest digits that give the same bits back.
    pub fn to_csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..self.rows() {
            for (k, (_, column)) in self.columns.iter().enumerate() {
                let comma = if k == 0 { "" } else { "," };
                let _ = match column {
                    Column::Numbers(x) => write!(text, "{comma}{}", x[row]),
                    Column::Words(x) => write!(text, "{comma}{}", x[row]),
                };
            }
            text.push('\n');
        }
        text
    }

    fn to_parquet(&self) -> parquet::errors::Result<Vec<u8>> {
        let fields: String = self
            .columns
            .iter()
            .map(|(name, column)| match column {
                Column::Numbers(_) => format!("REQUIRED DOUBLE {name};"),
                Column::Words(_) => format!("REQUIRED BYTE_ARRAY {name} (UTF8);"),
            })
            .collect();
        let schema = Arc::new(parse_message_type(&format!("message table {{ {fields} }}"))?);
        let mut bytes = Vec::new();
        let mut writer =
            SerializedFileWriter::new(&mut bytes, schema, Arc::new(WriterProperties::default()))?;
        let mut group = writer.next_row_group()?;
        for (_, column) in &self.columns {
            let Some(mut place) = group.next_column()? else { break };
            match column {
                Column::Numbers(x) => place.typed::<DoubleType>().write_batch(x, None, None)?,
                Column::Words(x) => {
                    let words: Vec<ByteArray> = x.iter().map(|w| w.as_str().into()).collect();
                    place.typed::<ByteArrayType>().write_batch(&words, None, None)?
                }
            };
            place.close()?;
        }
        group.close()?;
        writer.close()?;
        Ok(bytes)
    }

    /// One channel, `/flight`, of JSON messages with a schema; the first column is the time \[s\].
    fn to_mcap(&self) -> mcap::McapResult<Vec<u8>> {
        let numbers: Vec<(&str, &[f64])> = self
            .columns
            .iter()
            .filter_map(|(name, column)| match column {
                Column::Numbers(x) => Some((name.as_str(), x.as_slice())),
                Column::Words(_) => None,
            })
            .collect();
        let properties: serde_json::Map<String, serde_json::Value> = numbers
            .iter()
            .map(|(name, _)| ((*name).to_owned(), serde_json::json!({"type": "number"})))
            .collect();
        let schema = serde_json::json!({"title": "Flight", "type": "object", "properties": properties});
        let mut writer = mcap::Writer::new(Cursor::new(Vec::new()))?;
        let schema = writer.add_schema("twinrotor.Flight", "jsonschema", schema.to_string().as_bytes())?;
        let channel = writer.add_channel(schema, "/flight", "json", &BTreeMap::new())?;
        for row in 0..self.rows() {
            let message: serde_json::Map<String, serde_json::Value> =
                numbers.iter().map(|(name, x)| ((*name).to_owned(), x[row].into())).collect();
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "an hour of nanoseconds"
            )]
            let time = (numbers[0].1[row] * 1e9).round() as u64;
            let sequence = u32::try_from(row).unwrap_or(u32::MAX);
            let header = MessageHeader { channel_id: channel, sequence, log_time: time, publish_time: time };
            writer
                .write_to_known_channel(&header, serde_json::Value::Object(message).to_string().as_bytes())?;
        }
        writer.finish()?;
        Ok(writer.into_inner().into_inner())
    }

    fn to_npz(&self) -> zip::result::ZipResult<Vec<u8>> {
        let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
        for (name, column) in &self.columns {
            archive.start_file(format!("{name}.npy"), options)?;
            archive.write_all(&npy(column))?;
        }
        Ok(archive.finish()?.into_inner())
    }
}

/// One array in NumPy's format 1.0 (numpy.lib.format).
fn npy(column: &Column) -> Vec<u8> {
    let (descriptor, data): (String, Vec<u8>) = match column {
        Column::Numbers(x) => ("<f8".to_owned(), x.iter().flat_map(|v| v.to_le_bytes()).collect()),
        Column::Words(x) => {
            let longest = x.iter().map(|w| w.chars().count()).max().unwrap_or(0).max(1);
            let padded = |w: &String| {
                let letters = w.chars().map(u32::from).chain(std::iter::repeat(0)).take(longest);
                letters.flat_map(u32::to_le_bytes).collect::<Vec<u8>>()
            };
            (format!("<U{longest}"), x.iter().flat_map(padded).collect())
        }
    };
    let count = match column {
        Column::Numbers(x) => x.len(),
        Column::Words(x) => x.len(),
    };
    let mut header = format!("{{'descr': '{descriptor}', 'fortran_order': False, 'shape': ({count},), }}");
    // Magic, version, length and header together fill whole blocks of 64 bytes, the last one a line's end.
    let used = 10 + header.len() + 1;
    header.push_str(&" ".repeat(used.next_multiple_of(64) - used));
    header.push('\n');
    let length = u16::try_from(header.len()).expect("a header of two lines");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(length.to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    fn table() -> Table {
        let mut table = Table::default();
        table.push("t", Column::Numbers(vec![0.0, 0.001, 0.002]));
        table.push("theta", Column::Numbers(vec![0.1, f64::MIN_POSITIVE, -2.5]));
        table.push("name", Column::Words(vec!["a".into(), "grey wolf".into(), "ψ".into()]));
        table
    }

    #[test]
    fn parquet_reads_back_to_the_bit() {
        let file = tempfile::NamedTempFile::with_suffix(".parquet").unwrap();
        table().write(file.path()).unwrap();
        let reader = SerializedFileReader::new(std::fs::File::open(file.path()).unwrap()).unwrap();
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[1].get_double(1).unwrap(), f64::MIN_POSITIVE);
        assert_eq!(rows[2].get_string(2).unwrap(), "ψ");
    }

    #[test]
    fn mcap_reads_back_in_order_and_time() {
        let bytes = table().to_mcap().unwrap();
        let messages: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
        assert_eq!(messages.len(), 3);
        assert_eq!((messages[2].log_time, messages[2].channel.topic.as_str()), (2_000_000, "/flight"));
        let told: serde_json::Value = serde_json::from_slice(&messages[2].data).unwrap();
        assert_eq!(told["theta"], -2.5);
    }

    /// The layout that numpy.lib.format documents.
    #[test]
    fn an_array_of_numpys_starts_at_a_block_and_has_its_shape() {
        let bytes = npy(&table().columns[2].1);
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0);
        let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
        assert!(header.contains("'<U9'") && header.contains("(3,)") && header.ends_with('\n'), "{header}");
        assert_eq!(bytes.len(), 10 + length + 3 * 9 * 4);
    }

    #[test]
    fn a_format_that_is_not_there_is_named() {
        let told = check("--export", Path::new("x.xlsx"), true).unwrap_err().to_string();
        assert!(told.contains("x.xlsx") && told.contains(".mcap"), "{told}");
        assert!(check("--export", Path::new("x.mcap"), false).is_err());
    }
}

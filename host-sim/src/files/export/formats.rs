//! The formats that take other people's crates.

use mcap::records::MessageHeader;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::sync::Arc;
use twinrotor_sim::table::{Column, Table};
use zip::write::SimpleFileOptions;

pub(super) fn to_parquet(table: &Table) -> parquet::errors::Result<Vec<u8>> {
    let fields: String = table
        .columns
        .iter()
        .map(|(name, column)| match column {
            Column::Numbers(_) => format!("REQUIRED DOUBLE {name};"),
            Column::Counts(_) => format!("REQUIRED INT64 {name} (INTEGER(64,false));"),
            Column::Words(_) => format!("REQUIRED BYTE_ARRAY {name} (UTF8);"),
        })
        .collect();
    let schema = Arc::new(parse_message_type(&format!("message table {{ {fields} }}"))?);
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::new(WriterProperties::default()))?;
    let mut group = writer.next_row_group()?;
    for (_, column) in &table.columns {
        let Some(mut place) = group.next_column()? else { break };
        match column {
            Column::Numbers(x) => place.typed::<DoubleType>().write_batch(x, None, None)?,
            // Parquet writes down a number without a sign by its bits.
            Column::Counts(x) => {
                let bits: Vec<i64> = x.iter().map(|count| count.cast_signed()).collect();
                place.typed::<Int64Type>().write_batch(&bits, None, None)?
            }
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
pub(super) fn to_mcap(table: &Table) -> mcap::McapResult<Vec<u8>> {
    let properties: serde_json::Map<String, serde_json::Value> = table
        .columns
        .iter()
        .map(|(name, column)| {
            let kind = match column {
                Column::Numbers(_) => "number",
                Column::Counts(_) => "integer",
                Column::Words(_) => "string",
            };
            (name.clone(), serde_json::json!({"type": kind}))
        })
        .collect();
    let schema = serde_json::json!({"title": "Flight", "type": "object", "properties": properties});
    let mut writer = mcap::Writer::new(Cursor::new(Vec::new()))?;
    let schema = writer.add_schema("twinrotor.Flight", "jsonschema", schema.to_string().as_bytes())?;
    let channel = writer.add_channel(schema, "/flight", "json", &BTreeMap::new())?;
    let Some((_, Column::Numbers(seconds))) = table.columns.first() else {
        return Err(mcap::McapError::Io(std::io::Error::other("the first column is no time")));
    };
    for (row, second) in seconds.iter().enumerate() {
        let message: serde_json::Map<String, serde_json::Value> =
            table.columns.iter().map(|(name, column)| (name.clone(), json(column, row))).collect();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an hour of nanoseconds")]
        let time = (second * 1e9).round() as u64;
        let sequence = u32::try_from(row).unwrap_or(u32::MAX);
        let header = MessageHeader { channel_id: channel, sequence, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, serde_json::Value::Object(message).to_string().as_bytes())?;
    }
    writer.finish()?;
    Ok(writer.into_inner().into_inner())
}

pub(super) fn to_npz(table: &Table) -> zip::result::ZipResult<Vec<u8>> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, column) in &table.columns {
        archive.start_file(format!("{name}.npy"), options)?;
        archive.write_all(&npy(column))?;
    }
    Ok(archive.finish()?.into_inner())
}

fn json(column: &Column, row: usize) -> serde_json::Value {
    match column {
        Column::Numbers(x) => x[row].into(),
        Column::Counts(x) => x[row].into(),
        Column::Words(x) => x[row].as_str().into(),
    }
}

/// One array in NumPy's format 1.0 (numpy.lib.format).
fn npy(column: &Column) -> Vec<u8> {
    let (descriptor, data): (String, Vec<u8>) = match column {
        Column::Numbers(x) => ("<f8".to_owned(), x.iter().flat_map(|v| v.to_le_bytes()).collect()),
        Column::Counts(x) => ("<u8".to_owned(), x.iter().flat_map(|v| v.to_le_bytes()).collect()),
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
        Column::Counts(x) => x.len(),
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
        table.push("seed", Column::Counts(vec![1, (1 << 53) + 1, u64::MAX]));
        table.push("name", Column::Words(vec!["a".into(), "grey wolf".into(), "ψ".into()]));
        table
    }

    #[test]
    fn parquet_reads_back_to_the_bit() {
        let file = tempfile::NamedTempFile::with_suffix(".parquet").unwrap();
        std::fs::write(file.path(), super::super::bytes(&table(), file.path()).unwrap()).unwrap();
        let reader = SerializedFileReader::new(std::fs::File::open(file.path()).unwrap()).unwrap();
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[1].get_double(1).unwrap(), f64::MIN_POSITIVE);
        assert_eq!((rows[1].get_ulong(2).unwrap(), rows[2].get_ulong(2).unwrap()), ((1 << 53) + 1, u64::MAX));
        assert_eq!(rows[2].get_string(3).unwrap(), "ψ");
    }

    #[test]
    fn mcap_reads_back_in_order_and_time() {
        let bytes = to_mcap(&table()).unwrap();
        let messages: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
        assert_eq!(messages.len(), 3);
        assert_eq!((messages[2].log_time, messages[2].channel.topic.as_str()), (2_000_000, "/flight"));
        let told: serde_json::Value = serde_json::from_slice(&messages[2].data).unwrap();
        assert_eq!(told, serde_json::json!({"t": 0.002, "theta": -2.5, "seed": u64::MAX, "name": "ψ"}));
    }

    /// The layout that numpy.lib.format documents.
    #[test]
    fn an_array_of_numpys_starts_at_a_block_and_has_its_shape() {
        let bytes = npy(&table().columns[3].1);
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0);
        let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
        assert!(header.contains("'<U9'") && header.contains("(3,)") && header.ends_with('\n'), "{header}");
        assert_eq!(bytes.len(), 10 + length + 3 * 9 * 4);
    }
}

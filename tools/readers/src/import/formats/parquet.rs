//! Apache Parquet: flat columns of numbers are series. Read by `parquet`, without its compressors in C.

use bytes::Bytes;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::{Format, Series, guarded, unreadable};
use crate::import::Refusal;

pub(super) const FORMAT: Format = Format {
    name: "a Parquet file",
    is: |head| head.starts_with(b"PAR1"),
    read,
    help: "write one column of numbers per channel, with Snappy, gzip, LZ4 or no compression: \
           frame.to_parquet('loop.parquet', compression='snappy')",
};

fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Vec<Series>, Refusal> {
    let bytes = Bytes::copy_from_slice(bytes);
    let found = guarded(move || series(bytes)).map_err(|reason| unreadable(&FORMAT, reason))?;
    if !found.1.is_empty() {
        notes.push(format!("columns without numbers were not used: {}", found.1.join(", ")));
    }
    Ok(found.0)
}

fn series(bytes: Bytes) -> Result<(Vec<Series>, Vec<String>), String> {
    let told = |error: parquet::errors::ParquetError| error.to_string();
    let file = SerializedFileReader::new(bytes).map_err(told)?;
    let schema = file.metadata().file_metadata().schema_descr_ptr();
    let (mut found, mut passed) = (Vec::new(), Vec::new());
    for (index, column) in schema.columns().iter().enumerate() {
        let name = column.path().string();
        if column.max_rep_level() > 0 {
            passed.push(format!("`{name}`"));
            continue;
        }
        let (mut values, mut first) = (Vec::new(), None);
        let mut numeric = true;
        for group in 0..file.num_row_groups() {
            let group = file.get_row_group(group).map_err(told)?;
            let rows = usize::try_from(group.metadata().num_rows()).map_err(|error| error.to_string())?;
            let reader = group.get_column_reader(index).map_err(told)?;
            numeric &= append(reader, column, rows, &mut first, &mut values)?;
        }
        match numeric {
            true => found.push(Series { clock: seconds(column).is_some(), ..Series::new("", &name, values) }),
            false => passed.push(format!("`{name}`")),
        }
    }
    Ok((found, passed))
}

/// What a stamp of time counts, in seconds.
fn seconds(column: &ColumnDescriptor) -> Option<f64> {
    let of = |unit: &TimeUnit| match unit {
        TimeUnit::MILLIS => 1e-3,
        TimeUnit::MICROS => 1e-6,
        TimeUnit::NANOS => 1e-9,
    };
    match (column.logical_type_ref(), column.converted_type()) {
        (Some(LogicalType::Timestamp(stamp)), _) => Some(of(&stamp.unit)),
        (_, ConvertedType::TIMESTAMP_MILLIS) => Some(1e-3),
        (_, ConvertedType::TIMESTAMP_MICROS) => Some(1e-6),
        _ => None,
    }
}

/// The rows of a group; those without a value are NaN. `false` for what holds no numbers.
fn append(
    reader: ColumnReader,
    column: &ColumnDescriptor,
    rows: usize,
    first: &mut Option<i64>,
    out: &mut Vec<f64>,
) -> Result<bool, String> {
    match reader {
        ColumnReader::DoubleColumnReader(reader) => rows_of(reader, column, rows, out, |value| *value)?,
        ColumnReader::FloatColumnReader(reader) => {
            rows_of(reader, column, rows, out, |value| f64::from(*value))?
        }
        ColumnReader::Int32ColumnReader(reader) => {
            rows_of(reader, column, rows, out, |value| f64::from(*value))?
        }
        ColumnReader::Int64ColumnReader(reader) => match seconds(column) {
            // Counted from the first: a date in nanoseconds has more digits than a number of floating point.
            Some(size) => rows_of(reader, column, rows, out, |value| {
                value.saturating_sub(*first.get_or_insert(*value)) as f64 * size
            })?,
            None => rows_of(reader, column, rows, out, |value| *value as f64)?,
        },
        _ => return Ok(false),
    }
    Ok(true)
}

fn rows_of<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    column: &ColumnDescriptor,
    rows: usize,
    out: &mut Vec<f64>,
    mut number: impl FnMut(&T::T) -> f64,
) -> Result<(), String> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let mut left = rows;
    while left > 0 {
        let (read, _, _) = reader
            .read_records(left, Some(&mut levels), None, &mut values)
            .map_err(|error| error.to_string())?;
        if read == 0 {
            return Err("a column has fewer rows than the table".to_owned());
        }
        left -= read.min(left);
    }
    if column.max_def_level() == 0 {
        out.extend(values.iter().map(number));
        return Ok(());
    }
    let mut present = values.iter();
    let whole = column.max_def_level();
    out.extend(
        levels.iter().map(|level| {
            if *level == whole { present.next().map_or(f64::NAN, &mut number) } else { f64::NAN }
        }),
    );
    Ok(())
}

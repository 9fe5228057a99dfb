//! Tables as CSV, JSON, Parquet and Arrow, row by row, in a memory that does not depend on the number of rows.

use std::io::{self, Write};
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray, UInt64Array};
use arrow_ipc::writer::FileWriter;
use arrow_schema::{DataType, Field, Schema};
use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde_json::Value as Json;

use column_twin::study::{ColumnKind, TableColumn, TableValue};

/// Rows of a row group of Parquet and of a record batch of Arrow.
const GROUP_ROWS: usize = 65_536;

/// What a file says about itself, by name.
pub(super) type Metadata = [(&'static str, String)];

/// Writes a table in one format.
pub(super) trait TableWriter<W> {
    /// Writes a row.
    fn row(&mut self, values: &[TableValue<'_>]) -> io::Result<()>;
    /// Writes what is left, with what is known only at the end, and returns the target.
    fn finish(self: Box<Self>, closing: &Metadata) -> io::Result<W>;
}

/// CSV: a header with the unit in every name, then one row per line. A value that does not exist is empty. Numbers read back to the
/// same bits.
pub(super) struct CsvTable<W: Write>(csv::Writer<W>);

impl<W: Write> CsvTable<W> {
    pub fn new(target: W, columns: &[TableColumn]) -> io::Result<Self> {
        let mut table = csv::Writer::from_writer(target);
        table.write_record(columns.iter().map(|column| &column.name))?;
        Ok(Self(table))
    }
}

impl<W: Write> TableWriter<W> for CsvTable<W> {
    fn row(&mut self, values: &[TableValue<'_>]) -> io::Result<()> {
        for value in values {
            match value {
                TableValue::Whole(Some(number)) => self.0.write_field(number.to_string())?,
                TableValue::Number(Some(number)) => self.0.write_field(format!("{number:?}"))?,
                TableValue::Text(Some(text)) => self.0.write_field(text)?,
                _ => self.0.write_field("")?,
            }
        }
        // The end of a row.
        Ok(self.0.write_record(None::<&[u8]>)?)
    }

    fn finish(self: Box<Self>, _: &Metadata) -> io::Result<W> {
        self.0.into_inner().map_err(csv::IntoInnerError::into_error)
    }
}

/// JSON: an object with what the file says about itself and the list of rows, one per line. A value that does not exist is null.
pub(super) struct JsonTable<W: Write> {
    target: W,
    columns: Vec<TableColumn>,
    rows: u64,
}

impl<W: Write> JsonTable<W> {
    /// `list` is the name of the list.
    pub fn new(
        mut target: W,
        columns: &[TableColumn],
        metadata: &Metadata,
        list: &str,
    ) -> io::Result<Self> {
        target.write_all(b"{\n")?;
        for (name, text) in metadata {
            writeln!(target, "  {}: {},", Json::from(*name), as_json(text))?;
        }
        write!(target, "  {}: [", Json::from(list))?;
        Ok(Self {
            target,
            columns: columns.to_vec(),
            rows: 0,
        })
    }
}

/// Metadata that is JSON is a part of the document, anything else is a text.
fn as_json(text: &str) -> Json {
    serde_json::from_str(text).unwrap_or_else(|_| Json::from(text))
}

impl<W: Write> TableWriter<W> for JsonTable<W> {
    fn row(&mut self, values: &[TableValue<'_>]) -> io::Result<()> {
        let separator = if self.rows == 0 { "" } else { "," };
        write!(self.target, "{separator}\n    {{")?;
        for (number, (column, value)) in self.columns.iter().zip(values).enumerate() {
            let value = match value {
                TableValue::Whole(number) => Json::from(*number),
                // Infinities and NaN are null, too.
                TableValue::Number(number) => Json::from(*number),
                TableValue::Text(text) => Json::from(*text),
            };
            let separator = if number == 0 { "" } else { "," };
            write!(
                self.target,
                "{separator}{}:{value}",
                Json::from(column.name.as_str())
            )?;
        }
        self.rows += 1;
        self.target.write_all(b"}")
    }

    fn finish(mut self: Box<Self>, closing: &Metadata) -> io::Result<W> {
        self.target.write_all(b"\n  ]")?;
        for (name, text) in closing {
            write!(self.target, ",\n  {}: {}", Json::from(*name), as_json(text))?;
        }
        self.target.write_all(b"\n}\n")?;
        Ok(self.target)
    }
}

/// A column of a group of rows.
enum GroupColumn {
    Whole(Vec<Option<u64>>),
    Number(Vec<Option<f64>>),
    Text(Vec<Option<String>>),
}

/// Rows that are collected until they are written together.
struct Group {
    columns: Vec<GroupColumn>,
    rows: usize,
}

impl Group {
    fn new(columns: &[TableColumn]) -> Self {
        let columns = columns.iter().map(|column| match column.kind {
            ColumnKind::Whole => GroupColumn::Whole(Vec::new()),
            ColumnKind::Number => GroupColumn::Number(Vec::new()),
            ColumnKind::Text => GroupColumn::Text(Vec::new()),
        });
        Self {
            columns: columns.collect(),
            rows: 0,
        }
    }

    fn push(&mut self, values: &[TableValue<'_>]) {
        for (column, value) in self.columns.iter_mut().zip(values) {
            match (column, value) {
                (GroupColumn::Whole(column), TableValue::Whole(number)) => column.push(*number),
                (GroupColumn::Number(column), TableValue::Number(number)) => {
                    column.push(number.filter(|it| it.is_finite()));
                }
                (GroupColumn::Text(column), TableValue::Text(text)) => {
                    column.push(text.map(str::to_owned));
                }
                // A value of another kind than its column is missing, so that the columns stay equally long.
                (GroupColumn::Whole(column), _) => column.push(None),
                (GroupColumn::Number(column), _) => column.push(None),
                (GroupColumn::Text(column), _) => column.push(None),
            }
        }
        self.rows += 1;
    }

    fn clear(&mut self) {
        for column in &mut self.columns {
            match column {
                GroupColumn::Whole(column) => column.clear(),
                GroupColumn::Number(column) => column.clear(),
                GroupColumn::Text(column) => column.clear(),
            }
        }
        self.rows = 0;
    }
}

/// Parquet, compressed with Snappy.
pub(super) struct ParquetTable<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    group: Group,
}

impl<W: Write + Send> ParquetTable<W> {
    pub fn new(target: W, columns: &[TableColumn], metadata: &Metadata) -> io::Result<Self> {
        let field = |column: &TableColumn| {
            let (physical, logical) = match column.kind {
                ColumnKind::Whole => (PhysicalType::INT64, None),
                ColumnKind::Number => (PhysicalType::DOUBLE, None),
                ColumnKind::Text => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
            };
            Type::primitive_type_builder(&column.name, physical)
                .with_repetition(Repetition::OPTIONAL)
                .with_logical_type(logical)
                .build()
                .map(Arc::new)
        };
        let fields: Result<Vec<_>, _> = columns.iter().map(field).collect();
        let schema = Type::group_type_builder("map")
            .with_fields(fields.map_err(io::Error::other)?)
            .build()
            .map_err(io::Error::other)?;
        let metadata = metadata.iter().map(key_value).collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(format!("column_twin {}", env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata(Some(metadata))
            .build();
        let writer = SerializedFileWriter::new(target, Arc::new(schema), Arc::new(properties));
        Ok(Self {
            writer: writer.map_err(io::Error::other)?,
            group: Group::new(columns),
        })
    }

    fn write_group(&mut self) -> parquet::errors::Result<()> {
        let mut rows = self.writer.next_row_group()?;
        for column in &self.group.columns {
            let Some(mut writer) = rows.next_column()? else {
                break;
            };
            match column {
                GroupColumn::Whole(column) => {
                    // A number of a cell is below 1e8.
                    let there: Vec<i64> = column.iter().flatten().map(|it| *it as i64).collect();
                    writer
                        .typed::<Int64Type>()
                        .write_batch(&there, Some(&levels(column)), None)?;
                }
                GroupColumn::Number(column) => {
                    let there: Vec<f64> = column.iter().flatten().copied().collect();
                    writer.typed::<DoubleType>().write_batch(
                        &there,
                        Some(&levels(column)),
                        None,
                    )?;
                }
                GroupColumn::Text(column) => {
                    let there = column
                        .iter()
                        .flatten()
                        .map(|it| ByteArray::from(it.as_str()));
                    let there: Vec<_> = there.collect();
                    writer.typed::<ByteArrayType>().write_batch(
                        &there,
                        Some(&levels(column)),
                        None,
                    )?;
                }
            }
            writer.close()?;
        }
        rows.close()?;
        self.group.clear();
        Ok(())
    }
}

fn key_value((name, text): &(&'static str, String)) -> KeyValue {
    KeyValue::new((*name).to_owned(), text.clone())
}

/// Definition levels: 1 where a value is there.
fn levels<T>(column: &[Option<T>]) -> Vec<i16> {
    column
        .iter()
        .map(|value| i16::from(value.is_some()))
        .collect()
}

impl<W: Write + Send> TableWriter<W> for ParquetTable<W> {
    fn row(&mut self, values: &[TableValue<'_>]) -> io::Result<()> {
        self.group.push(values);
        match self.group.rows {
            GROUP_ROWS => self.write_group().map_err(io::Error::other),
            _ => Ok(()),
        }
    }

    fn finish(mut self: Box<Self>, closing: &Metadata) -> io::Result<W> {
        if self.group.rows > 0 {
            self.write_group().map_err(io::Error::other)?;
        }
        for pair in closing {
            self.writer.append_key_value_metadata(key_value(pair));
        }
        self.writer.into_inner().map_err(io::Error::other)
    }
}

/// The file format of Arrow.
pub(super) struct ArrowTable<W: Write> {
    writer: FileWriter<W>,
    schema: Arc<Schema>,
    group: Group,
}

impl<W: Write> ArrowTable<W> {
    pub fn new(target: W, columns: &[TableColumn], metadata: &Metadata) -> io::Result<Self> {
        let field = |column: &TableColumn| {
            let kind = match column.kind {
                ColumnKind::Whole => DataType::UInt64,
                ColumnKind::Number => DataType::Float64,
                ColumnKind::Text => DataType::Utf8,
            };
            let about = [("unit", column.unit), ("meaning", column.meaning)];
            let about = about.map(|(name, text)| (name.to_owned(), text.to_owned()));
            Field::new(&column.name, kind, true).with_metadata(about.into())
        };
        let fields: Vec<_> = columns.iter().map(field).collect();
        let metadata = metadata
            .iter()
            .map(|(name, text)| ((*name).to_owned(), text.clone()));
        let schema = Arc::new(Schema::new_with_metadata(fields, metadata.collect()));
        Ok(Self {
            writer: FileWriter::try_new(target, &schema).map_err(io::Error::other)?,
            schema,
            group: Group::new(columns),
        })
    }

    fn write_group(&mut self) -> io::Result<()> {
        let arrays = self.group.columns.iter().map(|column| -> ArrayRef {
            match column {
                GroupColumn::Whole(column) => Arc::new(UInt64Array::from(column.clone())),
                GroupColumn::Number(column) => Arc::new(Float64Array::from(column.clone())),
                GroupColumn::Text(column) => Arc::new(StringArray::from(column.clone())),
            }
        });
        let batch = RecordBatch::try_new(self.schema.clone(), arrays.collect());
        self.writer
            .write(&batch.map_err(io::Error::other)?)
            .map_err(io::Error::other)?;
        self.group.clear();
        Ok(())
    }
}

impl<W: Write> TableWriter<W> for ArrowTable<W> {
    fn row(&mut self, values: &[TableValue<'_>]) -> io::Result<()> {
        self.group.push(values);
        match self.group.rows {
            GROUP_ROWS => self.write_group(),
            _ => Ok(()),
        }
    }

    fn finish(mut self: Box<Self>, closing: &Metadata) -> io::Result<W> {
        if self.group.rows > 0 {
            self.write_group()?;
        }
        for (name, text) in closing {
            self.writer.write_metadata(*name, text.as_str());
        }
        self.writer.into_inner().map_err(io::Error::other)
    }
}

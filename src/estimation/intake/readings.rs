//! Recorded readings of sensors, as a table in a CSV file.

use std::cell::Cell;
use std::io::{self, Read, Write};

use crate::sensors::Sensor;
use printable::Printable;

/// Most rows of a table: ten minutes at 10 kHz.
const MAX_ROWS: usize = 6_000_000;

/// Largest file that is read \[byte\].
const MAX_BYTES: u64 = 1 << 30;

/// Longest row, with the comments before it \[byte\].
const MAX_ROW_BYTES: u64 = 1 << 20;

/// How much of a text from a table an error shows \[characters\].
const MAX_SHOWN: usize = 60;

/// Fewest distances between readings that tell their rate.
const LEAST_DISTANCES: usize = 19;

/// A table as it is read, up to a length of each row and of the whole.
struct BoundedRows<'a, R> {
    source: R,
    /// What may still be read of the current row \[byte\].
    row_left: &'a Cell<u64>,
}

impl<R: Read> Read for BoundedRows<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = self.row_left.get();
        if left == 0 {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                format!("a row is longer than {MAX_ROW_BYTES} bytes"),
            ));
        }
        let read = (&mut self.source).take(left).read(buffer)?;
        self.row_left.set(left - read as u64);
        Ok(read)
    }
}

/// Readings of some sensors: rows in the order of time, each with the values of all sensors, NaN where one is missing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Readings {
    /// Time of each row \[s\].
    pub times: Vec<f64>,
    /// Values row by row, sensor by sensor.
    pub values: Vec<f64>,
    /// Number of sensors.
    pub sensors: usize,
}

/// Why a table is rejected.
#[derive(Debug, thiserror::Error)]
pub enum ReadingsError {
    /// The bytes are no CSV.
    #[error("expected a table of comma-separated values: {0}")]
    Csv(#[from] csv::Error),
    /// A column is missing.
    #[error("expected a column `{name}`; found {}", list(found))]
    NoColumn {
        /// Its name.
        name: String,
        /// The columns.
        found: Vec<String>,
    },
    /// A column belongs to no sensor.
    #[error(
        "the column `{name}` belongs to no sensor of sensors.names; expected time and {}",
        list(known)
    )]
    UnknownSensor {
        /// Its name.
        name: String,
        /// The sensors.
        known: Vec<String>,
    },
    /// A column appears twice.
    #[error("the column `{name}` appears twice; expected one for each sensor")]
    Twice {
        /// Its name.
        name: String,
    },
    /// A cell is no number.
    #[error("line {line}, column `{column}`: expected a number or nothing, found `{found}`")]
    NoNumber {
        /// Its line, from 1.
        line: u64,
        /// Its column.
        column: String,
        /// Its text.
        found: String,
    },
    /// Times do not increase.
    #[error("line {line}: the time {found} s does not follow {before} s; sort the rows by time")]
    NotSorted {
        /// Its line, from 1.
        line: u64,
        /// The time \[s\].
        found: f64,
        /// The time before \[s\].
        before: f64,
    },
    /// Too many rows.
    #[error("the table has more than {MAX_ROWS} rows; cut it to the time of the impact")]
    TooLong,
    /// Too many bytes.
    #[error("the table has more than {MAX_BYTES} bytes; cut it to the time of the impact")]
    TooLarge,
    /// No rows.
    #[error("the table has no rows")]
    Empty,
}

fn list(names: &[String]) -> String {
    shown(&names.join(", "))
}

/// A text from a table as it may appear in an error: escaped, and of a bounded length.
fn shown(text: &str) -> String {
    let begin: String = text.chars().take(MAX_SHOWN).collect();
    let rest = if begin.len() < text.len() { "..." } else { "" };
    format!("{}{rest}", Printable(&begin))
}

impl Readings {
    /// Samples per second of a sensor by the times of its readings, the median of their distances; `None` for fewer than 20.
    #[must_use]
    pub fn rate_of(&self, sensor: usize) -> Option<f64> {
        let present = self.rows().filter(|(_, values)| values[sensor].is_finite());
        let times: Vec<f64> = present.map(|(time, _)| time).collect();
        let mut distances: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if distances.len() < LEAST_DISTANCES {
            return None;
        }
        distances.sort_by(f64::total_cmp);
        Some(1.0 / distances[distances.len() / 2])
    }

    /// Reads a table with a column `time` \[s\] and one column for each sensor, by its name. Empty cells are missing samples.
    /// A sensor without a column has no samples, as long as one has.
    ///
    /// # Errors
    /// The first fault of the table, with its line and column.
    pub fn from_csv(text: impl Read, sensors: &[Sensor]) -> Result<Self, ReadingsError> {
        let row_left = Cell::new(MAX_ROW_BYTES);
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .from_reader(BoundedRows {
                source: text.take(MAX_BYTES + 1),
                row_left: &row_left,
            });
        let header: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
        let known: Vec<String> = sensors.iter().map(|sensor| sensor.name.clone()).collect();
        let no_column = |name: &str| ReadingsError::NoColumn {
            name: name.to_owned(),
            found: header.clone(),
        };
        let time_column = header.iter().position(|name| name == "time");
        let time_column = time_column.ok_or_else(|| no_column("time"))?;
        let mut columns = Vec::new();
        for (column, name) in header.iter().enumerate() {
            if header[..column].contains(name) {
                return Err(ReadingsError::Twice { name: shown(name) });
            }
            if column != time_column {
                let sensor = known.iter().position(|it| it == name);
                let sensor = sensor.ok_or_else(|| ReadingsError::UnknownSensor {
                    name: shown(name),
                    known: known.clone(),
                })?;
                columns.push((column, sensor));
            }
        }
        if columns.is_empty() {
            return Err(no_column(known.first().map_or("", String::as_str)));
        }
        let mut readings = Self {
            sensors: sensors.len(),
            ..Self::default()
        };
        let mut row = csv::StringRecord::new();
        while reader.read_record(&mut row)? {
            row_left.set(MAX_ROW_BYTES);
            let line = row.position().map_or(0, csv::Position::line);
            let number = |column: usize| {
                let text = row.get(column).unwrap_or("");
                let fault = || ReadingsError::NoNumber {
                    line,
                    column: header[column].clone(),
                    found: shown(text),
                };
                match text {
                    "" => Ok(f64::NAN),
                    text => text.parse::<f64>().map_err(|_| fault()),
                }
            };
            let time = number(time_column)?;
            if !time.is_finite() {
                return Err(ReadingsError::NoNumber {
                    line,
                    column: "time".into(),
                    found: shown(row.get(time_column).unwrap_or("")),
                });
            }
            if let Some(&before) = readings.times.last()
                && time <= before
            {
                return Err(ReadingsError::NotSorted {
                    line,
                    found: time,
                    before,
                });
            }
            if readings.times.len() == MAX_ROWS {
                return Err(ReadingsError::TooLong);
            }
            readings.times.push(time);
            let first = readings.values.len();
            readings.values.resize(first + sensors.len(), f64::NAN);
            for &(column, sensor) in &columns {
                readings.values[first + sensor] = number(column)?;
            }
        }
        if reader.position().byte() > MAX_BYTES {
            return Err(ReadingsError::TooLarge);
        }
        if readings.times.is_empty() {
            return Err(ReadingsError::Empty);
        }
        Ok(readings)
    }

    /// Writes the table that [`Readings::from_csv`] reads.
    ///
    /// # Errors
    /// Those of the target.
    pub fn write_csv(&self, target: impl Write, sensors: &[Sensor]) -> Result<(), csv::Error> {
        let mut writer = csv::Writer::from_writer(target);
        writer.write_field("time")?;
        for sensor in sensors {
            writer.write_field(&sensor.name)?;
        }
        writer.write_record(None::<&[u8]>)?;
        for (time, values) in self.rows() {
            writer.write_field(time.to_string())?;
            for value in values {
                let text = if value.is_nan() {
                    String::new()
                } else {
                    value.to_string()
                };
                writer.write_field(text)?;
            }
            writer.write_record(None::<&[u8]>)?;
        }
        writer.flush()?;
        Ok(())
    }

    /// The rows: time and values.
    pub fn rows(&self) -> impl Iterator<Item = (f64, &[f64])> {
        let values = self.values.chunks_exact(self.sensors.max(1));
        self.times.iter().copied().zip(values)
    }
}

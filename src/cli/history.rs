//! The history of a response as a table.

use std::io::{self, Write};

use column_twin::column::Sample;
use column_twin::observables::history;

/// Writes samples as CSV: a header with the unit in every name, then one row per sample. Numbers read back to the same
/// bits.
pub struct HistoryWriter<W: Write> {
    table: csv::Writer<W>,
    row: csv::StringRecord,
    masses: usize,
}

impl<W: Write> HistoryWriter<W> {
    /// Writes the header for a vehicle of so many masses, 0 for a rigid one.
    ///
    /// # Errors
    /// The target cannot be written to.
    pub fn new(target: W, masses: usize) -> io::Result<Self> {
        let mut table = csv::Writer::from_writer(target);
        let names = history(masses).map(|(it, index)| it.in_histories(index));
        table
            .write_record(names.collect::<Vec<_>>())
            .map_err(cause)?;
        Ok(Self {
            table,
            row: csv::StringRecord::new(),
            masses,
        })
    }

    /// Writes a row.
    ///
    /// # Errors
    /// The target cannot be written to.
    pub fn write(&mut self, sample: &Sample) -> io::Result<()> {
        self.row.clear();
        for (it, index) in history(self.masses) {
            self.row.push_field(&exact(it.value(sample, index)));
        }
        self.table.write_record(&self.row).map_err(cause)
    }

    /// Flushes the buffer and returns the target.
    ///
    /// # Errors
    /// The target cannot be written to.
    pub fn finish(self) -> io::Result<W> {
        self.table
            .into_inner()
            .map_err(csv::IntoInnerError::into_error)
    }
}

/// Why a row could not be written, with the kind of the error, by which a pipe is known that its reader has closed.
fn cause(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(cause) => cause,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// The shortest text that reads back to the same number.
fn exact(value: f64) -> String {
    format!("{value:?}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::reference::Reference;
    use column_twin::column::BaseForces;

    #[test]
    fn a_history_reads_back_to_the_same_bits() {
        let mut samples = Reference::ellipse().samples;
        // The reference has no reactions of the base.
        for sample in &mut samples {
            sample.base = BaseForces {
                shear: 2.0 * sample.v1,
                moment: 3.0 * sample.v1,
                normal_force: 5.0 * sample.v1,
            };
        }
        let mut writer = HistoryWriter::new(Vec::new(), 0).unwrap();
        samples
            .iter()
            .for_each(|sample| writer.write(sample).unwrap());
        let text = writer.finish().unwrap();
        let mut table = csv::Reader::from_reader(&text[..]);
        let header = table.headers().unwrap().clone();
        let place = |name: &str| header.iter().position(|column| column == name).unwrap();
        let rows: Vec<_> = table.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), samples.len());
        for (row, sample) in rows.iter().zip(&samples) {
            let value = |name: &str| row[place(name)].parse::<f64>().unwrap().to_bits();
            assert_eq!(value("t_s"), sample.time.to_bits());
            assert_eq!(value("u2_m"), sample.u2.to_bits());
            assert_eq!(value("Na_N"), sample.hinges[3].normal_force.to_bits());
            assert_eq!(value("M1b_Nm"), sample.hinges[1].moment.to_bits());
            assert_eq!(
                value("utilisation_3"),
                sample.hinges[3].utilisation.to_bits()
            );
            assert_eq!(value("base_shear_N"), sample.base.shear.to_bits());
            assert_eq!(value("base_moment_Nm"), sample.base.moment.to_bits());
            assert_eq!(
                value("base_normal_force_N"),
                sample.base.normal_force.to_bits()
            );
        }
    }

    #[test]
    fn names_are_those_of_the_reference() {
        let text = include_str!("../../tests/data/heb220_ellipse.csv");
        let writer = HistoryWriter::new(Vec::new(), 0).unwrap();
        let writer = writer.finish().unwrap();
        let ours: Vec<_> = std::str::from_utf8(&writer)
            .unwrap()
            .trim()
            .split(',')
            .collect();
        for name in text.lines().next().unwrap().split(',') {
            assert!(ours.contains(&name), "{name} is missing in {ours:?}");
        }
    }
}

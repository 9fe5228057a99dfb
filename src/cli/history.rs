//! The history of a response as a table.

use std::io::{self, Write};

use column_twin::column::{
    HINGE_NAMES, HingeSample, HingeState, MAX_MASSES, Phase, Sample, VehicleSample,
};

/// Writes samples as CSV: a header with the unit in every name, then one row per sample. Numbers read back to the same
/// bits.
pub struct HistoryWriter<W: Write> {
    table: csv::Writer<W>,
    row: csv::StringRecord,
    /// Masses of the vehicle, each with the spring in front of it; 0 for a rigid one.
    masses: usize,
}

type Column = (&'static str, fn(&Sample) -> f64);
type VehicleColumn = (
    &'static str,
    &'static str,
    fn(&VehicleSample) -> [f64; MAX_MASSES],
);
type HingeColumn = (&'static str, &'static str, fn(&HingeSample) -> f64);

/// Columns of column and impactor, named as in `tests/data/heb220_ellipse.csv`. `Na` is the normal force of hinges 1a and
/// 3, `Nb` that of 1b and 2.
const COLUMNS: [Column; 24] = [
    ("t_s", |sample| sample.time),
    ("v1_m", |sample| sample.v1),
    ("u1_m", |sample| sample.u1),
    ("beta1_rad", |sample| sample.beta1),
    ("u2_m", |sample| sample.u2),
    ("vc_m", |sample| sample.impactor_position),
    ("v1dot_m_s", |sample| sample.v1_rate),
    ("u1dot_m_s", |sample| sample.u1_rate),
    ("u2dot_m_s", |sample| sample.u2_rate),
    ("vcdot_m_s", |sample| sample.impactor_velocity),
    ("gap_m", |sample| sample.gap),
    ("Na_N", |sample| sample.hinges[0].normal_force),
    ("Nb_N", |sample| sample.hinges[1].normal_force),
    ("contact_force_N", |sample| sample.contact_force),
    ("percussion_Ns", |sample| sample.percussion),
    ("impulse_Ns", |sample| sample.impulse),
    ("kinetic_energy_J", |sample| sample.kinetic_energy),
    ("elastic_energy_J", |sample| sample.elastic_energy),
    ("plastic_work_J", |sample| sample.plastic_work),
    ("impact_loss_J", |sample| sample.impact_loss),
    ("damping_work_J", |sample| sample.damping_work),
    ("load_work_J", |sample| sample.load_work),
    ("ledger_residual_J", |sample| sample.ledger_residual),
    ("in_contact", |sample| {
        f64::from(u8::from(sample.phase == Phase::Contact))
    }),
];

/// Columns of every hinge: text before its name, unit, and value.
const HINGE_COLUMNS: [HingeColumn; 8] = [
    ("M", "Nm", |hinge| hinge.moment),
    ("theta", "rad", |hinge| hinge.rotation),
    ("delta", "m", |hinge| hinge.elongation),
    ("theta_p", "rad", |hinge| hinge.plastic_rotation),
    ("delta_p", "m", |hinge| hinge.plastic_elongation),
    ("utilisation", "-", |hinge| hinge.utilisation),
    ("dynamic_factor", "-", |hinge| hinge.dynamic_factor),
    // 0 elastic, 1 plastic, 2 unloaded.
    ("state", "-", |hinge| match hinge.state {
        HingeState::Elastic => 0.0,
        HingeState::Plastic => 1.0,
        HingeState::Unloaded => 2.0,
    }),
];

/// Columns of every spring of a compliant vehicle and of the mass behind it, numbered from the front: text before the
/// number, unit, and values.
const VEHICLE_COLUMNS: [VehicleColumn; 5] = [
    ("crush", "m", |vehicle| vehicle.crush),
    ("permanent_crush", "m", |vehicle| vehicle.permanent_crush),
    ("crush_force", "N", |vehicle| vehicle.force),
    ("vehicle_dissipated", "J", |vehicle| vehicle.dissipated),
    ("vehicle_velocity", "m_s", |vehicle| vehicle.velocity),
];

impl<W: Write> HistoryWriter<W> {
    /// Writes the header for a vehicle of so many masses, 0 for a rigid one.
    ///
    /// # Errors
    /// The target cannot be written to.
    pub fn new(target: W, masses: usize) -> io::Result<Self> {
        let mut table = csv::Writer::from_writer(target);
        let mut header: Vec<String> = COLUMNS.iter().map(|(name, _)| (*name).to_owned()).collect();
        for (before, unit, _) in HINGE_COLUMNS {
            header.extend(HINGE_NAMES.iter().map(|hinge| match unit {
                "-" => format!("{before}_{hinge}"),
                _ => format!("{before}{hinge}_{unit}"),
            }));
        }
        for (before, unit, _) in VEHICLE_COLUMNS {
            header.extend((1..=masses).map(|number| format!("{before}{number}_{unit}")));
        }
        if masses > 0 {
            header.push("vehicle_elastic_energy_J".to_owned());
        }
        table.write_record(&header).map_err(cause)?;
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
        for (_, value) in COLUMNS {
            self.row.push_field(&exact(value(sample)));
        }
        for (_, _, value) in HINGE_COLUMNS {
            for hinge in &sample.hinges {
                self.row.push_field(&exact(value(hinge)));
            }
        }
        for (_, _, values) in VEHICLE_COLUMNS {
            for value in &values(&sample.vehicle)[..self.masses] {
                self.row.push_field(&exact(*value));
            }
        }
        if self.masses > 0 {
            let stored = exact(sample.vehicle.elastic_energy);
            self.row.push_field(&stored);
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

    #[test]
    fn a_history_reads_back_to_the_same_bits() {
        let samples = Reference::ellipse().samples;
        let mut writer = HistoryWriter::new(Vec::new(), 0).unwrap();
        samples
            .iter()
            .for_each(|sample| writer.write(sample).unwrap());
        let text = writer.finish().unwrap();
        let mut table = csv::Reader::from_reader(&text[..]);
        let header = table.headers().unwrap().clone();
        assert_eq!(header.len(), COLUMNS.len() + 4 * HINGE_COLUMNS.len());
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

//! What the sensors would read of a rigid vehicle by the fibre beam, which has the mass of the column along its length: the waves and
//! the modes that the two bars do not have.

use column_beam::{BeamColumn, Instrument, Sampling, Steel, history};

use crate::column::Impact;
use crate::parameters::{BeamMode, Parameters, ShearModel};
use crate::second_opinion::beam_column;
use crate::sensors::{Quantity, Sensor};

/// Elements of the beam. With 20, masses of made impacts are found 5 % too large, with 28 it is 4 %.
const ELEMENTS: usize = 28;

/// Time between two readings \[s\].
pub(crate) const PERIOD: f64 = 1e-4;

/// Steps between two readings: with one, masses are found 10 % too large.
const STEPS: u32 = 2;

/// Factors of what the parameters describe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Factors {
    pub yield_strength: f64,
    pub young_modulus: f64,
    pub density: f64,
    pub load: f64,
}

/// The undamaged column as a beam, with instruments in the places of its sensors.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BeamReadings {
    column: BeamColumn,
    /// With the index of the sensor.
    instruments: Vec<(usize, Instrument)>,
}

impl BeamReadings {
    /// `None` for a column without a second opinion, where the beam is switched off, and without a sensor of displacement or bending
    /// strain. The beam says nothing of rotations, axial strains and forces.
    pub fn new(parameters: &Parameters, sensors: &[Sensor]) -> Option<Self> {
        if parameters.settings().beam.mode == BeamMode::Off {
            return None;
        }
        let as_beam = beam_column(parameters).ok()?;
        let is_shear_known = parameters.settings().shear.model != ShearModel::None;
        let each = sensors.iter().enumerate();
        let instruments = each.filter_map(|(index, sensor)| {
            let instrument = match sensor.quantity {
                Quantity::Displacement => Instrument::Displacement(sensor.height),
                Quantity::Acceleration => Instrument::Acceleration(sensor.height),
                Quantity::BendingStrain => Instrument::BendingStrain(sensor.height),
                Quantity::Rotation | Quantity::AxialStrain | Quantity::ContactForce => return None,
            };
            Some((index, instrument))
        });
        let instruments: Vec<_> = instruments.collect();
        let is_level = |it: &(usize, Instrument)| !matches!(it.1, Instrument::Acceleration(_));
        instruments.iter().any(is_level).then_some(Self {
            instruments,
            column: BeamColumn {
                elements: ELEMENTS,
                shear: as_beam.shear && is_shear_known,
                bumper_height: 0.0,
                residual_stress: false,
                bow: 0.0,
                ..as_beam
            },
        })
    }

    /// The sensors that it predicts.
    pub fn sensors(&self) -> impl Iterator<Item = usize> {
        self.instruments.iter().map(|(index, _)| *index)
    }

    /// What they read from contact on, one row for each [`PERIOD`], as many as wanted; `None` where the beam does not follow the impact so
    /// long, or the column collapses.
    pub fn follow(&self, impact: &Impact, factors: Factors, rows: usize) -> Option<Vec<Vec<f64>>> {
        let steel = self.column.steel;
        let column = BeamColumn {
            steel: Steel {
                yield_strength: factors.yield_strength * steel.yield_strength,
                young_modulus: factors.young_modulus * steel.young_modulus,
                density: factors.density * steel.density,
                ..steel
            },
            top_load: factors.load * self.column.top_load,
            ..self.column
        };
        let sampling = Sampling {
            period: PERIOD,
            steps: STEPS,
            samples: rows,
        };
        let instruments: Vec<_> = self.instruments.iter().map(|(_, it)| *it).collect();
        let found = history(&column, impact, &instruments, &sampling).ok()?;
        (found.rows.len() == rows).then_some(found.rows)
    }
}

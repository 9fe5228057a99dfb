//! What the model expects of the sensors: the modes of the column for every stiffness that its supports may have.

use std::f64::consts::PI;

use column_beam::{BeamColumn, BeamError, Mode, modes};

use crate::column::Support;
use crate::sensors::{Quantity, Sensor};

/// Natural frequencies that are looked at.
pub(super) const MODES: usize = 2;

/// Fixities of a support are this far apart.
pub(super) const STEP: f64 = 0.04;

/// Standard deviation of the fixity of a support about that of the parameters.
const FIXITY_DEVIATION: f64 = 0.25;

/// Lowest first frequency that is looked at, over that of the parameters.
const LEAST_FREQUENCY: f64 = 0.2;

/// The fixity of a support is `1 / (1 + 3 E I / (k L))`: 0 is a hinge, 1 is built in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fixity {
    /// `3 E I / L` \[N m/rad\].
    unit: f64,
}

impl Fixity {
    fn of(self, support: Support) -> f64 {
        match support {
            Support::BuiltIn => 1.0,
            Support::SemiRigid { stiffness } => stiffness / (stiffness + self.unit),
            Support::Pinned | Support::Free => 0.0,
        }
    }

    /// The rotational stiffness \[N m/rad\]; infinite for a fixity of 1.
    pub fn stiffness(self, fixity: f64) -> f64 {
        self.unit * fixity / (1.0 - fixity)
    }

    fn support(self, fixity: f64) -> Support {
        match fixity {
            _ if fixity <= 0.0 => Support::Pinned,
            _ if fixity >= 1.0 => Support::BuiltIn,
            _ => Support::SemiRigid {
                stiffness: self.stiffness(fixity),
            },
        }
    }
}

/// The column with one fixity of each support.
pub(super) struct Candidate {
    /// Of base and top.
    pub fixity: [f64; 2],
    /// How far the fixities are from those of the parameters, squared, over their variance.
    pub prior: f64,
    pub modes: Vec<Mode>,
}

/// The column with all fixities that its supports may have.
pub(super) struct Candidates {
    pub all: Vec<Candidate>,
    /// The one of the parameters.
    pub declared: Candidate,
    pub fixity: Fixity,
    /// Which supports turn against a stiffness.
    pub turns: [bool; 2],
    pub length: f64,
}

impl Candidates {
    /// # Errors
    /// A column that the beam does not take, or that buckles under its load.
    pub fn new(column: &BeamColumn) -> Result<Self, BeamError> {
        column.check()?;
        let fixity = Fixity {
            unit: 3.0 * column.bending_stiffness() / column.length(),
        };
        let supports = [column.base, column.top];
        let turns = supports.map(|it| it != Support::Free);
        let of_parameters = supports.map(|it| fixity.of(it));
        let places = |end: usize| -> Vec<f64> {
            let count = (1.0 / STEP).round() as usize;
            match turns[end] {
                true => (0..=count).map(|k| k as f64 / count as f64).collect(),
                false => vec![0.0],
            }
        };
        let on = |pair: [f64; 2]| -> Result<Candidate, BeamError> {
            let with = |end: usize| match turns[end] {
                true => fixity.support(pair[end]),
                false => Support::Free,
            };
            let (base, top) = (with(0), with(1));
            let off = [0, 1].map(|end| (pair[end] - of_parameters[end]) / FIXITY_DEVIATION);
            Ok(Candidate {
                fixity: pair,
                prior: off[0] * off[0] + off[1] * off[1],
                modes: modes(
                    &BeamColumn {
                        base,
                        top,
                        ..*column
                    },
                    MODES,
                )?,
            })
        };
        let declared = on(of_parameters)?;
        let mut all = Vec::new();
        for base in places(0) {
            // A column that its load would buckle does not stand here.
            let those = places(1).into_iter().filter_map(|top| on([base, top]).ok());
            // Nor does a cantilever on a hinge.
            all.extend(those.filter(|it| {
                it.modes[0].frequency > LEAST_FREQUENCY * declared.modes[0].frequency
            }));
        }
        Ok(Self {
            all,
            declared,
            fixity,
            turns,
            length: column.length(),
        })
    }

    /// Lowest and highest frequency of a mode \[Hz\], with the tolerance of a frequency.
    pub fn band(&self, mode: usize) -> [f64; 2] {
        let each = self.all.iter().map(|it| it.modes[mode].frequency);
        let [low, high] = each.fold([f64::INFINITY, 0.0_f64], |[low, high], it| {
            [low.min(it), high.max(it)]
        });
        [0.95 * low, 1.05 * high]
    }
}

/// Whether the vibration across the column shows in a sensor of this quantity.
pub(super) fn shows_vibration(quantity: Quantity) -> bool {
    match quantity {
        Quantity::Acceleration
        | Quantity::Displacement
        | Quantity::Rotation
        | Quantity::BendingStrain => true,
        Quantity::AxialStrain | Quantity::ContactForce => false,
    }
}

/// The quantities in which it shows, in words.
pub(super) fn vibrating() -> String {
    let all = Quantity::ALL.into_iter().filter(|it| shows_vibration(*it));
    let words: Vec<_> = all.map(|it| it.word().replace('_', " ")).collect();
    words.join(", ")
}

/// The amplitude that a sensor at a height shows of a vibration of this mode with an amplitude of 1 m: with its sign, and weakened by
/// its filter.
pub(super) fn reading(mode: &Mode, sensor: &Sensor, height: f64) -> f64 {
    let circular = 2.0 * PI * mode.frequency;
    let size = match sensor.quantity {
        Quantity::Displacement => mode.displacement(height),
        Quantity::Acceleration => -circular * circular * mode.displacement(height),
        Quantity::Rotation => mode.rotation(height),
        Quantity::BendingStrain => -sensor.fibre * mode.curvature(height),
        Quantity::AxialStrain | Quantity::ContactForce => 0.0,
    };
    let [re, im] = filter(sensor, mode.frequency);
    let passed = size * re.hypot(im);
    if sensor.reversed { -passed } else { passed }
}

/// The lag of the filter of a sensor at a frequency \[Hz\], as a complex number of size 1.
pub(super) fn lag(sensor: &Sensor, frequency: f64) -> [f64; 2] {
    let [re, im] = filter(sensor, frequency);
    [re, im].map(|it| it / re.hypot(im))
}

/// What the filter of a sensor, a Butterworth filter of second order, does to a vibration of this frequency \[Hz\].
fn filter(sensor: &Sensor, frequency: f64) -> [f64; 2] {
    let x = frequency / sensor.bandwidth;
    let (re, im) = (1.0 - x * x, 2.0_f64.sqrt() * x);
    let size = re * re + im * im;
    [re / size, -im / size]
}

//! What the model says that a sensor reads.
//!
//! The bars of the model are beams whose end moments are those of its hinges. Between the ends the bending moment is
//! linear, so that the elastic deflection from the chord of a bar is a cubic. With `s` from the end away from the impact
//! point (the base, the top) to the impact point, `x = s / L`, and the moments `M_e` at the end and `M_i` at the impact
//! point, positive as in the mechanics:
//!
//! ```text
//! turns of the ends from the chord   a_e = L (2 M_e - M_i) / (6 EI)      a_i = L (2 M_i - M_e) / (6 EI)
//! deflection                         v = v1 x + L (a_i x^2 (1 - x) - a_e x (1 - x)^2)
//! curvature                          v'' = (M_e (1 - x) - M_i x) / EI
//! ```
//!
//! The bars have no mass of their own between their ends: the flexural waves of the first milliseconds are not in these
//! readings.

use crate::column::{End, Model, State, residual_without_bumper};
use crate::sensors::{Quantity, Sensor};

/// Reads one sensor in a state of the column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    quantity: Quantity,
    below: bool,
    /// `x`.
    position: f64,
    length: f64,
    bending_stiffness: f64,
    axial_rigidity: f64,
    fibre: f64,
    sign: f64,
}

impl Probe {
    /// A sensor on this column, whose height lies on it.
    #[must_use]
    pub fn new(model: &Model, sensor: &Sensor) -> Self {
        Self {
            fibre: sensor.fibre,
            sign: if sensor.reversed { -1.0 } else { 1.0 },
            ..Self::ideal(model, sensor.quantity, sensor.height)
        }
    }

    /// An instrument without a direction or a fibre of its own, at a height on this column \[m above the base\].
    #[must_use]
    pub fn ideal(model: &Model, quantity: Quantity, height: f64) -> Self {
        let p = &model.properties;
        let below = height <= p.length_below;
        let [clear_below, clear_above] = p.clear_lengths();
        let (length, from_end) = match below {
            true => (clear_below, height),
            false => (clear_above, p.length_below + p.length_above - height),
        };
        Self {
            quantity,
            below,
            // Behind a bumper the column moves as the impact point does.
            position: (from_end / length).min(1.0),
            length,
            bending_stiffness: p.bending_stiffness,
            axial_rigidity: p.axial_rigidity,
            fibre: 0.0,
            sign: 1.0,
        }
    }

    /// The reading; for an acceleration the displacement, whose second derivative in time it is. It is not relative to the
    /// column at rest.
    #[must_use]
    pub fn read(&self, state: &State) -> f64 {
        let forces = match self.below {
            true => &state.forces.below,
            false => &state.forces.above,
        };
        let (x, length, v1) = (self.position, self.length, state.displacement.v1);
        let [at_impact, at_end] = forces.moment;
        let flexibility = length / (6.0 * self.bending_stiffness);
        let turn_end = flexibility * (2.0 * at_end - at_impact);
        let turn_impact = flexibility * (2.0 * at_impact - at_end);
        let reading = match self.quantity {
            Quantity::Displacement | Quantity::Acceleration => {
                let rest = 1.0 - x;
                v1 * x + length * (turn_impact * x * x * rest - turn_end * x * rest * rest)
            }
            Quantity::Rotation => {
                let slope = turn_impact * (2.0 * x - 3.0 * x * x)
                    - turn_end * (1.0 - 4.0 * x + 3.0 * x * x);
                let rotation = v1 / length + slope;
                if self.below { rotation } else { -rotation }
            }
            Quantity::BendingStrain => {
                -self.fibre * (at_end * (1.0 - x) - at_impact * x) / self.bending_stiffness
            }
            Quantity::AxialStrain => forces.normal / self.axial_rigidity,
            Quantity::ContactForce => state.contact_force,
        };
        self.sign * reading
    }

    /// By how much the turning of its bar changes the reading in a second: a mechanism does not bend further.
    fn turning(&self, state: &State) -> f64 {
        let v1 = state.velocity.v1;
        let rate = match self.quantity {
            Quantity::Displacement | Quantity::Acceleration => v1 * self.position,
            Quantity::Rotation if self.below => v1 / self.length,
            Quantity::Rotation => -v1 / self.length,
            Quantity::BendingStrain | Quantity::AxialStrain | Quantity::ContactForce => 0.0,
        };
        self.sign * rate
    }
}

/// Readings after the end of a response: the last one, and by how much it changes in a second.
#[derive(Debug, Clone, Copy)]
struct Settled {
    reading: f64,
    rate: f64,
}

/// Reads one sensor step by step, relative to the column at rest.
#[derive(Debug, Clone)]
pub(crate) struct SteppedProbe {
    probe: Probe,
    at_rest: f64,
    is_acceleration: bool,
    displacement: f64,
    velocity: f64,
    /// What it reads once the response is over.
    settled: Option<Settled>,
}

impl SteppedProbe {
    /// A sensor on this column at rest.
    pub fn new(model: &Model, at_rest: &State, sensor: &Sensor) -> Self {
        let probe = Probe::new(model, sensor);
        Self {
            at_rest: probe.read(at_rest),
            probe,
            is_acceleration: sensor.quantity == Quantity::Acceleration,
            displacement: 0.0,
            velocity: 0.0,
            settled: None,
        }
    }

    /// The reading after a step of `secs` seconds.
    pub fn read(&mut self, state: &State, secs: f64) -> f64 {
        if let Some(settled) = &mut self.settled {
            settled.reading += settled.rate * secs;
            return settled.reading;
        }
        let reading = self.probe.read(state) - self.at_rest;
        if !self.is_acceleration {
            return reading;
        }
        let velocity = (reading - self.displacement) / secs;
        let acceleration = (velocity - self.velocity) / secs;
        (self.displacement, self.velocity) = (reading, velocity);
        acceleration
    }

    /// The response is over: from now on it reads the column at rest, if it comes to rest. The last state of the response is
    /// somewhere in a vibration, and the column would stay there for ever if that were read.
    ///
    /// A column that gives way keeps its last velocity. If its readings stayed where its response ends, a column with a fractured hinge
    /// would read like one that has come to rest there.
    pub fn settle(&mut self, last: &State, sensor: &Sensor, rest: Option<&Rest>) {
        let still = |reading| Settled { reading, rate: 0.0 };
        self.settled = Some(match rest {
            _ if self.is_acceleration => still(0.0),
            Some(rest) => {
                let probe = Probe::new(&rest.model, sensor);
                still(probe.read(&rest.after) - probe.read(&rest.before))
            }
            None => Settled {
                reading: self.probe.read(last) - self.at_rest,
                rate: self.probe.turning(last),
            },
        });
    }
}

/// A column at rest before and after an impact, without a bumper before it.
#[derive(Debug, Clone)]
pub(crate) struct Rest {
    model: Model,
    before: State,
    pub after: State,
}

impl Rest {
    /// What a response on the column of `model` that ended so in `last` leaves behind; `None` if the column does not stand, or has
    /// no equilibrium. `at_rest` gives the column before the impact.
    pub fn after(
        model: &Model,
        last: &State,
        end: End,
        at_rest: impl Fn(&Model) -> State,
    ) -> Option<Self> {
        if matches!(end, End::Collapsed | End::Fractured) {
            return None;
        }
        let whole = model.without_bumper();
        Some(Self {
            after: residual_without_bumper(model, last, &whole)?,
            before: at_rest(&whole),
            model: whole,
        })
    }
}

//! Equilibrium without inertia: of the whole column with its plastic deformation frozen, and of its massless
//! unknowns.

use nalgebra::{Matrix4, Vector4};

use super::bar::{BarForces, BarStrain, PerBar, PlasticFlow};
use super::frame::{self, BarStiffness};
use super::geometry::{Chord, Displacement};
use super::model::Model;
use super::motion::collapse_of;
use super::newton::{self, NonlinearSystem};
use super::state::State;

/// Bound of the iterations for a massless top.
const MAX_MASSLESS_ITERATIONS: u32 = 30;

/// Force by which a massless top may be out of balance at the end of a midpoint step, relative to `N^p + P`. Nothing
/// builds on it: the equations of the scheme hold at `n + 1/2`.
const MASSLESS_TOLERANCE: f64 = 1e-9;

/// Elastic equilibrium of the whole column under its load.
struct Frozen<'a> {
    model: &'a Model,
    plastic: &'a PerBar<PlasticFlow>,
}

/// Chords and forces at one displacement.
#[derive(Default)]
struct Point {
    chords: PerBar<Chord>,
    forces: PerBar<BarForces>,
}

impl NonlinearSystem for Frozen<'_> {
    type Point = Point;

    fn evaluate(&self, u: &Displacement, point: &mut Point) -> Vector4<f64> {
        let frame = &self.model.frame;
        let chords = frame.chords(u);
        let forces = frame.elastic_forces(&chords, u, self.plastic);
        let mut residual = frame.internal_forces(&frame::gradients(&chords), &forces, u.u2);
        residual[3] -= self.model.properties.top_load;
        *point = Point { chords, forces };
        residual
    }

    fn jacobian(&self, point: &mut Point) -> Matrix4<f64> {
        let frame = &self.model.frame;
        frame.elastic_stiffness(&point.chords, &point.forces)
    }

    fn scale(&self) -> Vector4<f64> {
        let p = &self.model.properties;
        let force = p.resistance_axial + p.top_load;
        Vector4::new(force, force, p.resistance_moment, force)
    }

    fn model(&self) -> &Model {
        self.model
    }

    fn tolerance(&self) -> f64 {
        1e-13
    }
}

/// A column with its massless unknowns in equilibrium.
#[derive(Clone, Copy)]
pub(crate) struct Settled {
    pub displacement: Displacement,
    pub chords: PerBar<Chord>,
    pub forces: PerBar<BarForces>,
}

/// `beta1` and a massless `u2` in elastic equilibrium at the other displacements of `u`; `None` if there is none nearby.
///
/// `beta1` follows in closed form from `M_1b = M_1a`; what remains is one equation for `u2`.
pub(crate) fn settle_massless(
    model: &Model,
    mut u: Displacement,
    plastic: &PerBar<PlasticFlow>,
) -> Option<Settled> {
    let frame = &model.frame;
    let [joint, _] = frame.massless_stiffness();
    let properties = &model.properties;
    let tolerance = MASSLESS_TOLERANCE * (properties.resistance_axial + properties.top_load);
    let straight = |chord: &Chord, plastic| {
        BarStrain::of_chord(chord.elongation, chord.angle(), 0.0).minus(plastic)
    };
    let below_chord = Chord::new(frame.below.length, u.u1, u.v1);
    let mut below_strain = straight(&below_chord, &plastic.below);
    let moment_1a = frame.below.elastic(&below_strain).moment[0];
    let tangent = frame.above.elastic_tangent();
    for _ in 0..MAX_MASSLESS_ITERATIONS {
        let chord = Chord::new(frame.above.length, u.u2 - u.u1, frame.across_above(u.v1));
        let mut above_strain = straight(&chord, &plastic.above);
        u.beta1 = (moment_1a - frame.above.elastic(&above_strain).moment[0]) / joint;
        above_strain.rotation[0] += u.beta1;
        let above = frame.above.elastic(&above_strain);
        let gradient = chord.gradient();
        let residual = properties.top_spring_stiffness * u.u2
            - gradient.forces(&above).x
            - properties.top_load;
        if !model.top_is_massless() || residual.abs() <= tolerance {
            below_strain.rotation[0] -= u.beta1;
            let below = frame.below.elastic(&below_strain);
            return Some(Settled {
                displacement: u,
                chords: PerBar {
                    below: below_chord,
                    above: chord,
                },
                forces: PerBar { below, above },
            });
        }
        let k = BarStiffness::new(&gradient, &chord, &above, &tangent, 1.0);
        let stiffness = properties.top_spring_stiffness + k.xx - k.xt * k.tx / joint;
        if stiffness.is_nan() || stiffness <= 0.0 {
            return None;
        }
        u.u2 -= residual / stiffness;
    }
    None
}

/// The residual state: static equilibrium under the load with the plastic deformation of `state` frozen, at rest and
/// without an impactor. `None` if there is no equilibrium nearby, or only one that has lost its shape.
pub fn residual_state(model: &Model, state: &State) -> Option<State> {
    let system = Frozen {
        model,
        plastic: &state.plastic,
    };
    let solved = newton::solve(&system, state.displacement, &mut Point::default())?;
    let displacement = solved.increment;
    if collapse_of(model, &displacement).is_some() {
        return None;
    }
    let mut residual = State::settled(model, displacement, state.plastic);
    residual.set_accumulated_rotation(model, &state.accumulated_rotation());
    residual.set_webs(model, &state.webs);
    Some(residual)
}

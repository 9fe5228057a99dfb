//! How far the energy that is left in a column can carry it: whether it can still reach a yield surface, and between which
//! displacements of the impact point it stays.
//!
//! About the residual equilibrium the potential energy is `1/2 d' K d` for a displacement `d`, `K` the tangent stiffness with
//! its geometric part. The least energy in the half-space `g' d >= s` is `s^2 / (2 g' K^-1 g)`. The yield surface of a hinge
//! is convex, so that a polygon whose corners lie on it lies within it: a stress that reaches the surface has passed a side
//! `a . (m, n) = c` of the polygon before. With `g` the gradient of `a . (m, n)` and `s = c - a . (m_r, n_r)` the distance of
//! the residual stress from that side, the smallest of these energies over all sides of all hinges is a lower bound of what
//! it takes to yield. A web that yields in shear is treated as a hinge whose moment is the sum of both, with the resistance of the direction
//! in which it is weaker, a hinge that has softened by what is left of its moment. Resistances that grow with the strain rate or
//! have hardened only add to it.

use nalgebra::{Matrix4, Vector4};

use super::bar::{Bar, BarForces, PerBar};
use super::frame::{self, Frame};
use super::geometry::ChordGradient;
use super::model::Model;
use super::shear::axial_share;
use super::state::State;
use super::statics;
use super::yield_surface::YieldSurface;

/// Energy that is assumed to be left, relative to what is: the margin for the geometry, of which `K` knows the first order
/// only.
const MARGIN: f64 = 2.0;

/// Normal forces of the corners of the polygon, relative to the squash load.
const CORNERS: [f64; 7] = [0.0, 0.15, 0.3, 0.5, 0.7, 0.9, 1.0];

/// Sides of the polygon in the quarter of positive moments and normal forces: `(a_m, a_n, c)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Polygon {
    sides: [[f64; 3]; CORNERS.len() - 1],
}

impl Polygon {
    pub fn within(surface: &YieldSurface) -> Self {
        Self::through(|n| surface.cap_of(n))
    }

    /// Of a web that yields in shear.
    fn of_web() -> Self {
        Self::through(axial_share)
    }

    /// With its corners on the curve `m = cap(n)`.
    fn through(cap: impl Fn(f64) -> f64) -> Self {
        let corners = CORNERS.map(|n| [cap(n), n]);
        let mut sides = [[0.0; 3]; CORNERS.len() - 1];
        for (side, ends) in sides.iter_mut().zip(corners.windows(2)) {
            let [from, to] = [ends[0], ends[1]];
            let a = [to[1] - from[1], from[0] - to[0]];
            *side = [a[0], a[1], a[0] * from[0] + a[1] * from[1]];
        }
        Self { sides }
    }
}

/// Between which `v1` a column without contact stays \[m\]; `None` if its energy may suffice to yield, or if there is no stable residual
/// equilibrium.
pub(crate) fn elastic_reach(
    model: &Model,
    state: &State,
    polygons: &PerBar<Polygon>,
) -> Option<[f64; 2]> {
    // The lines of a connection are none of the polygon's sides.
    if model.properties.base_connection.is_some() {
        return None;
    }
    let residual = statics::residual_state(model, state)?;
    let potential = |state: &State| {
        let energies = state.energies(model);
        energies.elastic - energies.load_work
    };
    let left = state.energies(model).column_kinetic + potential(state) - potential(&residual);
    // Round-off of an energy that is a difference.
    let energy = MARGIN * left.max(0.0);
    if energy.is_nan() {
        return None;
    }
    let frame = &model.frame;
    let chords = frame.chords(&residual.displacement);
    let stiffness = frame.elastic_stiffness(&chords, &residual.forces);
    let flexibility = inverse(&stiffness)?;
    let gradients = frame::gradients(&chords);
    for (bar, forces, gradient, polygon, web, hinges, is_above) in [
        (
            &frame.below,
            &residual.forces.below,
            &gradients.below,
            &polygons.below,
            state.webs.below.least(),
            &state.strength.below,
            false,
        ),
        (
            &frame.above,
            &residual.forces.above,
            &gradients.above,
            &polygons.above,
            state.webs.above.least(),
            &state.strength.above,
            true,
        ),
    ] {
        if !stays_within(
            bar,
            forces,
            gradient,
            (
                polygon,
                web,
                hinges.map(|hinge| hinge.factors.moment.min(1.0)),
            ),
            is_above,
            &flexibility,
            energy,
        ) {
            return None;
        }
    }
    let swing = (2.0 * energy * flexibility[(0, 0)]).sqrt();
    let v1 = residual.displacement.v1;
    Some([v1 - swing, v1 + swing])
}

/// Whether an energy \[J\] does not suffice to bring either hinge of a bar to a side of the polygon, or its web, which bears `web` times
/// its undamaged resistance, to its own; `softened` is what the hinges have left of their moments.
fn stays_within(
    bar: &Bar,
    forces: &BarForces,
    gradient: &ChordGradient,
    (polygon, web, softened): (&Polygon, f64, [f64; 2]),
    is_above: bool,
    flexibility: &Matrix4<f64>,
    energy: f64,
) -> bool {
    let surface = &bar.surface;
    let [along, turn] = gradients_of(gradient, is_above);
    let normal = along * (bar.axial / surface.resistance_axial);
    let n = surface.relative_axial(forces.normal);
    let stays = |c: [f64; 2], moment: f64, resistance: f64, polygon: &Polygon| {
        // The rotation of the impact point turns the hinge there alone.
        let mut row = turn * (c[0] + c[1]);
        row[2] += if is_above { c[0] } else { -c[0] };
        let m = moment * (1.0 / resistance);
        let moment = row * (1.0 / resistance);
        let by_moment = flexibility * moment;
        let (mm, mn) = (moment.dot(&by_moment), normal.dot(&by_moment));
        let nn = normal.dot(&(flexibility * normal));
        for [a_m, a_n, c] in polygon.sides {
            for [a_m, a_n] in [[a_m, a_n], [a_m, -a_n], [-a_m, a_n], [-a_m, -a_n]] {
                let distance = c - (a_m * m + a_n * n);
                let compliance = a_m * a_m * mm + 2.0 * a_m * a_n * mn + a_n * a_n * nn;
                let enough = distance > 0.0 && distance * distance > 2.0 * energy * compliance;
                if !enough {
                    return false;
                }
            }
        }
        true
    };
    let (c, moment) = (&bar.rotational, &forces.moment);
    (0..2).all(|k| {
        let resistance = softened[k] * surface.resistance_moment;
        stays(c[k], moment[k], resistance, polygon)
    }) && bar.slider.as_ref().is_none_or(|slider| {
        let sum = moment[0] + moment[1];
        stays(
            slider.turning,
            sum,
            web * slider.resistance,
            &Polygon::of_web(),
        )
    })
}

/// Derivatives by `v1, u1, beta1, u2` of the elongation of a bar and of the angle of its chord.
fn gradients_of(gradient: &ChordGradient, is_above: bool) -> [Vector4<f64>; 2] {
    [
        (gradient.length_x, gradient.length_v),
        (gradient.angle_x, gradient.angle_v),
    ]
    .map(|(x, v)| {
        if is_above {
            Vector4::new(v, x, 0.0, -x)
        } else {
            Vector4::new(v, -x, 0.0, 0.0)
        }
    })
}

/// The inverse of a stiffness; `None` if it is not positive definite.
fn inverse(stiffness: &Matrix4<f64>) -> Option<Matrix4<f64>> {
    Some(stiffness.cholesky()?.inverse())
}

/// The polygons of both bars.
pub(crate) fn polygons(frame: &Frame) -> PerBar<Polygon> {
    PerBar {
        below: Polygon::within(&frame.below.surface),
        above: Polygon::within(&frame.above.surface),
    }
}

//! The two bars and the spring at the top: from displacements to deformations of the bars, from forces of the bars to
//! forces on the displacements, `f_int = B^T S` (Eqs 10, 15-16), and the tangent `B^T D B` with its geometric part.
//!
//! Rows and columns are in the order of `U`: `v1, u1, beta1, u2`.

use nalgebra::{Matrix4, Vector4};

use super::bar::{Bar, BarForces, BarStrain, BarTangent, PerBar, PlasticFlow};
use super::geometry::{Chord, ChordGradient, Displacement};

/// The elasto-plastic structure: two bars with their hinges, and the spring at the top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Bar a, below the impact point.
    pub below: Bar,
    /// Bar b, above it.
    pub above: Bar,
    /// `k_s` \[N/m\].
    pub top_spring_stiffness: f64,
    /// Whether nothing holds the top. Bar b then rides on the impact point: its chord does not see `v1`, its hinges have no
    /// stiffness, and without a load it has no force.
    pub top_is_free: bool,
}

impl Frame {
    /// Length of the shorter bar \[m\].
    pub(crate) fn shorter_bar(&self) -> f64 {
        self.below.length.min(self.above.length)
    }

    /// Elastic stiffness against `beta1` \[N m/rad\] and against `u2` \[N/m\] alone.
    pub(crate) fn massless_stiffness(&self) -> [f64; 2] {
        [
            self.below.rotational[0][0] + self.above.rotational[0][0],
            self.above.axial + self.top_spring_stiffness,
        ]
    }

    /// Extent of bar b across the column where the impact point is at `v1` \[m\].
    #[inline(always)]
    pub(crate) fn across_above(&self, v1: f64) -> f64 {
        if self.top_is_free { 0.0 } else { v1 }
    }

    /// Chords of both bars (Eqs 3-4, 7-8).
    pub(crate) fn chords(&self, u: &Displacement) -> PerBar<Chord> {
        PerBar {
            below: Chord::new(self.below.length, u.u1, u.v1),
            above: Chord::new(self.above.length, u.u2 - u.u1, self.across_above(u.v1)),
        }
    }

    /// Angles \[rad\] by which both chords turn over an increment, to first order.
    pub(crate) fn turns(&self, chords: &PerBar<Chord>, increment: &Displacement) -> PerBar<f64> {
        let Displacement { v1, u1, u2, .. } = *increment;
        PerBar {
            below: chords.below.turn_for(-u1, v1),
            above: chords.above.turn_for(u1 - u2, self.across_above(v1)),
        }
    }

    /// Forces of both bars with the plastic deformation frozen.
    pub(crate) fn elastic_forces(
        &self,
        chords: &PerBar<Chord>,
        u: &Displacement,
        plastic: &PerBar<PlasticFlow>,
    ) -> PerBar<BarForces> {
        let total = strains(chords, &angles(chords), u.beta1);
        PerBar {
            below: self.below.elastic(&total.below.minus(&plastic.below)),
            above: self.above.elastic(&total.above.minus(&plastic.above)),
        }
    }

    /// Internal forces on `v1, u1, beta1, u2` (Eq 16) \[N, N, N m, N\]; `spring_u2` is the `u2` at which the top spring
    /// is taken.
    pub(crate) fn internal_forces(
        &self,
        gradients: &PerBar<ChordGradient>,
        forces: &PerBar<BarForces>,
        spring_u2: f64,
    ) -> Vector4<f64> {
        let below = gradients.below.forces(&forces.below);
        let above = gradients.above.forces(&forces.above);
        Vector4::new(
            below.v + above.v,
            above.x - below.x,
            forces.above.moment[0] - forces.below.moment[0],
            self.top_spring_stiffness * spring_u2 - above.x,
        )
    }

    /// Derivative of the internal forces with the elastic law.
    pub(crate) fn elastic_stiffness(
        &self,
        chords: &PerBar<Chord>,
        forces: &PerBar<BarForces>,
    ) -> Matrix4<f64> {
        let tangents = PerBar {
            below: self.below.elastic_tangent(),
            above: self.above.elastic_tangent(),
        };
        self.stiffness(&gradients(chords), chords, forces, &tangents)
    }

    /// Derivative of the internal forces: `B^T D B` with the gradients `left` that weigh the forces, at the chords
    /// `right` where the tangents hold, plus the geometric part of `forces` there.
    pub(crate) fn stiffness(
        &self,
        left: &PerBar<ChordGradient>,
        right: &PerBar<Chord>,
        forces: &PerBar<BarForces>,
        tangents: &PerBar<BarTangent>,
    ) -> Matrix4<f64> {
        let a = BarStiffness::new(
            &left.below,
            &right.below,
            &forces.below,
            &tangents.below,
            -1.0,
        );
        let mut b = BarStiffness::new(
            &left.above,
            &right.above,
            &forces.above,
            &tangents.above,
            1.0,
        );
        if self.top_is_free {
            b = b.along_only();
        }
        // x_a = L_a - u1, x_b = L_b + u1 - u2.
        Matrix4::new(
            a.vv + b.vv,
            b.vx - a.vx,
            a.vt + b.vt,
            -b.vx,
            //
            b.xv - a.xv,
            a.xx + b.xx,
            b.xt - a.xt,
            -b.xx,
            //
            a.tv + b.tv,
            b.tx - a.tx,
            a.tt + b.tt,
            -b.tx,
            //
            -b.xv,
            -b.xx,
            -b.xt,
            b.xx + self.top_spring_stiffness,
        )
    }
}

/// Angles of both chords (Eqs 3-4) \[rad\].
pub(crate) fn angles(chords: &PerBar<Chord>) -> PerBar<f64> {
    PerBar {
        below: chords.below.angle(),
        above: chords.above.angle(),
    }
}

/// Total deformations of chords with known angles (Eqs 3-8): `theta_1a = theta_3 - beta1`, `theta_1b = theta_2 + beta1`.
pub(crate) fn strains(
    chords: &PerBar<Chord>,
    angles: &PerBar<f64>,
    beta1: f64,
) -> PerBar<BarStrain> {
    PerBar {
        below: BarStrain::of_chord(chords.below.elongation, angles.below, -beta1),
        above: BarStrain::of_chord(chords.above.elongation, angles.above, beta1),
    }
}

/// Gradients at both chords (Eq 10).
pub(crate) fn gradients(chords: &PerBar<Chord>) -> PerBar<ChordGradient> {
    PerBar {
        below: chords.below.gradient(),
        above: chords.above.gradient(),
    }
}

/// Forces of a bar along the extents of its chord \[N\].
pub(crate) struct ChordForces {
    pub x: f64,
    pub v: f64,
}

impl ChordGradient {
    /// The forces of a bar along the extents of its chord.
    pub(crate) fn forces(&self, forces: &BarForces) -> ChordForces {
        let bending = forces.moment[0] + forces.moment[1];
        ChordForces {
            x: forces.normal * self.length_x + bending * self.angle_x,
            v: forces.normal * self.length_v + bending * self.angle_v,
        }
    }
}

/// Stiffness of one bar against the extents `x`, `v` of its chord and against the rotation `t` of the impact point.
pub(crate) struct BarStiffness {
    pub xx: f64,
    xv: f64,
    pub xt: f64,
    vx: f64,
    vv: f64,
    vt: f64,
    pub tx: f64,
    tv: f64,
    tt: f64,
}

impl BarStiffness {
    /// Of a bar whose chord stays parallel to the column.
    fn along_only(self) -> Self {
        let Self { xx, .. } = self;
        Self {
            xx,
            xv: 0.0,
            xt: 0.0,
            vx: 0.0,
            vv: 0.0,
            vt: 0.0,
            tx: 0.0,
            tv: 0.0,
            tt: 0.0,
        }
    }

    /// `turn` is the sign of `beta1` in the rotation of the hinge at the impact point.
    pub(crate) fn new(
        left: &ChordGradient,
        right: &Chord,
        forces: &BarForces,
        tangent: &BarTangent,
        turn: f64,
    ) -> Self {
        let (l, r) = (left, right.gradient());
        let d = &tangent.rotational;
        // The angle of the chord turns both hinges, beta1 turns the one at the impact point alone.
        let axial_chord = tangent.mixed[0] + tangent.mixed[1];
        let joint_chord = d[0][0] + d[0][1];
        let chord_chord = joint_chord + d[1][0] + d[1][1];
        // Force and moment for a unit of each extent on the right.
        let axial_x = tangent.axial * r.length_x + axial_chord * r.angle_x;
        let axial_v = tangent.axial * r.length_v + axial_chord * r.angle_v;
        let bending_x = axial_chord * r.length_x + chord_chord * r.angle_x;
        let bending_v = axial_chord * r.length_v + chord_chord * r.angle_v;
        let [xx, xv, vv] = right.hessian(forces.normal, forces.moment[0] + forces.moment[1]);
        Self {
            xx: l.length_x * axial_x + l.angle_x * bending_x + xx,
            xv: l.length_x * axial_v + l.angle_x * bending_v + xv,
            xt: turn * (l.length_x * tangent.mixed[0] + l.angle_x * joint_chord),
            vx: l.length_v * axial_x + l.angle_v * bending_x + xv,
            vv: l.length_v * axial_v + l.angle_v * bending_v + vv,
            vt: turn * (l.length_v * tangent.mixed[0] + l.angle_v * joint_chord),
            tx: turn * (tangent.mixed[0] * r.length_x + joint_chord * r.angle_x),
            tv: turn * (tangent.mixed[0] * r.length_v + joint_chord * r.angle_v),
            tt: d[0][0],
        }
    }
}

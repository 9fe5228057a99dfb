//! The moments of a bar's two hinges within their caps: two hinges that an elastic law may couple.

/// Rotations that bring trial moments within their caps, and how much of them smaller caps would add.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CappedMoments {
    /// Plastic rotations \[rad\].
    pub rotation: [f64; 2],
    /// `-d(|p_0| + |p_1|)/dm` where both caps change alike \[rad/(N m)\].
    pub compliance: f64,
}

impl CappedMoments {
    /// `|p_0| + |p_1|` \[rad\].
    pub fn sum(&self) -> f64 {
        self.rotation[0].abs() + self.rotation[1].abs()
    }
}

/// The plastic rotations that bring each of the `trial` moments within `[-cap, cap]` with the least complementary
/// energy: `min 1/2 p' C p - trial' p + cap_0 |p_0| + cap_1 |p_1|`, solved by cases. `flexibility` is the inverse of each
/// stiffness on the diagonal of `c`, 0 for a hinge that bears no moment.
#[inline(always)]
pub(crate) fn cap_moments(
    c: &[[f64; 2]; 2],
    flexibility: [f64; 2],
    trial: [f64; 2],
    caps: [f64; 2],
) -> CappedMoments {
    let excess = [trial[0].abs() - caps[0], trial[1].abs() - caps[1]];
    let alone = |k: usize| excess[k].max(0.0).copysign(trial[k]) * flexibility[k];
    if excess[0] <= 0.0 && excess[1] <= 0.0 {
        return CappedMoments {
            rotation: [0.0; 2],
            compliance: 0.0,
        };
    }
    if c[0][1] == 0.0 {
        let active = excess.map(|excess| excess > 0.0);
        let pick = |k: usize, value: f64| if active[k] { value } else { 0.0 };
        return CappedMoments {
            rotation: [pick(0, alone(0)), pick(1, alone(1))],
            compliance: pick(0, flexibility[0]) + pick(1, flexibility[1]),
        };
    }
    for k in 0..2 {
        let p = alone(k);
        if p != 0.0 && (trial[1 - k] - c[0][1] * p).abs() <= caps[1 - k] {
            let mut rotation = [0.0; 2];
            rotation[k] = p;
            return CappedMoments {
                rotation,
                compliance: flexibility[k],
            };
        }
    }
    cap_both(c, trial, caps)
}

/// Both hinges of a coupled bar flow: of the four pairs of signs, the one that its rotations agree with.
fn cap_both(c: &[[f64; 2]; 2], trial: [f64; 2], caps: [f64; 2]) -> CappedMoments {
    let determinant = c[0][0] * c[1][1] - c[0][1] * c[1][0];
    let mut best = CappedMoments {
        rotation: [0.0; 2],
        compliance: 0.0,
    };
    let mut best_agreement = f64::NEG_INFINITY;
    for signs in [[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]] {
        let right = [trial[0] - signs[0] * caps[0], trial[1] - signs[1] * caps[1]];
        let rotation = [
            (c[1][1] * right[0] - c[0][1] * right[1]) / determinant,
            (c[0][0] * right[1] - c[1][0] * right[0]) / determinant,
        ];
        let agreement = (signs[0] * rotation[0]).min(signs[1] * rotation[1]);
        if agreement > best_agreement {
            best_agreement = agreement;
            best = CappedMoments {
                rotation,
                compliance: (c[0][0] + c[1][1] - 2.0 * signs[0] * signs[1] * c[0][1]) / determinant,
            };
        }
    }
    best
}

/// How stiff two hinges that harden are against their plastic rotations: `A = C + diag(h)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hardening {
    /// The diagonal of `A` \[N m/rad\].
    pub diagonal: [f64; 2],
    /// Its inverses, 0 for a hinge that bears no moment.
    pub flexibility: [f64; 2],
}

impl Hardening {
    /// `A` for the elastic stiffness `c`.
    pub fn stiffness(&self, c: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
        [[self.diagonal[0], c[0][1]], [c[1][0], self.diagonal[1]]]
    }

    /// How the hinges that rotate by `rotation` \[rad\] rotate further under `moments` \[N m\], which are 0 at the others.
    pub fn solved(&self, c: &[[f64; 2]; 2], rotation: [f64; 2], moments: [f64; 2]) -> [f64; 2] {
        let (d, f) = (&self.diagonal, &self.flexibility);
        if c[0][1] != 0.0 && rotation[0] != 0.0 && rotation[1] != 0.0 {
            let per_determinant = 1.0 / (d[0] * d[1] - c[0][1] * c[1][0]);
            [
                (d[1] * moments[0] - c[0][1] * moments[1]) * per_determinant,
                (d[0] * moments[1] - c[1][0] * moments[0]) * per_determinant,
            ]
        } else {
            [moments[0] * f[0], moments[1] * f[1]]
        }
    }

    /// Tangent of the moments with the caps held, `C - C A^-1 C` over the hinges that rotate by `rotation` \[rad\].
    pub fn frozen(&self, c: &[[f64; 2]; 2], rotation: [f64; 2]) -> [[f64; 2]; 2] {
        let restricted = |moments: [f64; 2]| {
            [0, 1].map(|k| match rotation[k] {
                0.0 => 0.0,
                _ => moments[k],
            })
        };
        let columns = [0, 1].map(|k| times(c, self.solved(c, rotation, restricted(c[k]))));
        [0, 1].map(|row| [0, 1].map(|column| c[row][column] - columns[column][row]))
    }
}

/// `c` times a vector.
pub(crate) fn times(c: &[[f64; 2]; 2], rotation: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| c[k][0] * rotation[0] + c[k][1] * rotation[1])
}

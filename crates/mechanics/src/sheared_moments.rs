//! The moments of a bar's two hinges within their caps and their sum within that of the web: three mechanisms, two moments.
//!
//! Mechanisms 0 and 1 are the hinges, mechanism 2 is the web, whose angle adds to the rotations of both. With the plastic
//! deformations `x` and the hardening `h` the energy `1/2 x' A x - t' x + sum_k cap_k |x_k|` is least, where `t` are the trial
//! moments and their sum, and `A = B' C B + diag(h)` with `B = [[1, 0, 1], [0, 1, 1]]`.

use super::capped_moments::{cap_moments, times};

/// A mechanism that does not flow may exceed its cap by this much, relative to it: round-off.
const TOLERANCE: f64 = 1e-12;

/// A pivot below this, relative to its diagonal, is round-off: the mechanisms are not independent.
const PIVOT: f64 = 1e-13;

/// Elastic stiffness, hardening and trial moments of a bar.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mechanisms<'a> {
    /// Stiffness of the moments against the hinge rotations \[N m/rad\].
    pub rotational: &'a [[f64; 2]; 2],
    /// Hardening of each mechanism \[N m/rad\].
    pub hardening: [f64; 3],
    /// The hinge that flows with the web, and both of them, once [`Mechanisms::cap`] has found that they do.
    pub together: Option<(usize, HingeAndWeb)>,
}

/// What the web bears in one direction \[N m\], and its hardening there \[N m/rad\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct WebCap {
    pub limit: f64,
    pub hardening: f64,
}

impl Mechanisms<'_> {
    /// `A` \[N m/rad\].
    fn matrix(&self) -> [[f64; 3]; 3] {
        let (c, h) = (self.rotational, &self.hardening);
        let [first, second] = [0, 1].map(|k| c[k][0] + c[k][1]);
        [
            [c[0][0] + h[0], c[0][1], first],
            [c[1][0], c[1][1] + h[1], second],
            [first, second, first + second + h[2]],
        ]
    }

    /// How the mechanisms of `active` deform under `right` \[N m\]; `None` if they are not independent.
    #[inline(always)]
    pub fn solve(&self, active: [bool; 3], right: [f64; 3]) -> Option<[f64; 3]> {
        let a = self.matrix();
        let mut x = [0.0; 3];
        match active {
            [false, false, false] => {}
            [true, true, true] => return eliminated(a, right),
            [true, true, false] => (x[0], x[1]) = pair(&a, &right, 0, 1)?,
            [true, false, true] => {
                [x[0], x[2]] = self.hinge_and_web(0)?.solve([right[0], right[2]])
            }
            [false, true, true] => {
                [x[1], x[2]] = self.hinge_and_web(1)?.solve([right[1], right[2]])
            }
            [true, false, false] => x[0] = single(&a, &right, 0)?,
            [false, true, false] => x[1] = single(&a, &right, 1)?,
            [false, false, true] => x[2] = single(&a, &right, 2)?,
        }
        Some(x)
    }

    /// The moments that the mechanisms of `active` take by their deformations under `right` \[N m\].
    pub fn taken(&self, active: [bool; 3], right: [f64; 3]) -> [f64; 2] {
        let right = [0, 1, 2].map(|k| if active[k] { right[k] } else { 0.0 });
        // Of three mechanisms that depend on each other two determine both moments.
        let x = self
            .solve(active, right)
            .or_else(|| self.solve([active[0], active[1], false], right))
            .unwrap_or_default();
        times(self.rotational, [x[0] + x[2], x[1] + x[2]])
    }

    /// The moments that are left of `trial` after the deformations `x`, and their sum \[N m\].
    fn left(&self, trial: [f64; 2], x: &[f64; 3]) -> [f64; 3] {
        let taken = times(self.rotational, [x[0] + x[2], x[1] + x[2]]);
        let [first, second] = [trial[0] - taken[0], trial[1] - taken[1]];
        [first, second, first + second]
    }

    /// The deformations \[rad\] that bring each of the `trial` moments within its cap, and their sum within that of the web in
    /// its direction, positive or negative, with the least complementary energy; the hardening of the web is set to that of
    /// the direction. `flexibility` is 0 for a hinge that bears no moment.
    pub fn cap(
        &mut self,
        flexibility: [f64; 2],
        trial: [f64; 2],
        hinge_caps: [f64; 2],
        web: [WebCap; 2],
    ) -> [f64; 3] {
        let cap_of = |sum: f64| &web[usize::from(sum < 0.0)];
        let sum = trial[0] + trial[1];
        if sum.abs() > cap_of(sum).limit
            && let Some(x) = self.with_web(flexibility, trial, hinge_caps, cap_of(sum), sum)
        {
            return x;
        }
        let c = self.rotational;
        let mut stiffness = *c;
        stiffness[0][0] += self.hardening[0];
        stiffness[1][1] += self.hardening[1];
        let flexibility = [0, 1].map(|k| match flexibility[k] {
            0.0 => 0.0,
            _ => 1.0 / stiffness[k][k],
        });
        let hinges = cap_moments(&stiffness, flexibility, trial, hinge_caps).rotation;
        let without = [hinges[0], hinges[1], 0.0];
        let sum = self.left(trial, &without)[2];
        let web = cap_of(sum);
        self.hardening[2] = web.hardening;
        if sum.abs() <= web.limit {
            return without;
        }
        // The web flows, in the direction of that sum.
        self.with_web(flexibility, trial, hinge_caps, web, sum)
            .unwrap_or_else(|| {
                let caps = [hinge_caps[0], hinge_caps[1], web.limit];
                self.enumerated(flexibility, trial, sum.signum(), caps)
            })
    }

    /// The deformations if the web flows in the direction of `sum`, alone or with the hinge that would be overstressed
    /// otherwise; `None` if neither satisfies all conditions.
    #[inline(always)]
    fn with_web(
        &mut self,
        flexibility: [f64; 2],
        trial: [f64; 2],
        hinge_caps: [f64; 2],
        web: &WebCap,
        sum: f64,
    ) -> Option<[f64; 3]> {
        self.hardening[2] = web.hardening;
        let sign = sum.signum();
        let turning = self.turning();
        let stiffness = turning[0] + turning[1] + web.hardening;
        if stiffness.is_nan() || stiffness <= 0.0 {
            return None;
        }
        let right = trial[0] + trial[1] - sign * web.limit;
        let alone = right / stiffness;
        let moment = [0, 1].map(|k| trial[k] - turning[k] * alone);
        let excess = [0, 1].map(|k| match flexibility[k] {
            0.0 => f64::NEG_INFINITY,
            _ => moment[k].abs() - hinge_caps[k],
        });
        if excess[0] <= 0.0 && excess[1] <= 0.0 {
            return (sign * alone >= 0.0).then_some([0.0, 0.0, alone]);
        }
        // What may be violated, as `violation`, which is relative to the largest moment.
        let tolerance = TOLERANCE * (trial[0].abs() + trial[1].abs());
        let first = usize::from(excess[1] > excess[0]);
        for k in [first, 1 - first] {
            if excess[k] > 0.0
                && let Some(pair) = self.hinge_and_web(k)
            {
                let (own, other) = (moment[k].signum(), 1 - k);
                let [rotation, angle] = pair.solve([trial[k] - own * hinge_caps[k], right]);
                let left =
                    trial[other] - self.rotational[other][k] * rotation - turning[other] * angle;
                let is_solution = left.abs() - hinge_caps[other] <= tolerance
                    && -own * rotation * pair.hinge <= tolerance
                    && -sign * angle * pair.web <= tolerance;
                if is_solution {
                    let mut x = [0.0, 0.0, angle];
                    x[k] = rotation;
                    let mut signs = [0.0, 0.0, sign];
                    signs[k] = own;
                    self.together = Some((k, pair));
                    return Some(forwards(x, signs));
                }
            }
        }
        None
    }

    /// By how much the moments fall with the angle of the web \[N m/rad\].
    #[inline(always)]
    fn turning(&self) -> [f64; 2] {
        let c = self.rotational;
        [c[0][0] + c[0][1], c[1][0] + c[1][1]]
    }

    /// Hinge `k` and the web; `None` if they are not independent.
    #[inline(always)]
    pub fn hinge_and_web(&self, k: usize) -> Option<HingeAndWeb> {
        let turning = self.turning();
        let hinge = self.rotational[k][k] + self.hardening[k];
        let web = turning[0] + turning[1] + self.hardening[2];
        let full = hinge * web;
        let determinant = full - turning[k] * turning[k];
        (determinant > PIVOT * full).then(|| HingeAndWeb {
            hinge,
            both: turning[k],
            web,
            per_determinant: 1.0 / determinant,
        })
    }

    /// The deformations if the mechanisms flow in the directions of `signs`, 0 for one that does not.
    fn flow(&self, signs: [f64; 3], trial: [f64; 2], caps: [f64; 3]) -> Option<[f64; 3]> {
        let trial = [trial[0], trial[1], trial[0] + trial[1]];
        let right = [0, 1, 2].map(|k| trial[k] - signs[k] * caps[k]);
        self.solve(signs.map(|sign| sign != 0.0), right)
    }

    /// By how much the deformations `x` violate the conditions of the least energy: a cap that is exceeded, or a flow against
    /// its sign, relative to the largest moment.
    fn violation(&self, x: &[f64; 3], signs: [f64; 3], trial: [f64; 2], caps: [f64; 3]) -> f64 {
        let left = self.left(trial, x);
        let size = trial[0].abs() + trial[1].abs();
        let matrix = self.matrix();
        let of = |k: usize| match signs[k] {
            0.0 => left[k].abs() - caps[k],
            sign => -sign * x[k] * matrix[k][k],
        };
        of(0).max(of(1)).max(of(2)) / size
    }

    /// Of all sets of mechanisms and directions, with the web in the direction `sign`, the one that violates the conditions least: where several mechanisms begin to
    /// flow at once, and where the three caps meet.
    #[cold]
    fn enumerated(
        &self,
        flexibility: [f64; 2],
        trial: [f64; 2],
        sign: f64,
        caps: [f64; 3],
    ) -> [f64; 3] {
        let (mut best, mut least) = ([0.0; 3], f64::INFINITY);
        let of_hinge = |k: usize| match flexibility[k] {
            0.0 => &[0.0][..],
            _ => &[0.0, 1.0, -1.0],
        };
        for &first in of_hinge(0) {
            for &second in of_hinge(1) {
                for web in [0.0, sign] {
                    let signs = [first, second, web];
                    let Some(x) = self.flow(signs, trial, caps) else {
                        continue;
                    };
                    let violation = self.violation(&x, signs, trial, caps);
                    if violation < least {
                        (best, least) = (forwards(x, signs), violation);
                    }
                }
            }
        }
        best
    }
}

/// A hinge and the web, which flow together and determine both moments: the case of most steps in which a web flows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HingeAndWeb {
    /// Stiffness of the hinge, of either against the other, and of the web \[N m/rad\].
    hinge: f64,
    both: f64,
    web: f64,
    per_determinant: f64,
}

impl HingeAndWeb {
    /// How both deform under moments \[N m\].
    #[inline(always)]
    pub fn solve(&self, [hinge, web]: [f64; 2]) -> [f64; 2] {
        [
            (self.web * hinge - self.both * web) * self.per_determinant,
            (self.hinge * web - self.both * hinge) * self.per_determinant,
        ]
    }
}

/// Deformations without those that round-off has turned against their direction: their moments would change sign.
fn forwards(x: [f64; 3], signs: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| if signs[k] * x[k] > 0.0 { x[k] } else { 0.0 })
}

fn single(a: &[[f64; 3]; 3], right: &[f64; 3], k: usize) -> Option<f64> {
    (a[k][k] > 0.0).then(|| right[k] / a[k][k])
}

#[inline(always)]
fn pair(a: &[[f64; 3]; 3], right: &[f64; 3], i: usize, j: usize) -> Option<(f64, f64)> {
    let full = a[i][i] * a[j][j];
    let determinant = full - a[i][j] * a[j][i];
    (determinant > PIVOT * full).then(|| {
        let per_determinant = 1.0 / determinant;
        (
            (a[j][j] * right[i] - a[i][j] * right[j]) * per_determinant,
            (a[i][i] * right[j] - a[j][i] * right[i]) * per_determinant,
        )
    })
}

/// All three, by elimination.
fn eliminated(mut a: [[f64; 3]; 3], mut r: [f64; 3]) -> Option<[f64; 3]> {
    for pivot in 0..3 {
        let full = a[pivot][pivot];
        for done in 0..pivot {
            let factor = a[pivot][done] / a[done][done];
            let above = a[done];
            for (entry, above) in a[pivot].iter_mut().zip(above).skip(done) {
                *entry -= factor * above;
            }
            r[pivot] -= factor * r[done];
        }
        if a[pivot][pivot].is_nan() || a[pivot][pivot] <= PIVOT * full {
            return None;
        }
    }
    let mut x = [0.0; 3];
    for row in (0..3).rev() {
        let mut sum = r[row];
        for column in row + 1..3 {
            sum -= a[row][column] * x[column];
        }
        x[row] = sum / a[row][row];
    }
    Some(x)
}

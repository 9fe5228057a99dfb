//! The fibres of a sheared web, with `sigma^2 + 3 tau^2` in their yield condition, some at once.

use super::section::{LANES, PointForces, PointState, PointStiffness, Section, total};

/// Iterations of the return of a fibre under normal and shear stress.
const RETURNS: usize = 3;

impl Section {
    /// Normal and shear stress of some fibres of the web without further flow, and the same relative to the middle of their
    /// elastic range.
    pub fn web_trial(
        &self,
        strain: &[f64; 4],
        web: &[[f64; 2]],
        first: usize,
    ) -> [[f64; LANES]; 4] {
        let (e, h) = (self.steel.young_modulus, self.steel.plastic_modulus());
        let g = self.steel.shear_modulus();
        let mut to = [[0.0; LANES]; 4];
        for lane in 0..LANES {
            let k = first + lane;
            let f = &self.web;
            let [p, q] = web[k];
            let total = strain[0] - f.y[k] * strain[1] + f.z[k] * strain[2] + f.initial[k];
            to[0][lane] = e * (total - p);
            to[1][lane] = g * (strain[3] - q);
            to[2][lane] = to[0][lane] - h * p;
            to[3][lane] = to[1][lane] - h / 3.0 * q;
        }
        to
    }

    /// Returns fibres of the web to their yield surface; `None` if all are within it.
    pub fn return_web(&self, trial: &[[f64; LANES]; 4], strength: f64) -> Option<Returned> {
        let (e, h) = (self.steel.young_modulus, self.steel.plastic_modulus());
        let moduli = [e + h, 3.0 * self.steel.shear_modulus() + h];
        let limit = strength * strength;
        let outside = (0..LANES).any(|lane| {
            trial[2][lane] * trial[2][lane] + 3.0 * trial[3][lane] * trial[3][lane] > limit
        });
        outside.then(|| return_to_surface(&trial[2], &trial[3], strength, moduli))
    }

    /// Adds the forces of the fibres of the web, and takes the stiffness that they lose; tells whether any flows.
    pub fn respond_web(
        &self,
        strain: &[f64; 4],
        strength: f64,
        from: &PointState,
        forces: &mut PointForces,
        stiffness: &mut PointStiffness,
    ) -> bool {
        let (e, g) = (self.steel.young_modulus, self.steel.shear_modulus());
        let f = &self.web;
        let mut flows = false;
        // N, Mz, My, V.
        let mut sums = [[0.0; LANES]; 4];
        // Normal stiffness lost, its moments as in `respond`; mixed and its first moments; shear stiffness lost.
        let mut lost = [[0.0; LANES]; 10];
        for first in (0..f.len()).step_by(LANES) {
            let mut trial = self.web_trial(strain, &from.web, first);
            if let Some(returned) = self.return_web(&trial, strength) {
                flows = true;
                for lane in 0..LANES {
                    let (y, z, area) = (f.y[first + lane], f.z[first + lane], f.area[first + lane]);
                    trial[0][lane] -= e * returned.flow[0][lane];
                    trial[1][lane] -= g * returned.flow[1][lane];
                    let normal = area * e * e * returned.by_trial[0][lane];
                    let mixed = area * e * g * returned.by_trial[1][lane];
                    let parts = [
                        normal,
                        y * normal,
                        z * normal,
                        y * y * normal,
                        y * z * normal,
                        z * z * normal,
                        mixed,
                        y * mixed,
                        z * mixed,
                        area * g * g * returned.by_trial[2][lane],
                    ];
                    for (sum, part) in lost.iter_mut().zip(parts) {
                        sum[lane] += part;
                    }
                }
            }
            for lane in 0..LANES {
                let area = f.area[first + lane];
                let force = area * trial[0][lane];
                sums[0][lane] += force;
                sums[1][lane] -= f.y[first + lane] * force;
                sums[2][lane] += f.z[first + lane] * force;
                sums[3][lane] += area * trial[1][lane];
            }
        }
        for (force, sum) in forces.iter_mut().zip(sums) {
            *force += total(sum);
        }
        if flows {
            let [a, ay, az, ayy, ayz, azz, m, my, mz, v] = lost.map(total);
            let lost = [
                [a, -ay, az, m],
                [-ay, ayy, -ayz, -my],
                [az, -ayz, azz, mz],
                [m, -my, mz, v],
            ];
            for (row, lost) in stiffness.iter_mut().zip(lost) {
                for (value, lost) in row.iter_mut().zip(lost) {
                    *value -= lost;
                }
            }
        }
        flows
    }
}

/// Fibres of the web that were returned to their yield surface.
pub(crate) struct Returned {
    /// Plastic strains, normal and shear.
    pub flow: [[f64; LANES]; 2],
    /// Derivative of the normal one by the normal trial stress, by the shear trial stress, and of the shear one by that.
    by_trial: [[f64; LANES]; 3],
}

/// Returns relative stresses to `normal^2 + 3 shear^2 = strength^2` along the gradient of the surface; those within it stay.
///
/// The inverse of the root of the left side is nearly a straight line in the multiplier, because both moduli are nearly the
/// same. So three iterations of Newton's method meet the surface to the last digits, wherever the trial is.
fn return_to_surface(
    normal: &[f64; LANES],
    shear: &[f64; LANES],
    strength: f64,
    moduli: [f64; 2],
) -> Returned {
    let per_strength = 1.0 / strength;
    let mut to = Returned {
        flow: [[0.0; LANES]; 2],
        by_trial: [[0.0; LANES]; 3],
    };
    let (mut r, mut s, mut t) = ([0.0; LANES], [1.0; LANES], [1.0; LANES]);
    for _ in 0..RETURNS {
        for lane in 0..LANES {
            let (sigma, tau) = (normal[lane] * s[lane], shear[lane] * t[lane]);
            let (a, b) = (sigma * sigma, 3.0 * tau * tau);
            let size = a + b;
            let beyond = size.sqrt() * per_strength - 1.0;
            r[lane] += beyond * size / (a * moduli[0] * s[lane] + b * moduli[1] * t[lane]);
            s[lane] = 1.0 / (1.0 + moduli[0] * r[lane]);
            t[lane] = 1.0 / (1.0 + moduli[1] * r[lane]);
        }
    }
    for lane in 0..LANES {
        let (normal, shear) = (normal[lane], shear[lane]);
        let outside = normal * normal + 3.0 * shear * shear > strength * strength;
        let (r, s, t) = (r[lane], s[lane], t[lane]);
        // d r / d trial from the consistency of the surface.
        let (sigma, tau) = (normal * s, shear * t);
        let per = 1.0 / (sigma * sigma * moduli[0] * s + 3.0 * tau * tau * moduli[1] * t);
        let by = [sigma * s * per, 3.0 * tau * t * per];
        // The plastic strains are (r sigma, 3 r tau), with s and t functions of r.
        let grown = [
            normal * (s - moduli[0] * r * s * s),
            3.0 * shear * (t - moduli[1] * r * t * t),
        ];
        let select = |value: f64| if outside { value } else { 0.0 };
        to.flow[0][lane] = select(r * sigma);
        to.flow[1][lane] = select(3.0 * r * tau);
        to.by_trial[0][lane] = select(r * s + grown[0] * by[0]);
        to.by_trial[1][lane] = select(0.5 * (grown[0] * by[1] + grown[1] * by[0]));
        to.by_trial[2][lane] = select(3.0 * r * t + grown[1] * by[1]);
    }
    to
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stresses_return_to_the_yield_surface_with_their_derivatives() {
        let (e, g, h, strength) = (210e9, 210e9 / 2.6, 2e9, 355e6);
        let moduli = [e + h, 3.0 * g + h];
        let back = |trial: [f64; 2]| {
            let returned =
                return_to_surface(&[trial[0]; LANES], &[trial[1]; LANES], strength, moduli);
            [0, 1].map(|k| returned.flow[k][0])
        };
        for far in [1.0 + 1e-9, 1.01, 2.0, 50.0, 1e4] {
            for angle in 0..24 {
                let angle = f64::from(angle) * 0.261;
                let trial = [
                    far * strength * libm::cos(angle),
                    far * strength * libm::sin(angle) / 3.0_f64.sqrt(),
                ];
                let flow = back(trial);
                let relative = [
                    trial[0] - moduli[0] * flow[0],
                    trial[1] - moduli[1] / 3.0 * flow[1],
                ];
                let size = (relative[0] * relative[0] + 3.0 * relative[1] * relative[1]).sqrt();
                assert!(
                    (size / strength - 1.0).abs() < 1e-12 * far,
                    "{far} {angle} {size}"
                );
                let returned =
                    return_to_surface(&[trial[0]; LANES], &[trial[1]; LANES], strength, moduli);
                let step = 1e-6 * far * strength;
                if far < 1.001 {
                    continue;
                }
                let more = back([trial[0] + step, trial[1]]);
                let less = back([trial[0] - step, trial[1]]);
                let slope = (more[0] - less[0]) / (2.0 * step);
                assert!(
                    (slope - returned.by_trial[0][0]).abs() < 1e-4 / e,
                    "{far} {angle}"
                );
                let more = back([trial[0], trial[1] + step]);
                let less = back([trial[0], trial[1] - step]);
                let slope = (more[1] - less[1]) / (2.0 * step);
                assert!(
                    (slope - returned.by_trial[2][0]).abs() < 1e-4 / g,
                    "{far} {angle}"
                );
            }
        }
    }
}

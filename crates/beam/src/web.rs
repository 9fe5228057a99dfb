//! The fibres of a sheared web, with `sigma^2 + 3 tau^2` in their yield condition, some at once.

use super::curve::Curve;
use super::section::{LANES, PointForces, PointState, PointStiffness, Section, total};

/// Iterations of the return of a fibre under normal and shear stress.
const RETURNS: usize = 3;

impl Section {
    /// Normal and shear stress of some fibres of the web without further flow, the same relative to the middle of their elastic
    /// range, their plastic shear strain and their plastic normal strain.
    pub fn web_trial(
        &self,
        strain: &[f64; 4],
        web: &[[f64; 2]],
        first: usize,
    ) -> [[f64; LANES]; 6] {
        let (e, h) = (self.steel.young_modulus, self.steel.plastic_modulus());
        let g = self.steel.shear_modulus();
        let most = self.largest_back_stress;
        let mut to = [[0.0; LANES]; 6];
        for lane in 0..LANES {
            let k = first + lane;
            let f = &self.web;
            let [p, q] = web[k];
            let total = strain[0] - f.y[k] * strain[1] + f.z[k] * strain[2] + f.initial[k];
            to[0][lane] = e * (total - p);
            to[1][lane] = g * (f.share[k] * strain[3] - q);
            let [normal, shear] = match &self.curves {
                None => [h * p, (h / 3.0 * q).clamp(-most, most)],
                Some([normal, shear]) => [normal.back_stress(p), shear.back_stress(q)],
            };
            to[2][lane] = to[0][lane] - normal;
            to[3][lane] = to[1][lane] - shear;
            to[4][lane] = q;
            to[5][lane] = p;
        }
        to
    }

    /// Returns fibres of the web to their yield surface; `None` if all are within it.
    pub fn return_web(&self, trial: &[[f64; LANES]; 6], strength: f64) -> Option<Returned> {
        let (e, h) = (self.steel.young_modulus, self.steel.plastic_modulus());
        let moduli = [e + h, 3.0 * self.steel.shear_modulus() + h];
        let limit = strength * strength;
        let outside = (0..LANES).any(|lane| {
            trial[2][lane] * trial[2][lane] + 3.0 * trial[3][lane] * trial[3][lane] > limit
        });
        outside.then(
            || match (&self.curves, self.largest_back_stress.is_finite()) {
                (Some(curves), _) => return_along(curves, trial, strength),
                (None, true) => self.return_capped(trial, strength, moduli),
                (None, false) => return_to_surface(&trial[2], &trial[3], strength, moduli),
            },
        )
    }

    /// The same where the hardening in shear ends: each fibre returns as it would with hardening or as it would without, whichever
    /// agrees with the plastic shear strain that it reaches.
    fn return_capped(
        &self,
        trial: &[[f64; LANES]; 6],
        strength: f64,
        moduli: [f64; 2],
    ) -> Returned {
        let h = self.steel.plastic_modulus();
        let most = 3.0 * self.largest_back_stress / h;
        let (stress, before) = (&trial[1], &trial[4]);
        let hardened = std::array::from_fn(|lane| stress[lane] - h / 3.0 * before[lane]);
        let mut to = return_to_surface(&trial[2], &hardened, strength, moduli);
        let is_full = |q: f64| q.abs() > most;
        let sides: [f64; LANES] = std::array::from_fn(|lane| {
            let after = before[lane] + to.flow[1][lane];
            let at = if is_full(before[lane]) {
                before[lane]
            } else {
                after
            };
            at.signum()
        });
        let full =
            std::array::from_fn(|lane| stress[lane] - sides[lane] * self.largest_back_stress);
        let without = return_to_surface(&trial[2], &full, strength, [moduli[0], moduli[1] - h]);
        for lane in 0..LANES {
            let after = match is_full(before[lane]) {
                true => sides[lane] * (before[lane] + without.flow[1][lane]),
                false => sides[lane] * (before[lane] + to.flow[1][lane]),
            };
            if after > most {
                for (row, other) in to.flow.iter_mut().zip(without.flow) {
                    row[lane] = other[lane];
                }
                for (row, other) in to.by_trial.iter_mut().zip(without.by_trial) {
                    row[lane] = other[lane];
                }
            }
        }
        to
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
                    let share = f.share[first + lane];
                    trial[0][lane] -= e * returned.flow[0][lane];
                    trial[1][lane] -= g * returned.flow[1][lane];
                    let normal = area * e * e * returned.by_trial[0][lane];
                    let mixed = share * (area * e * g * returned.by_trial[1][lane]);
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
                        share * share * (area * g * g * returned.by_trial[2][lane]),
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
                sums[3][lane] += f.share[first + lane] * (area * trial[1][lane]);
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

/// Most iterations of the return of a fibre whose hardening is not a straight line; a few are enough.
const MOST_RETURNS: usize = 60;

/// Returns stresses to the surface where normal and shear stress harden along curves, each fibre by the one multiplier that meets
/// the surface: with it, both plastic strains follow from the rising curves.
fn return_along(curves: &[Curve; 2], trial: &[[f64; LANES]; 6], strength: f64) -> Returned {
    let mut to = Returned {
        flow: [[0.0; LANES]; 2],
        by_trial: [[0.0; LANES]; 3],
    };
    let [normal, shear] = curves;
    let (e, g) = (normal.modulus(), shear.modulus());
    for lane in 0..LANES {
        let (q, p) = (trial[4][lane], trial[5][lane]);
        let (whole, sheared) = (trial[0][lane] + e * p, trial[1][lane] + g * q);
        let size = |sigma: f64, tau: f64| (sigma * sigma + 3.0 * tau * tau).sqrt();
        if size(trial[2][lane], trial[3][lane]) <= strength {
            continue;
        }
        let (mut r, mut below, mut above) = (0.0, 0.0, f64::INFINITY);
        for _ in 0..MOST_RETURNS {
            // Plastic strains `p + r sigma`, `q + 3 r tau`, where sigma and tau are relative to the back stresses there.
            let [after, slope] = normal.solve(1.0 + r * e, r, p + r * whole);
            let [turned, rise] = shear.solve(1.0 + 3.0 * r * g, 3.0 * r, q + 3.0 * r * sheared);
            let sigma = whole - e * after - normal.back_stress(after);
            let tau = sheared - g * turned - shear.back_stress(turned);
            let moduli = [e + slope, 3.0 * (g + rise)];
            let (s, t) = (1.0 / (1.0 + moduli[0] * r), 1.0 / (1.0 + moduli[1] * r));
            let length = size(sigma, tau);
            let falls = sigma * sigma * moduli[0] * s + 3.0 * tau * tau * moduli[1] * t;
            // d r / d trial from the consistency of the surface.
            let by = [sigma * s / falls, 3.0 * tau * t / falls];
            to.flow[0][lane] = after - p;
            to.flow[1][lane] = turned - q;
            to.by_trial[0][lane] = s * (r + sigma * by[0]);
            to.by_trial[1][lane] = s * sigma * by[1];
            to.by_trial[2][lane] = 3.0 * t * (r + tau * by[1]);
            let beyond = length / strength - 1.0;
            if beyond.abs() < 1e-13 {
                break;
            }
            if beyond > 0.0 {
                below = r;
            } else {
                above = r;
            }
            // The inverse of the length is nearly a straight line in the multiplier.
            let next = r + beyond * length * length / falls;
            let middle = if above.is_finite() {
                0.5 * (below + above)
            } else {
                2.0 * next
            };
            let is_between = next > below && next < above;
            let next = if is_between { next } else { middle };
            if next == r {
                break;
            }
            r = next;
        }
    }
    to
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Steel;
    use crate::section::{Division, Shape};

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

    /// A web that shears alone has the closed form of a bilinear spring, up to the limit of its hardening.
    #[test]
    fn the_hardening_of_a_sheared_web_ends_at_its_limit() {
        let steel = Steel {
            young_modulus: 210e9,
            poisson_ratio: 0.3,
            yield_strength: 355e6,
            hardening_ratio: 1e-2,
            density: 7850.0,
            tensile_strength: None,
        };
        let division = Division {
            web: 8,
            layers: 2,
            across: 1,
        };
        let shape = Shape::plates(0.22, 0.22, 0.0095, 0.016);
        let mut section = Section::new(&shape, steel, division, true, false);
        let first = steel.yield_strength / 3.0_f64.sqrt();
        let (most, area) = (1.05, section.web.area.iter().sum::<f64>());
        section.largest_back_stress = (most - 1.0) * first;
        let slope = steel.plastic_modulus() / 3.0;
        let g = steel.shear_modulus();
        let mut state = section.undamaged();
        // Forth beyond the limit, back through the elastic range, forth again from within it.
        let mut plastic = 0.0_f64;
        let path = [
            0.002, 0.006, 0.02, 0.04, 0.0395, 0.03, -0.002, -0.05, -0.01, 0.03,
        ];
        for (number, to) in path.into_iter().enumerate() {
            let strain = [0.0, 0.0, 0.0, to];
            let (forces, _, _) = section.respond::<false>(&strain, 355e6, &state);
            // The same by bisection on the plastic strain.
            let back = |q: f64| (slope * q).clamp(-(most - 1.0) * first, (most - 1.0) * first);
            let beyond = |q: f64| g * (to - q) - back(q);
            if beyond(plastic).abs() > first {
                let side = beyond(plastic).signum();
                let (mut low, mut high) = (plastic, to);
                for _ in 0..200 {
                    let middle = 0.5 * (low + high);
                    match side * beyond(middle) > first {
                        true => low = middle,
                        false => high = middle,
                    }
                }
                plastic = low;
            }
            let expected = g * (to - plastic) * area;
            assert!(
                (forces[3] - expected).abs() < 1e-6 * first * area,
                "{number}: {forces:?} {expected}"
            );
            assert!(forces[3].abs() <= (most + 1e-9) * first * area);
            section.flow(&strain, 355e6, &mut state);
            assert!((state.web[0][1] - plastic).abs() < 1e-9, "{number}");
        }
        // The stiffness is the derivative of the forces, with normal stress as well.
        let strain = [4e-4, 1e-3, 0.0, 0.03];
        let at = |strain: &[f64; 4]| section.respond::<false>(strain, 355e6, &section.undamaged());
        let (_, stiffness, _) = at(&strain);
        for k in [0, 1, 3] {
            let step = 1e-8;
            let [more, less] = [step, -step].map(|by| {
                let mut strain = strain;
                strain[k] += by;
                at(&strain).0
            });
            for row in [0, 1, 3] {
                let slope = (more[row] - less[row]) / (2.0 * step);
                let scale = (section.elastic()[row] * section.elastic()[k]).sqrt();
                assert!(
                    (stiffness[row][k] - slope).abs() < 1e-4 * scale,
                    "{row} {k}: {} {slope}",
                    stiffness[row][k]
                );
            }
        }
    }

    /// Normal and shear stress that harden along curves: the relative stresses lie on the surface, and the stiffness is the derivative
    /// of the forces, on the plateau, beyond it, and on the way back.
    #[test]
    fn a_section_with_a_plateau_returns_to_its_surface_with_its_stiffness() {
        let steel = Steel {
            young_modulus: 210e9,
            poisson_ratio: 0.3,
            yield_strength: 355e6,
            hardening_ratio: 1e-4,
            density: 7850.0,
            tensile_strength: Some(490e6),
        };
        let division = Division {
            web: 8,
            layers: 2,
            across: 8,
        };
        let strength = 355e6;
        for shape in [
            Shape::plates(0.22, 0.22, 0.0095, 0.016),
            Shape::Circular {
                diameter: 0.2191,
                thickness: 0.01,
            },
        ] {
            let section = Section::new(&shape, steel, division, true, true);
            let mut state = section.undamaged();
            for strain in [
                [1e-3, 0.05, 0.01, 4e-3],
                [2e-3, 0.5, 0.1, 0.03],
                [3e-3, 0.9, 0.3, 0.08],
                [1e-3, 0.2, 0.3, 0.02],
                [-2e-3, -0.8, -0.1, -0.03],
            ] {
                let at = |strain: &[f64; 4]| section.respond::<true>(strain, strength, &state);
                let (_, stiffness, _) = at(&strain);
                for k in 0..4 {
                    let step = 1e-9 * [1.0, 10.0, 10.0, 1.0][k];
                    let [more, less] = [step, -step].map(|by| {
                        let mut strain = strain;
                        strain[k] += by;
                        at(&strain).0
                    });
                    for row in 0..4 {
                        let slope = (more[row] - less[row]) / (2.0 * step);
                        let scale = (section.elastic()[row] * section.elastic()[k]).sqrt();
                        assert!(
                            (stiffness[row][k] - slope).abs() < 1e-3 * scale,
                            "{shape:?} {strain:?} {row} {k}: {} {slope}",
                            stiffness[row][k]
                        );
                    }
                }
                let before = state.clone();
                let (forces, _, _) = at(&strain);
                section.flow(&strain, strength, &mut state);
                // What has flowed flows no further.
                let (again, _, _) = section.respond::<true>(&strain, strength, &state);
                for k in 0..4 {
                    let close = 1e-9 * section.elastic()[k];
                    assert!(
                        (again[k] - forces[k]).abs() < close,
                        "{k}: {again:?} {forces:?}"
                    );
                }
                for first in (0..section.web.len()).step_by(LANES) {
                    let trial = section.web_trial(&strain, &state.web, first);
                    for lane in 0..LANES {
                        let (sigma, tau) = (trial[2][lane], trial[3][lane]);
                        let size = (sigma * sigma + 3.0 * tau * tau).sqrt();
                        assert!(size < strength * (1.0 + 1e-9), "{size}");
                        if state.web[first + lane] != before.web[first + lane] {
                            assert!(size > strength * (1.0 - 1e-9), "{size}");
                        }
                    }
                }
            }
        }
    }

    /// The fibres of a tube on one side sheared the other way, so that damage in the plane was carried over with the wrong sign to
    /// fibres whose counterpart lies on the other side.
    #[test]
    fn fibres_of_a_tube_have_the_shear_of_their_counterparts_in_the_plane() {
        let steel = Steel {
            young_modulus: 210e9,
            poisson_ratio: 0.3,
            yield_strength: 355e6,
            hardening_ratio: 1e-3,
            density: 7850.0,
            tensile_strength: None,
        };
        let shape = Shape::Circular {
            diameter: 0.2191,
            thickness: 0.01,
        };
        let [plane, space] = [1, 8].map(|across| {
            let division = Division {
                web: 8,
                layers: 2,
                across,
            };
            Section::new(&shape, steel, division, true, true)
        });
        let [_, counterparts] = space.counterparts(&plane);
        assert_eq!(counterparts.len(), space.web.len());
        for (share, other) in space.web.share.iter().zip(counterparts) {
            assert!((share - plane.web.share[other]).abs() < 1e-12, "{share}");
            assert!(*share > 0.0);
        }
    }
}

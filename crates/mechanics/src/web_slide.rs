//! The return of a stress where the web of a bar flows alone, without its hinges.

use super::bar::{Bar, BarForces, BarTangent, Place, PlasticFlow, Returned};
use super::return_search::{MAX_RETURN_ITERATIONS, RETURN_TOLERANCE};
use super::shear::{FREE_AXIAL, Slider, SliderStrength};

impl Slider {
    /// The return of a stress that exceeds the resistance of the web where it flows alone, with `axial` \[N\] the squash load
    /// of the weaker hinge, into `returned`; `false` where it would shorten beyond that. Where the normal force remains, for a web up
    /// to half the squash load, it has a closed form.
    pub fn slide_alone(
        &self,
        (bar, strength): (&Bar, &SliderStrength),
        trial: &BarForces,
        axial: f64,
        returned: &mut Returned,
    ) -> bool {
        let sum = trial.moment[0] + trial.moment[1];
        let n = trial.normal.abs() / axial;
        if n <= FREE_AXIAL || !self.is_web {
            let slide = self.slide(strength, sum, 1.0);
            let tangent = self.frozen(bar, &slide);
            *returned = self.slid(bar, trial, &slide, trial.normal, tangent);
            return true;
        }
        // As in the problem of all mechanisms, the derivative in `n` never decreases.
        let per_energy = bar.axial / (axial * axial);
        let at = |n: f64| {
            let share = self.share_jet(n);
            let slide = self.slide(strength, sum, share.value);
            let weight = per_energy * self.resistance * strength.integral(slide.angle);
            let carried = self.resistance * share.first * strength.hardened(slide.angle);
            let slope =
                1.0 - weight * share.second + per_energy * carried * carried * slide.flexibility;
            (share.first * weight, slope, carried, slide)
        };
        let (mut low, mut high) = (FREE_AXIAL, n.min(1.0));
        let mut t = high;
        for _ in 0..MAX_RETURN_ITERATIONS {
            let (flow, slope, ..) = at(t);
            let value = t - n - flow;
            if value < 0.0 {
                if t >= 1.0 {
                    return false;
                }
                low = t;
            } else {
                high = t;
            }
            let next = t - value / slope;
            if (next - t).abs() <= RETURN_TOLERANCE || high - low <= f64::EPSILON {
                // The error of the last step is its square: next to the squash load every digit of the rest counts.
                let t = next.clamp(low, high);
                let (_, slope, carried, slide) = at(t);
                let normal = (t * axial).copysign(trial.normal);
                let carried = carried.copysign(-slide.angle) * slide.flexibility;
                let along = self.turning.map(|turning| turning * carried);
                let tangent = self.frozen(bar, &slide).sliding(
                    axial.copysign(trial.normal),
                    along,
                    slope / per_energy,
                );
                *returned = self.slid(bar, trial, &slide, normal, tangent);
                return true;
            }
            t = if next > low && next < high {
                next
            } else {
                0.5 * (low + high)
            };
        }
        false
    }

    /// How the web slides alone under a trial sum of the moments \[N m\] that exceeds the share `share` of its resistance.
    fn slide(&self, strength: &SliderStrength, sum: f64, share: f64) -> Slide {
        let limit = self.resistance * share;
        let factor = strength.towards(sum);
        let with = |factor: f64, hardening: f64| {
            let flexibility = 1.0 / (self.stiffness + hardening);
            let excess = (sum.abs() - limit * factor).max(0.0);
            let angle = excess * flexibility;
            Slide {
                angle: angle.copysign(sum),
                flexibility,
                sum: (limit * factor + hardening * angle).copysign(sum),
            }
        };
        let slide = with(factor, limit * strength.growth_towards(sum));
        if strength.is_capped(slide.angle) {
            return with(strength.most.max(factor), 0.0);
        }
        slide
    }

    /// Moments whose sum differs from that of the web by round-off, without it.
    pub fn onto(&self, moment: [f64; 2], sum: f64) -> [f64; 2] {
        let per_stiffness = (moment[0] + moment[1] - sum) / self.stiffness;
        [0, 1].map(|k| moment[k] - per_stiffness * self.turning[k])
    }

    /// Tangent of a web that slides alone, with the normal force held and that of a bar without flow as its axial stiffness.
    fn frozen(&self, bar: &Bar, slide: &Slide) -> BarTangent {
        let (c, turning) = (&bar.rotational, &self.turning);
        let entry = |row: usize, column: usize| {
            c[row][column] - turning[row] * turning[column] * slide.flexibility
        };
        BarTangent {
            axial: bar.axial,
            mixed: [0.0; 2],
            rotational: [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]],
        }
    }

    /// The stress after a slide, with the normal force `normal` \[N\].
    #[inline(always)]
    fn slid(
        &self,
        bar: &Bar,
        trial: &BarForces,
        slide: &Slide,
        normal: f64,
        tangent: BarTangent,
    ) -> Returned {
        let angle = slide.angle;
        let moment = [0, 1].map(|k| trial.moment[k] - self.turning[k] * angle);
        Returned {
            forces: BarForces {
                normal,
                moment: self.onto(moment, slide.sum),
            },
            flow: PlasticFlow {
                shear_angle: angle,
                shear_elongation: (trial.normal - normal) * bar.axial_flexibility,
                ..PlasticFlow::default()
            },
            place: Place::Sheared { tangent },
        }
    }
}

/// The angle of a web that slides alone \[rad\], and how it grows with the trial sum of the moments \[rad/(N m)\].
struct Slide {
    angle: f64,
    flexibility: f64,
    /// The sum of the moments that it leaves \[N m\].
    sum: f64,
}

#[cfg(test)]
#[allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]
mod tests {
    use std::cell::Cell;

    use proptest::prelude::*;
    use proptest::test_runner::{Config, TestRng, TestRunner};

    use super::*;
    use crate::bar::BarStrain;
    use crate::bar_strength::BarStrength;
    use crate::properties::YieldExponents;
    use crate::strength::return_stress;
    use crate::yield_surface::YieldSurface;

    const MOMENT: f64 = 0.3e6;
    const AXIAL: f64 = 3.2e6;

    /// A bar with a web, the strength of its parts and a trial stress.
    #[derive(Debug, Clone, Copy)]
    struct Case {
        bar: Bar,
        dynamic: [f64; 2],
        /// Factor of the moments alone.
        moment: [f64; 2],
        /// `g_k` \[1/rad\].
        growth: [f64; 2],
        web: SliderStrength,
        trial: BarForces,
    }

    impl Case {
        fn returned(&self) -> Returned {
            let mut strength = BarStrength::new(self.dynamic, self.moment, self.growth, self.web);
            return_stress(&self.bar, strength.as_mut(), self.trial, 0.0)
        }

        fn weakest(&self) -> f64 {
            self.dynamic[0].min(self.dynamic[1])
        }

        /// The moments \[N m\] that the normal force leaves to the hinges before they rotate.
        fn caps(&self, normal: f64) -> [f64; 2] {
            [0, 1].map(|k| {
                let n = (normal / (self.dynamic[k] * AXIAL)).abs().min(1.0);
                self.dynamic[k] * self.moment[k] * MOMENT * self.bar.surface.cap_of(n)
            })
        }

        /// The sum of moments \[N m\] of an undamaged web at this normal force.
        fn web_limit(&self, normal: f64) -> f64 {
            let n = (normal / (self.weakest() * AXIAL)).abs();
            let share = if n <= 0.5 {
                1.0
            } else {
                4.0 * n * (1.0 - n).max(0.0)
            };
            self.bar.slider.expect("a slider").resistance * share
        }

        /// What the deformations `x` of the hinges and the web dissipate, and minus the complementary energy that they
        /// release \[J\]: least where the moments are within their caps.
        fn primal(&self, normal: f64, x: [f64; 3]) -> f64 {
            let (c, caps, limit) = (
                &self.bar.rotational,
                self.caps(normal),
                self.web_limit(normal),
            );
            let turned = [x[0] + x[2], x[1] + x[2]];
            let quadratic = c[0][0] * turned[0] * turned[0]
                + 2.0 * c[0][1] * turned[0] * turned[1]
                + c[1][1] * turned[1] * turned[1];
            let hinge = |k: usize| caps[k] * (x[k].abs() + 0.5 * self.growth[k] * x[k] * x[k]);
            // The web by quadrature of its resistance, not in closed form.
            let parts = 64;
            let web: f64 = (0..parts)
                .map(|part| {
                    let [from, to] =
                        [part, part + 1].map(|it| x[2].abs() * f64::from(it) / f64::from(parts));
                    let direction = usize::from(x[2] < 0.0);
                    let at = |angle: f64| {
                        let factor = self.web.factor[direction];
                        (factor + self.web.growth[direction] * angle).min(self.web.most.max(factor))
                    };
                    // Simpson; the resistance is piecewise linear with one kink.
                    (to - from) / 6.0 * (at(from) + 4.0 * at(0.5 * (from + to)) + at(to))
                })
                .sum();
            0.5 * quadratic - self.trial.moment[0] * turned[0] - self.trial.moment[1] * turned[1]
                + hinge(0)
                + hinge(1)
                + limit * web
        }

        /// The least value of [`Case::primal`], by exhaustion of all sets of mechanisms, directions and, for the web, of the
        /// side of its cap.
        fn least(&self, normal: f64) -> f64 {
            let (c, caps, limit) = (
                &self.bar.rotational,
                self.caps(normal),
                self.web_limit(normal),
            );
            let mut least = 0.0_f64;
            for pattern in 0..27 {
                let sign =
                    [pattern % 3, pattern / 3 % 3, pattern / 9].map(|it| f64::from(it) - 1.0);
                for capped in [false, true] {
                    let direction = usize::from(sign[2] < 0.0);
                    let factor = self.web.factor[direction];
                    let (web, stiff) = match capped {
                        true => (self.web.most.max(factor), 0.0),
                        false => (factor, self.web.growth[direction]),
                    };
                    if !web.is_finite() {
                        continue;
                    }
                    // Gradient zero for the active ones: a system of at most three equations, by Cramer's rule.
                    let a = [
                        [
                            c[0][0] + caps[0] * self.growth[0],
                            c[0][1],
                            c[0][0] + c[0][1],
                        ],
                        [
                            c[0][1],
                            c[1][1] + caps[1] * self.growth[1],
                            c[1][1] + c[0][1],
                        ],
                        [
                            c[0][0] + c[0][1],
                            c[1][1] + c[0][1],
                            c[0][0] + 2.0 * c[0][1] + c[1][1] + limit * stiff,
                        ],
                    ];
                    let trial = self.trial.moment;
                    let r = [
                        trial[0] - sign[0] * caps[0],
                        trial[1] - sign[1] * caps[1],
                        trial[0] + trial[1] - sign[2] * limit * web,
                    ];
                    let entry = |row: usize, column: usize| match (sign[row], sign[column]) {
                        (0.0, _) | (_, 0.0) => f64::from(u8::from(row == column)),
                        _ => a[row][column] / MOMENT,
                    };
                    let right = |row: usize| match sign[row] {
                        0.0 => 0.0,
                        _ => r[row] / MOMENT,
                    };
                    let m = nalgebra::Matrix3::from_fn(entry);
                    let b = nalgebra::Vector3::from_fn(|row, _| right(row));
                    let Some(x) = m.lu().solve(&b) else { continue };
                    // Any deformations are admissible: a wrong set only gives a larger value.
                    let x = [x[0], x[1], x[2]].map(|it| if it.abs() < 1e3 { it } else { 0.0 });
                    least = least.min(self.primal(normal, x));
                }
            }
            least
        }

        /// The convex problem \[J\].
        fn energy(&self, normal: f64) -> f64 {
            let off = self.trial.normal - normal;
            0.5 * off * off / self.bar.axial - self.least(normal)
        }

        /// Its minimum, by ternary search.
        fn searched(&self) -> f64 {
            let limit = self.weakest() * AXIAL;
            let (mut low, mut high) = (0.0, self.trial.normal.abs().min(limit));
            let sign = self.trial.normal.signum();
            for _ in 0..90 {
                let third = (high - low) / 3.0;
                if self.energy(sign * (low + third)) < self.energy(sign * (high - third)) {
                    high -= third;
                } else {
                    low += third;
                }
            }
            sign * 0.5 * (low + high)
        }
    }

    prop_compose! {
        fn case()(
            alpha in prop_oneof![Just(1.0), Just(2.0), 1.05..4.0_f64, Just(50.0)],
            beta in prop_oneof![Just(1.0), Just(1.3), Just(2.0), 1.05..4.0_f64, Just(50.0)],
            length in 0.2..5.0_f64,
            // Elastic shear makes the carry-over smaller and at last negative.
            carry in prop_oneof![Just(0.5), -0.9..0.5_f64],
            coupled in any::<bool>(),
            pinned in prop_oneof![4 => Just(false), 1 => Just(true)],
            dynamic in prop_oneof![
                2 => Just([1.0; 2]),
                1 => (1.0..2.0_f64, 1.0..2.0_f64).prop_map(|(a, b)| [a, b]),
            ],
            factor in prop_oneof![
                2 => Just([1.0; 2]),
                1 => (0.01..1.5_f64, 0.01..1.5_f64).prop_map(|(a, b)| [a, b]),
            ],
            growth in prop_oneof![
                2 => Just([0.0; 2]),
                1 => (0.0..50.0_f64, 0.0..50.0_f64).prop_map(|(a, b)| [a, b]),
            ],
            resistance in prop_oneof![0.05..2.5_f64, Just(2.0), Just(1.0)],
            web in prop_oneof![
                2 => Just(SliderStrength::UNDAMAGED),
                1 => (0.01..2.0_f64, 0.01..2.0_f64, 0.0..20.0_f64, 1.0..2.0_f64).prop_map(
                    |(a, b, growth, most)| SliderStrength {
                        factor: [a, b],
                        growth: [growth; 2],
                        most: most * a.max(b),
                    }
                ),
            ],
            moment in (-3.0..3.0_f64, -3.0..3.0_f64),
            normal in prop_oneof![-1.5..1.5_f64, -0.01..0.01_f64, Just(0.0), 0.85..1.6_f64],
        ) -> Case {
            let exponents = YieldExponents { alpha, beta, gamma: 1.0 };
            let surface = YieldSurface::new(MOMENT, AXIAL, exponents);
            let c = 1.7e7 / length;
            let rotational = match (coupled, pinned) {
                (true, false) => [[4.0 * c, 4.0 * carry * c], [4.0 * carry * c, 4.0 * c]],
                (false, false) => [[6.0 * c, 0.0], [0.0, 6.0 * c]],
                (_, true) => [[3.0 * c, 0.0], [0.0, 0.0]],
            };
            let mut bar = Bar::new(length, 1.9e9 / length, rotational, surface);
            bar.slider = Some(Slider::of_web(resistance * MOMENT / length, length, &rotational));
            let second = if pinned { 0.0 } else { moment.1 * MOMENT };
            Case {
                bar,
                dynamic,
                moment: factor,
                growth,
                web,
                trial: BarForces { normal: normal * AXIAL, moment: [moment.0 * MOMENT, second] },
            }
        }
    }

    fn check(cases: u32, check: impl Fn(Case) -> Result<(), TestCaseError>) {
        let config = Config {
            cases,
            ..Config::default()
        };
        let seed = TestRng::deterministic_rng(config.rng_algorithm);
        TestRunner::new_with_rng(config, seed)
            .run(&case(), check)
            .unwrap_or_else(|failure| panic!("{failure}"));
    }

    #[test]
    fn the_return_with_a_web_minimises_the_convex_problem() {
        let sheared = Cell::new([0; 4]);
        check(3_000, |case| {
            let found = case.returned();
            let normal = found.forces.normal;
            let flow = &found.flow;
            let x = [flow.rotation[0], flow.rotation[1], flow.shear_angle];
            let searched = case.energy(case.searched());
            let scale = case.energy(0.0).abs() + searched.abs();
            // Near a tip the round-off of the normal force does not determine the caps.
            let nearby = [1.0 - 4.0 * f64::EPSILON, 1.0 + 4.0 * f64::EPSILON]
                .map(|factor| case.energy(factor * normal));
            let allowed = 1e-9 * scale + (nearby[0] - nearby[1]).abs();
            let excess = case.energy(normal) - searched;
            prop_assert!(
                excess <= allowed,
                "{excess} J of {scale}: {found:?} {case:?}"
            );
            // Its own deformations are the best ones at its normal force.
            let own = case.primal(normal, x) - case.least(normal);
            prop_assert!(own <= allowed, "{own} J of {scale}: {found:?} {case:?}");
            // The stress is that of the elastic law after the flow, and admissible.
            let size = MOMENT + case.trial.moment[0].abs() + case.trial.moment[1].abs();
            for k in 0..2 {
                let c = &case.bar.rotational[k];
                let moment = case.trial.moment[k] - c[0] * (x[0] + x[2]) - c[1] * (x[1] + x[2]);
                let error = (found.forces.moment[k] - moment).abs();
                prop_assert!(
                    error <= 1e-9 * size,
                    "hinge {k}: {error} N m, {found:?} {case:?}"
                );
                let hardened = case.moment[k] * (1.0 + case.growth[k] * x[k].abs());
                let used = case.bar.surface.sum(
                    found.forces.moment[k] / (case.dynamic[k] * hardened),
                    normal / case.dynamic[k],
                );
                prop_assert!(used <= 1.0 + 1e-9, "hinge {k}: {used}, {found:?} {case:?}");
            }
            let sum = found.forces.moment[0] + found.forces.moment[1];
            let limit = match x[2] {
                0.0 => case.web_limit(normal) * case.web.towards(sum),
                angle => case.web_limit(normal) * case.web.hardened(angle),
            };
            prop_assert!(
                sum.abs() - limit <= 1e-9 * size,
                "web {sum} {limit}: {found:?} {case:?}"
            );
            let work = found.forces.shear_work(flow);
            prop_assert!(work >= 0.0, "web {work} J: {found:?} {case:?}");
            let total = flow.elongation[0] + flow.elongation[1] + flow.shear_elongation;
            let left = case.bar.axial * total - (case.trial.normal - normal);
            prop_assert!(left.abs() <= 1e-9 * AXIAL, "{left} N: {found:?} {case:?}");
            for k in 0..2 {
                let work = normal * flow.elongation[k] + found.forces.moment[k] * flow.rotation[k];
                prop_assert!(
                    work >= -1e-9 * scale,
                    "hinge {k} {work} J: {found:?} {case:?}"
                );
            }
            let mut count = sheared.get();
            if x[2] != 0.0 {
                count[x[..2].iter().filter(|it| **it != 0.0).count()] += 1;
            }
            count[3] += u32::from(x[2] != 0.0 && flow.shear_elongation != 0.0);
            sheared.set(count);
            Ok(())
        });
        let count = sheared.get();
        println!("web alone, with one hinge, with both, and shortening: {count:?}");
        assert!(count.iter().all(|&it| it >= 20), "{count:?}");
    }

    #[test]
    fn the_tangent_with_a_web_is_consistent() {
        let compared = Cell::new(0);
        check(6_000, |case| {
            if case.trial.normal == 0.0 {
                // The curvature of the surface may be infinite there.
                return Ok(());
            }
            let size = [AXIAL / case.bar.axial, 0.02, 0.02];
            let at = |h: f64, direction: usize| {
                let mut moved = case;
                let strain = BarStrain {
                    elongation: if direction == 0 { h * size[0] } else { 0.0 },
                    rotation: [1, 2].map(|k| if direction == k { h * size[k] } else { 0.0 }),
                };
                let change = case.bar.elastic(&strain);
                moved.trial.normal += change.normal;
                for k in 0..2 {
                    moved.trial.moment[k] += change.moment[k];
                }
                let forces = moved.returned().forces;
                [forces.normal, forces.moment[0], forces.moment[1]]
            };
            let returned = case.returned();
            if returned.flow.shear_angle == 0.0 {
                return Ok(());
            }
            let d = case.bar.tangent(&returned);
            let r = &d.rotational;
            let matrix = [
                [d.axial, d.mixed[0], d.mixed[1]],
                [d.mixed[0], r[0][0], r[0][1]],
                [d.mixed[1], r[1][0], r[1][1]],
            ];
            let scale = [case.bar.axial * size[0], 1e6, 1e6];
            let h = 1e-6;
            for direction in 0..3 {
                let (before, here, after) =
                    (at(-h, direction), at(0.0, direction), at(h, direction));
                for row in 0..3 {
                    let left = (here[row] - before[row]) / h;
                    let right = (after[row] - here[row]) / h;
                    // Kinks have no derivative.
                    if (left - right).abs() > 1e-4 * scale[row] {
                        continue;
                    }
                    compared.set(compared.get() + 1);
                    let exact = matrix[row][direction] * size[direction];
                    let error = 0.5 * (left + right) - exact;
                    prop_assert!(
                        error.abs() <= 2e-4 * scale[row],
                        "{row} {direction}: {left} {right} {exact} {returned:?} {case:?}"
                    );
                }
            }
            Ok(())
        });
        println!("{} entries compared", compared.get());
        assert!(compared.get() > 10_000, "{}", compared.get());
    }
}

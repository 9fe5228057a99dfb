//! The hinge law against 18 columns that were pushed sideways in laboratories (`tests/data/column_tests.json`).
//!
//! By symmetry each bar of a column that is pushed at its middle sways as a column of its length that is built in at both ends.
//! A huge slow mass pushes it, so that the response is quasi-static and every part of the program takes part: elastic law,
//! hinge law, second-order effects.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

use column_mechanics::{
    ColumnProperties, ElasticLaw, Impact, Model, Progress, Response, RolledSection, Scheme,
    SectionBackbone, SofteningProperties, State, Support, YieldExponents,
};
use serde::Deserialize;

/// What a section by name has unless it is given, and with a law of the strain rate.
const NAMED: [f64; 2] = [0.01, 0.005];

/// Rotation at which moments are compared \[rad\].
const COMPARED_ROTATION: f64 = 0.05;

/// Speed of the push \[m/s\].
const SPEED: f64 = 0.2;

#[derive(Deserialize)]
struct Tests {
    nakashima: Nakashima,
    cravero: Cravero,
}

#[derive(Deserialize)]
struct Nakashima {
    tests: Vec<Sway>,
}

/// A column built in at both ends; lengths in mm, stresses in MPa, forces in kN.
#[derive(Deserialize)]
struct Sway {
    id: String,
    #[serde(flatten)]
    plates: Plates,
    fy: f64,
    #[serde(rename = "E")]
    young_modulus: f64,
    length: f64,
    #[serde(rename = "N")]
    load: f64,
    m_05: Option<f64>,
    sway: Option<f64>,
    last_moment: Option<f64>,
    buckling: Option<f64>,
}

#[derive(Deserialize)]
struct Cravero {
    length: f64,
    tests: Vec<Cantilever>,
}

/// A cantilever; lengths in mm, rotations in rad.
#[derive(Deserialize)]
struct Cantilever {
    id: String,
    #[serde(flatten)]
    plates: Plates,
    h_tw: f64,
    n: f64,
    #[serde(rename = "yield")]
    yield_rotation: f64,
    buckling: f64,
    moment_80: Option<f64>,
}

/// Dimensions of a section \[mm\].
#[derive(Deserialize)]
struct Plates {
    h: f64,
    b: f64,
    tw: f64,
    tf: f64,
}

impl Plates {
    fn section(&self) -> RolledSection {
        RolledSection {
            depth: 1e-3 * self.h,
            width: 1e-3 * self.b,
            web_thickness: 1e-3 * self.tw,
            flange_thickness: 1e-3 * self.tf,
            root_radius: 0.0,
        }
    }
}

fn tests() -> Tests {
    serde_json::from_str(include_str!("data/column_tests.json")).expect("the tests")
}

impl Sway {
    fn axial_ratio(&self) -> f64 {
        1e3 * self.load / (self.plates.section().properties().area * 1e6 * self.fy)
    }

    /// The sway \[mm\] at which the last measured moment carries the load without a lateral force, `N w = 2 M`. The last point of a
    /// test, at the sway that was measured, has up to 0.9 kN left of the push.
    fn standing_sway(&self) -> Option<f64> {
        self.last_moment.map(|moment| 2e3 * moment / self.load)
    }

    fn softening(&self) -> SofteningProperties {
        let section = self.plates.section();
        SectionBackbone::of(&section, 1e-3 * self.length, self.axial_ratio()).softening()
    }

    /// Two of these columns, one upon the other, pushed where they meet.
    fn column(&self, hardening_ratio: f64, softens: bool) -> ColumnProperties {
        let section = self.plates.section().properties();
        let (young_modulus, fy) = (1e6 * self.young_modulus, 1e6 * self.fy);
        ColumnProperties {
            length_below: 1e-3 * self.length,
            length_above: 1e-3 * self.length,
            axial_rigidity: young_modulus * section.area,
            bending_stiffness: young_modulus * section.second_moment,
            mass_per_length: section.mass_per_length,
            resistance_moment: fy * section.plastic_modulus,
            resistance_axial: fy * section.area,
            yield_surface: YieldExponents {
                alpha: 1.0,
                beta: 1.3,
                gamma: 1.0,
            },
            elastic_law: ElasticLaw::Coupled,
            base: Support::BuiltIn,
            top: Support::BuiltIn,
            hinge_stiffness: [None; 4],
            top_spring_stiffness: 0.0,
            top_mass: 0.0,
            top_load: 1e3 * self.load,
            damping_ratio: 0.05,
            rate: None,
            hardening_ratio,
            softening: softens.then(|| self.softening()),
            base_connection: None,
            ultimate_rotation: 0.0,
            shear: None,
            scheme: Scheme::ConservingMidpoint,
            step_nanos: 0,
        }
    }

    /// Pushes the column at `speed` \[m/s\]: `M / M_p` at the base at the compared rotation, and the sway \[m\] at which the push is
    /// no longer needed, if it is followed to there.
    fn pushed(&self, properties: &ColumnProperties, speed: f64, to_the_end: bool) -> (f64, f64) {
        let model = Model::new(properties).expect("a column");
        let mut state = State::at_rest(&model);
        let impact = Impact::rigid(1e9, speed);
        let mut response = Response::begin(&model, &mut state, impact, 3.0).expect("an impact");
        let (mut moment, mut sway) = (f64::NAN, 0.0);
        let most = 0.6 * model.properties.length_below;
        loop {
            let progress = response.advance(&model, &mut state, u64::MAX);
            let base = state.sample(&model).hinges[3];
            if moment.is_nan() && base.plastic_rotation.abs() >= COMPARED_ROTATION {
                moment = base.moment.abs() / model.properties.resistance_moment;
                if !to_the_end {
                    return (moment, sway);
                }
            }
            if state.impactor.as_ref().is_some_and(|it| it.closed) {
                sway = state.displacement.v1;
            }
            if progress != Ok(Progress::Running) || state.displacement.v1 > most {
                return (moment, sway);
            }
        }
    }

    /// The sway over the measured one.
    fn sway_ratio(&self, measured: f64, hardening_ratio: f64, softens: bool, speed: f64) -> f64 {
        let column = self.column(hardening_ratio, softens);
        1e3 * self.pushed(&column, speed, true).1 / measured
    }
}

/// Without hardening the law is too weak by 15 to 46 % at 0.05 rad. With that of a section by name it is still so in the mean,
/// by 11 %, which is on the safe side for displacements, and not more than 5 % too strong in any test.
#[test]
fn moments_of_nakashimas_columns_at_0_05_rad() {
    let mut ratios = [0.0, NAMED[1], NAMED[0], 0.02].map(|b| (b, Vec::new()));
    for test in tests().nakashima.tests {
        let Some(measured) = test.m_05 else { continue };
        let n = test.axial_ratio();
        let found = ratios.each_mut().map(|(b, ratios)| {
            let ratio = test.pushed(&test.column(*b, false), SPEED, false).0 / measured;
            ratios.push(ratio);
            ratio
        });
        println!(
            "{} n {n:.2}: M/Mp {measured:.2}, simulated over measured {found:.3?}",
            test.id
        );
    }
    for ((b, ratios), (mean, least, most)) in ratios.iter().zip([
        (0.67, 0.53, 0.86),
        (0.83, 0.72, 1.00),
        (0.89, 0.79, 1.05),
        (0.98, 0.86, 1.13),
    ]) {
        assert_eq!(ratios.len(), 11);
        let found = ratios.iter().sum::<f64>() / 11.0;
        println!("b {b}: mean {found:.3}");
        assert!((found - mean).abs() < 0.01, "b {b}: {found}");
        assert!(ratios.iter().all(|ratio| (least..=most).contains(ratio)));
    }
}

/// The columns stood by themselves, without a lateral force, at these sways: `N w = 2 M(N)`. Above `n = 0.4` none of them had
/// buckled locally by 0.1 rad, so that hardening alone is compared. At `n = 0.21` both had.
///
/// S104406 is overstated most. It was once overstated by 6 %, by a push that was twice as fast, and because its sway was
/// taken at the last point of the test, where it still took 0.5 kN to push it.
#[test]
fn axial_loads_that_nakashimas_columns_lost() {
    let mut compared = [0, 0];
    for test in tests().nakashima.tests {
        let Some((last, measured)) = test.sway.zip(test.standing_sway()) else {
            continue;
        };
        // 1 mm of the digitised points is within the error of the rotation.
        assert!((0.99..1.03).contains(&(measured / last)), "{}", test.id);
        let n = test.axial_ratio();
        let found = [(0.0, false), (NAMED[0], false), (NAMED[0], true)]
            .map(|(b, softens)| test.sway_ratio(measured, b, softens, SPEED));
        println!(
            "{} n {n:.2}: {measured:.1} mm, simulated over measured {found:.3?}, with hardening over the last point {:.3}",
            test.id,
            found[1] * measured / last
        );
        let [ideal, hardening, softening] = found;
        assert!(ideal < 0.85, "{}: {ideal}", test.id);
        if n >= 0.4 {
            compared[0] += 1;
            assert!(
                (0.7..=1.05).contains(&hardening),
                "{}: {hardening}",
                test.id
            );
            // As a section by name has it: the formula lets these columns buckle long before they did.
            assert!((0.5..=0.9).contains(&softening), "{}: {softening}", test.id);
        } else {
            compared[1] += 1;
            assert!(
                (0.7..=1.05).contains(&softening),
                "{}: {softening}",
                test.id
            );
            // Without softening the law is on the unsafe side here.
            assert!(hardening > 1.15, "{}: {hardening}", test.id);
        }
    }
    assert_eq!(compared, [6, 2]);
}

/// Of the columns that stand at the smallest sways.
#[test]
fn the_push_is_slow_enough() {
    let mut tests = tests().nakashima.tests;
    for softens in [false, true] {
        let test = tests.swap_remove(9);
        let measured = test.standing_sway().expect("a sway");
        let [one, other] =
            [SPEED, 0.5 * SPEED].map(|speed| test.sway_ratio(measured, NAMED[0], softens, speed));
        println!("{}: {one} {other}", test.id);
        assert!((one / other - 1.0).abs() < 5e-3, "{one} {other}");
    }
}

/// The capping rotation of the formula is close to the measured onset of local buckling up to `n = 0.35` and before it above.
#[test]
fn capping_of_nakashimas_columns() {
    let mut compared = 0;
    for test in tests().nakashima.tests {
        let Some(measured) = test.buckling else {
            continue;
        };
        let ratio = test.softening().capping_rotation / measured;
        println!(
            "{} n {:.2}: formula over measured {ratio:.2}",
            test.id,
            test.axial_ratio()
        );
        assert!((0.6..=1.1).contains(&ratio), "{}: {ratio}", test.id);
        compared += 1;
    }
    assert_eq!(compared, 7);
}

/// Chord rotations at which the law caps, against the measured onset of local buckling, and at which it is down to 80 %. The
/// formula is on the unsafe side for W360x91, whose moment was down to 80 % at 61 % of the rotation of the law under `n = 0.3`.
#[test]
fn craveros_columns_of_which_w360x91_buckles_earlier_than_the_formula() {
    let Cravero { length, tests } = tests().cravero;
    let mut flagged = Vec::new();
    for test in tests {
        let mut backbone = SectionBackbone::of(&test.plates.section(), 1e-3 * length, test.n);
        backbone.web = test.h_tw;
        let softening = backbone.softening();
        let capping = test.yield_rotation + softening.capping_rotation;
        let onset = capping / test.buckling;
        let at_80 = test
            .moment_80
            .map(|measured| (capping + 0.2 * softening.post_capping_rotation) / measured);
        println!(
            "{}: capping rotation over onset of local buckling {onset:.2}, rotation at 80 % of the moment {at_80:.2?}",
            test.id
        );
        assert!((0.65..=1.95).contains(&onset), "{}: {onset}", test.id);
        if at_80.is_some_and(|ratio| ratio > 1.05) {
            flagged.push(test.id);
        } else {
            assert!(onset < 1.3, "{}: {onset}", test.id);
        }
    }
    assert_eq!(
        flagged,
        ["W360x91, n 0.30", "W360x91, n 0.50"],
        "which columns lose 20 % of their moment before the law says so"
    );
}

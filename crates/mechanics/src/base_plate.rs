//! The base plate of a column of an I section: moment, shear and uplift that it bears, and its stiffness, by the component
//! method of EN 1993-1-8 (6.2.8, 6.2.6.9 to 6.2.6.12, 6.2.2, 6.3.4).
//!
//! Components: the concrete under each flange, over the width that the plate spreads a pressure to
//! (`c = t_p sqrt(f_yp / (3 f_jd))`, 6.2.5); one line of anchors on each side (`0.9 f_ub A_s`, table 3.4); and the plate that
//! bends between that line and the flange, as a T-stub without prying forces, because long anchors give way (table 6.2). The
//! part of the plate under the web is left out, as 6.2.8.3 has it. With the lever arms `z_T` of the anchors and `z_C` of the
//! flanges, the tension `T <= T_R` of a line, the compression `C <= C_R` under a flange and the compressive force `N`:
//!
//! ```text
//! M = T z_T + C z_C,  C = N + T,
//! M(N) = min[ z_T (2 T_R + N), T_R (z_T + z_C) + N z_C, C_R (z_T + z_C) - N z_T, z_C (2 C_R - N) ] >= 0
//! ```
//!
//! The least of these lines is concave, and exact between `-T_R` and `C_R`; beyond, where both lines of anchors or both flanges
//! bear the same sign, it is on the safe side.
//!
//! Anchors bear shear by `alpha_b f_ub A_s` with `alpha_b = 0.44 - 0.0003 f_yb` \[MPa\], all of them, beside the friction of a
//! compressed base (6.2.2). They are fractured after a slip or an elongation that their ductility does not grant; a plate that
//! bends before its anchors yield has no such limit. What is not evaluated: welds, cone failure and pull-out of the concrete, bearing of the anchors
//! in the holes of the plate, and shear together with tension in the same anchor.
//!
//! The formulas are recalled and were compared with public implementations and with the manual of COST C1; the text of the
//! standard was not at hand.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::base_resistance::{BaseFailure, BaseResistance};
use super::section::RolledSection;

/// Thickness of the grout under the plate \[m\], assumed: it lengthens the anchors.
const GROUT: f64 = 0.03;

/// Length over which an anchor stretches in the concrete, relative to its diameter (6.2.6.12, after COST C1).
const EMBEDDED_LENGTH: f64 = 8.0;

/// Washer and half of the nut, relative to the diameter of the anchor, assumed.
const NUT_LENGTH: f64 = 0.6;

/// `beta_j` times the concentration factor of the concrete (6.2.5 and EN 1992-1-1, 6.7), assumed: `2/3` for grout and `1.5` for
/// a foundation that is larger than the plate.
const CONCENTRATION: f64 = 1.0;

/// Slip of the base at which an anchor is sheared off, relative to its diameter, an assumption: an engineer gives 5 to 10 mm for
/// M24, of which this is the middle. A resistance of `alpha_b f_ub A_s` already counts on a large slip, with an anchor that bends
/// and pulls (6.2.2).
const SLIP_AT_FRACTURE: f64 = 0.3;

/// Plastic strain of the stretched length of an anchor at which it is fractured, an assumption: ISO 898-1 and table 3.1 grant
/// fracture elongations of 8 % (6.8), 12 % (8.8), 20 % (5.6) and 22 % (4.6) over five diameters, a part of which is the neck,
/// and the thread takes more of it than the shank.
const STRAIN_AT_FRACTURE: f64 = 0.05;

/// Elastic modulus of steel \[Pa\].
const STEEL_MODULUS: f64 = 210e9;

/// A base plate under an I section that is bent about its strong axis. SI units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BasePlate {
    /// Dimensions of the section.
    pub section: RolledSection,
    /// `t_p` \[m\], > 0.
    pub thickness: f64,
    /// In the plane of bending, parallel to the web \[m\].
    pub length: f64,
    /// Parallel to the flanges \[m\].
    pub width: f64,
    /// `f_yp` of the plate \[Pa\].
    pub yield_strength: f64,
    /// The anchors.
    pub anchors: Anchors,
    /// `f_ck` \[Pa\].
    pub concrete_strength: f64,
    /// `E_cm` \[Pa\].
    pub concrete_modulus: f64,
    /// `C_f`: coefficient of friction between plate and grout, >= 0; 0.2 in 6.2.2.
    pub friction: f64,
}

/// The anchors of a base plate, in two lines that are parallel to the flanges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Anchors {
    /// Number of all anchors, even.
    pub count: u32,
    /// Nominal diameter \[m\], of the series of [`stress_area`].
    pub diameter: f64,
    /// `f_ub` \[Pa\].
    pub ultimate_strength: f64,
    /// `f_yb` \[Pa\]: at most 640 MPa, so that anchors may bear shear (6.2.2).
    pub yield_strength: f64,
    /// `z_T`: of each line from the axis of the section \[m\].
    pub distance: f64,
}

/// Partial factors by which resistances are divided.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BaseFactors {
    /// Of the plate (`gamma_M0`).
    pub plate: f64,
    /// Of the anchors (`gamma_M2`).
    pub anchors: f64,
    /// Of the concrete (`gamma_C`).
    pub concrete: f64,
}

impl BaseFactors {
    /// 1 for everything: characteristic resistances.
    pub const CHARACTERISTIC: Self = Self {
        plate: 1.0,
        anchors: 1.0,
        concrete: 1.0,
    };
}

/// Why there is no base plate of these numbers.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum BasePlateError {
    /// A number is NaN, infinite or outside its range.
    #[error("{name} is {found}; expected {expected}")]
    OutOfRange {
        /// Which number.
        name: &'static str,
        /// Its value.
        found: f64,
        /// What is expected instead.
        expected: &'static str,
    },
    /// The plate does not reach around the section.
    #[error(
        "the base plate, {length} m long (parallel to the web) and {width} m wide, is smaller than the section, \
         {depth} m by {flange} m; enlarge the plate"
    )]
    PlateTooSmall {
        /// Of the plate \[m\].
        length: f64,
        /// Of the plate \[m\].
        width: f64,
        /// `h` \[m\].
        depth: f64,
        /// `b` \[m\].
        flange: f64,
    },
    /// Anchors beside the plate or at its very edge.
    #[error(
        "the line of anchors lies {distance} m from the axis, outside of the base plate, which ends at {edge} m; with their \
         diameter of {diameter} m they have to lie at most {most} m from the axis: move them inwards or enlarge the plate"
    )]
    AnchorsOutsideThePlate {
        /// Of the line from the axis \[m\].
        distance: f64,
        /// Of the edge from the axis \[m\].
        edge: f64,
        /// Of an anchor \[m\].
        diameter: f64,
        /// Largest distance \[m\].
        most: f64,
    },
    /// Anchors where the flange is.
    #[error(
        "the line of anchors, {distance} m from the axis, meets the flange, which reaches from {from} m to {to} m; expected \
         anchors that clear it by half their diameter of {diameter} m"
    )]
    AnchorsInTheFlange {
        /// Of the line from the axis \[m\].
        distance: f64,
        /// Inner face of the flange \[m\].
        from: f64,
        /// Outer face of the flange \[m\].
        to: f64,
        /// Of an anchor \[m\].
        diameter: f64,
    },
}

/// `A_s`: stress area of a thread of the coarse series \[m²\] (ISO 898-1); `None` for other diameters \[m\].
#[must_use]
pub fn stress_area(diameter: f64) -> Option<f64> {
    const AREAS: [(f64, f64); 17] = [
        (12.0, 84.3),
        (14.0, 115.0),
        (16.0, 157.0),
        (18.0, 192.0),
        (20.0, 245.0),
        (22.0, 303.0),
        (24.0, 353.0),
        (27.0, 459.0),
        (30.0, 561.0),
        (33.0, 694.0),
        (36.0, 817.0),
        (39.0, 976.0),
        (42.0, 1120.0),
        (45.0, 1310.0),
        (48.0, 1470.0),
        (52.0, 1760.0),
        (56.0, 2030.0),
    ];
    AREAS
        .into_iter()
        .find(|(nominal, _)| (diameter * 1e3 - nominal).abs() < 1e-6)
        .map(|(_, area)| area * 1e-6)
}

impl BasePlate {
    /// What the plate bears.
    ///
    /// # Errors
    /// Numbers out of range, a plate that is smaller than the section, anchors outside of the plate or in the flange.
    pub fn resistance(&self, factors: &BaseFactors) -> Result<BaseResistance, BasePlateError> {
        let area = self.check()?;
        let (anchors, section) = (&self.anchors, &self.section);
        let per_line = f64::from(anchors.count / 2);
        let bolt = 0.9 * anchors.ultimate_strength * area / factors.anchors;
        let stub = self.tension_stub();
        let plate =
            2.0 * 0.25 * stub.length * self.thickness * self.thickness * self.yield_strength
                / (stub.lever * factors.plate);
        let bolts = per_line * bolt;
        let (tension, tension_limit) = match plate < bolts {
            true => (plate, BaseFailure::Plate),
            false => (bolts, BaseFailure::AnchorsInTension),
        };
        let pressure = CONCENTRATION * self.concrete_strength / factors.concrete;
        let spread =
            self.thickness * (self.yield_strength / (3.0 * pressure * factors.plate)).sqrt();
        let outwards = spread.min(0.5 * (self.length - section.depth));
        let inwards = spread.min(0.5 * section.depth - section.flange_thickness);
        let bearing = [
            section.flange_thickness + outwards + inwards,
            section.width + 2.0 * spread.min(0.5 * (self.width - section.width)),
        ];
        let lever = [
            anchors.distance,
            0.5 * (section.depth - section.flange_thickness),
        ];
        // Table 6.11: k_13 of the concrete, k_15 of the plate and k_16 of the anchors without prying forces, as flexibilities.
        let stretched = (EMBEDDED_LENGTH + NUT_LENGTH) * anchors.diameter + GROUT + self.thickness;
        let cube = |x: f64| x * x * x;
        let flexibility = 1.275 * STEEL_MODULUS
            / (self.concrete_modulus * (bearing[0] * bearing[1]).sqrt())
            + cube(stub.lever) / (0.425 * stub.length * cube(self.thickness))
            + stretched / (per_line * area);
        let arm = lever[0] + lever[1];
        let alpha = 0.44 - 0.0003 * (anchors.yield_strength * 1e-6);
        Ok(BaseResistance {
            tension,
            tension_limit,
            compression: pressure * bearing[0] * bearing[1],
            lever,
            anchor_shear: f64::from(anchors.count) * alpha * anchors.ultimate_strength * area
                / factors.anchors,
            friction: self.friction,
            stiffness: STEEL_MODULUS * arm * arm / flexibility,
            ultimate_slip: SLIP_AT_FRACTURE * anchors.diameter,
            ultimate_elongation: match tension_limit {
                BaseFailure::AnchorsInTension => STRAIN_AT_FRACTURE * stretched,
                _ => 0.0,
            },
        })
    }

    /// Checks the numbers and returns the stress area of an anchor \[m²\].
    fn check(&self) -> Result<f64, BasePlateError> {
        let (anchors, section) = (&self.anchors, &self.section);
        let checks = [
            ("thickness of the base plate [m]", self.thickness),
            ("length of the base plate [m]", self.length),
            ("width of the base plate [m]", self.width),
            ("yield strength of the base plate [Pa]", self.yield_strength),
            (
                "ultimate strength of the anchors [Pa]",
                anchors.ultimate_strength,
            ),
            ("strength of the concrete [Pa]", self.concrete_strength),
            ("modulus of the concrete [Pa]", self.concrete_modulus),
        ];
        let out_of_range = |name, found, expected| {
            Err(BasePlateError::OutOfRange {
                name,
                found,
                expected,
            })
        };
        for (name, found) in checks {
            if !(found.is_finite() && found > 0.0) {
                return out_of_range(name, found, "a finite number > 0");
            }
        }
        for (name, found) in [
            (
                "coefficient of friction under the base plate",
                self.friction,
            ),
            (
                "distance of the anchors from the axis [m]",
                anchors.distance,
            ),
        ] {
            if !(found.is_finite() && found >= 0.0) {
                return out_of_range(name, found, "a finite number >= 0");
            }
        }
        if !(235e6..=640e6).contains(&anchors.yield_strength) {
            return out_of_range(
                "yield strength of the anchors [Pa]",
                anchors.yield_strength,
                "235 to 640 MPa, for which EN 1993-1-8, 6.2.2 has the shear resistance of anchors",
            );
        }
        if anchors.count < 2 || anchors.count % 2 != 0 {
            return out_of_range(
                "number of anchors",
                f64::from(anchors.count),
                "an even number >= 2: half of them in each line",
            );
        }
        let Some(area) = stress_area(anchors.diameter) else {
            return out_of_range(
                "diameter of the anchors [m]",
                anchors.diameter,
                "a thread of the coarse series from M12 to M56, such as 0.024",
            );
        };
        if self.length < section.depth || self.width < section.width {
            return Err(BasePlateError::PlateTooSmall {
                length: self.length,
                width: self.width,
                depth: section.depth,
                flange: section.width,
            });
        }
        let (edge, radius) = (0.5 * self.length, 0.5 * anchors.diameter);
        if anchors.distance + radius > edge {
            return Err(BasePlateError::AnchorsOutsideThePlate {
                distance: anchors.distance,
                edge,
                diameter: anchors.diameter,
                most: edge - radius,
            });
        }
        let to = 0.5 * section.depth;
        let from = to - section.flange_thickness;
        if anchors.distance + radius > from && anchors.distance - radius < to {
            return Err(BasePlateError::AnchorsInTheFlange {
                distance: anchors.distance,
                from,
                to,
                diameter: anchors.diameter,
            });
        }
        Ok(area)
    }

    /// The T-stub of the plate in tension (table 6.6 and, between the flanges, table 6.4). The weld is not known: the lever counts
    /// from the face of the flange or of the web, on the safe side. Across the plate the anchors have the distance from its edge
    /// that they have along it.
    fn tension_stub(&self) -> Stub {
        let (anchors, section) = (&self.anchors, &self.section);
        let edge = 0.5 * self.length - anchors.distance;
        let gauge = (self.width - 2.0 * edge).max(0.0);
        let pairs = f64::from(anchors.count / 2) / 2.0;
        let turn = std::f64::consts::PI;
        if anchors.distance > 0.5 * section.depth {
            let m = anchors.distance - 0.5 * section.depth;
            let lengths = [
                2.0 * turn * m,
                turn * m + gauge,
                turn * m + 2.0 * edge,
                4.0 * m + 1.25 * edge,
                edge + 2.0 * m + 0.625 * edge,
                0.5 * gauge + 2.0 * m + 0.625 * edge,
            ];
            let shortest = lengths.into_iter().fold(f64::INFINITY, f64::min);
            return Stub {
                length: (pairs.max(0.5) * shortest).min(0.5 * self.width),
                lever: m,
            };
        }
        let m = (0.5 * (gauge - section.web_thickness)).max(0.5 * anchors.diameter);
        Stub {
            length: pairs.max(0.5) * (2.0 * turn * m).min(4.0 * m + 1.25 * edge),
            lever: m,
        }
    }
}

/// A T-stub: its effective length and the lever of its anchors \[m\].
struct Stub {
    length: f64,
    lever: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// HEB 220 on a plate of 400 x 400 x 30 with four M24 8.8 at 140 mm from the axis, in C25/30.
    const PLATE: BasePlate = BasePlate {
        section: RolledSection {
            depth: 0.220,
            width: 0.220,
            web_thickness: 0.0095,
            flange_thickness: 0.016,
            root_radius: 0.018,
        },
        thickness: 0.03,
        length: 0.4,
        width: 0.4,
        yield_strength: 355e6,
        anchors: Anchors {
            count: 4,
            diameter: 0.024,
            ultimate_strength: 800e6,
            yield_strength: 640e6,
            distance: 0.14,
        },
        concrete_strength: 25e6,
        concrete_modulus: 31e9,
        friction: 0.2,
    };

    const DESIGN: BaseFactors = BaseFactors {
        plate: 1.0,
        anchors: 1.25,
        concrete: 1.5,
    };

    fn resistance(plate: &BasePlate, factors: &BaseFactors) -> BaseResistance {
        plate.resistance(factors).expect("a base plate")
    }

    fn near(found: f64, expected: f64, tolerance: f64) {
        assert!(
            (found / expected - 1.0).abs() < tolerance,
            "{found} instead of {expected}"
        );
    }

    /// The numbers that an engineer has worked out by hand for 490 kN of compression: with the partial factor of anchors 148 kNm
    /// and 322 kN, without it 173 kNm and 378 kN; 29 MNm/rad; 203 kN per anchor.
    #[test]
    fn the_worked_example() {
        let (design, plain) = (
            resistance(&PLATE, &DESIGN),
            resistance(&PLATE, &BaseFactors::CHARACTERISTIC),
        );
        near(design.tension / 2.0, 203e3, 0.005);
        near(design.moment(-490e3), 148e3, 0.01);
        near(plain.moment(-490e3), 173e3, 0.01);
        near(design.shear(-490e3), 322e3, 0.005);
        near(plain.shear(-490e3), 378e3, 0.005);
        near(plain.stiffness, 29e6, 0.02);
        assert_eq!(plain.tension_limit, BaseFailure::AnchorsInTension);
        assert_eq!(plain.moment_limit(-490e3), BaseFailure::AnchorsInTension);
        assert_eq!(plain.moment_limit(-1.5e6), BaseFailure::Concrete);
        // Lifted, it has no friction.
        assert_eq!(plain.shear(100e3), plain.anchor_shear);
        near(plain.uplift(), 4.0 * 0.9 * 800e6 * 353e-6, 1e-12);
    }

    /// Without a moment the base bears all anchors or both flanges, and between, the moment is that of the equilibrium.
    #[test]
    fn the_moment_is_concave_in_the_normal_force() {
        let mut thin = PLATE;
        thin.thickness = 0.012;
        let mut inside = PLATE;
        inside.anchors.distance = 0.06;
        for plate in [PLATE, thin, inside] {
            let it = resistance(&plate, &BaseFactors::CHARACTERISTIC);
            let (from, to) = (-2.0 * it.compression, it.uplift());
            assert!(it.moment(to) <= 1e-9 && it.moment(from) <= 1e-9);
            let at = |k: u32| it.moment(from + (to - from) * f64::from(k) / 400.0);
            for k in 1..400 {
                let [before, now, after] = [at(k - 1), at(k), at(k + 1)];
                let above = now - 0.5 * (before + after);
                // Beyond its ends it is 0, and there it is not concave.
                assert!(
                    above >= -1e-6 || before == 0.0 || after == 0.0,
                    "{k}: {above}"
                );
            }
        }
    }

    #[test]
    fn thicker_plates_and_anchors_bear_no_less() {
        let mut before: Option<[f64; 4]> = None;
        let numbers = |plate: &BasePlate| {
            let it = resistance(plate, &BaseFactors::CHARACTERISTIC);
            [
                it.moment(-490e3),
                it.uplift(),
                it.anchor_shear,
                it.stiffness,
            ]
        };
        for millimetres in [10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0] {
            let mut plate = PLATE;
            plate.thickness = millimetres * 1e-3;
            let found = numbers(&plate);
            if let Some(before) = before {
                // A thicker plate makes the anchors longer by a little.
                let pairs = found.into_iter().zip(before).take(3);
                assert!({ pairs }.all(|(now, before)| now >= before));
            }
            before = Some(found);
        }
        let mut before = [0.0; 4];
        for millimetres in [12.0, 16.0, 20.0, 24.0, 27.0, 30.0] {
            let mut plate = PLATE;
            plate.anchors.diameter = millimetres * 1e-3;
            plate.anchors.distance = 0.145;
            let found = numbers(&plate);
            assert!(
                found
                    .into_iter()
                    .zip(before)
                    .all(|(now, before)| now >= before)
            );
            before = found;
        }
    }

    #[test]
    fn bad_plates_are_rejected_with_their_reason() {
        type Change = fn(&mut BasePlate);
        let changes: [(Change, &str); 9] = [
            (
                |it| it.thickness = 0.0,
                "thickness of the base plate [m] is 0",
            ),
            (|it| it.length = 0.2, "smaller than the section"),
            (|it| it.anchors.distance = 0.19, "outside of the base plate"),
            (|it| it.anchors.distance = 0.105, "meets the flange"),
            (|it| it.anchors.diameter = 0.025, "coarse series"),
            (|it| it.anchors.count = 3, "an even number"),
            (|it| it.anchors.yield_strength = 900e6, "235 to 640 MPa"),
            (|it| it.friction = f64::NAN, "coefficient of friction"),
            (|it| it.concrete_strength = -1.0, "strength of the concrete"),
        ];
        for (change, reason) in changes {
            let mut plate = PLATE;
            change(&mut plate);
            let found = plate.resistance(&BaseFactors::CHARACTERISTIC);
            let error = found.expect_err(reason);
            let written = error.to_string();
            assert!(written.contains(reason), "{written}");
        }
    }
}

//! A column as an engineer gives it, and the beam that is built from it.

use column_mechanics::{RateProperties, Support};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::beam::Beam;
use super::curve::Steel;
use super::element::{Ends, UPRIGHT, angles, deformations};
use super::mesh::{self, Density};
use super::parts::{Element, RotationSpring, Slider};
use super::rate::Rate;
use super::section::{Division, Section, Shape};
use super::torsion::effective_rigidity;

/// How the column resists twist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Torsion {
    /// Saint-Venant's torsion and restrained warping, as the rigidity that gives the same twist at the impact point.
    Warping,
    /// Saint-Venant's torsion alone.
    SaintVenant,
    /// The twist is suppressed by a rigidity a thousand times Saint-Venant's.
    None,
}

/// Axes about which the column is bowed before the impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BowAxes {
    /// Both.
    Both,
    /// The strong axis: along the web.
    Strong,
    /// The weak axis: along the flanges.
    Weak,
}

/// A column for the beam. SI units throughout.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BeamColumn {
    /// Shape of the section.
    pub shape: Shape,
    /// Its steel.
    pub steel: Steel,
    /// `L_a`: height of the impact point above the base \[m\].
    pub length_below: f64,
    /// `L_b`: from the impact point to the top \[m\].
    pub length_above: f64,
    /// Rotational support of the foot, about both axes.
    pub base: Support,
    /// Rotational support of the head, about both axes.
    pub top: Support,
    /// `k_s`: stiffness of the vertical spring at the top \[N/m\].
    pub top_spring_stiffness: f64,
    /// `m_2`: mass at the top \[kg\].
    pub top_mass: f64,
    /// `P`: load on the top \[N\].
    pub top_load: f64,
    /// Strain rate; its hinge length and section height are not used.
    pub rate: Option<RateProperties>,
    /// Whether the web deforms and yields in shear.
    pub shear: bool,
    /// Largest shear strength of the web that hardens over its initial one, >= 1; 0 for no limit.
    pub max_shear_hardening: f64,
    /// How it resists twist.
    pub torsion: Torsion,
    /// `I_t` \[m⁴\]; `None` for that of the shape.
    pub torsion_constant: Option<f64>,
    /// Whether the section has the residual stresses of rolling (ECCS).
    pub residual_stress: bool,
    /// Initial bow \[m\]; 0 for a straight column, negative for 1/1000 of its length.
    pub bow: f64,
    /// About which axes it is bowed.
    pub bow_axes: BowAxes,
    /// Height of the bumper \[m\]; 0 for a force at a point.
    pub bumper_height: f64,
    /// Elements along the column; 0 for automatic.
    pub elements: usize,
    /// Fibres across a flange, and layers of the web; 0 for automatic.
    pub fibres: usize,
    /// Length of a time step \[ns\]; 0 for automatic.
    pub step_nanos: u64,
}

/// Why there is no second opinion.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BeamError {
    /// A number of the column.
    #[error("no second opinion: the beam's {name} is {found:e}; expected {expected}")]
    Column {
        /// Which number.
        name: &'static str,
        /// Its value.
        found: f64,
        /// What is expected instead.
        expected: &'static str,
    },
    /// The direction of a hit.
    #[error(
        "no second opinion: the direction of the impact is {found} rad; expected a number in (-pi, pi]"
    )]
    Direction {
        /// Its value \[rad\].
        found: f64,
    },
    /// The impact.
    #[error("no second opinion: {0}")]
    Impact(#[from] column_mechanics::ImpactError),
    /// No equilibrium under the load before the impact.
    #[error(
        "no second opinion: the column has no equilibrium under its load of {load:e} N before the impact; expected a load below its capacity"
    )]
    Unstable {
        /// The load \[N\].
        load: f64,
    },
    /// No equilibrium under the load before the impact when the column can bend about both axes.
    #[error(
        "no second opinion: undamaged and bowed about its axes, the column does not bear its load of {load:e} N about its weak axis; \
         expected a load below its capacity; if the column is held about its weak axis, set beam.bow_axes: strong"
    )]
    WeakAxis {
        /// The load \[N\].
        load: f64,
    },
    /// Too many steps, or too many updates of fibres.
    #[error(
        "no second opinion: the response did not end within {steps} steps, or within {updates:.0e} updates of a fibre; choose longer \
         steps with beam.dt, fewer elements with beam.elements or fewer fibres with beam.fibres, or 0 for automatic ones"
    )]
    Budget {
        /// Most steps.
        steps: u64,
        /// Most updates of a fibre.
        updates: f64,
    },
    /// Equations that were not solved.
    #[error(
        "no second opinion: a step of the beam was not solved {time:.6} s after the touch; choose shorter steps with beam.dt"
    )]
    NotSolved {
        /// When \[s\].
        time: f64,
    },
    /// Damage of another section.
    #[error(
        "no second opinion: the damage was stored for a section of {found} fibres; expected {expected}; keep section, beam.fibres, beam.shear and beam.residual_stress as they were"
    )]
    Damage {
        /// How many fibres it has.
        found: usize,
        /// How many the section has.
        expected: usize,
    },
    /// A measurement that contradicts the damage.
    #[error(
        "no second opinion: at {height} m the fibre beam has {before:.4e} where {measured:.4e} were measured, and no plausible factor on \
         its plastic deformation makes it meet this in equilibrium; the column has another damage than its impacts explain, and must \
         be examined"
    )]
    Correction {
        /// What the beam has, a displacement \[m\] or a rotation \[rad\].
        before: f64,
        /// What was measured.
        measured: f64,
        /// Above the base \[m\].
        height: f64,
    },
    /// Damage of a column of another length.
    #[error(
        "no second opinion: the damage was stored for a column of {found} m; expected {expected} m, the length of this column"
    )]
    DamageLength {
        /// Its length \[m\].
        found: f64,
        /// That of the column \[m\].
        expected: f64,
    },
}

/// Most elements along the column, and most fibres across a flange or the web: more take longer than an opinion may.
const MOST_ELEMENTS: usize = 400;
const MOST_FIBRES: usize = 100;

/// Fewest fibres across a flange in space. With ten, the displacement across an oblique hit is within 2.5 % of that with 48 fibres in
/// all cases of the references; with eight, it is up to 5 % off, because it is the difference of two larger ones.
const FEWEST_ACROSS: usize = 10;

/// Least and largest tensile strength of a steel with a yield plateau over its yield strength, and strain at which it yields at the
/// latest.
const LEAST_STRENGTH_RATIO: f64 = 1.02;
const LARGEST_STRENGTH_RATIO: f64 = 10.0;
const LONGEST_ELASTIC: f64 = 0.01;

/// Stiffness of a semi-rigid support \[N m/rad\].
fn stiffness(support: Support) -> f64 {
    match support {
        Support::SemiRigid { stiffness } => stiffness,
        Support::BuiltIn | Support::Pinned | Support::Free => 1.0,
    }
}

impl BeamColumn {
    /// Whole length \[m\].
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length_below + self.length_above
    }

    /// `E I` about the strong axis \[N m²\].
    #[must_use]
    pub fn bending_stiffness(&self) -> f64 {
        self.section(true).elastic()[1]
    }

    /// Depth of the section along y \[m\].
    pub(crate) fn depth(&self) -> f64 {
        match self.shape {
            Shape::Rolled(rolled) => rolled.depth,
            Shape::Rectangular { depth, .. } => depth,
            Shape::Circular { diameter, .. } => diameter,
        }
    }

    /// Bow along y and z \[m\].
    #[must_use]
    pub fn bows(&self) -> [f64; 2] {
        let bow = if self.bow < 0.0 {
            self.length() / 1000.0
        } else {
            self.bow
        };
        match self.bow_axes {
            BowAxes::Both => [bow, bow],
            BowAxes::Strong => [bow, 0.0],
            BowAxes::Weak => [0.0, bow],
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// The first number out of range.
    pub fn check(&self) -> Result<(), BeamError> {
        let positive = "a finite number > 0";
        let not_negative = "a finite number >= 0";
        let [first, second, third, fourth] = match self.shape {
            Shape::Rolled(rolled) => [
                rolled.depth,
                rolled.width,
                rolled.web_thickness,
                rolled.flange_thickness,
            ],
            Shape::Rectangular {
                depth,
                width,
                thickness,
            } => [depth, width, thickness, thickness],
            Shape::Circular {
                diameter,
                thickness,
            } => [diameter, diameter, thickness, thickness],
        };
        let above_zero = [
            ("depth of the section [m]", first),
            ("width of the section [m]", second),
            ("thickness of the web or wall [m]", third),
            ("thickness of the flanges or wall [m]", fourth),
            ("height of the impact point [m]", self.length_below),
            ("length above the impact point [m]", self.length_above),
            ("Young's modulus [Pa]", self.steel.young_modulus),
            ("yield strength [Pa]", self.steel.yield_strength),
            ("density [kg/m3]", self.steel.density),
            (
                "torsion constant [m4]",
                self.torsion_constant.unwrap_or(1.0),
            ),
            (
                "rotational stiffness of the base [N m/rad]",
                stiffness(self.base),
            ),
            (
                "rotational stiffness of the top [N m/rad]",
                stiffness(self.top),
            ),
        ];
        for (name, found) in above_zero {
            if !(found.is_finite() && found > 0.0) {
                return Err(BeamError::Column {
                    name,
                    found,
                    expected: positive,
                });
            }
        }
        let radius = match self.shape {
            Shape::Rolled(rolled) => rolled.root_radius,
            _ => 0.0,
        };
        let others = [
            ("spring at the top [N/m]", self.top_spring_stiffness),
            ("mass at the top [kg]", self.top_mass),
            ("load on the top [N]", self.top_load),
            ("height of the bumper [m]", self.bumper_height),
            ("radius of the fillets [m]", radius),
        ];
        for (name, found) in others {
            if !(found.is_finite() && found >= 0.0) {
                return Err(BeamError::Column {
                    name,
                    found,
                    expected: not_negative,
                });
            }
        }
        // What the walls leave free of the section.
        let (wall, free) = match self.shape {
            Shape::Rolled(rolled) => (
                rolled.flange_thickness + radius,
                (rolled.depth - 2.0 * (rolled.flange_thickness + radius))
                    .min(rolled.width - rolled.web_thickness - 2.0 * radius),
            ),
            _ => (third, first.min(second) - 2.0 * third),
        };
        if free <= 0.0 {
            return Err(BeamError::Column {
                name: "thickness of the walls with their fillets [m]",
                found: wall,
                expected: "less than what the depth and the width of the section leave",
            });
        }
        let counts = [
            ("number of elements", self.elements, MOST_ELEMENTS),
            ("number of fibres", self.fibres, MOST_FIBRES),
        ];
        for (name, found, most) in counts {
            if found > most {
                return Err(BeamError::Column {
                    name,
                    found: found as f64,
                    expected: "0 for automatic, at most 400 elements and at most 100 fibres",
                });
            }
        }
        let nu = self.steel.poisson_ratio;
        if !(0.0..0.5).contains(&nu) {
            return Err(BeamError::Column {
                name: "Poisson's ratio",
                found: nu,
                expected: "a number from 0 to below 0.5",
            });
        }
        let b = self.steel.hardening_ratio;
        if !(1e-5..=0.1).contains(&b) {
            return Err(BeamError::Column {
                name: "hardening ratio",
                found: b,
                expected: "a number from 1e-5 to 0.1: without hardening the length that yields depends on the mesh",
            });
        }
        if let Some(found) = self.steel.tensile_strength {
            let first = self.steel.yield_strength;
            let has_plateau = first < LONGEST_ELASTIC * self.steel.young_modulus;
            let range = LEAST_STRENGTH_RATIO * first..=LARGEST_STRENGTH_RATIO * first;
            if !(range.contains(&found) && has_plateau) {
                return Err(BeamError::Column {
                    name: "tensile strength [Pa]",
                    found,
                    expected: "1.02 to 10 times the yield strength, of a steel that yields at a strain below 0.01",
                });
            }
        }
        let most = self.max_shear_hardening;
        if !(most == 0.0 || most >= 1.0 && most.is_finite()) {
            return Err(BeamError::Column {
                name: "largest strength of the hardened web over its initial one",
                found: most,
                expected: "a finite number >= 1, or 0 for no limit",
            });
        }
        if 0.5 * self.bumper_height >= 0.95 * self.length_below.min(self.length_above) {
            return Err(BeamError::Column {
                name: "height of the bumper [m]",
                found: self.bumper_height,
                expected: "less than 1.9 times the shorter part of the column",
            });
        }
        if !self.bow.is_finite() || self.bow > 0.05 * self.length() {
            return Err(BeamError::Column {
                name: "bow [m]",
                found: self.bow,
                expected: "at most a twentieth of the length",
            });
        }
        Ok(())
    }

    /// Heights of the nodes \[m\]; `elements` 0 for automatic.
    pub(crate) fn heights(&self, elements: usize, density: Density) -> Vec<f64> {
        let half = 0.5 * self.bumper_height;
        let (at, top) = (self.length_below, self.length());
        if half > 0.0 {
            let keys = [0.0, at - half, at, at + half, top];
            mesh::nodes(&keys, self.depth(), elements, density)
        } else {
            mesh::nodes(&[0.0, at, top], self.depth(), elements, density)
        }
    }

    /// The fibres: in the plane of the web alone, or in space.
    pub(crate) fn section(&self, plane: bool) -> Section {
        let web = if self.fibres == 0 { 8 } else { self.fibres };
        let division = Division {
            web,
            layers: 2,
            across: if plane { 1 } else { web.max(FEWEST_ACROSS) },
        };
        let mut section = Section::new(
            &self.shape,
            self.steel,
            division,
            self.shear,
            self.residual_stress,
        );
        if self.max_shear_hardening > 0.0 {
            let strength = self.steel.yield_strength / 3.0_f64.sqrt();
            section.largest_back_stress = (self.max_shear_hardening - 1.0) * strength;
            if let Some([_, sheared]) = &mut section.curves {
                sheared.end_at(section.largest_back_stress);
            }
        }
        section
    }

    /// The beam on these heights.
    pub(crate) fn beam<const D: usize, const R: usize, const Q: usize>(
        &self,
        heights: &[f64],
        bows: [f64; 2],
    ) -> Beam<D, R, Q> {
        let plane = D == 3;
        let section = self.section(plane);
        let whole = self.length();
        let shape = |x: f64| libm::sin(std::f64::consts::PI * x / whole);
        let places: Vec<[f64; 3]> = heights
            .iter()
            .map(|&x| {
                let weak = if plane { 0.0 } else { bows[1] * shape(x) };
                [x, bows[0] * shape(x), weak]
            })
            .collect();
        let half_bumper = 0.5 * self.bumper_height;
        let elements = places.windows(2).map(|pair| {
            let chord = [0, 1, 2].map(|k| pair[1][k] - pair[0][k]);
            let ends = Ends::new::<6>(chord, [&UPRIGHT, &UPRIGHT]);
            let l = ends.length;
            let middle = 0.5 * (pair[0][0] + pair[1][0]);
            let (bar, clear) = if middle < self.length_below {
                (0, self.length_below - half_bumper)
            } else {
                (1, self.length_above - half_bumper)
            };
            // Behind the bumper the column does not shear.
            let behind = (middle - self.length_below).abs() < half_bumper;
            let bar = (section.web_rigidity > 0.0 && !behind).then_some(bar);
            Element {
                length: l,
                initial: angles(&deformations(&ends, l)),
                sliders: self.sliders(&section, clear),
                bar,
            }
        });
        let elements: Vec<Element<R>> = elements.collect();
        let rho = self.steel.density;
        let nodes = places.len();
        let [strong, weak] = section.second_moment;
        let mut inertia = vec![[0.0; 4]; nodes];
        for (index, element) in elements.iter().enumerate() {
            let half = 0.5 * rho * element.length;
            let part = [section.area, strong + weak, weak, strong].map(|x| x * half);
            for node in [index, index + 1] {
                for (to, by) in inertia[node].iter_mut().zip(part) {
                    *to += by;
                }
            }
        }
        inertia[nodes - 1][0] += self.top_mass;
        let mut held = vec![[false; D]; nodes];
        let mut springs = Vec::new();
        let dim = D / 2 + usize::from(plane);
        for (node, support) in [(0, self.base), (nodes - 1, self.top)] {
            if support == Support::Free {
                continue;
            }
            for unknown in usize::from(node > 0)..dim {
                held[node][unknown] = true;
            }
            match support {
                Support::BuiltIn => held[node][dim..].fill(true),
                Support::SemiRigid { stiffness } => {
                    springs.push(RotationSpring { node, stiffness })
                }
                Support::Pinned | Support::Free => {}
            }
            if !plane {
                held[node][3] = true;
            }
        }
        let constant = self.torsion_constant.unwrap_or(section.torsion[0]);
        let uniform = self.steel.shear_modulus() * constant;
        let torsional_rigidity = match self.torsion {
            Torsion::SaintVenant => uniform,
            Torsion::None => 1000.0 * uniform,
            Torsion::Warping => effective_rigidity(
                uniform,
                self.steel.young_modulus * section.torsion[1],
                [self.length_below, self.length_above],
                [self.base, self.top].map(|support| support == Support::BuiltIn),
            ),
        };
        Beam {
            section,
            places,
            elements,
            inertia,
            held,
            rotation_springs: springs,
            top_spring: self.top_spring_stiffness,
            top_load: self.top_load,
            torsional_rigidity,
            rate: self.rate.as_ref().map(Rate::new),
        }
    }

    /// The web within the flanges, and the frame of both flanges: fixed at both ends of a length `clear`, they resist with
    /// `24 E I_f / l^2` per shear angle up to `2 m_f / l`, the moments at one end; at the other they belong to the hinge there.
    fn sliders(&self, section: &Section, clear: f64) -> [Slider; 2] {
        if section.web_rigidity == 0.0 {
            return [Slider::default(); 2];
        }
        let (steel, area) = (&self.steel, section.shear_only_area);
        if area == 0.0 {
            return [Slider::default(); 2];
        }
        let [second_moment, plastic] = section.flanges;
        let frame = 12.0 * steel.young_modulus * second_moment / (clear * clear);
        let b = steel.hardening_ratio;
        [
            Slider {
                rigidity: steel.shear_modulus() * area,
                resistance: steel.yield_strength / 3.0_f64.sqrt() * area,
                hardening: steel.plastic_modulus() / 3.0 * area,
                most: section.largest_back_stress * area,
            },
            Slider {
                rigidity: frame,
                resistance: 2.0 * plastic * steel.yield_strength / clear,
                hardening: frame * b / (1.0 - b),
                // The limit is that of the web.
                most: f64::INFINITY,
            },
        ]
    }
}

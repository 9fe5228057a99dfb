//! The shear of the web of a column, from its section and its parameters.

use std::f64::consts::PI;

use super::Parameters;
use super::catalogue::CatalogueSection;
use super::section::{or_else, or_of_name};
use super::settings::{SectionShape, ShearModel};
use crate::column::{RolledSection, ShearProperties};

/// Why the web of a column does not yield in shear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoShear {
    /// `shear.model` is `none`.
    #[error("shear of the web is switched off (shear.model: none)")]
    SwitchedOff,
    /// A section by numbers without its web.
    #[error(
        "the web is not known: give section.height, section.web_thickness, section.width and section.flange_thickness, or \
         resistance.shear, or name the section"
    )]
    WebNotKnown,
}

/// `nu` of structural steel (EN 1993-1-1, 3.2.6).
pub const POISSON_RATIO: f64 = 0.3;

impl Parameters {
    /// Dimensions of the web and the flanges for the shear of the column: those of a named section and the numbers that override
    /// them, or numbers alone; width and thickness of the flanges are 0 where they are not known. The root radius is that of a
    /// named section. `None` where the height of the section or the thickness of its web is not known.
    fn shear_dimensions(&self) -> Option<RolledSection> {
        let given = &self.settings.section;
        let named = CatalogueSection::named(&given.name).map(|section| section.dimensions);
        let dimensions = RolledSection {
            depth: self.section().height,
            width: or_of_name(given.width, named.map(|it| it.width)),
            web_thickness: or_of_name(given.web_thickness, named.map(|it| it.web_thickness)),
            flange_thickness: or_of_name(
                given.flange_thickness,
                named.map(|it| it.flange_thickness),
            ),
            root_radius: named.map_or(0.0, |it| it.root_radius),
        };
        (dimensions.depth > 0.0 && dimensions.web_thickness > 0.0).then_some(dimensions)
    }

    /// Shear of the walls of the section in the plane of bending, by its dimensions alone, without the limit of its hardening;
    /// `None` where they are not known.
    pub(crate) fn shear_of_section(&self) -> Option<ShearProperties> {
        let (section, steel) = (self.shear_dimensions()?, self.steel());
        let ratio = self.settings.hardening.ratio;
        let of = |section: RolledSection| {
            section.shear(
                steel.yield_strength,
                steel.young_modulus,
                POISSON_RATIO,
                ratio,
            )
        };
        let wall = section.web_thickness;
        Some(match self.settings.section.shape {
            SectionShape::IOrH => of(section),
            // An I section with both walls as its web.
            SectionShape::RectangularHollow => of(RolledSection {
                web_thickness: 2.0 * wall,
                flange_thickness: or_else(section.flange_thickness, wall),
                ..section
            }),
            // The shear flow of a thin ring is in proportion to the sine of the angle from the plane of bending where it is
            // elastic, and constant where it is plastic (EN 1993-1-1, 6.2.6: 2 A / pi).
            SectionShape::CircularHollow => {
                let half = 0.5 * PI * (section.depth - wall) * wall;
                let strength = steel.yield_strength / 3.0_f64.sqrt();
                ShearProperties {
                    web_resistance: strength * 4.0 / PI * half,
                    flange_moment: 0.0,
                    rigidity: half * steel.young_modulus / (2.0 * (1.0 + POISSON_RATIO)),
                    hardening: half * ratio * steel.young_modulus / 3.0,
                    max_hardening: 0.0,
                    ultimate_angle: 0.0,
                    bumper_height: 0.0,
                }
            }
        })
    }

    /// Shear of the web of each bar, without a bumper before the column.
    ///
    /// # Errors
    /// Why the web of this column does not yield in shear.
    pub fn shear(&self) -> Result<ShearProperties, NoShear> {
        if self.settings.shear.model == ShearModel::None {
            return Err(NoShear::SwitchedOff);
        }
        let given = self.settings.resistance.shear;
        let of_section = self.shear_of_section();
        let mut shear = match of_section {
            Some(shear) if given > 0.0 => ShearProperties {
                web_resistance: given,
                flange_moment: 0.0,
                ..shear
            },
            Some(shear) => shear,
            // A web of which only the resistance is known is rigid until it yields.
            None if given > 0.0 => ShearProperties {
                web_resistance: given,
                flange_moment: 0.0,
                rigidity: 0.0,
                hardening: 0.0,
                max_hardening: 0.0,
                ultimate_angle: 0.0,
                bumper_height: 0.0,
            },
            None => return Err(NoShear::WebNotKnown),
        };
        shear.max_hardening = self.settings.shear.max_hardening;
        let assessment = &self.settings.assessment;
        shear.ultimate_angle = match assessment.ultimate_rotation > 0.0 {
            true => assessment.ultimate_shear_angle,
            false => 0.0,
        };
        Ok(shear)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ParameterFaults, Parameters, Value};

    fn by_numbers(shape: &str, numbers: &[(&str, f64)]) -> Result<Parameters, ParameterFaults> {
        let by_numbers = [
            ("section.name", Value::from("")),
            ("section.shape", shape.into()),
            ("section.area", 65e-4.into()),
            ("section.second_moment", 3500e-8.into()),
            ("section.mass_per_length", 51.0.into()),
            ("resistance.moment", 1.5e5.into()),
            ("shear.model", "web".into()),
            ("softening.model", "none".into()),
        ];
        let numbers = numbers.iter().map(|(name, it)| (*name, Value::from(*it)));
        Parameters::default().with_changes(by_numbers.into_iter().chain(numbers))
    }

    fn resistance(shape: &str, numbers: &[(&str, f64)]) -> f64 {
        let column = by_numbers(shape, numbers).expect("consistent");
        column.shear().expect("its walls are known").web_resistance
    }

    #[test]
    fn walls_as_thick_as_half_the_width_are_rejected() {
        let walls = [
            ("section.height", 0.25),
            ("section.width", 0.016),
            ("section.web_thickness", 0.008),
        ];
        let faults = by_numbers("rectangular_hollow", &walls).expect_err("no room between walls");
        let words = faults.in_one_line();
        assert!(words.contains("as the section is wide"), "{words}");
    }

    /// `A_v` of EN 1993-1-1, 6.2.6: `A h / (b + h)` of a rectangular and `2 A / pi` of a circular hollow section.
    #[test]
    fn the_walls_of_hollow_sections_resist_shear_as_the_code_says() {
        let strength = 355e6 / 3.0_f64.sqrt();
        let (h, b, t) = (0.25, 0.15, 0.008);
        let walls = [
            ("section.height", h),
            ("section.width", b),
            ("section.web_thickness", t),
        ];
        let area = h * b - (h - 2.0 * t) * (b - 2.0 * t);
        let ratio = resistance("rectangular_hollow", &walls) / (strength * area * h / (b + h));
        assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
        let walls = [("section.height", 0.2191), ("section.web_thickness", 0.01)];
        let area = 0.25 * std::f64::consts::PI * (0.2191 * 0.2191 - 0.1991 * 0.1991);
        let expected = strength * 2.0 * area / std::f64::consts::PI;
        let ratio = resistance("circular_hollow", &walls) / expected;
        assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
    }
}

//! The shear of the web of a column, from its section and its parameters.

use super::Parameters;
use super::catalogue::CatalogueSection;
use super::section::or_of_name;
use super::settings::ShearModel;
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

    /// Shear of the web of each bar, without a bumper before the column.
    ///
    /// # Errors
    /// Why the web of this column does not yield in shear.
    pub fn shear(&self) -> Result<ShearProperties, NoShear> {
        if self.settings.shear.model == ShearModel::None {
            return Err(NoShear::SwitchedOff);
        }
        let (given, steel) = (self.settings.resistance.shear, self.steel());
        let of_section = self.shear_dimensions().map(|section| {
            section.shear(
                steel.yield_strength,
                steel.young_modulus,
                POISSON_RATIO,
                self.settings.hardening.ratio,
            )
        });
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

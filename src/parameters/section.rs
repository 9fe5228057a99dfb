//! The section of a column, from its name and from what is given.

use serde::Serialize;

use super::catalogue::CatalogueSection;
use super::settings::SectionSettings;
use crate::column::RolledSection;

/// The column's section: named, given by numbers, or named with some properties overridden.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ColumnSection {
    /// Name in the catalogue.
    pub name: Option<&'static str>,
    /// `A` \[m²\].
    pub area: f64,
    /// `I` \[m⁴\], about the axis of bending.
    pub second_moment: f64,
    /// `m_l` \[kg/m\].
    pub mass_per_length: f64,
    /// `h` \[m\] in the plane of bending; 0 if it is not known.
    pub height: f64,
    /// `W_pl` \[m³\] of a named section.
    pub plastic_modulus: Option<f64>,
}

/// The section as given, with the properties that its name gives.
pub(super) fn section_of(given: &SectionSettings) -> ColumnSection {
    let named = CatalogueSection::named(&given.name);
    let computed = named.map(CatalogueSection::properties);
    ColumnSection {
        name: named.map(|section| section.name.as_str()),
        area: or_of_name(given.area, computed.map(|it| it.area)),
        second_moment: or_of_name(given.second_moment, computed.map(|it| it.second_moment)),
        mass_per_length: or_of_name(given.mass_per_length, computed.map(|it| it.mass_per_length)),
        height: or_of_name(given.height, named.map(|it| it.dimensions.depth)),
        plastic_modulus: computed.map(|it| it.plastic_modulus),
    }
}

/// Dimensions of a named section whose properties are not overridden.
pub(super) fn dimensions_of(given: &SectionSettings) -> Option<RolledSection> {
    let as_named = given.area == 0.0 && given.second_moment == 0.0;
    CatalogueSection::named(&given.name)
        .filter(|_| as_named)
        .map(|section| section.dimensions)
}

/// The given number, or else that of the named section or grade.
pub(super) fn or_of_name(number: f64, of_name: Option<f64>) -> f64 {
    or_else(number, of_name.unwrap_or(0.0))
}

/// The given number, or else the one that takes the place of 0.
pub(super) fn or_else(number: f64, otherwise: f64) -> f64 {
    if number > 0.0 { number } else { otherwise }
}

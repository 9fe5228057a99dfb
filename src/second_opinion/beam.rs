//! The column of the parameters as a fibre beam.

use column_beam::{BeamColumn, BeamError, BowAxes, Shape, Steel, Torsion};
use thiserror::Error;

use crate::assessment::{dimensions_by_numbers, section_dimensions};
use crate::column::RolledSection;
use crate::parameters::{self, POISSON_RATIO, Parameters, TorsionModel};

/// Least hardening of the beam: with less, the length that yields depends on the mesh, and so does what is computed.
const LEAST_HARDENING: f64 = 1e-4;

/// Largest relative difference between the area of the plates and that of the section, which has fillets besides.
const AREA_TOLERANCE: f64 = 0.1;

/// Why there is no second opinion.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NoSecondOpinion {
    /// `beam.mode` is `off`.
    #[error("no second opinion: it is switched off (beam.mode: off)")]
    SwitchedOff,
    /// The section has no plates that fibres could fill.
    #[error(
        "no second opinion: the plates of the section are not known, which the fibres need; give section.name without overriding its \
         properties, or section.height, section.width, section.web_thickness and section.flange_thickness"
    )]
    NoPlates,
    /// The plates do not have the area of the section.
    #[error(
        "no second opinion: the plates of the section have {plates:e} m^2, but section.area is {section:e} m^2; expected a difference of \
         at most 10 %"
    )]
    Area {
        /// `2 b t_f + (h - 2 t_f) t_w` \[m²\].
        plates: f64,
        /// `A` \[m²\].
        section: f64,
    },
    /// The column does not stand after an earlier impact.
    #[error("no second opinion: by the fibre beam the column has collapsed already")]
    Collapsed,
    /// The beam does not take the column or the impact, or was not solved.
    #[error(transparent)]
    Beam(#[from] BeamError),
}

/// The column that these parameters describe, for the beam, before the bumper of its vehicle.
///
/// # Errors
/// A section without plates.
pub fn beam_column(parameters: &Parameters) -> Result<BeamColumn, NoSecondOpinion> {
    let (settings, properties) = (parameters.settings(), parameters.column_properties());
    let (section, steel) = (parameters.section(), parameters.steel());
    let given = &settings.beam;
    Ok(BeamColumn {
        shape: Shape::Rolled(plates(parameters)?),
        steel: Steel {
            young_modulus: steel.young_modulus,
            poisson_ratio: POISSON_RATIO,
            yield_strength: steel.yield_strength,
            hardening_ratio: properties.hardening_ratio.max(LEAST_HARDENING),
            density: section.mass_per_length / section.area,
        },
        length_below: properties.length_below,
        length_above: properties.length_above,
        base: properties.base,
        top: properties.top,
        top_spring_stiffness: properties.top_spring_stiffness,
        top_mass: properties.top_mass,
        top_load: properties.top_load,
        rate: properties.rate,
        shear: given.shear,
        torsion: match given.torsion {
            TorsionModel::Warping => Torsion::Warping,
            TorsionModel::SaintVenant => Torsion::SaintVenant,
            TorsionModel::None => Torsion::None,
        },
        torsion_constant: None,
        residual_stress: given.residual_stress,
        bow: given.bow,
        bow_axes: match given.bow_axes {
            parameters::BowAxes::Both => BowAxes::Both,
            parameters::BowAxes::Strong => BowAxes::Strong,
            parameters::BowAxes::Weak => BowAxes::Weak,
        },
        bumper_height: parameters.whole_impact().bumper_height,
        elements: usize::from(given.elements),
        fibres: usize::from(given.fibres),
        step_nanos: (given.dt * 1e9).round() as u64,
    })
}

fn plates(parameters: &Parameters) -> Result<RolledSection, NoSecondOpinion> {
    if let Some(dimensions) = section_dimensions(parameters) {
        return Ok(dimensions);
    }
    let given = &parameters.settings().section;
    if !given.name.is_empty() {
        return Err(NoSecondOpinion::NoPlates);
    }
    let plates = dimensions_by_numbers(
        given.height,
        given.width,
        given.web_thickness,
        given.flange_thickness,
    )
    .ok_or(NoSecondOpinion::NoPlates)?;
    let [of_plates, of_section] = [plates.properties().area, parameters.section().area];
    match (of_plates - of_section).abs() <= AREA_TOLERANCE * of_section {
        true => Ok(plates),
        false => Err(NoSecondOpinion::Area {
            plates: of_plates,
            section: of_section,
        }),
    }
}

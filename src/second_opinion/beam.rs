//! The column of the parameters as a fibre beam.

use std::f64::consts::PI;

use column_beam::{BeamColumn, BeamError, BowAxes, Shape, Steel, Torsion};
use thiserror::Error;

use crate::assessment::{dimensions_by_numbers, section_dimensions};
use crate::column::RolledSection;
use crate::parameters::{
    self, BeamSteel, POISSON_RATIO, Parameters, SectionShape, SteelGrade, TorsionModel,
};

/// Least hardening of the beam: with less, the length that yields depends on the mesh, and so does what is computed.
const LEAST_HARDENING: f64 = 1e-4;

/// Largest relative difference of a number from that of the plates of a named section: it may be rounded.
const OF_NAMED: f64 = 0.01;

/// Largest relative difference of a number from that of plates by numbers: the section has fillets besides.
const OF_PLATES: f64 = 0.1;

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
    /// The walls of a hollow section are not known, or they are not of one thickness.
    #[error(
        "no second opinion: the walls of the hollow section are not known, which the fibres need; give section.height, \
         section.web_thickness and, for section.shape: rectangular_hollow, section.width, with walls of one thickness: \
         section.flange_thickness omitted or equal to section.web_thickness"
    )]
    NoWalls,
    /// A steel without a grade has no tensile strength.
    #[error(
        "no second opinion: beam.steel: plateau needs the tensile strength of the steel, which user-defined steel does not have; give \
         steel.grade, or omit beam.steel"
    )]
    NoTensileStrength,
    /// The two bars have a number that the beam, which consists of the plates, does not have.
    #[error(
        "no second opinion: {name} is {given:.3e} {unit}, but the plates and the steel of the section, of which the fibre beam consists, \
         give {of_plates:.3e} {unit}; expected a difference of at most {:.0} %: correct the one that is wrong",
        100.0 * .tolerance
    )]
    Differs {
        /// Name of the parameter.
        name: &'static str,
        /// Its unit.
        unit: &'static str,
        /// As given.
        given: f64,
        /// By plates and steel.
        of_plates: f64,
        /// Largest relative difference.
        tolerance: f64,
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
    let tensile_strength = match given.steel {
        BeamSteel::Bilinear => None,
        BeamSteel::Plateau => {
            let grade = SteelGrade::named(&settings.steel.grade);
            let grade = grade.ok_or(NoSecondOpinion::NoTensileStrength)?;
            Some(grade.ultimate_strength)
        }
    };
    Ok(BeamColumn {
        shape: shape(parameters)?,
        steel: Steel {
            young_modulus: steel.young_modulus,
            poisson_ratio: POISSON_RATIO,
            yield_strength: steel.yield_strength,
            hardening_ratio: match given.steel {
                BeamSteel::Bilinear => properties.hardening_ratio.max(LEAST_HARDENING),
                BeamSteel::Plateau => LEAST_HARDENING,
            },
            density: section.mass_per_length / section.area,
            tensile_strength,
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
        max_shear_hardening: settings.shear.max_hardening,
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

/// A number of the two bars beside that of the plates, with its name and unit.
type Beside = (&'static str, &'static str, f64, f64, f64);

/// Area \[m²\], second moment \[m⁴\] and plastic modulus \[m³\] by the plates, and the resistance of what shears \[N\].
struct OfPlates {
    area: f64,
    second_moment: f64,
    plastic_modulus: f64,
    shear_resistance: f64,
}

/// The section of the fibres, where the two bars have no other numbers than its plates.
fn shape(parameters: &Parameters) -> Result<Shape, NoSecondOpinion> {
    match parameters.settings().section.shape {
        SectionShape::IOrH => plates(parameters).map(Shape::Rolled),
        SectionShape::RectangularHollow | SectionShape::CircularHollow => walls(parameters),
    }
}

/// A hollow section by numbers.
fn walls(parameters: &Parameters) -> Result<Shape, NoSecondOpinion> {
    let section = &parameters.settings().section;
    let (height, width, wall) = (section.height, section.width, section.web_thickness);
    let is_circular = section.shape == SectionShape::CircularHollow;
    let is_known = height > 0.0 && wall > 0.0 && (is_circular || width > 0.0);
    let other = section.flange_thickness;
    let is_uniform = other == 0.0 || (other - wall).abs() <= OF_NAMED * wall;
    let web = parameters.shear_of_section();
    let Some(web) = web.filter(|_| is_known && is_uniform) else {
        return Err(NoSecondOpinion::NoWalls);
    };
    let shear_resistance = web.web_resistance;
    let (inner, gap) = (height - 2.0 * wall, width - 2.0 * wall);
    let cubes = [height, inner].map(|it| it * it * it);
    let (shape, of_plates) = if is_circular {
        let shape = Shape::Circular {
            diameter: height,
            thickness: wall,
        };
        let of_plates = OfPlates {
            area: 0.25 * PI * (height * height - inner * inner),
            second_moment: PI / 64.0 * (cubes[0] * height - cubes[1] * inner),
            plastic_modulus: (cubes[0] - cubes[1]) / 6.0,
            shear_resistance,
        };
        (shape, of_plates)
    } else {
        let shape = Shape::Rectangular {
            depth: height,
            width,
            thickness: wall,
        };
        let of_plates = OfPlates {
            area: height * width - inner * gap,
            second_moment: (width * cubes[0] - gap * cubes[1]) / 12.0,
            plastic_modulus: 0.25 * (width * height * height - gap * inner * inner),
            shear_resistance,
        };
        (shape, of_plates)
    };
    compare(&beside(parameters, &of_plates, OF_PLATES))?;
    Ok(shape)
}

/// The plates of the section, where the two bars have no other numbers than these.
fn plates(parameters: &Parameters) -> Result<RolledSection, NoSecondOpinion> {
    let section = &parameters.settings().section;
    let (plates, tolerance) = match section_dimensions(parameters) {
        Some(named) => (named, OF_NAMED),
        None if section.name.is_empty() => {
            let by_numbers = dimensions_by_numbers(
                section.height,
                section.width,
                section.web_thickness,
                section.flange_thickness,
            );
            (by_numbers.ok_or(NoSecondOpinion::NoPlates)?, OF_PLATES)
        }
        None => return Err(NoSecondOpinion::NoPlates),
    };
    compare(&[
        (
            "section.height",
            "m",
            section.height,
            plates.depth,
            tolerance,
        ),
        ("section.width", "m", section.width, plates.width, tolerance),
        (
            "section.web_thickness",
            "m",
            section.web_thickness,
            plates.web_thickness,
            tolerance,
        ),
        (
            "section.flange_thickness",
            "m",
            section.flange_thickness,
            plates.flange_thickness,
            tolerance,
        ),
    ])?;
    let (properties, steel) = (plates.properties(), parameters.steel());
    let web = plates.shear(
        steel.yield_strength,
        steel.young_modulus,
        POISSON_RATIO,
        0.0,
    );
    let of_plates = OfPlates {
        area: properties.area,
        second_moment: properties.second_moment,
        plastic_modulus: properties.plastic_modulus,
        shear_resistance: web.web_resistance,
    };
    compare(&beside(parameters, &of_plates, tolerance))?;
    Ok(plates)
}

/// The properties of the section and its resistances, each beside that of the plates.
fn beside(parameters: &Parameters, of_plates: &OfPlates, tolerance: f64) -> [Beside; 5] {
    let settings = parameters.settings();
    let (section, resistance) = (&settings.section, &settings.resistance);
    let strength = parameters.steel().yield_strength;
    [
        (
            "section.area",
            "m^2",
            section.area,
            of_plates.area,
            tolerance,
        ),
        (
            "section.second_moment",
            "m^4",
            section.second_moment,
            of_plates.second_moment,
            tolerance,
        ),
        (
            "resistance.moment",
            "N m",
            resistance.moment,
            of_plates.plastic_modulus * strength,
            tolerance,
        ),
        (
            "resistance.axial",
            "N",
            resistance.axial,
            of_plates.area * strength,
            tolerance,
        ),
        // The flanges bear a few per cent besides, which depend on where the column is hit.
        (
            "resistance.shear",
            "N",
            resistance.shear,
            of_plates.shear_resistance,
            OF_PLATES,
        ),
    ]
}

/// Whether every given number is that of the plates; 0 stands for the number of the section.
fn compare(numbers: &[Beside]) -> Result<(), NoSecondOpinion> {
    for &(name, unit, given, of_plates, tolerance) in numbers {
        if given > 0.0 && (given - of_plates).abs() > tolerance * of_plates {
            return Err(NoSecondOpinion::Differs {
                name,
                unit,
                given,
                of_plates,
                tolerance,
            });
        }
    }
    Ok(())
}

//! The one table of parameters, from which declaration, validation and documentation follow.

use super::alarm_rows;
use super::assumed;
use super::base::{CONCRETE_WORDS, FRICTION, GRADE_WORDS};
use super::beam;
use super::criterion_names::{CRITERION_NAMES, DEFAULT_CRITERIA};
use super::hinge_rows;
use super::parameter::{Admissible, Applies, DefaultValue, Parameter};
use super::ranges::{
    CURVE_CRUSH, CURVE_FORCE, DIRECTORY, EXPONENT, FROM_SECTION, HINGE_STIFFNESS, IDENTIFIER,
    LENGTH, OPTIONAL_PATH, SELECTED_COLUMNS, SENSOR_NAMES, SITE, SUPPORT, SUPPORT_STIFFNESS,
    TOP_SUPPORT, UNLOADING_STIFFNESS,
};
use super::verdict_rows;
use crate::column::MAX_MASSES;

/// Largest dynamic increase factor that may be asked for, and the limit of a law that has none of its own.
pub(super) const MAX_RATE_FACTOR: f64 = 100.0;

/// Height of the impact point above the base where nothing gives it \[m\], as in the paper.
pub(super) const DEFAULT_LENGTH_BELOW: f64 = 1.0;

/// Meaning of 0 for the numbers of a base plate.
const NO_PLATE: &str = "not given";

/// Every parameter, in the order of the documentation.
pub const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "column_id",
        unit: "",
        default: DefaultValue::Text("column"),
        admissible: IDENTIFIER,
        applies: Applies::Restart,
        meaning: "name of the column in messages; impact events for another column are rejected, or in a fleet ignored",
    },
    Parameter {
        name: "frame_id",
        unit: "",
        default: DefaultValue::Text("column"),
        admissible: IDENTIFIER,
        applies: Applies::Restart,
        meaning: "coordinate frame of the column in messages, with its origin at the base",
    },
    Parameter {
        name: "publish_rate",
        unit: "Hz",
        default: DefaultValue::Double(1000.0),
        admissible: Admissible::Real {
            min: 1.0,
            max: 10_000.0,
        },
        applies: Applies::AfterResponse,
        meaning: "rate at which state and hinge forces are published during a response; at most once per step, with the period rounded to whole steps",
    },
    Parameter {
        name: "use_sim_time",
        unit: "",
        default: DefaultValue::Bool(false),
        admissible: Admissible::Switch,
        applies: Applies::Restart,
        meaning: "take the time from the topic /clock, as every ROS 2 node does",
    },
    Parameter {
        name: "start_type_description_service",
        unit: "",
        default: DefaultValue::Bool(true),
        admissible: Admissible::Switch,
        applies: Applies::Restart,
        meaning: "offer the service ~/get_type_description, as every ROS 2 node does",
    },
    Parameter {
        name: "site.x",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: SITE,
        applies: Applies::Restart,
        meaning: "position of the column in the plan of its fleet, to the right; columns of a fleet that share a position with another \
                  one, or give none, are shown in rows below the plan",
    },
    Parameter {
        name: "site.y",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: SITE,
        applies: Applies::Restart,
        meaning: "position of the column in the plan of its fleet, upwards in the picture; see `site.x`",
    },
    Parameter {
        name: "geometry.height",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 0.04,
            max: 200.0,
            zero: "the sum of both lengths",
        },
        applies: Applies::AfterResponse,
        meaning: "height of the column. With it, the impact point is where the vehicle strikes (`column-twin vehicles` lists the \
                  heights: cars 0.5 m, forklift trucks 0.75 m, lorries 1.25 m), unless `geometry.length_below` or the impact gives a \
                  height, and `geometry.length_above` is the rest. Both lengths replace it where they are given later: in a later \
                  file or section, on the command line, or by a change of both together",
    },
    Parameter {
        name: "geometry.length_below",
        unit: "m",
        default: DefaultValue::Double(DEFAULT_LENGTH_BELOW),
        admissible: LENGTH,
        applies: Applies::AfterResponse,
        meaning: "L_a: height of the impact point above the base",
    },
    Parameter {
        name: "geometry.length_above",
        unit: "m",
        default: DefaultValue::Double(3.0),
        admissible: LENGTH,
        applies: Applies::AfterResponse,
        meaning: "L_b: distance from the impact point to the top",
    },
    Parameter {
        name: "section.name",
        unit: "",
        default: DefaultValue::Text("HEB220"),
        admissible: Admissible::SectionName,
        applies: Applies::AfterResponse,
        meaning: "rolled section, bent about its strong axis; empty: the section is user-defined. If files and overrides \
                  give one of the numbers but no name, the name is empty",
    },
    Parameter {
        name: "section.area",
        unit: "m^2",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e-5,
            max: 1.0,
            zero: FROM_SECTION,
        },
        applies: Applies::AfterResponse,
        meaning: "A: cross-sectional area; overrides the area of a named section",
    },
    Parameter {
        name: "section.second_moment",
        unit: "m^4",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e-10,
            max: 1.0,
            zero: FROM_SECTION,
        },
        applies: Applies::AfterResponse,
        meaning: "I: second moment of area; overrides the value of a named section",
    },
    Parameter {
        name: "section.mass_per_length",
        unit: "kg/m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 0.01,
            max: 1e5,
            zero: FROM_SECTION,
        },
        applies: Applies::AfterResponse,
        meaning: "m_l: mass per length; overrides the value of a named section",
    },
    Parameter {
        name: "section.height",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 0.01,
            max: 10.0,
            zero: FROM_SECTION,
        },
        applies: Applies::AfterResponse,
        meaning: "h: height in the plane of bending, for strain rates; overrides the value of a named section",
    },
    Parameter {
        name: "section.width",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 0.01,
            max: 10.0,
            zero: FROM_SECTION,
        },
        applies: Applies::AfterResponse,
        meaning: "b: width of the flanges, for the shear of the web; overrides the value of a named section",
    },
    Parameter {
        name: "section.web_thickness",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e-4,
            max: 1.0,
            zero: FROM_SECTION,
        },
        applies: Applies::AfterResponse,
        meaning: "t_w: thickness of the web, for its shear; overrides the value of a named section. A user-defined section yields in shear if it has this and `section.height`",
    },
    Parameter {
        name: "section.flange_thickness",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e-4,
            max: 1.0,
            zero: FROM_SECTION,
        },
        applies: Applies::AfterResponse,
        meaning: "t_f: thickness of the flanges, for the shear of the web; overrides the value of a named section",
    },
    Parameter {
        name: "section.shape",
        unit: "",
        default: DefaultValue::Text("i_or_h"),
        admissible: Admissible::Choice(&["i_or_h", "rectangular_hollow", "circular_hollow"]),
        applies: Applies::AfterResponse,
        meaning: "shape of a user-defined section. rectangular_hollow: `section.height` and `section.width` over walls of the thickness \
                  `section.web_thickness`; circular_hollow: the diameter is `section.height`, the thickness of the wall \
                  `section.web_thickness`",
    },
    Parameter {
        name: "steel.grade",
        unit: "",
        default: DefaultValue::Text("S355"),
        admissible: Admissible::SteelGrade,
        applies: Applies::AfterResponse,
        meaning: "steel grade, nominal values for thicknesses up to 40 mm (EN 1993-1-1, table 3.1); empty: the steel is user-defined. If files and overrides give one of the numbers but no grade, the grade is empty",
    },
    Parameter {
        name: "steel.young_modulus",
        unit: "Pa",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e9,
            max: 1e12,
            zero: "from `steel.grade`",
        },
        applies: Applies::AfterResponse,
        meaning: "E: Young's modulus; overrides the value of a named grade",
    },
    Parameter {
        name: "steel.yield_strength",
        unit: "Pa",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e6,
            max: 1e10,
            zero: "from `steel.grade`",
        },
        applies: Applies::AfterResponse,
        meaning: "f_y: yield strength; overrides the value of a named grade",
    },
    Parameter {
        name: "resistance.moment",
        unit: "N m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1.0,
            max: 1e10,
            zero: "W_pl f_y, which needs `section.name`",
        },
        applies: Applies::AfterResponse,
        meaning: "M^p: plastic moment resistance without normal force",
    },
    Parameter {
        name: "resistance.axial",
        unit: "N",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 100.0,
            max: 1e11,
            zero: "A f_y",
        },
        applies: Applies::AfterResponse,
        meaning: "N^p: plastic axial resistance (squash load)",
    },
    Parameter {
        name: "resistance.shear",
        unit: "N",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1.0,
            max: 1e11,
            zero: "from the web and the flanges of the section",
        },
        applies: Applies::AfterResponse,
        meaning: "V_s: plastic resistance of a bar against shear, all of it",
    },
    Parameter {
        name: "yield_surface.alpha",
        unit: "",
        default: DefaultValue::Double(1.0),
        admissible: EXPONENT,
        applies: Applies::AfterResponse,
        meaning: "alpha: exponent of the moment (Eq 28); 1 with beta = 1.3 is Duan-Chen, 2 with beta = 2 an ellipse",
    },
    Parameter {
        name: "yield_surface.beta",
        unit: "",
        default: DefaultValue::Double(1.3),
        admissible: EXPONENT,
        applies: Applies::AfterResponse,
        meaning: "beta: exponent of the normal force (Eq 28)",
    },
    Parameter {
        name: "yield_surface.gamma",
        unit: "",
        default: DefaultValue::Double(1.0),
        admissible: Admissible::Real {
            min: 0.01,
            max: 100.0,
        },
        applies: Applies::AfterResponse,
        meaning: "gamma: the whole sum is raised to 1/gamma (Eq 28), which scales the plastic multiplier but not the surface",
    },
    Parameter {
        name: "hinge.elastic_law",
        unit: "",
        default: DefaultValue::Text("coupled"),
        admissible: Admissible::Choice(&["uncoupled", "coupled"]),
        applies: Applies::AfterResponse,
        meaning: "uncoupled: the paper's independent springs (Eqs 47-48); coupled: the elastic beam, exact for any end rotations",
    },
    Parameter {
        name: "hinge.stiffness_1a",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: HINGE_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of hinge 1a, below the impact point; only with the uncoupled law",
    },
    Parameter {
        name: "hinge.stiffness_1b",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: HINGE_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of hinge 1b, above the impact point; only with the uncoupled law",
    },
    Parameter {
        name: "hinge.stiffness_2",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: HINGE_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of hinge 2, at the top; only with the uncoupled law and a built-in top",
    },
    Parameter {
        name: "hinge.stiffness_3",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: HINGE_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of hinge 3, at the base; only with the uncoupled law and a built-in base",
    },
    Parameter {
        name: "support.base",
        unit: "",
        default: DefaultValue::Text("built_in"),
        admissible: SUPPORT,
        applies: Applies::AfterResponse,
        meaning: "rotational support of the base",
    },
    Parameter {
        name: "support.base_stiffness",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: SUPPORT_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of a semi-rigid base",
    },
    Parameter {
        name: "support.top",
        unit: "",
        default: DefaultValue::Text("built_in"),
        admissible: TOP_SUPPORT,
        applies: Applies::AfterResponse,
        meaning: "support of the top: rotational, or free for a cantilever such as a bollard, which then needs `top.load: 0` and \
                  `top.spring_stiffness: 0`",
    },
    Parameter {
        name: "support.top_stiffness",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: SUPPORT_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of a semi-rigid top",
    },
    Parameter {
        name: "base.connection",
        unit: "",
        default: DefaultValue::Text("none"),
        admissible: Admissible::Choice(&["none", "plate"]),
        applies: Applies::AfterResponse,
        meaning: "how the base is connected; none: nothing is known of it, and the assessment assumes a plate for a named section that is built in; plate: a plate with anchors, which needs the other parameters of this group and `section.name`. Its moment and its shear limit the base in the response, in which the foot may slip and the anchors fracture, and its initial stiffness replaces a base that is built in",
    },
    Parameter {
        name: "base.plate_thickness",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 0.004,
            max: 0.5,
            zero: NO_PLATE,
        },
        applies: Applies::AfterResponse,
        meaning: "t_p: thickness of the base plate",
    },
    Parameter {
        name: "base.plate_length",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 0.02,
            max: 10.0,
            zero: NO_PLATE,
        },
        applies: Applies::AfterResponse,
        meaning: "length of the base plate in the plane of bending, parallel to the web",
    },
    Parameter {
        name: "base.plate_width",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 0.02,
            max: 10.0,
            zero: NO_PLATE,
        },
        applies: Applies::AfterResponse,
        meaning: "width of the base plate, parallel to the flanges",
    },
    Parameter {
        name: "base.anchor_count",
        unit: "",
        default: DefaultValue::Integer(0),
        admissible: Admissible::Integer { min: 0, max: 64 },
        applies: Applies::AfterResponse,
        meaning: "number of anchors in two lines parallel to the flanges, half of them in each; even; 0 without a plate",
    },
    Parameter {
        name: "base.anchor_diameter",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 0.012,
            max: 0.056,
            zero: NO_PLATE,
        },
        applies: Applies::AfterResponse,
        meaning: "nominal diameter of the anchors, a thread of the coarse series such as 0.024",
    },
    Parameter {
        name: "base.anchor_grade",
        unit: "",
        default: DefaultValue::Text("none"),
        admissible: Admissible::Choice(GRADE_WORDS),
        applies: Applies::AfterResponse,
        meaning: "property class of the anchors, in quotes; stronger ones than 8.8 may not bear shear (EN 1993-1-8, 6.2.2); none without a plate",
    },
    Parameter {
        name: "base.anchor_distance",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 0.001,
            max: 5.0,
            zero: NO_PLATE,
        },
        applies: Applies::AfterResponse,
        meaning: "z_T: distance of each line of anchors from the axis of the section",
    },
    Parameter {
        name: "base.concrete",
        unit: "",
        default: DefaultValue::Text("none"),
        admissible: Admissible::Choice(CONCRETE_WORDS),
        applies: Applies::AfterResponse,
        meaning: "strength class of the concrete under the plate; none without a plate",
    },
    Parameter {
        name: "base.friction",
        unit: "",
        default: DefaultValue::Double(FRICTION),
        admissible: Admissible::Real { min: 0.0, max: 1.0 },
        applies: Applies::AfterResponse,
        meaning: "C_f: coefficient of friction between plate and grout; 0.2 for sand and cement (EN 1993-1-8, 6.2.2)",
    },
    Parameter {
        name: "top.spring_stiffness",
        unit: "N/m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::Real {
            min: 0.0,
            max: 1e13,
        },
        applies: Applies::AfterResponse,
        meaning: "k_s: stiffness of the vertical spring at the top, which represents the rest of the structure and takes load off a \
                  column that shortens. Unless given, 0 for a section by name, 1e7 (the paper's example) for a user-defined one",
    },
    Parameter {
        name: "top.mass",
        unit: "kg",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::Real { min: 0.0, max: 1e7 },
        applies: Applies::AfterResponse,
        meaning: "m_2: lumped mass at the top",
    },
    Parameter {
        name: "top.load",
        unit: "N",
        default: DefaultValue::Double(5e5),
        admissible: Admissible::Real { min: 0.0, max: 1e9 },
        applies: Applies::AfterResponse,
        meaning: "P: constant vertical load at the top, positive in compression",
    },
    verdict_rows::REDISTRIBUTION_LIMIT,
    verdict_rows::REDISTRIBUTION_PROOF,
    verdict_rows::LOAD_BASIS,
    Parameter {
        name: "impact.mass",
        unit: "kg",
        default: DefaultValue::Double(1500.0),
        admissible: Admissible::RealOrOpen {
            min: 1e-3,
            max: 1e6,
            open: "the vehicle's own mass; not for a rigid one",
        },
        applies: Applies::AtOnce,
        meaning: "m_c: total mass of the vehicle; all masses of a deformable one, and the springs between them, scale with it. If it is not \
                  given and vehicle.name names a deformable vehicle, it is 0",
    },
    Parameter {
        name: "impact.velocity",
        unit: "m/s",
        default: DefaultValue::Double(10.0),
        admissible: Admissible::Real {
            min: 1e-6,
            max: 60.0,
        },
        applies: Applies::AtOnce,
        meaning: "v_c: ground speed of the vehicle, positive towards the column",
    },
    Parameter {
        name: "impact.gap",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::Real {
            min: 0.0,
            max: 100.0,
        },
        applies: Applies::AtOnce,
        meaning: "g_N: initial gap between vehicle and column",
    },
    Parameter {
        name: "impact.restitution",
        unit: "",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::Real { min: 0.0, max: 1.0 },
        applies: Applies::AtOnce,
        meaning: "epsilon: coefficient of restitution of Newton's impact law; 0 is perfectly inelastic, 1 perfectly elastic",
    },
    Parameter {
        name: "impact.transverse_force",
        unit: "N",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::Real { min: 0.0, max: 1e7 },
        applies: Applies::AtOnce,
        meaning: "F: constant force on every vehicle in its direction of travel, before, during and after contact, shared by its \
                  masses in proportion; at most 100 m/s^2 times its mass. The weight m g of a mass that falls on a horizontal \
                  member",
    },
    beam::DIRECTION,
    Parameter {
        name: "vehicle.name",
        unit: "",
        default: DefaultValue::Text("rigid"),
        admissible: Admissible::VehicleName,
        applies: Applies::AtOnce,
        meaning: "vehicle of impacts that name none: the paper's rigid mass, or one of the catalogue; empty: the vehicle is user-defined. If files and overrides give one of the numbers but no name, the name is empty",
    },
    Parameter {
        name: "vehicle.masses",
        unit: "kg",
        default: DefaultValue::Numbers(&[]),
        admissible: Admissible::List {
            of: &Admissible::Real {
                min: 1e-3,
                max: 1e6,
            },
            min_len: 0,
            max_len: MAX_MASSES,
        },
        applies: Applies::AtOnce,
        meaning: "masses of a user-defined vehicle, front first, each with a spring in front of it; impact.mass scales \
                  them, and the springs between them",
    },
    Parameter {
        name: "vehicle.slack",
        unit: "m",
        default: DefaultValue::Numbers(&[]),
        admissible: Admissible::List {
            of: &Admissible::Real {
                min: 0.0,
                max: 10.0,
            },
            min_len: 0,
            max_len: MAX_MASSES - 1,
        },
        applies: Applies::AtOnce,
        meaning: "distance that closes before a spring acts, one for each spring from the second on; empty: 0",
    },
    Parameter {
        name: "vehicle.spring_1.crush",
        unit: "m",
        default: DefaultValue::Numbers(&[]),
        admissible: CURVE_CRUSH,
        applies: Applies::AtOnce,
        meaning: "spring 1, in front of mass 1: crush of the points of its force-crush curve after (0, 0), increasing",
    },
    Parameter {
        name: "vehicle.spring_1.force",
        unit: "N",
        default: DefaultValue::Numbers(&[]),
        admissible: CURVE_FORCE,
        applies: Applies::AtOnce,
        meaning: "spring 1: force at each of these points; the last slope continues behind the last point",
    },
    Parameter {
        name: "vehicle.spring_1.unloading_stiffness",
        unit: "N/m",
        default: DefaultValue::Double(0.0),
        admissible: UNLOADING_STIFFNESS,
        applies: Applies::AtOnce,
        meaning: "spring 1: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is elastic",
    },
    Parameter {
        name: "vehicle.spring_2.crush",
        unit: "m",
        default: DefaultValue::Numbers(&[]),
        admissible: CURVE_CRUSH,
        applies: Applies::AtOnce,
        meaning: "spring 2, in front of mass 2: crush of the points of its force-crush curve after (0, 0), increasing",
    },
    Parameter {
        name: "vehicle.spring_2.force",
        unit: "N",
        default: DefaultValue::Numbers(&[]),
        admissible: CURVE_FORCE,
        applies: Applies::AtOnce,
        meaning: "spring 2: force at each of these points; the last slope continues behind the last point",
    },
    Parameter {
        name: "vehicle.spring_2.unloading_stiffness",
        unit: "N/m",
        default: DefaultValue::Double(0.0),
        admissible: UNLOADING_STIFFNESS,
        applies: Applies::AtOnce,
        meaning: "spring 2: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is elastic",
    },
    Parameter {
        name: "vehicle.spring_3.crush",
        unit: "m",
        default: DefaultValue::Numbers(&[]),
        admissible: CURVE_CRUSH,
        applies: Applies::AtOnce,
        meaning: "spring 3, in front of mass 3: crush of the points of its force-crush curve after (0, 0), increasing",
    },
    Parameter {
        name: "vehicle.spring_3.force",
        unit: "N",
        default: DefaultValue::Numbers(&[]),
        admissible: CURVE_FORCE,
        applies: Applies::AtOnce,
        meaning: "spring 3: force at each of these points; the last slope continues behind the last point",
    },
    Parameter {
        name: "vehicle.spring_3.unloading_stiffness",
        unit: "N/m",
        default: DefaultValue::Double(0.0),
        admissible: UNLOADING_STIFFNESS,
        applies: Applies::AtOnce,
        meaning: "spring 3: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is elastic",
    },
    Parameter {
        name: "vehicle.narrow_object",
        unit: "",
        default: DefaultValue::Bool(false),
        admissible: Admissible::Switch,
        applies: Applies::AtOnce,
        meaning: "whether the column meets half of the front's force up to a crush of 0.40 m, rising to all of it at 0.55 m, where it \
                  has reached the engine. If it is not given, it follows vehicle.name: true for cars of the catalogue, false for \
                  all others and for a user-defined vehicle. Another vehicle that an event names keeps its own default",
    },
    Parameter {
        name: "vehicle.force_factor",
        unit: "",
        default: DefaultValue::Double(1.0),
        admissible: Admissible::Real {
            min: 0.01,
            max: 100.0,
        },
        applies: Applies::AtOnce,
        meaning: "factor of the forces and of the unloading stiffness of every deformable vehicle's front, for its scatter: lognormal, coefficient of \
                  variation 20 % for cars (JCSS 2.18), 40 % for lorries (assumed)",
    },
    Parameter {
        name: "vehicle.bumper_height",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::Real {
            min: 0.0,
            max: 10.0,
        },
        applies: Applies::AtOnce,
        meaning: "height of the bumper, over which the vehicle holds the column straight; without effect where the web does not yield in shear. If it is not given, a vehicle of the catalogue has its own, and a rigid or user-defined one has 0, a force at a point",
    },
    Parameter {
        name: "event.max_age",
        unit: "s",
        default: DefaultValue::Double(5.0),
        admissible: Admissible::Real {
            min: 1e-3,
            max: 3600.0,
        },
        applies: Applies::AtOnce,
        meaning: "maximum age of the stamp of an impact event; an older event is rejected, and the response to a younger one catches up",
    },
    Parameter {
        name: "event.max_ahead",
        unit: "s",
        default: DefaultValue::Double(1.0),
        admissible: Admissible::Real {
            min: 0.0,
            max: 60.0,
        },
        applies: Applies::AtOnce,
        meaning: "how far the stamp of an impact event may lie in the future; an event further ahead is rejected",
    },
    Parameter {
        name: "senders.allowed",
        unit: "",
        default: DefaultValue::Texts(&[]),
        admissible: Admissible::List {
            of: &Admissible::Sender,
            min_len: 0,
            max_len: 64,
        },
        applies: Applies::Restart,
        meaning: "who may send impact events, parameters, measurements and requests to reset, to confirm an estimate and to correct the damage; empty: everybody. An enclave is known only with DDS security; \
                  without it a GUID can be forged",
    },
    Parameter {
        name: "senders.max_rate",
        unit: "1/s",
        // A rejected event takes 3.7 kB of a recording: 0.67 GB per hour at this rate, less than `record.max_file_size` per
        // `record.max_duration`. One sender therefore does not shorten the time that the recordings cover.
        default: DefaultValue::Double(50.0),
        admissible: Admissible::RealOrZero {
            min: 1e-3,
            max: 1e6,
            zero: "no limit",
        },
        applies: Applies::Restart,
        meaning: "impact events, sets of parameters and requests per second that the node takes from each sender, and from all new ones together; \
                  with the default, one sender that sends without end does not shorten the time that the recordings cover",
    },
    Parameter {
        name: "senders.burst",
        unit: "",
        // As many as a fleet has columns.
        default: DefaultValue::Integer(2000),
        admissible: Admissible::Integer {
            min: 1,
            max: 10_000,
        },
        applies: Applies::Restart,
        meaning: "number of messages that a sender may send in a burst under senders.max_rate",
    },
    Parameter {
        name: "estimation.accept",
        unit: "",
        default: DefaultValue::Text("confirmation"),
        admissible: Admissible::Choice(&["never", "confirmation", "automatic"]),
        applies: Applies::AtOnce,
        meaning: "when an impact that the sensors have detected becomes an impact of the twin. never: it is only published; confirmation: \
                  when ~/confirm_estimate accepts it; automatic: as soon as its estimate is reliable enough, at the latest with the final one",
    },
    Parameter {
        name: "estimation.momentum_width",
        unit: "",
        default: DefaultValue::Double(0.3),
        admissible: Admissible::Real {
            min: 0.01,
            max: 10.0,
        },
        applies: Applies::AtOnce,
        meaning: "largest width of the 90 % interval of the momentum, relative to its mean, of an estimate that is reliable enough",
    },
    Parameter {
        name: "estimation.yield_certainty",
        unit: "",
        default: DefaultValue::Double(0.9),
        admissible: Admissible::Real { min: 0.5, max: 1.0 },
        applies: Applies::AtOnce,
        meaning: "least probability of yielding, or of no yielding, of an estimate that is reliable enough",
    },
    Parameter {
        name: "estimation.merge_window",
        unit: "s",
        default: DefaultValue::Double(0.5),
        admissible: Admissible::Real {
            min: 0.0,
            max: 60.0,
        },
        applies: Applies::AtOnce,
        meaning: "largest difference of the instants of contact of an impact event and an estimate that are the same impact",
    },
    Parameter {
        name: "estimation.event_mass_deviation",
        unit: "",
        default: DefaultValue::Double(0.3),
        admissible: Admissible::Real {
            min: 0.01,
            max: 10.0,
        },
        applies: Applies::AtOnce,
        meaning: "relative standard deviation of the mass in an impact event that is the same impact as an estimate, by which the event \
                  counts for later estimates. 0.3: the masses of the vehicles of one kind differ by as much, because a camera or a person sees the kind and not the load [A]",
    },
    Parameter {
        name: "estimation.event_velocity_deviation",
        unit: "",
        default: DefaultValue::Double(0.15),
        admissible: Admissible::Real {
            min: 0.01,
            max: 10.0,
        },
        applies: Applies::AtOnce,
        meaning: "the same for the speed in such an event. 0.15: braking between the place where a camera measures the speed and the \
                  column is not seen [A]",
    },
    Parameter {
        name: "rate.law",
        unit: "",
        default: DefaultValue::Text("none"),
        admissible: Admissible::Choice(&["none", "cowper_symonds", "logarithmic"]),
        applies: Applies::AfterResponse,
        meaning: "increase of the yield surface with the filtered strain rate e of each hinge. none: the paper; cowper_symonds: \
                  1 + (e/d)^(1/q); logarithmic: 1 + c ln(e/reference), not below 1, with its defaults the form of the CEB, \
                  f_y + 6 MPa ln(e / 5e-5) (recalled, not verified)",
    },
    Parameter {
        name: "rate.d",
        unit: "1/s",
        default: DefaultValue::Double(40.4),
        admissible: Admissible::Real {
            min: 1e-6,
            max: 1e9,
        },
        applies: Applies::AfterResponse,
        meaning: "strain rate at which the law of Cowper and Symonds doubles the strength; 40.4 with q = 5 is for mild steel (recalled, not \
                  verified) and overstates the increase for higher grades",
    },
    Parameter {
        name: "rate.q",
        unit: "",
        default: DefaultValue::Double(5.0),
        admissible: Admissible::Real {
            min: 1.0,
            max: 100.0,
        },
        applies: Applies::AfterResponse,
        meaning: "exponent of the law of Cowper and Symonds",
    },
    Parameter {
        name: "rate.c",
        unit: "",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e-6,
            max: 1.0,
            zero: "6 MPa / f_y",
        },
        applies: Applies::AfterResponse,
        meaning: "factor of the logarithmic law",
    },
    Parameter {
        name: "rate.reference",
        unit: "1/s",
        default: DefaultValue::Double(5e-5),
        admissible: Admissible::Real {
            min: 1e-9,
            max: 1e3,
        },
        applies: Applies::AfterResponse,
        meaning: "strain rate below which the logarithmic law increases nothing",
    },
    Parameter {
        name: "rate.time_constant",
        unit: "s",
        default: DefaultValue::Double(1e-3),
        admissible: Admissible::Real {
            min: 1e-5,
            max: 1.0,
        },
        applies: Applies::AfterResponse,
        meaning: "time constant of the low-pass filter of the strain rate, without which the law is ill-posed",
    },
    Parameter {
        name: "rate.max_factor",
        unit: "",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1.0,
            max: MAX_RATE_FACTOR,
            zero: "logarithmic: 1.35 for S235, 1.25 for S355, 1.15 for S460 (assumed), linear in f_y between them and constant beyond; \
                   cowper_symonds: no limit below 100",
        },
        applies: Applies::AfterResponse,
        meaning: "largest dynamic increase factor",
    },
    Parameter {
        name: "rate.hinge_length",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e-3,
            max: 100.0,
            zero: "the section height",
        },
        applies: Applies::AfterResponse,
        meaning: "length over which the rotation of a plastic hinge is spread, for its strain rate",
    },
    Parameter {
        name: "shear.model",
        unit: "",
        default: DefaultValue::Text("web"),
        admissible: Admissible::Choice(&["none", "web"]),
        applies: Applies::AfterResponse,
        meaning: "web: the web of each bar yields in shear and deforms elastically, where its dimensions or `resistance.shear` are known; none: as in the paper, it does neither",
    },
    Parameter {
        name: "shear.max_hardening",
        unit: "",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1.0,
            max: 100.0,
            zero: "no limit",
        },
        applies: Applies::AfterResponse,
        meaning: "largest strength of a web that hardens over its initial one. If it is not given, it is f_u/f_y of `steel.grade`, or 1.1, the least of EN 1993-1-1, for user-defined steel",
    },
    hinge_rows::HARDENING_RATIO,
    hinge_rows::SOFTENING_MODEL,
    hinge_rows::SOFTENING_CAPPING_ROTATION,
    hinge_rows::SOFTENING_POST_CAPPING_ROTATION,
    hinge_rows::SOFTENING_RESIDUAL,
    Parameter {
        name: "solver.scheme",
        unit: "",
        default: DefaultValue::Text("conserving_midpoint"),
        admissible: Admissible::Choice(&["midpoint", "conserving_midpoint"]),
        applies: Applies::AfterResponse,
        meaning: "midpoint: the paper's midpoint rule as printed; conserving_midpoint: the midpoint rule that conserves energy",
    },
    Parameter {
        name: "solver.dt",
        unit: "s",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::WholeNanoseconds {
            min: 1e-7,
            max: 1e-3,
            zero: "chosen from the column's own period",
        },
        applies: Applies::AfterResponse,
        meaning: "time step; a chosen one is 1e-6 to 2e-5 s and keeps the error of the peak displacement below 2e-4 for 99 of 100 columns, with the largest seen at 2e-3",
    },
    Parameter {
        name: "damping.ratio",
        unit: "",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::Real { min: 0.0, max: 1.0 },
        applies: Applies::AfterResponse,
        meaning: "damping ratio of the elastic modes, relative to critical damping; the paper has no damping",
    },
    Parameter {
        name: "response.duration",
        unit: "s",
        default: DefaultValue::Double(2.0),
        admissible: Admissible::Real {
            min: 1e-3,
            max: 600.0,
        },
        applies: Applies::AfterResponse,
        meaning: "maximum duration of a computed response from the end of the approach, and of the approach; a response ends earlier if \
                  the column comes to rest",
    },
    Parameter {
        name: "capacity.imperfection",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e-6,
            max: 1.0,
            zero: "by the buckling curve of the section (EN 1993-1-1, table 5.1)",
        },
        applies: Applies::AtOnce,
        meaning: "e0: bow of the column for its axial capacity, at most a tenth of its height",
    },
    verdict_rows::BUCKLING_FACTOR_STRONG,
    verdict_rows::BUCKLING_FACTOR_WEAK,
    Parameter {
        name: "assessment.ultimate_rotation",
        unit: "rad",
        default: DefaultValue::Double(0.15),
        admissible: Admissible::RealOrZero {
            min: 1e-3,
            max: 3.0,
            zero: "no limit",
        },
        applies: Applies::AfterResponse,
        meaning: "theta_u: plastic rotation at which a hinge is fractured, of hinges 1a and 1b together: the response ends there, and the column \
                  is fractured (Lignos 2019)",
    },
    Parameter {
        name: "assessment.ultimate_shear_angle",
        unit: "rad",
        default: DefaultValue::Double(0.17),
        admissible: Admissible::RealOrZero {
            min: 1e-3,
            max: 3.0,
            zero: "no limit",
        },
        applies: Applies::AfterResponse,
        meaning: "plastic shear angle at which the web of a bar is fractured: the response ends there, and the column is fractured (ASCE/SEI 41-17, links that yield in shear; recalled). `assessment.ultimate_rotation: 0` lifts this limit, too",
    },
    Parameter {
        name: "assessment.criteria",
        unit: "",
        default: DefaultValue::Texts(DEFAULT_CRITERIA),
        admissible: Admissible::List {
            of: &Admissible::Choice(CRITERION_NAMES),
            min_len: 1,
            max_len: CRITERION_NAMES.len(),
        },
        applies: Applies::AtOnce,
        meaning: "criteria that decide the action; all others are shown only. `collapse` always decides",
    },
    assumed::ASSUMED,
    Parameter {
        name: "assessment.range_velocity",
        unit: "",
        default: DefaultValue::Double(0.1),
        admissible: Admissible::Real { min: 0.0, max: 0.9 },
        applies: Applies::AtOnce,
        meaning: "relative range of the speed of the vehicle, to both sides, within which the action of a verdict is sought. 0.1: a speed that is read from skid marks or a camera [A]",
    },
    Parameter {
        name: "assessment.range_height",
        unit: "m",
        default: DefaultValue::Double(0.2),
        admissible: Admissible::Real {
            min: 0.0,
            max: 10.0,
        },
        applies: Applies::AtOnce,
        meaning: "the same for the height of the impact point. 0.2: bumpers of one kind of vehicle differ by as much, and brakes dip them [A]",
    },
    Parameter {
        name: "assessment.range_front",
        unit: "",
        default: DefaultValue::Double(0.2),
        admissible: Admissible::Real { min: 0.0, max: 0.9 },
        applies: Applies::AtOnce,
        meaning: "relative range of the force of the vehicle's front, to both sides, for the same. 0.2: the standard deviation of `vehicle.force_factor`",
    },
    beam::MODE,
    beam::ELEMENTS,
    beam::FIBRES,
    beam::DT,
    beam::SHEAR,
    beam::TORSION,
    beam::RESIDUAL_STRESS,
    beam::BOW,
    beam::BOW_AXES,
    beam::STEEL,
    Parameter {
        name: "state.directory",
        unit: "",
        default: DefaultValue::Text("$XDG_STATE_HOME/column_twin/state"),
        admissible: OPTIONAL_PATH,
        applies: Applies::Restart,
        meaning: "directory of the state file, which is named after the column and preserves the damage across restarts; \
                  `$XDG_STATE_HOME` is `~/.local/state` unless the environment sets it; empty: the damage is lost when the program ends",
    },
    Parameter {
        name: "real_time.priority",
        unit: "",
        default: DefaultValue::Integer(50),
        admissible: Admissible::Integer { min: 0, max: 99 },
        applies: Applies::Restart,
        meaning: "SCHED_FIFO priority of the solver thread, if the system permits it, with the publishing thread one below; \
                  0: normal scheduling",
    },
    Parameter {
        name: "real_time.processors",
        unit: "",
        default: DefaultValue::Text(""),
        admissible: Admissible::Processors,
        applies: Applies::Restart,
        meaning: "processors that the solver thread may run on; empty: all",
    },
    Parameter {
        name: "real_time.lock_memory",
        unit: "",
        default: DefaultValue::Bool(true),
        admissible: Admissible::Switch,
        applies: Applies::Restart,
        meaning: "lock the program's memory so that it is never swapped out, if the system permits it",
    },
    Parameter {
        name: "real_time.threads",
        unit: "",
        default: DefaultValue::Integer(0),
        admissible: Admissible::Integer { min: 0, max: 64 },
        applies: Applies::Restart,
        meaning: "solver threads of a fleet; 0: as many as processors. A single twin has one",
    },
    Parameter {
        name: "record.mode",
        unit: "",
        default: DefaultValue::Text("off"),
        admissible: Admissible::Choice(&["off", "events", "always"]),
        applies: Applies::Restart,
        meaning: "off: no recording; events: every impact event with its response; always: everything",
    },
    Parameter {
        name: "record.directory",
        unit: "",
        default: DefaultValue::Text("$XDG_STATE_HOME/column_twin/recordings"),
        admissible: DIRECTORY,
        applies: Applies::Restart,
        meaning: "directory of the recordings; `$XDG_STATE_HOME` as for `state.directory`",
    },
    Parameter {
        name: "record.max_file_size",
        unit: "B",
        default: DefaultValue::Integer(1_000_000_000),
        admissible: Admissible::Integer {
            min: 1_000_000,
            max: 1_000_000_000_000,
        },
        applies: Applies::Restart,
        meaning: "size at which a new recording is started once the column is at rest; at twice this size in any case",
    },
    Parameter {
        name: "record.max_duration",
        unit: "s",
        default: DefaultValue::Double(3600.0),
        admissible: Admissible::RealOrZero {
            min: 1.0,
            max: 1e9,
            zero: "no limit",
        },
        applies: Applies::Restart,
        meaning: "duration after which a new recording is started once the column is at rest; after twice this duration in any case",
    },
    Parameter {
        name: "record.max_files",
        unit: "",
        default: DefaultValue::Integer(100),
        admissible: Admissible::Integer {
            min: 0,
            max: 1_000_000,
        },
        applies: Applies::Restart,
        meaning: "maximum number of recordings, beyond which the oldest are deleted; 0: no limit",
    },
    Parameter {
        name: "record.max_total_size",
        unit: "B",
        default: DefaultValue::Integer(0),
        admissible: Admissible::Integer {
            min: 0,
            max: 1_000_000_000_000_000,
        },
        applies: Applies::Restart,
        meaning: "maximum total size of all recordings, beyond which the oldest are deleted; 0: no limit",
    },
    Parameter {
        name: "record.max_age",
        unit: "s",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 60.0,
            max: 1e9,
            zero: "no limit",
        },
        applies: Applies::Restart,
        meaning: "age at which recordings are deleted",
    },
    Parameter {
        name: "record.compression",
        unit: "",
        default: DefaultValue::Text("none"),
        admissible: Admissible::Choice(&["none", "lz4", "zstd"]),
        applies: Applies::Restart,
        meaning: "compression of the chunks of recordings",
    },
    Parameter {
        name: "record.sync",
        unit: "",
        default: DefaultValue::Bool(true),
        admissible: Admissible::Switch,
        applies: Applies::Restart,
        meaning: "write recorded data to the disk within 50 ms, so that they survive a power failure and not only a crash of the program",
    },
    Parameter {
        name: "record.seal",
        unit: "",
        default: DefaultValue::Bool(true),
        admissible: Admissible::Switch,
        applies: Applies::Restart,
        meaning: "seal recordings: sign a hash chain over all messages, so that every later change is detected",
    },
    Parameter {
        name: "record.seal_key",
        unit: "",
        default: DefaultValue::Text(""),
        admissible: OPTIONAL_PATH,
        applies: Applies::Restart,
        meaning: "file of the private key of the seals, as `openssl genpkey -algorithm ed25519` writes it; empty: a fresh key for each run, which proves that nothing was changed but not who recorded",
    },
    Parameter {
        name: "viewer.mode",
        unit: "",
        default: DefaultValue::Text("off"),
        admissible: Admissible::Choice(&["off", "save", "serve", "connect", "spawn"]),
        applies: Applies::Restart,
        meaning: "off: no pictures; save: write a file; serve: viewers connect to this program; connect: connect to a running viewer; spawn: start a viewer",
    },
    Parameter {
        name: "viewer.address",
        unit: "",
        default: DefaultValue::Text("127.0.0.1"),
        admissible: IDENTIFIER,
        applies: Applies::Restart,
        meaning: "address to serve on or to connect to",
    },
    Parameter {
        name: "viewer.port",
        unit: "",
        default: DefaultValue::Integer(9876),
        admissible: Admissible::Integer {
            min: 1,
            max: 65_535,
        },
        applies: Applies::Restart,
        meaning: "TCP port to serve on or to connect to",
    },
    Parameter {
        name: "viewer.directory",
        unit: "",
        default: DefaultValue::Text("$XDG_STATE_HOME/column_twin/recordings"),
        admissible: DIRECTORY,
        applies: Applies::Restart,
        meaning: "directory of the files that `save` writes; `$XDG_STATE_HOME` as for `state.directory`",
    },
    Parameter {
        name: "viewer.memory_limit",
        unit: "B",
        default: DefaultValue::Integer(256_000_000),
        admissible: Admissible::Integer {
            min: 1_000_000,
            max: 64_000_000_000,
        },
        applies: Applies::Restart,
        meaning: "memory for the data that viewers receive when they connect later or again (serve, connect, spawn); the oldest data are \
                  dropped first",
    },
    Parameter {
        name: "viewer.magnification",
        unit: "",
        default: DefaultValue::Double(1.0),
        admissible: Admissible::Real {
            min: 1.0,
            max: 1000.0,
        },
        applies: Applies::AtOnce,
        meaning: "magnification factor of the displacements in the pictures; 1: true to scale",
    },
    Parameter {
        name: "viewer.select",
        unit: "",
        default: DefaultValue::Texts(&[]),
        admissible: SELECTED_COLUMNS,
        applies: Applies::Restart,
        meaning: "columns of a fleet that the viewer always shows in full, besides the one that was hit last: their `column_id`, or their \
                  names with the wildcards of parameter files (`/garage/*`); a single twin ignores it",
    },
    alarm_rows::ROWS[0],
    alarm_rows::ROWS[1],
    alarm_rows::ROWS[2],
    alarm_rows::ROWS[3],
    alarm_rows::ROWS[4],
    alarm_rows::ROWS[5],
    alarm_rows::ROWS[6],
    alarm_rows::ROWS[7],
    alarm_rows::ROWS[8],
    alarm_rows::ROWS[9],
    alarm_rows::ROWS[10],
    alarm_rows::ROWS[11],
    alarm_rows::ROWS[12],
    alarm_rows::ROWS[13],
    alarm_rows::ROWS[14],
    alarm_rows::ROWS[15],
    alarm_rows::ROWS[16],
    alarm_rows::ROWS[17],
    alarm_rows::ROWS[18],
    alarm_rows::ROWS[19],
    alarm_rows::ROWS[20],
    alarm_rows::METRICS_ADDRESS,
    alarm_rows::FOXGLOVE[0],
    alarm_rows::FOXGLOVE[1],
    alarm_rows::FOXGLOVE[2],
    alarm_rows::FOXGLOVE[3],
    // The last row: the rows of every sensor, in `sensors.rs`, continue the table.
    Parameter {
        name: "sensors.names",
        unit: "",
        default: DefaultValue::Texts(&[]),
        admissible: SENSOR_NAMES,
        applies: Applies::Restart,
        meaning: "names of the sensors on the column, which the names of their parameters contain",
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_each_entry_is_complete() {
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            assert_eq!(
                PARAMETERS
                    .iter()
                    .position(|other| other.name == parameter.name),
                Some(index)
            );
            assert_eq!(
                parameter.default_value().kind(),
                parameter.kind(),
                "{}",
                parameter.name
            );
            assert!(
                !parameter.meaning.is_empty() && !parameter.meaning.ends_with('.'),
                "{}",
                parameter.name
            );
        }
    }

    #[test]
    fn nearest_names() {
        for (wrong, right) in [
            ("impact.velocty", "impact.velocity"),
            ("velocity", "impact.velocity"),
            ("impact/mass", "impact.mass"),
            ("Section.Name", "section.name"),
            ("section.nam", "section.name"),
            ("length_above", "geometry.length_above"),
            ("steel.fy", ""),
            ("impact.speed", ""),
            ("solver.time_step", ""),
            ("dt", "solver.dt"),
            ("yield_surface.aplha", "yield_surface.alpha"),
            ("a.a.velocty", "impact.velocity"),
            (&format!("{}velocty", "a.".repeat(40)), ""), // longer than is looked at
            ("support.base_stifness", "support.base_stiffness"),
        ] {
            assert_eq!(
                Parameter::nearest(wrong).first().copied().unwrap_or(""),
                right,
                "{wrong}"
            );
        }
    }
}

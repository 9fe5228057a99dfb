//! The one table of parameters, from which declaration, validation and documentation follow.

use super::assumed::ASSUMED_INPUTS;
use super::base::{CONCRETE_WORDS, FRICTION, GRADE_WORDS};
use super::criterion_names::{CRITERION_NAMES, DEFAULT_CRITERIA};
use super::parameter::Admissible::{
    Choice, Processors, RealOrOpen, SectionName, Sender, SteelGrade, Switch, VehicleName,
    WholeNanoseconds,
};
use super::parameter::{
    Applies, DefaultValue, Parameter, integer, list, or_zero, parameters, real, text,
};
use super::ranges::{
    ALARM_ACTION, BUCKLING_FACTOR, CURVE_CRUSH, CURVE_FORCE, DIRECTORY, EXPONENT, FROM_SECTION,
    HINGE_STIFFNESS, IDENTIFIER, LENGTH, OPTIONAL_PATH, ORIGINS, SELECTED_COLUMNS, SENSOR_NAMES,
    SITE, SLACK, SUPPORT, SUPPORT_STIFFNESS, TOP_SUPPORT, UNLOADING_STIFFNESS, VEHICLE_MASS,
};
use crate::column::MAX_MASSES;

/// Largest dynamic increase factor that may be asked for, and the limit of a law that has none of its own.
pub(super) const MAX_RATE_FACTOR: f64 = 100.0;

/// Height of the impact point above the base where nothing gives it \[m\], as in the paper.
pub(super) const DEFAULT_LENGTH_BELOW: f64 = 1.0;

/// Meaning of 0 for the numbers of a base plate.
const NO_PLATE: &str = "not given";

/// Numbers of the beam that it chooses itself.
const AUTOMATIC: &str = "automatic";

/// Meaning of 0 for the limit of the dynamic increase factor.
const NO_RATE_LIMIT: &str = "logarithmic: 1.35 for S235, 1.25 for S355, 1.15 for S460 (assumed), linear in f_y between them and constant beyond; \
                             cowper_symonds: no limit below 100";

/// `b` of a named section unless it is given: docs/theory.md gives the reasons.
pub(super) const HARDENING_OF_NAMED: f64 = 0.01;

/// The same where the strength grows with the strain rate, too.
pub(super) const HARDENING_WITH_RATE: f64 = 0.005;

/// Every parameter, in the order of the documentation.
pub const PARAMETERS: &[Parameter] = parameters! {
    "column_id", "", Text("column"), IDENTIFIER, Restart,
        "name of the column in messages; impact events for another column are rejected, or in a fleet ignored";
    "frame_id", "", Text("column"), IDENTIFIER, Restart,
        "coordinate frame of the column in messages, with its origin at the base";
    "publish_rate", "Hz", Double(1000.0), real(1.0, 10_000.0), AfterResponse,
        "rate at which state and hinge forces are published during a response; at most once per step, with the period rounded to whole \
         steps";
    "use_sim_time", "", Bool(false), Switch, Restart, "take the time from the topic /clock, as every ROS 2 node does";
    "start_type_description_service", "", Bool(true), Switch, Restart,
        "offer the service ~/get_type_description, as every ROS 2 node does";
    "site.x", "m", Double(0.0), SITE, Restart,
        "position of the column in the plan of its fleet, to the right; columns of a fleet that share a position with another one, or \
         give none, are shown in rows below the plan";
    "site.y", "m", Double(0.0), SITE, Restart,
        "position of the column in the plan of its fleet, upwards in the picture; see `site.x`";
    "geometry.height", "m", Double(0.0), or_zero(0.04, 200.0, "the sum of both lengths"), AfterResponse,
        "height of the column. With it, the impact point is where the vehicle strikes (`column-twin vehicles` lists the heights: cars 0.5 \
         m, forklift trucks 0.75 m, lorries 1.25 m), unless `geometry.length_below` or the impact gives a height, and \
         `geometry.length_above` is the rest. Both lengths replace it where they are given later: in a later file or section, on the \
         command line, or by a change of both together";
    "geometry.length_below", "m", Double(DEFAULT_LENGTH_BELOW), LENGTH, AfterResponse,
        "L_a: height of the impact point above the base";
    "geometry.length_above", "m", Double(3.0), LENGTH, AfterResponse, "L_b: distance from the impact point to the top";
    "section.name", "", Text("HEB220"), SectionName, AfterResponse,
        "rolled section, bent about its strong axis; empty: the section is user-defined. If files and overrides give one of the numbers \
         but no name, the name is empty";
    "section.area", "m^2", Double(0.0), or_zero(1e-5, 1.0, FROM_SECTION), AfterResponse,
        "A: cross-sectional area; overrides the area of a named section";
    "section.second_moment", "m^4", Double(0.0), or_zero(1e-10, 1.0, FROM_SECTION), AfterResponse,
        "I: second moment of area; overrides the value of a named section";
    "section.mass_per_length", "kg/m", Double(0.0), or_zero(0.01, 1e5, FROM_SECTION), AfterResponse,
        "m_l: mass per length; overrides the value of a named section";
    "section.height", "m", Double(0.0), or_zero(0.01, 10.0, FROM_SECTION), AfterResponse,
        "h: height in the plane of bending, for strain rates; overrides the value of a named section";
    "section.width", "m", Double(0.0), or_zero(0.01, 10.0, FROM_SECTION), AfterResponse,
        "b: width of the flanges, for the shear of the web; overrides the value of a named section";
    "section.web_thickness", "m", Double(0.0), or_zero(1e-4, 1.0, FROM_SECTION), AfterResponse,
        "t_w: thickness of the web, for its shear; overrides the value of a named section. A user-defined section yields in shear if it \
         has this and `section.height`";
    "section.flange_thickness", "m", Double(0.0), or_zero(1e-4, 1.0, FROM_SECTION), AfterResponse,
        "t_f: thickness of the flanges, for the shear of the web; overrides the value of a named section";
    "section.shape", "", Text("i_or_h"), Choice(&["i_or_h", "rectangular_hollow", "circular_hollow"]), AfterResponse,
        "shape of a user-defined section. rectangular_hollow: `section.height` and `section.width` over walls of the thickness \
         `section.web_thickness`; circular_hollow: the diameter is `section.height`, the thickness of the wall `section.web_thickness`";
    "steel.grade", "", Text("S355"), SteelGrade, AfterResponse,
        "steel grade, nominal values for thicknesses up to 40 mm (EN 1993-1-1, table 3.1); empty: the steel is user-defined. If files and \
         overrides give one of the numbers but no grade, the grade is empty";
    "steel.young_modulus", "Pa", Double(0.0), or_zero(1e9, 1e12, "from `steel.grade`"), AfterResponse,
        "E: Young's modulus; overrides the value of a named grade";
    "steel.yield_strength", "Pa", Double(0.0), or_zero(1e6, 1e10, "from `steel.grade`"), AfterResponse,
        "f_y: yield strength; overrides the value of a named grade";
    "resistance.moment", "N m", Double(0.0), or_zero(1.0, 1e10, "W_pl f_y, which needs `section.name`"), AfterResponse,
        "M^p: plastic moment resistance without normal force";
    "resistance.axial", "N", Double(0.0), or_zero(100.0, 1e11, "A f_y"), AfterResponse,
        "N^p: plastic axial resistance (squash load)";
    "resistance.shear", "N", Double(0.0), or_zero(1.0, 1e11, "from the web and the flanges of the section"), AfterResponse,
        "V_s: plastic resistance of a bar against shear, all of it";
    "yield_surface.alpha", "", Double(1.0), EXPONENT, AfterResponse,
        "alpha: exponent of the moment (Eq 28); 1 with beta = 1.3 is Duan-Chen, 2 with beta = 2 an ellipse";
    "yield_surface.beta", "", Double(1.3), EXPONENT, AfterResponse, "beta: exponent of the normal force (Eq 28)";
    "yield_surface.gamma", "", Double(1.0), real(0.01, 100.0), AfterResponse,
        "gamma: the whole sum is raised to 1/gamma (Eq 28), which scales the plastic multiplier but not the surface";
    "hinge.elastic_law", "", Text("coupled"), Choice(&["uncoupled", "coupled"]), AfterResponse,
        "uncoupled: the paper's independent springs (Eqs 47-48); coupled: the elastic beam, exact for any end rotations";
    "hinge.stiffness_1a", "N m/rad", Double(0.0), HINGE_STIFFNESS, AfterResponse,
        "rotational stiffness of hinge 1a, below the impact point; only with the uncoupled law";
    "hinge.stiffness_1b", "N m/rad", Double(0.0), HINGE_STIFFNESS, AfterResponse,
        "rotational stiffness of hinge 1b, above the impact point; only with the uncoupled law";
    "hinge.stiffness_2", "N m/rad", Double(0.0), HINGE_STIFFNESS, AfterResponse,
        "rotational stiffness of hinge 2, at the top; only with the uncoupled law and a built-in top";
    "hinge.stiffness_3", "N m/rad", Double(0.0), HINGE_STIFFNESS, AfterResponse,
        "rotational stiffness of hinge 3, at the base; only with the uncoupled law and a built-in base";
    "support.base", "", Text("built_in"), SUPPORT, AfterResponse, "rotational support of the base";
    "support.base_stiffness", "N m/rad", Double(0.0), SUPPORT_STIFFNESS, AfterResponse,
        "rotational stiffness of a semi-rigid base";
    "support.top", "", Text("built_in"), TOP_SUPPORT, AfterResponse,
        "support of the top: rotational, or free for a cantilever such as a bollard, which then needs `top.load: 0` and \
         `top.spring_stiffness: 0`";
    "support.top_stiffness", "N m/rad", Double(0.0), SUPPORT_STIFFNESS, AfterResponse,
        "rotational stiffness of a semi-rigid top";
    "base.connection", "", Text("none"), Choice(&["none", "plate"]), AfterResponse,
        "how the base is connected; none: nothing is known of it, and the assessment assumes a plate for a named section that is built \
         in; plate: a plate with anchors, which needs the other parameters of this group and `section.name`. Its moment and its shear \
         limit the base in the response, in which the foot may slip and the anchors fracture, and its initial stiffness replaces a base \
         that is built in";
    "base.plate_thickness", "m", Double(0.0), or_zero(0.004, 0.5, NO_PLATE), AfterResponse,
        "t_p: thickness of the base plate";
    "base.plate_length", "m", Double(0.0), or_zero(0.02, 10.0, NO_PLATE), AfterResponse,
        "length of the base plate in the plane of bending, parallel to the web";
    "base.plate_width", "m", Double(0.0), or_zero(0.02, 10.0, NO_PLATE), AfterResponse,
        "width of the base plate, parallel to the flanges";
    "base.anchor_count", "", Integer(0), integer(0, 64), AfterResponse,
        "number of anchors in two lines parallel to the flanges, half of them in each; even; 0 without a plate";
    "base.anchor_diameter", "m", Double(0.0), or_zero(0.012, 0.056, NO_PLATE), AfterResponse,
        "nominal diameter of the anchors, a thread of the coarse series such as 0.024";
    "base.anchor_grade", "", Text("none"), Choice(GRADE_WORDS), AfterResponse,
        "property class of the anchors, in quotes; stronger ones than 8.8 may not bear shear (EN 1993-1-8, 6.2.2); none without a plate";
    "base.anchor_distance", "m", Double(0.0), or_zero(0.001, 5.0, NO_PLATE), AfterResponse,
        "z_T: distance of each line of anchors from the axis of the section";
    "base.concrete", "", Text("none"), Choice(CONCRETE_WORDS), AfterResponse,
        "strength class of the concrete under the plate; none without a plate";
    "base.friction", "", Double(FRICTION), real(0.0, 1.0), AfterResponse,
        "C_f: coefficient of friction between plate and grout; 0.2 for sand and cement (EN 1993-1-8, 6.2.2)";
    "top.spring_stiffness", "N/m", Double(0.0), real(0.0, 1e13), AfterResponse,
        "k_s: stiffness of the vertical spring at the top, which represents the rest of the structure and takes load off a column that \
         shortens. Unless given, 0 for a section by name, 1e7 (the paper's example) for a user-defined one";
    "top.mass", "kg", Double(0.0), real(0.0, 1e7), AfterResponse, "m_2: lumped mass at the top";
    "top.load", "N", Double(5e5), real(0.0, 1e9), AfterResponse,
        "P: constant vertical load at the top, positive in compression";
    "top.redistribution_limit", "N", Double(0.0), or_zero(1.0, 1e9, "none counts"), AtOnce,
        "largest force that the structure above is proven to take off the column. The verdict compares with top.load less the force that \
         the spring takes, at most this; needs top.redistribution_proof and a top.spring_stiffness. The response has the whole spring in \
         any case";
    "top.redistribution_proof", "", Text(""), text(0, 200), AtOnce,
        "where the proof of top.redistribution_limit is found, such as the number of a calculation; every verdict states it";
    "top.load_basis", "", Text("present"), Choice(&["present", "accidental"]), AtOnce,
        "meaning of top.load, which every verdict states. present: the load that the column carries now; accidental: the load of the \
         accidental combination of EN 1990 (6.4.3.3), with its psi factors";
    "impact.mass", "kg", Double(1500.0), RealOrOpen { min: 1e-3, max: 1e6, open: "the vehicle's own mass; not for a rigid one" }, AtOnce,
        "m_c: total mass of the vehicle; all masses of a deformable one, and the springs between them, scale with it. If it is not given \
         and vehicle.name names a deformable vehicle, it is 0";
    "impact.velocity", "m/s", Double(10.0), real(1e-6, 60.0), AtOnce,
        "v_c: ground speed of the vehicle, positive towards the column";
    "impact.gap", "m", Double(0.0), real(0.0, 100.0), AtOnce, "g_N: initial gap between vehicle and column";
    "impact.restitution", "", Double(0.0), real(0.0, 1.0), AtOnce,
        "epsilon: coefficient of restitution of Newton's impact law; 0 is perfectly inelastic, 1 perfectly elastic";
    "impact.transverse_force", "N", Double(0.0), real(0.0, 1e7), AtOnce,
        "F: constant force on every vehicle in its direction of travel, before, during and after contact, shared by its masses in \
         proportion; at most 100 m/s^2 times its mass. The weight m g of a mass that falls on a horizontal member";
    "impact.direction", "rad", Double(0.0), real(-1000.0, 1000.0), AtOnce,
        "phi: direction of travel of the vehicle in (-pi, pi]; 0 bends the column about its strong axis, positive turns towards the \
         positive weak-axis direction. The two bars are plane and take the component of the motion in their plane, v cos phi; the fibre \
         beam takes all of it. A number beyond (-pi, pi] is no direction: the two bars then take the whole velocity, and there is no \
         second opinion";
    "vehicle.name", "", Text("rigid"), VehicleName, AtOnce,
        "vehicle of impacts that name none: the paper's rigid mass, or one of the catalogue; empty: the vehicle is user-defined. If files \
         and overrides give one of the numbers but no name, the name is empty";
    "vehicle.masses", "kg", Numbers(&[]), list(&VEHICLE_MASS, 0, MAX_MASSES), AtOnce,
        "masses of a user-defined vehicle, front first, each with a spring in front of it; impact.mass scales them, and the springs \
         between them";
    "vehicle.slack", "m", Numbers(&[]), list(&SLACK, 0, MAX_MASSES - 1), AtOnce,
        "distance that closes before a spring acts, one for each spring from the second on; empty: 0";
    "vehicle.spring_1.crush", "m", Numbers(&[]), CURVE_CRUSH, AtOnce,
        "spring 1, in front of mass 1: crush of the points of its force-crush curve after (0, 0), increasing";
    "vehicle.spring_1.force", "N", Numbers(&[]), CURVE_FORCE, AtOnce,
        "spring 1: force at each of these points; the last slope continues behind the last point";
    "vehicle.spring_1.unloading_stiffness", "N/m", Double(0.0), UNLOADING_STIFFNESS, AtOnce,
        "spring 1: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is \
         elastic";
    "vehicle.spring_2.crush", "m", Numbers(&[]), CURVE_CRUSH, AtOnce,
        "spring 2, in front of mass 2: crush of the points of its force-crush curve after (0, 0), increasing";
    "vehicle.spring_2.force", "N", Numbers(&[]), CURVE_FORCE, AtOnce,
        "spring 2: force at each of these points; the last slope continues behind the last point";
    "vehicle.spring_2.unloading_stiffness", "N/m", Double(0.0), UNLOADING_STIFFNESS, AtOnce,
        "spring 2: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is \
         elastic";
    "vehicle.spring_3.crush", "m", Numbers(&[]), CURVE_CRUSH, AtOnce,
        "spring 3, in front of mass 3: crush of the points of its force-crush curve after (0, 0), increasing";
    "vehicle.spring_3.force", "N", Numbers(&[]), CURVE_FORCE, AtOnce,
        "spring 3: force at each of these points; the last slope continues behind the last point";
    "vehicle.spring_3.unloading_stiffness", "N/m", Double(0.0), UNLOADING_STIFFNESS, AtOnce,
        "spring 3: stiffness of unloading and reloading, at least the steepest slope of the curve; equal to the only slope, the spring is \
         elastic";
    "vehicle.narrow_object", "", Bool(false), Switch, AtOnce,
        "whether the column meets half of the front's force up to a crush of 0.40 m, rising to all of it at 0.55 m, where it has reached \
         the engine. If it is not given, it follows vehicle.name: true for cars of the catalogue, false for all others and for a \
         user-defined vehicle. Another vehicle that an event names keeps its own default";
    "vehicle.force_factor", "", Double(1.0), real(0.01, 100.0), AtOnce,
        "factor of the forces and of the unloading stiffness of every deformable vehicle's front, for its scatter: lognormal, coefficient \
         of variation 20 % for cars (JCSS 2.18), 40 % for lorries (assumed)";
    "vehicle.bumper_height", "m", Double(0.0), real(0.0, 10.0), AtOnce,
        "height of the bumper, over which the vehicle holds the column straight; without effect where the web does not yield in shear. If \
         it is not given, a vehicle of the catalogue has its own, and a rigid or user-defined one has 0, a force at a point";
    "event.max_age", "s", Double(5.0), real(1e-3, 3600.0), AtOnce,
        "maximum age of the stamp of an impact event; an older event is rejected, and the response to a younger one catches up";
    "event.max_ahead", "s", Double(1.0), real(0.0, 60.0), AtOnce,
        "how far the stamp of an impact event may lie in the future; an event further ahead is rejected";
    "senders.allowed", "", Texts(&[]), list(&Sender, 0, 64), Restart,
        "who may send impact events, parameters, measurements and requests to reset, to confirm an estimate and to correct the damage; \
         empty: everybody. An enclave is known only with DDS security; without it a GUID can be forged";
    // A rejected event takes 3.7 kB of a recording: 0.67 GB per hour at this rate, less than `record.max_file_size` per
    // `record.max_duration`. One sender therefore does not shorten the time that the recordings cover.
    "senders.max_rate", "1/s", Double(50.0), or_zero(1e-3, 1e6, "no limit"), Restart,
        "impact events, sets of parameters and requests per second that the node takes from each sender, and from all new ones together; \
         with the default, one sender that sends without end does not shorten the time that the recordings cover";
    // As many as a fleet has columns.
    "senders.burst", "", Integer(2000), integer(1, 10_000), Restart,
        "number of messages that a sender may send in a burst under senders.max_rate";
    "estimation.accept", "", Text("confirmation"), Choice(&["never", "confirmation", "automatic"]), AtOnce,
        "when an impact that the sensors have detected becomes an impact of the twin. never: it is only published; confirmation: when \
         ~/confirm_estimate accepts it; automatic: as soon as its estimate is reliable enough, at the latest with the final one";
    "estimation.momentum_width", "", Double(0.3), real(0.01, 10.0), AtOnce,
        "largest width of the 90 % interval of the momentum, relative to its mean, of an estimate that is reliable enough";
    "estimation.yield_certainty", "", Double(0.9), real(0.5, 1.0), AtOnce,
        "least probability of yielding, or of no yielding, of an estimate that is reliable enough";
    "estimation.merge_window", "s", Double(0.5), real(0.0, 60.0), AtOnce,
        "largest difference of the instants of contact of an impact event and an estimate that are the same impact";
    "estimation.event_mass_deviation", "", Double(0.3), real(0.01, 10.0), AtOnce,
        "relative standard deviation of the mass in an impact event that is the same impact as an estimate, by which the event counts for \
         later estimates. 0.3: the masses of the vehicles of one kind differ by as much, because a camera or a person sees the kind and \
         not the load [A]";
    "estimation.event_velocity_deviation", "", Double(0.15), real(0.01, 10.0), AtOnce,
        "the same for the speed in such an event. 0.15: braking between the place where a camera measures the speed and the column is not \
         seen [A]";
    "rate.law", "", Text("none"), Choice(&["none", "cowper_symonds", "logarithmic"]), AfterResponse,
        "increase of the yield surface with the filtered strain rate e of each hinge. none: the paper; cowper_symonds: 1 + (e/d)^(1/q); \
         logarithmic: 1 + c ln(e/reference), not below 1, with its defaults the form of the CEB, f_y + 6 MPa ln(e / 5e-5) (recalled, not \
         verified)";
    "rate.d", "1/s", Double(40.4), real(1e-6, 1e9), AfterResponse,
        "strain rate at which the law of Cowper and Symonds doubles the strength; 40.4 with q = 5 is for mild steel (recalled, not \
         verified) and overstates the increase for higher grades";
    "rate.q", "", Double(5.0), real(1.0, 100.0), AfterResponse, "exponent of the law of Cowper and Symonds";
    "rate.c", "", Double(0.0), or_zero(1e-6, 1.0, "6 MPa / f_y"), AfterResponse, "factor of the logarithmic law";
    "rate.reference", "1/s", Double(5e-5), real(1e-9, 1e3), AfterResponse,
        "strain rate below which the logarithmic law increases nothing";
    "rate.time_constant", "s", Double(1e-3), real(1e-5, 1.0), AfterResponse,
        "time constant of the low-pass filter of the strain rate, without which the law is ill-posed";
    "rate.max_factor", "", Double(0.0), or_zero(1.0, MAX_RATE_FACTOR, NO_RATE_LIMIT), AfterResponse,
        "largest dynamic increase factor";
    "rate.hinge_length", "m", Double(0.0), or_zero(1e-3, 100.0, "the section height"), AfterResponse,
        "length over which the rotation of a plastic hinge is spread, for its strain rate";
    "shear.model", "", Text("web"), Choice(&["none", "web"]), AfterResponse,
        "web: the web of each bar yields in shear and deforms elastically, where its dimensions or `resistance.shear` are known; none: as \
         in the paper, it does neither";
    "shear.max_hardening", "", Double(0.0), or_zero(1.0, 100.0, "no limit"), AfterResponse,
        "largest strength of a web that hardens over its initial one. If it is not given, it is f_u/f_y of `steel.grade`, or 1.1, the \
         least of EN 1993-1-1, for user-defined steel";
    "hardening.ratio", "", Double(HARDENING_OF_NAMED), real(0.0, 0.1), AfterResponse,
        "b: slope of the stress-strain curve after yield over Young's modulus, from first yield on; it enlarges the whole yield surface \
         with the plastic rotation. Unless given, 0.01 for a section by name, 0.005 with a rate.law, 0 for a user-defined one; 12 \
         measured columns need 0.006 to 0.05 (docs/theory.md). 0 is on the safe side for displacements and on the unsafe side for forces";
    "softening.model", "", Text("backbone"), Choice(&["none", "backbone"]), AfterResponse,
        "how a hinge loses strength when its flanges and web buckle locally. backbone: its moment falls with the accumulated plastic \
         rotation beyond the capping rotation, as in a monotonic test (Lignos 2019); none: it does not. Unless given, backbone for a \
         section by name, none for a user-defined one; with assessment.ultimate_rotation: 0 there is none";
    "softening.capping_rotation", "rad", Double(0.0), or_zero(1e-4, 3.0, "from the section, its length and top.load"), AfterResponse,
        "theta_p: plastic rotation at which the moment begins to fall, and at which hardening ends";
    "softening.post_capping_rotation", "rad", Double(0.0), or_zero(1e-4, 10.0, "from the section, its length and top.load"), AfterResponse,
        "theta_pc: further plastic rotation over which the moment would fall to zero";
    "softening.residual", "", Double(0.0),
        or_zero(1e-3, 1.0, "from the section, its length and top.load; none for a user-defined section"), AfterResponse,
        "moment that remains, relative to that at the capping rotation";
    "solver.scheme", "", Text("conserving_midpoint"), Choice(&["midpoint", "conserving_midpoint"]), AfterResponse,
        "midpoint: the paper's midpoint rule as printed; conserving_midpoint: the midpoint rule that conserves energy";
    "solver.dt", "s", Double(0.0), WholeNanoseconds { min: 1e-7, max: 1e-3, zero: "chosen from the column's own period" }, AfterResponse,
        "time step; a chosen one is 1e-6 to 2e-5 s and keeps the error of the peak displacement below 2e-4 for 99 of 100 columns, with \
         the largest seen at 2e-3";
    "damping.ratio", "", Double(0.0), real(0.0, 1.0), AfterResponse,
        "damping ratio of the elastic modes, relative to critical damping; the paper has no damping";
    "response.duration", "s", Double(2.0), real(1e-3, 600.0), AfterResponse,
        "maximum duration of a computed response from the end of the approach, and of the approach; a response ends earlier if the column \
         comes to rest";
    "capacity.imperfection", "m", Double(0.0), or_zero(1e-6, 1.0, "by the buckling curve of the section (EN 1993-1-1, table 5.1)"), AtOnce,
        "e0: bow of the column for its axial capacity, at most a tenth of its height";
    "capacity.buckling_factor_strong", "", Double(0.0), BUCKLING_FACTOR, AtOnce,
        "K_y: buckling length about the strong axis, in the plane of the impact, over the height of the column";
    "capacity.buckling_factor_weak", "", Double(0.0), BUCKLING_FACTOR, AtOnce,
        "K_z: buckling length about the weak axis over the height of the column; 1 for a base plate with two rows of anchors next to the \
         web, which holds the weak axis as a pin";
    "assessment.ultimate_rotation", "rad", Double(0.15), or_zero(1e-3, 3.0, "no limit"), AfterResponse,
        "theta_u: plastic rotation at which a hinge is fractured, of hinges 1a and 1b together: the response ends there, and the column \
         is fractured (Lignos 2019)";
    "assessment.ultimate_shear_angle", "rad", Double(0.17), or_zero(1e-3, 3.0, "no limit"), AfterResponse,
        "plastic shear angle at which the web of a bar is fractured: the response ends there, and the column is fractured (ASCE/SEI \
         41-17, links that yield in shear; recalled). `assessment.ultimate_rotation: 0` lifts this limit, too";
    "assessment.criteria", "", Texts(DEFAULT_CRITERIA), list(&Choice(CRITERION_NAMES), 1, CRITERION_NAMES.len()), AtOnce,
        "criteria that decide the action; all others are shown only. `collapse` always decides";
    "assessment.assumed", "", Texts(&[]), ASSUMED_INPUTS, AtOnce,
        "inputs of the column that nobody has given and whose defaults are assumed: the action is then a lower bound, and its range \
         reaches `evacuate`. Unless this list is given, it holds those that are left out where column_id, section.name or section.area is \
         given. Another value of one of them removes it from the list; to confirm the assumed value, give this list without it";
    "assessment.range_velocity", "", Double(0.1), real(0.0, 0.9), AtOnce,
        "relative range of the speed of the vehicle, to both sides, within which the action of a verdict is sought. 0.1: a speed that is \
         read from skid marks or a camera [A]";
    "assessment.range_height", "m", Double(0.2), real(0.0, 10.0), AtOnce,
        "the same for the height of the impact point. 0.2: bumpers of one kind of vehicle differ by as much, and brakes dip them [A]";
    "assessment.range_front", "", Double(0.2), real(0.0, 0.9), AtOnce,
        "relative range of the force of the vehicle's front, to both sides, for the same. 0.2: the standard deviation of \
         `vehicle.force_factor`";
    "beam.mode", "", Text("second_opinion"), Choice(&["off", "second_opinion", "governing"]), AtOnce,
        "whether the fibre beam computes impacts, too: in `simulate` and nodes, and in maps and risk studies with `--model`. \
         off: it does not, and estimates from sensors do without it, too; \
         second_opinion: its verdict counts where the two models differ (docs/second_opinion.md lists when); governing: it always counts. \
         The more severe action of the two models then applies";
    "beam.elements", "", Integer(0), integer(0, 200), AtOnce,
        "elements of the fibre beam along the column; 0: automatic";
    "beam.fibres", "", Integer(0), integer(0, 64), AtOnce,
        "layers of fibres of the web, and at least as many fibres across a flange; 0: automatic";
    "beam.dt", "s", Double(0.0), WholeNanoseconds { min: 1e-6, max: 1e-3, zero: AUTOMATIC }, AtOnce,
        "time step of the fibre beam";
    "beam.shear", "", Bool(true), Switch, AtOnce, "whether the web of the fibre beam deforms and yields in shear";
    "beam.torsion", "", Text("warping"), Choice(&["warping", "saint_venant", "none"]), AtOnce,
        "how the fibre beam resists twist. warping: St Venant's torsion and restrained warping; saint_venant: that torsion alone; none: \
         the twist is suppressed";
    "beam.residual_stress", "", Bool(true), Switch, AtOnce,
        "whether the fibre beam has the residual stresses of rolling (ECCS)";
    "beam.bow", "m", Double(-1.0), real(-1.0, 10.0), AtOnce,
        "initial bow of the fibre beam about each axis of `beam.bow_axes`, at most a twentieth of its height; 0: straight; negative: a \
         thousandth of the height";
    "beam.bow_axes", "", Text("both"), Choice(&["both", "strong", "weak"]), AtOnce,
        "axes about which the fibre beam is bowed before the impact, and about which its capacity counts";
    "beam.steel", "", Text("bilinear"), Choice(&["bilinear", "plateau"]), AtOnce,
        "stress of the steel of the fibre beam over its strain. bilinear: it hardens from the first yield on, with `hardening.ratio`; \
         plateau: it yields at the same stress at first and then hardens up to the tensile strength of `steel.grade` (EN 1993-1-14, after \
         Yun and Gardner 2017)";
    "state.directory", "", Text("$XDG_STATE_HOME/column_twin/state"), OPTIONAL_PATH, Restart,
        "directory of the state file, which is named after the column and preserves the damage across restarts; `$XDG_STATE_HOME` is \
         `~/.local/state` unless the environment sets it; empty: the damage is lost when the program ends";
    "real_time.priority", "", Integer(50), integer(0, 99), Restart,
        "SCHED_FIFO priority of the solver thread, if the system permits it, with the publishing thread one below and the thread of DDS two below; 0: normal scheduling";
    "real_time.processors", "", Text(""), Processors, Restart,
        "processors that the solver thread may run on; empty: all";
    "real_time.lock_memory", "", Bool(true), Switch, Restart,
        "lock the program's memory so that it is never swapped out, if the system permits it";
    "real_time.threads", "", Integer(0), integer(0, 64), Restart,
        "solver threads of a fleet; 0: as many as processors. A single twin has one";
    "record.mode", "", Text("off"), Choice(&["off", "events", "always"]), Restart,
        "off: no recording; events: every impact event with its response; always: everything";
    "record.directory", "", Text("$XDG_STATE_HOME/column_twin/recordings"), DIRECTORY, Restart,
        "directory of the recordings; `$XDG_STATE_HOME` as for `state.directory`";
    "record.max_file_size", "B", Integer(1_000_000_000), integer(1_000_000, 1_000_000_000_000), Restart,
        "size at which a new recording is started once the column is at rest; at twice this size in any case";
    "record.max_duration", "s", Double(3600.0), or_zero(1.0, 1e9, "no limit"), Restart,
        "duration after which a new recording is started once the column is at rest; after twice this duration in any case";
    "record.max_files", "", Integer(100), integer(0, 1_000_000), Restart,
        "maximum number of recordings, beyond which the oldest are deleted; 0: no limit";
    "record.max_total_size", "B", Integer(0), integer(0, 1_000_000_000_000_000), Restart,
        "maximum total size of all recordings, beyond which the oldest are deleted; 0: no limit";
    "record.max_age", "s", Double(0.0), or_zero(60.0, 1e9, "no limit"), Restart, "age at which recordings are deleted";
    "record.compression", "", Text("none"), Choice(&["none", "lz4", "zstd"]), Restart,
        "compression of the chunks of recordings";
    "record.sync", "", Bool(true), Switch, Restart,
        "write recorded data to the disk within 50 ms, so that they survive a power failure and not only a crash of the program";
    "record.seal", "", Bool(true), Switch, Restart,
        "seal recordings: sign a hash chain over all messages, so that every later change is detected";
    "record.seal_key", "", Text(""), OPTIONAL_PATH, Restart,
        "file of the private key of the seals, as `openssl genpkey -algorithm ed25519` writes it; empty: a fresh key for each run, which \
         proves that nothing was changed but not who recorded";
    "viewer.mode", "", Text("off"), Choice(&["off", "save", "serve", "connect", "spawn"]), Restart,
        "off: no pictures; save: write a file; serve: viewers connect to this program; connect: connect to a running viewer; spawn: start \
         a viewer";
    "viewer.address", "", Text("127.0.0.1"), IDENTIFIER, Restart, "address to serve on or to connect to";
    "viewer.port", "", Integer(9876), integer(1, 65_535), Restart, "TCP port to serve on or to connect to";
    "viewer.directory", "", Text("$XDG_STATE_HOME/column_twin/recordings"), DIRECTORY, Restart,
        "directory of the files that `save` writes; `$XDG_STATE_HOME` as for `state.directory`";
    "viewer.memory_limit", "B", Integer(256_000_000), integer(1_000_000, 64_000_000_000), Restart,
        "memory for the data that viewers receive when they connect later or again (serve, connect, spawn); the oldest data are dropped \
         first";
    "viewer.magnification", "", Double(1.0), real(1.0, 1000.0), AtOnce,
        "magnification factor of the displacements in the pictures; 1: true to scale";
    "viewer.select", "", Texts(&[]), SELECTED_COLUMNS, Restart,
        "columns of a fleet that the viewer always shows in full, besides the one that was hit last: their `column_id`, or their names \
         with the wildcards of parameter files (`/garage/*`); a single twin ignores it";
    "alarm.spool", "", Text("$XDG_STATE_HOME/column_twin/alarms"), text(1, 4096), Restart,
        "directory of the alarms that wait for delivery; each node needs one of its own; `$XDG_STATE_HOME` as for `state.directory`";
    "alarm.heartbeat", "s", Double(60.0), or_zero(1.0, 86_400.0, "no heartbeats"), Restart,
        "time between two heartbeats, whose absence shows the receiver that the node does not run or cannot be reached";
    "alarm.mqtt.broker", "", Text(""), OPTIONAL_PATH, Restart,
        "broker of MQTT 5, such as mqtts://broker.example:8883; empty: no alarms by MQTT";
    "alarm.mqtt.client_id", "", Text(""), OPTIONAL_PATH, Restart,
        "name by which the broker identifies the node; two nodes with the same one disconnect one another; empty: from the name of the \
         node";
    "alarm.mqtt.topic", "", Text("column_twin/{node}/{subject}/{kind}"), OPTIONAL_PATH, Restart,
        "template of the topics, with the fields {node}, {subject} (the column, or column/sensor) and {kind} (action, sensor_failed, \
         node_stopped, heartbeat or test)";
    "alarm.mqtt.user", "", Text(""), OPTIONAL_PATH, Restart, "user, if the broker asks for one";
    "alarm.mqtt.password_file", "", Text(""), OPTIONAL_PATH, Restart,
        "file with the password of the user, which nobody else may read (mode 0600)";
    "alarm.mqtt.ca_file", "", Text(""), OPTIONAL_PATH, Restart,
        "certificates of the authorities that are trusted (PEM); empty: the authorities of the system";
    "alarm.mqtt.certificate_file", "", Text(""), OPTIONAL_PATH, Restart,
        "certificate of the node with its chain (PEM), if the broker asks for one";
    "alarm.mqtt.key_file", "", Text(""), OPTIONAL_PATH, Restart, "private key of this certificate (PEM, mode 0600)";
    "alarm.mqtt.action", "", Text("inspect"), ALARM_ACTION, Restart, "mildest action that is an alarm; off: none is";
    "alarm.mqtt.sensor_failed", "", Bool(true), Switch, Restart, "whether a sensor that is dead or stuck is an alarm";
    "alarm.mqtt.node_stopped", "", Bool(true), Switch, Restart,
        "whether it is an alarm that the node stops, in order or not";
    "alarm.webhook.url", "", Text(""), OPTIONAL_PATH, Restart,
        "address that alarms are posted to, such as https://alarms.example/column; http:// for this machine only; empty: no webhook";
    "alarm.webhook.secret_file", "", Text(""), OPTIONAL_PATH, Restart,
        "file with the key of the signatures: whsec_ and at least 24 bytes in Base64 (Standard Webhooks, mode 0600)";
    "alarm.webhook.ca_file", "", Text(""), OPTIONAL_PATH, Restart,
        "certificates of the authorities that are trusted (PEM); empty: the authorities of the system";
    "alarm.webhook.certificate_file", "", Text(""), OPTIONAL_PATH, Restart,
        "certificate of the node with its chain (PEM), if the receiver asks for one";
    "alarm.webhook.key_file", "", Text(""), OPTIONAL_PATH, Restart, "private key of this certificate (PEM, mode 0600)";
    "alarm.webhook.action", "", Text("inspect"), ALARM_ACTION, Restart, "mildest action that is an alarm; off: none is";
    "alarm.webhook.sensor_failed", "", Bool(true), Switch, Restart,
        "whether a sensor that is dead or stuck is an alarm";
    "alarm.webhook.node_stopped", "", Bool(true), Switch, Restart,
        "whether it is an alarm that the node stops, in order or not";
    "metrics.address", "", Text(""), OPTIONAL_PATH, Restart,
        "address and port from which Prometheus reads, such as 127.0.0.1:9464; empty: no metrics";
    "foxglove.mode", "", Text("off"), Choice(&["off", "serve"]), Restart,
        "off: no live topics for Foxglove; serve: Foxglove connects to this program, past DDS and its security";
    "foxglove.address", "", Text("127.0.0.1:8765"), OPTIONAL_PATH, Restart,
        "address and port to serve on; everybody who reaches an address that is not loopback sees the topics";
    "foxglove.origins", "", Texts(&["https://app.foxglove.dev"]), ORIGINS, Restart,
        "web pages that may connect, by their origins; programs, which send no origin, and pages of this machine always may";
    "foxglove.control", "", Bool(false), Switch, Restart,
        "whether Foxglove may set parameters and reset columns; `senders.*` does not limit it";
    // The last row: the rows of every sensor, in `sensors.rs`, continue the table.
    "sensors.names", "", Texts(&[]), SENSOR_NAMES, Restart,
        "names of the sensors on the column, which the names of their parameters contain";
};

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

//! The constants of one column, derived and checked once.

use thiserror::Error;

use super::bar::{Bar, PerBar};
use super::base_resistance::BaseResistance;
use super::frame::Frame;
use super::geometry::Displacement;
use super::modes::{self, Damping, Masses};
use super::properties::{ColumnProperties, ElasticLaw, RateLaw, Scheme, ShearProperties, Support};
use super::rate::StrengthLaw;
use super::sample::HINGE_NAMES;
use super::shear::Slider;
use super::step_length::{self, NANOS_PER_SECOND};
use super::yield_surface::YieldSurface;

/// Longest step \[ns\]: more than this is longer than the impacts for which this model is made.
const MAX_STEP_NANOS: u64 = 10_000_000;

/// Largest hardening ratio: the closed form for the spread of yielding neglects it beside 1, and structural steel has about
/// 0.01.
const MAX_HARDENING_RATIO: f64 = 0.1;

/// Least share of the length of a bar that a bumper leaves clear. The model of a bar makes no sense where nothing is left.
const MIN_CLEAR_SHARE: f64 = 0.1;

/// Largest height of a bumper over the length of the shorter bar: half of it leaves the share of it clear that the model needs.
pub const MAX_BUMPER_SHARE: f64 = 2.0 * (1.0 - MIN_CLEAR_SHARE);

/// A column that can be stepped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    /// The properties from which it was derived, with the length of a step that was chosen.
    pub properties: ColumnProperties,
    /// The two bars with their hinges, and the spring at the top.
    pub frame: Frame,
    /// `m_1`: a third of the column's mass, at the impact point; if the top is free, the mass there that gives the column
    /// its moment of inertia about the base \[kg\].
    pub impact_point_mass: f64,
    /// Static equilibrium of the undamaged column under its load.
    pub rest: RestState,
    /// Period of the slowest elastic mode about it \[s\].
    pub slowest_period: f64,
    /// `None` for a column without damping.
    pub(crate) damping: Option<Damping>,
    /// `None` where the resistances of the hinges are constant.
    pub(crate) strength: Option<StrengthLaw>,
    /// Length of a step \[s\].
    pub step_secs: f64,
    /// Relative residual to which the conserving scheme solves its equations.
    pub(crate) tolerance: f64,
    /// Relative residual from which on a correction is followed linearly instead of evaluating the equations again; 0: never.
    pub(crate) linear_residual: f64,
}

/// Relative residual to which the conserving scheme solves its equations: its energy balance is as exact as their solution.
const TOLERANCE: f64 = 1e-13;

/// The same for one of thousands of responses: an error of the forces far below that of its steps.
const ROUGH_TOLERANCE: f64 = 1e-6;

/// Relative residual below which a correction is so small that its square, 1e-10 where no hinge begins or ends to flow, does not
/// matter.
const LINEAR_RESIDUAL: f64 = 1e-2;

/// Static equilibrium of the undamaged column: `v1 = beta1 = 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RestState {
    /// `u1` \[m\].
    pub u1: f64,
    /// `u2` \[m\].
    pub u2: f64,
    /// `N` of both bars, `-P / (1 + k_s (1/K_a + 1/K_b))` \[N\].
    pub normal_force: f64,
}

/// Why some properties do not make a column.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ModelError {
    /// A number is NaN, infinite or outside its range.
    #[error("{name} is {found}; expected {expected}")]
    OutOfRange {
        /// Which property.
        name: &'static str,
        /// Its value.
        found: f64,
        /// What is expected instead.
        expected: &'static str,
    },
    /// Supports, load and spring that do not belong together.
    #[error("{reason}")]
    Incompatible {
        /// What is wrong, and what to do.
        reason: &'static str,
    },
    /// Stiffness given directly together with the coupled law.
    #[error(
        "the stiffness of hinge {hinge} is given directly, which the coupled elastic law cannot use; \
         leave it out or use the uncoupled law"
    )]
    StiffnessWithCoupledLaw {
        /// Name of the hinge.
        hinge: &'static str,
    },
    /// The load alone makes the column yield.
    #[error(
        "the load squashes the column: it puts {normal_force:.4e} N into the bars at rest and they yield at \
         {resistance:.4e} N; lower the load or take a larger section"
    )]
    Squashed {
        /// `|N|` at rest \[N\].
        normal_force: f64,
        /// `N^p` \[N\].
        resistance: f64,
    },
    /// The load alone makes the column buckle.
    #[error(
        "the load buckles the column: at rest the transverse stiffness of the impact point is {stiffness:.4e} N/m; \
         lower the load or stiffen the supports"
    )]
    Buckled {
        /// Condensed stiffness against `v1` \[N/m\], <= 0.
        stiffness: f64,
    },
}

impl Model {
    /// Checks the properties and derives the constants.
    ///
    /// # Errors
    /// A number out of its range, a contradiction, or a column that its load alone squashes or buckles.
    pub fn new(properties: &ColumnProperties) -> Result<Self, ModelError> {
        check(properties)?;
        let mut p = *properties;
        let frame = frame_of(&p);
        let impact_point_mass = impact_point_mass(&p);
        let top_mass = if frame.top_is_free { 0.0 } else { p.top_mass };
        let masses = [impact_point_mass, impact_point_mass, 0.0, top_mass];
        let rest = rest_state(&p, &frame)?;
        let at_rest = rest.displacement();
        let stiffness = modes::transverse_stiffness(&frame, &at_rest);
        let slowest_period = modes::slowest_period(&frame, &masses, &at_rest, &PerBar::default())
            .ok_or(ModelError::Buckled { stiffness })?;
        if p.step_nanos == 0 {
            p.step_nanos = step_length::recommended_step_nanos(impact_point_mass, stiffness);
        }
        let step_secs = p.step_nanos as f64 / NANOS_PER_SECOND;
        Ok(Self {
            properties: p,
            frame,
            impact_point_mass,
            rest,
            slowest_period,
            damping: (p.damping_ratio > 0.0)
                .then(|| modes::modal_damping(&frame, &masses, stiffness, p.damping_ratio)),
            strength: StrengthLaw::new(&p, step_secs),
            step_secs,
            tolerance: TOLERANCE,
            linear_residual: 0.0,
        })
    }

    /// Instant of the beginning of step `step` \[s\]: a count times a whole number of nanoseconds, never a sum of
    /// floats.
    pub fn time_of_step(&self, step: u64) -> f64 {
        (step as f64 * self.properties.step_nanos as f64) / NANOS_PER_SECOND
    }

    /// Elastic stiffness of the undamaged column against a transverse displacement of the impact point \[N/m\].
    #[must_use]
    pub fn transverse_stiffness(&self) -> f64 {
        modes::transverse_stiffness(&self.frame, &self.rest.displacement())
    }

    /// The column without the bumper, of which both bars have their whole lengths again. What follows from its motion (period,
    /// damping, length of a step) remains.
    #[must_use]
    pub fn without_bumper(&self) -> Self {
        let mut without = *self;
        if let Some(shear) = &mut without.properties.shear
            && shear.bumper_height > 0.0
        {
            shear.bumper_height = 0.0;
            without.frame = frame_of(&without.properties);
        }
        without
    }

    /// The column whose equations are solved as exactly as one of thousands of responses needs it, where the scheme conserves energy.
    #[must_use]
    pub fn solved_roughly(mut self) -> Self {
        self.tolerance = ROUGH_TOLERANCE;
        self.linear_residual = LINEAR_RESIDUAL;
        self
    }

    /// The column whose equations are solved as exactly as those of a single impact.
    pub(crate) fn solved_exactly(mut self) -> Self {
        self.tolerance = TOLERANCE;
        self.linear_residual = 0.0;
        self
    }

    /// Whether `u2` is an algebraic unknown.
    pub(crate) fn top_is_massless(&self) -> bool {
        self.top_mass() == 0.0
    }

    /// Mass that moves with `u2` \[kg\]; that of a free top sways with the impact point and is part of `m_1`.
    pub(crate) fn top_mass(&self) -> f64 {
        if self.frame.top_is_free {
            0.0
        } else {
            self.properties.top_mass
        }
    }

    /// Masses of the displacements `v1, u1, beta1, u2` \[kg\].
    pub(crate) fn masses(&self) -> Masses {
        let mass = self.impact_point_mass;
        [mass, mass, 0.0, self.top_mass()]
    }

    /// Which time-stepping scheme.
    pub(crate) fn scheme(&self) -> Scheme {
        self.properties.scheme
    }
}

impl RestState {
    /// The displacements at rest.
    pub(crate) fn displacement(&self) -> Displacement {
        Displacement {
            u1: self.u1,
            u2: self.u2,
            ..Displacement::default()
        }
    }
}

/// `m_1` \[kg\]. Both bars of a column that is held at its top move as a mechanism, of which a third of the mass counts.
/// A cantilever turns about its base as a whole, with its mass and the one at its top.
fn impact_point_mass(p: &ColumnProperties) -> f64 {
    let height = p.length_below + p.length_above;
    if p.top != Support::Free {
        return p.mass_per_length * height / 3.0;
    }
    let lever = height / p.length_below;
    (p.mass_per_length * height / 3.0 + p.top_mass) * lever * lever
}

/// Stiffness of a bar's hinges, index 0 at the impact point, index 1 at the supported end; `c = EI/L`.
///
/// With `r = k / (k + 4c)` (1 built-in, 0 pinned) the elastic beam with a support spring `k` at one end, condensed to
/// the rotations of chord against impact point and chord against ground, is `c [[3 + r, 2r], [2r, 4r]]`. The
/// uncoupled springs are exact for a rotation of the chord (Eqs 47-48 where built-in): its row sums.
fn rotational_stiffness(
    law: ElasticLaw,
    c: f64,
    support: Support,
    given: [Option<f64>; 2],
) -> [[f64; 2]; 2] {
    let r = match support {
        Support::BuiltIn => 1.0,
        Support::Pinned => 0.0,
        Support::Free => return [[0.0; 2]; 2],
        Support::SemiRigid { stiffness } => stiffness / (stiffness + 4.0 * c),
    };
    match law {
        ElasticLaw::Coupled => [[c * (3.0 + r), 2.0 * c * r], [2.0 * c * r, 4.0 * c * r]],
        ElasticLaw::Uncoupled => [
            [given[0].unwrap_or(3.0 * c * (1.0 + r)), 0.0],
            [0.0, given[1].unwrap_or(6.0 * c * r)],
        ],
    }
}

/// The bars between the supports and the bumper, or the impact point, and the spring at the top.
fn frame_of(p: &ColumnProperties) -> Frame {
    let surface = YieldSurface::new(p.resistance_moment, p.resistance_axial, p.yield_surface);
    let [stiffness_1a, stiffness_1b, stiffness_2, stiffness_3] = p.hinge_stiffness;
    let is_cantilever = p.top == Support::Free;
    let bar = |length: f64, support, given: [Option<f64>; 2]| {
        let c = p.bending_stiffness / length;
        let of_law = |law, given| match shear_deformation(p, length) {
            0.0 => rotational_stiffness(law, c, support, given),
            phi => sheared_stiffness(law, c, phi, support, given),
        };
        let mut rotational = of_law(p.elastic_law, given);
        if is_cantilever && p.elastic_law == ElasticLaw::Uncoupled && given[1].is_none() {
            // The springs of the paper are exact where both ends turn with the chord, but the end of a cantilever turns
            // so that it bears no moment.
            let [[joint, carried], [_, end]] = of_law(ElasticLaw::Coupled, [None; 2]);
            if joint > 0.0 {
                rotational[1][1] = end - carried * carried / joint;
            }
        }
        let mut bar = Bar::new(length, p.axial_rigidity / length, rotational, surface);
        bar.slider = p
            .shear
            .filter(|_| support != Support::Free)
            .map(|shear| Slider::of_web(shear.resistance(length), length, &rotational));
        bar
    };
    let [length_below, length_above] = p.clear_lengths();
    let mut below = bar(length_below, p.base, [stiffness_1a, stiffness_3]);
    if let (None, Some(connection)) = (&p.shear, &p.base_connection) {
        let slider = Slider::of_foot(connection.anchor_shear, length_below, &below.rotational);
        below.slider = Some(slider);
    }
    Frame {
        below,
        above: bar(length_above, p.top, [stiffness_1b, stiffness_2]),
        top_spring_stiffness: p.top_spring_stiffness,
        top_is_free: is_cantilever,
    }
}

/// `phi = 12 EI / (G A_s l^2)` of a bar of clear length `length` \[m\]; 0 for one without elastic shear.
fn shear_deformation(p: &ColumnProperties, length: f64) -> f64 {
    match &p.shear {
        Some(shear) if shear.rigidity > 0.0 => {
            12.0 * p.bending_stiffness / (shear.rigidity * length * length)
        }
        _ => 0.0,
    }
}

/// As [`rotational_stiffness`], of the beam of Timoshenko: its ends have the stiffness `a = c (4 + phi) / (1 + phi)` and carry
/// over `b = c (2 - phi) / (1 + phi)`. With `r = k / (k + a)` the beam with the support spring `k` at one end, condensed as
/// there, is `[[a - (1 - r) b^2/a, r b], [r b, r a]]`. The uncoupled springs are its row sums, exact for a rotation of the
/// chord.
fn sheared_stiffness(
    law: ElasticLaw,
    c: f64,
    phi: f64,
    support: Support,
    given: [Option<f64>; 2],
) -> [[f64; 2]; 2] {
    let a = c * (4.0 + phi) / (1.0 + phi);
    let b = c * (2.0 - phi) / (1.0 + phi);
    let r = match support {
        Support::BuiltIn => 1.0,
        Support::Pinned => 0.0,
        Support::Free => return [[0.0; 2]; 2],
        Support::SemiRigid { stiffness } => stiffness / (stiffness + a),
    };
    let joint = a - (1.0 - r) * (b * b / a);
    match law {
        ElasticLaw::Coupled => [[joint, r * b], [r * b, r * a]],
        ElasticLaw::Uncoupled => [
            [given[0].unwrap_or(joint + r * b), 0.0],
            [0.0, given[1].unwrap_or(r * (a + b))],
        ],
    }
}

fn rest_state(p: &ColumnProperties, frame: &Frame) -> Result<RestState, ModelError> {
    let flexibility = 1.0 / frame.below.axial + 1.0 / frame.above.axial;
    let normal_force = -p.top_load / (1.0 + p.top_spring_stiffness * flexibility);
    if -normal_force >= p.resistance_axial {
        return Err(ModelError::Squashed {
            normal_force: -normal_force,
            resistance: p.resistance_axial,
        });
    }
    Ok(RestState {
        u1: -normal_force / frame.below.axial,
        u2: -normal_force * flexibility,
        normal_force,
    })
}

fn check(p: &ColumnProperties) -> Result<(), ModelError> {
    const POSITIVE: &str = "a finite number > 0";
    const NOT_NEGATIVE: &str = "a finite number >= 0";
    const AT_LEAST_ONE: &str = "a finite number >= 1";
    let positive = |x: f64| x > 0.0;
    let not_negative = |x: f64| x >= 0.0;
    let at_least_one = |x: f64| x >= 1.0;
    type Check<'a> = (&'static str, f64, &'static str, &'a dyn Fn(f64) -> bool);
    let checks: [Check; 14] = [
        (
            "length below the impact point",
            p.length_below,
            POSITIVE,
            &positive,
        ),
        (
            "length above the impact point",
            p.length_above,
            POSITIVE,
            &positive,
        ),
        ("axial rigidity EA", p.axial_rigidity, POSITIVE, &positive),
        (
            "bending stiffness EI",
            p.bending_stiffness,
            POSITIVE,
            &positive,
        ),
        ("mass per length", p.mass_per_length, POSITIVE, &positive),
        ("plastic moment", p.resistance_moment, POSITIVE, &positive),
        ("squash load", p.resistance_axial, POSITIVE, &positive),
        (
            "yield exponent alpha",
            p.yield_surface.alpha,
            AT_LEAST_ONE,
            &at_least_one,
        ),
        (
            "yield exponent beta",
            p.yield_surface.beta,
            AT_LEAST_ONE,
            &at_least_one,
        ),
        (
            "yield exponent gamma",
            p.yield_surface.gamma,
            POSITIVE,
            &positive,
        ),
        (
            "stiffness of the top spring",
            p.top_spring_stiffness,
            NOT_NEGATIVE,
            &not_negative,
        ),
        ("mass at the top", p.top_mass, NOT_NEGATIVE, &not_negative),
        ("load on the top", p.top_load, NOT_NEGATIVE, &not_negative),
        (
            "damping ratio",
            p.damping_ratio,
            NOT_NEGATIVE,
            &not_negative,
        ),
    ];
    for (name, found, expected, right) in checks {
        within(name, found, right(found), expected)?;
    }
    check_supports(p)?;
    check_strength(p)?;
    if let Some(shear) = &p.shear {
        check_shear(p, shear)?;
    }
    if let Some(connection) = &p.base_connection {
        check_connection(connection)?;
    }
    if p.step_nanos > MAX_STEP_NANOS {
        return Err(ModelError::OutOfRange {
            name: "length of a time step [ns]",
            found: p.step_nanos as f64,
            expected: "a whole number from 1 to 10 000 000, or 0 (chosen from the period of the column)",
        });
    }
    Ok(())
}

/// Checks that a number is finite and right.
fn within(
    name: &'static str,
    found: f64,
    is_right: bool,
    expected: &'static str,
) -> Result<(), ModelError> {
    match found.is_finite() && is_right {
        true => Ok(()),
        false => Err(ModelError::OutOfRange {
            name,
            found,
            expected,
        }),
    }
}

fn check_connection(connection: &BaseResistance) -> Result<(), ModelError> {
    let [anchors, flange] = connection.lever;
    for (name, found) in [
        ("tension of the anchors of the base", connection.tension),
        (
            "compression under a flange at the base",
            connection.compression,
        ),
        ("lever of the anchors of the base", anchors),
        ("lever of a flange at the base", flange),
        ("shear of the anchors of the base", connection.anchor_shear),
    ] {
        within(name, found, found > 0.0, "a finite number > 0")?;
    }
    for (name, found) in [
        ("coefficient of friction at the base", connection.friction),
        (
            "slip at which the anchors of the base are sheared off",
            connection.ultimate_slip,
        ),
        (
            "elongation at which the anchors of the base are fractured",
            connection.ultimate_elongation,
        ),
    ] {
        within(name, found, found >= 0.0, "a finite number >= 0")?;
    }
    Ok(())
}

fn check_free_top(p: &ColumnProperties) -> Result<(), ModelError> {
    let is_free = p.top == Support::Free;
    let given = p.hinge_stiffness;
    let wrong = [
        (
            p.base == Support::Free,
            "the base is free, but only the top may be; build the base in, or make it semi-rigid or pinned",
        ),
        (
            is_free && p.base == Support::Pinned,
            "the top is free and the base pinned, so that nothing holds the column; build the base in, or make it semi-rigid",
        ),
        (
            is_free && p.top_load > 0.0,
            "the top is free, and a load on it would sway with it, which the model does not follow; set the load on the \
             top to 0, or hold the top",
        ),
        (
            is_free && p.top_spring_stiffness > 0.0,
            "the top is free, so that there is nothing above it to which a spring could be fixed; set the stiffness of the \
             top spring to 0, or hold the top",
        ),
        (
            is_free && (given[1].is_some() || given[2].is_some()),
            "the top is free, so that the hinges 1b and 2 bear no moment; leave out their stiffness, or hold the top",
        ),
    ];
    match wrong.into_iter().find(|(is_wrong, _)| *is_wrong) {
        Some((_, reason)) => Err(ModelError::Incompatible { reason }),
        None => Ok(()),
    }
}

fn check_supports(p: &ColumnProperties) -> Result<(), ModelError> {
    for (name, support) in [
        ("stiffness of the base", p.base),
        ("stiffness of the top", p.top),
    ] {
        if let Support::SemiRigid { stiffness } = support {
            let expected = "a finite number > 0; use a pinned support for no stiffness at all";
            within(name, stiffness, stiffness > 0.0, expected)?;
        }
    }
    check_free_top(p)?;
    for (hinge, given) in HINGE_NAMES.into_iter().zip(p.hinge_stiffness) {
        let Some(stiffness) = given else { continue };
        if p.elastic_law == ElasticLaw::Coupled {
            return Err(ModelError::StiffnessWithCoupledLaw { hinge });
        }
        within(
            "stiffness of a hinge",
            stiffness,
            stiffness > 0.0,
            "a finite number > 0",
        )?;
    }
    Ok(())
}

/// Checks the shear of the webs.
fn check_shear(p: &ColumnProperties, shear: &ShearProperties) -> Result<(), ModelError> {
    const NOT_NEGATIVE: &str = "a finite number >= 0";
    within(
        "shear resistance of the web",
        shear.web_resistance,
        shear.web_resistance > 0.0,
        "a finite number > 0; without the dimensions of the web, leave out the shear of the column",
    )?;
    for (name, found) in [
        ("plastic moment of a flange", shear.flange_moment),
        ("shear rigidity G A_s", shear.rigidity),
        ("hardening of the web [N/rad]", shear.hardening),
    ] {
        within(name, found, found >= 0.0, NOT_NEGATIVE)?;
    }
    let most = shear.max_hardening;
    within(
        "largest strength of the hardened web over its initial one",
        most,
        most == 0.0 || most >= 1.0,
        "a finite number >= 1, or 0 for no cap",
    )?;
    let ultimate = shear.ultimate_angle;
    within(
        "ultimate plastic shear angle [rad]",
        ultimate,
        ultimate >= 0.0,
        "a finite number >= 0; 0 for no limit",
    )?;
    let [below, above] = p.clear_lengths();
    within(
        "height of the bumper [m]",
        shear.bumper_height,
        shear.bumper_height >= 0.0
            && below >= MIN_CLEAR_SHARE * p.length_below
            && above >= MIN_CLEAR_SHARE * p.length_above,
        "a finite number >= 0 that leaves each bar at least a tenth of its length: \
         at most 1.8 times the length of the shorter one",
    )
}

/// Checks strain rate, hardening and ultimate rotation.
fn check_strength(p: &ColumnProperties) -> Result<(), ModelError> {
    const POSITIVE: &str = "a finite number > 0";
    const AT_LEAST_ONE: &str = "a finite number >= 1";
    let b = p.hardening_ratio;
    within(
        "hardening ratio",
        b,
        (0.0..=MAX_HARDENING_RATIO).contains(&b),
        "a number from 0 (no hardening) to 0.1",
    )?;
    if let Some(softening) = &p.softening {
        for (name, found) in [
            (
                "capping rotation of a hinge [rad]",
                softening.capping_rotation,
            ),
            (
                "post-capping rotation of a hinge [rad]",
                softening.post_capping_rotation,
            ),
        ] {
            within(
                name,
                found,
                found > 0.0,
                "a finite number > 0; without softening, leave it out",
            )?;
        }
        within(
            "residual strength of a hinge",
            softening.residual,
            (0.0..=1.0).contains(&softening.residual),
            "a number from 0 to 1, relative to the strength at the capping rotation",
        )?;
    }
    within(
        "ultimate plastic rotation [rad]",
        p.ultimate_rotation,
        p.ultimate_rotation >= 0.0,
        "a finite number >= 0; 0 for no limit",
    )?;
    let Some(rate) = &p.rate else { return Ok(()) };
    for (name, found) in [
        ("time constant of the strain rate [s]", rate.time_constant),
        (
            "length of a hinge for the strain rate [m]",
            rate.hinge_length,
        ),
        ("height of the section [m]", rate.section_height),
    ] {
        within(name, found, found > 0.0, POSITIVE)?;
    }
    let max = rate.max_factor;
    within(
        "largest dynamic increase factor",
        max,
        max >= 1.0,
        AT_LEAST_ONE,
    )?;
    match rate.law {
        RateLaw::CowperSymonds { d, q } => {
            within(
                "strain rate D of Cowper and Symonds [1/s]",
                d,
                d > 0.0,
                POSITIVE,
            )?;
            within(
                "exponent q of Cowper and Symonds",
                q,
                q >= 1.0,
                AT_LEAST_ONE,
            )
        }
        RateLaw::Logarithmic { c, reference } => {
            within(
                "coefficient C of the logarithmic rate law",
                c,
                c >= 0.0,
                "a finite number >= 0",
            )?;
            within(
                "reference strain rate of the logarithmic rate law [1/s]",
                reference,
                reference > 0.0,
                POSITIVE,
            )
        }
    }
}

//! What an assessment judges, as plain data.

use serde::{Deserialize, Serialize};

use super::base::{BaseDemand, ConnectedBase};
use super::criterion::{PARTIAL_FACTOR, quantity};
use super::remaining::{ResidualCapacity, section_dimensions};
use super::rotation_limits::{ULTIMATE_ROTATION, ULTIMATE_SHEAR_ANGLE};
use super::utilisation::Utilisation;
use crate::column::{
    BaseFailure, ColumnProperties, HINGES, Impact, Model, Outcome, PerBar, PlasticFlow, Report,
    RolledSection, ShearProperties, State, WEBS, plastic_before_bumper, plastic_plateau,
};
use crate::parameters::{AssumedInput, LoadBasis, Parameters};

/// What struck the column.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AssessedImpact {
    /// Total mass of the vehicle \[kg\].
    pub mass: f64,
    /// Its speed \[m/s\].
    pub velocity: f64,
    /// Largest force of its front within the given points of the force-crush curve \[N\]; `None` for a rigid vehicle.
    pub front_force: Option<f64>,
    /// Height of its bumper \[m\].
    #[serde(default)]
    pub bumper_height: f64,
    /// Its direction of travel \[rad\], of which the model sees the component in its plane only; 0 for a model that sees all of it.
    #[serde(default, skip_serializing_if = "is_in_plane")]
    pub direction: f64,
}

/// For what is left out where the vehicle travels in the plane of the model.
fn is_in_plane(direction: &f64) -> bool {
    *direction == 0.0
}

/// For what is left out where it is false.
fn is_false(value: &bool) -> bool {
    !*value
}

/// Shear of the webs of both bars.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AssessedShear {
    /// Plastic shear angles of the webs of the bars below and above the impact point since the column was new \[rad\].
    pub plastic_angle: [f64; WEBS],
    /// Plastic shear angle at which a web is fractured \[rad\].
    pub ultimate_angle: f64,
}

/// A smaller difference between two loads is round-off of an equilibrium \[N\].
const ROUND_OFF: f64 = 1.0;

/// Which load the column is judged with.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct VerdictLoad {
    /// `top.load`: the load at the top before the structure above takes anything of it \[N\].
    pub top_load: f64,
    /// Which load that is.
    pub basis: LoadBasis,
    /// Whether nobody has given it.
    #[serde(default, skip_serializing_if = "is_false")]
    pub is_assumed: bool,
    /// Whether a spring at the top bears it, too.
    #[serde(default, skip_serializing_if = "is_false")]
    pub has_spring: bool,
    /// Where the proof is found that the structure above takes a part of it; empty where none counts.
    pub redistribution_proof: String,
}

/// What another model of the same column and impact has found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OtherModel {
    /// Whether the column gives way under its load.
    pub collapsed: bool,
    /// Whether the steel yields anywhere, beyond what residual stresses alone make it yield.
    pub yielded: bool,
    /// Largest residual rotation within the length of a plastic zone, wherever it is \[rad\].
    pub kink: f64,
    /// Residual shear angles of the web below and above the impact point \[rad\].
    pub shear_angle: [f64; WEBS],
    /// Residual displacement of the impact point, whatever its direction \[m\]; `None` after a collapse.
    pub residual: Option<f64>,
    /// Largest residual distance of the axis from that of the undamaged column, at any height \[m\]; `None` after a collapse.
    pub bow: Option<f64>,
    /// Peak displacement of the impact point \[m\].
    pub peak: f64,
    /// Axial capacity of the undamaged column and of the column that the impact leaves \[N\].
    pub capacity: [f64; 2],
    /// Largest shear of the base, as a mean over 1 ms \[N\].
    pub base_shear: f64,
}

/// All that an assessment depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AssessmentInput {
    /// Whether the column has lost its shape or its equilibrium.
    pub collapsed: bool,
    /// Whether a hinge has fractured in the response.
    pub fractured: bool,
    /// Plastic rotations of the hinges 1a, 1b, 2, 3 since the column was new \[rad\].
    pub plastic_rotation: [f64; HINGES],
    /// `v1` in the equilibrium under the load that remains \[m\], from the straight line between the supports, which do not
    /// move sideways; `None` if the column has none, or it is not known.
    pub residual_v1: Option<f64>,
    /// Largest residual bow between the supports where it is known to be larger than at the impact point \[m\]: two straight bars
    /// are farthest from the line between the supports there.
    #[serde(default)]
    pub larger_bow: Option<f64>,
    /// Which part of the column has come closest to its strength, and how close; `None` where it is not known.
    pub utilisation: Option<Utilisation>,
    /// Plastic rotation at which a section fractures \[rad\].
    pub ultimate_rotation: f64,
    /// Shear of the webs; `None` where they do not yield in shear.
    pub shear: Option<AssessedShear>,
    /// Peak `v1` by absolute value \[m\].
    pub max_v1: f64,
    /// `L_a` \[m\].
    pub length_below: f64,
    /// `L_b` \[m\].
    pub length_above: f64,
    /// `N^p` \[N\].
    pub squash_load: f64,
    /// `f_y` \[Pa\].
    pub yield_strength: f64,
    /// Dimensions of the section; `None` where they are not known.
    pub section: Option<RolledSection>,
    /// Residual axial capacity and the carried load.
    pub remaining: ResidualCapacity,
    /// Which load `N` is.
    #[serde(default)]
    pub load: VerdictLoad,
    /// What nobody has given of the column, each with what is assumed instead, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub assumed: Vec<(AssumedInput, String)>,
    /// `F0`: plastic plateau of the undamaged column under the carried load \[N\].
    pub plateau: f64,
    /// What struck the column; `None` for an assessment of its state alone.
    pub impact: Option<AssessedImpact>,
    /// The connection of the base, given or assumed; `None` where there is none.
    #[serde(default)]
    pub base: Option<ConnectedBase>,
    /// Why there is none.
    #[serde(default)]
    pub no_base: Option<String>,
    /// What the impact puts into the base; `None` for an assessment of its state alone.
    #[serde(default)]
    pub base_demand: Option<BaseDemand>,
    /// Names of the criteria that decide the action, such as [`DEFAULT_CRITERIA`](crate::parameters::DEFAULT_CRITERIA).
    pub deciding: Vec<String>,
}

impl From<&Impact> for AssessedImpact {
    fn from(impact: &Impact) -> Self {
        let front_force = impact.vehicle.and_then(|vehicle| {
            let envelope = vehicle.springs().first()?.envelope;
            let forces = envelope.points().iter().map(|[_, force]| *force);
            Some(forces.fold(0.0, f64::max))
        });
        Self {
            mass: impact.mass,
            velocity: impact.velocity,
            front_force,
            bumper_height: impact.bumper_height,
            direction: 0.0,
        }
    }
}

impl AssessedShear {
    /// With these plastic shear angles \[rad\]; `None` where the webs of the column do not yield in shear.
    pub(super) fn of(model: &Model, plastic_angle: [f64; WEBS]) -> Option<Self> {
        let shear = model.properties.shear?;
        Some(Self {
            plastic_angle,
            ultimate_angle: match shear.ultimate_angle > 0.0 {
                true => shear.ultimate_angle,
                false => ULTIMATE_SHEAR_ANGLE,
            },
        })
    }

    /// Whether a web has sheared beyond its ultimate angle.
    pub(super) fn is_fractured(&self) -> bool {
        self.largest_angle() >= self.ultimate_angle
    }

    /// The largest absolute plastic shear angle \[rad\]; NaN if one of them is, which exceeds every limit.
    pub(super) fn largest_angle(&self) -> f64 {
        largest(self.plastic_angle)
    }
}

/// The largest absolute value; NaN if one of them is.
fn largest<const N: usize>(values: [f64; N]) -> f64 {
    let mut largest = 0.0;
    for value in values.map(f64::abs) {
        if value > largest || value.is_nan() {
            largest = value;
        }
    }
    largest
}

impl VerdictLoad {
    fn of(parameters: &Parameters) -> Self {
        let settings = parameters.settings();
        let (top, assumed) = (&settings.top, &settings.assessment.assumed);
        Self {
            top_load: top.load,
            basis: top.load_basis,
            is_assumed: assumed.contains(&AssumedInput::TopLoad),
            has_spring: top.spring_stiffness > 0.0,
            redistribution_proof: top.redistribution_proof.clone(),
        }
    }

    /// That a column that stands does not bear the load at its top by itself, as a sentence behind a space; empty where it does, and
    /// where there is no spring from which the load could hang.
    pub(super) fn words_of_what_holds(&self, remaining: &ResidualCapacity) -> String {
        let own = remaining.least_resistance();
        if !self.has_spring || own >= self.top_load {
            return String::new();
        }
        let force = |newtons: f64| quantity(newtons, "N");
        let how = match remaining.taken_load {
            None => "it hangs from the spring at the top".to_owned(),
            Some(taken) if self.top_load - taken <= own => format!(
                "it hangs from the spring at the top, which bears {}",
                force(taken)
            ),
            // It stands in the model, whose push-down is not the resistance of the code.
            taken => format!(
                "its remaining buckling resistance is {}, and the spring at the top bears {} of the rest",
                force(own),
                taken
                    .filter(|it| *it > 0.0)
                    .map_or("nothing".to_owned(), force)
            ),
        };
        let load = force(self.top_load);
        format!(" The column alone does not bear its load of {load}: {how}.")
    }

    /// What `N` of this column is, as a sentence.
    pub(super) fn in_words(&self, remaining: &ResidualCapacity) -> String {
        let force = |newtons: f64| quantity(newtons, "N");
        let load = remaining.carried_load;
        let basis = match self.is_assumed {
            true => "an assumed value",
            false => self.basis.in_words(),
        };
        let taken = self.top_load - load;
        let what = if taken.abs() < ROUND_OFF {
            format!("top.load, {basis}, before any redistribution")
        } else if taken > 0.0 {
            format!(
                "top.load of {}, {basis}, less {} that the structure above takes (proof: {})",
                force(self.top_load),
                force(taken),
                self.redistribution_proof
            )
        } else {
            format!(
                "top.load of {}, {basis}, and {} with which the structure above presses on the column",
                force(self.top_load),
                force(-taken)
            )
        };
        format!(
            "The applied load N of {} is {what}; gamma_M = {PARTIAL_FACTOR:.1}.",
            force(load)
        )
    }
}

impl AssessmentInput {
    /// After a response: its report, the impact, and the residual capacity of the column that it left.
    #[must_use]
    pub fn of_response(
        parameters: &Parameters,
        model: &Model,
        impact: &Impact,
        report: &Report,
        remaining: ResidualCapacity,
    ) -> Self {
        Self {
            collapsed: report.outcome == Outcome::Collapsed,
            fractured: report.outcome == Outcome::Fractured,
            plastic_rotation: report.hinges.map(|hinge| hinge.plastic_rotation),
            shear: AssessedShear::of(model, report.webs.map(|web| web.plastic_angle)),
            residual_v1: report.residual_v1,
            utilisation: Some(Utilisation::of_report(report)),
            max_v1: report.max_v1.abs(),
            impact: Some(AssessedImpact {
                direction: parameters.direction(),
                ..AssessedImpact::from(impact)
            }),
            base_demand: Some(BaseDemand::of(report)),
            ..Self::of_column(parameters, model, remaining)
        }
    }

    /// Of a column at rest, whatever has happened to it.
    #[must_use]
    pub fn of_state(
        parameters: &Parameters,
        model: &Model,
        state: &State,
        remaining: ResidualCapacity,
    ) -> Self {
        Self {
            residual_v1: Some(state.displacement.v1),
            utilisation: Some(Utilisation::of_sample(&state.sample(model))),
            max_v1: state.displacement.v1.abs(),
            ..Self::of_column(parameters, model, remaining)
        }
        .deformed(model, &state.plastic_of_steel(model))
    }

    /// Which anchors of the base have fractured in the response, if they have.
    pub(super) fn fractured_base(&self) -> Option<BaseFailure> {
        let demand = self.base_demand.as_ref().filter(|_| self.fractured)?;
        demand.report.fractured
    }

    /// With this plastic deformation of the steel of the column of this model.
    fn deformed(self, model: &Model, plastic: &PerBar<PlasticFlow>) -> Self {
        Self {
            plastic_rotation: [
                plastic.below.rotation[0],
                plastic.above.rotation[0],
                plastic.above.rotation[1],
                plastic.below.rotation[1],
            ],
            shear: AssessedShear::of(
                model,
                [plastic.below.shear_angle, plastic.above.shear_angle],
            ),
            ..self
        }
    }

    /// The same with what has struck the column of this model, which is in this state, last: before its bumper the column
    /// has its plastic plateau, and the angles are those over the lengths that the bumper left clear, as in the response.
    pub(crate) fn struck_by(self, model: &Model, state: &State, impact: AssessedImpact) -> Self {
        let struck = Self {
            impact: Some(impact),
            ..self
        };
        let shear = model.properties.shear.map(|shear| ShearProperties {
            bumper_height: impact.bumper_height,
            ..shear
        });
        let before = Model::new(&ColumnProperties {
            shear,
            ..model.properties
        });
        // The parameters may have changed since then, so that the bumper no longer fits.
        let Ok(before) = before else { return struck };
        Self {
            plateau: plastic_plateau(&before, struck.remaining.carried_load),
            ..struck
        }
        .deformed(
            &before,
            &plastic_before_bumper(model, &before, &state.plastic_of_steel(model)),
        )
    }

    fn of_column(parameters: &Parameters, model: &Model, remaining: ResidualCapacity) -> Self {
        let p = &model.properties;
        let base = ConnectedBase::of(parameters);
        Self {
            collapsed: false,
            fractured: false,
            plastic_rotation: [0.0; HINGES],
            residual_v1: None,
            larger_bow: None,
            utilisation: None,
            ultimate_rotation: if p.ultimate_rotation > 0.0 {
                p.ultimate_rotation
            } else {
                ULTIMATE_ROTATION
            },
            shear: AssessedShear::of(model, [0.0; WEBS]),
            max_v1: 0.0,
            length_below: p.length_below,
            length_above: p.length_above,
            squash_load: p.resistance_axial,
            yield_strength: parameters.steel().yield_strength,
            section: section_dimensions(parameters),
            plateau: plastic_plateau(model, remaining.carried_load),
            remaining,
            load: VerdictLoad::of(parameters),
            assumed: parameters.assumed_in_words(),
            impact: None,
            no_base: base.err().map(str::to_owned),
            base: base.ok(),
            base_demand: None,
            deciding: parameters.settings().assessment.criteria.clone(),
        }
    }

    /// The same impact as another model sees it. Its plastic rotation is that of its cross-sections.
    #[must_use]
    pub fn by_another_model(&self, other: &OtherModel) -> Self {
        let stands_bent = other.yielded && !other.collapsed;
        let kink = if stands_bent { other.kink } else { 0.0 };
        let shear = self.shear.map(|shear| AssessedShear {
            plastic_angle: if stands_bent {
                other.shear_angle
            } else {
                [0.0; WEBS]
            },
            ..shear
        });
        let mut base_demand = self.base_demand;
        if let Some(demand) = &mut base_demand {
            demand.has_flowed = other.yielded;
            let shear = &mut demand.report.peak_shear.shear;
            if other.base_shear > shear.abs() {
                *shear = other.base_shear;
            }
        }
        Self {
            collapsed: other.collapsed,
            fractured: false,
            // It sees the whole of a hit out of the plane.
            impact: self.impact.map(|impact| AssessedImpact {
                direction: 0.0,
                ..impact
            }),
            // Which hinge of the two bars it would be is not asked: the largest one decides.
            plastic_rotation: [kink, 0.0, 0.0, 0.0],
            shear,
            residual_v1: other.residual,
            larger_bow: other.bow,
            utilisation: None,
            max_v1: other.peak,
            remaining: self.remaining.by_another_model(other.capacity),
            base_demand,
            ..self.clone()
        }
    }

    /// The largest utilisation of the base in the response, by shear, moment or uplift: above 1 its connection fails. `None` where
    /// the base is not known.
    #[must_use]
    pub fn base_utilisation(&self) -> Option<f64> {
        let base = self.base.as_ref()?;
        Some(base.utilisation(self.base_demand.as_ref()?))
    }

    /// The largest plastic rotation \[rad\], see [`largest_plastic_rotation`].
    pub(super) fn largest_rotation(&self) -> f64 {
        largest_plastic_rotation(&self.plastic_rotation)
    }

    /// Height of the column \[m\].
    #[must_use]
    pub fn height(&self) -> f64 {
        self.length_below + self.length_above
    }

    /// Which share of its squash load the column carries in compression.
    pub(super) fn axial_ratio(&self) -> f64 {
        self.remaining.carried_load / self.squash_load
    }

    /// The largest residual bow between the supports \[m\]; `None` if the column has no equilibrium, or it is not known.
    #[must_use]
    pub fn largest_bow(&self) -> Option<f64> {
        let there = self.residual_v1?.abs();
        // A NaN at the impact point is no bow that another one exceeds: it fails every check.
        let larger = self.larger_bow.filter(|bow| *bow > there);
        Some(larger.unwrap_or(there))
    }

    /// The residual bow over the height.
    pub(super) fn bow_of_column(&self) -> Option<f64> {
        self.largest_bow().map(|bow| bow / self.height())
    }

    /// The residual bow of the bent part over its length: of the piece that reaches from the impact point as far as the
    /// shorter bar does, to both sides. A kink in its middle makes a bow of a quarter of the kink, never less than that of
    /// the whole column.
    pub(super) fn bow_of_bent_part(&self) -> Option<f64> {
        let kink = self.bow_of_kink(self.residual_v1?);
        let column = self.bow_of_column().filter(|bow| *bow > kink);
        Some(column.unwrap_or(kink))
    }

    /// The kink that the residual displacement makes at the impact point \[rad\]; `None` if the column has no equilibrium, or it is
    /// not known.
    #[must_use]
    pub fn kink(&self) -> Option<f64> {
        let v1 = self.residual_v1?.abs();
        Some(v1 / self.length_below + v1 / self.length_above)
    }

    /// The bow of the bent part over its length if the impact point lies this far from the line between the supports \[m\].
    pub(super) fn bow_of_kink(&self, v1: f64) -> f64 {
        0.25 * (v1.abs() / self.length_below + v1.abs() / self.length_above)
    }

    /// The largest rotation of a bar at its support \[deg\], its shortening neglected.
    pub(super) fn support_rotation(&self) -> f64 {
        let shorter = self.length_below.min(self.length_above);
        libm::atan(self.max_v1 / shorter).to_degrees()
    }
}

/// The largest plastic rotation that has a limit of its own \[rad\]: that of the top, of the base, or the kink at the impact
/// point, which hinges 1a and 1b share in a way that is undetermined. NaN if one of them is, which exceeds every limit.
#[must_use]
pub fn largest_plastic_rotation(rotations: &[f64; HINGES]) -> f64 {
    let [below, above, top, base] = *rotations;
    let mut largest = 0.0;
    for rotation in [below + above, top, base].map(f64::abs) {
        if rotation > largest || rotation.is_nan() {
            largest = rotation;
        }
    }
    largest
}

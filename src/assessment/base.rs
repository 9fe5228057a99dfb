//! The base of a column in an assessment: what it has to bear, what its connection bears, and which part fails first.
//!
//! Forces *into* a connection are larger than the nominal strength of the column says, because real steel is stronger: where
//! the column has flowed they are multiplied by the overstrength. A column that has remained elastic passes on the forces of
//! its vibration, which do not grow with its strength.

use serde::{Deserialize, Serialize};

use crate::column::{
    BaseFailure, BaseForces, BasePlate, BaseReport, BaseResistance, Outcome, Report, Support,
};
use crate::parameters::{Parameters, assumed_plate, plate_in_words, resistance_of_base};

use super::criterion::Criterion;

/// Ratio of the yield strength that steel has to the nominal one, for forces into connections (`gamma_ov` of EN 1998-1,
/// 6.1.3, recalled).
pub const OVERSTRENGTH: f64 = 1.25;

/// Utilisation of anchors from which on they do not hold the column any more, an assumption: the steel of anchors and the
/// partial factor of their resistance leave about that much.
pub(super) const FAILED_ANCHORS: f64 = 1.3;

/// What the criteria of the base have in common in their names.
const PREFIX: &str = "base_";

/// The connection of a base.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ConnectedBase {
    /// The plate.
    pub plate: BasePlate,
    /// What it bears, without partial factors.
    pub resistance: BaseResistance,
    /// Whether nobody has given it.
    pub is_assumed: bool,
    /// Whether it bears moments: not with a pinned base.
    pub bears_moment: bool,
}

/// What an impact puts into the base.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BaseDemand {
    /// The reactions, with the nominal strength of the column.
    pub report: BaseReport,
    /// Whether the column has flowed with its nominal strength, so that its overstrength counts.
    pub has_flowed: bool,
}

const NO_FORCES: BaseForces = BaseForces {
    shear: 0.0,
    moment: 0.0,
    normal_force: 0.0,
};

/// Of a column to which nothing has happened.
pub(super) const AT_REST: BaseDemand = BaseDemand {
    report: BaseReport {
        plateau: None,
        peak_shear: NO_FORCES,
        peak_shear_time: 0.0,
        reversed_shear: NO_FORCES,
        peak_moment: NO_FORCES,
        least_compressed: NO_FORCES,
        most_compressed: NO_FORCES,
        checked_moment: NO_FORCES,
        slip: 0.0,
        anchor_elongation: 0.0,
        fractured: None,
    },
    has_flowed: false,
};

/// A force or moment in a base and its resistance to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Utilisation {
    pub demand: f64,
    pub resistance: f64,
    pub failure: BaseFailure,
}

impl Utilisation {
    pub fn ratio(&self) -> f64 {
        if self.demand <= 0.0 {
            return 0.0;
        }
        // A resistance of 0 is exceeded by any demand.
        self.demand / self.resistance
    }
}

impl ConnectedBase {
    /// The connection that the parameters give, or that is assumed for a named section that is built in.
    ///
    /// # Errors
    /// Why there is none, in words.
    pub fn of(parameters: &Parameters) -> Result<Self, &'static str> {
        let section = parameters.section_dimensions().ok_or(
            "the dimensions of the section are not known; give section.name without overriding its properties",
        )?;
        let support = parameters.column_properties().base;
        let given = parameters.base_plate();
        if given.is_none() && support != Support::BuiltIn {
            return Err(
                "the connection of the base is not known, and none is assumed where it is not built in; give base.connection",
            );
        }
        let plate =
            given.unwrap_or_else(|| assumed_plate(&section, parameters.steel().yield_strength));
        let resistance = resistance_of_base(&plate, parameters.settings())
            .map_err(|_| "no base plate is known for this section; give base.connection")?;
        Ok(Self {
            plate,
            resistance,
            is_assumed: given.is_none(),
            bears_moment: support != Support::Pinned,
        })
    }

    /// The instants of a response that may decide.
    fn instants(demand: &BaseDemand) -> [BaseForces; 3] {
        let BaseReport {
            peak_shear,
            reversed_shear,
            least_compressed,
            ..
        } = demand.report;
        [peak_shear, reversed_shear, least_compressed]
    }

    /// Shear of the anchors and of the friction, at the worst instant.
    pub(super) fn shear(&self, demand: &BaseDemand) -> Utilisation {
        let at = |forces: &BaseForces| Utilisation {
            demand: demand.overstrength() * forces.shear.abs(),
            resistance: self.resistance.shear(forces.normal_force),
            failure: BaseFailure::AnchorsInShear,
        };
        let [first, rest @ ..] = Self::instants(demand);
        rest.iter()
            .map(at)
            .fold(at(&first), |worst, it| match it.ratio() > worst.ratio() {
                true => it,
                false => worst,
            })
    }

    /// The moment that has to be checked. No more than the column can have at its base comes into it.
    pub(super) fn moment(&self, demand: &BaseDemand) -> Utilisation {
        let checked = &demand.report.checked_moment;
        Utilisation {
            demand: demand.overstrength() * checked.moment.abs(),
            resistance: self.resistance.moment(checked.normal_force),
            failure: self.resistance.moment_limit(checked.normal_force),
        }
    }

    /// The tension of all anchors.
    pub(super) fn uplift(&self, demand: &BaseDemand) -> Utilisation {
        let tension = demand.report.least_compressed.normal_force.max(0.0);
        Utilisation {
            demand: demand.overstrength() * tension,
            resistance: self.resistance.uplift(),
            failure: self.resistance.tension_limit,
        }
    }

    /// What is used most, as a ratio: above 1 the connection fails.
    pub(super) fn utilisation(&self, demand: &BaseDemand) -> f64 {
        self.worst(demand).ratio()
    }

    /// What is used most.
    pub(super) fn worst(&self, demand: &BaseDemand) -> Utilisation {
        let mut worst = self.shear(demand);
        let moment = self.bears_moment.then(|| self.moment(demand));
        for it in moment.into_iter().chain([self.uplift(demand)]) {
            if it.ratio() > worst.ratio() {
                worst = it;
            }
        }
        worst
    }
}

impl BaseDemand {
    /// Of a response.
    #[must_use]
    pub fn of(report: &Report) -> Self {
        Self {
            report: report.base,
            has_flowed: report.outcome != Outcome::Elastic,
        }
    }

    /// Of the response of a column that was computed with the largest strength that its steel may have, which is not multiplied
    /// once more.
    pub(super) fn with_overstrength(report: &Report) -> Self {
        Self {
            report: report.base,
            has_flowed: false,
        }
    }

    /// By what the nominal forces are multiplied.
    #[must_use]
    pub fn overstrength(&self) -> f64 {
        if self.has_flowed { OVERSTRENGTH } else { 1.0 }
    }

    /// With the larger reactions of an earlier impact: what that has done to the base remains.
    #[must_use]
    pub fn after(self, earlier: Option<&Self>) -> Self {
        let Some(earlier) = earlier else { return self };
        let (now, then) = (&self.report, &earlier.report);
        let larger = |pick: fn(&BaseReport) -> BaseForces, size: fn(&BaseForces) -> f64| {
            let [now, then] = [pick(now), pick(then)];
            if size(&then) > size(&now) { then } else { now }
        };
        Self {
            report: BaseReport {
                peak_shear: larger(|it| it.peak_shear, |it| it.shear),
                reversed_shear: larger(|it| it.reversed_shear, |it| -it.shear),
                peak_moment: larger(|it| it.peak_moment, |it| it.moment.abs()),
                least_compressed: larger(|it| it.least_compressed, |it| it.normal_force),
                most_compressed: larger(|it| it.most_compressed, |it| -it.normal_force),
                checked_moment: larger(|it| it.checked_moment, |it| it.moment.abs()),
                ..*now
            },
            has_flowed: self.has_flowed || earlier.has_flowed,
        }
    }
}

/// Adds to the statement of a criterion of the base which connection it is about and what fails first.
pub(super) fn annotate(
    criterion: &mut Criterion,
    base: Option<&ConnectedBase>,
    demand: Option<&BaseDemand>,
) {
    let (Some(base), Some(demand), Some(_)) = (base, demand, criterion.value) else {
        return;
    };
    if !criterion.name.starts_with(PREFIX) {
        return;
    }
    let worst = base.worst(demand);
    let text = &mut criterion.statement;
    if base.is_assumed {
        text.push_str(&format!(
            " Nobody has given the base plate: {} is assumed [A].",
            plate_in_words(&base.plate)
        ));
    }
    if worst.ratio() > 1.0 {
        text.push_str(&format!(
            " Of all that the base bears, its resistance is exceeded most in: {}, {:.2} times.",
            worst.failure.name(),
            worst.ratio()
        ));
    }
}

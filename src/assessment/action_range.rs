//! Between which actions the verdict on an impact lies, if what is not known exactly of it differs.
//!
//! Each assumption is changed alone to the ends of its range, and the impact is computed and judged anew. The range therefore
//! holds no combinations: two assumptions that both err on the unsafe side may lead beyond it.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use super::response::{EarlierImpacts, band_properties, input_of_response, respond_and_rest};
use super::{
    Action, Assessment, BaseDemand, ConnectedBase, OUT_OF_PLANE, OVERSTRENGTH, assess, in_capitals,
    missing_in_words,
};
use crate::column::{ColumnProperties, Impact, Model, Report};
use crate::parameters::{Parameters, Value, component_in_words};

/// What is assumed of an impact and its column, and not known exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Assumption {
    /// Speed of the vehicle.
    Speed,
    /// Height of the impact point.
    Height,
    /// Force of the vehicle's front.
    FrontForce,
    /// That a column meets only a part of the force of a front.
    NarrowObject,
    /// Whether the strength grows with the strain rate.
    StrainRate,
    /// Slope of the steel after yield, local buckling, and whether the flanges help a sheared web.
    Hardening,
    /// Yield strength: steel is stronger than its nominal value.
    YieldStrength,
    /// Spring at the top that takes a part of the load.
    TopSpring,
    /// That the base holds the column as its support does, where no connection is given.
    BasePlate,
    /// The model of the column: two bars, or a fibre beam.
    Model,
    /// Direction in which the vehicle travels. It is never varied, and decides where nothing else is varied because of it.
    Direction,
}

/// An action with what is not known and could ask for more.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OpenVerdict {
    /// What has to be done by what is evaluated.
    pub action: Action,
    /// The names of what is not known, each with the action in the worst case.
    pub not_evaluated: Vec<(&'static str, Action)>,
}

impl From<&Assessment> for OpenVerdict {
    fn from(assessment: &Assessment) -> Self {
        let missing = assessment.not_evaluated.iter();
        Self {
            action: assessment.action,
            not_evaluated: missing.map(|it| (it.criterion, it.action)).collect(),
        }
    }
}

/// The impact with one assumption changed.
#[derive(Debug, Clone, PartialEq)]
pub struct Variation {
    /// Which.
    pub assumption: Assumption,
    /// What is assumed instead.
    pub instead: String,
    /// The response.
    pub report: Report,
    /// Hardening of the steel.
    pub hardening_ratio: f64,
    /// Whether the column softens.
    pub softens: bool,
    /// What would have to be done.
    pub action: Action,
    /// The names of what is not known then, each with the action in the worst case.
    pub not_evaluated: Vec<(&'static str, Action)>,
}

/// Between which actions the verdict on one impact lies.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VerdictRange {
    /// The least severe action of the verdict and all variations.
    pub least: Action,
    /// The most severe one, or the worst that what is not known could ask for, where that is more severe.
    pub most: Action,
    /// Whether more than that may have to be done: only in what earlier programs recorded, whose `most` did not reach as far as
    /// what is not known.
    pub at_least: bool,
    /// The assumptions that alone lead to the most severe action, or where none does to more than the verdict, to the least
    /// severe one. None where every variation leads to the verdict, and where only what is not known leads to the most severe one.
    pub decided_by: Vec<Assumption>,
    /// The names of what is not known and could ask for the most severe action; none where the verdict asks for it already.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_evaluated: Vec<String>,
}

/// The range of a verdict with all that was computed for it.
#[derive(Debug, Clone, PartialEq)]
pub struct ActionRange {
    /// Between which actions the verdict lies.
    pub ends: VerdictRange,
    /// All that was computed.
    pub variations: Vec<Variation>,
    /// What could not be varied, and why.
    pub not_varied: Vec<(Assumption, String)>,
}

impl Assumption {
    /// In two words, for a table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Height => "height",
            Self::FrontForce => "front force",
            Self::NarrowObject => "narrow object",
            Self::StrainRate => "strain rate",
            Self::Hardening => "hardening",
            Self::YieldStrength => "yield strength",
            Self::TopSpring => "top spring",
            Self::BasePlate => "base plate",
            Self::Model => "model",
            Self::Direction => "direction",
        }
    }

    /// As a part of a sentence: "decided by the height of the hit".
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Speed => "the speed of the vehicle",
            Self::Height => "the height of the hit",
            Self::FrontForce => "the force of the vehicle's front",
            Self::NarrowObject => "the part of the front that meets the column",
            Self::StrainRate => "the strain rate",
            Self::Hardening => "the hardening of the steel",
            Self::YieldStrength => "the yield strength",
            Self::TopSpring => "the spring at the top",
            Self::BasePlate => "the plate of the base",
            Self::Model => "the model of the column",
            Self::Direction => "the direction of the hit",
        }
    }
}

impl ActionRange {
    /// Computes one response, with its assessment, for each end of the range of each assumption: at most 14. `verdict` is the
    /// assessment of the response of the column with these `properties` to this impact, after the `earlier` ones, if there were any.
    /// Of a damaged column only the assumptions about this impact are varied: how it would have come to its damage on other
    /// assumptions is not known. Of a hit out of the plane of the two bars, nothing is varied, and the range is open upwards. It reaches
    /// the worst that could come of what is not evaluated.
    #[must_use]
    pub fn of(
        parameters: &Parameters,
        properties: &ColumnProperties,
        impact: &Impact,
        earlier: Option<&EarlierImpacts>,
        verdict: &Assessment,
    ) -> Self {
        let verdict = OpenVerdict::from(verdict);
        let direction = parameters.direction();
        let found = Self::of_action(
            parameters,
            properties,
            impact,
            direction,
            earlier,
            &verdict,
            &mut || true,
        );
        // Nothing stops it.
        found.unwrap_or_else(|| Self::of_variations(&verdict, Vec::new(), Vec::new()))
    }

    /// As [`of`](Self::of) this verdict on a hit in this direction \[rad\]; `go_on` is asked before each response, and `None` is the
    /// result once it returns false.
    #[must_use]
    pub fn of_action(
        parameters: &Parameters,
        properties: &ColumnProperties,
        impact: &Impact,
        direction: f64,
        earlier: Option<&EarlierImpacts>,
        verdict: &OpenVerdict,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Option<Self> {
        let (mut variations, mut not_varied) = (Vec::new(), Vec::new());
        if component_in_words(direction).is_some() {
            not_varied.push((Assumption::Direction, OBLIQUE.to_owned()));
            return go_on().then(|| Self::of_variations(verdict, variations, not_varied));
        }
        let case = Case {
            parameters,
            properties,
            impact,
            earlier,
        };
        for (assumption, changed) in case.variations() {
            if !go_on() {
                return None;
            }
            match changed.and_then(|changed| changed.judged(assumption, &case)) {
                Ok(variation) => variations.push(variation),
                Err(reason) => not_varied.push((assumption, reason)),
            }
        }
        Some(Self::of_variations(verdict, variations, not_varied))
    }

    /// Of a verdict with these variations.
    pub(crate) fn of_variations(
        verdict: &OpenVerdict,
        variations: Vec<Variation>,
        not_varied: Vec<(Assumption, String)>,
    ) -> Self {
        let found = || variations.iter().map(|it| it.action);
        let least = found().fold(verdict.action, Action::min);
        let most = found().fold(verdict.action, Action::max);
        let end = match most > verdict.action {
            true => most,
            false => least,
        };
        let mut range = Self {
            ends: VerdictRange {
                least,
                most,
                at_least: false,
                decided_by: Vec::new(),
                not_evaluated: Vec::new(),
            },
            variations,
            not_varied,
        };
        if end != verdict.action {
            range.ends.decided_by = range.leading_to(end);
        } else if range.varies_nothing() {
            range.ends.decided_by = vec![Assumption::Direction];
        }
        range.reach(verdict);
        range
    }

    /// Includes the verdict of another model, which is more severe than the one of which this is the range.
    pub(crate) fn with_another_model(&mut self, verdict: &Assessment) {
        let found = self.variations.iter().map(|it| it.action);
        let most = found.fold(verdict.action, Action::max);
        self.ends.most = most;
        if self.varies_nothing() {
            // The least one is by a component of the hit.
            self.ends.least = verdict.action;
        }
        self.ends.decided_by = self.leading_to(most);
        self.ends.not_evaluated.clear();
        if verdict.action == most {
            self.ends.decided_by.push(Assumption::Model);
        }
        self.reach(&verdict.into());
    }

    /// Includes one more variation of the verdict, or of the one that another model has made of it.
    pub(crate) fn include(&mut self, verdict: &OpenVerdict, variation: Variation) {
        let ends = &mut self.ends;
        let (action, assumption) = (variation.action, variation.assumption);
        let end = if ends.most > verdict.action {
            ends.most
        } else {
            ends.least
        };
        if action > ends.most {
            ends.most = action;
            ends.decided_by = vec![assumption];
            ends.not_evaluated.clear();
        } else if action < ends.least && end == ends.least {
            ends.decided_by = vec![assumption];
        } else if action == end
            && action != verdict.action
            && !ends.decided_by.contains(&assumption)
        {
            ends.decided_by.push(assumption);
        }
        ends.least = ends.least.min(action);
        self.variations.push(variation);
        self.reach(verdict);
    }

    /// The assumptions that lead to this action.
    fn leading_to(&self, action: Action) -> Vec<Assumption> {
        let mut found = Vec::new();
        for variation in self.variations.iter().filter(|it| it.action == action) {
            if !found.contains(&variation.assumption) {
                found.push(variation.assumption);
            }
        }
        found
    }

    /// Whether nothing is varied because of the direction of the hit.
    fn varies_nothing(&self) -> bool {
        let mut not_varied = self.not_varied.iter();
        self.variations.is_empty() && not_varied.any(|(it, _)| *it == Assumption::Direction)
    }

    /// Extends the range to the worst that could come of what is not known beside this verdict and its variations.
    fn reach(&mut self, verdict: &OpenVerdict) {
        // However the verdict was found, nobody knows to what a slightly different hit would lead.
        let of_others = (OUT_OF_PLANE[0], Action::Evacuate);
        let of_others = self.varies_nothing().then_some(&of_others);
        let of_variations = self.variations.iter().flat_map(|it| &it.not_evaluated);
        let missing = verdict.not_evaluated.iter().chain(of_variations);
        let missing: Vec<_> = missing.chain(of_others).collect();
        let worst = missing.iter().map(|(_, action)| *action).max();
        let Some(worst) = worst.filter(|it| *it > verdict.action && *it >= self.ends.most) else {
            return;
        };
        let ends = &mut self.ends;
        if worst > ends.most {
            ends.most = worst;
            ends.decided_by.clear();
        }
        for (name, action) in missing {
            let is_named = ends.not_evaluated.iter().any(|it| it == name);
            if *action == worst && !is_named {
                ends.not_evaluated.push((*name).to_owned());
            }
        }
    }

    /// The variations of one assumption.
    pub fn of_assumption(&self, assumption: Assumption) -> impl Iterator<Item = &Variation> {
        let all = self.variations.iter();
        all.filter(move |it| it.assumption == assumption)
    }

    /// The band of the steel: the weakest and the strongest real column with this yield strength, see [`band_properties`];
    /// `None` if one of their responses failed.
    #[must_use]
    pub fn band(&self) -> Option<[&Variation; 2]> {
        let mut ends = self.of_assumption(Assumption::Hardening);
        Some([ends.next()?, ends.next()?])
    }
}

impl VerdictRange {
    /// What decides, as a part of a sentence: `the height of the hit or the yield strength`; empty where every variation leads to
    /// the verdict.
    #[must_use]
    pub fn decided_by_in_words(&self) -> String {
        let assumptions = self.decided_by.iter();
        let mut all: Vec<_> = assumptions.map(|it| it.in_words().to_owned()).collect();
        all.extend(self.not_evaluated_in_words());
        match all.as_slice() {
            [] => String::new(),
            [one] => one.clone(),
            [rest @ .., last] => format!("{} or {last}", rest.join(", ")),
        }
    }

    /// What is not known and could ask for the most severe action, as a part of a sentence; `None` where there is nothing.
    #[must_use]
    pub fn not_evaluated_in_words(&self) -> Option<String> {
        let names = self.not_evaluated.iter();
        let names: Vec<_> = names.map(|it| missing_in_words(it)).collect();
        (!names.is_empty()).then(|| format!("missing data: {}", names.join("; ")))
    }
}

/// `RESTRICT to EVACUATE, decided by the height of the hit`.
impl Display for VerdictRange {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let words = [self.least, self.most].map(in_capitals);
        let [least, most] = words.each_ref().map(String::as_str);
        let decided_by = self.decided_by_in_words();
        f.write_str(&range_in_words(least, most, self.at_least, &decided_by))
    }
}

impl Display for ActionRange {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.ends.fmt(f)
    }
}

/// A range in words, from the words for its ends.
pub(crate) fn range_in_words(least: &str, most: &str, at_least: bool, decided_by: &str) -> String {
    let at_least = if at_least { "at least " } else { "" };
    match least == most {
        true if decided_by.is_empty() => format!("{at_least}{most} within all ranges"),
        true => format!("{at_least}{most}; no assumption was varied, because of {decided_by}"),
        false => format!("{least} to {at_least}{most}, decided by {decided_by}"),
    }
}

/// The impact as it is judged.
struct Case<'a> {
    parameters: &'a Parameters,
    properties: &'a ColumnProperties,
    impact: &'a Impact,
    earlier: Option<&'a EarlierImpacts>,
}

/// The impact with one assumption changed.
struct Changed {
    instead: String,
    parameters: Parameters,
    properties: ColumnProperties,
    impact: Impact,
    /// The steel has the largest strength that it may have: the forces into the base contain its overstrength. The base bears no
    /// more than that of the verdict, whose plate may be assumed of the same steel.
    has_overstrength: bool,
}

impl Changed {
    fn judged(self, assumption: Assumption, case: &Case<'_>) -> Result<Variation, String> {
        let duration = self.parameters.response_duration();
        let (report, rest) = match case.earlier {
            Some(earlier) => earlier.respond_and_rest(&self.properties, &self.impact, duration),
            None => respond_and_rest(&self.properties, &self.impact, duration),
        }
        .map_err(|fault| fault.to_string())?;
        let model =
            Model::new(&self.properties.before(&self.impact)).map_err(|fault| fault.to_string())?;
        let mut input = input_of_response(
            &self.parameters,
            &model,
            &self.impact,
            &report,
            rest.as_ref(),
        )
        .map_err(|fault| fault.to_string())?;
        if self.has_overstrength {
            input.base = ConnectedBase::of(case.parameters).ok();
            input.base_demand = Some(BaseDemand::with_overstrength(&report));
        }
        let earlier = case.earlier.and_then(|it| it.base.as_ref());
        input.base_demand = input.base_demand.map(|demand| demand.after(earlier));
        let assessment = assess(&input);
        Ok(Variation {
            assumption,
            instead: self.instead,
            hardening_ratio: self.properties.hardening_ratio,
            softens: self.properties.softening.is_some(),
            report,
            not_evaluated: OpenVerdict::from(&assessment).not_evaluated,
            action: assessment.action,
        })
    }
}

type Found = (Assumption, Result<Changed, String>);

/// The assumptions on which the damage of earlier impacts depends, too.
const OF_THE_DAMAGE: [Assumption; 5] = [
    Assumption::Height,
    Assumption::Hardening,
    Assumption::YieldStrength,
    Assumption::TopSpring,
    Assumption::BasePlate,
];

/// Why nothing is varied.
const OBLIQUE: &str =
    "the two bars see only a part of a hit out of their plane, and the fibre beam is not varied";

/// Why they are not varied.
pub(crate) const DAMAGED: &str =
    "the column was damaged before, and the damage on another assumption is not known";

impl Case<'_> {
    fn variations(&self) -> Vec<Found> {
        let mut all = Vec::new();
        all.extend(self.speeds());
        if self.earlier.is_some_and(EarlierImpacts::have_damaged) {
            all.extend(self.fronts());
            all.extend(self.narrow_object());
            all.push((Assumption::StrainRate, self.strain_rate()));
            all.extend(OF_THE_DAMAGE.map(|it| (it, Err(DAMAGED.to_owned()))));
            return all;
        }
        all.extend(self.heights());
        all.extend(self.fronts());
        all.extend(self.narrow_object());
        all.push((Assumption::StrainRate, self.strain_rate()));
        all.extend(self.hardening());
        all.push((Assumption::YieldStrength, self.yield_strength()));
        all.extend(self.top_spring());
        all.extend(self.base_plate());
        all
    }

    fn with(&self, instead: String, properties: ColumnProperties, impact: Impact) -> Changed {
        Changed {
            instead,
            parameters: self.parameters.clone(),
            properties,
            impact,
            has_overstrength: false,
        }
    }

    /// With other parameters of the column.
    fn with_parameters<const N: usize>(
        &self,
        instead: String,
        changes: [(&str, Value); N],
    ) -> Result<Changed, String> {
        let changed = self.parameters.with_changes(changes);
        let parameters = changed.map_err(|faults| faults.in_one_line())?;
        Ok(Changed {
            instead,
            // The event may have named another height than the parameters.
            properties: ColumnProperties {
                length_below: self.properties.length_below,
                length_above: self.properties.length_above,
                ..parameters.column_properties()
            },
            parameters,
            impact: *self.impact,
            has_overstrength: false,
        })
    }

    fn speeds(&self) -> impl Iterator<Item = Found> {
        let part = self.parameters.settings().assessment.range_velocity;
        both_ends(part).map(move |end| {
            let velocity = self.impact.velocity * (1.0 + end);
            let impact = Impact {
                velocity,
                ..*self.impact
            };
            let instead = format!("{velocity:.2} m/s");
            let changed = self.with(instead, *self.properties, impact);
            (Assumption::Speed, Ok(changed))
        })
    }

    fn heights(&self) -> impl Iterator<Item = Found> {
        let p = self.properties;
        let distance = self.parameters.settings().assessment.range_height;
        both_ends(distance).map(move |end| {
            let properties = ColumnProperties {
                length_below: p.length_below + end,
                length_above: p.length_above - end,
                ..*p
            };
            let instead = format!("{:.2} m above the base", properties.length_below);
            let changed = match properties.length_below > 0.0 && properties.length_above > 0.0 {
                true => Ok(self.with(instead, properties, *self.impact)),
                false => Err(format!("{instead} is not on the column")),
            };
            (Assumption::Height, changed)
        })
    }

    fn fronts(&self) -> impl Iterator<Item = Found> {
        let part = self.parameters.settings().assessment.range_front;
        let vehicle = self.impact.vehicle;
        let both = vehicle.map(|vehicle| {
            both_ends(part).map(move |end| {
                let scaled = vehicle.with_force_factor(1.0 + end);
                let changed = scaled.map_err(|fault| fault.to_string()).map(|vehicle| {
                    let impact = Impact {
                        vehicle: Some(vehicle),
                        ..*self.impact
                    };
                    let instead = format!("{:.2} times the force", 1.0 + end);
                    self.with(instead, *self.properties, impact)
                });
                (Assumption::FrontForce, changed)
            })
        });
        both.into_iter().flatten()
    }

    /// The whole front, where the column is assumed to meet a part of it.
    fn narrow_object(&self) -> Option<Found> {
        let is_assumed = self.parameters.settings().vehicle.narrow_object;
        if !is_assumed || self.impact.vehicle.is_none() {
            return None;
        }
        let changed = match self.parameters.impact().vehicle == self.impact.vehicle {
            true => self
                .with_parameters(
                    "the whole front".to_owned(),
                    [("vehicle.narrow_object", false.into())],
                )
                .map(|changed| Changed {
                    impact: Impact {
                        vehicle: changed.parameters.impact().vehicle,
                        ..*self.impact
                    },
                    properties: *self.properties,
                    ..changed
                }),
            false => Err("the vehicle is not that of the parameters".to_owned()),
        };
        Some((Assumption::NarrowObject, changed))
    }

    fn strain_rate(&self) -> Result<Changed, String> {
        let (law, instead) = match self.properties.rate.is_some() {
            true => ("none", "no increase of the strength"),
            false => ("logarithmic", "f_y + 6 MPa ln(e / 5e-5)"),
        };
        let changed = self.with_parameters(instead.to_owned(), [("rate.law", law.into())])?;
        Ok(Changed {
            properties: ColumnProperties {
                rate: changed.properties.rate,
                ..*self.properties
            },
            ..changed
        })
    }

    fn hardening(&self) -> impl Iterator<Item = Found> {
        band_properties(self.properties)
            .into_iter()
            .map(move |properties| {
                let buckling = match properties.softening.is_some() {
                    true => "with buckling",
                    false => "no buckling",
                };
                let instead = format!("{:.1} %, {buckling}", 100.0 * properties.hardening_ratio);
                let changed = self.with(instead, properties, *self.impact);
                (Assumption::Hardening, Ok(changed))
            })
    }

    /// As much stronger than its nominal value as the overstrength says.
    fn yield_strength(&self) -> Result<Changed, String> {
        let given = self.parameters.settings().resistance.moment;
        if given > 0.0 {
            return Err("resistance.moment is given as a number".to_owned());
        }
        let steel = self.parameters.steel();
        let strength = OVERSTRENGTH * steel.yield_strength;
        let changed = self.with_parameters(
            format!("{:.0} MPa", 1e-6 * strength),
            [("steel.yield_strength", strength.into())],
        )?;
        Ok(Changed {
            // The plate of the base is not of the same piece of steel.
            properties: ColumnProperties {
                base: self.properties.base,
                base_connection: self.properties.base_connection,
                ..changed.properties
            },
            has_overstrength: true,
            ..changed
        })
    }

    fn top_spring(&self) -> Option<Found> {
        let has_spring = self.parameters.settings().top.spring_stiffness > 0.0;
        has_spring.then(|| {
            let changes = [("top.spring_stiffness", 0.0.into())];
            let changed = self.with_parameters("no spring".to_owned(), changes);
            (Assumption::TopSpring, changed)
        })
    }

    /// The plate that is assumed where none is given: in the verdict it is judged, and the base holds the column without limit.
    fn base_plate(&self) -> Option<Found> {
        let base = ConnectedBase::of(self.parameters).ok()?;
        (base.is_assumed && base.bears_moment).then(|| {
            let instead = "assumed plate [A]".to_owned();
            let properties = self.properties.on_plate(base.resistance);
            let changed = self.with(instead, properties, *self.impact);
            (Assumption::BasePlate, Ok(changed))
        })
    }
}

/// Both ends of a range; none where it has no width.
pub(crate) fn both_ends(width: f64) -> impl Iterator<Item = f64> {
    [-width, width].into_iter().filter(|end| *end != 0.0)
}

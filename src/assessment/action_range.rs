//! Between which actions the verdict on an impact lies, if what is not known exactly of it differs.
//!
//! Each assumption is changed alone to the ends of its range, and the impact is computed and judged anew. The range therefore
//! holds no combinations: two assumptions that both err on the unsafe side may lead beyond it.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use super::response::{EarlierImpacts, band_properties, input_of_response, respond_and_rest};
use super::{Action, Assessment, BaseDemand, ConnectedBase, OVERSTRENGTH, assess, in_capitals};
use crate::column::{ColumnProperties, Impact, Model, Report};
use crate::parameters::{Parameters, Value};

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
    /// Slope of the steel after yield, and local buckling.
    Hardening,
    /// Yield strength: steel is stronger than its nominal value.
    YieldStrength,
    /// Spring at the top that takes a part of the load.
    TopSpring,
    /// That the base holds the column as its support does, where no connection is given.
    BasePlate,
    /// The model of the column: two bars, or a fibre beam.
    Model,
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
    /// At least, because a criterion could not be evaluated.
    pub at_least: bool,
}

/// Between which actions the verdict on one impact lies.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VerdictRange {
    /// The least severe action of the verdict and all variations.
    pub least: Action,
    /// The most severe one.
    pub most: Action,
    /// Whether more than that may have to be done, because a criterion could not be evaluated.
    pub at_least: bool,
    /// The assumptions that alone lead to the most severe action, or where none does to more than the verdict, to the least
    /// severe one. None where every variation leads to the verdict.
    pub decided_by: Vec<Assumption>,
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
        }
    }
}

impl ActionRange {
    /// Computes one response, with its assessment, for each end of the range of each assumption: at most 14. `verdict` is the
    /// assessment of the response of the column with these `properties` to this impact, after the `earlier` ones, if there were any.
    /// Of a damaged column only the assumptions about this impact are varied: how it would have come to its damage on other
    /// assumptions is not known.
    #[must_use]
    pub fn of(
        parameters: &Parameters,
        properties: &ColumnProperties,
        impact: &Impact,
        earlier: Option<&EarlierImpacts>,
        verdict: &Assessment,
    ) -> Self {
        let verdict = (verdict.action, verdict.at_least);
        let mut range = Self::begin(verdict);
        let case = Case {
            parameters,
            properties,
            impact,
            earlier,
        };
        // Nothing stops it.
        range.vary(&case, &mut || true);
        range.summarise(verdict.0);
        range
    }

    /// As [`of`](Self::of) a verdict with this action, which is a lower bound or not; `go_on` is asked before each response, and
    /// `None` is the result once it returns false.
    #[must_use]
    pub fn of_action(
        parameters: &Parameters,
        properties: &ColumnProperties,
        impact: &Impact,
        earlier: Option<&EarlierImpacts>,
        verdict: (Action, bool),
        go_on: &mut dyn FnMut() -> bool,
    ) -> Option<Self> {
        let mut range = Self::begin(verdict);
        let case = Case {
            parameters,
            properties,
            impact,
            earlier,
        };
        if !range.vary(&case, go_on) {
            return None;
        }
        range.summarise(verdict.0);
        Some(range)
    }

    fn begin((action, at_least): (Action, bool)) -> Self {
        Self {
            ends: VerdictRange {
                least: action,
                most: action,
                at_least,
                decided_by: Vec::new(),
            },
            variations: Vec::new(),
            not_varied: Vec::new(),
        }
    }

    /// Computes the variations; false once `go_on` returns false.
    fn vary(&mut self, case: &Case<'_>, go_on: &mut dyn FnMut() -> bool) -> bool {
        for (assumption, changed) in case.variations() {
            if !go_on() {
                return false;
            }
            match changed.and_then(|changed| changed.judged(assumption, case)) {
                Ok(variation) => self.variations.push(variation),
                Err(reason) => self.not_varied.push((assumption, reason)),
            }
        }
        true
    }

    fn summarise(&mut self, verdict: Action) {
        let range = &mut self.ends;
        let found = || self.variations.iter().map(|it| it.action);
        range.least = found().fold(verdict, Action::min);
        range.most = found().fold(verdict, Action::max);
        let is_open = range.at_least || self.variations.iter().any(|it| it.at_least);
        range.at_least = is_open && range.most < Action::Evacuate;
        let end = match range.most > verdict {
            true => range.most,
            false => range.least,
        };
        if end == verdict {
            return;
        }
        for variation in &self.variations {
            let reaches = variation.action == end;
            if reaches && !range.decided_by.contains(&variation.assumption) {
                range.decided_by.push(variation.assumption);
            }
        }
    }

    /// Includes the verdict of another model, which is more severe than the one of which this is the range.
    pub(crate) fn with_another_model(&mut self, verdict: &Assessment) {
        let range = &mut self.ends;
        if verdict.action < range.most {
            return;
        }
        if verdict.action > range.most {
            range.decided_by.clear();
        }
        range.most = verdict.action;
        range.at_least = verdict.at_least && range.most < Action::Evacuate;
        range.decided_by.push(Assumption::Model);
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
        let mut words = String::new();
        for (index, assumption) in self.decided_by.iter().enumerate() {
            words += match index {
                0 => "",
                _ if index + 1 == self.decided_by.len() => " or ",
                _ => ", ",
            };
            words += assumption.in_words();
        }
        words
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
        true => format!("{at_least}{most} within all ranges"),
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
            action: assessment.action,
            at_least: assessment.at_least,
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

/// Why they are not varied.
const DAMAGED: &str =
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
        ends(part).map(move |end| {
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
        ends(distance).map(move |end| {
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
            ends(part).map(move |end| {
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
fn ends(width: f64) -> impl Iterator<Item = f64> {
    [-width, width].into_iter().filter(|end| *end != 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::ImpactEvaluation;
    use super::*;
    use crate::parameters::parse_override;

    fn evaluated(overrides: &[&str]) -> ImpactEvaluation {
        let overrides: Vec<_> = overrides.iter().map(|it| parse_override(it)).collect();
        let parameters = Parameters::load(&[], &overrides).expect("parameters");
        let (properties, impact) = (parameters.column_properties(), parameters.impact());
        let ended = respond_and_rest(&properties, &impact, parameters.response_duration())
            .expect("a response");
        ImpactEvaluation::complete(&parameters, &properties, &impact, ended).expect("an evaluation")
    }

    /// Each end of the range is an action to which the verdict or a variation leads, and what decides it leads there alone.
    #[test]
    fn the_range_of_a_verdict_holds_it_and_names_what_decides() {
        let real = [
            "section.name:=HEB220",
            "steel.grade:=S355",
            "vehicle.name:=mid_car",
        ];
        let hits: [&[&str]; 4] = [
            &[],
            &["impact.velocity:=5.0"],
            &["geometry.length_below:=0.5", "geometry.length_above:=3.5"],
            &["support.base:=pinned", "top.load:=1.0e6"],
        ];
        let mut wide = 0;
        for hit in hits {
            let evaluation = evaluated(&[&real[..], hit].concat());
            let verdict = evaluation.assessment.expect("an assessment").action;
            let range = evaluation.range.expect("a range");
            assert!(
                range.ends.least <= verdict && verdict <= range.ends.most,
                "{range}"
            );
            let found: Vec<_> = range.variations.iter().map(|it| it.action).collect();
            for end in [range.ends.least, range.ends.most] {
                assert!(end == verdict || found.contains(&end), "{range}");
            }
            let end = if range.ends.most > verdict {
                range.ends.most
            } else {
                range.ends.least
            };
            assert_eq!(range.ends.decided_by.is_empty(), end == verdict, "{range}");
            for assumption in &range.ends.decided_by {
                assert!(range.of_assumption(*assumption).any(|it| it.action == end));
            }
            wide += usize::from(range.ends.least < range.ends.most);
            assert_eq!(range.not_varied, []);
        }
        assert!(wide > 0);
    }

    #[test]
    fn what_cannot_be_varied_is_named_with_its_reason() {
        let range = evaluated(&[
            "geometry.length_below:=0.3",
            "assessment.range_height:=0.4",
            "resistance.moment:=3.0e5",
        ])
        .range
        .expect("a range");
        let reason = |assumption| {
            let mut all = range.not_varied.iter().filter(|(it, _)| *it == assumption);
            all.next().map(|(_, reason)| reason.as_str())
        };
        let height = reason(Assumption::Height);
        assert_eq!(height, Some("-0.10 m above the base is not on the column"));
        assert_eq!(range.of_assumption(Assumption::Height).count(), 1);
        let strength = reason(Assumption::YieldStrength);
        assert_eq!(strength, Some("resistance.moment is given as a number"));
    }

    /// Without a width of a range nothing of it is varied.
    #[test]
    fn a_range_without_width_is_not_varied() {
        let range = evaluated(&[
            "assessment.range_velocity:=0.0",
            "assessment.range_height:=0.0",
            "assessment.range_front:=0.0",
        ])
        .range
        .expect("a range");
        let varied: Vec<_> = range.variations.iter().map(|it| it.assumption).collect();
        for assumption in [
            Assumption::Speed,
            Assumption::Height,
            Assumption::FrontForce,
        ] {
            assert!(!varied.contains(&assumption));
        }
    }
}

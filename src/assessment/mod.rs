//! Assessment of a column after an impact: criteria with value, limit, margin, edition and tag, and one action.
//!
//! Every number that may decide over people carries where it comes from: [`Provenance`](crate::parameters::Provenance). `docs/assessment.md` lists the criteria.
//!
//! ```
//! use column_twin::assessment::{AssessmentInput, ResidualCapacity, Action, assess};
//! use column_twin::column::{Model, State};
//! use column_twin::parameters::Parameters;
//!
//! let parameters = Parameters::default();
//! let model = Model::new(&parameters.column_properties())?;
//! let undamaged = State::at_rest(&model);
//! let remaining = ResidualCapacity::compute(&parameters, &model, Some(&undamaged))?;
//! let assessment = assess(&AssessmentInput::of_state(&parameters, &model, &undamaged, remaining));
//! assert_eq!(assessment.action, Action::None);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - action_range.rs: Between which actions the verdict on an impact lies, if what is not known exactly of it differs
// - base.rs: The base of a column in an assessment: what it has to bear, what its connection bears, and which part fails first
// - criteria.rs: The criteria as data: names, editions, tags, actions; and how each is evaluated
// - criterion.rs: What a criterion says, and what has to be done if it is exceeded
// - definition.rs: What a criterion consists of, without values
// - effective.rs: The value that takes the place of a parameter whose 0 stands for what follows from others
// - evaluation.rs: One impact with all that an engineer needs to judge it
// - input.rs: What an assessment judges, as plain data
// - prepared.rs: The assessment of many impacts on one column: what does not depend on the impact is computed once, and only
//   the criteria that decide are evaluated, without their texts
// - remaining.rs: The residual axial capacity of a column, beside the buckling resistances of the code
// - response.rs: The response of a column to an impact, and what its assessment depends on
// - rotation_limits.rs: Limits of the plastic rotation of a hinge in an I or H section
// - section_class.rs: The class of a section: whether its plates buckle before it can rotate (EN 1993-1-1:2005, 5.5 and table
//   5.2, as the open-source library metku of Tampere University states it in `eurocodes/en1993/en1993_1_1.py`)
// - utilisation.rs: How close a column has come to yielding

mod action_range;
#[cfg(test)]
mod action_range_tests;
mod base;
mod criteria;
mod criterion;
mod definition;
mod effective;
mod evaluation;
mod input;
mod prepared;
mod remaining;
mod response;
mod rotation_limits;
mod section_class;
#[cfg(test)]
mod tests;
mod utilisation;

use serde::Serialize;

pub use action_range::{ActionRange, Assumption, OpenVerdict, Variation, VerdictRange};
pub(crate) use action_range::{DAMAGED, both_ends, range_in_words};
pub use base::{BaseDemand, ConnectedBase, OVERSTRENGTH};
use criteria::DEFINITIONS;
#[cfg(feature = "cli")]
pub(crate) use criterion::PART_OF_LENGTH as UNIT_OF_BOW;
use criterion::quantity;
pub use criterion::{Action, Criterion, NOT_ASSESSED, PARTIAL_FACTOR};
use definition::{Definition, NotEvaluated, Relation};
pub use evaluation::ImpactEvaluation;
pub use input::{
    AssessedImpact, AssessedShear, AssessmentInput, OtherModel, VerdictLoad,
    largest_plastic_rotation,
};
pub use prepared::{AssessedResponse, PreparedAssessment, Verdict};
pub use remaining::{
    ResidualCapacity, buckling_curve, buckling_resistances, dimensions_by_numbers, imperfection,
    section_dimensions,
};
pub use response::{
    EarlierImpacts, HARDENING_BAND, band_properties, input_of_response, observe_and_rest,
    observe_from, respond_and_rest,
};
pub use rotation_limits::{
    CLASS_3_ROTATION, HingeSlenderness, RotationLimits, ULTIMATE_ROTATION, ULTIMATE_SHEAR_ANGLE,
    rotation_before_buckling,
};
pub use section_class::{SectionClass, SectionClassification, section_class};
pub use utilisation::{Utilisation, UtilisedPart};

use crate::column::BaseFailure;
use crate::parameters::{AssumedInput, LoadBasis, component_in_words};

/// The criterion that decides whatever the user chooses.
const ALWAYS_DECIDES: &str = "collapse";

/// What the two bars do not evaluate of a hit out of their plane, by its name and its title.
const OUT_OF_PLANE: [&str; 2] = ["out_of_plane", "Movement out of the plane of the two bars"];

/// What the fibre beam does not know, beside every verdict of it.
const OF_THE_BEAM: &str = "The fibre beam knows neither connections nor local buckling; its plastic rotation is that of its \
                           cross-sections at rest, over three depths of the section.";

/// The assessment of one column.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Assessment {
    /// What has to be done; at least, see [`at_least`](Self::at_least).
    pub action: Action,
    /// Whether more may have to be done, because a criterion that decides and is more severe could not be evaluated.
    pub at_least: bool,
    /// The criteria that decide and for which data are missing, the most severe first.
    pub not_evaluated: Vec<MissingData>,
    /// Name of the criterion that decides: of the most severe ones that are exceeded the first, or the one closest to its
    /// limit where none is exceeded.
    pub deciding_criterion: &'static str,
    /// Why that has to be done, in plain words, as a part of a sentence.
    #[serde(skip)]
    pub cause: &'static str,
    /// What has to be done as an imperative, the cause in plain words, the number with its limit, and what the model does not
    /// know. It begins with `At least` where more may have to be done.
    pub reason: String,
    /// Which load `N` is, as a sentence, which is a part of the reason.
    pub load: String,
    /// Which load `top.load` is.
    pub load_basis: LoadBasis,
    /// Every criterion.
    pub criteria: Vec<Criterion>,
    /// What has to be done, without the action that is a lower bound, and why, each as sentences.
    #[serde(skip)]
    finding: [String; 2],
    /// What holds a column that stands and does not bear its load by itself, as a sentence behind a space, or nothing.
    #[serde(skip)]
    held: String,
    /// The load, and what the model does not know.
    #[serde(skip)]
    limits: String,
    /// What the reason says beside the finding.
    #[serde(skip)]
    reservations: String,
}

/// What is not known and could ask for more.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MissingData {
    /// Its name: that of the criterion, or of the parameter, or `out_of_plane`.
    pub criterion: &'static str,
    /// What engineers call it, as in [`Criterion::title`].
    #[serde(skip)]
    pub title: &'static str,
    /// What would have to be done in the worst case.
    pub action: Action,
    /// What is missing, and what to give.
    pub needs: String,
    /// What kind of thing it is.
    #[serde(skip)]
    pub kind: MissingKind,
}

/// What is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MissingKind {
    /// A criterion that decides and could not be evaluated for want of data.
    Criterion,
    /// An input that nobody has given: everything was evaluated with an assumed one.
    Input,
    /// The part of the motion that the two bars do not have.
    OutOfPlane,
}

impl Assessment {
    /// What has to be done, in capitals, and the reason.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self.at_least {
            true => self.reason.clone(),
            false => format!("{}: {}", in_capitals(self.action), self.reason),
        }
    }

    /// What stands before everything else, in two lines: what has to be done, in capitals, and why, with the number that decides and its
    /// limit.
    #[must_use]
    pub fn first_lines(&self) -> [String; 2] {
        let [what, why] = &self.finding;
        let bound = if self.at_least { AT_LEAST } else { "" };
        let action = in_capitals(self.action);
        [format!("{bound}{action}: {what}"), why.clone()]
    }

    /// Takes the verdict of the fibre beam on the same impact where it is more severe, with its reason and its deciding criterion;
    /// `because` says why it counts, as a part of a sentence. Returns whether it did.
    pub(crate) fn yield_to(&mut self, beam: &Self, because: &str) -> bool {
        if beam.action <= self.action {
            return false;
        }
        let deciding = beam
            .criteria
            .iter()
            .find(|it| it.name == beam.deciding_criterion);
        let Some(deciding) = deciding else {
            return false;
        };
        self.criteria = self.worse_criteria(beam);
        let why = format!(
            "Cause, by the fibre beam: {}.{}{} The fibre beam counts because {because}; the two bars alone lead to {}.",
            beam.cause,
            numbers(deciding),
            beam.held,
            self.action
        );
        self.finding = [capitalised(beam.action.order()), why];
        self.limits = format!(" {} {OF_THE_BEAM}", beam.load);
        self.cause = beam.cause;
        self.action = beam.action;
        self.not_evaluated.clone_from(&beam.not_evaluated);
        self.deciding_criterion = deciding.name;
        self.compose();
        true
    }

    /// Each criterion by the model that finds less margin: that of this assessment, or the fibre beam, which says so.
    pub(crate) fn worse_criteria(&self, beam: &Self) -> Vec<Criterion> {
        let worse = |(own, of_beam): (&Criterion, &Criterion)| {
            let exceeds_alone = of_beam.exceeded == Some(true) && own.exceeded != Some(true);
            let has_less = own.margin.is_none() || of_beam.margin < own.margin;
            match of_beam.margin.is_some() && (has_less || exceeds_alone) {
                true => Criterion {
                    statement: format!("By the fibre beam: {}", of_beam.statement),
                    ..of_beam.clone()
                },
                false => own.clone(),
            }
        };
        self.criteria
            .iter()
            .zip(&beam.criteria)
            .map(worse)
            .collect()
    }

    /// The same beside a model that has seen all of a hit out of the plane of the two bars, and that finds nothing more severe.
    pub(crate) fn seen_in_space(&mut self) {
        self.not_evaluated
            .retain(|it| it.kind != MissingKind::OutOfPlane);
        self.compose();
    }

    /// Puts the reason together, from what was found and what is not known.
    fn compose(&mut self) {
        self.at_least = self.not_evaluated.iter().any(|it| it.action > self.action);
        let bound = match self.at_least {
            true => format!("{AT_LEAST}{}: ", in_capitals(self.action)),
            false => String::new(),
        };
        self.reservations = missing_data(&self.not_evaluated) + &self.limits;
        let [what, why] = &self.finding;
        self.reason = format!("{bound}{what} {why}{}", self.reservations);
    }

    /// What the reason says beside the finding that decides: what was not evaluated and what is not known.
    #[must_use]
    pub fn reservations(&self) -> &str {
        &self.reservations
    }
}

/// How the reason of an action begins that is a lower bound; the action follows.
pub const AT_LEAST: &str = "At least ";

fn in_capitals(action: Action) -> String {
    action.name().to_uppercase()
}

/// Evaluates every criterion. Criteria without the data that they need are listed with the reason.
#[must_use]
pub fn assess(input: &AssessmentInput) -> Assessment {
    let mut choice = Choice::default();
    let mut criteria = Vec::with_capacity(DEFINITIONS.len());
    let mut not_evaluated = Vec::new();
    for (index, definition) in DEFINITIONS.iter().enumerate() {
        let decides = decides(definition, &input.deciding);
        let measured = measured(definition, input);
        match &measured {
            Ok(measured) if decides => choice.consider(index, measured),
            Err(NotEvaluated::Missing(needs)) if decides => not_evaluated.push(MissingData {
                criterion: definition.name,
                title: definition.title,
                action: definition.action,
                needs: needs.to_string(),
                kind: MissingKind::Criterion,
            }),
            _ => (),
        }
        let mut made = criterion(definition, decides, measured);
        base::annotate(&mut made, input.base.as_ref(), input.base_demand.as_ref());
        criteria.push(made);
    }
    let assumed = input.assumed.iter();
    not_evaluated.extend(assumed.map(|(input, needs)| MissingData {
        criterion: input.name(),
        title: input.title(),
        action: Action::Evacuate,
        needs: needs.clone(),
        kind: MissingKind::Input,
    }));
    let direction = input.impact.map_or(0.0, |impact| impact.direction);
    let [name, title] = OUT_OF_PLANE;
    not_evaluated.extend(component_in_words(direction).map(|component| MissingData {
        criterion: name,
        title,
        action: Action::Evacuate,
        needs: format!("{component}; the fibre beam sees all of it (beam.mode)"),
        kind: MissingKind::OutOfPlane,
    }));
    not_evaluated.sort_by_key(|missing| std::cmp::Reverse(missing.action));
    let (action, deciding) = (choice.action(), &criteria[choice.deciding()]);
    let cause = cause(input, deciding);
    let load = input.load.in_words(&input.remaining);
    let mut limits = format!(" {load}");
    let mut held = String::new();
    if !(input.collapsed || input.fractured) {
        limits += &axes(input);
        held = input.load.words_of_what_holds(&input.remaining);
    }
    let [what, why] = finding(input, action, cause, deciding);
    let mut assessment = Assessment {
        action,
        at_least: false,
        not_evaluated,
        deciding_criterion: deciding.name,
        cause,
        reason: String::new(),
        finding: [what, why + &held],
        held,
        load,
        load_basis: input.load.basis,
        criteria,
        limits,
        reservations: String::new(),
    };
    assessment.compose();
    assessment
}

/// Whether a criterion decides if the user has chosen the criteria `chosen`.
fn decides(definition: &Definition, chosen: &[String]) -> bool {
    definition.name == ALWAYS_DECIDES || chosen.iter().any(|name| name == definition.name)
}

/// A criterion in numbers.
#[derive(Debug, Clone, Copy)]
struct Measured {
    value: f64,
    limit: f64,
    margin: f64,
    exceeded: bool,
}

fn measured(definition: &Definition, input: &AssessmentInput) -> Result<Measured, NotEvaluated> {
    let (value, limit) = (definition.evaluate)(input)?;
    let sign = match definition.relation {
        Relation::AtMost => 1.0,
        Relation::AtLeast => -1.0,
    };
    let margin = if limit == 0.0 {
        0.0 - sign * value
    } else {
        sign * (limit - value) / limit
    };
    Ok(Measured {
        value,
        limit,
        margin,
        // A NaN exceeds every limit.
        exceeded: margin.is_nan() || margin < 0.0,
    })
}

/// Which of the criteria that decide is the one that does: of the most severe ones that are exceeded the first, or the one
/// closest to its limit where none is exceeded.
#[derive(Debug, Clone, Copy, Default)]
struct Choice {
    exceeded: Option<usize>,
    closest: Option<(usize, f64)>,
}

impl Choice {
    /// Takes the next criterion that decides, with its index among the definitions.
    fn consider(&mut self, index: usize, measured: &Measured) {
        let action = DEFINITIONS[index].action;
        if measured.exceeded
            && self
                .exceeded
                .is_none_or(|before| action > DEFINITIONS[before].action)
        {
            self.exceeded = Some(index);
        }
        if measured.limit != 0.0
            && self
                .closest
                .is_none_or(|(_, margin)| measured.margin.total_cmp(&margin).is_lt())
        {
            self.closest = Some((index, measured.margin));
        }
    }

    fn action(&self) -> Action {
        self.exceeded
            .map_or(Action::None, |index| DEFINITIONS[index].action)
    }

    /// The index of the criterion that decides; the first one of all where none has a limit.
    fn deciding(&self) -> usize {
        let closest = || self.closest.map(|(index, _)| index);
        self.exceeded.or_else(closest).unwrap_or(0)
    }
}

fn criterion(
    definition: &Definition,
    decides: bool,
    measured: Result<Measured, NotEvaluated>,
) -> Criterion {
    let numbers = measured.as_ref().ok();
    Criterion {
        name: definition.name,
        title: definition.title,
        cause: definition.cause,
        edition: definition.edition,
        tag: definition.tag,
        value: numbers.map(|it| it.value),
        limit: numbers.map(|it| it.limit),
        unit: definition.unit,
        margin: numbers.map(|it| it.margin),
        exceeded: numbers.map(|it| it.exceeded),
        action: definition.action,
        decides,
        statement: match &measured {
            Err(fault) => format!("Not evaluated: {}.", fault.reason()),
            Ok(measured) => statement(definition, measured),
        },
    }
}

/// A margin in per cent, with as many digits as it takes to tell it from 0.
fn percent(margin: f64) -> String {
    let percent = 100.0 * margin;
    match percent.abs() {
        0.0 => "0".to_owned(),
        size if size < 0.01 => format!("{percent:+.0e}"),
        size if size < 0.1 => format!("{percent:+.2}"),
        size if size < 1.0 => format!("{percent:+.1}"),
        _ => format!("{percent:+.0}"),
    }
}

/// A sentence with the numbers, and with the consequence if the criterion is exceeded.
fn statement(definition: &Definition, measured: &Measured) -> String {
    let Measured {
        value,
        limit,
        margin,
        exceeded,
    } = *measured;
    let bound = match definition.relation {
        Relation::AtMost => "at most",
        Relation::AtLeast => "at least",
    };
    let mut name = definition.value.to_owned();
    name[..1].make_ascii_uppercase();
    let mut text = format!(
        "{name}: {}; {bound} {} [{}]",
        quantity(value, definition.unit),
        quantity(limit, definition.unit),
        definition.tag
    );
    if limit != 0.0 {
        text.push_str(&format!(", margin {} %", percent(margin)));
    }
    if exceeded {
        text.push_str(&format!(". Exceeded: {}", definition.consequence));
    }
    text.push('.');
    text
}

/// The text with a capital letter at its beginning.
pub(crate) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// The cause of the criterion that decides; of a lost column, how it was lost.
fn cause(input: &AssessmentInput, deciding: &Criterion) -> &'static str {
    match deciding.name {
        ALWAYS_DECIDES if input.fractured => match input.fractured_base() {
            Some(BaseFailure::AnchorsInShear) => {
                "the anchors of the base are sheared off during the hit"
            }
            Some(_) => "the anchors of the base fracture in tension during the hit",
            None => "the column fractures during the hit and carries nothing",
        },
        ALWAYS_DECIDES => "the column collapses during the hit and carries nothing",
        _ => deciding.cause,
    }
}

/// The number of a criterion with its limit, as a sentence behind a space; empty where it is yes or no, and without a limit that is 0.
fn numbers(criterion: &Criterion) -> String {
    let (Some(value), Some(limit)) = (criterion.value, criterion.limit) else {
        return String::new();
    };
    if criterion.name == ALWAYS_DECIDES {
        return String::new();
    }
    let mut text = format!(
        " {}: {}",
        criterion.quantity(),
        quantity(value, criterion.unit)
    );
    if limit != 0.0 {
        text += &format!("; limit {}", quantity(limit, criterion.unit));
    }
    text + "."
}

/// What has to be done; and the cause with the number and its limit, or how far the column has come where nothing decides.
fn finding(
    input: &AssessmentInput,
    action: Action,
    cause: &str,
    deciding: &Criterion,
) -> [String; 2] {
    let what = match action {
        Action::None => "No deciding criterion is exceeded.".to_owned(),
        _ => capitalised(action.order()),
    };
    let why = match (action, input.utilisation) {
        (Action::None, Some(utilisation)) => format!("Largest utilisation: {utilisation}."),
        (Action::None, None) => {
            let (name, statement) = (deciding.name, &deciding.statement);
            format!("The closest to its limit is {name}: {statement}")
        }
        _ => format!("Cause: {cause}.{}", numbers(deciding)),
    };
    [what, why]
}

/// What engineers call what is not known, by its name, as a part of a sentence.
pub(crate) fn missing_in_words(name: &str) -> String {
    let of_criterion = DEFINITIONS.iter().find(|it| it.name == name);
    let of_input = AssumedInput::ALL.into_iter().find(|it| it.name() == name);
    let [out_of_plane, of_motion] = OUT_OF_PLANE;
    let title = of_criterion
        .and_then(|it| it.title.split(": ").next())
        .or(of_input.map(AssumedInput::title))
        .or((name == out_of_plane).then_some(of_motion));
    let mut letters = title.unwrap_or(name).chars();
    letters.next().map_or(String::new(), |first| {
        first.to_lowercase().chain(letters).collect()
    })
}

/// What is not known, with what has to be given, each need once.
fn missing_data(missing: &[MissingData]) -> String {
    let mut text = String::new();
    for (index, one) in missing.iter().enumerate() {
        let is_said = missing[..index].iter().any(|it| it.needs == one.needs);
        if is_said {
            continue;
        }
        let names: Vec<_> = missing
            .iter()
            .filter(|it| it.needs == one.needs)
            .map(|it| format!("{} ({})", it.criterion, it.action))
            .collect();
        let what = match one.kind {
            MissingKind::Input => "Not given",
            MissingKind::Criterion | MissingKind::OutOfPlane => "Not evaluated",
        };
        text += &format!(" {what}: {}: {}.", names.join(", "), one.needs);
    }
    text
}

/// What a plane model does not say, beside every statement on a column that carries its load.
fn axes(input: &AssessmentInput) -> String {
    let mut text = String::new();
    let remaining = &input.remaining;
    if remaining.now.is_lower_bound() {
        text.push_str(" The push-down could not be followed to its end: N_u is a lower bound.");
    }
    if let Some(section) = &input.section {
        let found = section_class(section, input.yield_strength, input.axial_ratio());
        if found.class > SectionClass::Two {
            text.push_str(&format!(
                " The section is of {found}: it buckles locally before it can rotate, and the computed capacity is too high."
            ));
        }
    }
    text.push_str(" The model is plane and knows neither connections nor local buckling; ");
    match &remaining.weak {
        Some(weak) => {
            text.push_str(&format!(
                "about the weak axis as much of the resistance of {} is assumed to be left as about the strong one",
                quantity(weak.force, "N")
            ));
            if remaining.weak_axis_governs() == Some(true) {
                text.push_str(", and it governs");
            }
        }
        None => text.push_str("the resistance about the weak axis is not known"),
    }
    text.push('.');
    text
}

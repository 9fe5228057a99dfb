//! What the impact has left of the column: its residual capacity, judged by the criteria.

use super::course::Struck;
use super::reported_impact::ReportedImpact;
use crate::assessment::{
    ActionRange, Assessment, AssessmentInput, ConnectedBase, Criterion, EarlierImpacts,
    ResidualCapacity, assess, imperfection,
};
use crate::column::{PushDownPoint, State, push_down};
use crate::parameters::BeamMode;
use crate::second_opinion::{NoSecondOpinion, ObliqueHit, SecondOpinion, is_out_of_plane};
use crate::standing::StandingColumn;
use crate::twin::KnownBeamDamage;

/// Residual capacity and assessment after one impact.
#[derive(Debug, Clone)]
pub(super) struct Assessed {
    /// By the two bars.
    pub remaining: ResidualCapacity,
    /// By the model that tells what the column does, see [`beam`](Self::beam).
    pub left: ResidualCapacity,
    pub assessment: Assessment,
    /// The checks as the report shows them: each by the model that finds less margin, where the fibre beam tells what the column does.
    pub criteria: Vec<Criterion>,
    /// Between which actions the verdict lies, or why that was not computed.
    pub range: Result<ActionRange, &'static str>,
    /// All on which the verdict of the fibre beam depends, where it tells what the column does.
    seen_by_beam: Option<AssessmentInput>,
    /// What the fibre beam says of the impact, or why it says nothing; `None` where it was not asked.
    pub second_opinion: Option<Result<SecondOpinion, NoSecondOpinion>>,
    /// `F0`: plastic plateau of the column \[N\].
    pub plateau: f64,
    /// Largest force of the vehicle's front within its crush curve \[N\]; `None` for a rigid vehicle.
    pub front_force: Option<f64>,
    /// The connection of the base, given or assumed.
    pub base: Option<ConnectedBase>,
    /// Push-down curve of the undamaged column.
    pub undamaged: Vec<PushDownPoint>,
    /// Push-down curve of the column as it is; empty if it is undamaged or carries nothing.
    pub now: Vec<PushDownPoint>,
}

impl Assessed {
    /// Computes the capacities and evaluates every criterion.
    ///
    /// # Errors
    /// Why there is no assessment, in words.
    pub fn of(impact: &ReportedImpact) -> Result<Self, String> {
        let stands = impact.report.outcome.stands();
        let state = match (stands, &impact.settled) {
            (false, _) => None,
            (true, Some(state)) => Some(state),
            (true, None) => {
                return Err("the state of the column after the impact is not known".into());
            }
        };
        let (parameters, model) = (&impact.parameters, &impact.model);
        let remaining = ResidualCapacity::compute(parameters, model, state)
            .map_err(|error| error.to_string())?;
        let bow = imperfection(parameters);
        let curve = |state: &State| {
            let mut curve = Vec::new();
            push_down(model, state, bow, &mut |point| curve.push(*point))
                .map(|_| curve)
                .map_err(|error| error.to_string())
        };
        let undamaged_state = State::at_rest(model);
        let now = match state {
            Some(state) if state.plastic != undamaged_state.plastic => curve(state)?,
            _ => Vec::new(),
        };
        let undamaged = curve(&undamaged_state)?;
        let mut input = AssessmentInput::of_response(
            parameters,
            model,
            &impact.impact,
            &impact.report,
            remaining,
        );
        // The event may have named another direction than the parameters.
        if let Some(hit) = &mut input.impact {
            hit.direction = impact.direction;
        }
        let mut assessment = assess(&input);
        let mut range = range(impact, &assessment);
        let second_opinion = match &impact.second_opinion {
            Some(known) => {
                let range = range.as_mut().ok();
                Some(Ok(known.weighed(&input, &mut assessment, range)))
            }
            None => second_opinion(impact, remaining, &mut assessment, &mut range),
        };
        if let Some(Ok(opinion)) = &second_opinion {
            range = by_both(impact, &assessment, opinion, range);
        }
        let beam = telling(second_opinion.as_ref());
        let seen_by_beam = beam.map(|it| it.seen_by_the_beam(&input));
        Ok(Self {
            remaining,
            left: seen_by_beam.as_ref().map_or(remaining, |it| it.remaining),
            range,
            criteria: criteria(&assessment, beam, impact.is_oblique()),
            assessment,
            seen_by_beam,
            second_opinion,
            plateau: input.plateau,
            front_force: input.impact.and_then(|impact| impact.front_force),
            base: input.base,
            undamaged,
            now,
        })
    }

    /// The criterion that decides.
    pub fn deciding(&self) -> Option<&Criterion> {
        let name = self.assessment.deciding_criterion;
        self.criteria
            .iter()
            .find(|criterion| criterion.name == name)
    }

    /// The fibre beam, where it and not the two bars tells what the column does: where it decides, and where the vehicle travels out of
    /// the plane of the two bars, of which they see a component only.
    pub fn beam(&self) -> Option<&SecondOpinion> {
        telling(self.second_opinion.as_ref())
    }

    /// The same with what it sees.
    pub fn by_beam(&self) -> Option<ByBeam<'_>> {
        self.beam().zip(self.seen_by_beam.as_ref())
    }
}

/// What the fibre beam says, and all on which its verdict depends.
pub(super) type ByBeam<'a> = (&'a SecondOpinion, &'a AssessmentInput);

fn telling(opinion: Option<&Result<SecondOpinion, NoSecondOpinion>>) -> Option<&SecondOpinion> {
    let opinion = opinion?.as_ref().ok();
    opinion.filter(|it| it.decides || is_out_of_plane(it.direction))
}

/// Why a check of the base has no result.
const BASE_IN_PART: &str = "out of the plane of the web, the forces of the base are known in part only: see the base reactions";

/// The checks as the report shows them.
fn criteria(
    assessment: &Assessment,
    beam: Option<&SecondOpinion>,
    is_oblique: bool,
) -> Vec<Criterion> {
    let by_beam = beam.and_then(|it| it.assessment.as_ref());
    let shown = match by_beam {
        Some(by_beam) => assessment.worse_criteria(by_beam),
        None => assessment.criteria.clone(),
    };
    // The beam knows the shear of the base in every direction, and no moment.
    let is_known = |name: &str| {
        !is_oblique || !name.starts_with("base_") || (name == "base_shear" && by_beam.is_some())
    };
    shown
        .into_iter()
        .map(|it| match it.exceeded {
            Some(false) if !is_known(it.name) => Criterion {
                value: None,
                margin: None,
                exceeded: None,
                statement: BASE_IN_PART.to_owned(),
                ..it
            },
            _ => it,
        })
        .collect()
}

/// The second opinion on a simulated impact, with which the verdict and its range become those of both models.
fn second_opinion(
    impact: &ReportedImpact,
    remaining: ResidualCapacity,
    assessment: &mut Assessment,
    range: &mut Result<ActionRange, &'static str>,
) -> Option<Result<SecondOpinion, NoSecondOpinion>> {
    let is_asked = impact.parameters.settings().beam.mode != BeamMode::Off;
    if impact.event.is_some() || !is_asked {
        return None;
    }
    let beside = SecondOpinion::beside(&impact.parameters, &impact.report, Some(remaining));
    Some(beside.map(|mut opinion| {
        opinion.weigh(assessment, range.as_mut().ok());
        opinion
    }))
}

fn range(impact: &ReportedImpact, verdict: &Assessment) -> Result<ActionRange, &'static str> {
    let struck = impact
        .struck
        .ok_or("the column was still moving when the impact began")?;
    let earlier = earlier(&struck);
    let found = ActionRange::of_action(
        &impact.parameters,
        &impact.model.properties,
        &impact.impact,
        impact.direction,
        Some(&earlier).filter(|it| it.have_damaged()),
        &verdict.into(),
        &mut || true,
    );
    found.ok_or("it was broken off")
}

/// What the impacts before it have left. Without the base: the assessment of a report judges the forces of its own impact.
fn earlier(struck: &Struck) -> EarlierImpacts {
    EarlierImpacts {
        column: StandingColumn::new(&struck.model, &struck.state),
        base: None,
    }
}

/// The range of the verdict of both models, where that of the two bars is `range`.
fn by_both(
    impact: &ReportedImpact,
    verdict: &Assessment,
    opinion: &SecondOpinion,
    mut range: Result<ActionRange, &'static str>,
) -> Result<ActionRange, &'static str> {
    let before = impact.beam_before.as_ref().map(KnownBeamDamage::before);
    let (Some(struck), Some(Ok(before))) = (&impact.struck, before) else {
        return range;
    };
    let earlier = earlier(struck);
    let hit = ObliqueHit {
        parameters: &impact.parameters,
        struck: &impact.model.properties,
        in_plane: impact.impact,
        whole: impact
            .parameters
            .whole_impact_of(impact.impact, impact.velocity),
        direction: impact.direction,
        earlier: Some(&earlier).filter(|it| it.have_damaged()),
        beam_before: before.as_ref(),
    };
    let verdict = verdict.into();
    if let Some(by_both) = hit.range(&verdict, &mut || true) {
        return Ok(by_both);
    }
    if let Ok(range) = &mut range {
        hit.include_hardening(range, &verdict, opinion.has_yielded());
    }
    range
}

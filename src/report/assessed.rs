//! What the impact has left of the column: its residual capacity, judged by the criteria.

use super::reported_impact::ReportedImpact;
use crate::assessment::{
    ActionRange, Assessment, AssessmentInput, ConnectedBase, Criterion, EarlierImpacts,
    ResidualCapacity, assess, imperfection,
};
use crate::column::{Outcome, PushDownPoint, State, push_down};
use crate::parameters::BeamMode;
use crate::second_opinion::{NoSecondOpinion, SecondOpinion};
use crate::standing::StandingColumn;

/// Residual capacity and assessment after one impact.
#[derive(Debug, Clone)]
pub(super) struct Assessed {
    pub remaining: ResidualCapacity,
    pub assessment: Assessment,
    /// Between which actions the verdict lies, or why that was not computed.
    pub range: Result<ActionRange, &'static str>,
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
        let stands = matches!(impact.report.outcome, Outcome::Elastic | Outcome::Plastic);
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
        let input = AssessmentInput::of_response(
            parameters,
            model,
            &impact.impact,
            &impact.report,
            remaining,
        );
        let mut assessment = assess(&input);
        let mut range = range(impact, &assessment);
        let second_opinion = match &impact.second_opinion {
            Some(known) => {
                let range = range.as_mut().ok();
                Some(Ok(known.weighed(&input, &mut assessment, range)))
            }
            None => second_opinion(impact, remaining, &mut assessment, &mut range),
        };
        Ok(Self {
            remaining,
            range,
            assessment,
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
        self.assessment
            .criteria
            .iter()
            .find(|criterion| criterion.name == name)
    }
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
    // Without the base: the assessment of a report judges the forces of its own impact.
    let earlier = EarlierImpacts {
        column: StandingColumn::new(&struck.model, &struck.state),
        base: None,
    };
    Ok(ActionRange::of(
        &impact.parameters,
        &impact.model.properties,
        &impact.impact,
        Some(&earlier).filter(|it| it.have_damaged()),
        verdict,
    ))
}

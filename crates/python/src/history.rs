//! One impact with its history for Python.

use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use column_twin::assessment::{AssessmentInput, ImpactEvaluation, OpenVerdict, observe_and_rest};
use column_twin::column::{ColumnProperties, ForceSpectrum, Impact, Model, State};
use column_twin::observables;
use column_twin::parameters::Parameters;
use column_twin::results::{BeamAnswer, ImpactFields, Travel};
use column_twin::second_opinion::{
    self, BeamDamage, BeamDamageBefore, BeamTask, EarlierHit, NoSecondOpinion, ObliqueHit,
    SecondOpinion, beam_damage_after,
};
use column_twin::study::{StudyColumn, VerdictModel};
use pyo3::prelude::*;

use crate::fault;

/// The damage of the fibre beam, or why there is none.
pub type KnownDamage = Result<Option<Arc<BeamDamage>>, NoSecondOpinion>;

/// An impact whose history is wanted.
pub struct Simulated {
    pub study: Arc<StudyColumn>,
    /// The impacts that have damaged the column, for the fibre beam; none of an undamaged one.
    pub hits: Arc<[EarlierHit]>,
    /// The damage that they leave in the beam, once an impact has needed it.
    pub beam_damage: Arc<OnceLock<KnownDamage>>,
    /// The parameters with the impact.
    pub stated: Parameters,
    /// The component of it in the plane of the two bars.
    pub impact: Impact,
    /// All of it, for the beam.
    pub hit: EarlierHit,
    pub vehicle_name: String,
    /// The model that judges.
    pub model: VerdictModel,
}

/// One impact with its history.
pub struct History {
    /// Names of the columns.
    pub names: Vec<String>,
    /// Values of the columns, one per step.
    pub columns: Vec<Vec<f64>>,
    /// The outcome as JSON.
    pub outcome: String,
}

impl Simulated {
    /// Computes it.
    ///
    /// # Errors
    /// A response that cannot be computed, or no second opinion where the beam alone judges.
    pub fn history(&self) -> PyResult<History> {
        let Self {
            study,
            stated,
            impact,
            vehicle_name,
            model,
            ..
        } = self;
        let is_damaged = self.study.is_damaged() || !self.hits.is_empty();
        let parameters = study.parameters();
        let properties = parameters.column_properties();
        let masses = impact.vehicle.map_or(0, |it| it.masses().len());
        let table: Vec<_> = observables::history(masses).collect();
        let names = table.iter().map(|(it, index)| it.in_histories(*index));
        let names: Vec<_> = names.collect();
        let mut columns = vec![Vec::new(); names.len()];
        let mut spectrum = ForceSpectrum::default();
        let start = Instant::now();
        let mut solve_time = Duration::ZERO;
        let observe = |model: &Model, state: &State| {
            let sample = state.sample(model);
            spectrum.push(sample.time, sample.impulse);
            for (column, (it, index)) in columns.iter_mut().zip(&table) {
                column.push(it.value(&sample, *index));
            }
            solve_time = start.elapsed();
        };
        let (mut evaluation, input) = match is_damaged {
            true => study
                .follow(impact, observe)
                .map_err(|fault| fault::study(&fault))?,
            false => {
                let duration = parameters.response_duration();
                let evaluated =
                    observe_and_rest(&properties, impact, duration, observe).and_then(|ended| {
                        ImpactEvaluation::complete(stated, &properties, impact, ended)
                    });
                (
                    evaluated.map_err(|fault| fault::of_simulation(&fault))?,
                    None,
                )
            }
        };
        let mut beam = None;
        if *model != VerdictModel::Bars {
            let start = Instant::now();
            let (opinion, solve_time) = match is_damaged {
                true => {
                    let answer = self.answer_on_damaged();
                    let solve_time = start.elapsed();
                    let opinion = answer.map(|answer| {
                        self.opinion_on_damaged(&answer, &mut evaluation, input.as_ref())
                    });
                    (opinion, solve_time)
                }
                false => {
                    let beside =
                        SecondOpinion::beside(stated, &evaluation.report, evaluation.remaining);
                    let solve_time = start.elapsed();
                    let opinion = beside.map(|it| it.taken_into(stated, &mut evaluation));
                    (opinion, solve_time)
                }
            };
            beam = Some(BeamAnswer::of(&opinion, solve_time));
            if *model == VerdictModel::Beam {
                let opinion = opinion.map_err(|reason| fault::simulation(reason.to_string()))?;
                evaluation.assessment = opinion.assessment;
                // Its variations are those of the two bars.
                evaluation.range = None;
            }
        }
        let travel = Travel {
            velocity: self.hit.impact.velocity,
            direction: self.hit.direction,
            in_plane: impact.velocity,
        };
        let mut fields = ImpactFields::of(&evaluation, vehicle_name, travel, solve_time)
            .with_spectrum(&spectrum);
        if let Some(beam) = beam {
            fields = fields.with_beam(beam);
        }
        Ok(History {
            outcome: serde_json::to_string(&fields).expect("numbers and words"),
            names,
            columns,
        })
    }

    /// What the beam computes of the impact on the damaged column, with the damage before it.
    fn answer_on_damaged(
        &self,
    ) -> Result<(second_opinion::BeamAnswer, Option<BeamDamageBefore>), NoSecondOpinion> {
        let hit = &self.hit;
        let parameters = self.study.parameters();
        let damage = self
            .beam_damage
            .get_or_init(|| beam_damage_after(parameters, &self.hits));
        let before = damage.clone()?.map(BeamDamageBefore::from);
        let task = BeamTask::new(
            parameters,
            hit.lengths,
            hit.impact,
            hit.direction,
            before.clone(),
        )?;
        Ok((task.compute()?, before))
    }

    /// What this answer says of the impact on the damaged column beside this evaluation by the two bars, whose verdict it becomes where
    /// it counts and is more severe.
    fn opinion_on_damaged(
        &self,
        (answer, before): &(second_opinion::BeamAnswer, Option<BeamDamageBefore>),
        evaluation: &mut ImpactEvaluation,
        input: Option<&AssessmentInput>,
    ) -> SecondOpinion {
        let hit = &self.hit;
        let parameters = self.study.parameters();
        let opinion = SecondOpinion::new(answer, hit.direction, parameters, &evaluation.report);
        let (Some(input), Some(assessment)) = (input, &mut evaluation.assessment) else {
            return opinion;
        };
        let opinion = opinion.weighed(input, assessment, evaluation.range.as_mut());
        let verdict = OpenVerdict::from(&*assessment);
        let [length_below, length_above] = hit.lengths;
        let oblique = ObliqueHit {
            parameters,
            struck: &ColumnProperties {
                length_below,
                length_above,
                ..parameters.column_properties()
            },
            in_plane: self.impact,
            whole: hit.impact,
            direction: hit.direction,
            earlier: evaluation.earlier.as_ref(),
            beam_before: before.as_ref(),
        };
        oblique.complete(&mut evaluation.range, &verdict, opinion.has_yielded());
        opinion
    }
}

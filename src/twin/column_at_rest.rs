//! The column at rest: its parameters, its damage, what it has been through, its assessment, and what was computed behind that.

use std::sync::Arc;

use super::assessed::{Assessed, LastImpact, UndamagedCapacity, assess_at_once, assessed_again};
use super::critical::{CriticalVelocityTask, KnownCriticalVelocities};
use super::damage_correction::{DamageCorrection, ResidualMeasurement, correct};
use super::forecast::Completed;
use super::journal::Checkpoint;
use super::judged_impact::JudgedImpact;
use super::life::Life;
use super::opinion::{OpinionTask, Seen};
use super::opinion_state::{BeamResult, KnownBeamDamage, MOVING, OpinionState};
use super::output::ReportOutput;
use super::parameter_set::ParameterSet;
use super::plant::{Condition, OF_ITS_MAKE, Plant, Struck};
use super::range::{Judged, RangeTask};
use super::rejection::{Rejection, RejectionCode};
use super::saved_state::SavedState;
use super::striking::Striking;
use super::what_if::ColumnSnapshot;
use crate::assessment::VerdictRange;
use crate::column::{Model, ModelError};
use crate::parameters::Parameters;
use crate::second_opinion::SecondOpinion;
use crate::study::VehicleLimits;
use crate::time::Nanos;

/// The column at rest. While it responds to an impact, it is what it was before.
#[derive(Debug)]
pub(super) struct ColumnAtRest {
    id: Arc<str>,
    parameters: ParameterSet,
    /// The column, as the last response or a reset left it.
    plant: Plant,
    life: Life,
    /// Its assessment; `None` if it cannot be computed.
    assessed: Option<Arc<Assessed>>,
    /// Undamaged capacity of the last column that was assessed.
    undamaged: Option<UndamagedCapacity>,
    /// Its critical velocities; `None` until they are computed.
    critical: Option<KnownCriticalVelocities>,
    /// The last impact with the range of its verdict, if that has one.
    judged: Option<Box<Judged>>,
}

/// What a response that is over has changed in the column.
#[derive(Debug)]
pub(super) struct BeforeResponse {
    /// Work dissipated before it since the last reset \[J\].
    plastic_work: f64,
    /// The column at rest.
    plant: Plant,
    /// Its assessment.
    assessed: Option<Arc<Assessed>>,
    /// The impact before.
    last_impact: Option<LastImpact>,
    /// The damage as the beam knew it.
    beam: KnownBeamDamage,
}

/// The verdict on an impact whose response has ended.
pub(super) struct Verdict {
    /// The parameters that held when it began.
    pub parameters: Arc<Parameters>,
    pub assessed: Option<Arc<Assessed>>,
    pub judged: Option<Box<Judged>>,
}

impl ColumnAtRest {
    /// The column with these parameters: undamaged, or with the damage that was saved.
    ///
    /// # Errors
    /// The column is impossible, or does not stand under its load.
    pub fn new(
        parameters: Arc<Parameters>,
        saved: Option<&SavedState>,
    ) -> Result<Self, ModelError> {
        let properties = parameters.column_properties();
        let mut column = Self {
            id: parameters.settings().column_id.as_str().into(),
            parameters: ParameterSet::new(parameters),
            plant: match saved {
                None => Plant::undamaged(&properties)?,
                Some(saved) => saved.plant(&properties)?,
            },
            life: saved.map_or_else(Life::default, SavedState::life),
            assessed: None,
            undamaged: None,
            critical: None,
            judged: None,
        };
        column.assess();
        Ok(column)
    }

    /// The column as it was at a checkpoint.
    ///
    /// # Errors
    /// The column is impossible.
    pub fn restored(from: &Checkpoint) -> Result<Self, ModelError> {
        let mut column = Self::new(Parameters::clone(&from.parameters).into(), None)?;
        let mut properties = from.parameters.column_properties();
        properties.length_below = from.length_below;
        properties.length_above = from.length_above;
        column.plant = Plant {
            model: Model::new(&properties)?,
            state: from.state,
            condition: from.condition.clone(),
        };
        column.life = from.life.clone();
        column.assess();
        let task = column.critical_velocity_task();
        if let (Some(task), Some(vehicles)) = (task, &from.critical_velocities) {
            column.keep_critical_velocities(task, vehicles);
        }
        column.judged = from.judged.as_ref().map(Judged::restored);
        Ok(column)
    }

    /// Another undamaged column that differs from this undamaged one by its names only, without computing anything; `None` if this
    /// one is not undamaged, or if the columns differ.
    pub fn sibling(&self, parameters: Arc<Parameters>) -> Option<Self> {
        let is_undamaged = self.life.impacts_since_reset == 0
            && self.plant.condition == Condition::Standing
            && !self.plant.is_damaged();
        if !is_undamaged || !self.parameters().differs_by_names_only(&parameters) {
            return None;
        }
        let id = parameters.settings().column_id.as_str().into();
        let mut parameters = ParameterSet::new(parameters);
        parameters.share_fingerprint(&self.parameters);
        Some(Self {
            id,
            parameters,
            plant: self.plant.clone(),
            life: Life::default(),
            assessed: self.assessed.clone(),
            undamaged: self.undamaged,
            critical: None,
            judged: None,
        })
    }

    /// Its name.
    pub fn id(&self) -> &Arc<str> {
        &self.id
    }

    /// The parameters that hold.
    pub fn parameters(&self) -> &Arc<Parameters> {
        self.parameters.current()
    }

    /// The column.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// What it has been through.
    pub fn life(&self) -> &Life {
        &self.life
    }

    /// Its assessment; `None` if it cannot be computed.
    pub fn assessed(&self) -> Option<&Arc<Assessed>> {
        self.assessed.as_ref()
    }

    /// The undamaged capacity of the last column that was assessed, which who computes another one replaces.
    pub fn undamaged(&mut self) -> &mut Option<UndamagedCapacity> {
        &mut self.undamaged
    }

    /// A snapshot for predictions, with `plant` in place of the column at rest, which may be moving.
    pub fn snapshot_of(&self, plant: Plant, is_moving: bool) -> ColumnSnapshot {
        ColumnSnapshot {
            column_id: Arc::clone(&self.id),
            parameters: Arc::clone(self.parameters()),
            plant,
            undamaged: self.undamaged,
            base_before: self.life.base_before(),
            beam: match is_moving {
                true => KnownBeamDamage::Unknown(MOVING.into()),
                false => self.life.beam.clone(),
            },
        }
    }

    /// The damage of this column to be saved, with the identifiers of its impacts.
    pub fn saved_of(&self, plant: &Plant, seen_ids: Vec<Arc<str>>, now: Nanos) -> SavedState {
        let fingerprint = self.parameters.fingerprint();
        SavedState::new(&self.id, fingerprint, plant, &self.life, seen_ids, now)
    }

    /// The damage to be saved before a response is over that is known to its end.
    pub fn saved_after(
        &self,
        completed: Completed,
        seen_ids: Vec<Arc<str>>,
        now: Nanos,
    ) -> SavedState {
        let mut expected = completed.at_rest;
        if !completed.has_residual {
            // The damage before the response is then the last that can be saved.
            expected.state = self.plant.state;
        }
        let mut saved = self.saved_of(&expected, seen_ids, now);
        saved.plastic_work_since_reset += completed.plastic_work;
        saved.last_impact = Some(completed.last);
        saved.beam = saved.beam.while_awaited(&expected);
        saved
    }

    // What the column goes through

    /// Notes that the column may have damage that is not known.
    pub fn note_unknown_damage(&mut self) {
        self.life.is_damage_unknown = true;
    }

    /// Counts an accepted impact.
    pub fn count_impact(&mut self) {
        let count = &mut self.life.impacts_since_reset;
        *count = count.saturating_add(1);
    }

    /// Takes the count of an accepted impact back, which is rejected after all.
    pub fn discount_impact(&mut self) {
        let count = &mut self.life.impacts_since_reset;
        *count = count.saturating_sub(1);
    }

    /// Counts a rejected impact.
    pub fn count_rejection(&mut self) {
        self.life.rejected_since_reset += 1;
    }

    /// An impact begins: a second opinion on the last one, or a range of its verdict, that is not known yet is not awaited any more.
    pub fn begin_impact(&mut self, event_id: &Arc<str>) {
        if self.has_unknown_range() || self.awaits_opinion() {
            self.judged = None;
        }
        self.life.last_event_id = Arc::clone(event_id);
    }

    /// Adds the work of a response that another impact has ended \[J\].
    pub fn add_plastic_work(&mut self, added: f64) {
        self.life.plastic_work_since_reset += added;
    }

    /// Takes over what a response has left that is over: the column, its impact, the damage as the beam knows it, and the work that was
    /// dissipated \[J\].
    pub fn settle(
        &mut self,
        settled: Plant,
        last: LastImpact,
        beam: KnownBeamDamage,
        plastic_work: f64,
    ) -> Box<BeforeResponse> {
        let life = &mut self.life;
        let before = BeforeResponse {
            plastic_work: life.plastic_work_since_reset,
            plant: std::mem::replace(&mut self.plant, settled),
            assessed: self.assessed.clone(),
            last_impact: life.last_impact.replace(last),
            beam: std::mem::replace(&mut life.beam, beam),
        };
        life.plastic_work_since_reset += plastic_work;
        Box::new(before)
    }

    /// Takes the verdict on the last impact. If other parameters have come into force since, the column is assessed by these instead.
    pub fn take_verdict(&mut self, verdict: Verdict) {
        if !Arc::ptr_eq(&verdict.parameters, self.parameters()) {
            return self.assess_anew();
        }
        self.assessed = verdict.assessed;
        self.judged = verdict.judged;
        self.forget_other_critical_velocities();
    }

    /// Takes back the work of the last response, which is resumed.
    pub fn resume(&mut self, before: &BeforeResponse) {
        self.life.plastic_work_since_reset = before.plastic_work;
    }

    /// Takes back everything that the last response has changed.
    pub fn take_back(&mut self, before: BeforeResponse) {
        self.resume(&before);
        self.plant = before.plant;
        self.assessed = before.assessed;
        self.life.last_impact = before.last_impact;
        self.life.beam = before.beam;
        self.forget_other_critical_velocities();
        self.judged = None;
    }

    /// Corrects the damage by a measurement, and tells whether anything has changed. Where the model agrees with it within its
    /// standard deviation, nothing does.
    ///
    /// # Errors
    /// The column does not stand, or the measurement does not fit to its damage.
    pub fn correct(
        &mut self,
        measured: &ResidualMeasurement,
        now: Nanos,
    ) -> Result<(DamageCorrection, bool), Rejection> {
        self.plant.check_standing()?;
        let (correction, corrected) = correct(&self.plant, measured, now)?;
        let is_changed = corrected.is_some();
        if let Some(corrected) = corrected {
            self.plant = corrected;
            if let Some(last) = &mut self.life.last_impact {
                last.residual_v1 = None;
                last.second_opinion = None;
            }
            // The beam corrects its own damage before it computes the next hit.
            self.life.beam = self.life.beam.corrected_by(measured);
            self.assess_anew();
        }
        let life = &mut self.life;
        life.corrections_since_reset = life.corrections_since_reset.saturating_add(1);
        life.last_correction = Some(correction);
        Ok((correction, is_changed))
    }

    /// Makes the column undamaged and forgets what it has been through. The caller then [assesses it anew](Self::assess_anew).
    pub fn reset(&mut self) {
        self.life = Life::default();
        // The parameters were checked when they came; if they failed now, the old model would still be a column.
        let properties = self.parameters().column_properties();
        self.plant =
            Plant::undamaged(&properties).unwrap_or_else(|_| Plant::undamaged_of(self.plant.model));
    }

    // Assessment

    /// Assesses the column at once: after a start, a reset or a change of parameters. After a response, the look-ahead has done it
    /// in slices.
    fn assess(&mut self) {
        self.assessed = assess_at_once(
            self.parameters.current(),
            &self.plant,
            self.life.last_impact.as_ref(),
            &mut self.undamaged,
        );
    }

    /// Assesses the column, and forgets what was computed for the column before.
    pub fn assess_anew(&mut self) {
        self.assess();
        self.forget_other_critical_velocities();
        self.judged = None;
    }

    // Changes of the parameters

    /// The parameters that hold, and the ones that wait.
    pub fn parameter_set(&self) -> &ParameterSet {
        &self.parameters
    }

    /// The same, to be changed. Where other parameters then hold for the column at rest, the caller [replaces it](Self::replace) and
    /// [assesses it anew](Self::assess_anew).
    pub fn parameter_set_mut(&mut self) -> &mut ParameterSet {
        &mut self.parameters
    }

    /// The column with other parameters.
    ///
    /// # Errors
    /// They are those of another column, and this one is damaged.
    pub fn with_parameters(&self, wanted: &Parameters) -> Result<Plant, Rejection> {
        let is_damaged = self.plant.is_damaged() || !self.life.beam.is_undamaged();
        self.changed(&self.plant, is_damaged, wanted)
    }

    /// # Errors
    /// The column that a response will leave does not take other parameters.
    pub fn check_change_of(&self, left: &Plant, wanted: &Parameters) -> Result<(), Rejection> {
        self.changed(left, left.is_damaged(), wanted).map(drop)
    }

    fn changed(
        &self,
        plant: &Plant,
        is_damaged: bool,
        wanted: &Parameters,
    ) -> Result<Plant, Rejection> {
        let current: &Parameters = self.parameters();
        let [from, to] = [current, wanted].map(Parameters::column_properties);
        let changed = plant.with_properties(&from, &to)?;
        // A damage belongs to the shape of the section, which the numbers of the two bars need not tell.
        let [from, to] = [current, wanted].map(|it| it.settings().section.shape);
        match is_damaged && from != to {
            true => Err(Rejection::new(RejectionCode::ColumnDamaged, OF_ITS_MAKE)),
            false => Ok(changed),
        }
    }

    /// Replaces the column, and tells whether it has another model. The caller then [assesses it anew](Self::assess_anew).
    pub fn replace(&mut self, plant: Plant) -> bool {
        let is_other = plant.model != self.plant.model;
        self.plant = plant;
        is_other
    }

    // Critical velocities

    /// All on which the critical velocities depend, whether they are known or not; `None` if the column is not assessed.
    pub fn critical_velocity_task(&self) -> Option<CriticalVelocityTask> {
        Some(CriticalVelocityTask {
            parameters: Arc::clone(self.parameters()),
            at_rest: self.plant.clone(),
            action: self.assessed.as_ref()?.assessment.action,
        })
    }

    /// The critical velocities, if they are known.
    pub fn critical_velocities(&self) -> Option<&Arc<[VehicleLimits]>> {
        self.critical.as_ref().map(|it| &it.vehicles)
    }

    /// Keeps the result of this task.
    pub fn keep_critical_velocities(
        &mut self,
        task: CriticalVelocityTask,
        vehicles: &Arc<[VehicleLimits]>,
    ) {
        self.critical = Some(KnownCriticalVelocities {
            task,
            vehicles: Arc::clone(vehicles),
        });
    }

    /// Forgets the critical velocities of a column that is no longer this one. Called wherever the column, its assessment or the
    /// parameters have changed, so that a twin from any later checkpoint knows the same.
    fn forget_other_critical_velocities(&mut self) {
        let task = self.critical_velocity_task();
        self.critical
            .take_if(|known| Some(&known.task) != task.as_ref());
    }

    // The second opinion on the last impact

    /// The last impact, if its verdict has, or will have, a range or a second opinion.
    pub fn judged(&self) -> Option<&JudgedImpact> {
        self.judged.as_ref().map(|it| &it.impact)
    }

    /// The report of the last impact once more, with what was computed behind it.
    pub fn supplemented_report(&self) -> Option<ReportOutput> {
        Some(self.judged.as_ref()?.output(self.assessed.clone()))
    }

    /// Whether the second opinion is to be computed.
    pub fn awaits_opinion(&self) -> bool {
        let is_awaited = |it: &JudgedImpact| it.opinion == OpinionState::Awaited;
        self.judged().is_some_and(is_awaited) && self.assessed.is_some()
    }

    /// The hit of the last impact, that of this response, for the beam, whether its answer is known or not.
    pub fn opinion_task(&self, response: u64) -> Option<OpinionTask> {
        let judged = self.judged()?;
        OpinionTask::new(
            response,
            self.parameters(),
            &self.plant.model.properties,
            &judged.striking(),
            &judged.beam_before,
        )
        .ok()
    }

    /// What is kept of the last impact by this result: the opinion and the damage of the beam.
    pub fn kept(
        &self,
        found: &BeamResult,
    ) -> Option<(Option<Arc<SecondOpinion>>, KnownBeamDamage)> {
        let judged = self.judged()?;
        let seen = Seen {
            striking: &judged.striking(),
            parameters: self.parameters(),
            report: &judged.report,
            left: &self.plant,
            before: &judged.beam_before,
        };
        Some(seen.kept(found))
    }

    /// Takes what the beam has found of the last impact, if it is awaited.
    pub fn take_opinion(&mut self, found: &BeamResult) -> bool {
        if !self.awaits_opinion() {
            return false;
        }
        let Some(((opinion, beam), judged)) = self.kept(found).zip(self.judged.as_mut()) else {
            return false;
        };
        let life = &mut self.life;
        life.beam = beam;
        judged.impact.opinion = OpinionState::after(found);
        if let Some(last) = life.last_impact.as_mut().filter(|_| opinion.is_some()) {
            last.second_opinion = opinion;
            let parameters = self.parameters.current();
            let assessed = self.assessed.as_ref();
            self.assessed = assessed.map(|it| assessed_again(it, parameters, &self.plant, last));
        }
        true
    }

    /// Where the second opinion on an impact stands that begins now, on the column `before` it.
    pub fn opinion_on(&self, before: &Plant, struck: &Struck, striking: &Striking) -> OpinionState {
        if before.state.impactor.is_some() {
            return OpinionState::None(MOVING.into());
        }
        let struck = &struck.model.properties;
        match OpinionTask::new(0, self.parameters(), struck, striking, &self.life.beam) {
            Ok(_) => OpinionState::Awaited,
            Err(reason) => OpinionState::None(reason),
        }
    }

    // The range of the verdict on the last impact

    /// Whether the range is to be computed.
    pub fn awaits_range(&self) -> bool {
        self.has_unknown_range() && self.assessed.is_some()
    }

    fn has_unknown_range(&self) -> bool {
        let is_unknown = |it: &JudgedImpact| {
            it.has_range && it.range.is_none() && it.opinion != OpinionState::Awaited
        };
        self.judged().is_some_and(is_unknown)
    }

    /// All on which the range depends, whether it is known or not; `None` where the last impact, that of this response, has none.
    pub fn range_task(&self, response: u64) -> Option<RangeTask> {
        let judged = self.judged().filter(|it| it.has_range)?;
        Some(RangeTask::new(
            response,
            self.parameters(),
            &self.plant.model.properties,
            &judged.striking(),
            judged.earlier.as_ref(),
            (&judged.opinion, &judged.beam_before),
            self.assessed.as_ref()?,
        ))
    }

    /// Takes the range, if it is awaited.
    pub fn take_range(&mut self, range: &Arc<VerdictRange>) -> bool {
        let is_awaited = self.awaits_range();
        if let Some(judged) = self.judged.as_mut().filter(|_| is_awaited) {
            judged.impact.range = Some(Arc::clone(range));
        }
        is_awaited
    }
}

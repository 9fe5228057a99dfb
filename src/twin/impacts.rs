//! Impacts: checked, begun, met while the column moves, refused.

use std::sync::Arc;

use super::input::{ImpactEvent, Nanos};
use super::look_ahead::LookAhead;
use super::output::{Output, Outputs, Refused, RefusedInput, Severity};
use super::present::{Met, Present};
use super::run::{History, Run};
use super::{
    Arriving, Last, MAX_EVENT_ID_CHARS, MAX_IMPACTS_AHEAD, MAX_REASON_CHARS, Twin, seconds,
};
use crate::column::Model;

/// What becomes of the report of an impact whose response another impact ends.
pub(super) const NO_REPORT: &str = "will not come";

impl Twin {
    pub(super) fn take_impact(
        &mut self,
        event: &ImpactEvent,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<(), String> {
        let present = self.present();
        present.check_column(&event.column_id)?;
        self.check_event_id(&event.event_id)?;
        self.check_stamp(event.stamp, now)?;
        let impact = present.impact_of(&event.blow())?;
        let met = present.meet(impact, event.height)?;
        let arriving = Arriving {
            event_id: event.event_id.as_str().into(),
            stamp: event.stamp,
            impact,
            height: event.height,
        };
        let event_id = Arc::clone(&arriving.event_id);
        match self
            .run
            .as_ref()
            .map(|run| (run.stamp, run.step_at(event.stamp), run.state.step))
        {
            None => match self.resume(arriving.stamp, &met.model) {
                Some(step) => self.hit_moving_column(arriving, step, "no longer holds", now, out),
                None => self.begin(arriving.event_id, arriving.stamp, met, now, out),
            },
            Some((_, Some(step), reached)) if step <= reached => {
                self.hit_moving_column(arriving, step, NO_REPORT, now, out);
            }
            Some((_, Some(_), _)) => self.keep_for_later(arriving)?,
            Some((first, None, _)) => {
                return Err(format!(
                    "its stamp lies {} s before that of the impact that the column responds to; \
                     impacts must come in the order of their stamps",
                    seconds(first.abs_diff(event.stamp))
                ));
            }
        }
        self.seen.remember(event_id);
        self.counts.events_accepted += 1;
        self.life.impacts = self.life.impacts.saturating_add(1);
        self.reported.due = true;
        Ok(())
    }

    pub(super) fn check_event_id(&self, id: &str) -> Result<(), String> {
        let chars = id.chars().take(MAX_EVENT_ID_CHARS + 1).count();
        if chars == 0 {
            return Err("event_id is empty; give every impact an identifier of its own".to_owned());
        }
        if chars > MAX_EVENT_ID_CHARS || id.chars().take(chars).any(char::is_control) {
            return Err(format!(
                "event_id is too long or has control characters; \
                 allowed: 1 to {MAX_EVENT_ID_CHARS} characters, no control characters"
            ));
        }
        if self.seen.contains(id) {
            return Err("an impact of this event_id was accepted before; \
                 give every impact an identifier of its own"
                .to_owned());
        }
        Ok(())
    }

    pub(super) fn check_stamp(&self, stamp: Nanos, now: Nanos) -> Result<(), String> {
        let tolerance = &self.parameters.settings().event;
        let off = seconds(stamp.abs_diff(now));
        if stamp <= now && off > tolerance.max_age {
            return Err(format!(
                "its stamp is {off} s old, event.max_age is {} s; \
                 check that sender and twin have the same clock",
                tolerance.max_age
            ));
        }
        if stamp > now && off > tolerance.max_ahead {
            return Err(format!(
                "its stamp is {off} s ahead, event.max_ahead is {} s; \
                 check that sender and twin have the same clock",
                tolerance.max_ahead
            ));
        }
        Ok(())
    }

    pub(super) fn keep_for_later(&mut self, arriving: Arriving) -> Result<(), String> {
        if self.impacts_ahead.len() == MAX_IMPACTS_AHEAD {
            return Err(format!(
                "{MAX_IMPACTS_AHEAD} impacts lie ahead already; send impacts when they happen"
            ));
        }
        let place = self
            .impacts_ahead
            .partition_point(|other| other.stamp <= arriving.stamp);
        self.impacts_ahead.insert(place, arriving);
        Ok(())
    }

    /// Takes up the last response again where an impact is so late that it belongs into it: the step where it does.
    pub(super) fn resume(&mut self, stamp: Nanos, model: &Model) -> Option<u64> {
        let last = self.last.as_ref()?;
        let plastic_work = last.resumable?;
        let step = last
            .run
            .step_at(stamp)
            .filter(|&step| step < last.run.state.step)?;
        if last.run.model != *model {
            return None;
        }
        let run = self.last.take()?.run;
        self.journal.taken_back = true;
        self.life.plastic_work = plastic_work;
        self.corrections -= run.state.newton_iterations;
        self.run = Some(run);
        Some(step)
    }

    /// The response to another impact ends where the column was at `step`; `becomes` says what becomes of its report.
    pub(super) fn hit_moving_column(
        &mut self,
        arriving: Arriving,
        step: u64,
        becomes: &str,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let Some(mut run) = self.run.take() else {
            return;
        };
        run.rewind(step);
        self.ahead = None;
        self.life.plastic_work += run.state.ledger.plastic_work;
        self.corrections += run.state.newton_iterations;
        let text = format!(
            "impact \"{}\" hits the column {} s after impact \"{}\", whose report {becomes}",
            arriving.event_id,
            seconds(arriving.stamp.abs_diff(run.stamp)),
            run.event_id,
        );
        self.notice(Severity::Info, text, now, out);
        let present = Present {
            model: run.model,
            state: run.state,
            ..self.present()
        };
        self.last = Some(Last {
            run,
            resumable: None,
        });
        // It was seen to be meant for these hinges when it was accepted.
        let arriving = Arriving {
            height: Some(present.model.properties.length_below),
            ..arriving
        };
        self.begin_arriving(&present, arriving, now, out);
    }

    pub(super) fn begin_arriving(
        &mut self,
        present: &Present,
        arriving: Arriving,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let Arriving {
            event_id,
            stamp,
            impact,
            height,
        } = arriving;
        match present.meet(impact, height) {
            Ok(met) => self.begin(event_id, stamp, met, now, out),
            Err(reason) => {
                // It lay ahead and was accepted: no impact is counted twice.
                self.counts.events_accepted = self.counts.events_accepted.saturating_sub(1);
                self.life.impacts = self.life.impacts.saturating_sub(1);
                self.refuse_impact(&event_id, reason, now, out);
            }
        }
    }

    pub(super) fn begin(
        &mut self,
        event_id: Arc<str>,
        stamp: Nanos,
        met: Met,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let text = format!("impact \"{event_id}\" accepted");
        self.notice(Severity::Info, text, now, out);
        self.life.last_event_id = Arc::clone(&event_id);
        self.journal.responses += 1;
        self.ahead = Some(LookAhead::new(met.clone()));
        let steps = self.steps_per_sample(&met.model);
        let history = self
            .last
            .take()
            .map_or_else(History::default, |it| it.run.into_history());
        self.run = Some(Run::new(event_id, stamp, met, steps, history));
        self.reported.due = true;
    }

    /// The period of `publish_rate` in whole steps.
    pub(super) fn steps_per_sample(&self, model: &Model) -> u64 {
        let steps =
            1e9 / self.parameters.settings().publish_rate / model.properties.step_nanos as f64;
        steps.round().max(1.0) as u64
    }

    pub(super) fn refuse_impact(
        &mut self,
        event_id: &str,
        reason: String,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let event_id: Arc<str> = shortened(event_id).into();
        self.counts.events_refused += 1;
        self.life.refused += 1;
        self.refuse(RefusedInput::Impact, &reason, event_id, "".into(), now, out);
    }

    pub(super) fn refuse(
        &mut self,
        what: RefusedInput,
        reason: &str,
        event_id: Arc<str>,
        source: Arc<str>,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let reason: Arc<str> = cut(reason, MAX_REASON_CHARS).into();
        self.last_refusal_reason = Arc::clone(&reason);
        self.last_refusal_event_id = Arc::clone(&event_id);
        self.reported.due = true;
        out.put(Output::Refused(Refused {
            stamp: now,
            what,
            reason,
            event_id,
            source,
        }));
    }
}

/// A name from outside as it may stand in a message: not too long, and nothing that a terminal would obey.
pub(super) fn shortened(name: &str) -> String {
    cut(name, MAX_EVENT_ID_CHARS)
        .chars()
        .map(|c| if c.is_control() { '?' } else { c })
        .collect()
}

pub(super) fn cut(text: &str, most_chars: usize) -> String {
    match text.char_indices().nth(most_chars) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

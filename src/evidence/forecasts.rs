//! The forecasts that a recording has to contain, and the messages that a forecast no longer holds or will never be there. When
//! each one was complete depends on the machine, so that only its place before the report of the same impact, before a later
//! estimate of it, and before the column is at rest, is fixed.

use std::collections::VecDeque;

use crate::messages::column_twin_msgs::ImpactReport;
use crate::outgoing::Message;

/// Maximum number of forecasts that wait for a recorded message, and of impacts that are remembered as without one.
const MAX_PENDING: usize = 256;

/// Computed forecasts for which no recorded message has been found.
#[derive(Debug, Default)]
pub(super) struct Forecasts {
    pending: VecDeque<Message>,
    /// Messages with which the recorded twin gave up a forecast.
    given_up: VecDeque<Message>,
}

/// A computed forecast that corresponds to a recorded one.
pub(super) struct FoundForecast {
    pub forecast: Message,
    /// Earlier forecasts of the same impact for which there is no recorded message.
    pub passed: Vec<Message>,
}

fn is_same_impact(one: &Message, other: &Message) -> bool {
    one.stamp() == other.stamp() && one.event_id() == other.event_id()
}

fn is_same(one: &Message, other: &Message) -> bool {
    let kind = |it: &Message| content(it).map(|it| it.kind);
    is_same_impact(one, other) && kind(one) == kind(other)
}

fn content(message: &Message) -> Option<&ImpactReport> {
    match message {
        Message::ImpactForecast(it) => Some(it),
        _ => None,
    }
}

/// Adds to a queue that drops its oldest entry.
fn push(queue: &mut VecDeque<Message>, message: Message) {
    if queue.len() == MAX_PENDING {
        queue.pop_front();
    }
    queue.push_back(message);
}

impl Forecasts {
    /// Adds a computed forecast.
    pub fn add(&mut self, forecast: Message) {
        if !self.given_up.iter().any(|it| is_same_impact(it, &forecast)) {
            push(&mut self.pending, forecast);
        }
    }

    /// A later estimate has replaced this impact: whether the forecasts of the earlier one were complete by then depends on the
    /// machine, and they are not awaited any more.
    pub fn replace(&mut self, event_id: &str) {
        self.pending.retain(|it| it.event_id() != Some(event_id));
    }

    /// Whether a corresponding forecast is pending.
    pub fn expect(&self, recorded: &Message) -> bool {
        self.pending.iter().any(|it| is_same(it, recorded))
    }

    /// Takes the forecast that is equal to the recorded one, or else the first one of the same impact and kind.
    pub fn take(
        &mut self,
        recorded: &Message,
        is_equal: impl Fn(&Message) -> bool,
    ) -> Option<FoundForecast> {
        let same = |it: &Message| is_same(it, recorded);
        let equal = |it: &Message| same(it) && is_equal(it);
        let mut found = self.pending.iter().position(equal);
        if found.is_none() {
            found = self.pending.iter().position(same);
        }
        let Some(found) = found else {
            return self.give_up(recorded);
        };
        let forecast = self.pending.remove(found)?;
        let mut passed = self.take_while_before(found, recorded);
        if content(recorded).is_some_and(is_withdrawn_without_error) {
            // Its second forecast may never have been complete.
            passed.retain(|it| content(it).is_some_and(|it| it.error_estimate.is_nan()));
        }
        Some(FoundForecast { forecast, passed })
    }

    /// The message with which the recorded twin told that it had no time to compute a forecast, which depends on the machine. It
    /// takes the place of the computed forecasts; why and when the twin gave up cannot be recomputed.
    fn give_up(&mut self, recorded: &Message) -> Option<FoundForecast> {
        let told = content(recorded).filter(|it| it.kind == ImpactReport::NO_FORECAST)?;
        let first = self
            .pending
            .iter()
            .find(|it| is_same_impact(it, recorded))
            .and_then(content)?;
        let forecast = Message::ImpactForecast(ImpactReport {
            header: first.header.clone(),
            column_id: first.column_id.clone(),
            event_id: first.event_id.clone(),
            vehicle: first.vehicle.clone(),
            mass: first.mass,
            velocity: first.velocity,
            ..ImpactReport::without_results(told.kind, told.end, &told.action_reason)
        });
        self.pending.retain(|it| !is_same_impact(it, recorded));
        push(&mut self.given_up, recorded.clone());
        Some(FoundForecast {
            forecast,
            passed: Vec::new(),
        })
    }

    /// Takes the forecasts that have to precede this report and have not been found.
    pub fn take_reported(&mut self, report: &Message) -> Vec<Message> {
        self.take_while_before(self.pending.len(), report)
    }

    /// Takes the forecasts that have to precede the rest of the column and have not been found.
    pub fn take_all(&mut self) -> Vec<Message> {
        self.given_up.clear();
        self.pending.drain(..).collect()
    }

    /// Takes the forecasts of an impact among the first `count`.
    fn take_while_before(&mut self, count: usize, of: &Message) -> Vec<Message> {
        let mut taken = Vec::new();
        let mut index = 0;
        self.pending.retain(|it| {
            let is_taken = index < count && is_same_impact(it, of);
            index += 1;
            if is_taken {
                taken.push(it.clone());
            }
            !is_taken
        });
        taken
    }
}

fn is_withdrawn_without_error(report: &ImpactReport) -> bool {
    report.kind == ImpactReport::WITHDRAWN && report.error_estimate.is_nan()
}

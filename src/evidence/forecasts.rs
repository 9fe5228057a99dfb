//! The forecasts that a recording has to contain. When each one was complete depends on the machine, so that only its place
//! before the report of the same impact is fixed.

use std::collections::VecDeque;

use crate::outgoing::Message;

/// Maximum number of forecasts that wait for a recorded message; those of responses that were ended early may never come.
const MAX_PENDING: usize = 256;

/// Computed forecasts for which no recorded message has been found.
#[derive(Debug, Default)]
pub(super) struct Forecasts {
    pending: VecDeque<Message>,
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

impl Forecasts {
    /// Adds a computed forecast.
    pub fn add(&mut self, forecast: Message) {
        if self.pending.len() == MAX_PENDING {
            self.pending.pop_front();
        }
        self.pending.push_back(forecast);
    }

    /// Whether a forecast of the same impact is pending.
    pub fn expect(&self, recorded: &Message) -> bool {
        self.pending.iter().any(|it| is_same_impact(it, recorded))
    }

    /// Takes the forecast that is equal to the recorded one, or else the first one of the same impact.
    pub fn take(
        &mut self,
        recorded: &Message,
        is_equal: impl Fn(&Message) -> bool,
    ) -> Option<FoundForecast> {
        let same = |it: &Message| is_same_impact(it, recorded);
        let equal = |it: &Message| same(it) && is_equal(it);
        let mut found = self.pending.iter().position(equal);
        if found.is_none() {
            found = self.pending.iter().position(same);
        }
        let forecast = self.pending.remove(found?)?;
        let passed = self.take_while_before(found?, recorded);
        Some(FoundForecast { forecast, passed })
    }

    /// Takes the forecasts that have to precede this report and have not been found.
    pub fn take_reported(&mut self, report: &Message) -> Vec<Message> {
        self.take_while_before(self.pending.len(), report)
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

//! The impacts in a recording.

use std::collections::HashMap;

use rosbag2_mcap::{Decoded, Decoder, Reader, RecordingError};
use serde::Serialize;

use crate::column::{End, Outcome};
use crate::messages::column_twin_msgs::ImpactReport;
use crate::messages::from_column::{end_code, outcome_code};

/// Maximum number of events in a summary.
const MAX_EVENTS: usize = 100_000;

/// One impact event and its outcome. Values that the recording does not contain are `None`.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct EventSummary {
    /// Identifier of the event.
    pub event_id: String,
    /// Identifier of the column.
    pub column_id: String,
    /// Instant of the contact in the event \[ns\].
    pub stamp: Option<i64>,
    /// Mass of the impactor \[kg\].
    pub mass: Option<f64>,
    /// Speed over the ground \[m/s\].
    pub velocity: Option<f64>,
    /// Why the twin rejected the event.
    pub rejected: Option<String>,
    /// Forecast of the peak displacement of the impact point \[m\].
    pub forecast_max_v1: Option<f64>,
    /// Peak displacement of the impact point \[m\].
    pub max_v1: Option<f64>,
    /// Time of the peak after the contact \[s\].
    pub max_v1_time: Option<f64>,
    /// Residual displacement \[m\].
    pub residual_v1: Option<f64>,
    /// Peak contact force \[N\].
    pub peak_contact_force: Option<f64>,
    /// What became of the column.
    pub outcome: Option<Outcome>,
    /// How the response ended.
    pub end: Option<End>,
    /// Why there is no outcome, although the event was accepted: another impact has hit the moving column, for example.
    pub no_outcome: Option<String>,
}

impl EventSummary {
    /// What there is to say of an event without an outcome.
    #[must_use]
    pub fn without_outcome(&self) -> String {
        match (&self.rejected, &self.no_outcome) {
            (Some(reason), _) => format!("rejected: {reason}"),
            (None, Some(reason)) => format!("no report of its own: {reason}"),
            (None, None) => "no report in this recording".to_owned(),
        }
    }
}

/// The impacts of a recording in the order of their first message, and the number of messages about further impacts.
///
/// # Errors
/// The recording cannot be read, or the definition of one of our types in it is wrong. Messages that do not match their
/// definition and damaged records are left out.
pub fn summarise_events(reader: &Reader) -> Result<(Vec<EventSummary>, u64), RecordingError> {
    let mut decoders = Vec::with_capacity(reader.topics().len());
    for topic in reader.topics() {
        decoders.push(match handler(&topic.type_name) {
            Some(handle) => Some((Decoder::new(topic)?, handle)),
            None => None,
        });
    }
    let mut events = Events::default();
    for message in reader.messages() {
        let message = match message {
            Ok(message) => message,
            Err(RecordingError::Damaged { .. }) => continue,
            Err(error) => return Err(error),
        };
        if let Some(Some((decoder, handle))) = decoders.get(message.topic_index)
            && let Ok(content) = decoder.decode(&message)
        {
            handle(&mut events, &content);
        }
    }
    Ok((events.list, events.beyond))
}

/// Adds the content of a message to the events.
type Handler = fn(&mut Events, &Decoded);

fn handler(type_name: &str) -> Option<Handler> {
    match type_name {
        "column_twin_msgs/msg/ImpactEvent" => Some(Events::announced),
        "column_twin_msgs/msg/ImpactReport" => Some(Events::reported),
        "column_twin_msgs/msg/TwinStatus" => Some(Events::status),
        _ => None,
    }
}

#[derive(Default)]
struct Events {
    list: Vec<EventSummary>,
    places: HashMap<(String, String), usize>,
    beyond: u64,
}

impl Events {
    fn of(&mut self, column_id: &str, event_id: &str) -> Option<&mut EventSummary> {
        let key = (column_id.to_owned(), event_id.to_owned());
        let place = match self.places.get(&key) {
            Some(place) => *place,
            None if self.list.len() >= MAX_EVENTS => {
                self.beyond += 1;
                return None;
            }
            None => {
                self.list.push(EventSummary {
                    event_id: event_id.to_owned(),
                    column_id: column_id.to_owned(),
                    ..EventSummary::default()
                });
                self.places.insert(key, self.list.len() - 1);
                self.list.len() - 1
            }
        };
        self.list.get_mut(place)
    }

    fn announced(&mut self, message: &Decoded) {
        let Some(event) = self.of(text(message, "column_id"), text(message, "event_id")) else {
            return;
        };
        event.stamp = stamp(message);
        event.mass = number(message, "mass");
        event.velocity = number(message, "velocity");
    }

    fn reported(&mut self, message: &Decoded) {
        let Some(event) = self.of(text(message, "column_id"), text(message, "event_id")) else {
            return;
        };
        // The event was accepted; the rejection was that of a repetition.
        event.rejected = None;
        let kind = number(message, "kind");
        if kind == Some(f64::from(ImpactReport::FORECAST)) {
            event.forecast_max_v1 = number(message, "max_v1");
        } else if kind == Some(f64::from(ImpactReport::RESULT)) {
            event.max_v1 = number(message, "max_v1");
            event.max_v1_time = number(message, "max_v1_time");
            event.residual_v1 = number(message, "residual_v1");
            event.peak_contact_force = number(message, "peak_contact_force");
            let code = number(message, "outcome").unwrap_or(f64::NAN);
            event.outcome = outcome(code);
            event.end = number(message, "end").and_then(end);
            event.no_outcome = event
                .outcome
                .is_none()
                .then(|| format!("the outcome {code} of its report is unknown to this program"));
        } else if kind == Some(f64::from(ImpactReport::WITHDRAWN))
            || kind == Some(f64::from(ImpactReport::NO_FORECAST))
        {
            let reason = text(message, "action_reason").to_owned();
            match number(message, "end") == Some(f64::from(ImpactReport::END_REJECTED)) {
                true => event.rejected = Some(reason),
                false => event.no_outcome = event.outcome.is_none().then_some(reason),
            }
        }
    }

    fn status(&mut self, message: &Decoded) {
        let rejected = text(message, "last_rejection_event_id");
        if rejected.is_empty() {
            return;
        }
        let reason = text(message, "last_rejection_reason").to_owned();
        if let Some(event) = self.of(text(message, "column_id"), rejected) {
            let accepted = event.forecast_max_v1.is_some()
                || event.outcome.is_some()
                || event.no_outcome.is_some();
            event.rejected = (!accepted).then_some(reason);
        }
    }
}

fn text<'a>(message: &'a Decoded, field: &str) -> &'a str {
    message
        .field(field)
        .and_then(Decoded::as_text)
        .unwrap_or_default()
}

/// The number in a field; NaN means that there is none.
fn number(message: &Decoded, field: &str) -> Option<f64> {
    message
        .field(field)
        .and_then(Decoded::as_f64)
        .filter(|number| !number.is_nan())
}

fn stamp(message: &Decoded) -> Option<i64> {
    let part = |name: &str| number(message, name).map(|it| it as i64);
    let seconds = part("header.stamp.sec")?;
    seconds
        .checked_mul(1_000_000_000)?
        .checked_add(part("header.stamp.nanosec")?)
}

fn outcome(code: f64) -> Option<Outcome> {
    let all = [
        Outcome::Elastic,
        Outcome::Plastic,
        Outcome::Collapsed,
        Outcome::Fractured,
    ];
    all.into_iter()
        .find(|it| f64::from(outcome_code(*it)) == code)
}

fn end(code: f64) -> Option<End> {
    let all = [
        End::AtRest,
        End::DurationReached,
        End::Collapsed,
        End::Fractured,
        End::NotConverged,
    ];
    all.into_iter().find(|it| f64::from(end_code(*it)) == code)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(numbers: &[(&str, f64)], texts: &[(&str, &str)]) -> Decoded {
        let numbers = numbers
            .iter()
            .map(|(name, it)| ((*name).into(), Decoded::Float64(*it)));
        let texts = texts
            .iter()
            .map(|(name, it)| ((*name).into(), Decoded::Text((*it).to_owned())));
        Decoded::Fields(numbers.chain(texts).collect())
    }

    fn rejection(id: &str) -> Decoded {
        let reason = ("last_rejection_reason", "it was there before");
        message(
            &[],
            &[("column_id", "c"), ("last_rejection_event_id", id), reason],
        )
    }

    /// A rejected repetition does not change the impact, whichever message is read first.
    #[test]
    fn a_rejected_repetition_does_not_make_its_impact_rejected() {
        let report = |id, kind, value| {
            let names = [("column_id", "c"), ("event_id", id)];
            message(&[("kind", f64::from(kind)), value], &names)
        };
        let mut events = Events::default();
        events.status(&rejection("rejected"));
        events.status(&rejection("first"));
        events.reported(&report("first", ImpactReport::FORECAST, ("max_v1", 0.1)));
        let outcome = ("outcome", f64::from(ImpactReport::PLASTIC));
        events.reported(&report("then", ImpactReport::RESULT, outcome));
        events.status(&rejection("then"));
        let rejected: Vec<_> = events
            .list
            .iter()
            .map(|it| (it.event_id.as_str(), it.rejected.is_some()))
            .collect();
        assert_eq!(
            rejected,
            [("rejected", true), ("first", false), ("then", false)]
        );
    }

    fn reported(kind: u8, outcome: u8, end: u8, reason: &str) -> EventSummary {
        let numbers = [
            ("kind", f64::from(kind)),
            ("outcome", f64::from(outcome)),
            ("end", f64::from(end)),
        ];
        let texts = [
            ("column_id", "c"),
            ("event_id", "e"),
            ("action_reason", reason),
        ];
        let mut events = Events::default();
        events.reported(&message(&numbers, &texts));
        events.list.remove(0)
    }

    /// A fractured column had no report.
    #[test]
    fn every_outcome_is_known() {
        for (code, outcome) in [
            (ImpactReport::ELASTIC, Outcome::Elastic),
            (ImpactReport::PLASTIC, Outcome::Plastic),
            (ImpactReport::COLLAPSED, Outcome::Collapsed),
            (ImpactReport::FRACTURED, Outcome::Fractured),
        ] {
            let event = reported(ImpactReport::RESULT, code, ImpactReport::END_AT_REST, "");
            assert_eq!((event.outcome, event.no_outcome), (Some(outcome), None));
        }
        let later = reported(ImpactReport::RESULT, 9, ImpactReport::END_AT_REST, "");
        assert_eq!(
            later.without_outcome(),
            "no report of its own: the outcome 9 of its report is unknown to this program"
        );
    }

    #[test]
    fn an_event_without_an_outcome_says_why() {
        let without = |kind, end| reported(kind, ImpactReport::OUTCOME_UNKNOWN, end, "the reason");
        let overtaken = without(ImpactReport::WITHDRAWN, ImpactReport::END_SUPERSEDED);
        assert_eq!(
            (overtaken.outcome, overtaken.without_outcome().as_str()),
            (None, "no report of its own: the reason")
        );
        let rejected = without(ImpactReport::NO_FORECAST, ImpactReport::END_REJECTED);
        assert_eq!(rejected.without_outcome(), "rejected: the reason");
        let unknown = EventSummary::default().without_outcome();
        assert_eq!(unknown, "no report in this recording");
    }
}

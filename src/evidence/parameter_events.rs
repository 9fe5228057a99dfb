//! Compares the messages on `/parameter_events` with the parameters of the recomputed twin.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::comparison::{Difference, Place};
use super::policy::UNNAMED;
use super::verification::Verification;
use crate::messages::cdr;
use crate::messages::rcl_interfaces::{Parameter, ParameterEvent, ParameterValue};
use crate::parameters::{Parameters, Value};

/// Recorded events that wait for the next entry of the journal: the event of a change precedes the entry of its command.
#[derive(Debug, Default)]
pub(super) struct ParameterEvents {
    waiting: Vec<Event>,
    /// Name of the node in the first event.
    node: Option<String>,
}

#[derive(Debug)]
struct Event {
    event: ParameterEvent,
    place: Difference,
}

impl ParameterEvents {
    /// Takes a recorded event whose names are those of the parameters of the column.
    fn take(&mut self, event: ParameterEvent, place: &Place<'_>, found: &mut Verification) {
        let node = self.node.get_or_insert_with(|| event.node.clone());
        if *node != event.node {
            let node = node.clone();
            found.note_difference(place.difference("node", event.node.clone(), node));
        }
        self.waiting.push(Event {
            place: place.difference("the message", "present", "absent"),
            event,
        });
    }

    /// Compares the events since the last entry of the journal with the parameters `before` and `after` the present one; `None` if
    /// they are not known.
    pub fn entry(
        &mut self,
        before: Option<&Parameters>,
        after: Option<&Parameters>,
        found: &mut Verification,
    ) {
        for Event { event, place } in self.waiting.drain(..) {
            let (Some(before), Some(after)) = (before, after) else {
                found.parameter_events.unchecked += 1;
                continue;
            };
            found.parameter_events.compared += 1;
            let at = Place {
                topic: &place.topic,
                log_time: place.log_time,
                stamp: event.stamp.to_nanos(),
                ..Place::default()
            };
            let difference = match event.new_parameters.is_empty() {
                true => changed(&event, after, &at),
                // All parameters are announced once, at any time.
                false => announced(&event, before, &at).and(announced(&event, after, &at)),
            };
            if let Some(difference) = difference {
                found.parameter_events.differing += 1;
                found.note_difference(difference);
            }
        }
    }

    /// Ends the recording: events after the last entry are not compared.
    pub fn finish(self, found: &mut Verification) {
        found.parameter_events.unchecked += self.waiting.len() as u64;
    }
}

/// A recorded event about one column.
#[derive(Debug)]
pub(super) struct EventOfColumn {
    /// [`UNNAMED`] if the names of the parameters do not begin with that of the column.
    pub column_id: Arc<str>,
    /// With the names of the parameters in the column.
    event: ParameterEvent,
}

impl EventOfColumn {
    /// Reads a recorded event of a fleet of these columns, or of a single twin; the error is the difference.
    pub fn decode(
        bytes: &[u8],
        fleet: Option<&BTreeSet<Arc<str>>>,
        place: &Place<'_>,
    ) -> Result<Self, Box<Difference>> {
        let mut event: ParameterEvent = cdr::decode(bytes).map_err(|it| place.unreadable(&it))?;
        let Some(fleet) = fleet else {
            let column_id = UNNAMED.into();
            return Ok(Self { column_id, event });
        };
        let other = |name: &str| {
            let own = "parameters of one column of the fleet";
            Box::new(place.difference("the message", format!("a change of {name:?}"), own))
        };
        let first = event.changed_parameters.first().map_or("", |it| &it.name);
        // An identifier may contain dots.
        let column_id = first
            .rmatch_indices('.')
            .find_map(|(dot, _)| fleet.get(&first[..dot]))
            .cloned()
            .ok_or_else(|| other(first))?;
        for parameter in &mut event.changed_parameters {
            let name = parameter.name.strip_prefix(&*column_id);
            let name = name.and_then(|it| it.strip_prefix('.'));
            let name = name.ok_or_else(|| other(&parameter.name))?;
            parameter.name = name.to_owned();
        }
        Ok(Self { column_id, event })
    }

    /// Gives the event to what is known of its column.
    pub fn take(self, known: &mut ParameterEvents, place: &Place<'_>, found: &mut Verification) {
        found.parameter_events.recorded += 1;
        known.take(self.event, place, found);
    }
}

/// The first difference between the announced parameters and these.
fn announced(event: &ParameterEvent, own: &Parameters, place: &Place<'_>) -> Option<Difference> {
    let all: Vec<_> = own
        .iter()
        .map(|(parameter, value)| parameter_of(parameter.name, value))
        .collect();
    let content = |new: &[Parameter]| serde_json::json!({ "new_parameters": new });
    place
        .first_difference(&content(&event.new_parameters), &content(&all))
        .or_else(|| without_others(&event.changed_parameters, event, place))
}

/// The first difference between the changed parameters and these.
fn changed(event: &ParameterEvent, own: &Parameters, place: &Place<'_>) -> Option<Difference> {
    let own: Vec<_> = event
        .changed_parameters
        .iter()
        .map(|it| own.get(&it.name).map(|value| parameter_of(&it.name, value)))
        .collect();
    if own.is_empty() {
        return Some(place.difference("changed_parameters", "empty", "at least one"));
    }
    let recorded = serde_json::json!({ "changed_parameters": event.changed_parameters });
    let own = serde_json::json!({ "changed_parameters": own });
    place
        .first_difference(&recorded, &own)
        .or_else(|| without_others(&[], event, place))
}

/// A difference if the event has more than the parameters that were compared.
fn without_others(
    changed: &[Parameter],
    event: &ParameterEvent,
    place: &Place<'_>,
) -> Option<Difference> {
    let others = changed.len() + event.deleted_parameters.len();
    (others > 0).then(|| place.difference("further parameters", others.to_string(), "none"))
}

fn parameter_of(name: &str, value: Value) -> Parameter {
    let mut message = ParameterValue::default();
    match value {
        Value::Bool(value) => (message.kind, message.bool_value) = (1, value),
        Value::Integer(value) => (message.kind, message.integer_value) = (2, value),
        Value::Double(value) => (message.kind, message.double_value) = (3, value),
        Value::String(value) => (message.kind, message.string_value) = (4, value),
        Value::DoubleArray(values) => (message.kind, message.double_array_value) = (8, values),
        Value::StringArray(values) => (message.kind, message.string_array_value) = (9, values),
    }
    Parameter {
        name: name.to_owned(),
        value: message,
    }
}

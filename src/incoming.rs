//! Converts received messages to commands, and measurements to batches. The node and `verify` share this conversion: the journal must contain exactly the
//! command that follows from each recorded message.

use crate::endpoints::COLUMN_PARAMETERS;
use crate::estimation::RawBatch;
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin_msgs::{
    ColumnParameters, ImpactEvent, Measurement, ParameterEntry,
};
use crate::parameters::Value;
use crate::time::{INVALID_STAMP, Nanos};
use crate::twin::{Command, ImpactCommand, Rejection, RejectionCode};

/// The command of a message on `impact_event`.
#[must_use]
pub fn impact_command(event: ImpactEvent) -> Command {
    Command::Impact(ImpactCommand {
        stamp: nanos(event.header.stamp),
        impact: (&event).into(),
        vehicle: event.vehicle,
        event_id: event.event_id,
        column_id: event.column_id,
    })
}

/// The command of a message on `column_parameters` to the twin of the column `own`.
#[must_use]
pub fn column_command(message: &ColumnParameters, own: &str) -> Command {
    let source = COLUMN_PARAMETERS.name.into();
    let found = &message.column_id;
    if found == own {
        return Command::SetParameters {
            changes: changes(message),
            source,
        };
    }
    let reason =
        format!("the message is for column {found:?}, but this is the twin of column {own:?}");
    Command::RejectedChange {
        rejection: Rejection::new(RejectionCode::OtherColumn, reason),
        source,
    }
}

/// The batch of a message on `measurements`, as the intake takes it.
#[must_use]
pub fn raw_batch(measurement: &Measurement) -> RawBatch<'_> {
    RawBatch {
        column_id: &measurement.column_id,
        sensor_id: &measurement.sensor_id,
        stamp: nanos(measurement.header.stamp),
        sample_period: measurement.sample_period,
        values: &measurement.values,
    }
}

/// The time of a stamp. One with a second or more of nanoseconds is no time, and becomes one that every check rejects.
pub fn nanos(stamp: Time) -> Nanos {
    stamp.to_nanos().unwrap_or(INVALID_STAMP)
}

/// The parameters that the message changes.
fn changes(message: &ColumnParameters) -> Vec<(String, Value)> {
    message
        .entries()
        .filter(|(_, entry)| !entry.is_unchanged())
        .map(|(name, entry)| {
            let value = match entry {
                ParameterEntry::Number(number) => Value::Double(number),
                ParameterEntry::Text(text) => Value::from(text),
            };
            (name.to_owned(), value)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unset_parameters_are_left_unchanged() {
        let message = ColumnParameters {
            top_load: 2e5,
            section_name: "HEB300".to_owned(),
            impact_gap: f64::INFINITY,
            ..ColumnParameters::default()
        };
        let expected = [
            ("section.name", Value::from("HEB300")),
            ("top.load", Value::Double(2e5)),
            ("impact.gap", Value::Double(f64::INFINITY)),
        ];
        assert_eq!(
            changes(&message),
            expected.map(|(name, value)| (name.to_owned(), value))
        );
    }

    /// It was taken for a later one.
    #[test]
    fn a_stamp_with_a_second_or_more_of_nanoseconds_is_no_time() {
        let of = |nanosec| nanos(Time { sec: 1, nanosec });
        assert_eq!(of(999_999_999), 1_999_999_999);
        for nanosec in [1_000_000_000, u32::MAX] {
            assert_eq!(of(nanosec), INVALID_STAMP);
        }
    }
}

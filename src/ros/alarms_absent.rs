//! Alarms in a program without the feature `alarm`: says so if the parameters ask for them.

use crate::parameters::AlarmSettings;

use super::node::NodeError;

/// Fails if the parameters ask for alarms.
pub(super) fn none_wanted(settings: &AlarmSettings) -> Result<(), NodeError> {
    match settings.mqtt.broker.is_empty() && settings.webhook.url.is_empty() {
        true => Ok(()),
        false => Err(NodeError::Alarms(
            "this program was built without alarms; build it with the feature `alarm`, or leave alarm.mqtt.broker and \
             alarm.webhook.url empty"
                .to_owned(),
        )),
    }
}

//! Replies that are short enough to arrive.
//!
//! RustDDS 0.15.1 writes a byte too many into every fragment of a message that has inline QoS, as every reply has (its
//! `DataFrag::write_to` writes an `Option` where a list is due). A reply that does not fit one datagram never arrives,
//! and in a build with debug assertions ends the participant's event loop. So replies are kept below that.

use byteorder::LittleEndian;
use ros2_client::rcl_interfaces::{
    DescribeParametersResponse, GetParameterTypesResponse, GetParametersResponse,
    ListParametersResponse, SetParametersAtomicallyResponse, SetParametersResponse,
};
use serde::Serialize;

use crate::messages::column_twin::PredictImpactResponse;
use crate::messages::std_srvs::TriggerResponse;

/// Longest reply \[bytes\] that RustDDS does not fragment, whatever the reader: an Ethernet frame less the headers is 1372.
const LONGEST_REPLY: usize = 1280;

/// What all reasons of a shortened reply have together \[bytes\].
const REASONS: usize = 640;

/// A reply that can be made to fit.
pub(super) trait Reply: Serialize {
    /// Leaves out what is not needed, or all where everything is.
    fn shorten(&mut self);
}

/// The reply, if need be shortened, which is said.
pub(super) fn fitting<R: Reply>(mut reply: R, service: &str) -> R {
    let length = length(&reply);
    if length > LONGEST_REPLY {
        reply.shorten();
        tracing::warn!(
            "the reply of {service} would have {length} bytes, and no more than {LONGEST_REPLY} arrive (RustDDS 0.15.1); \
             it is shortened. Ask for fewer names at once"
        );
    }
    reply
}

fn length(reply: &impl Serialize) -> usize {
    let mut bytes = Vec::new();
    // What cannot be written is not too long; sending it says what is wrong with it.
    let _ = cdr_encoding::to_writer::<_, LittleEndian, _>(&mut bytes, reply);
    bytes.len()
}

impl Reply for ListParametersResponse {
    /// The names are what is asked for; the groups stand in them.
    fn shorten(&mut self) {
        self.result.prefixes.clear();
    }
}

impl Reply for GetParametersResponse {
    /// No values, which is rclcpp's way to say that it failed: a part would be taken for the whole.
    fn shorten(&mut self) {
        self.values.clear();
    }
}

impl Reply for GetParameterTypesResponse {
    fn shorten(&mut self) {
        self.values.clear();
    }
}

impl Reply for DescribeParametersResponse {
    fn shorten(&mut self) {
        self.values.clear();
    }
}

impl Reply for SetParametersResponse {
    fn shorten(&mut self) {
        let each = REASONS / self.results.len().max(1);
        for result in &mut self.results {
            cut(&mut result.reason, each);
        }
    }
}

impl Reply for SetParametersAtomicallyResponse {
    fn shorten(&mut self) {
        cut(&mut self.result.reason, REASONS);
    }
}

impl Reply for TriggerResponse {
    fn shorten(&mut self) {
        cut(&mut self.message, REASONS);
    }
}

impl Reply for PredictImpactResponse {
    fn shorten(&mut self) {
        cut(&mut self.message, REASONS / 2);
        cut(&mut self.report.event_id, REASONS / 4);
        cut(&mut self.report.column_id, REASONS / 4);
    }
}

/// Cuts a text to `most` bytes and marks that it goes on.
fn cut(text: &mut String, most: usize) {
    const MARK: &str = "...";
    if text.len() > most {
        let end = most.saturating_sub(MARK.len());
        let end = (0..=end).rev().find(|&at| text.is_char_boundary(at));
        text.truncate(end.unwrap_or(0));
        text.push_str(MARK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{PARAMETERS, Parameters};
    use crate::ros::parameter_services::{describe, get, list};
    use ros2_client::parameters::raw::SetParametersResult;
    use ros2_client::rcl_interfaces::{
        DescribeParametersRequest, GetParametersRequest, ListParametersRequest,
    };

    #[test]
    fn all_names_arrive() {
        let all = list(&ListParametersRequest {
            prefixes: vec![],
            depth: 0,
        });
        let all = fitting(all, "list");
        assert_eq!(all.result.names.len(), PARAMETERS.len());
        assert!(length(&all) <= LONGEST_REPLY, "{}", length(&all));
    }

    #[test]
    fn each_parameter_alone_arrives_whole() {
        for parameter in PARAMETERS {
            let names = vec![parameter.name.to_owned()];
            let value = get(
                &Parameters::default(),
                &GetParametersRequest {
                    names: names.clone(),
                },
            );
            assert_eq!(fitting(value, "get").values.len(), 1);
            let description = describe(&DescribeParametersRequest { names });
            assert_eq!(fitting(description, "describe").values.len(), 1);
        }
    }

    #[test]
    fn reasons_are_cut_and_all_results_stay() {
        let refused = SetParametersResult {
            successful: false,
            reason: "\u{e4}".repeat(1000),
        };
        for count in [1, 10, 50] {
            let reply = SetParametersResponse {
                results: vec![refused.clone(); count],
            };
            let reply = fitting(reply, "set");
            assert_eq!(reply.results.len(), count);
            assert!(reply.results[0].reason.ends_with("..."));
            assert!(length(&reply) <= LONGEST_REPLY, "{}", length(&reply));
        }
    }
}

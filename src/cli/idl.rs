//! `column-twin idl`: the topics of the node for DDS programs without ROS.

use std::io::Write;

use clap::Args;

use super::failure::{Exit, Failure, printed};
use column_twin::messages::{self, idl::idl};
use column_twin::ros::NODE_NAME;
use column_twin::ros::qos::{Direction, ENDPOINTS, Endpoint};

/// Arguments of `column-twin idl`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct IdlArgs {}

const EXAMPLE: &str = "\
Example: read the column's state in C with Cyclone DDS
  column-twin idl > column_twin.idl && idlc column_twin.idl
  # then subscribe to the topic rt/column_state, type column_twin_msgs::msg::dds_::ColumnState_

Exit codes: 0 done, 1 failed.";

/// Prints topics and types.
pub fn run(_: &IdlArgs, out: &mut impl Write) -> Result<(), Failure> {
    let topics: Vec<_> = ENDPOINTS
        .iter()
        .filter(|endpoint| endpoint.direction != Direction::Service)
        .filter_map(|endpoint| Some((endpoint, messages::find(endpoint.type_name)?)))
        .collect();
    let types: Vec<_> = topics.iter().map(|(_, interface)| *interface).collect();
    let definitions =
        idl(&types, messages::INTERFACES).map_err(|error| Failure::plain(Exit::Failed, error))?;
    let mut text = HEAD.to_owned();
    for (endpoint, interface) in topics {
        text += &topic(endpoint, &interface.dds_name());
    }
    printed(writeln!(out, "{text}\n{definitions}"))
}

const HEAD: &str = "\
// Topics of the node column_twin on the wire, for DDS programs without ROS. Written by `column-twin idl`.
// Encoding: plain CDR, little endian. The namespace of the node comes between rt/ and the name: rt/garage/column_state.
//
";

fn topic(endpoint: &Endpoint, type_name: &str) -> String {
    let qos = endpoint.qos;
    format!(
        "// {:4} rt/{:<18} {type_name}: {}, {}, keep last {}\n",
        match endpoint.direction {
            Direction::In => "to",
            Direction::Out | Direction::Service => "from",
        },
        endpoint
            .name
            .replacen('~', NODE_NAME, 1)
            .trim_start_matches('/'),
        match qos.reliable {
            true => "reliable",
            false => "best effort",
        },
        match qos.transient_local {
            true => "transient local",
            false => "volatile",
        },
        qos.depth,
    )
}

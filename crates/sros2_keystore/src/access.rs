//! What the programs of an enclave may publish and subscribe to.

use std::collections::BTreeSet;

use crate::enclave_name::EnclaveName;

/// Topics and services by their full ROS names, without a name twice and in order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Access {
    /// Topics that may be published.
    pub publish: BTreeSet<String>,
    /// Topics that may be subscribed to.
    pub subscribe: BTreeSet<String>,
    /// Services that may be offered.
    pub reply: BTreeSet<String>,
    /// Services that may be called.
    pub request: BTreeSet<String>,
}

/// An enclave to be made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EnclavePlan {
    /// Its name.
    pub name: EnclaveName,
    /// What its programs may do.
    pub access: Access,
}

/// The topic by which the nodes of ROS 2 find one another; every participant reads and writes it.
const DISCOVERY: &str = "ros_discovery_info";

impl Access {
    /// Names of the DDS topics that may be published: `rt` before a topic, `rq` and `rr` before the requests and replies of a
    /// service.
    #[must_use]
    pub fn dds_publish(&self) -> BTreeSet<String> {
        dds_topics(&self.publish, &self.request, &self.reply)
    }

    /// Names of the DDS topics that may be subscribed to.
    #[must_use]
    pub fn dds_subscribe(&self) -> BTreeSet<String> {
        dds_topics(&self.subscribe, &self.reply, &self.request)
    }
}

fn dds_topics(
    topics: &BTreeSet<String>,
    requests: &BTreeSet<String>,
    replies: &BTreeSet<String>,
) -> BTreeSet<String> {
    let topics = topics.iter().map(|name| format!("rt{name}"));
    let requests = requests.iter().map(|name| format!("rq{name}Request"));
    let replies = replies.iter().map(|name| format!("rr{name}Reply"));
    let all = topics.chain(requests).chain(replies);
    all.chain([DISCOVERY.to_owned()]).collect()
}

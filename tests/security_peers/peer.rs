//! A bare DDS participant: unlike the node, it does not check its own files, so that it can be as hostile as its stack lets it.

use std::net::{IpAddr, Ipv4Addr};
use std::path::Path;
use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{ColumnState, ImpactEvent, TwinStatus};
use column_twin::ros::qos::{self, Endpoint};
use rustdds::no_key::{DataReader, DataWriter};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, DomainParticipantSecurityConfigFiles, QosPolicies,
    ReadCondition, Topic, TopicKind,
};
use serde::de::DeserializeOwned;

/// A peer that writes impact events and reads what the twin publishes.
pub struct Peer {
    events: DataWriter<ImpactEvent>,
    statuses: DataReader<TwinStatus>,
    states: DataReader<ColumnState>,
    sent: u64,
    pub received: u64,
    _participant: DomainParticipant,
}

impl Peer {
    /// With the files of an enclave, or without any.
    pub fn start(domain_id: u16, enclave: Option<&Path>) -> Self {
        Self::of(participant(domain_id, enclave))
    }

    /// With a stack that does not check its own permissions.
    pub fn without_own_checks(domain_id: u16, enclave: &Path) -> Self {
        let builder = builder(domain_id, Some(enclave)).without_own_permission_checks();
        Self::of(builder.build().expect("a participant"))
    }

    fn of(participant: DomainParticipant) -> Self {
        let publisher = participant
            .create_publisher(&QosPolicies::default())
            .unwrap();
        let (topic, policies) = topic(&participant, &qos::IMPACT_EVENT);
        let events = publisher.create_datawriter_no_key_cdr(&topic, Some(policies));
        Self {
            events: events.unwrap(),
            statuses: reader(&participant, &qos::TWIN_STATUS),
            states: reader(&participant, &qos::COLUMN_STATE),
            sent: 0,
            received: 0,
            _participant: participant,
        }
    }

    /// Sends events at 10 Hz and reads for this time.
    pub fn try_for(&mut self, time: Duration) {
        let end = Instant::now() + time;
        while Instant::now() < end {
            self.try_once();
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Sends one event, and reads what is there.
    pub fn try_once(&mut self) {
        self.sent += 1;
        let event = ImpactEvent {
            column_id: "column".to_owned(),
            event_id: format!("hostile-{}", self.sent),
            mass: 1500.0,
            velocity: 1.0,
            ..ImpactEvent::default()
        };
        // A writer whose window is full has no reader that acknowledges.
        let _ = self.events.write(event, None);
        self.received += taken(&mut self.statuses) + taken(&mut self.states);
    }
}

/// A participant on loopback.
pub fn participant(domain_id: u16, enclave: Option<&Path>) -> DomainParticipant {
    builder(domain_id, enclave).build().expect("a participant")
}

fn builder(domain_id: u16, enclave: Option<&Path>) -> DomainParticipantBuilder {
    let localhost = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let builder = DomainParticipantBuilder::new(domain_id).with_only_networks([localhost]);
    match enclave {
        Some(folder) => {
            let files =
                DomainParticipantSecurityConfigFiles::with_ros_default_names(folder, String::new());
            builder.builtin_security(files)
        }
        None => builder,
    }
}

fn topic(participant: &DomainParticipant, endpoint: &Endpoint) -> (Topic, QosPolicies) {
    let policies = QosPolicies::from(endpoint.qos.profile());
    let (package, name) = endpoint.type_name.split_once("/msg/").unwrap();
    let topic = participant.create_topic(
        format!("rt/{}", endpoint.name),
        format!("{package}::msg::dds_::{name}_"),
        &policies,
        TopicKind::NoKey,
    );
    (topic.unwrap(), policies)
}

fn reader<M: DeserializeOwned + 'static>(
    participant: &DomainParticipant,
    endpoint: &Endpoint,
) -> DataReader<M> {
    let (topic, policies) = topic(participant, endpoint);
    let subscriber = participant
        .create_subscriber(&QosPolicies::default())
        .unwrap();
    subscriber
        .create_datareader_no_key_cdr(&topic, Some(policies))
        .unwrap()
}

fn taken<M: DeserializeOwned + 'static>(reader: &mut DataReader<M>) -> u64 {
    let samples = reader.take(1000, ReadCondition::any()).unwrap_or_default();
    samples.len() as u64
}

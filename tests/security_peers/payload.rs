//! Encrypted payloads.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use column_twin::ros::qos;
use rustdds::{QosPolicies, ReadCondition, TopicKind};
use serde::{Deserialize, Serialize};

use super::by_openssl::{Keystore, SROS_DEFAULT};
use super::domain::{Domain, PATIENCE};
use super::peer::participant;

/// A message that ends with its text: its length on the wire is that of the text, and 9 bytes.
#[derive(Debug, Serialize, Deserialize)]
struct Text {
    text: String,
}

/// DATA is padded to 4 bytes: RustDDS 0.15.1 looked for the end of an encrypted payload after the padding, and lost three of
/// four messages.
#[test]
fn an_encrypted_payload_arrives_whatever_its_length() {
    let (domain, keystore) = (Domain::fresh(), Keystore::new());
    let files = ["/writer", "/reader"]
        .map(|name| keystore.write(&keystore.unrestricted(name, &SROS_DEFAULT)));
    let [writing, reading] =
        files.map(|files| participant(domain.environment.domain_id, Some(&files)));
    // Reliable and transient local: what was sent before the reader was found arrives as well.
    let policies = QosPolicies::from(qos::IMPACT_REPORT.qos.profile());
    let topic = |of: &rustdds::DomainParticipant| {
        let (name, kind) = ("rt/text".to_owned(), "test::msg::dds_::Text_".to_owned());
        of.create_topic(name, kind, &policies, TopicKind::NoKey)
            .unwrap()
    };
    let subscriber = reading.create_subscriber(&policies).unwrap();
    let mut reader = subscriber
        .create_datareader_no_key_cdr::<Text>(&topic(&reading), None)
        .unwrap();
    let publisher = writing.create_publisher(&policies).unwrap();
    let writer = publisher
        .create_datawriter_no_key_cdr::<Text>(&topic(&writing), None)
        .unwrap();
    let lengths = 0..9;
    let (mut arrived, deadline) = (BTreeSet::new(), Instant::now() + PATIENCE);
    while arrived.len() < lengths.len() && Instant::now() < deadline {
        for length in lengths.clone() {
            let text = "x".repeat(length);
            writer.write(Text { text }, None).unwrap();
        }
        std::thread::sleep(Duration::from_millis(200));
        let samples = reader.take(1000, ReadCondition::any()).unwrap();
        arrived.extend(samples.iter().map(|it| it.value().text.len()));
    }
    assert_eq!(arrived, lengths.collect(), "lengths that arrived");
}

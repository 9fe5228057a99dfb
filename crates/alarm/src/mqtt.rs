//! Delivery by MQTT 5.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use rumqttc::v5::mqttbytes::QoS;
use rumqttc::v5::mqttbytes::v5::{
    DisconnectReasonCode, LastWill, LastWillProperties, Packet, PubAckReason, PublishProperties,
};
use rumqttc::v5::{AsyncClient, ConnectionError, Event, EventLoop, MqttOptions, StateError};
use rumqttc::{Outgoing, TlsConfiguration, Transport};
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

use crate::backoff::Backoff;
use crate::error::StartError;
use crate::message::{Message, State};
use crate::rules::Rules;
use crate::secret::read_secret;
use crate::sender::{LEAST_WAIT, LONGEST_WAIT, Pulse, SendFault, Sender, time_of_day};
use crate::spool::Next;
use crate::tls::{Identity, TlsFiles};
use crate::topic::TopicTemplate;
use crate::webhook::{in_words, is_this_machine};

/// How often the connection is tried when nothing is sent: the broker publishes the will one and a half times later.
const KEEP_ALIVE: Duration = Duration::from_secs(10);
/// Longest time until the broker acknowledges a message or a connection.
const TIMEOUT: Duration = Duration::from_secs(10);
/// Largest packet of a broker \[bytes\]; it sends acknowledgements only.
const MAX_PACKET: u32 = 64 * 1024;
/// Requests and events between the tasks: one message is on its way at a time, and a heartbeat.
const QUEUE: usize = 16;

/// Where and how to publish.
#[derive(Debug, Clone, Default)]
pub struct MqttSettings {
    /// `mqtts://HOST:PORT`, or `mqtt://HOST:PORT` without TLS.
    pub broker: String,
    /// The name by which the broker knows this client; another client with it would be disconnected.
    pub client_id: String,
    /// The template of the topics, see [`TopicTemplate`].
    pub topic: String,
    /// The user, if the broker asks for one.
    pub user: Option<String>,
    /// The file with the user's password, mode 0600.
    pub password_file: Option<PathBuf>,
    /// The files of TLS.
    pub tls: TlsFiles,
    /// What is delivered.
    pub rules: Rules,
}

/// A broker.
pub(crate) struct Broker {
    options: MqttOptions,
    address: String,
    topic: TopicTemplate,
}

impl Broker {
    pub fn new(settings: &MqttSettings) -> Result<Self, StartError> {
        let topic = TopicTemplate::new(&settings.topic)?;
        let broker = &settings.broker;
        let (encrypted, host, port) =
            address(broker).ok_or_else(|| StartError::Broker(broker.clone()))?;
        let mut options = MqttOptions::new(&settings.client_id, host, port);
        options
            .set_keep_alive(KEEP_ALIVE)
            .set_clean_start(true)
            .set_connection_timeout(TIMEOUT.as_secs())
            .set_max_packet_size(Some(MAX_PACKET));
        if encrypted {
            let config = Identity::read(&settings.tls)?.config()?;
            let config = TlsConfiguration::Rustls(Arc::new(config));
            options.set_transport(Transport::tls_with_config(config));
        } else if settings.tls.are_given() {
            return Err(StartError::TlsWithoutTls(broker.clone()));
        }
        match (&settings.user, &settings.password_file) {
            (None, None) => {}
            (Some(user), None) => {
                options.set_credentials(user, "");
            }
            (Some(_), Some(_)) if !encrypted && !is_this_machine(host) => {
                return Err(StartError::PasswordWithoutTls(broker.clone()));
            }
            (Some(user), Some(path)) => {
                let text = read_secret(path)?;
                options.set_credentials(user, text.trim_end_matches(['\r', '\n']));
            }
            (None, Some(_)) => return Err(StartError::PasswordWithoutUser),
        }
        Ok(Self {
            options,
            address: broker.clone(),
            topic,
        })
    }

    fn topic(&self, message: &Message) -> String {
        self.topic.topic(&message.node, &message.watched)
    }

    /// Delivers until the end.
    pub async fn run(&self, sender: &Sender) {
        let mut backoff = Backoff::default();
        let mut pulse = Pulse::new(sender.heartbeat);
        let mut connected_before = false;
        while let Err(broken) = self
            .connection(sender, &mut backoff, &mut pulse, &mut connected_before)
            .await
        {
            let wait = backoff.failed();
            sender.channel().failed(&broken, wait);
            let resume = sender.now() + wait;
            // A fresh alarm does not wait for a minute, because the broker may be back.
            let first = wait.min(LEAST_WAIT);
            if !pause(sender, first).await {
                let rest = resume.saturating_sub(sender.now());
                tokio::select! {
                    () = sleep(rest) => {}
                    () = sender.bell.heard() => {}
                }
            }
            if sender.ends() {
                return;
            }
        }
    }

    /// One connection, until it breaks (`Err`) or everything is delivered at the end (`Ok`).
    async fn connection(
        &self,
        sender: &Sender,
        backoff: &mut Backoff,
        pulse: &mut Pulse,
        connected_before: &mut bool,
    ) -> Result<(), String> {
        let mut options = self.options.clone();
        if let Some(will) = sender.channel().will() {
            options.set_last_will(self.last_will(&will));
        }
        let mut link = Link::open(options);
        let mut connected = false;
        // Whether the last acknowledgement was a rejection, which would explain why the broker hangs up.
        let mut was_rejected = false;
        // The message on its way, and when its acknowledgement is overdue.
        let mut on_its_way: Option<(u64, String, Duration)> = None;
        loop {
            let now = sender.now();
            let mut due = now + LONGEST_WAIT;
            if connected && on_its_way.is_none() {
                let next = sender.channel().next(now);
                match next {
                    Next::Send(it) => {
                        let topic = self.topic(&it.message);
                        link.publish(&topic, QoS::AtLeastOnce, &it.message);
                        on_its_way = Some((it.number, topic, now + TIMEOUT));
                    }
                    Next::At(time) => due = time,
                    Next::Nothing if sender.ends() => {
                        link.close().await;
                        return Ok(());
                    }
                    Next::Nothing => {}
                }
                if pulse.is_due(now, sender.signs_of_life.load(Ordering::Relaxed)) {
                    let message = sender.channel().heartbeat(time_of_day());
                    link.publish(&self.topic(&message), QoS::AtMostOnce, &message);
                    sender.channel().heartbeat_sent();
                }
                if let Some(beat) = pulse.next() {
                    due = due.min(beat);
                }
            }
            if let Some((_, _, overdue)) = &on_its_way {
                if *overdue <= now {
                    return Err(format!("{} does not acknowledge a message", self.address));
                }
                due = due.min(*overdue);
            }
            tokio::select! {
                event = link.events.recv_async() => match event {
                    Ok(Ok(Event::Incoming(Packet::ConnAck(_)))) => {
                        connected = true;
                        let mut channel = sender.channel();
                        if std::mem::replace(connected_before, true) {
                            channel.reconnected(time_of_day());
                        }
                        if matches!(channel.next(sender.now()), Next::Nothing) {
                            backoff.succeeded();
                            channel.works();
                        }
                    }
                    Ok(Ok(Event::Incoming(Packet::PubAck(ack)))) => {
                        if let Some((number, topic, _)) = on_its_way.take() {
                            let mut channel = sender.channel();
                            match self.rejection(&topic, ack.reason) {
                                None => {
                                    backoff.succeeded();
                                    was_rejected = false;
                                    channel.delivered(number);
                                }
                                Some(why) => {
                                    was_rejected = true;
                                    channel.rejected(number, sender.now(), &why);
                                }
                            }
                        }
                    }
                    Ok(Ok(_)) => {}
                    broken => {
                        if let (Some((number, _, _)), false) = (on_its_way, was_rejected) {
                            // It may be the reason: mosquitto hangs up after a message that it does not take, sometimes
                            // before its acknowledgement says so. The others go first.
                            sender.channel().postpone(number, sender.now());
                        }
                        return Err(match broken {
                            Ok(Err(fault)) => self.in_words(&fault),
                            _ => format!("{}: the connection ended", self.address),
                        });
                    }
                },
                () = sender.bell.heard() => {
                    if sender.ends() && !connected {
                        return Err(format!("{} was not reached before the end", self.address));
                    }
                }
                () = sleep(due.saturating_sub(now)) => {}
            }
        }
    }

    /// Why the broker does not take a message, if it does not.
    fn rejection(&self, topic: &str, reason: PubAckReason) -> Option<String> {
        let taken = matches!(
            reason,
            PubAckReason::Success | PubAckReason::NoMatchingSubscribers
        );
        (!taken).then(|| format!("{} does not take {topic}: {reason:?}", self.address))
    }

    fn last_will(&self, will: &Message) -> LastWill {
        LastWill {
            topic: self.topic(will).into(),
            message: will.json().into(),
            qos: QoS::AtLeastOnce,
            retain: true,
            properties: Some(LastWillProperties {
                delay_interval: None,
                payload_format_indicator: Some(1),
                message_expiry_interval: None,
                content_type: Some(CONTENT_TYPE.to_owned()),
                response_topic: None,
                correlation_data: None,
                user_properties: Vec::new(),
            }),
        }
    }

    fn in_words(&self, fault: &ConnectionError) -> String {
        let hint = match fault {
            ConnectionError::MqttState(StateError::ServerDisconnect {
                reason_code: DisconnectReasonCode::SessionTakenOver,
                ..
            }) => " (another client with the same alarm.mqtt.client_id?)",
            _ => "",
        };
        format!("{}: {}{hint}", self.address, in_words(fault))
    }

    /// Publishes one message on a connection of its own, beside those of a running node.
    pub async fn try_out(&self, message: &Message) -> Result<(), SendFault> {
        let away = |why| SendFault::Away(why, None);
        let mut options = self.options.clone();
        options.set_client_id(format!(
            "{}_test_{}",
            options.client_id(),
            std::process::id()
        ));
        let mut link = Link::open(options);
        let topic = self.topic(message);
        link.publish(&topic, QoS::AtLeastOnce, message);
        let acknowledged = async {
            loop {
                match link.events.recv_async().await {
                    Ok(Ok(Event::Incoming(Packet::PubAck(ack)))) => {
                        let why = self.rejection(&topic, ack.reason);
                        return why.map_or(Ok(()), |why| Err(SendFault::Rejected(why)));
                    }
                    Ok(Ok(_)) => {}
                    Ok(Err(fault)) => return Err(away(self.in_words(&fault))),
                    Err(_) => return Err(away("the connection ended".to_owned())),
                }
            }
        };
        timeout(TIMEOUT, acknowledged)
            .await
            .unwrap_or_else(|_| Err(away(format!("{} does not answer", self.address))))?;
        link.close().await;
        Ok(())
    }
}

const CONTENT_TYPE: &str = "application/json";

/// Waits; returns whether the bell rang, which stays rung.
async fn pause(sender: &Sender, wait: Duration) -> bool {
    sleep(wait).await;
    let rang = timeout(Duration::ZERO, sender.bell.heard()).await.is_ok();
    if rang {
        sender.bell.ring();
    }
    rang
}

/// A connection, polled by a task of its own.
struct Link {
    client: AsyncClient,
    events: flume::Receiver<Result<Event, ConnectionError>>,
    poller: JoinHandle<()>,
}

impl Link {
    fn open(options: MqttOptions) -> Self {
        let (client, events) = AsyncClient::new(options, QUEUE);
        let (sent, received) = flume::bounded(QUEUE);
        let poller = tokio::spawn(poll(events, sent));
        Self {
            client,
            events: received,
            poller,
        }
    }

    /// Hands a message to the poller. If that has ended, its last event says why.
    fn publish(&mut self, topic: &str, qos: QoS, message: &Message) {
        let properties = PublishProperties {
            payload_format_indicator: Some(1),
            content_type: Some(CONTENT_TYPE.to_owned()),
            ..Default::default()
        };
        let retain = message.is_state() && message.state != State::Test;
        let json = message.json();
        let _ = self
            .client
            .try_publish_with_properties(topic, qos, retain, json, properties);
    }

    /// Leaves in order, so that the broker does not publish the will.
    async fn close(&mut self) {
        let left = async {
            if self.client.disconnect().await.is_err() {
                return;
            }
            while let Ok(Ok(event)) = self.events.recv_async().await {
                if event == Event::Outgoing(Outgoing::Disconnect) {
                    return;
                }
            }
        };
        let _ = timeout(LEAST_WAIT, left).await;
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.poller.abort();
    }
}

/// Polls a connection until it breaks.
async fn poll(mut events: EventLoop, sent: flume::Sender<Result<Event, ConnectionError>>) {
    loop {
        let event = events.poll().await;
        let broken = event.is_err();
        if broken {
            // What arrived before the end, such as the acknowledgement after which mosquitto hangs up.
            for earlier in std::mem::take(&mut events.state.events) {
                if sent.send_async(Ok(earlier)).await.is_err() {
                    return;
                }
            }
        }
        if sent.send_async(event).await.is_err() || broken {
            return;
        }
    }
}

/// Encryption, host and port of a broker.
fn address(text: &str) -> Option<(bool, &str, u16)> {
    let (encrypted, rest) = match text.split_once("://")? {
        ("mqtts", rest) => (true, rest),
        ("mqtt", rest) => (false, rest),
        _ => return None,
    };
    let (host, port) = rest.trim_end_matches('/').rsplit_once(':')?;
    // rumqttc looks an address of IPv6 up with brackets, and compares it with the certificate with them, too.
    let forbidden: &[char] = if encrypted {
        &['/', '@', ' ', '?', '#', '[']
    } else {
        &['/', '@', ' ', '?', '#']
    };
    let is_host = !host.is_empty() && !host.contains(forbidden);
    let port = port.parse().ok().filter(|it| *it != 0)?;
    is_host.then_some((encrypted, host, port))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_a_scheme_a_host_and_a_port() {
        assert_eq!(
            address("mqtts://b.example:8883"),
            Some((true, "b.example", 8883))
        );
        assert_eq!(address("mqtt://[::1]:1883/"), Some((false, "[::1]", 1883)));
        for text in [
            "",
            "b:1",
            "http://b:1",
            "mqtt://b",
            "mqtt://:1",
            "mqtt://b:0",
            "mqtt://b:70000",
            "mqtt://u@b:1",
            "mqtts://[::1]:1",
        ] {
            assert_eq!(address(text), None, "{text}");
        }
    }
}

//! Publishers, subscriptions and servers over Zenoh.

use std::marker::PhantomData;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use futures::Stream;
use futures::stream::unfold;
use ros2_client::qos::{Durability, History, QosProfile, Reliability};
use ros2_client::{Gid, MessageInfo, ROSTime, RmwRequestId};
use rustdds::GUID;
use serde::Serialize;
use serde::de::DeserializeOwned;
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::query::{Query, Queryable};
use zenoh::sample::{Sample, SampleKind};
use zenoh_ext::{
    AdvancedPublisher, AdvancedPublisherBuilderExt, AdvancedSubscriber,
    AdvancedSubscriberBuilderExt, CacheConfig, HistoryConfig, MissDetectionConfig, RecoveryConfig,
};

use crate::messages::cdr;
use crate::ros::transport_error::TransportError;
use ros_node::given_up::GivenUp;
use ros_node::guid_prefix::GuidPrefix;

use super::graph::Graph;
use super::keys::TypedName;
use super::queue::{Queue, Sender};

/// Longest message, as in RustDDS.
const MAX_MESSAGE_BYTES: usize = 4 << 20;

/// After this time a publisher of latched messages tells the number of its last one, by which readers notice that they lost it; the
/// period of rmw_zenoh.
const HEARTBEAT: Duration = Duration::from_millis(500);

/// Bytes of an attachment: number, time, the length of the identifier, identifier.
const ATTACHMENT_BYTES: usize = 33;

/// The place of an endpoint on the network, from its announcement to its end.
pub(super) struct Place {
    pub guid: GUID,
    pub gid: Gid,
    pub graph: Arc<Graph>,
    /// `None` until it is announced, and of a subscription that nobody is told of.
    pub token: Option<LivelinessToken>,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.graph.remove(self.guid, self.gid);
    }
}

/// Publishes messages on a topic.
pub struct ZenohPublisher<M> {
    publisher: AdvancedPublisher<'static>,
    /// Number of the last message. Locked while one is sent, so that they leave in the order of their numbers.
    last: Mutex<i64>,
    name: String,
    pub(super) place: Place,
    message: PhantomData<fn(M)>,
}

impl<M: Serialize> ZenohPublisher<M> {
    pub(super) fn new(
        session: &zenoh::Session,
        topic: &TypedName,
        key: String,
        qos: &QosProfile,
        place: Place,
    ) -> zenoh::Result<Self> {
        let reliability = match qos.reliability {
            Reliability::Reliable { .. } => zenoh::qos::Reliability::Reliable,
            Reliability::BestEffort => zenoh::qos::Reliability::BestEffort,
        };
        let mut builder = session
            .declare_publisher(key)
            .advanced()
            .reliability(reliability);
        if qos.durability == Durability::TransientLocal {
            let cache = CacheConfig::default().max_samples(depth(qos));
            builder = builder.publisher_detection().cache(cache);
            if reliability == zenoh::qos::Reliability::Reliable {
                let misses = MissDetectionConfig::default().sporadic_heartbeat(HEARTBEAT);
                builder = builder.sample_miss_detection(misses);
            }
        }
        Ok(Self {
            publisher: builder.wait()?,
            last: Mutex::new(0),
            name: topic.name.clone(),
            place,
            message: PhantomData,
        })
    }

    /// The publisher among the endpoints of the network.
    pub(in crate::ros) fn guid(&self) -> GUID {
        self.place.guid
    }

    /// Publishes a message.
    pub(in crate::ros) fn publish(&self, message: &M) -> Result<(), TransportError> {
        let bytes = cdr::encode_named(message, || self.name.clone());
        let bytes = bytes.map_err(TransportError::new)?;
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        *last += 1;
        let sent = self
            .publisher
            .put(bytes)
            .attachment(attachment(*last, self.place.gid))
            .wait();
        sent.map_err(TransportError::new)
    }
}

/// Receives the messages of a topic.
pub struct ZenohSubscription<M> {
    queue: Arc<Queue<Sample>>,
    name: String,
    pub(super) place: Place,
    _subscriber: AdvancedSubscriber<()>,
    message: PhantomData<fn() -> M>,
}

impl<M: DeserializeOwned> ZenohSubscription<M> {
    pub(super) fn new(
        session: &zenoh::Session,
        topic: &TypedName,
        key: String,
        qos: &QosProfile,
        (place, given_up): (Place, Arc<GivenUp>),
    ) -> zenoh::Result<Self> {
        let queue = Arc::new(Queue::new(depth(qos)));
        let (filled, name) = (Arc::clone(&queue), topic.name.clone());
        let graph = Arc::clone(&place.graph);
        let take = move |sample: Sample| {
            let size = sample.payload().len();
            if sample.kind() != SampleKind::Put {
                return;
            }
            if size > MAX_MESSAGE_BYTES {
                let sender = read_attachment(sample.attachment()).map(|it| graph.sender(it.gid));
                let sender = GuidPrefix::from(sender.unwrap_or_default());
                let size = u32::try_from(size).unwrap_or(u32::MAX);
                given_up.take(
                    &name,
                    sender,
                    size,
                    MAX_MESSAGE_BYTES as u32,
                    Instant::now(),
                );
                return;
            }
            let sender = sender(sample.attachment());
            filled.push(sample, size, sender);
        };
        let mut builder = session.declare_subscriber(key).callback(take).advanced();
        if qos.durability == Durability::TransientLocal {
            let history = HistoryConfig::default().detect_late_publishers();
            builder = builder.subscriber_detection().history(history);
            if matches!(qos.reliability, Reliability::Reliable { .. }) {
                builder = builder.recovery(RecoveryConfig::default().heartbeat());
            }
        }
        Ok(Self {
            queue,
            name: topic.name.clone(),
            place,
            _subscriber: builder.wait()?,
            message: PhantomData,
        })
    }

    /// The subscription among the endpoints of the network.
    pub(in crate::ros) fn guid(&self) -> GUID {
        self.place.guid
    }

    /// The next message, if there is one.
    pub(in crate::ros) fn take(&self) -> Option<Result<(M, MessageInfo), TransportError>> {
        self.queue.pop().map(|it| self.read(&it))
    }

    /// All messages, indefinitely.
    pub(in crate::ros) fn stream(
        &self,
    ) -> impl Stream<Item = Result<(M, MessageInfo), TransportError>> {
        unfold(self, |it| async move {
            let sample = it.queue.next().await;
            Some((it.read(&sample), it))
        })
    }

    /// All messages that can be read, each with the endpoint that sent it.
    pub(super) fn into_stream(self) -> impl Stream<Item = (GUID, M)> {
        unfold(self, |it| async move {
            loop {
                let sample = it.queue.next().await;
                if let Ok((message, info)) = it.read(&sample) {
                    return Some(((GUID::from(info.publisher_gid()), message), it));
                }
            }
        })
    }

    fn read(&self, sample: &Sample) -> Result<(M, MessageInfo), TransportError> {
        let Attachment { number, time, gid } = read_attachment(sample.attachment())?;
        let bytes = sample.payload().to_bytes();
        let message = cdr::decode_named(&bytes, || self.name.clone());
        let message = message.map_err(TransportError::new)?;
        let sender = self.place.graph.sender(gid);
        let time = Some(ROSTime::from_nanos(time));
        Ok((message, MessageInfo::new(None, time, number, sender, None)))
    }
}

/// Answers the requests of a service.
pub struct ZenohServer<Request, Response> {
    queue: Arc<Queue<Query>>,
    /// The request that was taken last and is not answered yet.
    pending: Mutex<Option<(RmwRequestId, Gid, Query)>>,
    name: String,
    pub(super) place: Place,
    _queryable: Queryable<()>,
    service: PhantomData<fn(Request) -> Response>,
}

impl<Request: DeserializeOwned, Response: Serialize> ZenohServer<Request, Response> {
    pub(super) fn new(
        session: &zenoh::Session,
        service: &TypedName,
        key: String,
        qos: &QosProfile,
        place: Place,
    ) -> zenoh::Result<Self> {
        let queue = Arc::new(Queue::new(depth(qos)));
        let filled = Arc::clone(&queue);
        let take = move |query: Query| {
            let size = query.payload().map_or(0, ZBytes::len);
            // Without an answer, the caller sees that there is none.
            if size <= MAX_MESSAGE_BYTES {
                let sender = sender(query.attachment());
                filled.push(query, size, sender);
            }
        };
        let queryable = session
            .declare_queryable(key)
            .complete(true)
            .callback(take)
            .wait()?;
        Ok(Self {
            queue,
            pending: Mutex::new(None),
            name: service.name.clone(),
            place,
            _queryable: queryable,
            service: PhantomData,
        })
    }

    /// All requests, indefinitely.
    pub(in crate::ros) fn stream(
        &self,
    ) -> impl Stream<Item = Result<(RmwRequestId, Request), TransportError>> {
        unfold(self, |it| async move {
            let query = it.queue.next().await;
            Some((it.read(query), it))
        })
    }

    fn read(&self, query: Query) -> Result<(RmwRequestId, Request), TransportError> {
        let Attachment { number, gid, .. } = read_attachment(query.attachment())?;
        let bytes = query.payload().map(ZBytes::to_bytes).unwrap_or_default();
        let request = cdr::decode_named(&bytes, || self.name.clone());
        let request = request.map_err(TransportError::new)?;
        let id = RmwRequestId {
            writer_gid: self.place.graph.sender(gid),
            sequence_number: number,
        };
        *self.pending() = Some((id, gid, query));
        Ok((id, request))
    }

    /// Sends the response to the request that was taken last.
    pub(in crate::ros) fn send_response(
        &self,
        id: RmwRequestId,
        response: &Response,
    ) -> Result<(), TransportError> {
        let pending = self.pending().take().filter(|(it, ..)| *it == id);
        let Some((_, gid, query)) = pending else {
            return Err(TransportError::new("the request is not known any more"));
        };
        let bytes = cdr::encode_named(response, || self.name.clone());
        let bytes = bytes.map_err(TransportError::new)?;
        let sent = query
            .reply(query.key_expr().clone(), bytes)
            .attachment(attachment(id.sequence_number, gid))
            .wait();
        sent.map_err(TransportError::new)
    }

    fn pending(&self) -> std::sync::MutexGuard<'_, Option<(RmwRequestId, Gid, Query)>> {
        self.pending.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// As many messages as the quality of service keeps.
fn depth(qos: &QosProfile) -> usize {
    match qos.history {
        History::KeepLast { depth } => depth.max(1),
        History::KeepAll => usize::MAX,
    }
}

/// What rmw_zenoh attaches to each message, request and response.
#[derive(Debug, PartialEq, Eq)]
struct Attachment {
    /// Of the message, from 1.
    number: i64,
    /// When it was sent, since the epoch \[ns\].
    time: i64,
    gid: Gid,
}

/// The attachment of what is sent now.
fn attachment(number: i64, gid: Gid) -> Vec<u8> {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let now = i64::try_from(since.unwrap_or_default().as_nanos()).unwrap_or(i64::MAX);
    encode_attachment(&Attachment {
        number,
        time: now,
        gid,
    })
}

fn encode_attachment(attachment: &Attachment) -> Vec<u8> {
    let Attachment { number, time, gid } = attachment;
    let gid = gid.to_bytes16();
    let mut bytes = Vec::with_capacity(ATTACHMENT_BYTES);
    bytes.extend_from_slice(&number.to_le_bytes());
    bytes.extend_from_slice(&time.to_le_bytes());
    bytes.push(gid.len() as u8);
    bytes.extend_from_slice(&gid);
    bytes
}

fn read_attachment(attachment: Option<&ZBytes>) -> Result<Attachment, TransportError> {
    let bytes = attachment.map(ZBytes::to_bytes).unwrap_or_default();
    decode_attachment(&bytes).ok_or_else(|| {
        TransportError::new(format_args!(
            "expected an attachment of rmw_zenoh ({ATTACHMENT_BYTES} bytes: number, time, identifier), found {} bytes; let the sender \
             use rmw_zenoh of ROS 2 Jazzy or later",
            bytes.len()
        ))
    })
}

/// Who has sent what has this attachment.
fn sender(attachment: Option<&ZBytes>) -> Sender {
    read_attachment(attachment).map_or(Sender::default(), |it| it.gid.to_bytes16())
}

fn decode_attachment(bytes: &[u8]) -> Option<Attachment> {
    let (number, rest) = bytes.split_first_chunk()?;
    let (time, rest) = rest.split_first_chunk()?;
    let (length, gid) = rest.split_first()?;
    let gid: [u8; 16] = gid.try_into().ok()?;
    let number = i64::from_le_bytes(*number);
    (usize::from(*length) == gid.len() && number > 0).then(|| Attachment {
        number,
        time: i64::from_le_bytes(*time),
        gid: Gid::from(gid),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attachments_are_read_as_they_are_written() {
        let attachment = Attachment {
            number: 7,
            time: 0x0102_0304_0506_0708,
            gid: Gid::from([0xab; 16]),
        };
        let bytes = encode_attachment(&attachment);
        let expected = [
            &[7, 0, 0, 0, 0, 0, 0, 0, 8, 7, 6, 5, 4, 3, 2, 1, 16][..],
            &[0xab; 16],
        ];
        assert_eq!(bytes, expected.concat());
        assert_eq!(decode_attachment(&bytes), Some(attachment));
        for wrong in [0, 16, 32] {
            assert_eq!(decode_attachment(&bytes[..wrong]), None);
        }
        assert_eq!(decode_attachment(&[&bytes[..], &[0]].concat()), None);
        assert_eq!(decode_attachment(&[0; ATTACHMENT_BYTES]), None);
    }
}

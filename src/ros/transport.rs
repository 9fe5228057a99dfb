//! The endpoints of a node, whichever transport carries their messages: DDS by ros2-client, or Zenoh.

use futures::future::Either;
use futures::stream::{LocalBoxStream, Stream, StreamExt};
use ros2_client::{Message, MessageInfo, RmwRequestId};
use rustdds::GUID;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::transport_error::TransportError;
use super::zenoh::{ZenohPublisher, ZenohServer, ZenohSubscription};

/// Publishes messages on a topic.
#[allow(clippy::large_enum_variant)] // few exist, and none moves once it does
pub enum Publisher<M: Serialize> {
    /// Over DDS.
    Dds(ros2_client::Publisher<M>),
    /// Over Zenoh.
    Zenoh(ZenohPublisher<M>),
}

impl<M: Serialize> Publisher<M> {
    /// Publishes a message.
    ///
    /// # Errors
    /// The message cannot be encoded, or a reader is too slow.
    pub fn publish(&self, message: M) -> Result<(), TransportError> {
        match self {
            Self::Dds(it) => it.publish(message).map_err(TransportError::new),
            Self::Zenoh(it) => it.publish(&message),
        }
    }

    /// The publisher among the endpoints of the network.
    #[must_use]
    pub fn guid(&self) -> GUID {
        match self {
            Self::Dds(it) => it.guid(),
            Self::Zenoh(it) => it.guid(),
        }
    }
}

/// Receives the messages of a topic.
#[allow(clippy::large_enum_variant)] // few exist, and none moves once it does
pub enum Subscription<M> {
    /// Over DDS.
    Dds(ros2_client::Subscription<M>),
    /// Over Zenoh.
    Zenoh(ZenohSubscription<M>),
}

impl<M: DeserializeOwned + 'static> Subscription<M> {
    /// All messages, indefinitely; an error is a message that cannot be read.
    pub fn async_stream(&self) -> impl Stream<Item = Result<(M, MessageInfo), TransportError>> {
        match self {
            Self::Dds(it) => Either::Left(
                it.async_stream()
                    .map(|message| message.map_err(TransportError::new)),
            ),
            Self::Zenoh(it) => Either::Right(it.stream()),
        }
    }

    /// The next message, if there is one.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn take(&self) -> Result<Option<(M, MessageInfo)>, TransportError> {
        match self {
            Self::Dds(it) => it.take().map_err(TransportError::new),
            Self::Zenoh(it) => it.take().transpose(),
        }
    }

    /// The subscription among the endpoints of the network.
    #[must_use]
    pub fn guid(&self) -> GUID {
        match self {
            Self::Dds(it) => it.guid(),
            Self::Zenoh(it) => it.guid(),
        }
    }
}

/// Answers the requests of a service.
#[allow(clippy::large_enum_variant)] // few exist, and none moves once it does
pub enum Server<Request: Message, Response: Message> {
    /// Over DDS.
    Dds(ros2_client::Server<Request, Response>),
    /// Over Zenoh.
    Zenoh(ZenohServer<Request, Response>),
}

/// What a server receives: a request with its number, or why it cannot be read.
type Received<Request> = Result<(RmwRequestId, Request), TransportError>;

impl<Request: Message + 'static, Response: Message + 'static> Server<Request, Response> {
    /// All requests, indefinitely. Each has to be answered before the next one is taken.
    pub fn receive_request_stream(&self) -> LocalBoxStream<'_, Received<Request>> {
        match self {
            Self::Dds(it) => it
                .receive_request_stream()
                .map(|request| request.map_err(TransportError::new))
                .boxed_local(),
            Self::Zenoh(it) => it.stream().boxed_local(),
        }
    }

    /// Sends the response to a request.
    ///
    /// # Errors
    /// It cannot be encoded or sent.
    pub async fn async_send_response(
        &self,
        id: RmwRequestId,
        response: Response,
    ) -> Result<(), TransportError> {
        match self {
            Self::Dds(it) => {
                let sent = it.async_send_response(id, response).await;
                sent.map_err(|error| TransportError::new(format!("{error:?}")))
            }
            Self::Zenoh(it) => it.send_response(id, &response),
        }
    }
}

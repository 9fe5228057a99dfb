//! Zenoh in a program without the feature `zenoh`: says so if it is asked for. Its endpoints cannot exist.

use std::convert::Infallible;
use std::marker::PhantomData;
use std::sync::Arc;

use futures::stream::Pending;
use ros2_client::qos::QosProfile;
use ros2_client::{MessageInfo, RmwRequestId};
use rustdds::GUID;

use super::transport_error::TransportError;
use ros_node::environment::Environment;
use ros_node::matches::{Discovered, Matches};
use ros_node::names::Names;

/// Fails: there is no Zenoh.
pub(super) fn check_zenoh(_: &Environment) -> Result<(), String> {
    Err(
        "this program was built without Zenoh; build it with the feature `zenoh` (cargo build --release --features zenoh), or use \
         --transport dds"
            .to_owned(),
    )
}

/// No session.
#[derive(Clone)]
pub(super) struct ZenohSession(Infallible);

impl ZenohSession {
    pub fn open(environment: &Environment, _: &Arc<Matches>) -> Result<Self, String> {
        check_zenoh(environment)?;
        unreachable!("the check fails")
    }

    pub fn node(&self, _: &Names) -> Result<ZenohNode, String> {
        match self.0 {}
    }
}

/// No node.
#[derive(Clone)]
pub(super) struct ZenohNode(Infallible);

impl ZenohNode {
    pub fn session(&self) -> ZenohSession {
        match self.0 {}
    }

    pub fn publisher<M>(
        &self,
        _: &str,
        _: &str,
        _: Option<&str>,
        _: &QosProfile,
    ) -> Result<ZenohPublisher<M>, String> {
        match self.0 {}
    }

    pub fn subscription<M>(
        &self,
        _: &str,
        _: &str,
        _: &QosProfile,
    ) -> Result<ZenohSubscription<M>, String> {
        match self.0 {}
    }

    pub fn overheard<M>(
        &self,
        _: &str,
        _: &str,
        _: &QosProfile,
    ) -> Result<Pending<(GUID, M)>, String> {
        match self.0 {}
    }

    pub fn server<Request, Response>(
        &self,
        _: &str,
        _: &str,
        _: &QosProfile,
    ) -> Result<ZenohServer<Request, Response>, String> {
        match self.0 {}
    }

    pub fn events<F: FnMut(Discovered<'_>)>(&self, _: F) -> std::future::Pending<()> {
        match self.0 {}
    }

    pub fn guid(&self) -> GUID {
        match self.0 {}
    }

    pub fn topics_of(&self, _: &str) -> std::iter::Empty<String> {
        match self.0 {}
    }
}

/// No publisher.
pub struct ZenohPublisher<M>(Infallible, PhantomData<fn(M)>);

impl<M> ZenohPublisher<M> {
    pub(super) fn guid(&self) -> GUID {
        match self.0 {}
    }

    pub(super) fn publish(&self, _: &M) -> Result<(), TransportError> {
        match self.0 {}
    }
}

/// No subscription.
pub struct ZenohSubscription<M>(Infallible, PhantomData<fn() -> M>);

impl<M> ZenohSubscription<M> {
    pub(super) fn guid(&self) -> GUID {
        match self.0 {}
    }

    pub(super) fn take(&self) -> Option<Result<(M, MessageInfo), TransportError>> {
        match self.0 {}
    }

    pub(super) fn stream(&self) -> Pending<Result<(M, MessageInfo), TransportError>> {
        match self.0 {}
    }
}

/// No server.
pub struct ZenohServer<Request, Response>(Infallible, PhantomData<fn(Request) -> Response>);

impl<Request, Response> ZenohServer<Request, Response> {
    pub(super) fn stream(&self) -> Pending<Result<(RmwRequestId, Request), TransportError>> {
        match self.0 {}
    }

    pub(super) fn send_response(
        &self,
        _: RmwRequestId,
        _: &Response,
    ) -> Result<(), TransportError> {
        match self.0 {}
    }
}

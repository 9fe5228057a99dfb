//! Reads one topic.

use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::Instant;

use column_twin::ros::qos::Endpoint;
use column_twin::ros::{Names, Node};
use futures::StreamExt;
use futures::future::{AbortHandle, Abortable};
use rustdds::GUID;
use serde::de::DeserializeOwned;

use super::domain::{Domain, PATIENCE};

/// A node that does not belong to the twin.
pub fn reader(domain: &Domain) -> Node {
    let names = Names::new("/", "reader", &[]).unwrap();
    Node::new(&domain.environment, names).unwrap()
}

/// Reads one topic in its own thread until it is dropped.
pub struct Incoming<M> {
    pub messages: Receiver<M>,
    /// The subscription.
    pub guid: GUID,
    abort: AbortHandle,
    thread: Option<JoinHandle<()>>,
}

impl<M: DeserializeOwned + Send + 'static> Incoming<M> {
    /// Subscribes and waits for a publisher.
    pub fn start(node: &mut Node, endpoint: &Endpoint) -> Self {
        let incoming = Self::early(node, endpoint);
        let deadline = Instant::now() + PATIENCE;
        let found = node.matches().wait_for(incoming.guid, 1, deadline);
        assert!(found, "no {} found", endpoint.name);
        incoming
    }

    /// Subscribes without waiting for a publisher.
    pub fn early(node: &mut Node, endpoint: &Endpoint) -> Self {
        let subscription = node.subscription::<M>(endpoint).unwrap();
        let guid = subscription.guid();
        let (sender, messages) = channel();
        let events = node.participant_events();
        let (abort, registration) = AbortHandle::new_pair();
        let read = move || {
            let each = subscription.async_stream().for_each(|message| {
                let _ = sender.send(message.unwrap().0);
                futures::future::ready(())
            });
            let all = async { futures::join!(events, each) };
            let _ = futures::executor::block_on(Abortable::new(all, registration));
        };
        let thread = Some(std::thread::spawn(read));
        Self {
            messages,
            guid,
            abort,
            thread,
        }
    }

    /// The first message from now on that `is_it` says yes to.
    pub fn find(&self, what: &str, mut is_it: impl FnMut(&M) -> bool) -> M {
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            let message = self.messages.recv_timeout(PATIENCE);
            if let Some(it) = message.ok().filter(&mut is_it) {
                return it;
            }
        }
        panic!("timeout while waiting for {what}");
    }

    /// The last of the messages that are here already.
    pub fn newest(&self) -> Option<M> {
        self.messages.try_iter().last()
    }

    /// The next message.
    pub fn next(&self) -> M {
        self.messages.recv_timeout(PATIENCE).expect("a message")
    }
}

impl<M> Drop for Incoming<M> {
    fn drop(&mut self) {
        self.abort.abort();
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

//! The receiving peers: a Rust reader in this process, and rclpy in a separate one.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::ImpactEvent;
use column_twin::messages::std_msgs::Header;
use column_twin::messages::std_srvs::{TriggerRequest, TriggerResponse};
use column_twin::ros::qos::{self, Endpoint};
use column_twin::ros::{Names, Node, Publisher};
use futures::StreamExt;
use futures::future::{AbortHandle, Abortable};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::domain::{Domain, PATIENCE};

const RESET: Endpoint = Endpoint {
    name: "/column_twin/reset",
    ..qos::RESET
};

/// The system time \[ns\].
pub fn now() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |it| it.as_nanos() as i64)
}

/// An event that leaves vehicle, gap, restitution and height to the parameters.
pub fn event(event_id: &str, stamp: i64, mass: f64, velocity: f64) -> ImpactEvent {
    ImpactEvent {
        header: Header {
            stamp: Time::from_nanos(stamp).unwrap_or_default(),
            frame_id: String::new(),
        },
        column_id: "column".to_owned(),
        event_id: event_id.to_owned(),
        mass,
        velocity,
        ..ImpactEvent::default()
    }
}

/// The times of a message on the clock of this machine \[ns\].
#[derive(Debug, Clone, Copy)]
pub struct Arrival {
    /// Stamp of the message, when it should be published.
    pub stamp: i64,
    /// When it was passed to the writer.
    pub source: i64,
    /// When the code of the reader received it.
    pub received: i64,
    /// Sequence number of the writer; `None` if the reader does not know it.
    pub sequence: Option<i64>,
}

/// A node of this process, with its known peers.
pub struct Peer {
    pub node: Node,
    abort: AbortHandle,
    follow: Option<JoinHandle<()>>,
}

impl Peer {
    pub fn new(domain: &Domain) -> Self {
        let names = Names::new("/", "benchmark", &[]).expect("a name");
        let node = Node::new(&domain.environment, names).expect("a node");
        let events = node.participant_events();
        let (abort, registration) = AbortHandle::new_pair();
        let follow = std::thread::spawn(move || {
            let _ = futures::executor::block_on(Abortable::new(events, registration));
        });
        Self {
            node,
            abort,
            follow: Some(follow),
        }
    }

    /// A publisher with this number of readers.
    pub fn publisher<M: Serialize>(&mut self, endpoint: &Endpoint) -> Publisher<M> {
        let publisher = self.node.publisher(endpoint).expect("a publisher");
        let deadline = Instant::now() + PATIENCE;
        let met = self.node.matches().wait_for(publisher.guid(), 1, deadline);
        assert!(met, "no reader for {}", endpoint.name);
        publisher
    }

    /// A function that makes the column undamaged again.
    pub fn reset(&mut self) -> impl Fn() + use<> {
        let client = self.node.client::<TriggerRequest, TriggerResponse>(&RESET);
        let client = client.expect("a client");
        move || {
            let request = client.async_call_service(TriggerRequest::default());
            let answer = futures::executor::block_on(request);
            assert!(
                answer.is_ok_and(|it| it.success),
                "the column is undamaged again"
            );
        }
    }

    /// Receives a topic in a separate thread.
    pub fn reader<M, T>(
        &mut self,
        endpoint: &Endpoint,
        take: impl Fn(M, Arrival) -> T + Send + 'static,
        stamp: impl Fn(&M) -> Time + Send + 'static,
    ) -> Reader<T>
    where
        M: DeserializeOwned + Send + 'static,
        T: Send + 'static,
    {
        let subscription = self.node.subscription::<M>(endpoint).expect("a reader");
        let guid = subscription.guid();
        let (sender, arrivals) = channel();
        let (abort, registration) = AbortHandle::new_pair();
        let read = move || {
            let each = subscription.async_stream().for_each(|message| {
                let received = now();
                let (message, info) = message.expect("a message of our own");
                let arrival = Arrival {
                    stamp: stamp(&message).to_nanos().unwrap_or_default(),
                    source: info.source_timestamp().map_or(0, |it| it.to_nanos()),
                    received,
                    sequence: Some(info.sequence_number()),
                };
                let _ = sender.send(take(message, arrival));
                std::future::ready(())
            });
            let _ = futures::executor::block_on(Abortable::new(each, registration));
        };
        let thread = Some(std::thread::spawn(read));
        let reader = Reader {
            arrivals,
            abort,
            thread,
        };
        let deadline = Instant::now() + PATIENCE;
        let met = self.node.matches().wait_for(guid, 1, deadline);
        assert!(met, "no publisher of {}", endpoint.name);
        reader
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        self.abort.abort();
        if let Some(follow) = self.follow.take() {
            let _ = follow.join();
        }
    }
}

/// Receives the messages of a topic.
pub struct Reader<T> {
    pub arrivals: Receiver<T>,
    abort: AbortHandle,
    thread: Option<JoinHandle<()>>,
}

impl<T> Reader<T> {
    pub fn next(&self) -> T {
        self.arrivals.recv_timeout(PATIENCE).expect("a message")
    }

    /// Waits for a message that satisfies `is_it`.
    pub fn find(&self, mut is_it: impl FnMut(&T) -> bool) -> T {
        loop {
            let it = self.next();
            if is_it(&it) {
                return it;
            }
        }
    }
}

impl<T> Drop for Reader<T> {
    fn drop(&mut self) {
        self.abort.abort();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn interop(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/interop")
        .join(file)
}

/// rclpy, which receives topics in a separate process.
pub struct Rclpy {
    child: Child,
    lines: std::io::Lines<BufReader<std::process::ChildStdout>>,
}

impl Rclpy {
    /// `None`, with a message, if its environment cannot be built.
    pub fn start(domain: &Domain, topics: &[&str]) -> Option<Self> {
        let built = Command::new(interop("environment.sh"))
            .stderr(Stdio::inherit())
            .output();
        let built = built.ok().filter(|it| it.status.success());
        let Some(environment) = built.and_then(|it| String::from_utf8(it.stdout).ok()) else {
            println!("rclpy is not available; run tests/interop/environment.sh for the reason");
            return None;
        };
        let mut child = Command::new(Path::new(environment.trim()).join("bin/python"))
            .arg(interop("stream_with_rclpy.py"))
            .args(topics)
            .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("a Python");
        let lines = BufReader::new(child.stdout.take().expect("piped")).lines();
        Some(Self { child, lines })
    }

    /// Waits until every topic has a publisher.
    pub fn wait_until_ready(&mut self) {
        let line = self.lines.next().and_then(Result::ok).unwrap_or_default();
        assert_eq!(line, "ready", "rclpy does not find all topics");
    }

    /// Everything it received, by topic in the given order.
    pub fn finish(mut self, topics: usize) -> Vec<Vec<Arrival>> {
        if let Some(mut stdin) = self.child.stdin.take() {
            let _ = stdin.write_all(b"end\n");
        }
        let mut arrivals = vec![Vec::new(); topics];
        for line in self.lines.by_ref().map_while(Result::ok) {
            let numbers: Vec<i64> = line.split(',').filter_map(|it| it.parse().ok()).collect();
            let [topic, stamp, source, received] = numbers[..] else {
                panic!("rclpy: {line}");
            };
            arrivals[topic as usize].push(Arrival {
                stamp,
                source,
                received,
                sequence: None,
            });
        }
        let ended = self.child.wait().expect("a child");
        assert!(ended.success(), "rclpy: {ended}");
        arrivals
    }
}

impl Drop for Rclpy {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

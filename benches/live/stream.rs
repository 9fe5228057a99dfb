//! Publishing at 1 kHz to rclpy and to a Rust reader, alternating with a bare publisher.

use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{
    ColumnState, HingeForces, ImpactEvent, ImpactReport,
};
use column_twin::ros::qos::{self, Endpoint};

use super::bare::{BARE_FORCES, BARE_STATE, Bare};
use super::domain::Domain;
use super::peers::{Arrival, Peer, Rclpy, Reader, event, now};
use super::program::Program;
use super::table::{Ranked, number, row};

/// Duration of one turn of one of the two publishers.
const TURN: Duration = Duration::from_secs(5);

/// A heavy and slow vehicle: contact lasts a third of a second, the column remains elastic, and no reset is needed.
const MASS: f64 = 1e6;
const VELOCITY: f64 = 0.04;

/// Events are stamped this far ahead, so that no sample is due before its event has arrived \[ns\].
const AHEAD: i64 = 5_000_000;

/// Targets: delay of a publication \[ms\], and ratio of its latency to that of the bare publisher.
const LATENESS: f64 = 0.5;
const LATENCY_RATIO: f64 = 1.5;

/// States with a longer distance in time belong to different responses \[ns\].
const SAME_RESPONSE: i64 = 3_000_000;

/// The start of a response, in which forecast, report of the previous impact, statuses and the sender of the events share
/// the processors with the stream \[ns\].
const START: i64 = 20_000_000;

/// The next bare publisher starts and is discovered between two turns: in a turn of the node it would disturb the node only.
const DISCOVERY: Duration = Duration::from_secs(2);

/// Maximum time in transit of the last messages.
const STRAGGLERS: Duration = Duration::from_secs(1);

/// Causes continuous responses until the turn is over.
pub struct Impacts {
    events: column_twin::ros::Publisher<ImpactEvent>,
    reports: Reader<String>,
    sent: u64,
}

impl Impacts {
    pub fn new(peer: &mut Peer) -> Self {
        Self {
            reports: peer.reader(
                &qos::IMPACT_REPORT,
                |it: ImpactReport, _| it.event_id,
                |it| it.header.stamp,
            ),
            events: peer.publisher(&qos::IMPACT_EVENT),
            sent: 0,
        }
    }

    pub fn for_a_while(&mut self, span: Duration) {
        let end = Instant::now() + span;
        while Instant::now() < end {
            let id = format!("impact-{:06}", self.sent);
            self.sent += 1;
            self.events
                .publish(event(&id, now() + AHEAD, MASS, VELOCITY))
                .expect("room for one");
            self.reports.find(|it| *it == id);
        }
    }
}

/// What a reader received on a topic of a publisher.
#[derive(Default)]
struct Record {
    arrivals: Vec<Arrival>,
    /// Number of sent messages, if the sequence numbers are known.
    sent: Option<usize>,
}

impl Record {
    /// The record of a single writer, whose sequence numbers count the messages since the first received one.
    fn of_writer(arrivals: Vec<Arrival>) -> Self {
        let numbers = || arrivals.iter().filter_map(|it| it.sequence);
        let span = numbers().max().zip(numbers().min());
        Self {
            sent: span.and_then(|(last, first)| usize::try_from(last - first + 1).ok()),
            arrivals,
        }
    }

    fn out_of_order(&self) -> usize {
        let pairs = self.arrivals.windows(2);
        pairs.filter(|pair| pair[1].stamp < pair[0].stamp).count()
    }

    fn lateness(&self) -> Ranked {
        Ranked::new(
            self.arrivals
                .iter()
                .map(|it| 1e-6 * (it.source - it.stamp) as f64),
        )
    }

    fn latency(&self) -> Ranked {
        Ranked::new(self.arrivals.iter().map(latency))
    }

    /// The latencies in the first [`START`] of each response, and those of all later messages.
    fn latencies_at_start_and_later(&self) -> (Ranked, Ranked) {
        let mut sorted: Vec<_> = self.arrivals.iter().collect();
        sorted.sort_by_key(|it| it.stamp);
        let (mut first, mut last) = (i64::MIN, i64::MIN);
        let (mut start, mut later) = (Vec::new(), Vec::new());
        for arrival in sorted {
            if arrival.stamp.saturating_sub(last) > SAME_RESPONSE {
                first = arrival.stamp;
            }
            last = arrival.stamp;
            let group = if arrival.stamp - first < START {
                &mut start
            } else {
                &mut later
            };
            group.push(latency(arrival));
        }
        (Ranked::new(start), Ranked::new(later))
    }
}

/// From the stamp of a message to the code of the reader \[ms\].
pub(super) fn latency(arrival: &Arrival) -> f64 {
    1e-6 * (arrival.received - arrival.stamp) as f64
}

/// The arrivals of one Rust reader.
fn rust_reader(peer: &mut Peer, endpoint: &Endpoint) -> Reader<Arrival> {
    if endpoint.type_name == qos::COLUMN_STATE.type_name {
        peer.reader(endpoint, |_: ColumnState, it| it, |it| it.header.stamp)
    } else {
        peer.reader(endpoint, |_: HingeForces, it| it, |it| it.header.stamp)
    }
}

fn drained(reader: &Reader<Arrival>) -> Vec<Arrival> {
    std::iter::from_fn(|| reader.arrivals.recv_timeout(STRAGGLERS).ok()).collect()
}

/// What the Rust reader received: the states of the node and of the bare publisher, and the forces of both.
type Records = [Record; 4];

pub fn run(span: Duration) {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let _program = Program::ready(&domain, folder.path(), &[]);
    let turns = (span.as_secs_f64() / TURN.as_secs_f64()).ceil().max(1.0) as usize;
    let turn = span.div_f64(turns as f64);
    let pairs = turn.as_millis() as u64;
    // All readers discover all publishers before anything is sent; the bare publisher waits in each turn for its start.
    let mut bare = Some(Bare::publisher(&domain, pairs));
    let mut peer = Peer::new(&domain);
    let endpoints = [
        qos::COLUMN_STATE,
        BARE_STATE,
        qos::HINGE_FORCES,
        BARE_FORCES,
    ];
    let readers = endpoints.map(|endpoint| rust_reader(&mut peer, &endpoint));
    let names = endpoints.map(|it| it.name);
    // It can process two topics at 1 kHz, of one publisher at a time, in real time.
    let mut rclpy = Rclpy::start(&domain, &names[..2]);
    if let Some(rclpy) = &mut rclpy {
        rclpy.wait_until_ready();
    }
    let mut impacts = Impacts::new(&mut peer);
    // Messages sent before the first acknowledgement of a reader may be lost, and are excluded.
    impacts.for_a_while(Duration::from_millis(500));
    let begun = now();
    for number in 0..turns {
        impacts.for_a_while(turn);
        if let Some(bare) = bare.take() {
            bare.go();
        }
        if number + 1 < turns {
            bare = Some(Bare::publisher(&domain, pairs));
            std::thread::sleep(DISCOVERY);
        }
    }
    let mut rust: Records = readers.each_ref().map(|reader| {
        let all = drained(reader).into_iter();
        Record::of_writer(all.filter(|it| it.stamp >= begun).collect())
    });
    // Each turn of the bare publisher is a separate process.
    for bare in [1, 3] {
        rust[bare].sent = Some(turns * pairs as usize);
    }
    let python = rclpy.map(|rclpy| {
        let topics = rclpy.finish(2).into_iter();
        let records = topics.map(|all| Record {
            arrivals: all.into_iter().filter(|it| it.stamp >= begun).collect(),
            sent: None,
        });
        let mut records: Vec<_> = records.collect();
        for (record, of_rust) in records.iter_mut().zip(&rust) {
            record.sent = of_rust.sent;
        }
        records
    });
    println!(
        "{turns} turns of {turn:?} each; latency: from the stamp of a message to the code of the reader"
    );
    print_reader("Rust reader", &rust);
    if let Some(python) = python {
        print_reader("rclpy", &python);
    }
}

fn print_reader(name: &str, records: &[Record]) {
    println!();
    row(name, ["node", "bare", "ratio"].map(str::to_owned));
    let topics = ["column_state", "hinge_forces"];
    for (topic, pair) in topics.iter().zip(records.chunks_exact(2)) {
        let (node, bare) = (&pair[0], &pair[1]);
        let counts = |of: fn(&Record) -> String| [of(node), of(bare)];
        row(
            &format!("{topic}: received"),
            counts(|it| it.arrivals.len().to_string()),
        );
        row(
            "  lost",
            counts(|it| match it.sent {
                Some(sent) => (sent as i64 - it.arrivals.len() as i64).to_string(),
                None => "?".to_owned(),
            }),
        );
        row("  out of order", counts(|it| it.out_of_order().to_string()));
        let compared = |what: &str, node: f64, bare: f64| {
            row(what, [node, bare, node / bare].map(number));
        };
        let (late, bare_late) = (node.lateness(), bare.lateness());
        let (latency, bare_latency) = (node.latency(), bare.latency());
        for percent in [50.0, 99.0, 100.0] {
            compared(
                &format!("  published after its deadline, p{percent} [ms]"),
                late.percentile(percent),
                bare_late.percentile(percent),
            );
        }
        for percent in [50.0, 99.0, 100.0] {
            compared(
                &format!("  latency, p{percent} [ms]"),
                latency.percentile(percent),
                bare_latency.percentile(percent),
            );
        }
        let (start, later) = node.latencies_at_start_and_later();
        for (name, group) in [("first 20 ms of a response", start), ("later", later)] {
            compared(
                &format!("  {name}: {} messages, p99 [ms]", group.len()),
                group.percentile(99.0),
                bare_latency.percentile(99.0),
            );
        }
        row(
            "  lateness p99 / 0.5 ms",
            [number(late.percentile(99.0) / LATENESS)],
        );
        row(
            "  ratio of latencies p50, p99 / 1.5",
            [50.0, 99.0].map(|it| {
                let ratio = latency.percentile(it) / bare_latency.percentile(it);
                number(ratio / LATENCY_RATIO)
            }),
        );
    }
}

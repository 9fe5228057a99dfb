//! Forecast, stream and processor time with everything that leaves the node past DDS, in turns with the same without.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{ColumnState, ImpactEvent, ImpactReport, TwinStatus};
use column_twin::ros::qos;

use super::domain::Domain;
use super::peers::{Peer, event, now};
use super::processor::share_together;
use super::program::Program;
use super::programs::{Mosquitto, free_port};
use super::stream::Impacts;
use super::table::{Ranked, number, row};

/// Turns of each of the two.
const TURNS: usize = 4;

/// Events of one turn.
const EVENTS: usize = 50;

/// The targets: ratio of the 99th percentiles, and processor time at rest \[s per s\].
const RATIO: f64 = 1.1;
const IDLE: f64 = 0.006;

/// What one of the two has shown in all its turns.
#[derive(Default)]
struct Found {
    /// From an event to its forecast \[ms\].
    forecasts: Vec<f64>,
    /// From the stamp of a state to its publication, and to the code of a reader \[ms\].
    late: Vec<f64>,
    latency: Vec<f64>,
    /// Shares of a processor at rest.
    idle: Vec<f64>,
}

/// Takes one of the measured quantities.
type Take = fn(&Found) -> &Vec<f64>;

pub fn run(span: Duration) {
    let turn = span.div_f64((4 * TURNS) as f64);
    let mut found = [Found::default(), Found::default()];
    let mut counts = [0; 3];
    for _ in 0..TURNS {
        for (is_on, found) in [false, true].into_iter().zip(&mut found) {
            let (domain, folder) = (Domain::fresh(), tempfile::tempdir().expect("a folder"));
            let mut others = is_on.then(|| Others::new(folder.path()));
            let arguments = others.as_ref().map(Others::arguments).unwrap_or_default();
            let arguments: Vec<_> = arguments.iter().flat_map(|it| ["-p", it]).collect();
            let program = Program::ready(&domain, folder.path(), &arguments);
            if let Some(others) = &mut others {
                others.connect();
            }
            measure(&domain, &program, turn, found);
            if let Some(others) = others {
                drop(program);
                for (sum, count) in counts.iter_mut().zip(others.finish()) {
                    *sum += count;
                }
            }
        }
    }
    let [frames, pages, alarms] = counts;
    println!(
        "{TURNS} turns of each of the two; with: {frames} messages at a client of Foxglove, {pages} pages of metrics, {alarms} messages at a subscriber of MQTT"
    );
    row("", ["without", "with", "ratio"].map(str::to_owned));
    let rows: [(&str, f64, Take); 6] = [
        ("event to forecast, p50 [ms]", 50.0, |it| &it.forecasts),
        ("event to forecast, p99 [ms]", 99.0, |it| &it.forecasts),
        ("1 kHz stream, lateness p99 [ms]", 99.0, |it| &it.late),
        ("1 kHz stream, latency p50 [ms]", 50.0, |it| &it.latency),
        ("1 kHz stream, latency p99 [ms]", 99.0, |it| &it.latency),
        ("processor time at rest [s per s]", 50.0, |it| &it.idle),
    ];
    let of = |percent: f64, take: Take| {
        found
            .each_ref()
            .map(|it| Ranked::new(take(it).iter().copied()).percentile(percent))
    };
    for (name, percent, take) in rows {
        let [without, with] = of(percent, take);
        row(name, [without, with, with / without].map(number));
    }
    let ratio = |take: Take| {
        let [without, with] = of(99.0, take);
        with / without / RATIO
    };
    row(
        "p99 / 1.1: forecast, lateness, latency",
        [
            ratio(|it| &it.forecasts),
            ratio(|it| &it.late),
            ratio(|it| &it.latency),
        ]
        .map(number),
    );
    let [_, idle] = of(50.0, |it| &it.idle);
    row(
        "at rest / 0.6 % of a core",
        [String::new(), number(idle / IDLE)],
    );
}

fn measure(domain: &Domain, program: &Program, turn: Duration, found: &mut Found) {
    let mut peer = Peer::new(domain);
    let forecasts = peer.reader(
        &qos::IMPACT_FORECAST,
        |it: ImpactReport, _| (Instant::now(), it.event_id),
        |it| it.header.stamp,
    );
    let reports = peer.reader(
        &qos::IMPACT_REPORT,
        |it: ImpactReport, _| it.event_id,
        |it| it.header.stamp,
    );
    let states = peer.reader(
        &qos::COLUMN_STATE,
        |_: ColumnState, it| it,
        |it| it.header.stamp,
    );
    let statuses = peer.reader(
        &qos::TWIN_STATUS,
        |it: TwinStatus, _| it.critical_vehicle.len(),
        |it| it.header.stamp,
    );
    let reset = peer.reset();
    let events = peer.publisher::<ImpactEvent>(&qos::IMPACT_EVENT);
    // After the start, the node computes the critical velocities of its column, once.
    statuses.find(|vehicles| *vehicles > 0);
    found.idle.push(share_together(&[program.id()], turn));
    for number in 0..EVENTS {
        let id = format!("forecast-{number:06}");
        let sent = Instant::now();
        events
            .publish(event(&id, now(), 1500.0, 10.0))
            .expect("room for one");
        let (received, _) = forecasts.find(|(_, event)| *event == id);
        let waited = received.duration_since(sent);
        found.forecasts.push(1e3 * waited.as_secs_f64());
        reports.find(|event| *event == id);
        reset();
    }
    let mut impacts = Impacts::new(&mut peer);
    impacts.for_a_while(Duration::from_millis(500));
    states.arrivals.try_iter().for_each(drop);
    impacts.for_a_while(turn);
    for it in states.arrivals.try_iter() {
        found.late.push(1e-6 * (it.source - it.stamp) as f64);
        found.latency.push(1e-6 * (it.received - it.stamp) as f64);
    }
}

/// What a node serves besides DDS, with those who read it.
struct Others {
    broker: Mosquitto,
    subscriber: super::programs::Lines,
    metrics: u16,
    foxglove: u16,
    stop: Arc<AtomicBool>,
    readers: Vec<JoinHandle<()>>,
    frames: Arc<AtomicU64>,
    pages: Arc<AtomicU64>,
}

impl Others {
    fn new(folder: &std::path::Path) -> Self {
        let broker = Mosquitto::started(folder, "");
        Self {
            subscriber: broker.subscriber(),
            broker,
            metrics: free_port(),
            foxglove: free_port(),
            stop: Arc::default(),
            readers: Vec::new(),
            frames: Arc::default(),
            pages: Arc::default(),
        }
    }

    fn arguments(&self) -> Vec<String> {
        let mut arguments = vec![
            format!("alarm.mqtt.broker:={}", self.broker.address()),
            "alarm.mqtt.action:=inspect".to_owned(),
            format!("metrics.address:='127.0.0.1:{}'", self.metrics),
        ];
        if cfg!(feature = "foxglove") {
            arguments.push("foxglove.mode:=serve".to_owned());
            arguments.push(format!("foxglove.address:='127.0.0.1:{}'", self.foxglove));
        }
        arguments
    }

    /// Starts the readers of the running node.
    fn connect(&mut self) {
        let (stop, pages, port) = (
            Arc::clone(&self.stop),
            Arc::clone(&self.pages),
            self.metrics,
        );
        self.readers.push(std::thread::spawn(move || {
            while !stop.load(Ordering::Relaxed) {
                if has_page(port) {
                    pages.fetch_add(1, Ordering::Relaxed);
                }
                std::thread::sleep(Duration::from_secs(1));
            }
        }));
        #[cfg(feature = "foxglove")]
        self.follow_foxglove();
        #[cfg(not(feature = "foxglove"))]
        println!("without a client of Foxglove, because this was built without the feature");
    }

    /// Subscribes to every topic, and reads until the node ends.
    #[cfg(feature = "foxglove")]
    fn follow_foxglove(&mut self) {
        use super::foxglove_socket::{Frame, Socket};
        let mut socket = Socket::connect(self.foxglove);
        let channels = loop {
            if let Frame::Text(text) = socket.receive()
                && text["op"] == "advertise"
            {
                break text;
            }
        };
        let channels = channels["channels"].as_array().cloned();
        for (id, channel) in channels.unwrap_or_default().iter().enumerate() {
            socket.subscribe(id, channel["id"].as_u64().expect("a number"));
        }
        let frames = Arc::clone(&self.frames);
        self.readers.push(std::thread::spawn(move || {
            while let Ok(frame) = socket.try_receive() {
                if matches!(frame, Frame::Binary(_)) {
                    frames.fetch_add(1, Ordering::Relaxed);
                }
            }
        }));
    }

    /// After the end of the node: messages of Foxglove, pages and alarms that were read.
    fn finish(self) -> [u64; 3] {
        self.stop.store(true, Ordering::Relaxed);
        for reader in self.readers {
            reader.join().expect("a reader");
        }
        let alarms = std::iter::from_fn(|| self.subscriber.next_soon()).count();
        let counts = [&self.frames, &self.pages].map(|it| it.load(Ordering::Relaxed));
        [counts[0], counts[1], alarms as u64]
    }
}

fn has_page(port: u16) -> bool {
    let read = || -> std::io::Result<String> {
        let mut connection = TcpStream::connect(("127.0.0.1", port))?;
        connection.write_all(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n")?;
        let mut text = String::new();
        connection.read_to_string(&mut text)?;
        Ok(text)
    };
    read().is_ok_and(|it| it.starts_with("HTTP/1.1 200"))
}

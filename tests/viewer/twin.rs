//! A live twin under a simulated clock, with or without a viewer.

use column_twin::column::ImpactSpecification;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use column_twin::live::{Live, LiveHandle, LiveOptions, RealTime, Receiver, SimClock};
use column_twin::parameters::{Parameters, Value};
use column_twin::time::Nanos;
use column_twin::twin::{Command, ImpactCommand, NoticeLevel, Output, StateOutput, Twin};
use column_twin::viewer::{LiveViewer, Shown, VIEWER_QUEUE, ViewerLogger, output_queue};

pub const START: Nanos = 1_800_000_000_000_000_000;
pub const MS: Nanos = 1_000_000;

/// How long a test waits before it fails.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// The log lines of a viewer's thread.
pub type Log = Arc<Mutex<Vec<(NoticeLevel, String)>>>;

pub struct LiveColumn {
    pub live: LiveHandle,
    clock: Arc<SimClock>,
    receiver: Receiver,
    pub viewer: Option<LiveViewer>,
    pub log: Log,
    impacts: i64,
}

/// Parameters with these values under `viewer.`.
pub fn parameters(viewer: &[(&str, Value)]) -> Arc<Parameters> {
    let values = viewer
        .iter()
        .map(|(name, value)| (format!("viewer.{name}"), value.clone()));
    let own = [
        ("solver.dt".to_owned(), Value::from(1e-4)),
        ("publish_rate".to_owned(), Value::from(1000.0)),
    ];
    Arc::new(Parameters::from_values(own.into_iter().chain(values)).expect("admissible"))
}

impl LiveColumn {
    pub fn start(parameters: &Arc<Parameters>) -> Self {
        let twin = Twin::new((**parameters).clone(), None, Box::new(|| 0), START).expect("stands");
        let clock = Arc::new(SimClock::new(START));
        let mut options = LiveOptions {
            real_time: RealTime::none(),
            ..LiveOptions::default()
        };
        options.outputs.push(output_queue(1));
        let live = Live::start(twin, Arc::clone(&clock), options).expect("starts");
        let receiver = live.outputs("ros").expect("there");
        let outputs = live.outputs(VIEWER_QUEUE).expect("there");
        let lines = Log::default();
        let log: ViewerLogger = {
            let lines = Arc::clone(&lines);
            Arc::new(move |level, text| {
                println!("{level:?}: {text}");
                lines.lock().expect("no panic").push((level, text));
            })
        };
        let shown = Shown::Column(Arc::clone(parameters));
        let viewer = LiveViewer::start(parameters, shown, outputs, None, START, log);
        Self {
            live,
            clock,
            receiver,
            viewer: viewer.expect("a thread"),
            log: lines,
            impacts: 0,
        }
    }

    /// Hits the column once more and returns the whole response that goes to ROS.
    pub fn hit(&mut self, velocity: f64) -> Vec<StateOutput> {
        let stamp = START + 1_000 * MS * self.impacts;
        self.impacts += 1;
        self.clock.set(stamp);
        let event = ImpactCommand {
            event_id: format!("impact-{}", self.impacts),
            column_id: "column".to_owned(),
            stamp,
            vehicle: String::new(),
            impact: ImpactSpecification {
                mass: 1500.0,
                velocity,
                gap: None,
                restitution: None,
                height: None,
                direction: None,
            },
        };
        self.live.submit(Command::Impact(event)).expect("room");
        let mut states = Vec::new();
        let mut now = stamp;
        let deadline = Instant::now() + PATIENCE;
        let mut forecast = false;
        while Instant::now() < deadline {
            match self.receiver.try_next() {
                Some(Output::State(state)) => states.push(state),
                Some(Output::Forecast(_)) => forecast = true,
                Some(Output::Report(_)) => return states,
                Some(Output::Rejected(rejected)) => panic!("{rejected:?}"),
                Some(_) => {}
                None if forecast && now < stamp + 990 * MS => {
                    now += 5 * MS;
                    self.clock.set(now);
                }
                None => self.receiver.wait(Duration::from_millis(10)),
            }
        }
        panic!("no report; {} states", states.len());
    }

    /// Number of lost entries of the viewer's queue.
    pub fn dropped(&self) -> u64 {
        let queues = self.live.statistics().queues;
        let ours = queues.iter().filter(|it| it.name.ends_with("to viewer"));
        ours.map(|it| it.dropped).sum()
    }

    /// Number of waiting entries of the viewer's queue.
    pub fn waiting(&self) -> usize {
        let queues = self.live.statistics().queues;
        let ours = queues.iter().filter(|it| it.name.ends_with("to viewer"));
        ours.map(|it| it.len).sum()
    }

    /// Waits until the viewer's thread has logged this text.
    pub fn wait_for(&self, text: &str) {
        let deadline = Instant::now() + PATIENCE;
        while !self.has_logged(text) {
            assert!(Instant::now() < deadline, "not logged: {text}");
            std::thread::yield_now();
            std::thread::park_timeout(Duration::from_millis(10));
        }
    }

    pub fn has_logged(&self, text: &str) -> bool {
        let lines = self.log.lock().expect("no panic");
        lines.iter().any(|(_, line)| line.contains(text))
    }

    /// Stops viewer and twin and returns how long the viewer took.
    pub fn stop(mut self) -> Duration {
        let before = Instant::now();
        if let Some(viewer) = self.viewer.take() {
            viewer.stop();
        }
        let took = before.elapsed();
        self.live.stop().expect("no panic");
        took
    }
}

/// The complete states, for a comparison bit for bit.
pub fn bits(states: &[StateOutput]) -> Vec<(Nanos, String)> {
    let shown = |state: &StateOutput| {
        let StateOutput {
            event_id,
            phase,
            sample,
            ..
        } = state;
        // Debug prints every float so that it reads back to the same bits.
        format!("{event_id} {phase:?} {sample:?}")
    };
    states.iter().map(|it| (it.stamp, shown(it))).collect()
}

/// The states without a viewer.
pub fn without_viewer(velocities: &[f64]) -> Vec<(Nanos, String)> {
    let mut column = LiveColumn::start(&parameters(&[]));
    assert!(column.viewer.is_none());
    let states = velocities
        .iter()
        .flat_map(|it| column.hit(*it))
        .collect::<Vec<_>>();
    column.stop();
    bits(&states)
}

//! A live twin under a simulated clock, with or without a viewer.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use column_twin::live::{Live, LiveHandle, LiveOptions, RealTime, Receiver, SimClock};
use column_twin::parameters::{Parameters, Value};
use column_twin::twin::{ImpactEvent, Input, Nanos, Output, Severity, StateOutput, Twin};
use column_twin::viewer::{LiveViewer, ViewerLogger, VIEWER_QUEUE, output_queue};

pub const START: Nanos = 1_800_000_000_000_000_000;
pub const MS: Nanos = 1_000_000;

/// What has not happened by then never will.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// Everything that a viewer's thread has said.
pub type Said = Arc<Mutex<Vec<(Severity, String)>>>;

pub struct LiveColumn {
    pub live: LiveHandle,
    clock: Arc<SimClock>,
    receiver: Receiver,
    pub viewer: Option<LiveViewer>,
    pub said: Said,
    impacts: i64,
}

/// Parameters of the viewer, by the ends of their names.
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
        options.outputs.push(output_queue());
        let live = Live::start(twin, Arc::clone(&clock), options).expect("starts");
        let receiver = live.outputs("ros").expect("there");
        let outputs = live.outputs(VIEWER_QUEUE).expect("there");
        let said = Said::default();
        let log: ViewerLogger = {
            let said = Arc::clone(&said);
            Arc::new(move |severity, text| {
                println!("{severity:?}: {text}");
                said.lock().expect("no panic").push((severity, text));
            })
        };
        let viewer = LiveViewer::start(parameters, outputs, START, log).expect("a thread");
        Self {
            live,
            clock,
            receiver,
            viewer,
            said,
            impacts: 0,
        }
    }

    /// The whole response to one more impact, as it goes to ROS.
    pub fn hit(&mut self, velocity: f64) -> Vec<StateOutput> {
        let stamp = START + 1_000 * MS * self.impacts;
        self.impacts += 1;
        self.clock.set(stamp);
        let event = ImpactEvent {
            event_id: format!("impact-{}", self.impacts),
            column_id: "column".to_owned(),
            stamp,
            impact_mass: 1500.0,
            velocity,
            gap: None,
            restitution: None,
            height: None,
        };
        self.live.submit(Input::Impact(event)).expect("room");
        let mut states = Vec::new();
        let mut now = stamp;
        let given_up = Instant::now() + PATIENCE;
        let mut forecast = false;
        while Instant::now() < given_up {
            match self.receiver.try_next() {
                Some(Output::State(state)) => states.push(state),
                Some(Output::Forecast(_)) => forecast = true,
                Some(Output::Report(_)) => return states,
                Some(Output::Refused(refused)) => panic!("{refused:?}"),
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

    /// Entries of the viewer's queue that were lost.
    pub fn dropped(&self) -> u64 {
        let queues = self.live.statistics().queues;
        let ours = queues.iter().filter(|it| it.name.ends_with("to viewer"));
        ours.map(|it| it.dropped).sum()
    }

    /// Entries of the viewer's queue that wait.
    pub fn waiting(&self) -> usize {
        let queues = self.live.statistics().queues;
        let ours = queues.iter().filter(|it| it.name.ends_with("to viewer"));
        ours.map(|it| it.len).sum()
    }

    /// Waits until the viewer's thread has said this.
    pub fn wait_for(&self, text: &str) {
        let given_up = Instant::now() + PATIENCE;
        while !self.has_said(text) {
            assert!(Instant::now() < given_up, "not said: {text}");
            std::thread::yield_now();
            std::thread::park_timeout(Duration::from_millis(10));
        }
    }

    pub fn has_said(&self, text: &str) -> bool {
        let said = self.said.lock().expect("no panic");
        said.iter().any(|(_, line)| line.contains(text))
    }

    /// Stops viewer and twin; how long the viewer took.
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

/// All that a state says, to be compared bit for bit.
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

/// What comes out with nobody looking.
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

//! A twin that answers every event with the whole response of a virgin column at once, so that the node can be tested
//! without clocks.

use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};

use column_twin::column::{Impact, Report, Sample, simulate};
use column_twin::messages::column_twin::{ImpactEvent, ImpactReport, PredictImpactRequest};
use column_twin::parameters::Parameters;
use column_twin::ros::bridge::{Health, ParameterChange, Twin};
use column_twin::twin::{
    Change, Counts, Notice, Output, ParametersChanged, Refused, RefusedInput, ReportOutput,
    Severity, StateOutput, Status, TwinPhase,
};

/// Time between two samples that go out \[ns\], and in steps of the default 20 microseconds.
pub const SAMPLE_PERIOD: i64 = 100_000;
const STEPS_PER_SAMPLE: usize = 5;

pub struct ScriptedTwin {
    parameters: Mutex<Arc<Parameters>>,
    outputs: Mutex<Sender<Output>>,
    accepted: AtomicU64,
    refused: AtomicU64,
    clock: AtomicI64,
}

impl ScriptedTwin {
    pub fn start(parameters: Parameters) -> (Arc<Self>, Receiver<Output>) {
        let (sender, outputs) = channel();
        let twin = Arc::new(Self {
            parameters: Mutex::new(Arc::new(parameters)),
            outputs: Mutex::new(sender),
            accepted: AtomicU64::new(0),
            refused: AtomicU64::new(0),
            clock: AtomicI64::new(1_700_000_000_000_000_000),
        });
        twin.status("", "", "");
        (twin, outputs)
    }

    fn put(&self, output: Output) {
        self.outputs.lock().unwrap().send(output).unwrap();
    }

    fn status(&self, event_id: &str, refused_id: &str, reason: &str) {
        self.put(Output::Status(Status {
            stamp: self.now(),
            phase: TwinPhase::Idle,
            event_id: event_id.into(),
            counts: Counts {
                events_accepted: self.accepted.load(Ordering::Relaxed),
                events_refused: self.refused.load(Ordering::Relaxed),
                ..Counts::default()
            },
            last_refusal_reason: reason.into(),
            last_refusal_event_id: refused_id.into(),
            fault: "".into(),
            impacts_since_reset: 0,
            residual_v1: 0.0,
            residual_u2: 0.0,
            plastic_work_since_reset: 0.0,
            plastic_rotation: [0.0; 4],
            plastic_elongation: [0.0; 4],
        }));
    }

    fn refuse(&self, event_id: &str, reason: &str) {
        self.refused.fetch_add(1, Ordering::Relaxed);
        self.status("", event_id, reason);
        self.put(Output::Refused(Refused {
            stamp: self.now(),
            what: RefusedInput::Impact,
            reason: reason.into(),
            event_id: event_id.into(),
            source: "".into(),
        }));
    }
}

/// Every 5th sample of the response, and the report.
pub fn response(parameters: &Parameters, mass: f64, velocity: f64) -> (Vec<Sample>, Report) {
    let impact = Impact {
        mass,
        velocity,
        gap: 0.0,
        restitution: 0.0,
    };
    let (mut samples, mut step) = (Vec::new(), 0);
    let mut observe = |sample: &Sample| {
        if step % STEPS_PER_SAMPLE == 0 {
            samples.push(*sample);
        }
        step += 1;
    };
    let duration = parameters.response_duration();
    let report = simulate(
        &parameters.column_properties(),
        &impact,
        duration,
        &mut observe,
    )
    .expect("a possible impact");
    (samples, report)
}

impl Twin for ScriptedTwin {
    fn submit_impact(&self, event: ImpactEvent) -> Result<(), String> {
        let stamp = event.header.stamp.to_nanos().unwrap_or_default();
        if !(event.mass > 0.0 && event.velocity > 0.0) {
            self.refuse(&event.event_id, "mass and velocity must be above 0");
            return Ok(());
        }
        self.accepted.fetch_add(1, Ordering::Relaxed);
        let event_id: Arc<str> = event.event_id.into();
        let (samples, report) = response(&self.parameters(), event.mass, event.velocity);
        let report = ReportOutput {
            stamp,
            event_id: Arc::clone(&event_id),
            report,
            compute_time: 1e-3,
        };
        self.put(Output::Forecast(report.clone()));
        let last = samples.len() - 1;
        for (index, sample) in samples.into_iter().enumerate() {
            self.put(Output::State(StateOutput {
                stamp: stamp + SAMPLE_PERIOD * i64::try_from(index).unwrap(),
                event_id: Arc::clone(&event_id),
                phase: if index == last {
                    TwinPhase::Rest
                } else {
                    sample.phase.into()
                },
                sample,
                length_below: self.parameters().settings().geometry.length_below,
                length_above: self.parameters().settings().geometry.length_above,
            }));
        }
        self.put(Output::Report(report));
        self.status(&event_id, "", "");
        Ok(())
    }

    fn set_parameters(&self, change: ParameterChange) -> Result<(), String> {
        let mut parameters = self.parameters.lock().unwrap();
        let own = &parameters.settings().column_id;
        if change.column_id.as_ref().is_some_and(|id| id != own) {
            return Err(format!("this is the column {own}"));
        }
        let changed = parameters
            .with_changes(change.values)
            .map_err(|faults| faults.to_string())?;
        *parameters = Arc::new(changed);
        self.put(Output::ParametersChanged(ParametersChanged {
            stamp: self.now(),
            names: Vec::new(),
            change: Change::Applied,
            parameters: Arc::clone(&parameters),
            source: "test".into(),
        }));
        Ok(())
    }

    fn parameters(&self) -> Arc<Parameters> {
        Arc::clone(&self.parameters.lock().unwrap())
    }

    fn reset(&self) -> Result<String, String> {
        self.put(Output::Notice(Notice {
            stamp: self.now(),
            severity: Severity::Info,
            text: "reset".into(),
        }));
        Ok("the column is virgin".to_owned())
    }

    fn predict(&self, request: &PredictImpactRequest) -> Result<ImpactReport, String> {
        if !(request.mass > 0.0 && request.velocity > 0.0) {
            return Err("mass and velocity must be above 0".to_owned());
        }
        let (_, report) = response(&self.parameters(), request.mass, request.velocity);
        Ok(ImpactReport::from(&report))
    }

    fn health(&self) -> Health {
        Health::default()
    }

    fn now(&self) -> i64 {
        self.clock.load(Ordering::Relaxed)
    }

    fn set_clock(&self, now: i64) {
        self.clock.store(now, Ordering::Relaxed);
        self.status("", "", "");
    }
}

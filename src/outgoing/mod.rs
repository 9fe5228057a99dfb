//! Converts the outputs of the twin to messages. The node, recordings without ROS and `verify` share this conversion, so
//! that their messages are equal byte for byte.
//!
//! Every state with its hinge forces, every report, forecast and status becomes a message. Joint states and markers serve
//! only for display, and are published at a lower rate. The result depends only on the outputs since the last checkpoint.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - assessment.rs: The outcome of an impact with its assessment as messages
// - descriptions.rs: What the entries of the arrays about hinges and webs stand for
// - estimate.rs: What the sensors say about an impact as a message
// - joint_states.rs: The four hinges as joints, with rotation, rate and moment, for tools that plot or display joints
// - markers.rs: Markers for RViz and Foxglove: the deformed column, its hinges, the vehicle, and the contact force
// - second_opinion.rs: The second opinion on an impact as a message
// - tap.rs: The interface through which the node passes messages to a recording
// - withdrawn.rs: A forecast that no longer holds, or that will never be there, as a message

mod assessment;
mod descriptions;
mod estimate;
mod joint_states;
mod markers;
mod second_opinion;
#[cfg(feature = "live")]
mod tap;
mod withdrawn;

use serde::Serialize;

use crate::column::MAX_MASSES;
use crate::endpoints::{self, Endpoint};
use crate::messages::builtin_interfaces::Time;
use crate::messages::cdr::{self, CdrError};
use crate::messages::column_twin_msgs::{
    ColumnState, HingeForces, ImpactEstimate, ImpactReport, TwinStatus,
};
use crate::messages::sensor_msgs::JointState;
use crate::messages::std_msgs::Header;
use crate::messages::visualization_msgs::MarkerArray;
use crate::parameters::Parameters;
use crate::shape::{Heading, VehicleBody};
use crate::twin::{
    DamageCorrection, Journal, Lengths, Output, RejectionCode, ReportOutput, RestingColumn,
    StateOutput, Status, SupplementedReport, TwinPhase, WithdrawnForecast,
};
#[cfg(feature = "viewer")]
pub(crate) use assessment::action_code;
use joint_states::JointStates;
use markers::markers;
#[cfg(feature = "live")]
pub use tap::{RecordingHealth, RecordingTap};

/// Minimum time between the samples of two joint states \[ns\]: 100 Hz suffice for a plot.
const JOINT_STATES_PERIOD: i64 = 10_000_000;

/// Minimum time between the samples of two marker arrays \[ns\]: 25 Hz appear as continuous motion.
const MARKERS_PERIOD: i64 = 40_000_000;

/// Minimum time between the messages that show the column at rest \[ns\], so that a display that is started then shows it too:
/// somewhat less than the period of the status, with which they come.
const AT_REST_PERIOD: i64 = 900_000_000;

/// The header of a message; the column and the impact to which it belongs, if its type has fields for them.
type About<'a> = (Option<&'a Header>, Option<[&'a str; 2]>);

/// Of which states of a response a topic has a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum States {
    None,
    /// Those that a display needs.
    Some,
    Every,
}

// The topics with the types of their messages, their endpoints, of which states they have one, and what a message says about itself.
macro_rules! topics {
    ($($topic:ident($type:ty) $endpoint:ident $states:ident $about:expr;)*) => {
        /// A topic on which the twin publishes.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Topic {
            $(#[doc = concat!("See [`", stringify!($endpoint), "`](endpoints::", stringify!($endpoint), ").")] $topic),*
        }

        impl Topic {
            /// Number of topics.
            pub const COUNT: usize = [$(endpoints::$endpoint.name),*].len();

            /// All topics, each at its [`index`](Self::index).
            pub const ALL: [Self; Self::COUNT] = [$(Self::$topic),*];

            /// Name, type and quality of service.
            #[must_use]
            pub const fn endpoint(self) -> &'static Endpoint {
                match self { $(Self::$topic => &endpoints::$endpoint),* }
            }

            const fn states(self) -> States {
                match self { $(Self::$topic => States::$states),* }
            }
        }

        /// A message of the twin, on the topic of the same name. A status is without the state of threads and queues, which the node adds.
        #[derive(Debug, Clone, PartialEq, Serialize)]
        #[serde(untagged)]
        pub enum Message {
            $(#[doc = concat!("See [`", stringify!($endpoint), "`](endpoints::", stringify!($endpoint), ").")] $topic($type)),*
        }

        impl Message {
            /// The topic of the message.
            #[must_use]
            pub fn topic(&self) -> Topic {
                match self { $(Self::$topic(_) => Topic::$topic),* }
            }

            /// Encodes the message, with its encapsulation header.
            ///
            /// # Errors
            /// See [`cdr::encode`].
            pub fn encode(&self) -> Result<Vec<u8>, CdrError> {
                match self { $(Self::$topic(message) => cdr::encode(message)),* }
            }

            /// Decodes a message of a topic.
            ///
            /// # Errors
            /// See [`cdr::decode`].
            pub fn decode(topic: Topic, bytes: &[u8]) -> Result<Self, CdrError> {
                match topic { $(Topic::$topic => cdr::decode(bytes).map(Self::$topic)),* }
            }

            fn about(&self) -> About<'_> {
                match self {
                    $(Self::$topic(message) => {
                        let about: fn(&$type) -> About<'_> = $about;
                        about(message)
                    })*
                }
            }
        }
    };
}

topics! {
    ColumnState(ColumnState) COLUMN_STATE Every |it| (Some(&it.header), Some([&it.column_id, &it.event_id]));
    HingeForces(HingeForces) HINGE_FORCES Every |it| (Some(&it.header), Some([&it.column_id, &it.event_id]));
    ImpactForecast(ImpactReport) IMPACT_FORECAST None |it| (Some(&it.header), Some([&it.column_id, &it.event_id]));
    ImpactReport(ImpactReport) IMPACT_REPORT None |it| (Some(&it.header), Some([&it.column_id, &it.event_id]));
    ImpactEstimate(ImpactEstimate) IMPACT_ESTIMATE None |it| (Some(&it.header), Some([&it.column_id, &it.event_id]));
    TwinStatus(TwinStatus) TWIN_STATUS None |it| (Some(&it.header), Some([&it.column_id, &it.event_id]));
    JointStates(JointState) JOINT_STATES Some |it| (Some(&it.header), None);
    Markers(MarkerArray) MARKERS Some |it| (it.markers.first().map(|it| &it.header), None);
}

impl Topic {
    /// Index of the topic in [`ALL`](Self::ALL).
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Whether each of its messages shows a state of a response.
    #[must_use]
    pub const fn is_of_state(self) -> bool {
        !matches!(self.states(), States::None)
    }

    /// Whether every state of a response has such a message.
    #[must_use]
    pub const fn is_of_every_state(self) -> bool {
        matches!(self.states(), States::Every)
    }
}

impl Message {
    /// The stamp \[ns since 1970\]; `None` if it is not valid.
    #[must_use]
    pub fn stamp(&self) -> Option<i64> {
        self.about().0?.stamp.to_nanos()
    }

    /// The column to which the message belongs; `None` if its type has no such field.
    #[must_use]
    pub fn column_id(&self) -> Option<&str> {
        self.about().1.map(|[column_id, _]| column_id)
    }

    /// The impact to which the message belongs; `None` if its type has no such field.
    #[must_use]
    pub fn event_id(&self) -> Option<&str> {
        self.about().1.map(|[_, event_id]| event_id)
    }
}

/// Converts the outputs of a twin to messages.
#[derive(Debug, Clone)]
pub struct Outgoing {
    column_id: String,
    frame_id: String,
    /// Lengths for states that do not contain them.
    lengths: Lengths,
    joints: JointStates,
    joint_states: Thinning,
    markers: Thinning,
    at_rest: Thinning,
}

impl Outgoing {
    /// A converter for a twin with these parameters.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let settings = parameters.settings();
        Self {
            column_id: settings.column_id.clone(),
            frame_id: settings.frame_id.clone(),
            lengths: Lengths::from(parameters),
            joints: JointStates::default(),
            joint_states: Thinning::new(JOINT_STATES_PERIOD),
            markers: Thinning::new(MARKERS_PERIOD),
            at_rest: Thinning::new(AT_REST_PERIOD),
        }
    }

    /// Passes the messages for an output to `put`; outputs that are not published have none.
    pub fn convert(&mut self, output: &Output, mut put: impl FnMut(Message)) {
        match output {
            Output::State(state) => self.state(state, put),
            Output::Forecast(report) => {
                put(Message::ImpactForecast(
                    self.report(report, ImpactReport::FORECAST),
                ));
            }
            Output::Report(report) => {
                put(Message::ImpactReport(
                    self.report(report, ImpactReport::RESULT),
                ));
            }
            Output::Supplemented(SupplementedReport {
                report, is_result, ..
            }) => put(match is_result {
                true => Message::ImpactReport(self.report(report, ImpactReport::RESULT)),
                false => Message::ImpactForecast(self.report(report, ImpactReport::FORECAST)),
            }),
            Output::Withdrawn(withdrawn) => {
                put(Message::ImpactForecast(self.withdrawn(withdrawn)));
            }
            Output::Estimate(estimate) => {
                put(Message::ImpactEstimate(ImpactEstimate {
                    header: self.header(estimate.stamp),
                    column_id: self.column_id.clone(),
                    ..ImpactEstimate::from(estimate)
                }));
            }
            Output::Status(status) => {
                if let Some(resting) = &status.at_rest {
                    self.resting(status.stamp, resting, &mut put);
                }
                // Last, because with it a recording of events ends.
                put(Message::TwinStatus(self.status(status)));
            }
            Output::Journal(Journal::Checkpoint(_)) => {
                self.joints = JointStates::default();
                self.joint_states = Thinning::new(JOINT_STATES_PERIOD);
                self.markers = Thinning::new(MARKERS_PERIOD);
                self.at_rest = Thinning::new(AT_REST_PERIOD);
            }
            Output::Journal(Journal::Command(_) | Journal::Status(_))
            | Output::Rejected(_)
            | Output::Replaced(_)
            | Output::Merged(_)
            | Output::DamageCorrected(_)
            | Output::ParametersChanged(_)
            | Output::Notice(_)
            | Output::Save(_) => {}
        }
    }

    fn state(&mut self, output: &StateOutput, mut put: impl FnMut(Message)) {
        let StateOutput {
            stamp,
            event_id,
            phase,
            sample,
            lengths,
            vehicle,
        } = output;
        let header = self.header(*stamp);
        let mut state = ColumnState::from(sample);
        state.phase = phase_code(*phase);
        state.header.clone_from(&header);
        state.column_id.clone_from(&self.column_id);
        state.event_id = event_id.to_string();
        put(Message::ColumnState(state));
        let mut forces = HingeForces::from(sample);
        forces.header.clone_from(&header);
        forces.column_id.clone_from(&self.column_id);
        forces.event_id = event_id.to_string();
        put(Message::HingeForces(forces));
        let running = matches!(
            phase,
            TwinPhase::Approach | TwinPhase::Contact | TwinPhase::Free
        );
        if self.joint_states.passes(*stamp, running) {
            let message = self.joints.convert(*stamp, header.clone(), sample);
            put(Message::JointStates(message));
        }
        if self.markers.passes(*stamp, running) {
            let lengths = lengths.unwrap_or(self.lengths);
            let (name, mass, direction) = match vehicle {
                Some(it) => (&*it.name, it.mass, it.direction),
                None => ("", 0.0, 0.0),
            };
            let slack = &[0.0; MAX_MASSES][..sample.vehicle.masses.min(MAX_MASSES)];
            let body = VehicleBody::named(name, mass, slack);
            let heading = Heading::new(direction);
            put(Message::Markers(markers(
                &header, lengths, &body, heading, sample,
            )));
        }
    }

    /// The column at rest, for displays that were started after the last response. The markers of that response, which show
    /// the vehicle too, are kept for late joiners.
    fn resting(&mut self, stamp: i64, resting: &RestingColumn, mut put: impl FnMut(Message)) {
        if !self.at_rest.passes(stamp, true) {
            return;
        }
        let RestingColumn {
            sample,
            lengths,
            is_unseen,
        } = resting;
        let header = self.header(stamp);
        let joints = JointStates::at_rest(header.clone(), sample);
        put(Message::JointStates(joints));
        if *is_unseen {
            let nothing = VehicleBody::named("", 0.0, &[]);
            let heading = Heading::default();
            put(Message::Markers(markers(
                &header, *lengths, &nothing, heading, sample,
            )));
        }
    }

    fn report(&self, output: &ReportOutput, kind: u8) -> ImpactReport {
        ImpactReport {
            header: self.header(output.stamp),
            column_id: self.column_id.clone(),
            event_id: output.event_id.to_string(),
            kind,
            ..ImpactReport::from(output)
        }
    }

    fn withdrawn(&self, withdrawn: &WithdrawnForecast) -> ImpactReport {
        let impact = &withdrawn.impact;
        ImpactReport {
            header: self.header(impact.stamp),
            column_id: self.column_id.clone(),
            event_id: impact.event_id.to_string(),
            ..ImpactReport::from(withdrawn)
        }
    }

    fn status(&self, status: &Status) -> TwinStatus {
        let correction = |of: fn(&DamageCorrection) -> f64| {
            let last = status.last_correction.as_ref();
            last.map_or(f64::NAN, of)
        };
        TwinStatus {
            header: self.header(status.stamp),
            column_id: self.column_id.clone(),
            phase: phase_code(status.phase),
            event_id: status.event_id.to_string(),
            events_accepted: status.counts.events_accepted,
            events_merged: status.counts.events_merged,
            events_rejected: status.counts.events_rejected,
            parameters_accepted: status.counts.parameters_accepted,
            parameters_rejected: status.counts.parameters_rejected,
            last_rejection_code: status
                .last_rejection_code
                .map_or(TwinStatus::REJECTED_NONE, RejectionCode::number),
            last_rejection_reason: status.last_rejection_reason.to_string(),
            last_rejection_event_id: status.last_rejection_event_id.to_string(),
            fault: status.fault.to_string(),
            waiting_estimate: status.waiting_estimate.to_string(),
            impacts_since_reset: status.impacts_since_reset,
            corrections_since_reset: status.corrections_since_reset,
            correction_before: correction(|it| it.before),
            correction_measured: correction(|it| it.measured),
            correction_after: correction(|it| it.after),
            residual_v1: status.residual_v1,
            residual_u2: status.residual_u2,
            plastic_work_since_reset: status.plastic_work_since_reset,
            hinges: descriptions::hinges(status.lengths),
            webs: descriptions::webs(status.lengths),
            plastic_rotation: status.plastic_rotation.into(),
            plastic_elongation: status.plastic_elongation.into(),
            shear_angle: status.shear_angle.into(),
            ..TwinStatus::default()
        }
        .assessed(status)
    }

    /// The header of a message with this stamp, in the frame of the column.
    #[must_use]
    pub fn header(&self, stamp: i64) -> Header {
        Header {
            stamp: Time::from_nanos(stamp).unwrap_or_default(),
            frame_id: self.frame_id.clone(),
        }
    }
}

/// The code of a phase in `ColumnState` and `TwinStatus`.
#[must_use]
pub fn phase_code(phase: TwinPhase) -> u8 {
    match phase {
        TwinPhase::Idle => TwinStatus::IDLE,
        TwinPhase::Approach => TwinStatus::APPROACH,
        TwinPhase::Contact => TwinStatus::CONTACT,
        TwinPhase::Free => TwinStatus::FREE,
        TwinPhase::Rest => TwinStatus::REST,
        TwinPhase::Collapsed => TwinStatus::COLLAPSED,
        TwinPhase::Fractured => TwinStatus::FRACTURED,
        TwinPhase::Faulted => TwinStatus::FAULTED,
    }
}

/// Reduces a stream of samples to a minimum period.
#[derive(Debug, Clone)]
struct Thinning {
    period: i64,
    last: Option<i64>,
}

impl Thinning {
    fn new(period: i64) -> Self {
        Self { period, last: None }
    }

    /// Whether the sample is kept. Samples outside of a running response are always kept, because the last sample of a
    /// response remains on display.
    fn passes(&mut self, stamp: i64, running: bool) -> bool {
        let passes = !running
            || self
                .last
                .is_none_or(|last| stamp < last || stamp - last >= self.period);
        if passes {
            self.last = Some(stamp);
        }
        passes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_first_the_spaced_and_the_last() {
        let mut thinning = Thinning::new(10);
        let passed: Vec<i64> = (0..35)
            .filter(|stamp| thinning.passes(*stamp, true))
            .collect();
        assert_eq!(passed, [0, 10, 20, 30]);
        assert!(thinning.passes(35, false));
        // After a late impact or a rewound recording.
        assert!(thinning.passes(3, true));
    }

    #[test]
    fn every_message_has_the_topic_of_its_type() {
        use crate::messages::Message as _;
        let types = [
            ColumnState::INTERFACE,
            HingeForces::INTERFACE,
            ImpactReport::INTERFACE,
            ImpactReport::INTERFACE,
            ImpactEstimate::INTERFACE,
            TwinStatus::INTERFACE,
            JointState::INTERFACE,
            MarkerArray::INTERFACE,
        ];
        let messages = [
            Message::ColumnState(ColumnState::default()),
            Message::HingeForces(HingeForces::default()),
            Message::ImpactForecast(ImpactReport::default()),
            Message::ImpactReport(ImpactReport::default()),
            Message::ImpactEstimate(ImpactEstimate::default()),
            Message::TwinStatus(TwinStatus::default()),
            Message::JointStates(JointState::default()),
            Message::Markers(MarkerArray::default()),
        ];
        for (index, message) in messages.iter().enumerate() {
            let topic = Topic::ALL[index];
            assert_eq!((message.topic(), topic.index()), (topic, index));
            assert_eq!(topic.endpoint().type_name, types[index].ros_name());
            let bytes = message.encode().expect("bytes");
            // Bytes, because a second opinion that there is not has no numbers.
            let decoded = Message::decode(topic, &bytes).expect("the same");
            assert_eq!(decoded.encode().expect("bytes"), bytes);
        }
    }

    #[test]
    fn rejection_codes_are_the_constants_of_the_status() {
        use crate::messages::Message as _;
        use re_ros_msg::message_spec::Literal;
        let definition = TwinStatus::INTERFACE.specification().expect("valid");
        let constants: Vec<_> = definition
            .constants
            .into_iter()
            .filter(|it| it.name.starts_with("REJECTED_") && it.name != "REJECTED_NONE")
            .map(|it| (it.name, it.value))
            .collect();
        let codes: Vec<_> = RejectionCode::ALL
            .iter()
            .map(|code| {
                let name = format!("REJECTED_{}", code.name().to_uppercase());
                (name, Literal::UInt(code.number().into()))
            })
            .collect();
        assert_eq!(constants, codes);
    }
}

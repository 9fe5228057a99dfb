//! All endpoints of the node with their quality of service, which never relies on the defaults of a library.

/// An endpoint of the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Endpoint {
    /// Name before expansion and remapping.
    pub name: &'static str,
    /// ROS name of the type, `column_twin_msgs/msg/ColumnState`.
    pub type_name: &'static str,
    /// The direction of its messages.
    pub direction: Direction,
    /// Quality of service; for a service, that of requests and replies.
    pub qos: Qos,
    /// Which nodes have it; `None`: all.
    pub owner: Option<NodeKind>,
    /// Whether its messages are recorded.
    pub is_recorded: bool,
    /// Whether it shows columns at rest as well, again and again. The others tell what follows from an impact.
    pub shows_rest: bool,
}

/// What a node shows of its columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NodeKind {
    /// One column, under the names of the node. What only such a node has is in the namespaces of the columns of a fleet, if anywhere.
    #[default]
    Single,
    /// Columns that share topics and services, so that messages name their column.
    Fleet,
}

/// The direction of messages, from the point of view of the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// The node subscribes.
    In,
    /// The node publishes.
    Out,
    /// The node answers requests.
    Service,
}

/// Quality of service. The deadline is infinite and liveliness is automatic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Qos {
    /// Lost samples are sent again.
    pub reliable: bool,
    /// Late subscribers receive the last samples.
    pub transient_local: bool,
    /// Number of samples in the history.
    pub depth: usize,
    /// Time after which a sample expires \[s\]; `None`: never.
    pub lifespan: Option<u64>,
}

impl Qos {
    const fn reliable(depth: usize) -> Self {
        Self {
            reliable: true,
            transient_local: false,
            depth,
            lifespan: None,
        }
    }

    const fn latched(depth: usize) -> Self {
        Self {
            transient_local: true,
            ..Self::reliable(depth)
        }
    }
}

impl Endpoint {
    const fn new(
        name: &'static str,
        type_name: &'static str,
        direction: Direction,
        qos: Qos,
    ) -> Self {
        Self {
            name,
            type_name,
            direction,
            qos,
            owner: None,
            is_recorded: false,
            shows_rest: false,
        }
    }

    const fn single(self) -> Self {
        Self {
            owner: Some(NodeKind::Single),
            ..self
        }
    }

    const fn fleet(self) -> Self {
        Self {
            owner: Some(NodeKind::Fleet),
            ..self
        }
    }

    const fn recorded(self) -> Self {
        Self {
            is_recorded: true,
            ..self
        }
    }

    const fn at_rest(self) -> Self {
        Self {
            shows_rest: true,
            ..self
        }
    }

    /// Whether a node of this kind has it.
    #[must_use]
    pub fn is_of(&self, kind: NodeKind) -> bool {
        self.owner.is_none_or(|owner| owner == kind)
    }

    /// Package and bare name of the type.
    #[must_use]
    pub fn package_and_type(&self) -> (&'static str, &'static str) {
        package_and_type(self.type_name)
    }
}

/// Package and bare name of a type such as `column_twin_msgs/msg/ColumnState`.
#[must_use]
pub fn package_and_type(type_name: &str) -> (&str, &str) {
    let package = type_name.split('/').next().unwrap_or_default();
    let name = type_name.rsplit('/').next().unwrap_or_default();
    (package, name)
}

/// Most messages that the history of a fleet holds: as many as RustDDS allows to be unacknowledged.
pub const MAX_DEPTH_OF_A_FLEET: usize = 8192;

impl Endpoint {
    /// The depth with which a reader of a topic that the columns of a fleet share loses nothing when all of them are hit at once, while
    /// it takes nothing until all responses are over: for each column its forecasts (the first one, with its error, with the second
    /// opinion, with its range, and their withdrawal), its reports (the first one, with the second opinion, and with the range), or each
    /// status between two states of rest. A report takes 6 kB. States come by the thousands and are not among them.
    #[must_use]
    pub fn depth_of_a_fleet(&self, columns: usize) -> usize {
        let of_each = match self.name {
            "impact_forecast" => 5,
            "impact_report" => 3,
            "twin_status" => 10,
            _ => 0,
        };
        (of_each * columns).clamp(self.qos.depth, MAX_DEPTH_OF_A_FLEET)
    }

    /// The endpoint with a history for all columns of a fleet, if it keeps messages for late joiners.
    #[must_use]
    pub fn kept_of_all(&self, columns: usize) -> Self {
        let mut endpoint = *self;
        if endpoint.qos.transient_local {
            endpoint.qos.depth = match endpoint.qos.depth {
                // A late joiner gets the newest message of each column.
                1 => columns.clamp(1, MAX_DEPTH_OF_A_FLEET),
                _ => endpoint.depth_of_a_fleet(columns),
            };
        }
        endpoint
    }
}

macro_rules! endpoints {
    ($($(#[$doc:meta])* $constant:ident = $name:literal $type_name:literal $direction:ident $qos:expr $(, $property:ident)*;)*) => {
        $($(#[$doc])* pub const $constant: Endpoint = Endpoint::new($name, $type_name, Direction::$direction, $qos)$(.$property())*;)*

        /// All endpoints.
        pub const ENDPOINTS: &[Endpoint] = &[$($constant),*];
    };
}

/// Samples of sensors. Best effort, which matches reliable and best-effort senders alike: a sample that comes again after it was lost
/// would be too late for the estimate, and lost ones are seen by their times. The depth holds what 16 sensors send in 0.6 s, in
/// batches of 10 ms.
pub const SENSOR_DATA: Qos = Qos {
    reliable: false,
    ..Qos::reliable(1000)
};

/// Reliable and volatile, as the services of rcl. Their depth of 10 would let RustDDS keep 64 requests that wait for an answer and
/// drop the others of a burst without a word.
const SERVICE: Qos = Qos::reliable(2000);

endpoints! {
    /// Impact events.
    IMPACT_EVENT = "impact_event" "column_twin_msgs/msg/ImpactEvent" In Qos::reliable(100), recorded;
    /// Impacts of one vehicle on several columns of a fleet.
    ROW_IMPACT_EVENT = "row_impact_event" "column_twin_msgs/msg/RowImpactEvent" In Qos::reliable(100), fleet;
    /// Parameters of the column.
    COLUMN_PARAMETERS = "column_parameters" "column_twin_msgs/msg/ColumnParameters" In Qos::reliable(10), recorded;
    /// Samples of the sensors on the column.
    MEASUREMENTS = "measurements" "column_twin_msgs/msg/Measurement" In SENSOR_DATA, recorded;
    /// Simulated time.
    CLOCK = "/clock" "rosgraph_msgs/msg/Clock" In Qos { reliable: false, ..Qos::reliable(1) };
    /// State at `publish_rate`.
    COLUMN_STATE = "column_state" "column_twin_msgs/msg/ColumnState" Out Qos::reliable(1000), recorded;
    /// Hinge forces at `publish_rate`.
    HINGE_FORCES = "hinge_forces" "column_twin_msgs/msg/HingeForces" Out Qos::reliable(1000), recorded;
    /// Predicted outcome of an impact.
    IMPACT_FORECAST = "impact_forecast" "column_twin_msgs/msg/ImpactReport" Out Qos::latched(10), recorded;
    /// Outcome of an impact.
    IMPACT_REPORT = "impact_report" "column_twin_msgs/msg/ImpactReport" Out Qos::latched(10), recorded;
    /// An impact, estimated from the sensors; latched, so that a late subscriber has the newest estimate, and no stale one.
    IMPACT_ESTIMATE = "impact_estimate" "column_twin_msgs/msg/ImpactEstimate" Out Qos::latched(1), recorded;
    /// State of the twin.
    TWIN_STATUS = "twin_status" "column_twin_msgs/msg/TwinStatus" Out Qos::latched(1), recorded, at_rest;
    /// Status of the columns of a fleet; as many messages are kept for late joiners as one round of all columns takes.
    FLEET_STATUS = "fleet_status" "column_twin_msgs/msg/FleetStatus" Out Qos::latched(20), recorded, at_rest, fleet;
    /// The hinges as joints.
    JOINT_STATES = "joint_states" "sensor_msgs/msg/JointState" Out Qos::reliable(10), recorded, at_rest, single;
    /// The deformed column; latched, so that late viewers show it as the last response left it. At rest it is published once per second
    /// until the first response.
    MARKERS = "markers" "visualization_msgs/msg/MarkerArray" Out Qos::latched(1), recorded, at_rest, single;
    /// Health of the node.
    DIAGNOSTICS = "/diagnostics" "diagnostic_msgs/msg/DiagnosticArray" Out Qos::reliable(10), recorded;
    /// Log messages, published as rcl does.
    ROSOUT = "/rosout" "rcl_interfaces/msg/Log" Out Qos { lifespan: Some(10), ..Qos::latched(1000) }, recorded;
    /// Parameter changes, published as rclcpp does.
    PARAMETER_EVENTS = "/parameter_events" "rcl_interfaces/msg/ParameterEvent" Out Qos::reliable(1000), recorded;
    /// Returns to the undamaged column.
    RESET = "~/reset" "std_srvs/srv/Trigger" Service SERVICE, single;
    /// Returns to one undamaged column of a fleet.
    RESET_COLUMN = "~/reset_column" "column_twin_msgs/srv/ResetColumn" Service SERVICE, fleet;
    /// Predicts the outcome of an impact without executing it.
    PREDICT = "~/predict" "column_twin_msgs/srv/PredictImpact" Service SERVICE;
    /// Accepts or rejects the newest impact that the sensors have detected.
    CONFIRM_ESTIMATE = "~/confirm_estimate" "column_twin_msgs/srv/ConfirmEstimate" Service SERVICE;
    /// Corrects the damage of the column at rest by a measurement.
    CORRECT_DAMAGE = "~/correct_damage" "column_twin_msgs/srv/CorrectDamage" Service SERVICE;
    /// Parameter service.
    GET_PARAMETERS = "~/get_parameters" "rcl_interfaces/srv/GetParameters" Service SERVICE;
    /// Parameter service.
    GET_PARAMETER_TYPES = "~/get_parameter_types" "rcl_interfaces/srv/GetParameterTypes" Service SERVICE;
    /// Parameter service.
    LIST_PARAMETERS = "~/list_parameters" "rcl_interfaces/srv/ListParameters" Service SERVICE;
    /// Parameter service.
    DESCRIBE_PARAMETERS = "~/describe_parameters" "rcl_interfaces/srv/DescribeParameters" Service SERVICE;
    /// Parameter service.
    SET_PARAMETERS = "~/set_parameters" "rcl_interfaces/srv/SetParameters" Service SERVICE;
    /// Describes the types of the node.
    GET_TYPE_DESCRIPTION = "~/get_type_description" "type_description_interfaces/srv/GetTypeDescription" Service SERVICE;
    /// Parameter service.
    SET_PARAMETERS_ATOMICALLY = "~/set_parameters_atomically" "rcl_interfaces/srv/SetParametersAtomically" Service SERVICE;
    /// Changes the state of a managed node.
    CHANGE_STATE = "~/change_state" "lifecycle_msgs/srv/ChangeState" Service SERVICE;
    /// The state of a managed node.
    GET_STATE = "~/get_state" "lifecycle_msgs/srv/GetState" Service SERVICE;
    /// All states of a managed node.
    GET_AVAILABLE_STATES = "~/get_available_states" "lifecycle_msgs/srv/GetAvailableStates" Service SERVICE;
    /// The transitions that begin in the state of a managed node.
    GET_AVAILABLE_TRANSITIONS = "~/get_available_transitions" "lifecycle_msgs/srv/GetAvailableTransitions" Service SERVICE;
    /// All transitions of a managed node.
    GET_TRANSITION_GRAPH = "~/get_transition_graph" "lifecycle_msgs/srv/GetAvailableTransitions" Service SERVICE;
    /// The transitions that a managed node makes.
    TRANSITION_EVENT = "~/transition_event" "lifecycle_msgs/msg/TransitionEvent" Out Qos::reliable(10);
}

/// The [journal](crate::twin::Journal) of the twin: only recorded, never published.
pub const JOURNAL: Endpoint = Endpoint::new(
    "~/journal",
    "std_msgs/msg/String",
    Direction::Out,
    Qos::latched(1),
)
.recorded();

//! Every endpoint of the node with its quality of service, written out: no default of a library holds anywhere.

/// An endpoint of the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Endpoint {
    /// Name before expansion and remapping.
    pub name: &'static str,
    /// ROS name of the type, `column_twin/msg/ColumnState`.
    pub type_name: &'static str,
    /// Who sends.
    pub direction: Direction,
    /// Quality of service; of a service that of requests and replies.
    pub qos: Qos,
}

/// Who sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// The node receives.
    In,
    /// The node sends.
    Out,
    /// The node answers.
    Service,
}

/// Quality of service. Deadline and lifespan are infinite but for `/rosout`, liveliness is automatic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Qos {
    /// Lost samples are sent again.
    pub reliable: bool,
    /// Late joiners get the last samples.
    pub transient_local: bool,
    /// Number of samples that are kept.
    pub depth: usize,
    /// How long a sample is of use \[s\]; `None`: for ever.
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
        }
    }

    /// Package and bare name of the type.
    #[must_use]
    pub fn package_and_type(&self) -> (&'static str, &'static str) {
        package_and_type(self.type_name)
    }
}

/// Package and bare name of a type, of `column_twin/msg/ColumnState` say.
#[must_use]
pub fn package_and_type(type_name: &str) -> (&str, &str) {
    let package = type_name.split('/').next().unwrap_or_default();
    let name = type_name.rsplit('/').next().unwrap_or_default();
    (package, name)
}

macro_rules! endpoints {
    ($($(#[$doc:meta])* $constant:ident = $name:literal $type_name:literal $direction:ident $qos:expr;)*) => {
        $($(#[$doc])* pub const $constant: Endpoint = Endpoint::new($name, $type_name, Direction::$direction, $qos);)*

        /// All of them.
        pub const ENDPOINTS: &[Endpoint] = &[$($constant),*];
    };
}

/// What rcl gives every service.
const SERVICE: Qos = Qos::reliable(10);

endpoints! {
    /// Impacts to come.
    IMPACT_EVENT = "impact_event" "column_twin/msg/ImpactEvent" In Qos::reliable(100);
    /// Parameters of the whole column.
    COLUMN_PARAMETERS = "column_parameters" "column_twin/msg/ColumnParameters" In Qos::reliable(10);
    /// Simulated time.
    CLOCK = "/clock" "rosgraph_msgs/msg/Clock" In Qos { reliable: false, ..Qos::reliable(1) };
    /// State at `publish_rate`.
    COLUMN_STATE = "column_state" "column_twin/msg/ColumnState" Out Qos::reliable(1000);
    /// Hinge forces at `publish_rate`.
    HINGE_FORCES = "hinge_forces" "column_twin/msg/HingeForces" Out Qos::reliable(1000);
    /// What will come of an impact.
    IMPACT_FORECAST = "impact_forecast" "column_twin/msg/ImpactReport" Out Qos::latched(10);
    /// What came of it.
    IMPACT_REPORT = "impact_report" "column_twin/msg/ImpactReport" Out Qos::latched(10);
    /// The twin's own state.
    TWIN_STATUS = "twin_status" "column_twin/msg/TwinStatus" Out Qos::latched(1);
    /// The hinges as joints.
    JOINT_STATES = "joint_states" "sensor_msgs/msg/JointState" Out Qos::reliable(10);
    /// The column to look at; latched, so that a viewer that comes late sees it as the last response left it. Nothing is
    /// sent before the first response.
    MARKERS = "markers" "visualization_msgs/msg/MarkerArray" Out Qos::latched(1);
    /// Health.
    DIAGNOSTICS = "/diagnostics" "diagnostic_msgs/msg/DiagnosticArray" Out Qos::reliable(10);
    /// Log messages, as rcl sends them.
    ROSOUT = "/rosout" "rcl_interfaces/msg/Log" Out Qos { lifespan: Some(10), ..Qos::latched(1000) };
    /// Changed parameters, as rclcpp sends them.
    PARAMETER_EVENTS = "/parameter_events" "rcl_interfaces/msg/ParameterEvent" Out Qos::reliable(1000);
    /// Back to the virgin column.
    RESET = "~/reset" "std_srvs/srv/Trigger" Service SERVICE;
    /// What if.
    PREDICT = "~/predict" "column_twin/srv/PredictImpact" Service SERVICE;
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
    /// Parameter service.
    SET_PARAMETERS_ATOMICALLY = "~/set_parameters_atomically" "rcl_interfaces/srv/SetParametersAtomically" Service SERVICE;
}

/// What a recording holds beside these: see [`Journal`](crate::twin::Journal). Nobody sends it.
pub const JOURNAL: Endpoint = Endpoint::new(
    "~/journal",
    "std_msgs/msg/String",
    Direction::Out,
    Qos::latched(1),
);

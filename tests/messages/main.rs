//! The messages are what `msg/` and `srv/` say, on the wire and in recordings.

mod bounded_reading;
mod conversions;
mod definitions;
mod foxglove_layout;
mod golden_bytes;
mod idl;
mod ros2_itself;

use column_twin::messages::{
    Message, builtin_interfaces, column_twin_msgs as ours, diagnostic_msgs, geometry_msgs,
    lifecycle_msgs, rcl_interfaces, rosgraph_msgs, sensor_msgs, service_msgs, std_msgs, std_srvs,
    visualization_msgs,
};

/// What a test does with one type.
trait ForEachType {
    fn visit<M: Message + PartialEq + std::fmt::Debug>(&mut self);
}

/// Shows every type of the table to `visitor`; that none is left out is tested in `definitions`.
fn for_each_type(visitor: &mut impl ForEachType) {
    macro_rules! visit {
        ($($type:ty),* $(,)?) => { $(visitor.visit::<$type>();)* };
    }
    visit!(
        ours::AssessmentCriterion,
        ours::BaseForces,
        ours::ColumnParameters,
        ours::ColumnState,
        ours::ColumnStatus,
        ours::ConfirmEstimateRequest,
        ours::ConfirmEstimateResponse,
        ours::CorrectDamageRequest,
        ours::CorrectDamageResponse,
        ours::CredibleInterval,
        ours::FleetStatus,
        ours::HingeDescription,
        ours::HingeForces,
        ours::ImpactEstimate,
        ours::ImpactEvent,
        ours::ImpactReport,
        ours::Measurement,
        ours::PredictImpactRequest,
        ours::PredictImpactResponse,
        ours::ResetColumnRequest,
        ours::ResetColumnResponse,
        ours::RowImpactEvent,
        ours::SecondOpinion,
        ours::TwinStatus,
        builtin_interfaces::Duration,
        builtin_interfaces::Time,
        diagnostic_msgs::DiagnosticArray,
        diagnostic_msgs::DiagnosticStatus,
        diagnostic_msgs::KeyValue,
        geometry_msgs::Accel,
        geometry_msgs::AccelStamped,
        geometry_msgs::Point,
        geometry_msgs::Pose,
        geometry_msgs::Quaternion,
        geometry_msgs::Vector3,
        lifecycle_msgs::ChangeStateRequest,
        lifecycle_msgs::ChangeStateResponse,
        lifecycle_msgs::GetAvailableStatesRequest,
        lifecycle_msgs::GetAvailableStatesResponse,
        lifecycle_msgs::GetAvailableTransitionsRequest,
        lifecycle_msgs::GetAvailableTransitionsResponse,
        lifecycle_msgs::GetStateRequest,
        lifecycle_msgs::GetStateResponse,
        lifecycle_msgs::State,
        lifecycle_msgs::Transition,
        lifecycle_msgs::TransitionDescription,
        lifecycle_msgs::TransitionEvent,
        rcl_interfaces::Log,
        rcl_interfaces::Parameter,
        rcl_interfaces::ParameterEvent,
        rcl_interfaces::ParameterValue,
        rosgraph_msgs::Clock,
        sensor_msgs::CompressedImage,
        sensor_msgs::Imu,
        sensor_msgs::JointState,
        service_msgs::ServiceEventInfo,
        std_msgs::ColorRGBA,
        std_msgs::Header,
        std_msgs::String,
        std_srvs::TriggerRequest,
        std_srvs::TriggerResponse,
        visualization_msgs::Marker,
        visualization_msgs::MarkerArray,
        visualization_msgs::MeshFile,
        visualization_msgs::UVCoordinate,
    );
}

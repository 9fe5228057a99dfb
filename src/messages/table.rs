//! The table of message types: every struct with its ROS name and the file that defines it.

use ros_interface::{Interface, Message, Part};

use super::{
    builtin_interfaces, column_twin_msgs, diagnostic_msgs, geometry_msgs, lifecycle_msgs,
    rcl_interfaces, rosgraph_msgs, sensor_msgs, service_msgs, std_msgs, std_srvs,
    visualization_msgs,
};

/// Connects each struct with its file, and lists all of them, so that no type can be missing from the list.
macro_rules! interfaces {
    ($($package:ident $part:ident $name:ident = $type:ident in $file:literal;)*) => {
        $(impl Message for $package::$type {
            const INTERFACE: &'static Interface = &Interface::new(
                stringify!($package), Part::$part, stringify!($name), include_str!(concat!("../../", $file)),
            );
        })*

        /// All types that the twin reads or writes, with their dependencies.
        pub const INTERFACES: &[&Interface] = &[$(<$package::$type as Message>::INTERFACE),*];
    };
}

interfaces! {
    column_twin_msgs Message AssessmentCriterion = AssessmentCriterion in "msg/AssessmentCriterion.msg";
    column_twin_msgs Message BaseForces = BaseForces in "msg/BaseForces.msg";
    column_twin_msgs Message ColumnParameters = ColumnParameters in "msg/ColumnParameters.msg";
    column_twin_msgs Message ColumnState = ColumnState in "msg/ColumnState.msg";
    column_twin_msgs Message ColumnStatus = ColumnStatus in "msg/ColumnStatus.msg";
    column_twin_msgs Message CredibleInterval = CredibleInterval in "msg/CredibleInterval.msg";
    column_twin_msgs Message FleetStatus = FleetStatus in "msg/FleetStatus.msg";
    column_twin_msgs Message HingeDescription = HingeDescription in "msg/HingeDescription.msg";
    column_twin_msgs Message HingeForces = HingeForces in "msg/HingeForces.msg";
    column_twin_msgs Message ImpactEstimate = ImpactEstimate in "msg/ImpactEstimate.msg";
    column_twin_msgs Message ImpactEvent = ImpactEvent in "msg/ImpactEvent.msg";
    column_twin_msgs Message ImpactReport = ImpactReport in "msg/ImpactReport.msg";
    column_twin_msgs Message Measurement = Measurement in "msg/Measurement.msg";
    column_twin_msgs Message RowImpactEvent = RowImpactEvent in "msg/RowImpactEvent.msg";
    column_twin_msgs Message SecondOpinion = SecondOpinion in "msg/SecondOpinion.msg";
    column_twin_msgs Message TwinStatus = TwinStatus in "msg/TwinStatus.msg";
    column_twin_msgs Request CorrectDamage = CorrectDamageRequest in "srv/CorrectDamage.srv";
    column_twin_msgs Response CorrectDamage = CorrectDamageResponse in "srv/CorrectDamage.srv";
    column_twin_msgs Request ConfirmEstimate = ConfirmEstimateRequest in "srv/ConfirmEstimate.srv";
    column_twin_msgs Response ConfirmEstimate = ConfirmEstimateResponse in "srv/ConfirmEstimate.srv";
    column_twin_msgs Request PredictImpact = PredictImpactRequest in "srv/PredictImpact.srv";
    column_twin_msgs Response PredictImpact = PredictImpactResponse in "srv/PredictImpact.srv";
    column_twin_msgs Request ResetColumn = ResetColumnRequest in "srv/ResetColumn.srv";
    column_twin_msgs Response ResetColumn = ResetColumnResponse in "srv/ResetColumn.srv";

    builtin_interfaces Message Duration = Duration in "msg/deps/builtin_interfaces/Duration.msg";
    builtin_interfaces Message Time = Time in "msg/deps/builtin_interfaces/Time.msg";
    diagnostic_msgs Message DiagnosticArray = DiagnosticArray in "msg/deps/diagnostic_msgs/DiagnosticArray.msg";
    diagnostic_msgs Message DiagnosticStatus = DiagnosticStatus in "msg/deps/diagnostic_msgs/DiagnosticStatus.msg";
    diagnostic_msgs Message KeyValue = KeyValue in "msg/deps/diagnostic_msgs/KeyValue.msg";
    geometry_msgs Message Accel = Accel in "msg/deps/geometry_msgs/Accel.msg";
    geometry_msgs Message AccelStamped = AccelStamped in "msg/deps/geometry_msgs/AccelStamped.msg";
    geometry_msgs Message Point = Point in "msg/deps/geometry_msgs/Point.msg";
    geometry_msgs Message Pose = Pose in "msg/deps/geometry_msgs/Pose.msg";
    geometry_msgs Message Quaternion = Quaternion in "msg/deps/geometry_msgs/Quaternion.msg";
    geometry_msgs Message Vector3 = Vector3 in "msg/deps/geometry_msgs/Vector3.msg";
    lifecycle_msgs Request ChangeState = ChangeStateRequest in "msg/deps/lifecycle_msgs/ChangeState.srv";
    lifecycle_msgs Response ChangeState = ChangeStateResponse in "msg/deps/lifecycle_msgs/ChangeState.srv";
    lifecycle_msgs Request GetAvailableStates = GetAvailableStatesRequest in "msg/deps/lifecycle_msgs/GetAvailableStates.srv";
    lifecycle_msgs Response GetAvailableStates = GetAvailableStatesResponse in "msg/deps/lifecycle_msgs/GetAvailableStates.srv";
    lifecycle_msgs Request GetAvailableTransitions = GetAvailableTransitionsRequest in "msg/deps/lifecycle_msgs/GetAvailableTransitions.srv";
    lifecycle_msgs Response GetAvailableTransitions = GetAvailableTransitionsResponse in "msg/deps/lifecycle_msgs/GetAvailableTransitions.srv";
    lifecycle_msgs Request GetState = GetStateRequest in "msg/deps/lifecycle_msgs/GetState.srv";
    lifecycle_msgs Response GetState = GetStateResponse in "msg/deps/lifecycle_msgs/GetState.srv";
    lifecycle_msgs Message State = State in "msg/deps/lifecycle_msgs/State.msg";
    lifecycle_msgs Message Transition = Transition in "msg/deps/lifecycle_msgs/Transition.msg";
    lifecycle_msgs Message TransitionDescription = TransitionDescription in "msg/deps/lifecycle_msgs/TransitionDescription.msg";
    lifecycle_msgs Message TransitionEvent = TransitionEvent in "msg/deps/lifecycle_msgs/TransitionEvent.msg";
    rcl_interfaces Message Log = Log in "msg/deps/rcl_interfaces/Log.msg";
    rcl_interfaces Message Parameter = Parameter in "msg/deps/rcl_interfaces/Parameter.msg";
    rcl_interfaces Message ParameterEvent = ParameterEvent in "msg/deps/rcl_interfaces/ParameterEvent.msg";
    rcl_interfaces Message ParameterValue = ParameterValue in "msg/deps/rcl_interfaces/ParameterValue.msg";
    rosgraph_msgs Message Clock = Clock in "msg/deps/rosgraph_msgs/Clock.msg";
    sensor_msgs Message CompressedImage = CompressedImage in "msg/deps/sensor_msgs/CompressedImage.msg";
    sensor_msgs Message Imu = Imu in "msg/deps/sensor_msgs/Imu.msg";
    sensor_msgs Message JointState = JointState in "msg/deps/sensor_msgs/JointState.msg";
    service_msgs Message ServiceEventInfo = ServiceEventInfo in "msg/deps/service_msgs/ServiceEventInfo.msg";
    std_msgs Message ColorRGBA = ColorRGBA in "msg/deps/std_msgs/ColorRGBA.msg";
    std_msgs Message Header = Header in "msg/deps/std_msgs/Header.msg";
    std_msgs Message String = String in "msg/deps/std_msgs/String.msg";
    std_srvs Request Trigger = TriggerRequest in "msg/deps/std_srvs/Trigger.srv";
    std_srvs Response Trigger = TriggerResponse in "msg/deps/std_srvs/Trigger.srv";
    visualization_msgs Message Marker = Marker in "msg/deps/visualization_msgs/Marker.msg";
    visualization_msgs Message MarkerArray = MarkerArray in "msg/deps/visualization_msgs/MarkerArray.msg";
    visualization_msgs Message MeshFile = MeshFile in "msg/deps/visualization_msgs/MeshFile.msg";
    visualization_msgs Message UVCoordinate = UVCoordinate in "msg/deps/visualization_msgs/UVCoordinate.msg";
}

/// The type with this ROS name, for example `column_twin_msgs/msg/ColumnState`.
pub fn find(ros_name: &str) -> Option<&'static Interface> {
    ros_interface::find(ros_name, INTERFACES)
}

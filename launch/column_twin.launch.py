"""One column: ros2 launch column_twin column_twin.launch.py [name:=value ...], see --show-args."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

ARGUMENTS = [
    ("params_file", [FindPackageShare("column_twin"), "config", "heb220_s355.yaml"], "ROS 2 parameter file of the column"),
    ("namespace", "", "namespace of the node, its topics and its services"),
    ("name", "column_twin", "name of the node"),
    ("use_sim_time", "false", "use the time of /clock instead of the system clock"),
    ("log_level", "info", "debug, info, warn, error or fatal"),
]


def stop_on_bad_input(event, context):
    """Ends the launch after exit code 2, bad input such as a wrong parameter: a restart would end in the same way."""
    if event.returncode == 2:
        return [EmitEvent(event=Shutdown(reason="column-twin cannot start with its input; its log gives the reason"))]
    return []


def generate_launch_description():
    declared = []
    for name, default, description in ARGUMENTS:
        if isinstance(default, list):
            default = PathJoinSubstitution(default)
        declared.append(DeclareLaunchArgument(name, default_value=default, description=description))
    node = Node(
        package="column_twin",
        executable="column-twin",
        # Before --ros-args, which launch adds.
        arguments=["run"],
        name=LaunchConfiguration("name"),
        namespace=LaunchConfiguration("namespace"),
        parameters=[
            LaunchConfiguration("params_file"),
            {"use_sim_time": LaunchConfiguration("use_sim_time")},
        ],
        ros_arguments=["--log-level", LaunchConfiguration("log_level")],
        output="screen",
        # The state file preserves the damage, so the node can be restarted at any time.
        respawn=True,
        respawn_delay=2.0,
        on_exit=stop_on_bad_input,
    )
    return LaunchDescription([*declared, node])

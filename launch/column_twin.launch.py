"""One column: ros2 launch column_twin column_twin.launch.py [name:=value ...], see --show-args."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
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
    )
    return LaunchDescription([*declared, node])

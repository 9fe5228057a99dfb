"""Several columns, each in its own namespace: ros2 launch column_twin several_columns.launch.py.

Copy this file and list your columns in COLUMNS: a namespace, a parameter file in the package's config folder or a full path,
and changes to that file. The columns share the state directory, in which each has its own file.
"""

from launch import LaunchDescription
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

COLUMNS = [
    ("/garage/a1", "heb220_s355.yaml", {"column_id": "a1"}),
    ("/garage/a2", "heb220_s355.yaml", {"column_id": "a2", "top.load": 4.0e5}),
    ("/garage/a3", "heb220_s355.yaml", {"column_id": "a3", "section.name": "HEB260"}),
]


def generate_launch_description():
    return LaunchDescription([
        Node(
            package="column_twin",
            executable="column-twin",
            arguments=["run"],
            name="column_twin",
            namespace=namespace,
            parameters=[PathJoinSubstitution([FindPackageShare("column_twin"), "config", file]), changes],
            output="screen",
        )
        for namespace, file, changes in COLUMNS
    ])

#!/usr/bin/env bash
# A ROS 2 workspace with the repository as its package, built by colcon with the ament and rosidl of the environment's wheels.
#
#   tests/interop/build_workspace.sh ENVIRONMENT FOLDER
#
# ENVIRONMENT is what tests/interop/environment.sh prints; the workspace is made in FOLDER. Afterwards everything must stand
# where `ros2 run`, `ros2 launch`, C++ and Python look for it, and the node must start. What only an installed ROS 2 can show,
# that its commands find it, this cannot show.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
environment=$1
workspace=$2
mkdir -p "$workspace"
cd "$workspace"

export AMENT_PREFIX_PATH=$environment PATH=$environment/bin:$PATH PYTHONDONTWRITEBYTECODE=1
LD_LIBRARY_PATH=$environment/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
export LD_LIBRARY_PATH
# The repository where it stands, so that cargo compiles nothing anew.
colcon --log-level error build --base-paths "$repository" --event-handlers console_direct- --cmake-args \
  -DCMAKE_PREFIX_PATH="$environment" -DPython3_EXECUTABLE="$environment/bin/python" -DBUILD_TESTING=OFF -G Ninja

installed=$workspace/install/column_twin
for path in lib/column_twin/column-twin share/column_twin/launch/column_twin.launch.py share/column_twin/config/heb220_s355.yaml \
  share/column_twin/msg/ColumnState.msg share/column_twin/package.xml include/column_twin/column_twin/msg/column_state.hpp; do
  [[ -e $installed/$path ]] || {
    echo "expected $path in $installed, found none" >&2
    exit 1
  }
done
"$installed/lib/column_twin/column-twin" --version

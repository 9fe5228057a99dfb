#!/usr/bin/env bash
# Builds a ROS 2 workspace that contains the repository as a package, with colcon and the ament and rosidl wheels of the environment.
#
#   tests/interop/build_workspace.sh ENVIRONMENT FOLDER
#
# ENVIRONMENT is the path printed by tests/interop/environment.sh; the workspace is created in FOLDER. Afterwards all files must
# be where `ros2 run`, `ros2 launch`, C++ and Python look for them, and the program must start. Only an installed ROS 2 could
# show that its commands find the package.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
environment=$1
workspace=$2
mkdir -p "$workspace"
cd "$workspace"

export AMENT_PREFIX_PATH=$environment PATH=$environment/bin:$PATH PYTHONDONTWRITEBYTECODE=1
LD_LIBRARY_PATH=$environment/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
export LD_LIBRARY_PATH
# The repository is used in place, so that cargo recompiles nothing.
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

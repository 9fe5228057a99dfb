#!/usr/bin/env bash
# Builds a ROS 2 workspace that contains the repository, with colcon and the ament and rosidl wheels of the environment.
#
#   tests/interop/build_workspace.sh ENVIRONMENT FOLDER
#
# ENVIRONMENT is the path printed by tests/interop/environment.sh; the workspace is created in FOLDER. colcon must find exactly the
# two packages of the repository. Afterwards all files must be where `ros2 run`, `ros2 launch`, C++ and Python look for them, and
# the program must start. Only an installed ROS 2 could show that its commands find the packages.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
environment=$1
workspace=$2
mkdir -p "$workspace/src"
cd "$workspace"
# The repository is used in place, so that cargo recompiles nothing.
ln -sfn "$repository" src/column_twin

export AMENT_PREFIX_PATH=$environment PATH=$environment/bin:$PATH PYTHONDONTWRITEBYTECODE=1
LD_LIBRARY_PATH=$environment/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
export LD_LIBRARY_PATH
colcon --log-level error build --event-handlers console_direct- --cmake-args \
  -DCMAKE_PREFIX_PATH="$environment" -DPython3_EXECUTABLE="$environment/bin/python" -DBUILD_TESTING=OFF -G Ninja
found=$(find install -mindepth 1 -maxdepth 1 -type d -printf '%f\n' | sort | tr '\n' ' ')
[[ $found == "column_twin column_twin_msgs " ]] || {
  echo "expected the packages column_twin and column_twin_msgs from $workspace/src, found $found" >&2
  exit 1
}

expect_in() {
  local installed=$1 path
  shift
  for path in "$@"; do
    compgen -G "$installed/$path" >/dev/null || {
      echo "expected $path in $installed, found none" >&2
      exit 1
    }
  done
}
expect_in install/column_twin lib/column_twin/column-twin share/column_twin/package.xml \
  share/column_twin/launch/column_twin.launch.py share/column_twin/config/heb220_s355.yaml
expect_in install/column_twin_msgs share/column_twin_msgs/package.xml share/column_twin_msgs/msg/ColumnState.msg \
  share/column_twin_msgs/srv/PredictImpact.srv include/column_twin_msgs/column_twin_msgs/msg/column_state.hpp \
  'lib/python*/site-packages/column_twin_msgs/msg/_column_state.py'
# The Python package column_twin is the library, which pip installs; no package of ROS may have it, too.
if compgen -G 'install/*/lib/python*/site-packages/column_twin' >/dev/null; then
  echo "expected no Python package column_twin from ROS, found one in $workspace/install" >&2
  exit 1
fi
install/column_twin/lib/column_twin/column-twin --version

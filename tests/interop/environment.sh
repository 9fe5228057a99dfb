#!/usr/bin/env bash
# Builds the Python environment of the interoperability tests, unless it is there already, and prints its path:
#
#   venv=$(tests/interop/environment.sh) && "$venv/bin/python" -c 'from column_twin_msgs.msg import ColumnState'
#
# It holds rclpy (ROS 2 Jazzy, Fast DDS) from PyPI, our messages made by rosidl from msg/ and srv/, and the peers of
# requirements.txt. With the argument `kilted` it is that of ROS 2 Kilted, of requirements-kilted.txt. It stands in the user's
# cache directory under a hash of everything it is made from, so that a change of a message makes a new one. Steps and times go
# to stderr, their output to build.log in the environment.
# Needs: Python 3.11 with venv and headers, a C and a C++ compiler; on Debian: python3.11-venv python3.11-dev gcc g++.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
repository=$(cd "$here/../.." && pwd)
cache=${XDG_CACHE_HOME:-$HOME/.cache}/column_twin
case ${1:-jazzy} in
jazzy) requirements=requirements.txt constraints=constraints.txt ;;
kilted) requirements=requirements-kilted.txt constraints=constraints-kilted.txt ;;
*)
  printf '%s\n' "interop: expected jazzy or kilted, found '$1'" >&2
  exit 2
  ;;
esac
unset PYTHONPATH PYTHONHOME _ROS_WHEELS_BOOTSTRAP_COMPLETE

say() { printf '%s\n' "interop: $*" >&2; }

fail() {
  say "$*"
  exit 1
}

# The first Python 3.11 of those that may be one; a pyenv shim of that name may exist without it.
find_python() {
  local candidate
  for candidate in python3.11 python3 python; do
    if "$candidate" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null; then
      "$candidate" -c 'import sys; print(sys.executable)'
      return
    fi
  done
  fail "expected Python 3.11, for which the wheels of ROS 2 are made, as python3.11 or python3;" \
    "found $(python3 --version 2>/dev/null || echo no python3). On Debian: apt-get install python3.11-venv python3.11-dev"
}

check_tools() {
  local include tool
  include=$("$python" -c 'import sysconfig; print(sysconfig.get_path("include"))')
  [[ -f $include/Python.h ]] || fail "expected Python.h in $include; on Debian: apt-get install python3.11-dev"
  "$python" -c 'import ensurepip, venv' 2>/dev/null ||
    fail "expected the modules venv and ensurepip in $python; on Debian: apt-get install python3.11-venv"
  for tool in cc c++ flock sha256sum; do
    command -v "$tool" >/dev/null || fail "expected $tool in PATH; on Debian: apt-get install gcc g++ util-linux coreutils"
  done
}

# A hash of all that the environment is made from: names and contents of the files, and the Python itself.
content_hash() {
  (
    cd "$repository"
    sha256sum tests/interop/environment.sh "tests/interop/$requirements" "tests/interop/$constraints" \
      ros/column_twin_msgs/* msg/*.msg srv/*.srv
    "$python" -c 'import sys; print(sys.version, sys.base_prefix)'
  ) | sha256sum | cut -c1-16
}

# Runs one step: its name to stderr, its output to the log, the log's end to stderr when it fails.
step() {
  local name=$1 start=$SECONDS
  shift
  printf '\n=== %s\n' "$name" >>"$log"
  if ! "$@" >>"$log" 2>&1; then
    tail -n 30 "$log" >&2
    fail "$name: failed; all of its output stands in $log"
  fi
  say "$name: $((SECONDS - start)) s"
}

install_packages() {
  "$python" -m venv --clear "$venv" &&
    "$venv/bin/python" -m pip install --disable-pip-version-check --no-input --progress-bar off \
      -r "$here/$requirements" -c "$here/$constraints"
}

# The exported CMake files name the Python of the machine that made the wheels.
relocate_cmake_files() {
  local foreign=/opt/python/cp311-cp311 include files
  include=$("$python" -c 'import sysconfig; print(sysconfig.get_path("include"))')
  mapfile -t files < <(grep -rl --include='*.cmake' "$foreign" "$venv/share")
  [[ ${#files[@]} -gt 0 ]] || return 0
  printf '%s\n' "${files[@]}"
  sed -i -e "s|$foreign/include/python3.11|$include|g" -e "s|$foreign/lib/python3.11/site-packages|$site_packages|g" "${files[@]}"
  ! grep -rn --include='*.cmake' "$foreign" "$venv/share"
}

# Our messages and services, made by rosidl, installed beside those of the wheels.
build_messages() {
  local build=$venv/build-column_twin_msgs
  export AMENT_PREFIX_PATH=$venv PATH=$venv/bin:$PATH
  LD_LIBRARY_PATH=$venv/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
  export LD_LIBRARY_PATH
  cmake -S "$repository/ros/column_twin_msgs" -B "$build" -G Ninja -DCMAKE_PREFIX_PATH="$venv" -DCMAKE_INSTALL_PREFIX="$venv" \
    -DPython3_EXECUTABLE="$venv/bin/python" -DPYTHON_INSTALL_DIR=lib/python3.11/site-packages -DBUILD_TESTING=OFF &&
    cmake --build "$build" &&
    cmake --install "$build" &&
    rm -rf "$build"
}

check_messages_import() {
  (cd / && "$venv/bin/python" -c 'from column_twin_msgs.msg import ColumnState; from column_twin_msgs.srv import PredictImpact; import rclpy')
  [[ -f $venv/share/column_twin_msgs/msg/ColumnState.json ]]
}

build() {
  say "building $venv"
  rm -rf "$venv" && mkdir -p "$venv"
  # Outside of the environment while `venv --clear` empties it.
  log=$cache/$name.log
  : >"$log"
  step "packages from PyPI" install_packages
  step "CMake files of the wheels" relocate_cmake_files
  step "our messages by rosidl" build_messages
  step "import of our messages" check_messages_import
  mv "$log" "$venv/build.log"
  touch "$venv/.complete"
}

# Environments of older messages that nobody has used for a month.
remove_unused() {
  find "$cache" -maxdepth 1 -type d -name 'interop-*' ! -path "$venv" -mtime +30 -exec rm -rf {} +
}

python=$(find_python)
check_tools
name=interop-$(content_hash)
venv=$cache/$name
site_packages=$venv/lib/python3.11/site-packages
mkdir -p "$cache"
# One builder at a time; the others wait and find it built.
exec 9>"$cache/interop.lock"
flock 9
if [[ -f $venv/.complete ]]; then
  touch "$venv"
else
  build
  remove_unused
fi
exec 9>&-
printf '%s\n' "$venv"

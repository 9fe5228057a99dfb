#!/usr/bin/env bash
# Builds the wheels of the library and of the program, and does one thing with them in a fresh virtual environment:
#
#   crates/python/tests/wheels.sh build               # both wheels into $CARGO_TARGET_DIR/old_glibc_wheels, for glibc 2.17 and newer
#   crates/python/tests/wheels.sh check               # what they need of glibc and of Python, and what they say of themselves
#   crates/python/tests/wheels.sh sdist FOLDER        # the source distribution of the library, into the folder
#   crates/python/tests/wheels.sh source              # the library from its source distribution, in an empty folder
#   crates/python/tests/wheels.sh install             # pip install of both, as a user does; the demonstration of the program
#   crates/python/tests/wheels.sh test [ARGUMENT...]  # pytest of the installed library
#   crates/python/tests/wheels.sh mixed               # the library beside the ROS 2 messages
#
# COLUMN_TWIN_PROGRAM_FLAGS are further flags of maturin for the program, such as --no-default-features --features cli,ros,record.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
repository=$(cd "$here/../../.." && pwd)
target=${CARGO_TARGET_DIR:-$repository/target}
# Not $target/wheels: maturin puts there what pip builds from the source distribution, and pip installs no two wheels of one package.
wheels=$target/old_glibc_wheels
tools=$("$here/environment.sh")
unset PYTHONPATH PYTHONHOME

# zig is the linker, with the symbols of glibc 2.17; python -m ziglang is where maturin looks for it.
for_old_glibc=(--release --strip --zig --compatibility manylinux_2_17 --target x86_64-unknown-linux-gnu)

build() {
  local flags
  read -ra flags <<<"${COLUMN_TWIN_PROGRAM_FLAGS:-}"
  rm -rf "$wheels"
  (cd "$repository/crates/python" && PATH=$tools/bin:$PATH maturin build "${for_old_glibc[@]}" --out "$wheels")
  (cd "$repository/packaging/program" && PATH=$tools/bin:$PATH maturin build "${for_old_glibc[@]}" --out "$wheels" "${flags[@]}")
  "$repository/packaging/finish_wheel.py" "$wheels"/column_twin-*.whl --package column_twin_python --target x86_64-unknown-linux-gnu
  "$repository/packaging/finish_wheel.py" "$wheels"/column_twin_program-*.whl --package column_twin --target x86_64-unknown-linux-gnu "${flags[@]}"
  ls -l "$wheels"
}

check() {
  local wheel shown
  "$tools/bin/python" "$repository/packaging/check_wheel.py" "$wheels"/*.whl
  "$tools/bin/abi3audit" --strict "$wheels"/column_twin-*.whl
  for wheel in "$wheels"/*.whl; do
    shown=$(PATH=$tools/bin:$PATH auditwheel show "$wheel")
    printf '%s\n' "$shown"
    grep -q 'manylinux_2_17_x86_64' <<<"$shown"
  done
}

source_distribution() {
  (cd "$repository/crates/python" && "$tools/bin/maturin" sdist --out "$1")
}

# With what is in the archive alone. The packages of the registry are those that are compiled already.
from_source() {
  source_distribution "$folder"
  fresh_environment "$folder/venv"
  (cd "$folder" && "$folder/venv/bin/pip" install --quiet --disable-pip-version-check -c "$here/requirements.txt" "$folder"/column_twin-*.tar.gz)
  "$folder/venv/bin/python" -I -c 'from column_twin import Column; print(Column().simulate("mid_car", velocity=10.0))'
}

site_packages() {
  "$1/bin/python" -c 'import site; print(site.getsitepackages()[0])'
}

# A fresh environment in the folder $1; with a second argument on top of the packages of that environment.
fresh_environment() {
  "$tools/bin/python" -m venv "$1"
  if [[ $# -gt 1 ]]; then
    printf 'import site; site.addsitedir("%s")\n' "$(site_packages "$2")" >"$(site_packages "$1")/under.pth"
  fi
}

# `pip install` as a user does it, dependencies from PyPI; then what the README promises.
install() {
  fresh_environment "$folder/venv"
  # The files by their paths, so that nothing of these names can come from an index.
  "$folder/venv/bin/pip" install --quiet --disable-pip-version-check -c "$here/requirements.txt" "$wheels"/*.whl
  "$folder/venv/bin/column-twin" --version
  (cd "$folder" && "$folder/venv/bin/column-twin" demo >demo.txt) || {
    cat "$folder/demo.txt"
    return 1
  }
  tail -n 3 "$folder/demo.txt"
  "$folder/venv/bin/python" -I -c 'from column_twin import Column; print(Column().simulate("mid_car", velocity=10.0))'
}

run_tests() {
  fresh_environment "$folder/venv" "$tools"
  "$folder/venv/bin/pip" install --quiet --disable-pip-version-check --no-deps "$wheels"/*.whl
  (cd "$here" && PATH=$folder/venv/bin:$PATH PYTHONDONTWRITEBYTECODE=1 "$folder/venv/bin/python" -m pytest -p no:cacheprovider -q "$@")
}

# The library `column_twin` beside the messages `column_twin_msgs`: in two folders, in one, and each without the other.
mixed() {
  local environment ros site python=$folder/venv/bin/python pip=$folder/venv/bin/pip
  environment=$("$repository/tests/interop/environment.sh")
  ros=$(site_packages "$environment")
  fresh_environment "$folder/venv" "$environment"
  site=$(site_packages "$folder/venv")
  "$pip" install --quiet --disable-pip-version-check --no-deps "$wheels"/column_twin-*.whl
  "$python" "$here/beside_ros_messages.py" "$site" "$ros"
  # As `colcon build --merge-install` or pip in the environment of ROS put them, with the metadata that ament installs.
  cp -r "$ros"/column_twin_msgs* "$site"
  "$python" "$here/beside_ros_messages.py" "$site" "$site"
  # pip neither takes the messages for the library nor removes them with it.
  "$pip" install --quiet --disable-pip-version-check --no-deps --force-reinstall "$wheels"/column_twin-*.whl
  "$python" "$here/beside_ros_messages.py" "$site" "$site"
  "$pip" uninstall --quiet --disable-pip-version-check --yes column-twin
  (cd / && "$python" -c '
from importlib.util import find_spec
from column_twin_msgs.msg import ColumnState
assert find_spec("column_twin") is None, "ROS has installed a Python package column_twin"
print(ColumnState.__name__, "without the library")')
}

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
command=${1:-}
case $command in
build | check | install | mixed) "$command" ;;
sdist) source_distribution "$(realpath "${2:?expected a folder}")" ;;
source) from_source ;;
test)
  shift
  run_tests "$@"
  ;;
*)
  printf '%s\n' "expected build, check, sdist, source, install, test or mixed; found '$command'" >&2
  exit 2
  ;;
esac

#!/usr/bin/env bash
# Builds the wheels of the library and of the program, and does one thing with those that are built, in a fresh virtual environment:
#
#   crates/python/tests/wheels.sh build [WHEEL...]    # library, program, or both, into $CARGO_TARGET_DIR/old_glibc_wheels, for glibc 2.17 and newer
#   crates/python/tests/wheels.sh check               # what they need of glibc and of Python, and what they say of themselves
#   crates/python/tests/wheels.sh sdist FOLDER [WHAT...]  # the source distributions of library (the default) and program, into the folder
#   crates/python/tests/wheels.sh source [WHAT...]    # library (the default) and program from their source distributions, in empty
#                                                     # folders; the program has the same bits as that of the wheel
#   crates/python/tests/wheels.sh install             # pip install of both, as a user does; the demonstration of the program
#   crates/python/tests/wheels.sh test [ARGUMENT...]  # pytest of the installed library, and of the program that is installed or that
#                                                     # COLUMN_TWIN_PROGRAM names
#   crates/python/tests/wheels.sh pythons [ARGUMENT...]  # the same on every other CPython of this machine from 3.10 on, in PATH or of
#                                                     # pyenv, with the newest packages that PyPI has for it
#   crates/python/tests/wheels.sh mixed               # the library beside the ROS 2 messages
#
# The source distribution of the program has the metadata of its wheel, which is built first.
# COLUMN_TWIN_PROGRAM_FLAGS are further flags of maturin for the program, such as --no-default-features --features cli,ros,record.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
repository=$(cd "$here/../../.." && pwd)
target=${CARGO_TARGET_DIR:-$repository/target}
# Not $target/wheels: maturin puts there what pip builds from the source distribution, and pip installs no two wheels of one package.
wheels=$target/old_glibc_wheels
tools=$("$here/environment.sh")
unset PYTHONPATH PYTHONHOME
# What is released is compiled as a whole.
export CARGO_INCREMENTAL=0

# zig is the linker, with the symbols of glibc 2.17; python -m ziglang is where maturin looks for it.
for_old_glibc=(--release --strip --zig --compatibility manylinux_2_17 --target x86_64-unknown-linux-gnu)

# Of maturin, for the program.
flags=()
read -ra flags <<<"${COLUMN_TWIN_PROGRAM_FLAGS:-}"

build() {
  local what
  [[ $# -gt 0 ]] || set -- library program
  rm -rf "$wheels"
  for what; do
    case $what in
    library) build_wheel "$repository/crates/python" column_twin column_twin_python ;;
    program) build_wheel "$repository/packaging/program" column_twin_program column_twin "${flags[@]}" ;;
    *) unknown "$what" ;;
    esac
  done
  ls -l "$wheels"
}

unknown() {
  printf '%s\n' "expected library or program; found '$1'" >&2
  exit 2
}

# The wheel $2 of the folder $1, whose crate is $3, with further flags.
build_wheel() {
  (cd "$1" && PATH=$tools/bin:$PATH maturin build "${for_old_glibc[@]}" --out "$wheels" "${@:4}")
  "$repository/packaging/finish_wheel.py" "$wheels/$2"-*.whl --package "$3" --target x86_64-unknown-linux-gnu "${@:4}"
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

# The wheel of the program that is built.
program_wheel() {
  local found=("$wheels"/column_twin_program-*.whl)
  if [[ ! -f ${found[0]} ]]; then
    printf '%s\n' "expected the wheel of the program in $wheels; run: crates/python/tests/wheels.sh build" >&2
    return 1
  fi
  printf '%s\n' "${found[0]}"
}

# The source distributions of $2 and what follows it, into the folder $1.
source_distributions() {
  local what wheel
  for what in "${@:2}"; do
    case $what in
    library) (cd "$repository/crates/python" && "$tools/bin/maturin" sdist --out "$1") ;;
    program)
      wheel=$(program_wheel)
      "$repository/packaging/program_sdist.py" "$wheel" "$1"
      ;;
    *) unknown "$what" ;;
    esac
  done
}

from_source() {
  local what
  for what; do
    mkdir "$folder/$what"
    source_distributions "$folder/$what" "$what"
    case $what in
    library)
      install_source library
      "$folder/library/venv/bin/python" -I -c 'from column_twin import Column; print(Column().simulate("mid_car", velocity=10.0))'
      ;;
    program)
      install_source program "${flags[@]}"
      same_bits "$folder/program/venv/bin/column-twin"
      ;;
    esac
  done
}

# The source distribution of $1, built with further flags of maturin from what is in the archive alone. The packages of the registry
# are those that are compiled already; ours are compiled fast, as the archive is what is tested. Its files are as new as the test, or
# Cargo would take what it has compiled of an earlier archive.
install_source() {
  local at=$folder/$1
  mkdir "$at/unpacked"
  tar -xzmf "$at"/column_twin*.tar.gz -C "$at/unpacked"
  fresh_environment "$at/venv"
  (cd "$at/unpacked" && "$at/venv/bin/pip" install --quiet --disable-pip-version-check -c "$here/requirements.txt" \
    --config-settings=build-args="${*:2} --config profile.release.package.column_twin.opt-level=1" ./column_twin*)
}

# One impact by the program of the wheel and by the program $1, with its history: equal to the last bit, but for the times that they
# took.
same_bits() {
  local wheel program number=0
  wheel=$(program_wheel)
  fresh_environment "$folder/of_wheel"
  "$folder/of_wheel/bin/pip" install --quiet --disable-pip-version-check --no-deps "$wheel"
  for program in "$folder/of_wheel/bin/column-twin" "$1"; do
    number=$((number + 1))
    "$program" --version
    "$program" simulate --vehicle mid_car --velocity 10 --json --csv "$folder/history$number.csv" |
      grep -v '"solve_time_s"' >"$folder/impact$number.json"
  done
  diff "$folder/impact1.json" "$folder/impact2.json"
  cmp "$folder/history1.csv" "$folder/history2.csv"
  printf '%s\n' 'the program of the wheel and the one from source have the same bits'
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
  run_pytest "$folder/venv" "$@"
}

# pytest in the environment $1.
run_pytest() {
  (cd "$here" && PATH=$1/bin:$PATH PYTHONDONTWRITEBYTECODE=1 "$1/bin/python" -m pytest -p no:cacheprovider -q "${@:2}")
}

# One environment for each version of Python that is found. Tests whose packages requirements.txt pins for another Python are skipped.
pythons() {
  local python version at tested=' '
  for python in "${PYENV_ROOT:-$HOME/.pyenv}"/versions/*/bin/python3 $(type -aP python3.{10..30}); do
    version=$("$python" -c 'import ensurepip, sys, venv; print(*sys.version_info[:2], sep=".") if sys.version_info >= (3, 10) else sys.exit(1)' 2>/dev/null) || continue
    at=$folder/$version
    if [[ -d $at ]] || "$tools/bin/python" -c "import sys; sys.exit('$version' != '%d.%d' % sys.version_info[:2])"; then
      continue
    fi
    "$python" -m venv "$at"
    "$at/bin/pip" install --quiet --disable-pip-version-check "$wheels"/*.whl pytest matplotlib pandas xarray
    printf '=== %s\n' "$("$at/bin/python" -VV)"
    run_pytest "$at" "$@"
    tested+="$version "
  done
  printf 'tested on CPython:%s\n' "$tested"
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
build)
  shift
  build "$@"
  ;;
check | install | mixed) "$command" ;;
sdist)
  into=$(realpath "${2:?expected a folder}")
  shift 2
  source_distributions "$into" "${@:-library}"
  ;;
source)
  shift
  from_source "${@:-library}"
  ;;
test)
  shift
  run_tests "$@"
  ;;
pythons)
  shift
  pythons "$@"
  ;;
*)
  printf '%s\n' "expected build, check, sdist, source, install, test, pythons or mixed; found '$command'" >&2
  exit 2
  ;;
esac

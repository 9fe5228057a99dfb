#!/usr/bin/env bash
# Installs the Rerun viewer from PyPI, unless it is already installed, and prints the path of its program:
#
#   viewer=$(tests/interop/viewer.sh) && "$viewer" --version
#
# It is in the user's cache directory; its usage statistics are switched off for the HOME `home` beside `.complete`. Pictures
# need a Vulkan driver; without a graphics card the one in Debian's mesa-vulkan-drivers is sufficient.
set -euo pipefail

version=0.36.3
cache=${XDG_CACHE_HOME:-$HOME/.cache}/column_twin
venv=$cache/rerun-$version
unset PYTHONPATH PYTHONHOME

fail() {
  printf 'viewer: %s\n' "$*" >&2
  exit 1
}

mkdir -p "$cache"
# Only one process installs at a time; the others wait for it.
exec 9>"$cache/viewer.lock"
flock 9
if [[ ! -f $venv/.complete ]]; then
  python=$(command -v python3.11 || command -v python3) || fail 'expected Python 3.9 or newer as python3'
  rm -rf "$venv"
  "$python" -m venv "$venv" >&2 || fail 'expected the module venv; on Debian: apt-get install python3-venv'
  "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-input "rerun-sdk==$version" >&2 ||
    fail "cannot install rerun-sdk==$version from PyPI"
  viewer=$("$venv/bin/python" -c 'import pathlib, rerun_cli; print(pathlib.Path(rerun_cli.__file__).parent / "rerun")')
  mkdir -p "$venv/home"
  HOME=$venv/home XDG_CONFIG_HOME=$venv/home "$viewer" analytics disable >&2
  printf '%s\n' "$viewer" >"$venv/.complete"
fi
if [[ -z $(find /usr/share/vulkan/icd.d /etc/vulkan/icd.d -name '*.json' 2>/dev/null | head -n 1) ]]; then
  printf 'viewer: no Vulkan driver is installed; on Debian: apt-get install mesa-vulkan-drivers\n' >&2
fi
cat "$venv/.complete"

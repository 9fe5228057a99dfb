#!/usr/bin/env bash
# Builds the Python environment in which the package and the examples are built and tested, unless it is there already, and
# prints its path:
#
#   venv=$(crates/python/tests/environment.sh) && "$venv/bin/maturin" --version
#
# It holds the packages of requirements.txt from PyPI, and stands in the user's cache directory under a hash of them. The wheels
# under test are not in it: each run installs them into a fresh environment on top (`fresh_environment` in wheels.sh).
# Needs Python 3.11 with venv; on Debian: python3.11-venv.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cache=${XDG_CACHE_HOME:-$HOME/.cache}/column_twin
unset PYTHONPATH PYTHONHOME

find_python() {
  local candidate
  for candidate in python3.11 python3 python; do
    if "$candidate" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null; then
      "$candidate" -c 'import sys; print(sys.executable)'
      return
    fi
  done
  printf '%s\n' 'python: expected Python 3.11 with venv, for which requirements.txt is pinned; on Debian: apt-get install python3.11-venv' >&2
  exit 1
}

python=$(find_python)
hash=$( (sha256sum <"$here/requirements.txt" && "$python" -c 'import sys; print(sys.version, sys.base_prefix)') | sha256sum | cut -c1-16)
venv=$cache/python-$hash
mkdir -p "$cache"
# One builder at a time; the others wait and find it built.
exec 9>"$cache/python.lock"
flock 9
if [[ ! -f $venv/.complete ]]; then
  start=$SECONDS
  "$python" -m venv --clear "$venv"
  "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-input -r "$here/requirements.txt" >&2
  touch "$venv/.complete"
  printf '%s\n' "python: packages from PyPI: $((SECONDS - start)) s" >&2
  find "$cache" -maxdepth 1 -type d -name 'python-*' ! -path "$venv" -mtime +30 -exec rm -rf {} +
else
  touch "$venv"
fi
exec 9>&-
printf '%s\n' "$venv"

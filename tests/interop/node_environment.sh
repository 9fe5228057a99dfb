#!/usr/bin/env bash
# Installs the packages of npm/package.json in the versions of the lock file, unless they are already installed, and prints
# their folder:
#
#   NODE_PATH=$(tests/interop/node_environment.sh) node tests/interop/read_recording.js DIRECTORY EXPECTED
#
# They are in the user's cache directory under a hash of the lock file. Needs node 18 or newer with npm; on Debian:
# apt-get install nodejs npm.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cache=${XDG_CACHE_HOME:-$HOME/.cache}/column_twin

for tool in node npm flock sha256sum; do
  command -v "$tool" >/dev/null || {
    echo "interop: expected $tool in PATH; on Debian: apt-get install nodejs npm util-linux coreutils" >&2
    exit 1
  }
done

folder=$cache/npm-$(sha256sum "$here/npm/package-lock.json" | cut -c1-16)
mkdir -p "$cache"
# Only one process installs at a time; the others wait for it.
exec 9>"$cache/npm.lock"
flock 9
if [[ ! -f $folder/.complete ]]; then
  rm -rf "$folder" && mkdir -p "$folder"
  cp "$here/npm/package.json" "$here/npm/package-lock.json" "$folder/"
  # Scripts of packages are not run.
  npm ci --prefix "$folder" --ignore-scripts --no-audit --no-fund >"$folder/install.log" 2>&1 || {
    tail -n 30 "$folder/install.log" >&2
    echo "interop: npm ci failed; its complete output is in $folder/install.log" >&2
    exit 1
  }
  touch "$folder/.complete"
fi
exec 9>&-
printf '%s\n' "$folder/node_modules"

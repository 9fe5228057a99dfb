#!/usr/bin/env bash
# Builds the bridge between DDS and Zenoh of packaging/bridge, unless it is there already, and prints the path of the program:
#
#   bridge=$(tests/interop/bridge_program.sh) && "$bridge" -c config/zenoh/site.json5
#
# It stands in the user's cache directory under a hash of its sources, its dependencies and the compiler. The first build takes
# four minutes on two idle processors. Needs: Rust, a C compiler, and Python 3 with venv, which gets CMake and libclang from PyPI.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
crate=$(cd "$here/../../packaging/bridge" && pwd)
cache=${XDG_CACHE_HOME:-$HOME/.cache}/column_twin
CMAKE=3.31.10
LIBCLANG=18.1.1

say() { printf '%s\n' "bridge: $*" >&2; }

# CMake builds Cyclone DDS and libclang reads its headers.
install_tools() {
  local python=${PYTHON:-python3}
  "$python" -m venv --clear "$folder/tools" &&
    "$folder/tools/bin/pip" install --disable-pip-version-check --no-input --quiet "cmake==$CMAKE" "libclang==$LIBCLANG"
}

build() {
  local start=$SECONDS
  say "building $folder"
  rm -rf "$folder" && mkdir -p "$folder"
  install_tools
  LIBCLANG_PATH=$(dirname "$(find "$folder/tools" -name libclang.so | head -n 1)")
  # The wheel of libclang has no headers of the compiler itself (stddef.h); those of the C compiler serve.
  BINDGEN_EXTRA_CLANG_ARGS=-I$(cc -print-file-name=include)
  export LIBCLANG_PATH BINDGEN_EXTRA_CLANG_ARGS PATH=$folder/tools/bin:$PATH CARGO_TARGET_DIR=$folder/target
  nice cargo build --release --locked --manifest-path "$crate/Cargo.toml" >&2
  mv "$CARGO_TARGET_DIR/release/column-twin-bridge" "$folder/column-twin-bridge"
  rm -rf "$CARGO_TARGET_DIR" "$folder/tools"
  say "built in $((SECONDS - start)) s"
}

hash=$( (cd "$crate" && sha256sum Cargo.toml Cargo.lock src/*.rs && rustc --version) | sha256sum | cut -c1-16)
folder=$cache/bridge-$hash
mkdir -p "$cache"
# One builder at a time; the others wait and find it built.
exec 9>"$cache/bridge.lock"
flock 9
[[ -x $folder/column-twin-bridge ]] || build
exec 9>&-
printf '%s\n' "$folder/column-twin-bridge"

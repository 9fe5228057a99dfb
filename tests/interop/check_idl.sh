#!/usr/bin/env bash
# Compiles the IDL printed by `column-twin idl` with the compiler of Cyclone DDS, and the generated C code: the type of every topic
# must have the name that is used on the wire.
#
#   tests/interop/check_idl.sh COLUMN_TWIN
#
# Needs idlc and the headers of Cyclone DDS, and a C compiler; on Debian: cyclonedds-tools cyclonedds-dev gcc.
set -euo pipefail

program=$(realpath "$1")
for tool in idlc cc; do
  command -v "$tool" >/dev/null || {
    echo "expected $tool in PATH; on Debian: apt-get install cyclonedds-tools cyclonedds-dev gcc" >&2
    exit 1
  }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$program" idl >column_twin.idl
idlc -l c column_twin.idl
cc -c -Wall column_twin.c
types=$(sed -n 's#^// \(from\|to\) .* \([a-z_]*::msg::dds_::[A-Za-z]*_\):.*#\2#p' column_twin.idl | sort -u)
[[ $(wc -w <<<"$types") -ge 8 ]] || {
  echo "expected the types of at least 8 topics, found: $types" >&2
  exit 1
}
for type in $types; do
  grep -q "m_typename = \"$type\"" column_twin.c || {
    echo "expected a topic type called $type in the output of idlc, found none" >&2
    exit 1
  }
done
echo "idlc and cc accept $(grep -c '^struct' column_twin.idl) types, of which $(wc -w <<<"$types") belong to topics"

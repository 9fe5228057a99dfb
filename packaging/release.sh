#!/usr/bin/env bash
# Makes the files of a release in a folder, and prints what a person has to sign and push. It publishes nothing, signs nothing and
# changes nothing in the repository.
#
#   packaging/release.sh FOLDER             # needs the tools of .ci/run and .ci/long
#   packaging/release.sh --dry-run FOLDER   # checks everything that can be checked without building, and prints the steps
#
# FOLDER must not exist. In it: both wheels, both source distributions, a list of components (CycloneDX) of each wheel,
# the context of the container image, and SHA256SUMS.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
dry_run=
if [[ ${1:-} == --dry-run ]]; then
  dry_run=yes
  shift
fi
if [[ $# -ne 1 || $1 == -* ]]; then
  printf '%s\n' 'expected: packaging/release.sh [--dry-run] FOLDER' >&2
  exit 2
fi

fault() {
  printf '%s\n' "$@" >&2
  exit 1
}

[[ ! -e $1 ]] || fault "expected a folder that does not exist, so that it has the files of one release only; found $1"
folder=$(realpath -m "$1")

# What is built has to be what the tag names.
cd "$repository"
changes=$(git status --porcelain)
[[ -z $changes ]] || fault 'expected a checkout without changes, because the files are those of a commit; commit or remove:' "$changes"
version=$(packaging/versions.py --for-release) || fault "expected one version everywhere:" "$version"
commit=$(git rev-parse HEAD)
tag=v$version
tagged=$(git rev-parse --quiet --verify "refs/tags/$tag^{commit}" || true)
[[ -z $tagged || $tagged == "$commit" ]] || fault "expected that $tag names this commit, $commit, or does not exist; it names $tagged"
printf '%s\n' "version $version, commit $commit"

# Runs a step, or prints it.
step() {
  if [[ -n $dry_run ]]; then
    printf 'would run: %s\n' "$*"
  else
    printf '\n=== %s\n' "$*"
    "$@"
  fi
}

# The features that .ci/long has tested.
COLUMN_TWIN_PROGRAM_FLAGS=$(<packaging/program/build_flags)
export COLUMN_TWIN_PROGRAM_FLAGS
printf '%s\n' "the program is built with $COLUMN_TWIN_PROGRAM_FLAGS"

wheels=${CARGO_TARGET_DIR:-$repository/target}/old_glibc_wheels
tests=crates/python/tests

step "$tests/wheels.sh" build
step "$tests/wheels.sh" check
step "$tests/wheels.sh" source library program
for what in install test mixed; do
  step "$tests/wheels.sh" "$what"
done
step packaging/check_container.py "$wheels"
step mkdir -p "$folder/image"
step "$tests/wheels.sh" sdist "$folder" library program

# The files as they were tested.
collect() {
  cp "$wheels"/*.whl "$folder"
  cp "$wheels"/column_twin_program-*.whl packaging/container/Containerfile "$folder/image"
  python3 - "$folder" <<'PYTHON'
import sys, zipfile
from pathlib import Path
for wheel in sorted(Path(sys.argv[1]).glob("*.whl")):
    with zipfile.ZipFile(wheel) as archive:
        [components] = [it for it in archive.namelist() if "/sboms/" in it]
        wheel.with_name("-".join(wheel.name.split("-")[:2]) + ".cdx.json").write_bytes(archive.read(components))
PYTHON
  local found
  found=$(find "$folder" -maxdepth 1 -name "column_twin*-$version-*.whl" | wc -l)
  [[ $found -eq 2 ]] || fault "expected two wheels of version $version in $wheels, found $found"
  found=$(find "$folder" -maxdepth 1 -name "column_twin*-$version.tar.gz" | wc -l)
  [[ $found -eq 2 ]] || fault "expected two source distributions of version $version in $folder, found $found"
  (cd "$folder" && find . -type f ! -name SHA256SUMS -printf '%P\n' | LC_ALL=C sort | xargs -d '\n' sha256sum >SHA256SUMS && sha256sum --check --quiet SHA256SUMS)
  # A build that changed a file would not be that of the commit.
  changes=$(git status --porcelain)
  [[ -z $changes && $(git rev-parse HEAD) == "$commit" ]] || fault 'the checkout has changed during the build:' "$changes"
  ls -l "$folder"
}
step collect

cat <<END

What remains for a person, in this order. Nothing of it has been done.

1. All checks on this commit:   .ci/run && .ci/long
2. Sign the checksums:          gpg --armor --detach-sign $folder/SHA256SUMS
3. Tag and push:                git tag -s $tag -m 'column-twin $version' $commit && git push origin $tag
4. Python packages:             twine check $folder/*.whl $folder/*.tar.gz && twine upload $folder/*.whl $folder/*.tar.gz
5. Container image, with the digest of the base image that was reviewed:
     podman build --build-arg BASE=docker.io/library/debian@sha256:DIGEST -f $folder/image/Containerfile -t REGISTRY/column-twin:$version $folder/image
     podman push REGISTRY/column-twin:$version, then sign its digest: cosign sign REGISTRY/column-twin@sha256:DIGEST
6. Release notes: the section $version of CHANGELOG.md, with SHA256SUMS, SHA256SUMS.asc and *.cdx.json beside the files.
7. Pages that say how to install the program from source: README.md, docs/python.md, docs/start/.
END

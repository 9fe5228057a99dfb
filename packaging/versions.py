#!/usr/bin/env python3
"""Prints the version of the repository, or what does not have it, with exit code 1.

    packaging/versions.py [--for-release]

The version is that of the workspace in Cargo.toml. The crates, both ROS 2 packages, CITATION.cff, the changelog and the image that
Kubernetes runs have the same; both Python packages take it from Cargo. --for-release also asks for a dated section of the changelog,
and for pages that do not say that the version is not released.
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SEMANTIC = r"\d+\.\d+\.\d+(?:-[0-9A-Za-z.-]+)?"
# Where the version stands, as an expression with one group.
PLACES = {
    "CITATION.cff": r"^version: (\S+)$",
    "CHANGELOG.md": rf"^## \[(?:Unreleased\] - )?({SEMANTIC})",
    "ros/column_twin/package.xml": r"<version>([^<]*)</version>",
    "ros/column_twin_msgs/package.xml": r"<version>([^<]*)</version>",
    "config/kubernetes/statefulset.yaml": r"image: \S*/column-twin:(\S+)$",
}
PYTHON_PACKAGES = ("crates/python/pyproject.toml", "packaging/program/pyproject.toml")
# Pages that state whether the version is released.
STATED = ("README.md",)


def read(path: str) -> str:
    return (ROOT / path).read_text()


def faults_of_cargo(version: str) -> list[str]:
    """What of the workspace has another version: dependencies between its crates, its crates, and the lock file."""
    faults = []
    workspace = tomllib.loads(read("Cargo.toml"))
    for name, wanted in workspace["workspace"]["dependencies"].items():
        if isinstance(wanted, dict) and "path" in wanted and "vendor" not in wanted["path"] and wanted.get("version") != version:
            faults.append(f"Cargo.toml: expected version {version} of {name}, found {wanted.get('version')}")
    own = set()
    for manifest in ["Cargo.toml", *(str(it.relative_to(ROOT)) for it in sorted(ROOT.glob("crates/*/Cargo.toml")))]:
        package = tomllib.loads(read(manifest))["package"]
        own.add(package["name"])
        found = version if package["version"] == {"workspace": True} else package["version"]
        if found != version:
            faults.append(f"{manifest}: expected version {version}, or that of the workspace, found {found}")
    locked = {it["name"]: it["version"] for it in tomllib.loads(read("Cargo.lock"))["package"] if it["name"] in own}
    faults += [f"Cargo.lock: expected {name} {version}, found {locked.get(name)}; run cargo check" for name in sorted(own) if locked.get(name) != version]
    return faults


def faults_of(version: str, for_release: bool) -> list[str]:
    faults = faults_of_cargo(version)
    if not re.fullmatch(SEMANTIC, version):
        faults.append(f"Cargo.toml: expected a version such as 1.2.3, found {version}")
    for path, expression in PLACES.items():
        found = re.search(expression, read(path), re.MULTILINE)
        if found is None or found[1] != version:
            faults.append(f"{path}: expected version {version}, found {found[1] if found else 'none'}")
    for path in PYTHON_PACKAGES:
        project = tomllib.loads(read(path))["project"]
        if "version" not in project.get("dynamic", []):
            faults.append(f"{path}: expected a version that is taken from Cargo (dynamic), found {project.get('version')}")
    if for_release:
        section = rf"^## \[{re.escape(version)}\] - \d{{4}}-\d{{2}}-\d{{2}}$"
        if not re.search(section, read("CHANGELOG.md"), re.MULTILINE):
            faults.append(f"CHANGELOG.md: expected a section '## [{version}] - YYYY-MM-DD'; give it the day of the release")
        for path in STATED:
            if re.search(r"not (been )?released", read(path)):
                faults.append(f"{path}: it says that the version is not released; state the release")
    return faults


def main() -> int:
    arguments = sys.argv[1:]
    if arguments not in ([], ["--for-release"]):
        print(__doc__)
        return 2
    version = tomllib.loads(read("Cargo.toml"))["workspace"]["package"]["version"]
    faults = faults_of(version, bool(arguments))
    print("\n".join(faults) or version)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

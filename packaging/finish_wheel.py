#!/usr/bin/env python3
"""Completes a wheel that maturin has built, in place: its list of components, and the licences of the vendored crates.

    packaging/finish_wheel.py WHEEL cargo-tree arguments, such as --package column_twin --no-default-features

maturin writes a list of components (SBOM, CycloneDX) of everything that any feature on any platform might need, with the folders
of the machine that built it. Here it is what `cargo tree` with these arguments says is compiled, and each local crate is named
without its folder.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
LOCAL = re.compile(r"(path\+)?file://[^\"]*?#((?P<name>[A-Za-z0-9_-]+)@)?(?P<version>[0-9][^\" ]*)")


def compiled(arguments: list[str]) -> set[tuple[str, str]]:
    """Names and versions of the crates that are compiled, of the root first."""
    command = ["cargo", "tree", "--locked", "--edges", "normal,build", "--prefix", "none", "--format", "{p}", *arguments]
    lines = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    return {(name, version.removeprefix("v")) for name, version, *_ in (line.split() for line in lines if line)}


def name_of(component: dict[str, Any]) -> tuple[str, str]:
    return component["name"], component["version"]


def of_what_is_compiled(sbom: dict[str, Any], wanted: set[tuple[str, str]]) -> dict[str, Any]:
    """The list without components that are not compiled, and without folders."""
    components = [it for it in sbom.get("components", []) if name_of(it) in wanted]
    root = sbom["metadata"]["component"]
    # Targets of the root, whose names repeat its own.
    for component in [root, *components]:
        component.pop("components", None)
    references = {it["bom-ref"] for it in [root, *components]}
    sbom["components"] = components
    sbom["dependencies"] = [
        {**it, "dependsOn": [on for on in it.get("dependsOn", []) if on in references]}
        for it in sbom.get("dependencies", [])
        if it["ref"] in references
    ]
    text = json.dumps(sbom)
    for component in [root, *components]:
        reference = component["bom-ref"]
        if "file://" in reference:
            text = text.replace(json.dumps(reference), json.dumps(f"{component['name']}@{component['version']}"))
    text = re.sub(r"\?download_url=file:[^\"#]*(#[^\"]*)?", "", text)
    found: dict[str, Any] = json.loads(text)
    return found


def licences() -> dict[str, bytes]:
    """The licences of the vendored crates, by their path beside the licence of the project."""
    return {f"vendor/{path.parent.name}/{path.name}": path.read_bytes() for path in sorted(ROOT.glob("vendor/*/LICENSE*"))}


def record_line(name: str, content: bytes) -> str:
    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(content)}"


def finish(wheel: Path, arguments: list[str]) -> None:
    wanted = compiled(arguments)
    with zipfile.ZipFile(wheel) as archive:
        entries = [(info, archive.read(info)) for info in archive.infolist()]
    record = next(info.filename for info, _ in entries if info.filename.endswith(".dist-info/RECORD"))
    folder = record.rpartition("/")[0]
    kept: list[tuple[zipfile.ZipInfo, bytes]] = []
    for info, content in entries:
        if "/sboms/" in info.filename and info.filename.endswith(".json"):
            sbom = of_what_is_compiled(json.loads(content), wanted)
            content = json.dumps(sbom, indent=2).encode()
            print(f"{info.filename}: {len(sbom['components'])} components")
        if info.filename != record and not info.filename.startswith(f"{folder}/licenses/vendor/"):
            kept.append((info, content))
    names = {name for name, _ in wanted}
    for name, content in licences().items():
        if name.split("/")[1] in names:
            info = zipfile.ZipInfo(f"{folder}/licenses/{name}", date_time=entries[0][0].date_time)
            info.external_attr, info.compress_type = 0o644 << 16, zipfile.ZIP_DEFLATED
            kept.append((info, content))
    lines = [record_line(info.filename, content) for info, content in kept]
    last = zipfile.ZipInfo(record, date_time=entries[0][0].date_time)
    last.external_attr, last.compress_type = 0o644 << 16, zipfile.ZIP_DEFLATED
    kept.append((last, ("\n".join([*lines, f"{record},,"]) + "\n").encode()))
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for info, content in kept:
            archive.writestr(info, content)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    finish(Path(sys.argv[1]), sys.argv[2:])

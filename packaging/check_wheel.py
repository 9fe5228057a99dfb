#!/usr/bin/env python3
"""Checks that a wheel runs where its name promises, and that it tells what it consists of. Needs pyelftools.

    packaging/check_wheel.py WHEEL...

Every binary may ask for symbols of glibc up to 2.17 only, is stripped, and names no library beside those of glibc and the
compiler's. The list of components names no folder, and each of them once. All files are in RECORD.
"""

from __future__ import annotations

import io
import json
import sys
import zipfile
from pathlib import Path

from elftools.elf.elffile import ELFFile
from elftools.elf.gnuversions import GNUVerNeedSection

NEWEST_GLIBC = (2, 17)
LIBRARIES = {"libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0", "librt.so.1", "libutil.so.1", "libgcc_s.so.1", "ld-linux-x86-64.so.2"}

# What a folder of the machine that has built the wheel begins with: an address, any text that is an absolute path, homes, the checkout.
FOLDERS = ("file:", '"/', "/root/", "/home/", f"{Path(__file__).resolve().parents[1]}/")


def faults_of_binary(content: bytes) -> list[str]:
    elf = ELFFile(io.BytesIO(content))
    faults = ["is not stripped"] if elf.get_section_by_name(".symtab") or elf.get_section_by_name(".debug_info") else []
    for section in elf.iter_sections():
        if isinstance(section, GNUVerNeedSection):
            for library, versions in section.iter_versions():
                for version in versions:
                    kind, _, number = version.name.partition("_")
                    if kind == "GLIBC" and number != "PRIVATE" and tuple(map(int, number.split("."))) > NEWEST_GLIBC:
                        faults.append(f"needs {version.name} of {library.name}; expected at most GLIBC_2.17")
    dynamic = elf.get_section_by_name(".dynamic")
    needed = {tag.needed for tag in dynamic.iter_tags() if tag.entry.d_tag == "DT_NEEDED"} if dynamic else set()
    return faults + [f"needs the library {name}" for name in sorted(needed - LIBRARIES)]


def faults_of_components(content: bytes) -> list[str]:
    sbom = json.loads(content)
    faults = [f"contains a folder: {word}" for word in FOLDERS if word.encode() in content]
    names = [(it["name"], it["version"]) for it in sbom["components"]]
    if len(names) != len(set(names)):
        faults.append("names a component twice")
    if not names:
        faults.append("names no components")
    return faults


def faults_of(wheel: Path) -> list[str]:
    faults: list[str] = []
    if "manylinux_2_17_x86_64" not in wheel.name:
        faults.append("its name does not promise manylinux_2_17_x86_64")
    binaries = lists = 0
    with zipfile.ZipFile(wheel) as archive:
        record = next(it for it in archive.namelist() if it.endswith(".dist-info/RECORD"))
        recorded = {line.split(",")[0] for line in archive.read(record).decode().splitlines()}
        faults += [f"{name} is not in RECORD" for name in archive.namelist() if name not in recorded]
        for name in archive.namelist():
            content = archive.read(name)
            if content[:4] == b"\x7fELF":
                binaries += 1
                faults += [f"{name} {fault}" for fault in faults_of_binary(content)]
            elif "/sboms/" in name:
                lists += 1
                faults += [f"{name} {fault}" for fault in faults_of_components(content)]
    if not binaries or not lists:
        faults.append(f"contains {binaries} binaries and {lists} lists of components; expected at least one of each")
    return faults


def main() -> None:
    faults = [f"{path}: {fault}" for path in sys.argv[1:] for fault in faults_of(Path(path))]
    if len(sys.argv) < 2 or faults:
        sys.exit("\n".join(faults) or __doc__)
    print(f"{len(sys.argv) - 1} wheels run with glibc 2.17 and list their components")


if __name__ == "__main__":
    main()

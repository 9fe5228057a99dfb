#!/usr/bin/env python3
"""Makes the source distribution of the program: the files of this checkout, with the project file of packaging/program at their head.

    packaging/program_sdist.py WHEEL FOLDER

maturin would leave out the crate of the library, without which Cargo.lock does not fit the workspace, and a locked build ends. WHEEL
is the wheel of the program, whose metadata are those of the archive. The same checkout gives the same bytes.
"""

from __future__ import annotations

import gzip
import io
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PROJECT = "packaging/program"
# Paths of the project file that its place at the head of the archive changes.
MOVED = {'manifest-path = "../../Cargo.toml"': 'manifest-path = "Cargo.toml"', 'readme = "README.md"': f'readme = "{PROJECT}/README.md"'}


def files_of_checkout() -> list[str]:
    """What a commit of this checkout would have; of an export without history, everything but what Cargo has built."""
    if not (ROOT / ".git").exists():
        names = (it.relative_to(ROOT) for it in ROOT.rglob("*") if it.is_file())
        return [str(it) for it in names if it.parts[0] != "target"]
    # The checkout may belong to another user.
    line = ["git", "-c", "safe.directory=*", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    listed = subprocess.run(line, cwd=ROOT, check=True, capture_output=True).stdout
    # Without what is deleted in the checkout, and not yet in a commit.
    return [it for it in listed.decode().split("\0") if it and (ROOT / it).is_file()]


def project_file() -> str:
    text = (ROOT / PROJECT / "pyproject.toml").read_text()
    for line, moved in MOVED.items():
        if text.count(line) != 1:
            sys.exit(f"{PROJECT}/pyproject.toml: expected one line '{line}', found {text.count(line)}")
        text = text.replace(line, moved)
    return text


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    wheel, folder = map(Path, sys.argv[1:])
    with zipfile.ZipFile(wheel) as archive:
        metadata = archive.read(next(it for it in archive.namelist() if it.endswith(".dist-info/METADATA")))
    found = re.search(rb"^Version: (\S+)$", metadata, re.MULTILINE)
    if found is None:
        sys.exit(f"{wheel}: expected a version in its metadata, found none")
    head = f"column_twin_program-{found[1].decode()}"
    contents = {name: (ROOT / name).read_bytes() for name in files_of_checkout()}
    contents |= {"pyproject.toml": project_file().encode(), "PKG-INFO": metadata}
    path = folder / f"{head}.tar.gz"
    with path.open("wb") as file, gzip.GzipFile("", "wb", fileobj=file, mtime=0) as packed, tarfile.open(fileobj=packed, mode="w") as tar:
        for name, content in sorted(contents.items()):
            member = tarfile.TarInfo(f"{head}/{name}")
            member.size = len(content)
            source = ROOT / name
            member.mode = 0o755 if source.is_file() and source.stat().st_mode & 0o100 else 0o644
            tar.addfile(member, io.BytesIO(content))
    print(path)


if __name__ == "__main__":
    main()

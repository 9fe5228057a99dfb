#!/usr/bin/env python3
"""Tests packaging/release.sh --dry-run in a copy of the repository: what it accepts, and what it rejects with which reason.

    packaging/check_release.py

The copy has the files of this checkout, as they are, in one commit. Nothing is built and nothing leaves the machine: programs that
could publish, sign or push are replaced by ones that fail.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from program_sdist import files_of_checkout

ROOT = Path(__file__).resolve().parents[1]
DANGEROUS = ("cargo", "cosign", "curl", "docker", "gpg", "maturin", "podman", "ssh", "twine", "wget")
IDENTITY = ["-c", "user.name=release", "-c", "user.email=release@example.org", "-c", "commit.gpgsign=false"]


class Copy:
    """A copy of the repository, ready for a release."""

    def __init__(self, folder: Path) -> None:
        self.root, self.tools, self.calls = folder / "repository", folder / "tools", folder / "calls"
        for name in files_of_checkout():
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            (self.root / name).write_bytes((ROOT / name).read_bytes())
            (self.root / name).chmod((ROOT / name).stat().st_mode)
        self.version = re.search(r'^version = "(.*)"', self.read("Cargo.toml"), re.MULTILINE)[1]  # type: ignore[index]
        self.git("init", "--quiet")
        # The commit of a release has its date, and states the release, already.
        for name, expression, by in (("CHANGELOG.md", rf"^## \[Unreleased\] - {re.escape(self.version)}$", f"## [{self.version}] - 2026-01-31"),
                                     ("README.md", "is not released", "is a release")):
            (self.root / name).write_text(re.sub(expression, by, self.read(name), flags=re.MULTILINE))
        self.commit()
        self.tools.mkdir()
        for name in DANGEROUS:
            (self.tools / name).write_text(f'#!/bin/sh\necho "{name} $*" >>"{self.calls}"\nexit 1\n')
            (self.tools / name).chmod(0o755)

    def read(self, name: str) -> str:
        return (self.root / name).read_text()

    def replace(self, name: str, expression: str, by: str) -> None:
        text, count = re.subn(expression, by, self.read(name), count=1, flags=re.MULTILINE)
        assert count == 1, f"{name} has no {expression}"
        (self.root / name).write_text(text)

    def git(self, *arguments: str) -> None:
        subprocess.run(["git", *IDENTITY, *arguments], cwd=self.root, check=True, capture_output=True)

    def commit(self) -> None:
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message", "State of the test")

    def release(self, *arguments: str) -> tuple[int, str]:
        # A target folder of its own: the build removes the wheels of before.
        environment = {**os.environ, "PATH": f"{self.tools}:{os.environ['PATH']}", "CARGO_TARGET_DIR": str(self.root.parent / "target")}
        done = subprocess.run([self.root / "packaging/release.sh", *arguments], cwd=self.root, env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        return done.returncode, done.stdout


def rejected(what: str, change: Callable[[Copy], None], reason: str, committed: bool = True) -> None:
    """A copy with this change is rejected for this reason."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path(folder))
        change(copy)
        if committed:
            copy.commit()
        code, text = copy.release("--dry-run", f"{folder}/release")
        assert code == 1 and reason in text, f"{what}: expected exit code 1 and '{reason}', found {code} and:\n{text}"
        assert "would run" not in text and "twine" not in text, f"{what}: a rejected release must print no steps:\n{text}"
    print("rejected:", what)


def version(name: str, expression: str) -> Callable[[Copy], None]:
    return lambda copy: copy.replace(name, expression, "9.9.9")


# In the place of the scripts that build: files of the right names.
STUB = """#!/usr/bin/env python3
import os, sys, zipfile
from pathlib import Path
wheels = Path(os.environ["CARGO_TARGET_DIR"], "old_glibc_wheels")
if sys.argv[1] == "build":
    wheels.mkdir(parents=True)
    for name, tags in (("column_twin", "cp310-abi3"), ("column_twin_program", "py3-none")):
        with zipfile.ZipFile(wheels / f"{name}-VERSION-{tags}-manylinux_2_17_x86_64.whl", "w") as archive:
            archive.writestr(f"{name}-VERSION.dist-info/sboms/{name}.cyclonedx.json", "{}")
elif sys.argv[1] == "sdist":
    for what in sys.argv[3:]:
        name = {"library": "column_twin", "program": "column_twin_program"}[what]
        Path(sys.argv[2], f"{name}-VERSION.tar.gz").write_text("source")
"""


def check_files(folder: Path, version: str) -> None:
    """What a release consists of, with scripts that build nothing."""
    copy = Copy(folder)
    for name in ("crates/python/tests/wheels.sh", "packaging/check_container.py"):
        (copy.root / name).write_text(STUB.replace("VERSION", version))
    copy.commit()
    code, text = copy.release(f"{folder}/release")
    assert code == 0, text
    names = {str(it.relative_to(folder / "release")) for it in (folder / "release").rglob("*") if it.is_file()}
    program = f"column_twin_program-{version}-py3-none-manylinux_2_17_x86_64.whl"
    expected = {f"column_twin-{version}-cp310-abi3-manylinux_2_17_x86_64.whl", program, f"column_twin-{version}.tar.gz", f"column_twin_program-{version}.tar.gz", "SHA256SUMS",
                f"column_twin-{version}.cdx.json", f"column_twin_program-{version}.cdx.json", f"image/{program}", "image/Containerfile"}
    assert names == expected, f"expected {sorted(expected)}, found {sorted(names)}"
    sums = (folder / "release/SHA256SUMS").read_text().splitlines()
    assert {it.split("  ")[1] for it in sums} == expected - {"SHA256SUMS"}, sums
    subprocess.run(["sha256sum", "--check", "--strict", "--quiet", "SHA256SUMS"], cwd=folder / "release", check=True)
    assert not copy.calls.exists(), copy.calls.read_text()


def tagged_before(copy: Copy) -> None:
    copy.git("tag", f"v{copy.version}")
    copy.replace("LICENSE", "Apache", "apache")


def without_date(copy: Copy) -> None:
    copy.replace("CHANGELOG.md", rf"(?<=^## \[{re.escape(copy.version)}\] - )\d{{4}}-\d\d-\d\d", "soon")


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path(folder))
        code, text = copy.release("--dry-run", f"{folder}/release")
        assert code == 0, text
        flags = copy.read("packaging/program/build_flags").strip()
        for expected in (f"version {copy.version}", f"the program is built with {flags}", "wheels.sh build", "wheels.sh source library program", "check_container.py", "collect", f"git tag -s v{copy.version}", "twine upload", "podman push"):
            assert expected in text, f"expected {expected} in:\n{text}"
        status = subprocess.run(["git", "status", "--porcelain"], cwd=copy.root, check=True, capture_output=True).stdout
        assert not copy.calls.exists() and not Path(folder, "release").exists() and not status, "a dry run must do nothing"
        # A real run begins with the build, and ends where that fails: nothing after it is done or promised.
        code, text = copy.release(f"{folder}/release")
        assert code != 0 and "twine" not in text, text
        made = copy.calls.read_text() if copy.calls.exists() else ""
        assert not re.search(r"^(cosign|docker|gpg|podman|ssh|twine) ", made, re.MULTILINE), made
        assert copy.release()[0] == 2 and copy.release("--publish", "x")[0] == 2
        os.mkdir(f"{folder}/release.old")
        assert copy.release("--dry-run", f"{folder}/release.old")[0] == 1
    print("accepted: a clean checkout with one version")
    with tempfile.TemporaryDirectory() as folder:
        check_files(Path(folder), copy.version)
    print("made: wheels, source distributions, lists of components, context of the image, checksums")
    number = r"\d+\.\d+\.\d+"
    rejected("a changed file", lambda copy: copy.replace("LICENSE", "Apache", "apache"), "expected a checkout without changes", committed=False)
    rejected("a file that no commit has", lambda copy: (copy.root / "note").touch() and None, "?? note", committed=False)
    rejected("another version of the citation", version("CITATION.cff", rf"(?<=^version: ){number}"), "CITATION.cff: expected version")
    for package in ("column_twin", "column_twin_msgs"):
        name = f"ros/{package}/package.xml"
        rejected(f"another version in {name}", version(name, rf"(?<=<version>){number}"), f"{name}: expected version")
    rejected("another version of the image", version("config/kubernetes/statefulset.yaml", rf"(?<=/column-twin:){number}"), "statefulset.yaml: expected")
    rejected("another version of a crate", version("Cargo.toml", rf'(?<=column_beam = {{ version = "){number}'), "of column_beam, found 9.9.9")
    rejected("a lock file of before", version("Cargo.lock", rf'(?<=name = "column_beam"\nversion = "){number}'), "Cargo.lock: expected column_beam")
    rejected("a changelog without the version", version("CHANGELOG.md", rf"(?<=^## \[){number}"), "CHANGELOG.md: expected a section")
    rejected("a changelog without a date", without_date, "CHANGELOG.md: expected a section")
    rejected("a README of before", lambda copy: copy.replace("README.md", r"\Z", "It is not released.\n"), "README.md: it says")
    rejected("a tag at another commit", tagged_before, "does not exist; it names")
    print("packaging/release.sh --dry-run accepts and rejects what it should")


if __name__ == "__main__":
    try:
        main()
    except AssertionError as fault:
        sys.exit(f"check_release.py: {fault}")
    except subprocess.CalledProcessError as fault:
        # Some of them print to the terminal.
        text = (fault.stderr or b"").decode(errors="replace")
        sys.exit(f"check_release.py: {shlex.join(map(str, fault.cmd))} ended with {fault.returncode}:\n{text}")

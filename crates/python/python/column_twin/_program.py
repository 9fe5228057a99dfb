"""What the program `column-twin` does: reports for people, recordings. The distribution column-twin-program installs it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sysconfig
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._errors import ProgramError
from ._loading import native

if TYPE_CHECKING:
    from ._column import Column


def _path() -> str:
    """The program: that of COLUMN_TWIN_PROGRAM, of this environment, or of PATH."""
    places = (os.environ.get("COLUMN_TWIN_PROGRAM"), shutil.which("column-twin", path=sysconfig.get_path("scripts")))
    path = next((it for it in places if it), None) or shutil.which("column-twin")
    if path is None:
        raise ProgramError("the program column-twin is not installed; in the repository: pip install ./packaging/program")
    return path


def run_program(*arguments: str | os.PathLike[str]) -> str:
    """Runs the program `column-twin` of the same version with these arguments, and returns what it prints.

    >>> run_program("map", "--params-file", "garage.yaml", "velocity=1:20:40", "mass=1000:3000:20", "--output", "maps")

    Raises:
        ProgramError: the program is missing, of another version, or has failed; the text is what it reports.
    """
    path = _path()
    version = _run(path, ["--version"]).split()[-1]
    if version != native.VERSION:
        raise ProgramError(f"expected the program column-twin {native.VERSION}, found {version} at {path}; install both in one version")
    return _run(path, [os.fspath(it) for it in arguments])


def _run(path: str, arguments: Sequence[str]) -> str:
    with subprocess.Popen([path, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8") as program:
        # In another thread: after Ctrl-C, `communicate` itself would wait a quarter of a second for the program before it raises.
        with ThreadPoolExecutor(1) as reader:
            printed = reader.submit(program.communicate)
            try:
                output, errors = printed.result()
            except BaseException:
                program.kill()
                raise
    if program.returncode != 0:
        command = " ".join(arguments[:1])
        raise ProgramError(f"column-twin {command} ended with exit code {program.returncode}: {errors.strip()}")
    return output


def report(
    column: Column,
    path: str | os.PathLike[str],
    vehicle: str | None,
    mass: float | None,
    velocity: float | None,
    details: str | os.PathLike[str] | None,
) -> None:
    """The report of one impact, see `Column.report`."""
    with tempfile.TemporaryDirectory() as folder:
        config = Path(folder, "column.yaml")
        column.to_file(config)
        arguments: list[str] = ["simulate", "--config", str(config), "--report", os.path.abspath(path)]
        for option, value in (("--vehicle", vehicle), ("--mass", mass), ("--velocity", velocity), ("--report-details", details)):
            if value is not None:
                arguments.append(f"{option}={os.fspath(value) if isinstance(value, os.PathLike) else value}")
        run_program(*arguments)


def read_recording(recording: str | os.PathLike[str], *topics: str) -> Iterator[dict[str, Any]]:
    """The messages of a recording in the order of their times: each with `topic`, `type`, `log_time` and `publish_time` [ns since
    1970], and `message` with the fields of its type in SI units.

    Every rosbag2 MCAP file can be read, because a recording contains the definitions of its messages. The program `column-twin` reads
    it: `pip install ./packaging/program` in the repository.

    >>> [it["message"]["action"] for it in read_recording("recordings/one", "/impact_report")]

    Args:
        recording: directory of the recording, or an MCAP file.
        topics: those that are read; default: all.

    Raises:
        ProgramError: a recording that cannot be read, or a topic that it does not have.
    """
    selected = ["--topics", *topics] if topics else []
    for line in run_program("export", recording, "--json", "--output", "-", *selected).splitlines():
        found: dict[str, Any] = json.loads(line)
        yield found


def recording_info(recording: str | os.PathLike[str]) -> dict[str, Any]:
    """The summary of a recording: its times, topics and impacts, as `column-twin info --json`.

    Raises:
        ProgramError: a recording that cannot be read, or is damaged.
    """
    found: dict[str, Any] = json.loads(run_program("info", recording, "--json"))
    return found

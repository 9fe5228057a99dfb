"""Calls of the program `column-twin`, which writes reports and reads recordings. The distribution column-twin-program installs it."""

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
    """Runs the program `column-twin` of the same version, and returns its standard output.

    The program is the file that the environment variable COLUMN_TWIN_PROGRAM names, the one in the environment of this Python, or the
    first one in PATH. Ctrl-C ends it.

    >>> run_program("map", "--config", "config/heb220_s355.yaml", "--mass", "1000:3000:20", "--velocity", "1:20:40", "--csv", "map.csv")

    Args:
        arguments: the subcommand and its options, as docs/commands.md lists them; each is a text or a path.

    Raises:
        ProgramError: the program is missing, is of another version, or has failed; the text contains its error message.
    """
    path = _path()
    version = (_run(path, ["--version"]).split() or ["nothing"])[-1]
    if version != native.VERSION:
        raise ProgramError(f"expected the program column-twin {native.VERSION}, found {version} at {path}; install both in one version")
    return _run(path, [os.fspath(it) for it in arguments])


def _run(path: str, arguments: Sequence[str]) -> str:
    try:
        started = subprocess.Popen([path, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8")
    except OSError as reason:
        raise ProgramError(f"the program {path} cannot be started: {reason.strerror}") from reason
    with started as program:
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
    """The messages of a recording, in the order of their times.

    Every rosbag2 MCAP file can be read, because a recording contains the definitions of its messages. The program `column-twin` reads
    all of it before the first message is returned; to install it: `pip install ./packaging/program` in the repository.

    >>> [it["message"]["action"] for it in read_recording("recordings/one", "/impact_report")]

    Args:
        recording: directory of the recording, or an MCAP file.
        topics: topics that are read; default: all.

    Returns:
        Dictionaries with `topic`, `type`, `log_time` and `publish_time` [ns since 1970], and `message` with the fields of its type, which
        docs/messages.md lists, in SI units.

    Raises:
        ProgramError: the program is missing or of another version, the recording cannot be read, or it does not have a topic.
    """
    selected = ["--topics", *topics] if topics else []
    # The texts of messages may contain characters that `splitlines` takes for the ends of lines.
    lines = run_program("export", recording, "--json", "--output", "-", *selected).split("\n")
    return (json.loads(line) for line in lines if line)


def recording_info(recording: str | os.PathLike[str]) -> dict[str, Any]:
    """The summary of a recording: its times, topics, impacts and losses.

    Args:
        recording: directory of the recording, or an MCAP file.

    Returns:
        The fields of `column-twin info --json`.

    Raises:
        ProgramError: the program is missing or of another version, or the recording cannot be read or is damaged.
    """
    found: dict[str, Any] = json.loads(run_program("info", recording, "--json"))
    return found

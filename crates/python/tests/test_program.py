"""What the program does for Python: reports and recordings; sensors and fleets, compared with the command line."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from column_twin import Column, ParameterError, ProgramError, Readings, __version__, read_recording, recording_info, run_program

Program = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(scope="module")
def sensed(root: Path) -> Column:
    """A column with sensors."""
    return Column.from_file(root / "config/heb220_s355.yaml", root / "config/sensors_industrial.yaml")


def test_readings_and_estimate_are_those_of_the_command_line(
    root: Path, sensed: Column, program: Program, tmp_path: Path
) -> None:
    files = [part for name in ("heb220_s355", "sensors_industrial") for part in ("--config", str(root / f"config/{name}.yaml"))]
    table = tmp_path / "readings.csv"
    impact = ("--vehicle", "mid_car", "--velocity", "12")
    assert program("simulate", *files, *impact, "--readings", str(table)).returncode == 0
    readings = sensed.sensor_readings("mid_car", velocity=12.0)
    assert readings.csv == table.read_text()
    readings.to_file(tmp_path / "ours.csv")
    assert Readings.from_file(tmp_path / "ours.csv").csv == readings.csv
    columns = readings.to_numpy()
    assert columns["time"][0] < 0.0 and set(columns) == {"time", *(str(it) for it in np.ravel(sensed["sensors.names"]))}
    ran = program("estimate", *files, "--readings", str(table), "--json")
    assert ran.returncode == 0, ran.stderr
    estimate = sensed.estimate(readings)
    assert estimate is not None
    mean, low, high = estimate.velocity
    assert low < mean < high and low < 12.0 < high
    assert f"{mean!r}" in ran.stdout or json.dumps(mean) in ran.stdout
    assert sensed.estimate(table) is not None
    with pytest.raises(ParameterError, match="has no sensors"):
        Column().sensor_readings("mid_car", velocity=5.0)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("", "expected a header with the column time, found an empty text"),
        ("a,b\n1,2\n", "expected a header with the column time, found a, b"),
        ("time,laser\n0.0,1e-3\n0.1\n", "row 2 has 1 cells; expected 2, as in the header"),
        ("time,laser\n0.0,one\n", "row 1, laser: expected a number, found 'one'"),
    ],
)
def test_readings_that_are_no_table_are_explained(table: str, message: str) -> None:
    """A notebook that showed them failed with an error of Python about unpacking."""
    readings = Readings(table)
    with pytest.raises(ParameterError, match=message):
        readings.to_numpy()
    assert message in repr(readings)
    columns = Readings("time,laser\n0.0,\n0.1,1e-3\n\n").to_numpy()
    assert columns["time"].tolist() == [0.0, 0.1] and np.isnan(columns["laser"][0]) and columns["laser"][1] == 1e-3


def test_a_fleet_is_its_columns(root: Path, tmp_path: Path) -> None:
    table = tmp_path / "columns.csv"
    table.write_text("namespace,column_id,section.name,top.load\n/garage/a1,a1,HEB 220,4e5\n/garage/a2,a2,HEB 300,6e5\n")
    fleet = Column.fleet(table=table)
    assert [column["column_id"] for column in fleet.values()] == ["a1", "a2"]
    first, second = fleet.values()
    assert second["section.name"] == "HEB300" and second["top.load"] == 6e5
    assert second.evaluate("van", velocity=8.0).max_v1 < first.evaluate("van", velocity=8.0).max_v1
    shipped = Column.fleet(root / "config/fleet.yaml", table=root / "config/fleet.csv")
    assert len(shipped) > 2
    with pytest.raises(ParameterError, match="No such file"):
        Column.fleet(tmp_path / "missing.yaml")


def test_a_report_and_a_recording(steel: Column, program: Program, tmp_path: Path) -> None:
    steel.report(tmp_path / "impact.html", "mid_car", velocity=10.0)
    assert "mid_car" in (tmp_path / "impact.html").read_text()
    steel.to_file(tmp_path / "column.yaml")
    run_program("simulate", "--config", tmp_path / "column.yaml", "--velocity", "10", "--record", tmp_path / "recording")
    messages = list(read_recording(tmp_path / "recording", "/impact_report"))
    assert len(messages) == 1 and messages[0]["topic"] == "/impact_report"
    result = steel.simulate(velocity=10.0)
    assert messages[0]["message"]["max_v1"] == pytest.approx(result.max_v1, rel=1e-12)
    assert recording_info(tmp_path / "recording")["topics"]
    with pytest.raises(ProgramError, match="export ended with exit code 2"):
        list(read_recording(tmp_path / "missing"))
    with pytest.raises(ParameterError, match="out of range"):
        steel.report(tmp_path / "wrong.html", "mid_car", velocity=90.0)


def test_ctrl_c_ends_the_program_too(tmp_path: Path) -> None:
    """It took a quarter of a second. The signal reaches Python alone, as from a notebook."""
    started = tmp_path / "started"
    fake = tmp_path / "column-twin"
    fake.write_text(
        f'#!/bin/sh\n[ "$1" = --version ] && echo column-twin {__version__} && exit\n'
        f"echo $$ > {started}.new\nmv {started}.new {started}\nexec sleep 600\n"
    )
    fake.chmod(0o755)
    script = "from column_twin import run_program\ntry:\n    run_program('map')\nexcept KeyboardInterrupt:\n    print('interrupted', flush=True)\n"
    environment = {**os.environ, "COLUMN_TWIN_PROGRAM": str(fake)}
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, env=environment) as process:
        while not started.exists():
            assert process.poll() is None
            time.sleep(0.01)
        os.kill(process.pid, signal.SIGINT)
        assert process.communicate()[0] == "interrupted\n"
    with pytest.raises(ProcessLookupError):
        os.kill(int(started.read_text()), 0)


def test_a_missing_program_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("COLUMN_TWIN_PROGRAM", "")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("sysconfig.get_path", lambda name: str(tmp_path))
    with pytest.raises(ProgramError, match="pip install ./packaging/program"):
        run_program("--version")
    monkeypatch.setenv("COLUMN_TWIN_PROGRAM", str(tmp_path / "missing"))
    with pytest.raises(ProgramError, match="the program .*missing cannot be started: No such file"):
        run_program("--version")

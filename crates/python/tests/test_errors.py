"""Bad input: exceptions with the texts of the command line, and nothing half done."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from column_twin import Column, ColumnTwinError, ParameterError, ParameterWarning, SimulationError

Program = Callable[..., "subprocess.CompletedProcess[str]"]


def words(text: str) -> str:
    """A text without the frames and line breaks that the command line draws around it."""
    for mark in "│╭╰─×├▶":
        text = text.replace(mark, " ")
    return " ".join(text.split())


@pytest.mark.parametrize(
    ("changes", "count"),
    [
        ({"top.laod": 3.0}, 1),
        ({"top": 3.0}, 1),
        ({"section.name": "HEB 221", "steel.grade": "S350"}, 2),
        ({"top.load": "heavy"}, 1),
        ({"top.load": [1.0, 2.0]}, 1),
        ({"top.load": -1.0, "damping.ratio": 7.0, "solver.scheme": "euler"}, 3),
        ({"solver.dt": 1.5e-10}, 1),
        ({"vehicle.masses": [1.0, -2.0]}, 1),
    ],
)
def test_faults_of_parameters_are_those_of_the_command_line(
    program: Program, changes: dict[str, Any], count: int
) -> None:
    arguments = [part for name, value in changes.items() for part in ("-p", f"{name}:={value}")]
    ran = program("simulate", *arguments)
    assert ran.returncode == 2
    with pytest.raises(ParameterError) as raised:
        Column(changes)
    assert len(raised.value.faults) == count
    for fault in raised.value.faults:
        assert words(fault) in words(ran.stderr)


@pytest.mark.parametrize(
    ("impact", "option"),
    [
        ({"velocity": -5.0}, "--velocity=-5"),
        ({"velocity": 61.0}, "--velocity=61"),
        ({"velocity": float("nan")}, "--velocity=nan"),
        ({"mass": -1.0}, "--mass=-1"),
        ({"mass": 1e9}, "--mass=1e9"),
        ({"mass": float("inf")}, "--mass=inf"),
        ({"vehicle": "mid_cra"}, "--vehicle=mid_cra"),
        ({"vehicle": "lorry_8t", "mass": -1.0}, "--vehicle=lorry_8t --mass=-1"),
        ({"vehicle": "rigid", "mass": 0.0}, "--vehicle=rigid --mass=0"),
    ],
)
def test_faults_of_impacts_are_those_of_the_command_line(
    program: Program, impact: dict[str, Any], option: str
) -> None:
    ran = program("simulate", *option.split())
    assert ran.returncode == 2
    column = Column()
    for call in (column.evaluate, column.simulate, column.capacity):
        with pytest.raises(ParameterError) as raised:
            call(**impact)
        for fault in raised.value.faults:
            assert words(fault) in words(ran.stderr)


def test_a_fault_in_a_batch_names_its_element() -> None:
    with pytest.raises(ParameterError, match="element 2: .*\n  impact.velocity: `-1.0` is out of range"):
        Column().evaluate_batch(mass=1500.0, velocity=[1.0, 2.0, -1.0, -2.0])
    with pytest.raises(ParameterError, match="element 0: .*\n  impact.mass"):
        Column().evaluate_batch("rigid", mass=[0.0, 1.0], velocity=2.0)
    with pytest.raises(ParameterError, match="threads: expected a whole number from 1 to .*, found 0"):
        Column().evaluate_batch(mass=1500.0, velocity=[1.0], threads=0)
    with pytest.raises(ParameterError, match="mass: element 0 is 'heavy'; expected numbers"):
        Column().evaluate_batch(mass=["heavy"], velocity=[1.0])


def test_faults_of_files_have_line_and_column(program: Program, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text("column_twin:\n  ros__parameters:\n    top:\n      laod: 3.0\n      mass: -1.0\n")
    with pytest.raises(ParameterError) as raised:
        Column.from_file(wrong, steel__grade="S350")
    found = raised.value.faults
    assert [fault.startswith(f"{wrong}:{place}: ") for fault, place in zip(found, ("4:7", "5:13"), strict=False)] == [True] * 2
    assert len(found) == 3 and found[2].startswith("steel.grade: `S350` is not known (did you mean S355?)")
    missing = tmp_path / "missing.yaml"
    with pytest.raises(ParameterError, match="cannot be read: No such file"):
        Column.from_file(missing)
    ran = program("simulate", "--config", str(missing))
    assert "cannot be read: No such file" in words(ran.stderr)


def test_a_change_is_made_as_a_whole_or_not_at_all(paper: Column) -> None:
    before = paper.parameters
    with pytest.raises(ParameterError):
        paper.with_changes(top__load=1e5, top__mass=-1.0)
    assert paper.parameters == before
    assert paper.with_changes(top__load=1e5)["top.load"] == 1e5
    assert paper["top.load"] == before["top.load"]
    with pytest.raises(ParameterError, match="did you mean top.load"):
        paper["top.laod"]


def test_files_and_mappings_are_not_mixed_up(tmp_path: Path) -> None:
    """A path in the place of the mapping was an AttributeError, and `from_file` without a file was the column of the defaults."""
    with pytest.raises(TypeError, match="changes: expected a mapping .*, found str; Column.from_file reads parameter files"):
        Column("config/heb220_s355.yaml")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="from_file: expected one parameter file or more, found none"):
        Column.from_file(*tmp_path.glob("*.yaml"))
    with pytest.raises(ParameterError, match="vehicle.masses: element 1 is True; expected numbers"):
        Column({"vehicle.masses": [500.0, True]})


def test_deprecated_values_are_warnings() -> None:
    with pytest.warns(ParameterWarning, match="conserving_midpoint"):
        column = Column(solver__scheme="energy")  # type: ignore[arg-type]
    assert column["solver.scheme"] == "conserving_midpoint"


def test_values_of_other_types() -> None:
    assert Column(top__load=np.float64(3e5))["top.load"] == 3e5
    assert Column(top__load=np.int64(300_000))["top.load"] == 3e5
    assert Column({"vehicle.slack": np.array([])})["vehicle.slack"] == []
    with pytest.raises(TypeError, match="top.load: expected bool, int, float, str, or a list"):
        Column(top__load=None)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="out of range"):
        Column(top__load=10**30)


def test_exceptions_are_also_those_of_python() -> None:
    assert issubclass(ParameterError, ValueError) and issubclass(ParameterError, ColumnTwinError)
    assert issubclass(SimulationError, RuntimeError) and issubclass(SimulationError, ColumnTwinError)

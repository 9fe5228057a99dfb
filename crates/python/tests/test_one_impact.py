"""One impact: numbers of the paper, of the command line and of another implementation."""

from __future__ import annotations

import csv
import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from column_twin import Action, Column, Outcome, ParameterError, SimulationError

Program = Callable[..., "subprocess.CompletedProcess[str]"]


def test_the_paper_example(root: Path, paper: Column) -> None:
    """The history of an independent implementation of the paper's equations (tests/data)."""
    result = paper.simulate(mass=1500.0, velocity=10.0)
    with (root / "tests/data/heb220_ellipse.csv").open() as file:
        rows = list(csv.DictReader(file))
    time = np.array([float(row["t_s"]) for row in rows])
    assert time[-1] < result.time[-1]
    for column in ("v1_m", "u2_m", "Na_N", "contact_force_N", "plastic_work_J"):
        expected = np.array([float(row[column]) for row in rows])
        found = np.interp(time, result.time, result.history[column])
        assert np.abs(found - expected).max() < 2e-3 * np.abs(expected).max(), column
    assert result.outcome is Outcome.PLASTIC
    assert result.max_v1 == pytest.approx(0.0946, rel=2e-3)


@pytest.mark.parametrize("vehicle", [None, "mid_car", "lorry_8t"])
def test_report_and_history_are_those_of_the_command_line(
    root: Path, steel: Column, program: Program, tmp_path: Path, vehicle: str | None
) -> None:
    table = tmp_path / "history.csv"
    named = [] if vehicle is None else ["--vehicle", vehicle]
    config = str(root / "config/heb220_s355.yaml")
    # Python computes the two bars alone.
    bars = ("-p", "beam.mode:=off")
    ran = program("simulate", "--config", config, *named, *bars, "--velocity", "7.5", "--json", "--csv", str(table))
    assert ran.returncode == 0, ran.stderr
    result = steel.simulate(vehicle=vehicle, velocity=7.5)
    expected = json.loads(ran.stdout)
    found = dict(result.report)
    del expected["solve_time_s"], found["solve_time_s"]
    assert expected.pop("beam") == "no second opinion: it is switched off (beam.mode: off)"
    assert found == expected
    with table.open() as file:
        header, *rows = csv.reader(file)
    assert list(result.history) == header
    assert len(rows) == result.time.size
    numbers = np.array(rows, dtype=np.float64)
    for index, name in enumerate(header):
        assert np.array_equal(numbers[:, index], result.history[name]), name


@pytest.mark.parametrize("degrees", [0.0, 10.0, 90.0])
def test_the_beam_is_that_of_the_command_line(root: Path, steel: Column, program: Program, degrees: float) -> None:
    config = str(root / "config/heb220_s355.yaml")
    arguments = ("--vehicle", "mid_car", "--velocity", "9", "--direction", str(degrees))
    ran = program("simulate", "--config", config, *arguments, "--json")
    assert ran.returncode == 0, ran.stderr
    expected = json.loads(ran.stdout)
    result = steel.simulate("mid_car", velocity=9.0, direction=np.radians(degrees), model="both")
    found = dict(result.report)
    del expected["solve_time_s"], found["solve_time_s"]
    del expected["beam"]["solve_time_s"], found["beam"]["solve_time_s"]
    assert found == expected
    assert result.beam is not None and result.beam["max_displacement_m"] == expected["beam"]["max_displacement_m"]
    # The two bars take the component in their plane, also for what the impact leaves.
    bars = steel.simulate("mid_car", velocity=9.0, direction=np.radians(degrees))
    assert bars.beam is None and bars.max_v1 == result.max_v1
    turned = steel.with_changes(impact__direction=np.radians(degrees))
    hit: Any = {"vehicle": "mid_car", "velocity": 9.0}
    oblique = {**hit, "direction": np.radians(degrees)}
    left = [steel.after(bars), turned.after(**hit), steel.after(**oblique)]
    assert left[0].capacity().force == left[1].capacity().force == left[2].capacity().force
    assert repr(steel.evaluate(**oblique)) == repr(turned.evaluate(**hit))
    assert steel.evaluate_batch(**oblique).tobytes() == turned.evaluate_batch(**hit).tobytes()
    after = steel.capacity(**oblique)
    assert after.force == turned.capacity(**hit).force and after.report["state"].endswith("at 9 m/s")


def test_the_beam_alone_has_its_own_verdict(steel: Column) -> None:
    hit = {"vehicle": "mid_car", "velocity": 9.0, "direction": np.radians(90.0)}
    bars, beam, both = (steel.simulate(**hit, model=it) for it in ("bars", "beam", "both"))
    # By the two bars, which are plane, a vehicle that travels across them does nothing.
    assert bars.action is Action.NONE and beam.action is both.action is not Action.NONE
    assert beam.report["range"] is None and beam.max_v1 == bars.max_v1
    damage = steel.map(velocity=[8.0, 9.0], direction=[0.0, np.radians(90.0)], vehicle="mid_car", model="beam")
    assert damage["action"][1, 1] == beam.action


def test_where_the_beam_says_nothing_it_says_why(paper: Column) -> None:
    result = paper.simulate(mass=1500.0, velocity=5.0, model="both")
    with pytest.raises(SimulationError, match="no second opinion: the plates of the section"):
        _ = result.beam
    with pytest.raises(SimulationError, match="no second opinion: the plates of the section"):
        paper.simulate(mass=1500.0, velocity=5.0, model="beam")
    with pytest.raises(ParameterError, match="the model both needs the fibre beam, which beam.mode: off switches off"):
        paper.with_changes(beam__mode="off").simulate(mass=1500.0, velocity=5.0, model="both")
    for keywords in ({"direction": 3.2}, {"direction": -np.pi}, {"direction": float("nan")}, {"model": "shell"}):
        with pytest.raises(ParameterError, match="expected"):
            paper.simulate(mass=1500.0, velocity=5.0, **keywords)


def test_capacity_is_that_of_the_command_line(root: Path, paper: Column, program: Program) -> None:
    config = ("--config", str(root / "config/heb220_paper.yaml"), "--json")
    for arguments, capacity in [
        ((), paper.capacity()),
        (("--after-impact", "--velocity", "10"), paper.capacity(velocity=10.0)),
    ]:
        expected = json.loads(program("capacity", *config, *arguments).stdout)
        found = dict(capacity.report)
        del expected["state"], found["state"]
        assert found == expected
    after = paper.capacity(velocity=10.0)
    assert after.push_down.force.max() == pytest.approx(after.force, rel=1e-6)
    assert 0.0 < after.ratio < 1.0


def test_arrays_over_hinges_and_springs(steel: Column) -> None:
    result = steel.simulate(vehicle="mid_car", velocity=10.0)
    steps = result.time.size
    assert result.moments.shape == result.normal_forces.shape == result.plastic_rotations.shape == (steps, 4)
    assert np.array_equal(result.moments[:, 3], result.history["M3_Nm"])
    assert np.array_equal(result.normal_forces[:, 3], result.history["Na_N"])
    assert result.base_forces.shape == (steps, 3)
    assert np.array_equal(result.base_forces[:, 0], result.history["base_shear_N"])
    assert np.array_equal(result.base_forces[:, 1], result.history["M3_Nm"])
    assert result.crush.shape[1] == len(result.report["crush_max_m"]) >= 1
    assert result.crush.max() == pytest.approx(max(result.report["crush_max_m"]), rel=1e-3)
    assert steel.simulate("rigid", mass=1500.0, velocity=3.0).crush.shape[1] == 0


def test_the_arrays_of_a_result_cannot_be_changed(steel: Column) -> None:
    """`v1 = result.v1; v1 *= 1e3` changed the history, and the next figure was a thousand times too large."""
    result = steel.simulate("mid_car", velocity=10.0)
    v1 = result.v1
    with pytest.raises(ValueError, match="read-only"):
        v1 *= 1e3
    assert v1.max() == result.v1.max() == pytest.approx(result.max_v1, rel=1e-3)
    with pytest.raises(ValueError, match="read-only"):
        steel.capacity().push_down.force[0] = 0.0
    table = pytest.importorskip("pandas") and result.to_pandas()
    table["v1_m"] *= 1e3
    assert result.v1.max() == v1.max()


def test_a_evaluation_is_the_report_without_the_history(steel: Column) -> None:
    impacts = [("mid_car", None, 10.0), ("van", None, 20.0), ("articulated_36t", None, 25.0), ("rigid", 1500.0, 4.0)]
    for vehicle, mass, velocity in impacts:
        evaluation = steel.evaluate(vehicle=vehicle, mass=mass, velocity=velocity)
        result = steel.simulate(vehicle=vehicle, mass=mass, velocity=velocity)
        assert evaluation.action is result.action
        assert evaluation.outcome is result.outcome
        assert evaluation.deciding_criterion == result.report["deciding_criterion"]
        assert evaluation.max_v1 == pytest.approx(result.max_v1, rel=1e-3)
        if result.residual_v1 is None:
            assert np.isnan(evaluation.residual_v1)
    assert steel.evaluate("rigid", mass=36e3, velocity=25.0).action is Action.EVACUATE


def test_defaults_of_an_impact_are_those_of_the_parameters(steel: Column) -> None:
    column = steel.with_changes(vehicle__name="van", impact__mass=3000.0, impact__velocity=4.0)
    evaluation = column.evaluate()
    assert (evaluation.mass, evaluation.velocity) == (3000.0, 4.0)
    assert column.evaluate(vehicle="mid_car").mass == 1719.0
    assert column.evaluate(vehicle="mid_car", mass=1800.0).mass == 1800.0
    # The rigid mass has no mass of its own: it is that of the parameters.
    assert column.evaluate(vehicle="rigid").mass == 3000.0

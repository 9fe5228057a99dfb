"""Damage maps and critical velocities."""

from __future__ import annotations

import csv
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from column_twin import Action, Column, IncompleteWarning, Map, ParameterError, ParameterWarning, Range

Program = Callable[..., "subprocess.CompletedProcess[str]"]


def test_every_cell_equals_a_evaluation_bit_for_bit(steel: Column) -> None:
    damage = steel.map(mass=Range(6000, 12000, points=4), velocity=np.linspace(2.0, 20.0, 5), vehicle="lorry_8t")
    assert damage.cells.shape == (4, 5)
    assert (damage.rows.name, damage.columns.name) == ("mass", "velocity")
    assert not damage.failures
    expected = steel.evaluate_batch("lorry_8t", mass=damage.rows.values[:, None], velocity=damage.columns.values[None, :])
    for field in damage.cells.dtype.names or ():
        assert damage[field].tobytes() == np.ascontiguousarray(expected[field]).tobytes(), field


def test_an_axis_of_the_column_and_a_comparison(steel: Column) -> None:
    damage = steel.map("velocity=3:12:4", top__load=[2e5, 6e5], vehicle="van", compare={"section": ["HEB 220", "HEB 300"]})
    assert damage.labels == ["HEB220", "HEB300"]
    assert damage.cells.shape == (2, 2, 4)
    other = steel.with_changes(section__name="HEB 300", top__load=6e5)
    row = other.evaluate_batch("van", velocity=np.linspace(3.0, 12.0, 4))
    assert np.array_equal(damage["max_v1"][1, 1], row["max_v1"])
    assert (damage["max_v1"][1] < damage["max_v1"][0]).all()
    assert "HEB300" in damage._repr_html_()
    named = steel.map(vehicle=["mid_car", "van"], velocity=Range(5, 10, points=2))
    assert list(named.rows.values) == ["mid_car", "van"]
    assert named["max_v1"][0, 1] == steel.evaluate("mid_car", velocity=10.0).max_v1


def test_too_many_threads_are_not_started(steel: Column) -> None:
    with pytest.warns(UserWarning, match="^10000 threads were asked for; 4 are used, because"):
        many = steel.map(mass=Range(1000, 2000, points=2), velocity=Range(2, 4, points=2), threads=10_000)
    one = steel.map(mass=Range(1000, 2000, points=2), velocity=Range(2, 4, points=2), threads=1)
    assert many.cells.tobytes() == one.cells.tobytes()
    with pytest.warns(UserWarning, match="^9999 threads were asked for; 2 are used, because"):
        steel.evaluate_batch(mass=1500, velocity=[2.0, 3.0], threads=9999)
    with pytest.raises(ParameterError, match="threads"):
        steel.map(mass=Range(1000, 2000, points=2), velocity=Range(2, 4, points=2), threads=0)


def test_tables_and_figures_of_maps(steel: Column) -> None:
    pytest.importorskip("pandas")
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    damage = steel.map(mass=Range(1000, 20000, points=5), velocity=Range(1, 25, points=6))
    table = damage.to_pandas()
    assert len(table) == 30 and list(table.columns[:3]) == ["label", "mass", "velocity"]
    worst = table[table["action"] == "evacuate"]
    assert len(worst) == (damage["action"] == Action.EVACUATE).sum() > 0
    assert worst["velocity"].min() > 1.0
    ax = damage.plot()
    assert ax.get_xlabel() == "velocity of the vehicle [m/s]"
    assert ax.collections


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ({"mass": Range(2000, 1000, points=10), "velocity": Range(1, 2, points=2)}, "expected the smaller one first"),
        ({"mass": Range(1000, 2000, points=20_000), "velocity": Range(1, 2, points=20_000)}, "too many"),
        ({"mass": (1000, 2000, 50), "velocity": Range(1, 2, points=2)}, r"mass: expected a Range or a list.*Range\(1000, 2000, points=50\)"),
        ({"mass": [1000, np.nan], "velocity": Range(1, 2, points=2)}, "mass: element 1 is nan; expected finite"),
        ({"mass": [np.inf], "velocity": Range(1, 2, points=2)}, "mass: element 0 is inf"),
        ({"mass": Range(1000, 2000, points=2)}, "a map has two axes"),
        ({"column_id": Range(1, 2, points=2), "velocity": Range(1, 2, points=2)}, "cannot vary"),
        ({"top__laod": Range(1, 2, points=2), "velocity": Range(1, 2, points=2)}, "did you mean top.load"),
        ({"velocity": Range(1, 100, points=2), "mass": Range(1000, 2000, points=2)}, "is out of range; allowed: 1e-6 to 60 m/s"),
        ({"velocity": [], "mass": Range(1000, 2000, points=2)}, "velocity"),
    ],
)
def test_axes_that_are_not_accepted(steel: Column, axes: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        steel.map(**axes)


def test_critical_velocities_hold_the_action(steel: Column) -> None:
    found = steel.critical_velocities("lorry_8t", lowest=0.5, highest=30.0)
    assert list(found) == [Action.INSPECT, Action.RESTRICT, Action.SHORE, Action.EVACUATE]
    brackets = [it for it in found.items() if it[1].below is not None and it[1].at is not None]
    assert brackets
    for action, (below, at) in brackets:
        assert below is not None and at is not None and below < at <= 1.0101 * below
        assert steel.evaluate("lorry_8t", velocity=at).action >= action
        assert steel.evaluate("lorry_8t", velocity=below).action < action
    assert steel.critical_velocity(Action.SHORE, "lorry_8t", lowest=0.5, highest=30.0) == found[Action.SHORE]
    with pytest.raises(ParameterError, match="out of range"):
        steel.critical_velocities("lorry_8t", highest=100.0)
    with pytest.raises(ParameterError, match="below the highest"):
        steel.critical_velocities("lorry_8t", lowest=5.0, highest=5.0)


def test_the_parts_of_a_map_are_the_whole_map(steel: Column) -> None:
    axes: Any = {"mass": Range(1000, 3000, points=3), "velocity": Range(2, 20, points=5), "vehicle": "van"}
    whole = steel.map(**axes)
    parts = [steel.map(**axes, shard=(number, 4)) for number in (3, 1, 4, 2)]
    assert [part.part for part in parts] == [(7, 11), (0, 3), (11, 15), (3, 7)]
    # What another part computes is in no number of this one.
    assert [np.ma.count(part["max_v1"]) for part in parts] == [4, 3, 4, 4]
    assert Map.merged(parts).cells.tobytes() == whole.cells.tobytes()
    with pytest.raises(ParameterError, match="expected a part that begins with cell 3, found one that begins with 7"):
        Map.merged([parts[0], parts[1]])
    with pytest.raises(ParameterError, match="the cells from 3 to 14 are missing"):
        Map.merged([parts[1]])
    with pytest.raises(ParameterError, match="different axes"):
        Map.merged([parts[1], steel.map(**{**axes, "velocity": [1.0, 2.0]})])
    with pytest.raises(ParameterError, match="shard: expected a number from 1"):
        steel.map(**axes, shard=(5, 4))
    # Cells that failed keep their reasons.
    with pytest.warns(IncompleteWarning):
        failing = [steel.map(top__load=[2e5, 1e8], velocity=[2.0, 30.0], shard=(number, 2)) for number in (1, 2)]
    assert set(Map.merged(failing).failures) == {(1, 0), (1, 1)}


def test_a_map_as_a_data_set_with_units(steel: Column) -> None:
    pytest.importorskip("xarray")
    compare = {"section": ["HEB 220", "HEB 300"]}
    damage = steel.map(top__load=[2e5, 6e5], velocity=Range(3, 12, points=4), vehicle="van", compare=compare)
    data = damage.to_xarray()
    assert dict(data.sizes) == {"section": 2, "top_load": 2, "velocity": 4}
    assert data.velocity.units == "m/s" and data.top_load.units == "N" and data.max_v1.units == "m"
    cell = data.max_v1.sel(section="HEB300", top_load=6e5, velocity=12.0)
    assert float(cell) == damage["max_v1"][1, 1, 3]
    assert data.action.flag_meanings.split() == [str(it) for it in Action]
    with pytest.warns(IncompleteWarning):
        failed = steel.map(top__load=[2e5, 1e8], velocity=[2.0, 30.0]).to_xarray()
    assert int((failed.action >= Action.SHORE).sum() + (failed.action < Action.SHORE).sum()) == 2
    assert set(data.data_vars) == set(damage.cells.dtype.names or ())


def test_the_boundaries_of_a_map_are_where_the_cells_change(steel: Column) -> None:
    axes: Any = {"mass": Range(1000, 3000, points=3), "velocity": Range(1, 20, points=40), "vehicle": "van"}
    refined = steel.refined_map(**axes)
    rows, velocities = refined.boundary(Action.SHORE)
    assert rows.size == 3 and refined.responses > 0
    for mass, velocity in zip(rows, velocities, strict=True):
        assert steel.evaluate("van", mass=mass, velocity=1.011 * velocity).action >= Action.SHORE
        assert steel.evaluate("van", mass=mass, velocity=velocity / 1.011).action < Action.SHORE
    with pytest.raises(ValueError, match="from inspect to evacuate"):
        refined.boundary(Action.NONE)
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    ax = refined.plot()
    assert ax.get_xlabel() == "velocity [m/s]" and ax.lines


def test_the_colours_are_those_of_the_program_and_keep_their_order_in_grey() -> None:
    from column_twin._html import COLOURS

    light = [
        sum(weight * int(COLOURS[it][at : at + 2], 16) for weight, at in ((0.299, 1), (0.587, 3), (0.114, 5))) for it in Action
    ]
    assert all(darker < lighter - 10 for lighter, darker in zip(light, light[1:], strict=False))


@pytest.mark.parametrize("model", ["bars", "beam", "both"])
def test_a_map_over_directions_is_that_of_the_command_line(
    root: Path, steel: Column, program: Program, tmp_path: Path, model: Any
) -> None:
    degrees, speeds = [0.0, 20.0, 90.0], [4.0, 8.0, 12.0]
    path = tmp_path / "map.csv"
    values = [",".join(map(str, it)) for it in (degrees, speeds)]
    config = ("--config", str(root / "config/heb220_s355.yaml"), "--vehicle", "mid_car")
    ran = program("map", *config, "--direction", values[0], "--velocity", values[1], "--model", model, "--csv", str(path))
    assert ran.returncode == 0, ran.stderr
    with path.open() as file:
        expected = list(csv.DictReader(file))
    damage = steel.map(direction=np.radians(degrees), velocity=speeds, vehicle="mid_car", model=model)
    assert (damage.rows.name, damage.rows.unit, damage.model) == ("direction", "rad", model)
    assert damage.cells.shape == (3, 3) and len(expected) == 9
    for row, cell in zip(expected, damage.cells.reshape(-1)):
        assert Action(cell["action"]).name.lower() == row["action"]
        assert cell["max_v1"] == float(row["max_v1_m"])
        assert cell["reserve"] == float(row["reserve"])
    names = [name for name in expected[0] if name.startswith("beam_") or name == "ratio_to_two_bars"]
    assert list(damage.beam) == [*names, *(["no_second_opinion"] if names else [])]
    for name in names:
        for row, found in zip(expected, damage.beam[name].reshape(-1)):
            there = row[name] if isinstance(found, str) else float(row[name] or "nan")
            assert found == there or (np.isnan(found) and np.isnan(there)), name
    assert bool(names) == (model != "bars")
    # In the notation of the command line the angles are in degrees, and the axis names that unit.
    text = steel.map(f"direction={values[0]}", velocity=speeds, vehicle="mid_car", model=model)
    assert (text.rows.name, text.rows.unit) == ("direction", "degrees")
    assert np.array_equal(text["max_v1"], damage["max_v1"])


def test_the_parts_of_a_map_by_both_models_are_the_whole_map(steel: Column) -> None:
    axes: Any = {"direction": [0.0, 0.5], "velocity": [4.0, 8.0], "vehicle": "mid_car", "model": "both"}
    whole = steel.map(**axes)
    parts = [steel.map(**axes, shard=(number, 3)) for number in (2, 3, 1)]
    assert np.isnan(parts[2].beam["beam_max_sideways_m"]).sum() == 3
    merged = Map.merged(parts)
    assert merged.cells.tobytes() == whole.cells.tobytes() and merged.beam_units == whole.beam_units
    assert list(merged.beam) == list(whole.beam) and merged.model == "both"
    for name, values in whole.beam.items():
        assert np.array_equal(merged.beam[name], values, equal_nan=values.dtype == float), name
    with pytest.raises(ParameterError, match="one by the model 'both' and one by 'bars'"):
        Map.merged([parts[2], *(steel.map(**{**axes, "model": "bars"}, shard=(number, 3)) for number in (2, 3))])
    table = pytest.importorskip("pandas") and whole.to_pandas()
    assert table["beam_max_sideways_m"].tolist() == whole.beam["beam_max_sideways_m"].reshape(-1).tolist()
    pytest.importorskip("xarray")
    data = whole.to_xarray()
    assert data.attrs["model"] == "both" and data.direction.attrs["units"] == "rad"
    assert data.beam_max_sideways_m.attrs["units"] == "m"
    assert float(data.beam_max_sideways_m.sel(direction=0.5, velocity=8.0)) > 0.0
    assert steel.map(mass=[1500, 1800], velocity=[4.0, 8.0]).to_xarray().attrs["model"] == "bars"


def test_models_and_directions_that_are_not_accepted(steel: Column) -> None:
    axes: Any = {"velocity": [4.0, 8.0], "vehicle": "mid_car"}
    # 90 degrees are no 90 rad.
    with pytest.raises(ParameterError, match=r"direction: 90 is out of range; expected angles .* in rad, such as np.radians\(90\)"):
        steel.map(**axes, direction=[0.0, 90.0])
    with pytest.raises(ParameterError, match="200 degrees is not a direction"):
        steel.map("direction=0,200", **axes)
    with pytest.raises(ParameterError, match="two axes determine the same parameter"):
        steel.map("direction=0:90:2", direction=[0.0, 1.0])
    with pytest.raises(ParameterError, match="model: expected 'bars', 'beam' or 'both', found 'shell'"):
        steel.map(**axes, direction=[0.0, 1.0], model="shell")  # type: ignore[arg-type]
    off = steel.with_changes(beam__mode="off")
    with pytest.raises(ParameterError, match="beam.mode: off switches off"):
        off.map(**axes, direction=[0.0, 1.0], model="beam")
    with pytest.raises(ParameterError, match="beam.mode: off switches off"):
        off.risk("courtyard", 100, samples=10, model="both")
    with pytest.raises(ParameterError, match="model: expected 'bars'"):
        steel.risk("courtyard", 100, samples=10, model="shell")  # type: ignore[arg-type]


def test_boundaries_by_both_models_lie_between_cells(steel: Column) -> None:
    axes: Any = {"direction": np.radians([0.0, 30.0]), "velocity": Range(2, 14, points=5), "vehicle": "mid_car"}
    refined = steel.refined_map(**axes, model="both")
    assert refined.report["model"] == "both"
    assert (refined.report["rows"]["name"], refined.report["rows"]["unit"]) == ("direction", "rad")
    rows, speeds = refined.boundary(Action.RESTRICT)
    assert rows.size > 0
    for direction, speed in zip(rows, speeds):
        around = [0.98 * float(speed), 1.02 * float(speed)]
        hits = [steel.simulate("mid_car", velocity=it, direction=direction, model="both").action for it in around]
        assert hits[0] is not None and hits[1] is not None and hits[0] < Action.RESTRICT <= hits[1]

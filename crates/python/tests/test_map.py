"""Damage maps and critical velocities."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from column_twin import Column, ParameterError, Action


def test_every_cell_equals_a_evaluation_bit_for_bit(steel: Column) -> None:
    damage = steel.map(mass=(6000, 12000, 4), velocity=np.linspace(2.0, 20.0, 5), vehicle="lorry_8t")
    assert damage.cells.shape == (4, 5)
    assert (damage.rows.name, damage.columns.name) == ("mass", "velocity")
    assert not damage.failures
    expected = steel.evaluate_batch(damage.rows.values[:, None], damage.columns.values[None, :], "lorry_8t")
    for field in damage.cells.dtype.names or ():
        assert damage[field].tobytes() == np.ascontiguousarray(expected[field]).tobytes(), field


def test_an_axis_of_the_column_and_a_comparison(steel: Column) -> None:
    damage = steel.map("velocity=3:12:4", top__load=[2e5, 6e5], vehicle="van", compare={"section": ["HEB 220", "HEB 300"]})
    assert damage.labels == ["HEB220", "HEB300"]
    assert damage.cells.shape == (2, 2, 4)
    other = steel.with_changes(section__name="HEB 300", top__load=6e5)
    row = other.evaluate_batch(None, np.linspace(3.0, 12.0, 4), "van")
    assert np.array_equal(damage["max_v1"][1, 1], row["max_v1"])
    assert (damage["max_v1"][1] < damage["max_v1"][0]).all()
    assert "HEB300" in damage._repr_html_()
    named = steel.map(vehicle=["mid_car", "van"], velocity=(5, 10, 2))
    assert list(named.rows.values) == ["mid_car", "van"]
    assert named["max_v1"][0, 1] == steel.evaluate("mid_car", velocity=10.0).max_v1


def test_too_many_threads_are_not_started(steel: Column) -> None:
    with pytest.warns(UserWarning, match="^10000 threads were asked for; 4 are used, because"):
        many = steel.map(mass=(1000, 2000, 2), velocity=(2, 4, 2), threads=10_000)
    one = steel.map(mass=(1000, 2000, 2), velocity=(2, 4, 2), threads=1)
    assert many.cells.tobytes() == one.cells.tobytes()
    with pytest.warns(UserWarning, match="^9999 threads were asked for; 2 are used, because"):
        steel.evaluate_batch(1500, [2.0, 3.0], threads=9999)
    with pytest.raises(ParameterError, match="threads"):
        steel.map(mass=(1000, 2000, 2), velocity=(2, 4, 2), threads=0)


def test_tables_and_figures_of_maps(steel: Column) -> None:
    pytest.importorskip("pandas")
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    damage = steel.map(mass=(1000, 20000, 5), velocity=(1, 25, 6))
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
        ({"mass": (2000, 1000, 10), "velocity": (1, 2, 2)}, "expected the smaller one first"),
        ({"mass": (1000, 2000, 1), "velocity": (1, 2, 2)}, "mass"),
        ({"mass": (1000, 2000, 20_000), "velocity": (1, 2, 20_000)}, "too many"),
        ({"mass": (1000, 2000, 2.5), "velocity": (1, 2, 2)}, "number of points"),
        ({"mass": (1000, 2000, 2)}, "a map has two axes"),
        ({"column_id": (1, 2, 2), "velocity": (1, 2, 2)}, "cannot vary"),
        ({"top__laod": (1, 2, 2), "velocity": (1, 2, 2)}, "did you mean top.load"),
        ({"velocity": (1, 100, 2), "mass": (1000, 2000, 2)}, "is out of range; allowed: 1e-6 to 60 m/s"),
        ({"velocity": [], "mass": (1000, 2000, 2)}, "velocity"),
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

"""What reads as one thing and would mean another: each raises, warns, or means what a reader expects."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from column_twin import Action, Column, IncompleteWarning, Map, ParameterError, ParameterWarning, Range, SimulationError

ROOT = Path(__file__).resolve().parents[3]


def test_a_number_in_the_place_of_a_velocity_is_no_mass(steel: Column) -> None:
    """`simulate("mid_car", 10.0)` was a car of 10 kg."""
    for call in (steel.simulate, steel.evaluate, steel.capacity, steel.critical_velocities, steel.sensor_readings):
        with pytest.raises(TypeError, match=r"has no positional argument for 10.0; give it by a keyword: mass=\.\.\., "):
            call("mid_car", 10.0)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="after: expected a result of simulate, found str; a vehicle is given by a keyword"):
        steel.after("mid_car", velocity=8.0)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="positional argument"):
        steel.evaluate_batch([1500.0], [10.0])  # type: ignore[call-arg, arg-type]
    with pytest.raises(TypeError, match="vehicle: expected a name such as 'mid_car', found list; .* mass=..., velocity="):
        steel.evaluate_batch([1500.0], velocity=10.0)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="found float"):
        steel.evaluate(10.0)  # type: ignore[arg-type]


def test_a_lorry_of_ten_kilograms_is_told(steel: Column) -> None:
    for mass in (8.0, 10.0, 49.0, 300.0):
        with pytest.warns(ParameterWarning, match=f"impact.mass is the mass of a lorry_8t of {mass:g} kg: .* expected in kg") as found:
            steel.evaluate("lorry_8t", mass=mass, velocity=5.0)
        assert found[0].filename == __file__
    with pytest.warns(ParameterWarning, match="element 1: impact.mass is the mass of a mid_car of 1.7 kg"):
        steel.evaluate_batch("mid_car", mass=[1700.0, 1.7, 2.0], velocity=5.0)
    with pytest.warns(ParameterWarning, match="mass: the smallest one is the mass of a lorry_8t of 6 kg"):
        steel.map(mass=Range(6, 12, points=2), velocity=[1.0, 2.0], vehicle="lorry_8t")
    # Boundaries and compared masses told nothing.
    with pytest.warns(ParameterWarning, match="mass: the smallest one is the mass of a lorry_8t of 6 kg"):
        steel.refined_map(mass=Range(6, 12, points=2), velocity=[1.0, 2.0], vehicle="lorry_8t")
    with pytest.warns(ParameterWarning, match="mass: the smallest one is the mass of a lorry_8t of 6 kg"):
        steel.map(height=[0.5, 1.0], velocity=[1.0, 2.0], compare={"mass": [6.0, 8000.0]}, vehicle="lorry_8t")
    with pytest.warns(ParameterWarning, match="impact.mass is the mass of a van of 3 kg"):
        Column(vehicle__name="van", impact__mass=3.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # A rigid mass may be that of an experiment, and a lorry may be empty.
        steel.evaluate("rigid", mass=10.0, velocity=5.0)
        steel.evaluate("lorry_8t", mass=4000.0, velocity=5.0)


def test_numbers_in_another_unit_are_told_with_theirs(steel: Column) -> None:
    with pytest.raises(ParameterError, match="impact.velocity: `90.0` is out of range; allowed: 1e-6 to 60 m/s"):
        steel.evaluate("mid_car", velocity=90.0)
    with pytest.raises(ParameterError, match="element 1: .*\n.*`90.0` is out of range; allowed: 1e-6 to 60 m/s"):
        steel.evaluate_batch("mid_car", velocity=[9.0, 90.0])
    with pytest.raises(ParameterError, match="steel.yield_strength: `355.0` is out of range; .*1e6 to 1e10 Pa"):
        Column(steel__yield_strength=355.0)
    with pytest.raises(ParameterError, match="steel.young_modulus: `210000.0` is out of range; .*Pa"):
        Column(steel__young_modulus=210_000.0)


def test_a_direction_in_degrees_is_told(steel: Column) -> None:
    """`Column(impact__direction=90.0)` was a hit with the whole velocity, as if it came along the web."""
    with pytest.raises(ParameterError, match=r"direction 90.0: expected an angle .* in rad, such as np.radians\(90.0\)"):
        steel.simulate("van", velocity=5.0, direction=90.0)
    for call in (Column, steel.with_changes):
        with pytest.warns(ParameterWarning, match=r"impact.direction: 90.0 is no direction, .*np.radians\(90.0\)") as found:
            call(impact__direction=90.0)
        assert found[0].filename == __file__


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_found_by_its_index(steel: Column, wrong: float) -> None:
    with pytest.raises(ParameterError, match="element 2: .*"):
        steel.evaluate_batch("mid_car", velocity=[1.0, 2.0, wrong])
    with pytest.raises(ParameterError, match="(?s)element 1: .*impact.mass"):
        steel.evaluate_batch("mid_car", mass=[1500.0, wrong], velocity=1.0)
    with pytest.raises(ParameterError, match="impact.mass"):
        steel.evaluate("mid_car", mass=wrong, velocity=1.0)
    with pytest.raises(ParameterError, match="top.load"):
        Column(top__load=wrong)


def test_a_range_says_that_it_is_one(steel: Column) -> None:
    """`velocity=(5, 10, 15)` was 15 points from 5 to 10."""
    with pytest.raises(ParameterError, match=r"Range\(5, 10, points=15\) .* or \[5, 10, 15\] for these three"):
        steel.map(velocity=(5, 10, 15), mass=[1500.0], vehicle="van")
    three = steel.map(velocity=[5, 10, 15], mass=[2000.0, 2500.0], vehicle="van")
    assert list(three.columns.values) == [5.0, 10.0, 15.0]
    fifteen = steel.map(velocity=Range(5, 10, points=15), mass=[2000.0, 2500.0], vehicle="van")
    assert np.allclose(fifteen.columns.values, np.linspace(5.0, 10.0, 15), rtol=1e-14)
    for points in (1, 2.5, True):
        with pytest.raises(ParameterError, match="expected points, a whole number of at least 2"):
            Range(5, 10, points=points)  # type: ignore[arg-type]


def test_a_misspelt_keyword_is_told_with_the_nearest_one(steel: Column) -> None:
    with pytest.raises(TypeError, match=r"Column.simulate\(\) got an unexpected .* 'velocty'; did you mean 'velocity'\?"):
        steel.simulate("mid_car", velocty=10.0)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"Column.fleet\(\) got an unexpected .* 'tables'; did you mean 'table'\?"):
        Column.fleet(tables="columns.csv")  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="'zzz'; it takes scenario, vehicles_per_day, years"):
        steel.risk("urban", 1000, zzz=1)  # type: ignore[call-arg]
    # A map takes any parameter, and said only that it has two axes.
    for call in (steel.map, steel.refined_map):
        with pytest.raises(ParameterError, match=r"vehicel is neither a keyword nor an axis of a map \(did you mean vehicle\?\)"):
            call(velocity=[1.0, 2.0], mass=[2000.0, 3000.0], vehicel="van")  # type: ignore[call-arg]
    with pytest.raises(ParameterError, match="did you mean velocity"):
        steel.map(velocty=[1.0, 2.0], mass=[2000.0, 3000.0])  # type: ignore[call-arg]
    with pytest.raises(ParameterError, match="did you mean top.load"):
        steel.map(velocity=[1.0, 2.0], mass=[2000.0, 3000.0], top__laod=[1e5, 2e5])  # type: ignore[call-arg]


def test_a_rigid_vehicle_does_not_take_the_own_mass_of_another_one(steel: Column) -> None:
    """`evaluate("rigid", velocity=3.0)` was a rigid mass as heavy as the mid_car of the column; the command line asks for the mass."""
    expected = "impact.mass is required, because a rigid vehicle has no mass of its own; give it in kg"
    for call in (steel.simulate, steel.evaluate, steel.evaluate_batch, steel.capacity):
        with pytest.raises(ParameterError, match=expected):
            call("rigid", velocity=3.0)
    with pytest.raises(ParameterError, match=expected):
        steel.critical_velocities("rigid")
    with pytest.raises(ParameterError, match=expected):
        steel.after(vehicle="rigid", velocity=3.0)
    assert steel.evaluate("rigid", mass=1719.0, velocity=3.0).mass == 1719.0
    # One that the parameters give is its own.
    given = Column(vehicle__name="rigid", impact__mass=900.0)
    assert given.evaluate("rigid", velocity=3.0).mass == given.evaluate(velocity=3.0).mass == 900.0


def test_a_truth_value_is_no_number(steel: Column) -> None:
    """`velocity=True` was 1 m/s."""
    for call in (steel.simulate, steel.evaluate, steel.evaluate_batch, steel.capacity, steel.sensor_readings):
        for keyword in ("velocity", "mass"):
            wrong: dict[str, Any] = {keyword: True}
            with pytest.raises(ParameterError, match=f"{keyword}: .*expected (a number|numbers)|{keyword}: element 0 is True"):
                call("van", **wrong)
    with pytest.raises(ParameterError, match="velocity: element 0 is True"):
        steel.map(velocity=[True, 2.0], mass=[2000.0, 3000.0], vehicle="van")
    with pytest.raises(ParameterError, match="direction: expected a number, found True"):
        steel.simulate("van", velocity=5.0, direction=True)


def test_a_text_is_no_number(steel: Column) -> None:
    """`evaluate_batch("van", velocity="10")` was 10 m/s, because numpy reads numbers in texts."""
    wrong: list[tuple[Any, str]] = [
        ("10", "element 0 is '10'"),
        ([5.0, "6"], "element 1 is '6'"),
        (np.array([5.0, True], dtype=object), "element 1 is True"),
        ([5.0, None], "element 1 is None"),
        (np.array(["2026-01-01"], dtype="datetime64[D]"), "element 0 is datetime.date"),
        ([[5.0], [5.0, 6.0]], "expected an array of numbers"),
        ([5.0 + 1.0j], "element 0 is "),
    ]
    for given, message in wrong:
        with pytest.raises(ParameterError, match=f"velocity: {message}"):
            steel.evaluate_batch("van", velocity=given)
    with pytest.raises(ParameterError, match="velocity: expected a number, found '10'"):
        steel.evaluate("van", velocity="10")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="vehicles_per_day: expected a number, found '1000'"):
        steel.risk("urban", "1000")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="velocity: element 1 is '6'; expected finite numbers"):
        steel.map(velocity=[5.0, "6"], mass=[2000.0, 3000.0], vehicle="van")  # type: ignore[list-item]
    with pytest.raises(ParameterError, match="velocity: expected the values of an axis, found the number 5.0"):
        steel.map(velocity=np.array(5.0), mass=[2000.0, 3000.0], vehicle="van")
    with pytest.raises(ParameterError, match="Range: first: expected a number, found True"):
        Range(True, 5, points=3)


def test_an_oblique_hit_has_the_speed_that_was_given(steel: Column) -> None:
    """It had the component in the plane of the two bars, and was another impact when it was computed again."""
    turned = steel.with_changes(impact__direction=np.radians(60.0))
    evaluation = turned.evaluate("van", velocity=8.0)
    batch = turned.evaluate_batch("van", mass=[2000.0, evaluation.mass], velocity=8.0)
    assert evaluation.velocity == 8.0 and batch["velocity"].tolist() == [8.0, 8.0]
    assert turned.evaluate("van", velocity=evaluation.velocity).max_v1 == evaluation.max_v1 == batch["max_v1"][1]
    straight = steel.evaluate("van", velocity=8.0 * np.cos(np.radians(60.0)))
    assert evaluation.max_v1 == pytest.approx(straight.max_v1, rel=3e-3)


def test_a_map_is_a_collection_of_its_fields(steel: Column) -> None:
    """`"max_v1" in damage` compared rows of cells with the name, and a misspelt field was an error of numpy."""
    damage = steel.map(mass=[1500.0, 2500.0], velocity=[2.0, 4.0], vehicle="van")
    assert "max_v1" in damage and "mass" not in damage
    assert list(damage) == list(damage.cells.dtype.names or ())
    with pytest.raises(ParameterError, match=r"found 'max_v2' \(did you mean max_v1\?\)"):
        damage["max_v2"]
    with pytest.raises(ParameterError, match="found 'mass'; `axes` has the values of the axes"):
        damage["mass"]
    with pytest.raises(ParameterError, match=r"shard: expected the number of a part and the number of parts, .*; found '1/4'"):
        steel.map(mass=[1500.0, 2500.0], velocity=[2.0, 4.0], shard="1/4")  # type: ignore[arg-type]


def test_a_truth_value_among_numbers_is_found_by_its_index(steel: Column) -> None:
    """`[5.0, True]` was 5 and 1 m/s."""
    with pytest.raises(ParameterError, match="velocity: element 1 is True; expected numbers"):
        steel.evaluate_batch("van", velocity=[5.0, True])
    # In a list of lists it still was.
    nested: list[tuple[Any, str]] = [
        ([[5.0, True]], "True"),
        ([[5.0], (np.True_,)], "True"),
        ([np.array([5.0]), np.array([True])], "True"),
        ([np.ma.array([5.0, 6.0], mask=[False, True])], "masked"),
    ]
    for wrong_numbers, word in nested:
        with pytest.raises(ParameterError, match=f"velocity: element 1 is {word}; expected numbers"):
            steel.evaluate_batch("van", velocity=wrong_numbers)
    assert steel.evaluate_batch("van", velocity=[[5.0, 6.0]]).shape == (1, 2)
    with pytest.raises(ParameterError, match="mass: element 2 is masked; expected numbers"):
        steel.evaluate_batch("van", mass=[1500.0, 1600.0, np.ma.masked], velocity=5.0)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="velocity: element 0 is False"):
        steel.evaluate_batch("van", velocity=(np.False_, 2.0))  # type: ignore[arg-type]


def test_a_masked_element_is_found_by_its_index(steel: Column) -> None:
    """The mask was lost, and the number behind it was computed."""
    masked = np.ma.array([1.0, 2.0, 3.0], mask=[False, False, True])
    for given in ({"velocity": masked}, {"mass": 1000.0 * masked, "velocity": 2.0}):
        with pytest.raises(ParameterError, match="element 2 is masked"):
            steel.evaluate_batch("van", **given)
    with pytest.raises(ParameterError, match="velocity: element 2 is masked"):
        steel.map(velocity=masked, mass=[2000.0, 3000.0], vehicle="van")
    with pytest.raises(ParameterError, match="velocity: expected a number"):
        steel.evaluate("van", velocity=masked[2])
    unmasked = np.ma.array([1.0, 2.0])
    assert steel.evaluate_batch("van", velocity=unmasked).tobytes() == steel.evaluate_batch("van", velocity=[1.0, 2.0]).tobytes()


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5])
def test_a_seed_out_of_range_is_told_with_the_range(steel: Column, seed: Any) -> None:
    """It was a TypeError about a field of the native part."""
    sensors = Column.from_file(ROOT / "config/sensors_industrial.yaml")
    expected = f"seed: expected a whole number from 0 to {2**64 - 1}, found {seed}"
    with pytest.raises(ParameterError, match=expected):
        steel.risk("urban", 1000, samples=10, seed=seed)
    with pytest.raises(ParameterError, match=expected):
        sensors.sensor_readings("van", velocity=5.0, seed=seed)
    with pytest.raises(ParameterError, match="samples: expected a whole number from 1"):
        steel.risk("urban", 1000, samples=seed if seed < 2 else 10**13)


def test_a_mass_that_nobody_can_have_meant_is_told_once(steel: Column) -> None:
    """Critical velocities gave the warning for both ends of the scan."""
    with pytest.warns(ParameterWarning, match="impact.mass is the mass of a van of 2.5 kg") as found:
        steel.critical_velocities("van", mass=2.5)
    assert len(found) == 1 and found[0].filename == __file__
    with pytest.warns(ParameterWarning, match="impact.mass is the mass of a van of 2.5 kg") as found:
        steel.critical_velocity(Action.SHORE, "van", mass=2.5)
    assert len(found) == 1 and found[0].filename == __file__
    with pytest.raises(ParameterError, match="action: expected one from inspect to evacuate, such as Action.SHORE; found 'shore'"):
        steel.critical_velocity("shore", "van")  # type: ignore[arg-type]


def with_failures(column: Column) -> Map:
    """A map on whose first axis the load grows beyond what the column can bear."""
    with pytest.warns(IncompleteWarning, match="cells cannot be computed and are masked; the first, ") as found:
        damage = column.map(top__load=[2e5, 1e8], velocity=[2.0, 30.0], vehicle="van")
    assert found[0].filename == __file__
    return damage


def test_a_cell_that_failed_is_in_no_comparison(steel: Column) -> None:
    """A cell without a result counted as at least `shore`, because its code is 255."""
    damage = with_failures(steel)
    failed = np.zeros(damage.cells.shape, dtype=bool)
    for place in damage.failures:
        failed[place] = True
    assert failed.tolist() == [[False, False], [True, True]]
    for action in Action:
        assert (damage["action"] >= action).sum() + (damage["action"] < action).sum() == 2
        assert (damage.cells["action"] >= action).sum() <= 2
    assert np.isfinite(damage["max_v1"].max()) and np.ma.count(damage["max_v1"]) == 2
    assert np.ma.getmaskarray(damage["reserve"]).tolist() == failed.tolist()


def test_rows_of_boundaries_that_failed_are_told(steel: Column) -> None:
    """They were missing among the boundaries without a word."""
    with pytest.warns(IncompleteWarning, match="1 of the rows cannot be computed in whole; the first, row 1: ") as found:
        refined = steel.refined_map(top__load=[2e5, 1e8], velocity=Range(2, 30, points=5), vehicle="van")
    assert found[0].filename == __file__
    assert 1e8 not in refined.boundary(Action.EVACUATE)[0]


def test_changes_warn_as_the_constructor_does(paper: Column) -> None:
    with pytest.warns(ParameterWarning, match="`energy` is deprecated") as found:
        changed = paper.with_changes(solver__scheme="energy")  # type: ignore[arg-type]
    assert found[0].filename == __file__
    assert changed["solver.scheme"] == "conserving_midpoint"


def test_a_value_that_follows_from_others_is_read_as_what_it_is() -> None:
    """`column["section.area"]` read 0.0."""
    column = Column(section__name="HEB 300", steel__grade="S355", vehicle__name="mid_car")
    properties = column.properties
    assert column["section.area"] == properties.area == pytest.approx(149.1e-4, rel=1e-3)
    assert column["steel.yield_strength"] == properties.yield_strength == 355e6
    assert column["resistance.axial"] == column.resistance_axial == properties.resistance_axial
    assert column["impact.mass"] == 1719.0 and column["solver.dt"] == column.step > 0.0
    assert column["geometry.height"] == properties.height == 4.0
    assert (properties.section, properties.steel) == ("HEB300", "S355")
    assert properties.bending_stiffness == pytest.approx(210e9 * 25170e-8, rel=1e-3)
    # What was given is as it was given, so that it makes the same column.
    assert column.parameters["section.area"] == 0.0
    assert Column(column.parameters) == column


def test_a_column_is_read_as_a_mapping(steel: Column) -> None:
    """`in` and `list()` asked for the parameter 0."""
    assert "top.load" in steel and "top.laod" not in steel and 0 not in steel  # type: ignore[comparison-overlap]
    assert list(steel) == list(steel.parameters) and len(steel) == len(steel.parameters)
    assert dict(steel)["section.height"] == 0.22
    assert isinstance(steel, Mapping) and {**steel} == dict(steel.items()) == dict(zip(steel.keys(), steel.values(), strict=True))
    assert steel.get("top.load") == steel["top.load"]
    assert steel.get("top.laod") is None and steel.get("top.laod", 3.0) == 3.0
    with pytest.raises(KeyError) as raised:
        steel["top.laod"]
    assert isinstance(raised.value, ParameterError) and "did you mean top.load?" in str(raised.value)
    # What follows from the name of a section follows from the next one, too.
    assert Column(steel) == steel
    assert Column(steel, section__name="HEB 300") == steel.with_changes(section__name="HEB 300")


def test_a_value_that_was_read_belongs_to_its_reader() -> None:
    """The values of a column are kept for the next reader, who must not see what this one has done with a list."""
    column = Column.from_file(ROOT / "config/sensors_industrial.yaml")
    names = column["sensors.names"]
    assert isinstance(names, list) and names
    first = list(names)
    names.clear()
    assert column["sensors.names"] == first
    assert column["top.load"] == column.parameters["top.load"]
    changed = column.with_changes(top__load=1e5, section__name="HEB 300")
    assert (changed["top.load"], changed["section.height"], column["section.height"]) == (1e5, 0.3, 0.22)


def test_a_file_has_all_parameters(steel: Column, tmp_path: Path) -> None:
    column = steel.with_changes(top__load=1.0 / 3.0, vehicle__name="van")
    column.to_file(tmp_path / "column.yaml")
    assert Column.from_file(tmp_path / "column.yaml") == column


def test_the_column_after_an_impact(steel: Column) -> None:
    result = steel.simulate("lorry_8t", velocity=8.0)
    assert result.residual_v1 is not None and result.residual_v1 > 1e-3
    damaged = steel.after(result)
    assert damaged.is_damaged and not steel.is_damaged and damaged != steel
    assert damaged == steel.after(vehicle="lorry_8t", velocity=8.0)
    # What the same column carries by its full simulation.
    left = steel.capacity("lorry_8t", velocity=8.0)
    assert damaged.capacity().force == pytest.approx(left.force, rel=1e-9)
    # A second impact adds to the first.
    again, once = damaged.evaluate("lorry_8t", velocity=8.0), steel.evaluate("lorry_8t", velocity=8.0)
    assert again.capacity_ratio < once.capacity_ratio
    batch = damaged.evaluate_batch("lorry_8t", velocity=[8.0, 2.0])
    assert batch["capacity_ratio"][0] == again.capacity_ratio
    with pytest.raises(ParameterError, match="found one of another"):
        steel.with_changes(top__load=1e5).after(result)
    with pytest.raises(ParameterError, match="found both"):
        steel.after(result, velocity=3.0)
    with pytest.raises(SimulationError, match="does not stand"):
        steel.after(vehicle="lorry_8t", velocity=25.0)

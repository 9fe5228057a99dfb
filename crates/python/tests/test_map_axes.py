"""Maps over more than two quantities: the cells of single impacts, planes, parts, data sets, and what is not accepted."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from column_twin import Action, Column, IncompleteWarning, Map, ParameterError, ParameterWarning, Range


@pytest.fixture(scope="module")
def four(steel: Column) -> Map:
    """A map over four quantities, whose axes are not given in the order of the arrays."""
    return steel.map(velocity=Range(2, 12, points=3), top__load=[2e5, 6e5], mass=[1500.0, 2500.0], vehicle=["van", "mid_car"])


def test_every_cell_of_four_axes_is_that_of_a_single_impact(steel: Column, four: Map) -> None:
    assert [axis.name for axis in four.axes] == ["top.load", "vehicle", "mass", "velocity"]
    assert four.cells.shape == (2, 2, 2, 3) and not four.failures
    for row, load in enumerate([2e5, 6e5]):
        column = steel.with_changes(top__load=load)
        for place, vehicle in enumerate(["van", "mid_car"]):
            expected = column.evaluate_batch(vehicle, mass=np.array([[1500.0], [2500.0]]), velocity=np.array([2.0, 7.0, 12.0]))
            for field in four.cells.dtype.names or ():
                assert four[field][row, place].tobytes() == np.ascontiguousarray(expected[field]).tobytes(), field


def test_an_axis_in_front_and_a_row_have_the_same_bits(steel: Column) -> None:
    axes: Any = {"section": ["HEB 220", "HEB 300"], "velocity": [4.0, 8.0, 12.0], "vehicle": "van"}
    cube = steel.map(**axes, height=[0.8, 1.0])
    assert [axis.name for axis in cube.axes] == ["section", "height", "velocity"]
    plane = steel.with_changes(section__name="HEB 300").map(height=[0.8, 1.0], velocity=[4.0, 8.0, 12.0], vehicle="van")
    assert plane.cells.tobytes() == cube.at(section="HEB 300").cells.tobytes()
    one = steel.map(**axes, compare={"height": [0.8, 1.0]})
    assert np.array_equal(one["max_v1"], np.moveaxis(cube["max_v1"], 1, 0))


def test_a_data_set_has_as_many_dimensions_as_the_map_has_axes(four: Map, steel: Column) -> None:
    pytest.importorskip("xarray")
    data = four.to_xarray()
    assert dict(data.sizes) == {"top_load": 2, "vehicle": 2, "mass": 2, "velocity": 3}
    units = {name: data[name].attrs["units"] for name in data.dims}
    assert units == {"top_load": "N", "vehicle": "1", "mass": "kg", "velocity": "m/s"}
    assert data.max_v1.attrs["units"] == "m"
    cell = float(data.max_v1.sel(top_load=6e5, vehicle="mid_car", mass=2500.0, velocity=7.0))
    assert cell == steel.with_changes(top__load=6e5).evaluate("mid_car", mass=2500.0, velocity=7.0).max_v1
    # Of a plane the chosen values are coordinates without a dimension.
    plane = four.at(top__load=6e5).to_xarray()
    assert float(plane.coords["top_load"]) == 6e5 and dict(plane.sizes) == {"vehicle": 2, "mass": 2, "velocity": 3}
    compared = steel.map(top__load=[2e5, 6e5], height=[0.8, 1.0], velocity=[4.0, 8.0], compare={"section": ["HEB 220", "HEB 300"]})
    assert dict(compared.to_xarray().sizes) == {"section": 2, "top_load": 2, "height": 2, "velocity": 2}
    assert compared.labels == ["HEB220", "HEB300"]


def test_a_table_has_a_column_for_every_axis(four: Map) -> None:
    pytest.importorskip("pandas")
    table = four.to_pandas()
    assert len(table) == 24 and list(table.columns[:5]) == ["label", "top.load", "vehicle", "mass", "velocity"]
    heavy = table[(table["top.load"] == 6e5) & (table["vehicle"] == "van")]
    assert heavy["max_v1"].tolist() == four["max_v1"][1, 0].reshape(-1).tolist()
    # Of a plane the chosen values were lost.
    plane = four.at(top__load=6e5, vehicle="van").to_pandas()
    assert list(plane.columns[:5]) == ["label", "mass", "velocity", "top.load", "vehicle"]
    assert set(plane["top.load"]) == {6e5} and set(plane["vehicle"]) == {"van"}
    assert plane["max_v1"].tolist() == heavy["max_v1"].tolist()


def test_a_figure_of_many_axes_asks_for_a_plane(four: Map) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    with pytest.raises(ParameterError, match=r"shows two axes, and this map has 4; .* map.at\(top__load=200000.0, vehicle='van'\).plot\(\)"):
        four.plot()
    ax = four.at(top__load=200000.0, vehicle="van").plot()
    assert ax.get_title() == "top.load 200000 N, van" and ax.get_ylabel() == "mass of the vehicle [kg]"
    html = four._repr_html_()
    assert html.count("<figure") == 4 and "top.load 600000 N, mid_car" in html
    assert "top.load and vehicle and mass and velocity" in repr(four)


def test_a_plane_is_chosen_by_values_that_the_axis_has(four: Map) -> None:
    plane = four.at({"top.load": 6e5}, vehicle="Mid_Car")
    assert np.array_equal(plane["max_v1"], four["max_v1"][1, 1])
    assert np.array_equal(four.at(vehicle="van").at(top__load=6e5)["max_v1"], four["max_v1"][1, 0])
    cases: list[tuple[dict[str, object], str]] = [
        ({"velocity": 2.0}, "expected one of the further axes, top.load, vehicle; found velocity"),
        ({"top.load": 3e5}, "top.load: expected one of 200000.0, 600000.0; found 300000.0"),
        ({"top.load": True}, "top.load: expected a number, found True"),
        ({"vehicle": "lorry"}, "vehicle: expected one of van, mid_car; found 'lorry'"),
    ]
    for wrong, message in cases:
        with pytest.raises(ParameterError, match=message):
            four.at(wrong)
    with pytest.raises(ParameterError, match="of which there are none; found top.load"):
        plane.at(top__load=6e5)


def test_the_parts_of_a_map_of_four_axes_are_the_whole_map(steel: Column, four: Map) -> None:
    axes: Any = {"velocity": Range(2, 12, points=3), "top__load": [2e5, 6e5], "mass": [1500.0, 2500.0], "vehicle": ["van", "mid_car"]}
    parts = [steel.map(**axes, shard=(number, 5)) for number in (4, 2, 5, 1, 3)]
    assert Map.merged(parts).cells.tobytes() == four.cells.tobytes()
    with pytest.raises(ParameterError, match="put its parts together with Map.merged"):
        parts[0].at(top__load=2e5)
    copied = pickle.loads(pickle.dumps(four))
    assert copied.cells.tobytes() == four.cells.tobytes()


def test_cells_of_further_axes_that_fail_have_their_places(steel: Column) -> None:
    with pytest.warns(IncompleteWarning, match="4 of 8 cells cannot be computed and are masked"):
        damage = steel.map(top__load=[2e5, 1e8], mass=[1500.0, 2500.0], velocity=[2.0, 4.0])
    assert set(damage.failures) == {(1, row, column) for row in (0, 1) for column in (0, 1)}
    assert np.ma.count(damage["max_v1"]) == 4 and (damage["action"] >= Action.NONE).sum() == 4
    assert set(damage.at(top__load=1e8).failures) == {(row, column) for row in (0, 1) for column in (0, 1)}
    assert not damage.at(top__load=2e5).failures


def test_the_fibre_beam_judges_more_than_two_axes(steel: Column) -> None:
    damage = steel.map(direction=[0.0, 0.5], vehicle=["van", "mid_car"], velocity=[4.0, 8.0], model="both")
    assert [axis.name for axis in damage.axes] == ["direction", "vehicle", "velocity"]
    sideways = damage.beam["beam_max_sideways_m"]
    assert sideways.shape == (2, 2, 2)
    one = steel.simulate("mid_car", velocity=8.0, direction=0.5, model="both")
    assert one.beam is not None
    assert sideways[1, 1, 1] == pytest.approx(one.beam["max_sideways_m"], rel=1e-9) and sideways[1, 1, 1] > 0.0
    assert np.array_equal(damage.at(direction=0.5).beam["beam_max_sideways_m"], sideways[1])


def test_a_lorry_of_six_kilograms_among_the_vehicles_of_an_axis_is_told(steel: Column) -> None:
    with pytest.warns(ParameterWarning, match="mass: the smallest one is the mass of a lorry_8t of 6 kg"):
        steel.map(vehicle=["lorry_8t", "van"], mass=[6.0, 1700.0], velocity=[1.0, 2.0])


def test_a_rigid_vehicle_has_the_mass_of_an_axis(steel: Column) -> None:
    """It was rejected, because it has no mass of its own and the vehicle of the column names none."""
    masses, velocities = [1500.0, 2500.0], [3.0, 5.0]
    axes: Any = {"mass": masses, "velocity": velocities}
    assert steel.parameters["impact.mass"] == 0.0 and steel["vehicle.name"] == "mid_car"
    damaged = steel.after(vehicle="lorry_8t", velocity=8.0)
    for column in (steel, damaged):
        several = column.map(vehicle=["rigid", "van"], **axes)
        for place, vehicle in enumerate(["rigid", "van"]):
            expected = column.evaluate_batch(vehicle, mass=np.array([masses]).T, velocity=np.array(velocities))
            one = column.map(vehicle=vehicle, **axes)
            for field in ("max_v1", "action", "capacity_ratio"):
                bits = np.ascontiguousarray(expected[field]).tobytes()
                assert several[field][place].tobytes() == one[field].tobytes() == bits, (vehicle, field)
        compared = column.map(compare={"vehicle": ["rigid", "van"]}, **axes)
        assert compared["max_v1"].tobytes() == several["max_v1"].tobytes()
        with pytest.raises(ParameterError, match="vehicle=rigid: impact.mass is required"):
            column.map(vehicle=["rigid", "van"], velocity=velocities)
        with pytest.raises(ParameterError, match="impact.mass"):
            column.map(vehicle=["rigid", "van"], mass=[-1.0, 1500.0], velocity=velocities)
    # As the rows of a plane, and by the beam.
    plane = steel.map(vehicle=["rigid", "van"], mass=masses, model="both")
    assert plane.cells.shape == (2, 2) and not plane.failures
    assert plane.rows.name == "vehicle"


def test_axes_that_make_no_map_are_rejected(steel: Column) -> None:
    with pytest.raises(ParameterError, match="a map has two axes or more, .* found mass"):
        steel.map(mass=[1500.0, 2500.0])
    with pytest.raises(ParameterError, match="two axes determine the same parameter: section and section.area"):
        steel.map(section=["HEB 220", "HEB 300"], section__area=[1e-2, 2e-2], mass=[1500, 2500], velocity=[2.0, 4.0])
    with pytest.raises(ParameterError, match="top.load x geometry.height make more than 10000 combinations"):
        steel.map(
            top__load=Range(1e5, 5e5, points=200), geometry__height=Range(3, 5, points=200), mass=[1500, 2500], velocity=[2.0, 4.0]
        )
    with pytest.raises(ParameterError, match="top.load: expected the values of an axis, found the number 500000.0"):
        steel.map(mass=[1500, 2500], velocity=[2.0, 4.0], top__load=5e5)  # type: ignore[arg-type]
    # The labels would name masses that no cell has.
    with pytest.raises(ParameterError, match="every vehicle along the axis has its own mass"):
        steel.map(vehicle=["van", "mid_car"], velocity=[2.0, 4.0], compare={"mass": [1500, 2500]})
    with pytest.raises(ParameterError, match=r"refined_map: expected two axes, .* found 3. Give the column one value of top.load, or compare"):
        steel.refined_map(top__load=[2e5, 6e5], mass=[1500, 2500], velocity=Range(1, 15, points=5))


def test_a_damaged_column_is_hit_by_several_vehicles_from_several_directions(steel: Column) -> None:
    damaged = steel.after(vehicle="lorry_8t", velocity=8.0)
    damage = damaged.map(vehicle=["van", "mid_car"], mass=[1500.0, 2500.0], velocity=[3.0, 5.0])
    for place, vehicle in enumerate(["van", "mid_car"]):
        expected = damaged.evaluate_batch(vehicle, mass=np.array([[1500.0], [2500.0]]), velocity=np.array([3.0, 5.0]))
        assert damage["max_v1"][place].tobytes() == np.ascontiguousarray(expected["max_v1"]).tobytes()
    compared = damaged.map(mass=[1500.0, 2500.0], velocity=[3.0, 5.0], compare={"vehicle": ["van", "mid_car"]})
    assert compared["max_v1"].tobytes() == damage["max_v1"].tobytes()
    with pytest.raises(ParameterError, match="top.load cannot vary, because an impact has damaged the column"):
        damaged.map(top__load=[1e5, 2e5], mass=[1500.0, 2500.0], velocity=[3.0, 5.0])

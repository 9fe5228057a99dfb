"""A column that an impact has damaged is hit once more."""

from __future__ import annotations

import json
import pickle
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from column_twin import Action, Column, Outcome, ParameterError, Range, SimulationError

Program = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(scope="module")
def damaged(steel: Column) -> Column:
    """After a lorry at 8 m/s, which bends the column."""
    return steel.after(steel.simulate("lorry_8t", velocity=8.0))


def test_a_second_impact_continues_where_the_first_one_ended(steel: Column, damaged: Column) -> None:
    first = steel.simulate("lorry_8t", velocity=8.0)
    second = damaged.simulate("lorry_8t", velocity=8.0)
    assert first.residual_v1 is not None and first.residual_v1 > 1e-3
    # At rest in the equilibrium that the first one has left, with its plastic rotations.
    assert second.v1[0] == pytest.approx(first.residual_v1, rel=1e-3)
    bumper = 1e-3 * np.abs(first.plastic_rotations[-1]).max()
    assert np.abs(second.plastic_rotations[0] - first.plastic_rotations[-1]).max() < bumper
    assert second.outcome is Outcome.PLASTIC and second.max_v1 > first.max_v1
    # The energy of the impact is found again, by the ledger and by hand.
    report = second.report
    assert abs(report["ledger_residual"]) < 1e-3
    spent = report["plastic_work_j"] + report["impactor_kinetic_energy_j"] + sum(report["vehicle_dissipated_j"])
    assert 0.5 * report["input_energy_j"] < spent <= 1.1 * report["input_energy_j"]
    assert "damaged" in second.title and "the height of the hit" in second.report["range"]["not_varied"]
    assert 0.0 < second.report["error_estimate"] < 0.1


@pytest.mark.parametrize(("vehicle", "velocity"), [("lorry_8t", 6.0), ("mid_car", 10.0), ("mid_car", 1.0), ("lorry_8t", 14.0)])
def test_the_history_of_a_second_impact_has_the_verdict_of_its_evaluation(damaged: Column, vehicle: str, velocity: float) -> None:
    """Both follow the response by code of their own."""
    result, evaluation = damaged.simulate(vehicle, velocity=velocity), damaged.evaluate(vehicle, velocity=velocity)
    assert (result.action, result.outcome) == (evaluation.action, evaluation.outcome)
    assert result.report["deciding_criterion"] == evaluation.deciding_criterion
    assert result.max_v1 == evaluation.max_v1
    assert result.report["peak_contact_force_n"] == evaluation.peak_contact_force
    if result.outcome in (Outcome.ELASTIC, Outcome.PLASTIC):
        assert result.residual_v1 == pytest.approx(evaluation.residual_v1, rel=1e-9)
        assert result.report["capacity_ratio"] == pytest.approx(evaluation.capacity_ratio, rel=1e-9)
    again = damaged.simulate(vehicle, velocity=velocity)
    assert again.v1.tobytes() == result.v1.tobytes()


def test_a_light_second_impact_leaves_what_the_first_one_has_left(root: Path, damaged: Column, program: Program) -> None:
    """The program knows what the first one leaves."""
    config = ("--config", str(root / "config/heb220_s355.yaml"), "--vehicle", "lorry_8t", "--velocity", "8", "--json")
    left = json.loads(program("capacity", "--after-impact", *config).stdout)
    light = damaged.simulate("lorry_8t", velocity=0.3)
    assert light.outcome is Outcome.ELASTIC
    # A hinge fractures in the push-down, which multiplies what the way before the bumper and back changes in the equilibrium.
    for name in ("residual_capacity_n", "capacity_ratio", "reserve"):
        assert light.report[name] == pytest.approx(left[name], rel=5e-3), name
    assert light.action is not None and light.action.name.lower() == left["action"]
    assert damaged.after(light).capacity().force == pytest.approx(left["residual_capacity_n"], rel=5e-3)


def test_the_base_keeps_what_earlier_impacts_have_done_to_it(steel: Column) -> None:
    """A column whose base had failed was whole again for the verdict on a light second impact."""

    def base(report: dict[str, Any]) -> dict[str, float]:
        return {it["name"]: it["value"] for it in report["criteria"] if it["name"].startswith("base_") and it["value"] is not None}

    first = steel.simulate("lorry_8t", velocity=8.0)
    light = steel.after(first).simulate("mid_car", velocity=0.5)
    assert base(first.report)
    for name, value in base(first.report).items():
        assert base(light.report)[name] >= 0.999 * value, name
    assert light.action is not None and first.action is not None and light.action >= first.action
    assert steel.after(first).evaluate("mid_car", velocity=0.5).action == light.action


def test_three_impacts_and_a_pickle(damaged: Column) -> None:
    second = damaged.simulate("lorry_8t", velocity=5.0)
    after_two = damaged.after(second)
    restored = pickle.loads(pickle.dumps(after_two))
    assert restored == after_two and restored.is_damaged
    third, same = (it.simulate("mid_car", velocity=6.0, model="both") for it in (after_two, restored))
    assert third.v1.tobytes() == same.v1.tobytes()
    assert third.action == same.action
    assert {**(third.beam or {}), "solve_time_s": 0} == {**(same.beam or {}), "solve_time_s": 0}
    with pytest.raises(ParameterError, match="expected a result of this column"):
        damaged.after(third)


def test_the_beam_knows_the_earlier_impacts(steel: Column) -> None:
    sideways = {"vehicle": "mid_car", "direction": np.radians(90.0)}
    first = steel.simulate(**sideways, velocity=9.0, model="both")
    second = steel.after(first).simulate(**sideways, velocity=9.0, model="both")
    # The two bars are plane and see nothing of both.
    assert first.outcome is second.outcome is Outcome.ELASTIC
    assert first.beam is not None and second.beam is not None and first.beam["outcome"] == "plastic"
    assert second.beam["residual_bow_m"] > first.beam["residual_bow_m"] > 0.0
    assert not steel.after(vehicle="mid_car", velocity=0.5).is_damaged
    oblique = {"vehicle": "lorry_8t", "direction": np.radians(30.0)}
    hit = steel.simulate(**oblique, velocity=8.0, model="both")
    again = steel.after(hit).simulate(**oblique, velocity=8.0, model="both")
    assert hit.beam is not None and again.beam is not None
    for name in ("residual_sideways_m", "residual_bow_m"):
        assert again.beam[name] > 0.0 and np.isfinite(again.beam[name]), name
    assert again.beam["residual_bow_m"] > hit.beam["residual_bow_m"]
    assert again.beam["residual_capacity_n"] < hit.beam["residual_capacity_n"]
    assert again.beam["undamaged_capacity_n"] == hit.beam["undamaged_capacity_n"]
    assert again.action is not None and hit.action is not None and again.action >= hit.action


def test_an_oblique_second_impact_keeps_the_damage(damaged: Column) -> None:
    oblique = damaged.simulate("mid_car", velocity=8.0, direction=np.radians(60.0))
    straight = damaged.simulate("mid_car", velocity=8.0 * np.cos(np.radians(60.0)), direction=0.0)
    assert oblique.v1[0] == straight.v1[0] != 0.0
    assert oblique.max_v1 == pytest.approx(straight.max_v1, rel=1e-9)
    assert damaged.after(oblique)["impact.direction"] == damaged["impact.direction"]


def test_a_map_of_a_damaged_column_has_its_evaluations(damaged: Column) -> None:
    damage = damaged.map(mass=[1500.0, 3000.0], velocity=[2.0, 6.0, 10.0], vehicle="van")
    expected = damaged.evaluate_batch("van", mass=damage.rows.values[:, None], velocity=damage.columns.values[None, :])
    for field in damage.cells.dtype.names or ():
        assert damage[field].tobytes() == np.ascontiguousarray(expected[field]).tobytes(), field
    vehicles = damaged.map(vehicle=["mid_car", "lorry_8t"], direction=[0.0, 1.0])
    for column, vehicle in enumerate(("mid_car", "lorry_8t")):
        turned = damaged.simulate(vehicle, direction=1.0)
        assert vehicles["max_v1"][1, column] == turned.max_v1
    refined = damaged.refined_map(mass=[6000.0, 8000.0], velocity=Range(1, 15, points=5), vehicle="lorry_8t")
    _, speeds = refined.boundary(Action.EVACUATE)
    assert speeds.size == 2
    assert damaged.evaluate("lorry_8t", mass=6000.0, velocity=1.02 * float(speeds[0])).action is Action.EVACUATE


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda it: it.map(top__load=[1e5, 2e5], velocity=[2.0, 4.0]), "top.load cannot vary, because an impact has damaged the column"),
        (lambda it: it.map(mass=[1e3, 2e3], velocity=[2.0, 4.0], compare={"section": ["HEB 220", "HEB 300"]}), "section cannot vary"),
        (lambda it: it.map(mass=[1e3, 2e3], velocity=[2.0, 4.0], model="both"), "judged by the two bars alone; omit the model both"),
        (lambda it: it.risk("courtyard", 100), "risk: expected an undamaged column.*give them to evaluate_batch"),
        (lambda it: it.with_changes(top__load=1e5), "with_changes: expected an undamaged column.*before its first impact"),
        (lambda it: it.capacity("van"), r"ask column.after\(...\).capacity\(\)"),
        (lambda it: it.report("x.html"), "report: expected an undamaged column.*a node that records"),
        (lambda it: it.sensor_readings("van"), "sensor_readings: expected an undamaged column"),
    ],
)
def test_what_a_damaged_column_has_not_says_what_to_do(damaged: Column, call: Callable[[Column], Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        call(damaged)


def test_a_second_impact_may_be_too_much(damaged: Column) -> None:
    result = damaged.simulate("lorry_8t", velocity=25.0)
    assert result.outcome in (Outcome.COLLAPSED, Outcome.FRACTURED) and result.action is Action.EVACUATE
    with pytest.raises(SimulationError, match="does not stand"):
        damaged.after(result)

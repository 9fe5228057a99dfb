"""Risk studies: those of the command line, equal for equal seeds."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from column_twin import Column, ParameterError, Action

Program = Callable[..., "subprocess.CompletedProcess[str]"]


def test_a_study_is_that_of_the_command_line(root: Path, steel: Column, program: Program) -> None:
    options = {"scenario": "parking_garage", "vehicles-per-day": 2000, "distance": 0.5, "samples": 2000, "seed": 3, "years": 50}
    arguments = [part for name, value in options.items() for part in (f"--{name}", str(value))]
    ran = program("risk", "--config", str(root / "config/heb220_s355.yaml"), "--json", *arguments)
    assert ran.returncode == 0, ran.stderr
    expected = json.loads(ran.stdout)
    risk = steel.risk("parking_garage", 2000, distance=0.5, samples=2000, seed=3, years=50.0)
    assert set(risk.report) <= set(expected)
    # It was a KeyError: the report names only other models.
    assert risk.model == "bars"
    for name, value in risk.report.items():
        assert value == expected[name], name


@pytest.mark.parametrize("model", ["beam", "both"])
def test_a_study_by_the_beam_is_that_of_the_command_line(root: Path, steel: Column, program: Program, model: Any) -> None:
    any_way = "orientation_deg=uniform:-90:90"
    options = {"scenario": "courtyard", "vehicles-per-day": 50, "samples": 40, "seed": 3, "distribution": any_way, "model": model}
    arguments = [part for name, value in options.items() for part in (f"--{name}", str(value))]
    ran = program("risk", "--config", str(root / "config/heb220_s355.yaml"), "--json", *arguments)
    assert ran.returncode == 0, ran.stderr
    expected = json.loads(ran.stdout)
    risk = steel.risk("courtyard", 50, samples=40, seed=3, distributions=[any_way], model=model)
    assert risk.model == expected["model"] == model
    for name, value in risk.report.items():
        assert value == expected[name], name


def test_equal_seeds_give_equal_results_on_any_number_of_threads(steel: Column) -> None:
    def study(seed: int, threads: int) -> dict[str, object]:
        return steel.risk("courtyard", 100, distance=1.0, samples=300, seed=seed, exact=True, threads=threads).report

    assert study(1, 1) == study(1, 2) != study(2, 2)


def test_probabilities_tables_and_figures(steel: Column) -> None:
    risk = steel.risk("courtyard", 500, distance=0.5, samples=500, years=10.0)
    chances = [risk.in_period(it) for it in Action if it is not Action.NONE]
    assert all(chance.low <= chance.value <= chance.high for chance in chances)
    assert [it.value for it in chances] == sorted((it.value for it in chances), reverse=True)
    assert risk.given_impact(Action.INSPECT).value >= risk.in_period(Action.EVACUATE).value
    assert "courtyard" in repr(risk) and "evacuate or worse" in risk._repr_html_()
    with pytest.raises(ValueError, match="from inspect to evacuate"):
        risk.in_period(Action.NONE)
    pytest.importorskip("pandas")
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    assert list(risk.to_pandas().index) == ["inspect", "restrict", "shore", "evacuate"]
    assert risk.plot().get_xlabel()


def test_studies_that_are_not_accepted(steel: Column, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="motorway"):
        steel.risk("motorwy", 100, samples=10)
    with pytest.raises(ParameterError, match="speed_km_h"):
        steel.risk("urban", 100, samples=10, distributions=["speed_km_h=normal:50:-5"])
    for wrong in ({"years": 0.0}, {"confidence": 1.0}, {"samples": 0}, {"threads": 0}):
        with pytest.raises(ParameterError, match=next(iter(wrong))):
            steel.risk("urban", 100, **wrong)
    # One text was a list of its letters.
    with pytest.raises(ParameterError, match="speed_km_h"):
        steel.risk("urban", 100, samples=10, distributions="speed_km_h=normal:50:-5")
    with pytest.raises(ParameterError, match="No such file"):
        steel.risk("mine", 100, scenarios=tmp_path / "missing.json")

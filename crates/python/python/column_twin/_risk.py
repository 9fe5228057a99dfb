"""Risk: how often vehicles that leave the road damage a column, and how severely."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from ._codes import Action

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


class Estimate(NamedTuple):
    """A probability with the interval in which it lies at the confidence level of the study."""

    value: float
    low: float
    high: float

    @classmethod
    def _of(cls, fields: dict[str, float]) -> Estimate:
        return cls(fields["value"], fields["low"], fields["high"])


@dataclass(frozen=True, eq=False)
class Risk:
    """The result of a risk study. docs/risk.md describes the model, the data with their sources, and the intervals."""

    scenario: str
    """Its name."""
    report: dict[str, Any]
    """Everything that `column-twin risk --json` computes from the samples: probabilities, classes, fragility, sensitivity."""

    def _action(self, action: Action) -> dict[str, Any]:
        for row in self.report["actions"]:
            if row["action"] == str(Action(action)):
                found: dict[str, Any] = row
                return found
        raise ValueError(f"expected an action from inspect to evacuate, found {action}")

    def in_period(self, action: Action) -> Estimate:
        """Probability of at least one impact of this action or a higher one in the period of the study."""
        return Estimate._of(self._action(action)["in_period"])

    def given_impact(self, action: Action) -> Estimate:
        """Probability of this action or a higher one given an impact."""
        return Estimate._of(self._action(action)["given_impact"])

    @property
    def model(self) -> str:
        """By which model the samples are judged: `bars`, `beam` or `both`."""
        return str(self.report["model"])

    @property
    def samples(self) -> int:
        """Vehicles that were drawn."""
        return int(self.report["counts"]["samples"])

    def to_pandas(self) -> pd.DataFrame:
        """One row per action: probabilities with their intervals. Needs pandas."""
        import pandas as pd

        rows = []
        for row in self.report["actions"]:
            flat: dict[str, Any] = {"action": row["action"]}
            for kind in ("given_impact", "in_period"):
                flat |= {kind: row[kind]["value"], f"{kind}_low": row[kind]["low"], f"{kind}_high": row[kind]["high"]}
            rows.append(flat)
        return pd.DataFrame(rows).set_index("action")

    def plot(self, ax: Axes | None = None) -> Axes:
        """Fragility of the whole traffic: probability of each action against the speed, with intervals. Needs matplotlib."""
        from . import _figures

        return _figures.fragility(self, ax)

    def __repr__(self) -> str:
        chances = ", ".join(f"{row['action']} {row['in_period']['value']:.2g}" for row in self.report["actions"])
        return f"<Risk {self.scenario}, {self.samples} samples, {self.report['exposure']['years']:g} a: {chances}>"

    def _repr_html_(self) -> str:
        from . import _html

        return _html.risk(self)

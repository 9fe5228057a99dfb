"""Risk: how often vehicles that leave the road damage a column, and how severely."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from ._codes import Action, expect_action

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


class Estimate(NamedTuple):
    """A probability, from 0 to 1, with its interval at the confidence level of the study. The interval contains the scatter of the
    sampling alone."""

    value: float
    """The estimate [-]."""
    low: float
    """The lower end of the interval [-]."""
    high: float
    """The upper end of the interval [-]."""

    @classmethod
    def _of(cls, fields: dict[str, float]) -> Estimate:
        return cls(fields["value"], fields["low"], fields["high"])


@dataclass(frozen=True, eq=False)
class Risk:
    """The result of a risk study, which `Column.risk` computes. docs/risk.md describes the model, the data with their sources, and the
    intervals."""

    scenario: str
    """Name of the scenario."""
    report: dict[str, Any]
    """The fields of `column-twin risk --json` that follow from the samples, such as `actions`, `annual`, `classes`, `fragility` and
    `sensitivity`."""

    def _action(self, action: Action) -> dict[str, Any]:
        name = str(expect_action(action))
        found: dict[str, Any] = next(row for row in self.report["actions"] if row["action"] == name)
        return found

    def in_period(self, action: Action) -> Estimate:
        """Probability that the column has at least one impact with this action, or a more severe one, in the period of the study.

        Raises:
            ParameterError: an action that is not one from INSPECT to EVACUATE.
        """
        return Estimate._of(self._action(action)["in_period"])

    def given_impact(self, action: Action) -> Estimate:
        """Probability that an impact has this action or a more severe one.

        Raises:
            ParameterError: an action that is not one from INSPECT to EVACUATE.
        """
        return Estimate._of(self._action(action)["given_impact"])

    @property
    def model(self) -> str:
        """The model by which the samples are judged: `bars`, `beam` or `both`."""
        # The report names only the others.
        return str(self.report.get("model", "bars"))

    @property
    def samples(self) -> int:
        """Number of vehicles that were drawn."""
        return int(self.report["counts"]["samples"])

    def to_pandas(self) -> pd.DataFrame:
        """A table with one row for each action: `given_impact` and `in_period` with the ends of their intervals, such as `in_period_low`.
        Needs pandas."""
        import pandas as pd

        rows = []
        for row in self.report["actions"]:
            flat: dict[str, Any] = {"action": row["action"]}
            for kind in ("given_impact", "in_period"):
                flat |= {kind: row[kind]["value"], f"{kind}_low": row[kind]["low"], f"{kind}_high": row[kind]["high"]}
            rows.append(flat)
        return pd.DataFrame(rows).set_index("action")

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the fragility of the whole traffic: the probability of each action, given an impact, against the speed at the column
        [km/h], with intervals. Needs matplotlib.

        Args:
            ax: axes to draw on; default: new ones.

        Returns:
            The axes.
        """
        from . import _figures

        return _figures.fragility(self, ax)

    def __repr__(self) -> str:
        chances = ", ".join(f"{row['action']} {row['in_period']['value']:.2g}" for row in self.report["actions"])
        return f"<Risk {self.scenario}, {self.samples} samples, {self.report['exposure']['years']:g} a: {chances}>"

    def _repr_html_(self) -> str:
        from . import _html

        return _html.risk(self)

"""One impact with its history."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from ._codes import Outcome, Action
from ._errors import SimulationError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

HINGES = ("1a", "1b", "2", "3")
"""Below and above the impact point, top, base: the order of every array over hinges."""

_Array = npt.NDArray[np.float64]


class Result:
    """The response of a column to one impact: histories, and the report with capacity, criteria and action.

    Displacements `v` are positive in the direction of travel of the vehicle, `u` positive downwards, and normal forces positive
    in tension. All of them count from the undamaged column without load, also where an earlier impact has damaged it.
    """

    def __init__(self, title: str, history: Mapping[str, _Array], report: Mapping[str, Any]) -> None:
        self.title = title
        """Column and impact in one line."""
        self.history: dict[str, _Array] = dict(history)
        """Every column of `column-twin simulate --csv`, one value per step; the names carry the unit."""
        self.report: dict[str, Any] = dict(report)
        """Everything of `column-twin simulate --json` in SI units; None where there is no value."""

        self._impact: tuple[str | None, float | None, float | None] = (None, None, None)
        self._direction: float | None = None
        self._struck: str | None = None
        """The column, for `Column.after`."""

    def _of_hinges(self, before: str, unit: str) -> _Array:
        return np.column_stack([self.history[f"{before}{hinge}_{unit}"] for hinge in HINGES])

    def _of_springs(self, before: str, unit: str) -> _Array:
        count = len(self.report["crush_max_m"])
        columns = [self.history[f"{before}{number + 1}_{unit}"] for number in range(count)]
        return np.column_stack(columns) if columns else np.empty((self.time.size, 0))

    @property
    def time(self) -> _Array:
        """Time since the event [s]."""
        return self.history["t_s"]

    @property
    def v1(self) -> _Array:
        """Transverse displacement of the impact point [m]."""
        return self.history["v1_m"]

    @property
    def u1(self) -> _Array:
        """Axial displacement of the impact point, down [m]."""
        return self.history["u1_m"]

    @property
    def beta1(self) -> _Array:
        """Rotation of the impact point [rad]."""
        return self.history["beta1_rad"]

    @property
    def u2(self) -> _Array:
        """Axial displacement of the top, down [m]."""
        return self.history["u2_m"]

    @property
    def contact_force(self) -> _Array:
        """Contact force without impact impulses [N]."""
        return self.history["contact_force_N"]

    @property
    def moments(self) -> _Array:
        """Bending moments of the hinges 1a, 1b, 2, 3 [N m], one row per step."""
        return self._of_hinges("M", "Nm")

    @property
    def normal_forces(self) -> _Array:
        """Normal forces of the hinges 1a, 1b, 2, 3 [N], tension positive, one row per step."""
        below, above = self.history["Na_N"], self.history["Nb_N"]
        return np.column_stack([below, above, above, below])

    @property
    def base_forces(self) -> _Array:
        """Shear force [N], moment [N m] and normal force [N], tension positive, on the base, one row per step."""
        columns = ("base_shear_N", "base_moment_Nm", "base_normal_force_N")
        return np.column_stack([self.history[column] for column in columns])

    @property
    def plastic_rotations(self) -> _Array:
        """Plastic rotations of the hinges 1a, 1b, 2, 3 [rad], one row per step."""
        return self._of_hinges("theta_p", "rad")

    @property
    def crush(self) -> _Array:
        """Crush of each spring of the vehicle, front first [m], one row per step; no columns for a rigid vehicle."""
        return self._of_springs("crush", "m")

    @property
    def crush_force(self) -> _Array:
        """Force of each spring of the vehicle, front first [N], one row per step; no columns for a rigid vehicle."""
        return self._of_springs("crush_force", "N")

    @property
    def max_v1(self) -> float:
        """Peak displacement of the impact point [m], also inside of a step."""
        return float(self.report["max_v1_m"])

    @property
    def residual_v1(self) -> float | None:
        """The same in the equilibrium that remains [m]; None if there is none."""
        residual: float | None = self.report["residual_v1_m"]
        return residual

    @property
    def outcome(self) -> Outcome:
        """Whether the column yields, collapses or fractures."""
        return Outcome[self.report["outcome"].upper()]

    @property
    def action(self) -> Action | None:
        """The required action; None if the capacity could not be computed."""
        action = self.report["action"]
        return None if action is None else Action[action.upper()]

    @property
    def criteria(self) -> list[dict[str, Any]]:
        """Every criterion with edition, tag, value, limit, unit, margin, action, and what it says in words."""
        return list(self.report["criteria"] or [])

    @property
    def beam(self) -> dict[str, Any] | None:
        """The result of the fibre beam, the object `beam` of `column-twin simulate --json` in SI units; None with `model="bars"`.

        Raises:
            SimulationError: the beam has no result, with the reason.
        """
        beam = self.report.get("beam")
        if isinstance(beam, str):
            raise SimulationError(beam)
        return None if beam is None else dict(beam)

    def to_pandas(self) -> pd.DataFrame:
        """The history as a table with the time as its index. Needs pandas."""
        import pandas as pd

        return pd.DataFrame(self.history).set_index("t_s")

    def plot(
        self,
        ax: Axes | None = None,
        quantity: Literal["displacement", "force", "moment", "rotation"] = "displacement",
    ) -> Axes:
        """One quantity against time: displacements, forces, moments or plastic rotations of the hinges. Needs matplotlib."""
        from . import _figures

        return _figures.response(self, ax, quantity)

    def plot_all(self) -> list[Axes]:
        """Displacements, forces, moments and plastic rotations against time, in one figure. Needs matplotlib."""
        from . import _figures

        return _figures.overview(self)

    def __repr__(self) -> str:
        residual = "none" if self.residual_v1 is None else f"{1e3 * self.residual_v1:.4g} mm"
        return (
            f"<Result {self.title}: {self.outcome}, {self.action}, peak v1 {1e3 * self.max_v1:.4g} mm, "
            f"residual {residual}>"
        )

    def _repr_html_(self) -> str:
        from . import _html

        return _html.result(self)

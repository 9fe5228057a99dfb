"""One impact with its history."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from ._codes import Outcome, Action
from ._errors import SimulationError
from ._loading import native

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

HINGES = tuple(native.hinges())
"""Below and above the impact point, at the top, and at the base: the order of the columns of every array over hinges."""


class Result:
    """The response of a column to one impact: histories, and the report with capacity, criteria and action. `Column.simulate` makes it.

    Each history has one value, or one row, for each step of the computation. Transverse displacements `v` are positive in the direction
    of travel of the vehicle, axial displacements `u` are positive downwards, and normal forces are positive in tension. Displacements
    and plastic rotations are measured from the undamaged column without load, also where an earlier impact has damaged it.
    """

    title: str
    """Column and impact in one line."""
    history: dict[str, npt.NDArray[np.float64]]
    """The columns of `column-twin simulate --csv` by their names, which end with the unit where there is one. Each array has one value
    for each step, and is read-only."""
    report: dict[str, Any]
    """The fields of `column-twin simulate --json`, in SI units; None where there is no value. docs/glossary.md explains them."""

    def __init__(self, title: str, history: Mapping[str, npt.NDArray[np.float64]], report: Mapping[str, Any]) -> None:
        self.title = title
        self.history = dict(history)
        self.report = dict(report)
        self._impact: tuple[str | None, float | None, float | None, float | None] = (None, None, None, None)
        self._struck: str | None = None
        """The column, for `Column.after`."""

    def _of_hinges(self, before: str, unit: str) -> npt.NDArray[np.float64]:
        return np.column_stack([self.history[f"{before}{hinge}_{unit}"] for hinge in HINGES])

    def _of_springs(self, before: str, unit: str) -> npt.NDArray[np.float64]:
        count = len(self.report["crush_max_m"])
        columns = [self.history[f"{before}{number + 1}_{unit}"] for number in range(count)]
        return np.column_stack(columns) if columns else np.empty((self.time.size, 0))

    @property
    def time(self) -> npt.NDArray[np.float64]:
        """Time since the event, at which the vehicle starts at its initial gap [s]."""
        return self.history["t_s"]

    @property
    def v1(self) -> npt.NDArray[np.float64]:
        """Transverse displacement of the impact point [m]."""
        return self.history["v1_m"]

    @property
    def u1(self) -> npt.NDArray[np.float64]:
        """Axial displacement of the impact point, positive downwards [m]."""
        return self.history["u1_m"]

    @property
    def beta1(self) -> npt.NDArray[np.float64]:
        """Rotation of the impact point [rad]."""
        return self.history["beta1_rad"]

    @property
    def u2(self) -> npt.NDArray[np.float64]:
        """Axial displacement of the top, positive downwards [m]."""
        return self.history["u2_m"]

    @property
    def contact_force(self) -> npt.NDArray[np.float64]:
        """Force between vehicle and column, without impact impulses [N]."""
        return self.history["contact_force_N"]

    @property
    def moments(self) -> npt.NDArray[np.float64]:
        """Bending moments of the hinges 1a, 1b, 2 and 3 [N m], of shape (steps, 4)."""
        return self._of_hinges("M", "Nm")

    @property
    def normal_forces(self) -> npt.NDArray[np.float64]:
        """Normal forces of the hinges 1a, 1b, 2 and 3, positive in tension [N], of shape (steps, 4)."""
        below, above = self.history["Na_N"], self.history["Nb_N"]
        return np.column_stack([below, above, above, below])

    @property
    def base_forces(self) -> npt.NDArray[np.float64]:
        """Shear force [N], moment [N m] and normal force [N] at the base, of shape (steps, 3). The shear force is positive where the base
        holds the column back from the direction of travel, the moment is positive with a positive shear force, and the normal force is
        positive in tension, which lifts the base."""
        columns = ("base_shear_N", "base_moment_Nm", "base_normal_force_N")
        return np.column_stack([self.history[column] for column in columns])

    @property
    def plastic_rotations(self) -> npt.NDArray[np.float64]:
        """Plastic rotations of the hinges 1a, 1b, 2 and 3 [rad], of shape (steps, 4)."""
        return self._of_hinges("theta_p", "rad")

    @property
    def crush(self) -> npt.NDArray[np.float64]:
        """Crush of each spring of the vehicle, beginning at the front [m], of shape (steps, springs); a rigid vehicle has no springs."""
        return self._of_springs("crush", "m")

    @property
    def crush_force(self) -> npt.NDArray[np.float64]:
        """Force of each spring of the vehicle, beginning at the front [N], of shape (steps, springs); a rigid vehicle has no springs."""
        return self._of_springs("crush_force", "N")

    @property
    def max_v1(self) -> float:
        """Peak transverse displacement of the impact point [m], which may lie between two steps."""
        return float(self.report["max_v1_m"])

    @property
    def residual_v1(self) -> float | None:
        """Transverse displacement of the impact point in the static equilibrium after the impact [m]; None if there is no equilibrium."""
        residual: float | None = self.report["residual_v1_m"]
        return residual

    @property
    def outcome(self) -> Outcome:
        """The state in which the response leaves the column."""
        return Outcome[self.report["outcome"].upper()]

    @property
    def action(self) -> Action | None:
        """The action that is required; None if the capacity could not be computed."""
        action = self.report["action"]
        return None if action is None else Action[action.upper()]

    @property
    def criteria(self) -> list[dict[str, Any]]:
        """The criteria of docs/assessment.md, each with `name`, `edition`, `tag`, `value`, `limit`, `unit`, `exceeded`, `action`, and a
        `statement` in words. `margin` is the distance to the limit relative to it, negative where the criterion is exceeded, and `decides`
        is whether the criterion counts for the action. The list is empty if the capacity could not be computed."""
        return list(self.report["criteria"] or [])

    @property
    def beam(self) -> dict[str, Any] | None:
        """The result of the fibre beam, in SI units; None with `model="bars"`. docs/second_opinion.md lists its fields.

        Raises:
            SimulationError: the beam has no result; the text gives the reason.
        """
        beam = self.report.get("beam")
        if isinstance(beam, str):
            raise SimulationError(beam)
        return None if beam is None else dict(beam)

    def to_pandas(self) -> pd.DataFrame:
        """The history as a table: one row for each step, with the time `t_s` [s] as index, and the columns of `history`. Needs pandas."""
        import pandas as pd

        return pd.DataFrame(self.history).set_index("t_s")

    def plot(
        self,
        ax: Axes | None = None,
        quantity: Literal["displacement", "force", "moment", "rotation"] = "displacement",
    ) -> Axes:
        """Draws one quantity against time [ms]. Needs matplotlib.

        Args:
            ax: axes to draw on; default: new ones.
            quantity: `displacement` of the impact point and the top, with the crush of the front [mm]; `force`, the contact force and the
                compression of both bars [kN]; `moment` of the hinges [kN m]; or their plastic `rotation` [mrad].

        Returns:
            The axes.

        Raises:
            ParameterError: another quantity.
        """
        from . import _figures

        return _figures.response(self, ax, quantity)

    def plot_all(self) -> list[Axes]:
        """Draws displacements, forces, moments and plastic rotations against time, in one new figure. Needs matplotlib.

        Returns:
            The four axes, in this order.
        """
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

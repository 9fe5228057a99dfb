"""The residual axial capacity of a column."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._codes import Action

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class PushDown(NamedTuple):
    """A static push-down: the top of the column is lowered until the column carries no more. Each array has one value for each of its
    points, in the order of the shortening, and is read-only; the arrays are empty if the column carries nothing."""

    shortening: npt.NDArray[np.float64]
    """Shortening of the column, from its length without load [m]."""
    force: npt.NDArray[np.float64]
    """Compressive force at the top, without the share of the spring there [N]."""
    v1: npt.NDArray[np.float64]
    """Transverse displacement of the impact point, including the initial bow [m]."""


@dataclass(frozen=True, eq=False)
class Capacity:
    """The axial capacity of a column, undamaged and in its present state, and the action that its load requires. `Column.capacity`
    computes it; docs/assessment.md describes the method."""

    report: dict[str, Any]
    """The fields of `column-twin capacity --json`, in SI units; None where there is no value."""
    push_down: PushDown
    """The push-down of the column in its present state."""

    @property
    def force(self) -> float:
        """Largest force of the push-down of the column in its present state [N], `residual_capacity` of an `Evaluation`. It is too high
        for slender columns; `axial_capacity` takes their buckling into account."""
        return float(self.report["residual_capacity_n"])

    @property
    def undamaged_force(self) -> float:
        """Largest force of the push-down of the undamaged column [N]."""
        return float(self.report["undamaged_capacity_n"])

    @property
    def ratio(self) -> float:
        """`force` over `undamaged_force` [-], `capacity_ratio` of an `Evaluation`."""
        return float(self.report["capacity_ratio"])

    @property
    def axial_capacity(self) -> float:
        """N_u: `ratio` times the buckling resistance of the new column about its strong axis, by EN 1993-1-1, 6.3.1, with
        gamma_M = 1.0 [N]."""
        return float(self.report["axial_capacity_n"])

    @property
    def carried_load(self) -> float:
        """N: the applied load at the top, positive in compression, from which only a proven redistribution is deducted [N]."""
        return float(self.report["carried_load_n"])

    @property
    def reserve(self) -> float | None:
        """`axial_capacity` over `carried_load`, N_u / N [-]; None where there is no compressive load."""
        reserve: float | None = self.report["reserve"]
        return reserve

    @property
    def action(self) -> Action:
        """The action that is required."""
        return Action[self.report["action"].upper()]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the axial force [kN] of the push-down against the displacement of the impact point [mm]. Needs matplotlib.

        Args:
            ax: axes to draw on, also with the curves of other capacities; default: new ones.

        Returns:
            The axes.
        """
        from . import _figures

        return _figures.push_down(self, ax)

    def __repr__(self) -> str:
        return (
            f"<Capacity {self.report['state']}: N_u {1e-3 * self.axial_capacity:.4g} kN, {100 * self.ratio:.3g} % of the undamaged "
            f"column, {self.action}>"
        )

    def _repr_html_(self) -> str:
        from . import _html

        return _html.capacity(self)

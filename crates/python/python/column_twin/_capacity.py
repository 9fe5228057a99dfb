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
    """A static push-down: the column is shortened until it carries no more. Empty if it carries nothing."""

    shortening: npt.NDArray[np.float64]
    """Shortening, counted from the unloaded column [m]."""
    force: npt.NDArray[np.float64]
    """Compressive force at the top, without the share of the spring [N]."""
    v1: npt.NDArray[np.float64]
    """Displacement of the impact point, bow included [m]."""


@dataclass(frozen=True, eq=False)
class Capacity:
    """The axial capacity of a column, undamaged and as it is, and what follows for its load."""

    report: dict[str, Any]
    """Everything under the names of `column-twin capacity --json`, in SI units; None where there is no value."""
    push_down: PushDown
    """The push-down of the column as it is."""

    @property
    def force(self) -> float:
        """Largest force of the push-down of the column as it is [N]; too high for slender columns, see `axial_capacity`."""
        return float(self.report["residual_capacity_n"])

    @property
    def undamaged_force(self) -> float:
        """Largest force of the push-down of the undamaged column [N]."""
        return float(self.report["undamaged_capacity_n"])

    @property
    def ratio(self) -> float:
        """`force` over `undamaged_force` [-]."""
        return float(self.report["capacity_ratio"])

    @property
    def axial_capacity(self) -> float:
        """N_u: `ratio` times the buckling resistance of EN 1993-1-1 about the strong axis [N]."""
        return float(self.report["axial_capacity_n"])

    @property
    def carried_load(self) -> float:
        """The applied load N: the load at the top before any redistribution that is not proven [N]."""
        return float(self.report["carried_load_n"])

    @property
    def reserve(self) -> float | None:
        """N_u / N [-]; None where there is no compressive load."""
        reserve: float | None = self.report["reserve"]
        return reserve

    @property
    def action(self) -> Action:
        """The required action."""
        return Action[self.report["action"].upper()]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Force against displacement of the impact point. Needs matplotlib."""
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

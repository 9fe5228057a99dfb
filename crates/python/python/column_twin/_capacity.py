"""The remaining axial capacity of a column."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._codes import Severity

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
    """The axial capacity of a column, virgin and as it is, and what follows for its load."""

    report: dict[str, Any]
    """Everything under the names of `column-twin capacity --json`, in SI units; None where there is no value."""
    push_down: PushDown
    """The push-down of the column as it is."""

    @property
    def force(self) -> float:
        """N_u of the column as it is [N]."""
        return float(self.report["residual_capacity_n"])

    @property
    def virgin_force(self) -> float:
        """N_u of the virgin column [N]."""
        return float(self.report["virgin_capacity_n"])

    @property
    def ratio(self) -> float:
        """`force` over `virgin_force` [-]."""
        return float(self.report["capacity_ratio"])

    @property
    def carried_load(self) -> float:
        """Load that the column carries, N_Ed [N]."""
        return float(self.report["carried_load_n"])

    @property
    def reserve(self) -> float | None:
        """N_u / N_Ed [-]; None where the column carries no compressive force."""
        reserve: float | None = self.report["reserve"]
        return reserve

    @property
    def severity(self) -> Severity:
        """What has to be done."""
        return Severity[self.report["severity"].upper()]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Force against displacement of the impact point. Needs matplotlib."""
        from . import _figures

        return _figures.push_down(self, ax)

    def __repr__(self) -> str:
        return (
            f"<Capacity {self.report['state']}: N_u {1e-3 * self.force:.4g} kN, {100 * self.ratio:.3g} % of the virgin "
            f"column, {self.severity}>"
        )

    def _repr_html_(self) -> str:
        from . import _html

        return _html.capacity(self)

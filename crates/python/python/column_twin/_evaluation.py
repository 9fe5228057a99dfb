"""One impact reduced to the numbers that a study compares, and arrays of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ._codes import CRITERIA, Action, Outcome
from ._loading import native

if TYPE_CHECKING:
    import pandas as pd

# The order is that of `Row` in src/batch.rs.
_NUMBERS = (
    "mass",
    "velocity",
    "max_v1",
    "residual_v1",
    "peak_contact_force",
    "residual_capacity",
    "capacity_ratio",
    "reserve",
    "max_plastic_rotation",
)
# Of sizes that leave no gap: the bytes of two equal batches are equal.
_CODES = (("action", np.uint16), ("outcome", np.uint16), ("deciding_criterion", np.uint32))

CATEGORIES: dict[str, list[str]] = {
    "action": [str(it) for it in Action],
    "outcome": [str(it) for it in Outcome],
    "deciding_criterion": list(CRITERIA),
}
"""The words for the codes of a batch."""

EVALUATION: np.dtype[np.void] = np.dtype(
    [*((name, np.float64) for name in _NUMBERS), *_CODES], align=True
)
"""Type of the rows of a batch: the fields of `Evaluation` in SI units, NaN where there is none; `action` and `outcome` are
numbers of `Action` and `Outcome`, `deciding_criterion` is a place in `CRITERIA`."""

CELL: np.dtype[np.void] = np.dtype([*((name, np.float64) for name in _NUMBERS[2:]), *_CODES], align=True)
"""Type of the cells of a map: the same without mass and velocity, which its axes tell."""

UNITS: dict[str, str] = {
    "mass": "kg",
    "velocity": "m s-1",
    "max_v1": "m",
    "residual_v1": "m",
    "peak_contact_force": "N",
    "residual_capacity": "N",
    "capacity_ratio": "1",
    "reserve": "1",
    "max_plastic_rotation": "rad",
}
"""The unit of each number."""

for _found, _expected in ((EVALUATION.itemsize, native.ROW_BYTES), (CELL.itemsize, native.CELL_BYTES)):
    if _found != _expected:
        raise ImportError(f"column_twin is inconsistent: rows of {_found} bytes, expected {_expected}")


@dataclass(frozen=True)
class Evaluation:
    """The effects of one impact that a study compares. SI units."""

    mass: float
    """Total mass of the vehicle [kg]."""
    velocity: float
    """Its speed [m/s]."""
    max_v1: float
    """Peak displacement of the impact point [m]."""
    residual_v1: float
    """The same in the equilibrium that remains [m]; NaN if there is none."""
    peak_contact_force: float
    """Largest contact force [N]."""
    residual_capacity: float
    """Largest force of the push-down [N]; 0 if the column carries nothing."""
    capacity_ratio: float
    """This force over that of the undamaged column [-]."""
    reserve: float
    """N_u over the applied load N [-], see `Capacity`; NaN where there is no compressive load."""
    max_plastic_rotation: float
    """Largest plastic rotation of a hinge [rad]."""
    action: Action
    """The required action."""
    outcome: Outcome
    """Whether the column yields, collapses or fractures."""
    deciding_criterion: str
    """Name of the criterion that decides."""

    @classmethod
    def _of(cls, numbers: list[float], codes: list[int]) -> Evaluation:
        mass, velocity, max_v1, residual_v1, force, capacity, ratio, reserve, rotation = numbers
        action, outcome, criterion = codes
        return cls(
            mass=mass,
            velocity=velocity,
            max_v1=max_v1,
            residual_v1=residual_v1,
            peak_contact_force=force,
            residual_capacity=capacity,
            capacity_ratio=ratio,
            reserve=reserve,
            max_plastic_rotation=rotation,
            action=Action(action),
            outcome=Outcome(outcome),
            deciding_criterion=CRITERIA[criterion],
        )

    def __repr__(self) -> str:
        return (
            f"<Evaluation {self.mass:g} kg at {self.velocity:g} m/s: {self.action} ({self.deciding_criterion}), "
            f"{self.outcome}, peak v1 {1e3 * self.max_v1:.4g} mm, capacity {100 * self.capacity_ratio:.3g} %>"
        )

    def _repr_html_(self) -> str:
        from . import _html

        return _html.evaluation(self)


def table_of(rows: bytearray) -> npt.NDArray[np.void]:
    """The rows of a batch as a structured array, without a copy."""
    return np.frombuffer(rows, dtype=EVALUATION)


def to_pandas(evaluations: npt.NDArray[np.void]) -> pd.DataFrame:
    """A batch as a table with one row per impact; action, outcome and criterion become words. Needs pandas.

    >>> table = to_pandas(Column().evaluate_batch([1500.0, 2500.0], 10.0))
    >>> table.groupby("action", observed=True)["max_v1"].max()
    """
    import pandas as pd

    flat = evaluations.reshape(-1)
    table = pd.DataFrame({name: flat[name] for name in _NUMBERS})

    for name, names in CATEGORIES.items():
        words = pd.Index(names)
        table[name] = pd.Categorical.from_codes(flat[name].tolist(), words, ordered=name == "action")
    return table

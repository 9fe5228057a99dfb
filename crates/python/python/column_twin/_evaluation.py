"""One impact reduced to the numbers that a study compares, and arrays of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ._codes import CRITERIA, Action, Outcome
from ._errors import ParameterError
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
"""The words of the codes in a batch or a map, each at the place of its code."""

EVALUATION: np.dtype[np.void] = np.dtype(
    [*((name, np.float64) for name in _NUMBERS), *_CODES], align=True
)
"""The structured type of the rows of a batch: the fields of `Evaluation` in SI units, NaN where there is no value. `action` and
`outcome` are the numbers of `Action` and `Outcome`, and `deciding_criterion` is a place in `CRITERIA`."""

CELL: np.dtype[np.void] = np.dtype([*((name, np.float64) for name in _NUMBERS[2:]), *_CODES], align=True)
"""The structured type of the cells of a map: the same without mass and velocity, which are on its axes or the same in all cells."""

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
"""The unit of each number, in the notation of UDUNITS."""

for _found, _expected in ((EVALUATION.itemsize, native.ROW_BYTES), (CELL.itemsize, native.CELL_BYTES)):
    if _found != _expected:
        raise ImportError(f"column_twin is inconsistent: rows of {_found} bytes, expected {_expected}")


@dataclass(frozen=True)
class Evaluation:
    """One impact by the two bars, without its history: the effects that a study compares. `Column.evaluate` computes it. All units are
    SI; docs/glossary.md explains the terms."""

    mass: float
    """Total mass of the vehicle [kg]."""
    velocity: float
    """Speed of the vehicle over the ground [m/s], also where it travels out of the plane of the two bars."""
    max_v1: float
    """Peak transverse displacement of the impact point, from the undamaged column [m]."""
    residual_v1: float
    """Transverse displacement of the impact point in the static equilibrium after the impact [m]; NaN if there is no equilibrium."""
    peak_contact_force: float
    """Largest contact force, without impact impulses [N]."""
    residual_capacity: float
    """Largest force of a push-down after the impact [N]; 0 if the column carries nothing."""
    capacity_ratio: float
    """`residual_capacity` over the largest force of a push-down of the undamaged column [-]."""
    reserve: float
    """N_u over the applied load N [-], see `Capacity.reserve`; NaN where there is no compressive load."""
    max_plastic_rotation: float
    """Largest absolute plastic rotation of a hinge [rad]; hinges 1a and 1b, which are at one place, count together."""
    action: Action
    """The action that is required."""
    outcome: Outcome
    """The state in which the response leaves the column."""
    deciding_criterion: str
    """Name of the criterion from which the action follows, one of `CRITERIA`."""

    @classmethod
    def _of(cls, velocity: float, numbers: list[float], codes: bytes) -> Evaluation:
        # The native part has the component of the velocity in the plane of the two bars.
        mass, _, max_v1, residual_v1, force, capacity, ratio, reserve, rotation = numbers
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
    """A batch as a table. Needs pandas.

    >>> table = to_pandas(Column().evaluate_batch("van", mass=[1500.0, 2500.0], velocity=10.0))
    >>> table.groupby("action", observed=True)["max_v1"].max()

    Args:
        evaluations: an array of the type `EVALUATION` from `Column.evaluate_batch`, of any shape; a map has `Map.to_pandas`.

    Returns:
        One row for each impact, in the order of the flattened array, and one column for each field, in SI units. Action, outcome and
        criterion are categories of words, and the actions are ordered.

    Raises:
        ParameterError: an array of another type.
    """
    if getattr(evaluations, "dtype", None) != EVALUATION:
        raise ParameterError("to_pandas: expected an array from evaluate_batch; a map and a result have a method to_pandas of their own")
    import pandas as pd

    flat = evaluations.reshape(-1)
    table = pd.DataFrame({name: flat[name] for name in _NUMBERS})

    for name, names in CATEGORIES.items():
        words = pd.Index(names)
        table[name] = pd.Categorical.from_codes(flat[name].tolist(), words, ordered=name == "action")
    return table

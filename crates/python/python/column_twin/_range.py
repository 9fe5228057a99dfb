"""The values of an axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ._errors import ParameterError


@dataclass(frozen=True)
class Range:
    """Numbers at equal distances; both ends are among them.

    >>> column.map(velocity=Range(1, 25, points=50), mass=[1500, 2000, 2500])
    """

    first: float
    """The smallest number."""
    last: float
    """The largest number."""
    points: int
    """How many numbers, at least 2."""

    def __post_init__(self) -> None:
        whole = isinstance(self.points, (int, np.integer)) and not isinstance(self.points, bool)
        if not whole or self.points < 2:
            raise ParameterError(f"Range: expected points, a whole number of at least 2; found {self.points!r}")


AxisNumbers = Union[Range, Sequence[float], npt.NDArray[Any], str]
"""Numbers of an axis: a range, the numbers themselves, or a text in the notation of the command line (`1:25:50`)."""

AxisNames = Union[Sequence[str], npt.NDArray[Any], str]
"""Names of a catalogue."""

AxisValues = Union[AxisNumbers, AxisNames]
"""The values of an axis."""

NativeAxis = Union[str, "tuple[str, float, float, int]", "tuple[str, list[float]]", "tuple[str, list[str]]"]


def native_axis(name: str, values: AxisValues) -> NativeAxis:
    """An axis for the native part."""
    if isinstance(values, str):
        return f"{name}={values}"
    if isinstance(values, Range):
        return name, float(values.first), float(values.last), int(values.points)
    if isinstance(values, tuple) and len(values) == 3 and not any(isinstance(it, str) for it in values):
        first, last, count = values
        raise ParameterError(
            f"{name}: expected a Range or a list, found the tuple {values!r}; write Range({first!r}, {last!r}, points={count!r}) "
            f"for that many numbers from {first!r} to {last!r}, or [{first!r}, {last!r}, {count!r}] for these three"
        )
    plain: list[Any] = values.tolist() if isinstance(values, np.ndarray) else list(values)
    if plain and all(isinstance(it, str) for it in plain):
        return name, [str(it) for it in plain]
    numbers = [float(it) for it in plain]
    for index, number in enumerate(numbers):
        if not np.isfinite(number):
            raise ParameterError(f"{name}: element {index} is {number}; expected finite numbers")
    return name, numbers

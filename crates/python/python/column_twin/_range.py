"""The values of an axis."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
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

def expect_numbers(given: Mapping[str, object]) -> None:
    """Neither a truth value, which Python counts as 0 or 1, nor a masked one, which is NaN: nobody means them as numbers."""
    for name, value in given.items():
        # Most are floats, which need no further look.
        if type(value) is not float and (isinstance(value, (bool, np.bool_)) or value is np.ma.masked):
            raise ParameterError(f"{name}: expected a number, found {value}")


def _elements(given: Iterable[object]) -> Iterator[object]:
    """The elements of lists and arrays in one another, in their order."""
    for it in given:
        if isinstance(it, (list, tuple)):
            yield from _elements(it)
        elif isinstance(it, np.ndarray) and it is not np.ma.masked:
            yield from _elements(it.flat)
        else:
            yield it


def numbers(name: str, given: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """An array of numbers, of which none is masked and none a truth value."""
    if isinstance(given, np.ma.MaskedArray):
        masked = np.flatnonzero(np.ma.getmaskarray(given))
        if masked.size:
            raise ParameterError(
                f"{name}: element {masked[0]} is masked; expected numbers without a mask, such as those of {name}.compressed()"
            )
    # Most lists hold numbers alone, which need no further look.
    looked_into = (bool, np.bool_, list, tuple, np.ndarray)
    if isinstance(given, (list, tuple)) and any(issubclass(it, looked_into) for it in set(map(type, given))):
        for index, found in enumerate(_elements(given)):
            # In an array they would be 0, 1 and NaN.
            if isinstance(found, (bool, np.bool_)) or found is np.ma.masked:
                word = "masked" if found is np.ma.masked else found
                raise ParameterError(f"{name}: element {index} is {word}; expected numbers")
    array = np.asarray(given)
    if array.dtype == np.bool_ and array.size:
        raise ParameterError(f"{name}: element 0 is {array.flat[0]}; expected numbers")
    return np.asarray(array, dtype=np.float64)


NativeAxis = Union[str, "tuple[str, float, float, int]", "tuple[str, list[float]]", "tuple[str, list[str]]"]


def native_axis(name: str, values: AxisValues) -> NativeAxis:
    """An axis for the native part."""
    if isinstance(values, str):
        return f"{name}={values}"
    if isinstance(values, Range):
        return name, float(values.first), float(values.last), int(values.points)
    if isinstance(values, Real):
        raise ParameterError(
            f"{name}: expected the values of an axis, found the number {values}; give two or more, or give the column this one value"
        )
    if isinstance(values, tuple) and len(values) == 3 and not any(isinstance(it, str) for it in values):
        first, last, count = values
        raise ParameterError(
            f"{name}: expected a Range or a list, found the tuple {values!r}; write Range({first!r}, {last!r}, points={count!r}) "
            f"for that many numbers from {first!r} to {last!r}, or [{first!r}, {last!r}, {count!r}] for these three"
        )
    if isinstance(values, np.ndarray) and values.dtype.kind in "biuf":
        values = numbers(name, values)
    plain: list[Any] = values.tolist() if isinstance(values, np.ndarray) else list(values)
    if plain and all(isinstance(it, str) for it in plain):
        return name, [str(it) for it in plain]
    for index, it in enumerate(plain):
        if isinstance(it, (bool, np.bool_)) or not np.isfinite(float(it)):
            raise ParameterError(f"{name}: element {index} is {it}; expected finite numbers")
    return name, [float(it) for it in plain]

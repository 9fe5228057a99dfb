"""The values of an axis, and checks of numbers and arrays."""

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
    """The values of an axis of a map at equal distances, including both ends, in the SI unit of the quantity.

    >>> column.map(velocity=Range(1, 25, points=50), mass=[1500, 2000, 2500])

    Raises:
        ParameterError: an end that is not a number, or a number of points that is not a whole number of at least 2. A map also
            rejects ends that are not finite, and a first number that is not smaller than the last one.
    """

    first: float
    """The first and smallest number."""
    last: float
    """The last and largest number."""
    points: int
    """The number of values, at least 2."""

    def __post_init__(self) -> None:
        expect_numbers({"Range: first": self.first, "Range: last": self.last})
        whole = isinstance(self.points, (int, np.integer)) and not isinstance(self.points, bool)
        if not whole or self.points < 2:
            raise ParameterError(f"Range: expected points, a whole number of at least 2; found {self.points!r}")


AxisNumbers = Union[Range, Sequence[float], npt.NDArray[Any], str]
"""The numbers of an axis in the SI unit of its quantity: a range, the numbers in ascending order, or a text in the notation of the
command line, such as `1:25:50` for 50 numbers from 1 to 25, or `5,10,15`."""

AxisNames = Union[Sequence[str], npt.NDArray[Any], str]
"""The names of an axis of sections or vehicles: a list of names, or a text such as `HEB 220,HEB 300`."""

AxisValues = Union[AxisNumbers, AxisNames]
"""The values of an axis: numbers, or names of a catalogue."""


def _is_number(value: object) -> bool:
    """Whether a value can be meant as a number: neither a truth value, which Python counts as 0 or 1, nor a masked one, which is NaN,
    nor a text, a date or an array."""
    if isinstance(value, (bool, np.bool_)) or value is np.ma.masked:
        return False
    if isinstance(value, (Real, np.generic)):
        return isinstance(value, Real)
    return hasattr(value, "__float__") and np.ndim(value) == 0  # type: ignore[arg-type]


def _word(value: object) -> str:
    """A value as an error names it."""
    if value is np.ma.masked:
        return "masked"
    return repr(value.item() if isinstance(value, np.generic) else value)


def expect_numbers(given: Mapping[str, object]) -> None:
    """Expects a number or None under each name."""
    for name, value in given.items():
        # Most are floats, which need no further look.
        if type(value) is not float and value is not None and not _is_number(value):
            raise ParameterError(f"{name}: expected a number, found {_word(value)}")


def _elements(given: Iterable[object]) -> Iterator[object]:
    """The elements of lists and arrays in one another, in their order."""
    for it in given:
        if isinstance(it, (list, tuple)):
            yield from _elements(it)
        elif isinstance(it, np.ndarray) and it is not np.ma.masked:
            yield from _elements(it.flat)
        else:
            yield it


def _expect_elements(name: str, elements: Iterable[object]) -> None:
    for index, found in enumerate(elements):
        if not _is_number(found):
            raise ParameterError(f"{name}: element {index} is {_word(found)}; expected numbers")


def numbers(name: str, given: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """An array of numbers, of which none is masked, a truth value or a text."""
    if isinstance(given, np.ma.MaskedArray):
        masked = np.flatnonzero(np.ma.getmaskarray(given))
        if masked.size:
            raise ParameterError(
                f"{name}: element {masked[0]} is masked; expected numbers without a mask, such as those of {name}.compressed()"
            )
    # Most lists hold numbers alone, which need no further look.
    looked_into = (bool, np.bool_, str, list, tuple, np.ndarray)
    if isinstance(given, (list, tuple)) and any(issubclass(it, looked_into) for it in set(map(type, given))):
        # In an array they would be 0, 1, NaN and texts.
        _expect_elements(name, _elements(given))
    try:
        array = np.asarray(given)
    except ValueError as reason:
        raise ParameterError(f"{name}: expected an array of numbers; {reason}") from reason
    if array.dtype.kind in "fiu":
        return np.asarray(array, dtype=np.float64)
    # numpy would turn texts, dates and truth values into numbers.
    _expect_elements(name, array.flat)
    return np.asarray(array, dtype=np.float64)


NativeAxis = Union[str, "tuple[str, float, float, int]", "tuple[str, list[float]]", "tuple[str, list[str]]"]


def native_axis(name: str, values: AxisValues) -> NativeAxis:
    """An axis for the native part."""
    if isinstance(values, str):
        return f"{name}={values}"
    if isinstance(values, Range):
        return name, float(values.first), float(values.last), int(values.points)
    if isinstance(values, Real) or (isinstance(values, np.ndarray) and values.ndim == 0):
        raise ParameterError(
            f"{name}: expected the values of an axis, found the number {values}; give two or more, or give the column this one value"
        )
    if isinstance(values, tuple) and len(values) == 3 and not any(isinstance(it, str) for it in values):
        first, last, count = values
        raise ParameterError(
            f"{name}: expected a Range or a list, found the tuple {values!r}; write Range({first!r}, {last!r}, points={count!r}) "
            f"for that many numbers from {first!r} to {last!r}, or [{first!r}, {last!r}, {count!r}] for these three"
        )
    if not isinstance(values, Iterable):
        raise ParameterError(f"{name}: expected a Range, or a list or an array of values; found {values!r}")
    if isinstance(values, np.ndarray) and values.dtype.kind in "biuf":
        values = numbers(name, values)
    plain: list[Any] = values.tolist() if isinstance(values, np.ndarray) else list(values)
    if plain and all(isinstance(it, str) for it in plain):
        return name, [str(it) for it in plain]
    for index, it in enumerate(plain):
        if not _is_number(it) or not np.isfinite(float(it)):
            raise ParameterError(f"{name}: element {index} is {_word(it)}; expected finite numbers")
    return name, [float(it) for it in plain]

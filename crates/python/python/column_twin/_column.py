"""A column."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ._capacity import Capacity, PushDown
from ._codes import Action
from ._errors import ColumnTwinError, ParameterError, ParameterWarning
from ._loading import native
from ._map import CriticalVelocity, Map
from ._result import Result
from ._risk import Risk
from ._evaluation import Evaluation, table_of

Value = Union[bool, int, float, str, Sequence[float], Sequence[str]]
"""The value of a parameter."""

Setting = Union[Value, npt.NDArray[Any], np.generic, "os.PathLike[str]"]
"""What a parameter may be set to: a value, or what numpy or pathlib make of one."""


AxisValues = Union["tuple[float, float, int]", Sequence[float], Sequence[str], npt.NDArray[Any], str]
"""The values of an axis: (from, to, number of points), numbers, or names."""

_NativeAxis = Union[str, "tuple[str, float, float, int]", "tuple[str, list[float]]", "tuple[str, list[str]]"]


def _axis(name: str, values: AxisValues) -> _NativeAxis:
    """An axis for the native part."""
    if isinstance(values, str):
        return f"{name}={values}"
    if isinstance(values, tuple) and len(values) == 3 and not any(isinstance(it, str) for it in values):
        first, last, count = values
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 0:
            raise ParameterError(f"{name}: expected (from, to, number of points); found {values}")
        return name, float(first), float(last), int(count)
    plain = [_plain(it) for it in values]
    if plain and all(isinstance(it, str) for it in plain):
        return name, [str(it) for it in plain]
    return name, [float(it) for it in plain]


def _plain(value: Any) -> Any:
    """A value of numpy or a path as the plain value that it holds."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return value


def _changes(changes: Mapping[str, Setting] | None, overrides: Mapping[str, Setting]) -> list[tuple[str, Any]]:
    """Names with dots from both notations; keywords come last and win."""
    given = list((changes or {}).items()) + [(name.replace("__", "."), it) for name, it in overrides.items()]
    return [(name, _plain(value)) for name, value in given]


class Column:
    """A steel column that a vehicle may hit: an undamaged column with its parameters, which never changes.

    Every parameter of docs/parameters.md has a default. A dot in its name is two underscores in a keyword; a mapping takes the
    names as they are:

    >>> Column(section__name="HEB 300", top__load=8e5)
    >>> Column({"section.name": "HEB 300", "top.load": 8e5})

    All units are SI.

    Raises:
        ParameterError: names or values that are not accepted, all faults at once.
    """

    __slots__ = ("_native",)

    def __init__(self, changes: Mapping[str, Setting] | None = None, /, **overrides: Setting) -> None:
        self._native = self._load([], changes, overrides)

    @classmethod
    def from_file(
        cls,
        *files: str | os.PathLike[str],
        changes: Mapping[str, Setting] | None = None,
        **overrides: Setting,
    ) -> Column:
        """The column of one or more parameter files (ROS 2 YAML), of which later ones win, changed by `changes` and `overrides`.

        >>> Column.from_file("config/heb220_s355.yaml", top__load=6e5)

        Raises:
            ParameterError: a file that cannot be read, or names or values that are not accepted, with line and column.
        """
        return cls._of(cls._load([os.fspath(file) for file in files], changes, overrides))

    @staticmethod
    def _load(files: list[str], changes: Mapping[str, Setting] | None, overrides: Mapping[str, Setting]) -> native.Column:
        column, found = native.Column.load(files, _changes(changes, overrides))
        for text in found:
            warnings.warn(text, ParameterWarning, stacklevel=3)
        return column

    @classmethod
    def _of(cls, column: native.Column) -> Column:
        new = cls.__new__(cls)
        new._native = column
        return new

    def with_changes(self, changes: Mapping[str, Setting] | None = None, /, **overrides: Setting) -> Column:
        """This column with other values of some parameters: all changes or none.

        >>> heavier = column.with_changes(section__name="HEB 260")
        """
        return self._of(self._native.with_changes(_changes(changes, overrides)))

    def __getitem__(self, name: str) -> Value:
        """The value of a parameter: `column["top.load"]`."""
        value: Value | None = self._native.get(name)
        if value is None:
            # The same text as for a change of a parameter that does not exist.
            self._native.with_changes([(name, 0.0)])
            raise KeyError(name)
        return value

    @property
    def parameters(self) -> dict[str, Value]:
        """Every parameter with its value, in the order of docs/parameters.md."""
        return {name: value for name, value, _, _ in self._native.describe()}

    def describe(self) -> list[tuple[str, Value, str, str]]:
        """Name, value, unit and meaning of every parameter."""
        return self._native.describe()

    @property
    def step(self) -> float:
        """Length of a time step [s]."""
        return self._native.derived()[0]

    @property
    def resistance_moment(self) -> float:
        """Plastic moment M^p [N m]."""
        return self._native.derived()[1]

    @property
    def resistance_axial(self) -> float:
        """Squash load N^p [N]."""
        return self._native.derived()[2]

    def simulate(self, vehicle: str | None = None, mass: float | None = None, velocity: float | None = None) -> Result:
        """One impact on the undamaged column with histories and report.

        The response itself takes milliseconds. The report takes three more responses, which tell the error of the step and the
        influence of hardening, and two push-downs.

        Args:
            vehicle: `rigid`, or a name of `vehicles()`; default: the parameter `vehicle.name`.
            mass: total mass of the vehicle [kg]; default: with `vehicle` its own mass, otherwise the parameter `impact.mass`.
            velocity: speed towards the column [m/s]; default: the parameter `impact.velocity`.

        Raises:
            ParameterError: an impact that is not accepted.
            SimulationError: a response that cannot be computed. A collapse is a result.
        """
        names, columns, report = self._native.simulate(vehicle, mass, velocity)
        history = {name: np.frombuffer(it, dtype=np.float64) for name, it in zip(names, columns)}
        fields = json.loads(report)
        if velocity is None:
            velocity = float(self._native.get("impact.velocity"))
        who = fields["vehicle"] or "a vehicle by numbers"
        of = "" if mass is None else f" of {mass:g} kg"
        return Result(f"{self._title()}, {who}{of} at {velocity:g} m/s", history, fields)

    def evaluate(self, vehicle: str | None = None, mass: float | None = None, velocity: float | None = None) -> Evaluation:
        """One impact on the undamaged column without its history: action, displacements, contact force, capacity.

        Arguments and errors are those of `simulate`.
        """
        return Evaluation._of(*self._native.evaluate(vehicle, mass, velocity))

    def evaluate_batch(
        self,
        masses: npt.ArrayLike | None,
        velocities: npt.ArrayLike,
        vehicle: str | None = None,
        threads: int | None = None,
    ) -> npt.NDArray[np.void]:
        """Many impacts on the undamaged column, on all processors: each row equals that of `evaluate` bit for bit.

        Other Python threads run meanwhile, and Ctrl-C interrupts the batch within a fraction of a second.

        Args:
            masses: total masses [kg], or None: as `mass` of `simulate`. NaN is the vehicle's own mass.
            velocities: speeds [m/s]. Both arrays are broadcast against each other.
            vehicle: as in `simulate`.
            threads: number of threads; default: as many as there are processors. The result does not depend on it.

        Returns:
            An array of the broadcast shape and of the structured type `EVALUATION`, in SI units.

        Raises:
            ParameterError: impacts that are not accepted; the text names the element.
            SimulationError: a response that cannot be computed.
        """
        speeds = np.asarray(velocities, dtype=np.float64)
        if masses is None:
            shape, weights = speeds.shape, None
        else:
            both = np.broadcast_arrays(np.asarray(masses, dtype=np.float64), speeds)
            shape, weights, speeds = both[0].shape, both[0].tobytes(), both[1]
        if threads is not None and threads < 1:
            raise ParameterError(f"threads: expected at least 1, found {threads}")
        rows = self._native.evaluate_batch(vehicle, weights, speeds.tobytes(), threads)
        return table_of(rows).reshape(shape)

    def map(
        self,
        *axes: str,
        vehicle: str | Sequence[str] | None = None,
        compare: str | Mapping[str, AxisValues] | None = None,
        threads: int | None = None,
        changes: Mapping[str, AxisValues] | None = None,
        **ranges: AxisValues,
    ) -> Map:
        """A damage map over two quantities, on all processors.

        An axis is `mass`, `velocity`, `height`, `section`, `vehicle`, or any parameter that is a number (`top__load`). Its values
        are a tuple (from, to, number of points), a list or an array of numbers, or a list of names of a catalogue; or it is a
        text in the notation of `column-twin map`.

        >>> column.map(mass=(2000, 12000, 50), velocity=(1, 25, 50), vehicle="lorry_8t")
        >>> column.map("section=HEB 200,HEB 240,HEB 300", velocity=np.linspace(1.0, 20.0, 50), vehicle="van")
        >>> column.map(velocity=(1, 25, 50), top__load=(2e5, 1e6, 20), compare={"section": ["HEB 220", "HEB 300"]})

        Other Python threads run meanwhile, and Ctrl-C interrupts the map.

        Args:
            axes: axes in the notation of the command line, such as `velocity=1:25:100`.
            vehicle: the vehicle of all cells; a list of names is an axis.
            compare: one more quantity, for each of whose values there is a map over the same axes.
            threads: number of threads; default: as many as there are processors. The result does not depend on it.
            changes: axes by the names of parameters, with dots.
            ranges: axes by keywords; two underscores are a dot.

        Raises:
            ParameterError: axes, values or a number of cells that are not accepted.
        """
        if threads is not None and threads < 1:
            raise ParameterError(f"threads: expected at least 1, found {threads}")
        given: list[_NativeAxis] = list(axes)
        named = {**(changes or {}), **{name.replace("__", "."): values for name, values in ranges.items()}}
        if vehicle is not None and not isinstance(vehicle, str):
            named["vehicle"], vehicle = vehicle, None
        given.extend(_axis(name, values) for name, values in named.items())
        if len(given) != 2:
            found = ", ".join(str(axis if isinstance(axis, str) else axis[0]) for axis in given) or "none"
            raise ParameterError(f"a map has two axes, such as mass=(2000, 12000, 50), velocity=(1, 25, 50); found {found}")
        if isinstance(compare, Mapping):
            if len(compare) != 1:
                raise ParameterError(f"compare: expected one quantity, found {len(compare)}")
            ((name, values),) = compare.items()
            compared: _NativeAxis | None = _axis(name, values)
        else:
            compared = compare
        computed = self._native.map(vehicle, given, compared, threads)
        return Map._of(computed, compared=compare is not None)

    def critical_velocities(
        self, vehicle: str | None = None, mass: float | None = None, lowest: float = 0.1, highest: float = 60.0
    ) -> dict[Action, CriticalVelocity]:
        """How fast a vehicle may be before its impact has each action, to 1 %.

        A scan goes up from `lowest` in ratios of at most 1.4, then intervals are halved; narrower ranges of velocities with a
        higher action are not found.

        Args:
            vehicle: as in `simulate`.
            mass: as in `simulate`.
            lowest: where the scan begins [m/s].
            highest: where it ends [m/s].
        """
        brackets, _ = self._native.critical_velocities(vehicle, mass, lowest, highest)
        actions = [it for it in Action if it is not Action.NONE]
        return {it: CriticalVelocity(*bracket) for it, bracket in zip(actions, brackets)}

    def critical_velocity(
        self,
        action: Action,
        vehicle: str | None = None,
        mass: float | None = None,
        lowest: float = 0.1,
        highest: float = 60.0,
    ) -> CriticalVelocity:
        """How fast a vehicle may be before its impact has this action; as `critical_velocities`."""
        if action == Action.NONE:
            raise ParameterError("action: expected one from inspect to evacuate, found none")
        return self.critical_velocities(vehicle, mass, lowest, highest)[Action(action)]

    def risk(
        self,
        scenario: str,
        vehicles_per_day: float,
        *,
        years: float = 1.0,
        distance: float | None = None,
        distributions: Sequence[str] = (),
        scenarios: str | os.PathLike[str] | None = None,
        samples: int = 10_000,
        seed: int = 1,
        confidence: float = 0.95,
        exact: bool = False,
        threads: int | None = None,
    ) -> Risk:
        """How often vehicles that leave the road damage the column, by Monte Carlo, as `column-twin risk` computes it.

        The same seed gives the same result on any number of threads. Other Python threads run meanwhile, and Ctrl-C interrupts.

        >>> column.risk("parking_garage", vehicles_per_day=2000, distance=0.5, samples=20_000)

        Args:
            scenario: `motorway`, `urban`, `courtyard`, `parking_garage`, or one of `scenarios`.
            vehicles_per_day: vehicles that pass the column [1/d].
            years: period for which the probabilities hold [a].
            distance: of the column from the edge of the road [m]; default: that of the scenario.
            distributions: other distributions of inputs, such as `speed_km_h=lognormal:12:5`.
            scenarios: file of scenarios of your own, as config/risk.json.
            samples: vehicles that are drawn.
            seed: of the random numbers.
            confidence: level of the intervals.
            exact: compute the response of every sample, and predict none from critical speeds.
            threads: number of threads; default: as many as there are processors.

        Raises:
            ParameterError: a scenario, law or number that is not accepted.
        """
        for name, number in (("vehicles_per_day", vehicles_per_day), ("years", years)):
            if not (np.isfinite(number) and number > 0.0):
                raise ParameterError(f"{name} {number}: expected a finite number > 0")
        if not 0.5 <= confidence <= 0.9999:
            raise ParameterError(f"confidence {confidence}: expected a number from 0.5 to 0.9999, such as 0.95")
        if not 1 <= samples <= 10**12 or int(samples) != samples:
            raise ParameterError(f"samples {samples}: expected a whole number from 1 to 1e12")
        if threads is not None and threads < 1:
            raise ParameterError(f"threads: expected at least 1, found {threads}")
        text = None
        if scenarios is not None:
            try:
                with open(scenarios, encoding="utf-8") as file:
                    text = (os.fspath(scenarios), file.read())
            except OSError as reason:
                raise ParameterError(f"cannot read the scenarios {os.fspath(scenarios)}: {reason.strerror}") from reason
        moved = [] if distance is None else [f"distance_m=fixed:{float(distance)!r}"]
        report = self._native.risk(
            {
                "scenario": scenario,
                "scenarios": text,
                "distributions": moved + list(distributions),
                "vehicles_per_day": float(vehicles_per_day),
                "years": float(years),
                "samples": int(samples),
                "seed": seed,
                "confidence": float(confidence),
                "exact": exact,
                "threads": threads,
            }
        )
        return Risk(scenario, json.loads(report))

    def capacity(
        self, vehicle: str | None = None, mass: float | None = None, velocity: float | None = None
    ) -> Capacity:
        """The axial capacity: of the undamaged column without arguments, otherwise of what this impact leaves.

        A static push-down finds the largest force that the column carries; docs/assessment.md describes it.
        Arguments and errors are those of `simulate`.
        """
        if vehicle is None and mass is None and velocity is None:
            report, curve = self._native.capacity()
        else:
            report, curve = self._native.capacity_after(vehicle, mass, velocity)
        return Capacity(json.loads(report), PushDown(*(np.frombuffer(it, dtype=np.float64) for it in curve)))

    def _title(self) -> str:
        """The section, or the name of the column where the section is given by numbers."""
        height = float(self._native.get("geometry.length_below")) + float(self._native.get("geometry.length_above"))
        name = self._native.get("section.name") or self._native.get("column_id") or "column"
        return f"{name}, {height:g} m"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Column):
            return NotImplemented
        return self._native.to_json() == other._native.to_json()

    def __hash__(self) -> int:
        return hash(self._native.to_json())

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (native.VERSION, self._native.to_json())

    def __dask_tokenize__(self) -> tuple[str, str, str]:
        """What identifies the column to Dask, in every process."""
        return "column_twin.Column", native.VERSION, self._native.to_json()

    def __repr__(self) -> str:
        load = float(self._native.get("top.load"))
        return (
            f"<Column {self._title()}, M^p {1e-3 * self.resistance_moment:.4g} kN m, "
            f"N^p {1e-3 * self.resistance_axial:.4g} kN, load {1e-3 * load:.4g} kN>"
        )

    def _repr_html_(self) -> str:
        from . import _html

        return _html.column(self)


def _restored(version: str, parameters: str) -> Column:
    """A column that was pickled, perhaps in another process or on another machine."""
    if version != native.VERSION:
        # Another version may compute other bits, and a study must not mix them.
        raise ColumnTwinError(
            f"this column was pickled by column-twin {version}, and this is {native.VERSION}; install the same version "
            "in every process"
        )
    return Column._of(native.Column.from_json(parameters))

"""A column."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any, Literal, Union

import numpy as np
import numpy.typing as npt

from ._capacity import Capacity, PushDown
from ._codes import Action
from ._errors import (
    ColumnTwinError,
    IncompleteWarning,
    ParameterError,
    ParameterWarning,
    SimulationError,
    UnknownParameterError,
)
from ._evaluation import Evaluation, table_of
from ._keyword_check import nearest, with_checked_keywords
from ._loading import native
from ._map import CriticalVelocity, Map, RefinedMap
from ._properties import ColumnProperties
from ._range import AxisValues, NativeAxis, expect_numbers, native_axis, numbers
from ._result import Result
from ._risk import Risk
from ._sensors import ImpactEstimate, Readings

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._keywords import AxisKeywords, ParameterKeywords

Value = Union[bool, int, float, str, Sequence[float], Sequence[str]]
"""The value of a parameter."""

Setting = Union[Value, npt.NDArray[Any], np.generic, "os.PathLike[str]"]
"""What a parameter may be set to: a value, or what numpy or pathlib make of one."""


Model = Literal["bars", "beam", "both"]
"""By which model an impact is judged: the two bars, the fibre beam alone, or the more severe verdict of both."""


def _plain(value: Any) -> Any:
    """A value of numpy or a path as the plain value that it holds."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return value


def _changes(changes: Mapping[str, Setting] | None, overrides: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Names with dots from both notations; keywords come last and win."""
    # Of a column what was given: what follows from it would otherwise stay as it is under later changes.
    first = changes.parameters if isinstance(changes, Column) else changes or {}
    given = list(first.items()) + [(name.replace("__", "."), it) for name, it in overrides.items()]
    return [(name, _plain(value)) for name, value in given]


def _name(vehicle: str | None, **impact: float | None) -> str | None:
    """The name of a vehicle, and not a mass, a velocity or arrays of them; of the impact no number is a truth value."""
    expect_numbers(impact)
    if vehicle is None or isinstance(vehicle, str):
        return vehicle
    raise TypeError(
        f"vehicle: expected a name such as 'mid_car', found {type(vehicle).__name__}; masses and velocities are keywords: "
        "mass=..., velocity=..."
    )


def _whole(name: str, number: float, least: int, most: int) -> int:
    """A whole number of this range."""
    if isinstance(number, Real) and not isinstance(number, bool) and least <= number <= most and int(number) == number:
        return int(number)
    raise ParameterError(f"{name}: expected a whole number from {least} to {most}, found {number!r}")


def _seed(seed: int) -> int:
    return _whole("seed", seed, 0, 2**64 - 1)


def _threads(threads: int | None) -> int | None:
    return None if threads is None else _whole("threads", threads, 1, 2**32)


def _map_request(
    vehicle: str | None, axes: list[NativeAxis], compared: NativeAxis | None, threads: int | None, model: str
) -> dict[str, Any]:
    """A map for the native part."""
    return {"vehicle": vehicle, "axes": axes, "compared": compared, "model": str(model), "threads": _threads(threads)}


def _compared_name(compare: str | Mapping[str, AxisValues] | None) -> str | None:
    """The quantity of a comparison."""
    if isinstance(compare, str):
        return compare.partition("=")[0]
    return None if compare is None else next(iter(compare)).replace("__", ".")


_AXES = ("mass", "velocity", "height", "section", "vehicle", "direction")
"""The names of axes that are no parameters."""

_MAP_KEYWORDS = ("vehicle", "compare", "shard", "threads", "model", "changes")
"""The keywords of a map that are no axes."""


@with_checked_keywords
class Column(Mapping[str, Value]):
    """A steel column that a vehicle may hit, with its parameters. It never changes: `with_changes` and `after` make another one.

    Every parameter of docs/parameters.md has a default. A dot in its name is two underscores in a keyword; a mapping takes the
    names as they are:

    >>> Column(section__name="HEB 300", top__load=8e5)
    >>> Column({"section.name": "HEB 300", "top.load": 8e5})

    All units are SI.

    It is a read-only mapping of the names of all parameters to the values that are computed with: `"top.load" in column`,
    `column.get("top.load")`, `column.items()`, `dict(column)`. `parameters` has the values as they are given.

    Raises:
        ParameterError: names or values that are not accepted, all faults together.
    """

    __slots__ = ("_native",)

    def __init__(self, changes: Mapping[str, Setting] | None = None, /, **overrides: Unpack[ParameterKeywords]) -> None:
        self._native = self._load([], changes, overrides)

    @classmethod
    def from_file(
        cls,
        *files: str | os.PathLike[str],
        changes: Mapping[str, Setting] | None = None,
        **overrides: Unpack[ParameterKeywords],
    ) -> Column:
        """The column of one or more parameter files (ROS 2 YAML), of which later ones win, changed by `changes` and `overrides`.

        >>> Column.from_file("config/heb220_s355.yaml", top__load=6e5)

        Raises:
            ParameterError: a file that cannot be read, or names or values that are not accepted, with line and column.
        """
        return cls._of(cls._load([os.fspath(file) for file in files], changes, overrides))

    @classmethod
    def fleet(
        cls, *files: str | os.PathLike[str], table: str | os.PathLike[str] | None = None
    ) -> dict[str, Column]:
        """The columns of a fleet by the names of their nodes, such as `/garage/a3`, for a study of each of them.

        >>> fleet = Column.fleet("garage.yaml", table="columns.csv")
        >>> {name: column.critical_velocity(Action.SHORE, "van") for name, column in fleet.items()}

        Args:
            files: parameter files of the fleet, as of `column-twin fleet`.
            table: its table of columns (CSV), which wins over the files.

        Raises:
            ParameterError: a file that cannot be read, or names or values that are not accepted.
        """
        columns, found = native.Column.fleet(
            [os.fspath(file) for file in files], None if table is None else os.fspath(table)
        )
        for text in found:
            warnings.warn(text, ParameterWarning, stacklevel=2)
        return {name: cls._of(column) for name, column in columns}

    def report(
        self,
        path: str | os.PathLike[str],
        vehicle: str | None = None,
        *,
        mass: float | None = None,
        velocity: float | None = None,
        details: str | os.PathLike[str] | None = None,
    ) -> None:
        """Writes the HTML report of one impact, one file with verdict, sketches, checks and figures.

        The program `column-twin` writes it: `pip install ./packaging/program` in the repository. All parameters go to a JSON file next to it.

        Args:
            path: HTML file; an existing one is replaced.
            details: file with project, site, author and more for the title block.

        Raises:
            ParameterError: an impact that is not accepted, or a damaged column.
            ProgramError: the program is missing, of another version, or has failed.
        """
        from ._program import report

        self._native.evaluate(_name(vehicle, mass=mass, velocity=velocity), mass, velocity)
        if self.is_damaged:
            raise ParameterError(
                "report: expected an undamaged column, found one that an impact has damaged; simulate has its numbers, and a node that "
                "records writes the report of a second impact"
            )
        report(self, path, vehicle, mass, velocity, details)

    @classmethod
    def _load(cls, files: list[str], changes: Mapping[str, Setting] | None, overrides: Mapping[str, Any]) -> native.Column:
        column, found = native.Column.load(files, _changes(changes, overrides))
        cls._warn(found)
        return column

    @staticmethod
    def _warn(found: list[str]) -> None:
        """Warns the caller of the method that calls this one or `_load`."""
        for text in found:
            warnings.warn(text, ParameterWarning, stacklevel=4)

    @classmethod
    def _of(cls, column: native.Column) -> Column:
        new = cls.__new__(cls)
        new._native = column
        return new

    def with_changes(
        self, changes: Mapping[str, Setting] | None = None, /, **overrides: Unpack[ParameterKeywords]
    ) -> Column:
        """This column with other values of some parameters: all changes or none.

        >>> heavier = column.with_changes(section__name="HEB 260")

        Raises:
            ParameterError: names or values that are not accepted, all faults together; a damaged column.
        """
        return self._changed(_changes(changes, overrides))

    def _changed(self, changes: list[tuple[str, Any]]) -> Column:
        changed, found = self._native.with_changes(changes)
        self._warn(found)
        return self._of(changed)

    def to_file(self, path: str | os.PathLike[str]) -> None:
        """Writes all parameters as a parameter file (ROS 2 YAML), which `from_file`, the command line and the node read.

        Damage is not written; a column is pickled with it.
        """
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._native.to_yaml())

    def __getitem__(self, name: str) -> Value:
        """The value of a parameter: `column["top.load"]`. Of one that follows from others it is the number that is computed with:
        `column["section.area"]` is the area of the named section. `parameters` has what was given.

        Raises:
            ParameterError: there is no parameter of this name; the text names the nearest ones. It is a KeyError, too.
        """
        value: Value | None = self._native.get(name)
        if value is None:
            try:
                # The same text as for a change of a parameter that does not exist.
                native.Column.load([], [(name, 0.0)])
            except ParameterError as reason:
                raise UnknownParameterError(str(reason)) from None
            raise UnknownParameterError(f"{name} is not a parameter of this column")
        return value

    def __contains__(self, name: object) -> bool:
        """Whether there is a parameter of this name."""
        return isinstance(name, str) and self._native.get(name) is not None

    def __iter__(self) -> Iterator[str]:
        """The names of all parameters, in the order of docs/parameters.md."""
        return iter(self.parameters)

    def __len__(self) -> int:
        """The number of parameters."""
        return len(self.parameters)

    @property
    def parameters(self) -> dict[str, Value]:
        """Every parameter as it is given, in the order of docs/parameters.md: 0 where it follows from others."""
        return {name: value for name, value, _, _ in self._native.describe()}

    def describe(self) -> list[tuple[str, Value, str, str]]:
        """Name, value as given, unit and meaning of every parameter."""
        return self._native.describe()

    @property
    def properties(self) -> ColumnProperties:
        """The numbers with which the column is computed."""

        def number(name: str) -> float:
            return float(self._native.get(name))

        step, moment, axial, axial_rigidity, bending_stiffness = self._native.derived()
        return ColumnProperties(
            section=str(self._native.get("section.name")),
            steel=str(self._native.get("steel.grade")),
            height=number("geometry.length_below") + number("geometry.length_above"),
            impact_height=number("geometry.length_below"),
            area=number("section.area"),
            second_moment=number("section.second_moment"),
            mass_per_length=number("section.mass_per_length"),
            young_modulus=number("steel.young_modulus"),
            yield_strength=number("steel.yield_strength"),
            axial_rigidity=axial_rigidity,
            bending_stiffness=bending_stiffness,
            resistance_moment=moment,
            resistance_axial=axial,
            load=number("top.load"),
            step=step,
        )

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

    @property
    def is_damaged(self) -> bool:
        """Whether an impact has damaged the column, see `after`."""
        return self._native.is_damaged

    def after(
        self,
        impact: Result | None = None,
        /,
        *,
        vehicle: str | None = None,
        mass: float | None = None,
        velocity: float | None = None,
    ) -> Column:
        """The column as an impact leaves it, at rest once the vehicle is gone, to be hit again.

        >>> first = column.simulate("mid_car", velocity=12.0)
        >>> second = column.after(first).simulate("mid_car", velocity=8.0)

        A damaged column has `simulate`, `evaluate`, `evaluate_batch`, `map`, `refined_map`, `critical_velocities`, `capacity` without
        arguments and `after`; everything else raises a ParameterError that names the way to go instead. The damage is pickled with it.
        Its hinges stay at the height at which the first vehicle struck.

        Args:
            impact: a result of `simulate` of this column. Without one the keywords describe the impact, as in
                `simulate`. Damage by the fibre beam alone, such as from a vehicle that travels across the plane of the two bars,
                is kept where the result has it (`model="both"`).

        Raises:
            ParameterError: an impact that is not accepted, or one of another column.
            SimulationError: the column does not stand after this impact.
        """
        if impact is not None:
            if vehicle is not None or mass is not None or velocity is not None:
                raise ParameterError("after: expected a result, or vehicle, mass and velocity; found both")
            if impact._struck != self._native.to_json():
                raise ParameterError("after: expected a result of this column, found one of another; compute it for this column")
            vehicle, mass, velocity = impact._impact
        direction = None if impact is None else impact._direction
        beam = None if impact is None else impact.report.get("beam")
        by_beam = isinstance(beam, dict) and beam["outcome"] != "elastic"
        left = self._native.after(_name(vehicle, mass=mass, velocity=velocity), mass, velocity, direction, by_beam)
        if left is None:
            raise SimulationError("the column does not stand after this impact: it has collapsed or is fractured")
        return self._of(left)

    def simulate(
        self,
        vehicle: str | None = None,
        *,
        mass: float | None = None,
        velocity: float | None = None,
        direction: float | None = None,
        model: Model = "bars",
    ) -> Result:
        """One impact with histories and report.

        The response itself takes milliseconds. The report takes more responses, which give the error of the step and the range of
        the verdict, and their push-downs.

        A column that an impact has damaged, see `after`, is hit once more, as by a node: displacements and plastic rotations count
        from the undamaged column, the reactions of the base are the largest of all impacts, and the range of the verdict varies
        this impact alone. The beam first computes the earlier impacts again.

        With `model="both"` the fibre beam computes the impact, too, as `column-twin simulate` does: `Result.beam` has its numbers,
        and the action is the more severe one of both models where its verdict counts. With `model="beam"`, the beam alone
        gives action and criteria, without a range. Histories and displacements are still by the two bars. The beam takes tens of
        milliseconds more.

        >>> column.simulate("mid_car", velocity=10.0)
        >>> column.simulate("mid_car", velocity=10.0, direction=np.radians(10), model="both").beam["max_sideways_m"]

        Args:
            vehicle: `rigid`, or a name of `vehicles()`; default: the parameter `vehicle.name`.
            mass: total mass of the vehicle [kg]; default: with `vehicle` its own mass, otherwise the parameter `impact.mass`.
            velocity: speed towards the column [m/s]; default: the parameter `impact.velocity`.
            direction: direction of travel [rad], above -pi to pi; 0 bends the column about its strong axis, and of any other one the
                two bars take the component in their plane; default: the parameter `impact.direction`.
            model: by which model the impact is judged: `bars`, the two bars, `beam`, the fibre beam, or `both`.

        Raises:
            ParameterError: an impact that is not accepted.
            SimulationError: a response that cannot be computed. A collapse is a result.

        Warns:
            ParameterWarning: a mass that this vehicle cannot have, such as one in tonnes.
        """
        vehicle = _name(vehicle, mass=mass, velocity=velocity, direction=direction)
        if direction is not None:
            direction = float(direction)
            if not -np.pi < direction <= np.pi:
                raise ParameterError(f"direction {direction}: expected an angle above -pi and at most pi, in rad")
        names, columns, report = self._native.simulate(vehicle, mass, velocity, direction, str(model))
        history = {name: np.frombuffer(it, dtype=np.float64) for name, it in zip(names, columns)}
        fields = json.loads(report)
        if velocity is None:
            velocity = float(self._native.get("impact.velocity"))
        who = fields["vehicle"] or "a user-defined vehicle"
        of = "" if mass is None else f" of {mass:g} kg"
        turned = "" if direction is None else f", {np.degrees(direction):g} degrees"
        result = Result(f"{self._title()}, {who}{of} at {velocity:g} m/s{turned}", history, fields)
        result._impact, result._struck = (vehicle, mass, velocity), self._native.to_json()
        result._direction = direction
        return result

    def evaluate(
        self, vehicle: str | None = None, *, mass: float | None = None, velocity: float | None = None
    ) -> Evaluation:
        """One impact without its history: action, displacements, contact force, capacity.

        Arguments, errors and warnings are the same as for `simulate`.
        """
        return Evaluation._of(*self._native.evaluate(_name(vehicle, mass=mass, velocity=velocity), mass, velocity))

    def evaluate_batch(
        self,
        vehicle: str | None = None,
        *,
        mass: npt.ArrayLike | None = None,
        velocity: npt.ArrayLike | None = None,
        threads: int | None = None,
    ) -> npt.NDArray[np.void]:
        """Many impacts, on all processors: each row equals the result of `evaluate` bit for bit.

        All impacts are checked before the first one is computed. Other Python threads run meanwhile, and Ctrl-C interrupts the
        batch within a fraction of a second. It takes at most three times the memory of the array that it returns.

        >>> column.evaluate_batch("van", velocity=np.linspace(1.0, 20.0, 1000))

        Args:
            vehicle: as in `simulate`.
            mass: total masses [kg]; default: as in `simulate`.
            velocity: speeds [m/s]; default: the parameter `impact.velocity`. Both arrays are broadcast against each other.
            threads: number of threads; default: as many as there are processors. The result does not depend on it.

        Returns:
            An array of the broadcast shape and of the structured type `EVALUATION`, in SI units.

        Raises:
            ParameterError: impacts that are not accepted, or masked elements; the text names the element, counted in the flattened
                array.
            SimulationError: a response that cannot be computed.

        Warns:
            ParameterWarning: a mass that this vehicle cannot have, such as one in tonnes.
        """
        vehicle = _name(vehicle)
        if velocity is None:
            velocity = float(self._native.get("impact.velocity"))
        speeds = numbers("velocity", velocity)
        if mass is None:
            shape, weights = speeds.shape, None
        else:
            both = np.broadcast_arrays(numbers("mass", mass), speeds)
            shape, weights, speeds = both[0].shape, both[0].tobytes(), both[1]
        rows = self._native.evaluate_batch(vehicle, weights, speeds.tobytes(), _threads(threads))
        return table_of(rows).reshape(shape)

    def map(
        self,
        *axes: str,
        vehicle: str | Sequence[str] | None = None,
        compare: str | Mapping[str, AxisValues] | None = None,
        shard: tuple[int, int] | None = None,
        threads: int | None = None,
        model: Model = "bars",
        changes: Mapping[str, AxisValues] | None = None,
        **ranges: Unpack[AxisKeywords],
    ) -> Map:
        """A damage map over two quantities or more, on all processors.

        An axis is `mass`, `velocity`, `height`, `section`, `vehicle`, `direction` [rad], or any parameter that is a number
        (`top__load`). Its values are a `Range`, a list or an array of numbers, or a list of names of a catalogue; or it is a text in
        the notation of `column-twin map`, in which a direction is in degrees.

        >>> column.map(mass=Range(2000, 12000, points=50), velocity=Range(1, 25, points=50), vehicle="lorry_8t")
        >>> column.map("section=HEB 200,HEB 240,HEB 300", velocity=np.linspace(1.0, 20.0, 50), vehicle="van")
        >>> column.map(velocity=Range(1, 25, points=50), top__load=[2e5, 5e5], compare={"section": ["HEB 220", "HEB 300"]})
        >>> column.map(direction=np.radians([0.0, 45.0, 90.0]), velocity=[4.0, 8.0], vehicle="mid_car", model="both")
        >>> column.map(top__load=[2e5, 5e5], vehicle=["van", "mid_car"], mass=[1500, 2500], velocity=Range(2, 12, points=6))

        The velocity is the last axis of the arrays, the mass the one before it, and vehicle and direction follow all other quantities;
        apart from that the axes stand in the order in which they are given. The last two are the rows and columns of figures.
        `Map.at` chooses values of the further ones, of which there may be 10 000 combinations.

        Other Python threads run meanwhile, and Ctrl-C interrupts the map.

        On a column that an impact has damaged every cell is one more impact; mass, velocity, vehicle and direction can vary, and the
        two bars judge.

        Args:
            axes: axes in the notation of the command line, such as `velocity=1:25:100`.
            vehicle: the vehicle of all cells; a list of names is an axis.
            compare: one more quantity, for each of whose values there is a map over the same axes, with a label of its own.
            shard: part of the map that is computed, (number from 1, number of parts), for several machines; all others are
                masked. `Map.merged` puts the parts together.
            threads: number of threads; default: as many as there are processors. The result does not depend on it.
            model: by which model an impact is judged: `bars`, the two bars; `beam`, the fibre beam alone; `both`, the more severe
                verdict of both where the beam counts, as in a node. The beam takes tens of milliseconds for each cell, and
                `Map.beam` has its results.
            changes: axes by the names of parameters, with dots.
            ranges: axes by keywords; two underscores are a dot.

        Raises:
            ParameterError: axes, values or a number of cells that are not accepted; for a damaged column, an axis or a comparison of
                what belongs to the column, or a model other than `bars`.

        Warns:
            IncompleteWarning: cells that cannot be computed. They are masked, and `failures` has the reasons.
        """
        vehicle, given, compared = self._planned(axes, vehicle, compare, changes, ranges)
        if shard is not None:
            number, parts = shard
            if not 1 <= number <= parts:
                raise ParameterError(f"shard: expected a number from 1 to the number of parts, found {shard}")
        computed = self._native.map(_map_request(vehicle, given, compared, threads, model), shard)
        damage = Map._of(computed, _compared_name(compare))
        if damage.failures:
            place, reason = next(iter(damage.failures.items()))
            warnings.warn(
                f"{len(damage.failures)} of {damage.cells.size} cells cannot be computed and are masked; the first, {place}: {reason}",
                IncompleteWarning,
                stacklevel=3,
            )
        return damage

    def refined_map(
        self,
        *axes: str,
        vehicle: str | None = None,
        compare: str | Mapping[str, AxisValues] | None = None,
        threads: int | None = None,
        model: Model = "bars",
        changes: Mapping[str, AxisValues] | None = None,
        **ranges: Unpack[AxisKeywords],
    ) -> RefinedMap:
        """The boundaries of the actions on a map of two axes, to 1 %, without its cells: `column-twin map --refine`.

        Arguments and errors are the same as for `map`; a third axis is an error.
        """
        vehicle, given, compared = self._planned(axes, vehicle, compare, changes, ranges)
        return RefinedMap._of(json.loads(self._native.refine(_map_request(vehicle, given, compared, threads, model))))

    def _expect_axis(self, name: str) -> None:
        """A name that is neither an axis nor a parameter may be a misspelt keyword."""
        if name in _AXES or name in self:
            return
        meant = nearest(name, (*_AXES, *_MAP_KEYWORDS))
        if meant:
            raise ParameterError(f"{name} is neither a keyword nor an axis of a map (did you mean {meant}?)")
        # The nearest parameter.
        self[name]

    def _planned(
        self,
        axes: tuple[str, ...],
        vehicle: str | Sequence[str] | None,
        compare: str | Mapping[str, AxisValues] | None,
        changes: Mapping[str, AxisValues] | None,
        ranges: Mapping[str, Any],
    ) -> tuple[str | None, list[NativeAxis], NativeAxis | None]:
        """The vehicle, the axes and the compared quantity of a map."""
        given: list[NativeAxis] = list(axes)
        named = {**(changes or {}), **{name.replace("__", "."): values for name, values in ranges.items()}}
        if vehicle is not None and not isinstance(vehicle, str):
            named["vehicle"], vehicle = vehicle, None
        for name in named:
            self._expect_axis(name)
        given.extend(native_axis(name, values) for name, values in named.items())
        if len(given) < 2:
            found = ", ".join(str(axis if isinstance(axis, str) else axis[0]) for axis in given) or "none"
            raise ParameterError(
                "a map has two axes or more, such as mass=Range(2000, 12000, points=50), velocity=Range(1, 25, points=50); "
                f"found {found}"
            )
        if isinstance(compare, Mapping):
            if len(compare) != 1:
                raise ParameterError(f"compare: expected one quantity, found {len(compare)}")
            ((name, values),) = compare.items()
            return vehicle, given, native_axis(name, values)
        return vehicle, given, compare

    def sensor_readings(
        self,
        vehicle: str | None = None,
        *,
        mass: float | None = None,
        velocity: float | None = None,
        seed: int = 1,
    ) -> Readings:
        """The readings of the sensors of the column in an impact, with their errors: `column-twin simulate --readings`.

        The sensors are declared by `sensors.names`, such as in config/sensors_industrial.yaml. The same seed gives the same readings.

        Raises:
            ParameterError: an impact that is not accepted, or a column without sensors.
        """
        vehicle = _name(vehicle, mass=mass, velocity=velocity)
        return Readings(self._native.sensor_readings(vehicle, mass, velocity, _seed(seed)))

    def estimate(self, readings: Readings | str | os.PathLike[str], *, seed: int = 1) -> ImpactEstimate | None:
        """The vehicle that struck the undamaged column, estimated from the readings of its sensors: `column-twin estimate`. It takes seconds.

        Args:
            readings: from `sensor_readings`, or a file in CSV: `time` [s] and a column for each sensor.
            seed: seed of the random numbers; the same seed gives the same estimate.

        Returns:
            The estimate; None if there was no impact.

        Raises:
            ParameterError: readings that do not fit the sensors of the column.
        """
        if not isinstance(readings, Readings):
            readings = Readings.from_file(readings)
        found = self._native.estimate(readings.csv, _seed(seed))
        return None if found is None else ImpactEstimate(json.loads(found))

    def critical_velocities(
        self, vehicle: str | None = None, *, mass: float | None = None, lowest: float = 0.1, highest: float = 60.0
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
        vehicle = _name(vehicle, mass=mass, lowest=lowest, highest=highest)
        brackets, _ = self._native.critical_velocities(vehicle, mass, lowest, highest)
        actions = [it for it in Action if it is not Action.NONE]
        return {it: CriticalVelocity(*bracket) for it, bracket in zip(actions, brackets)}

    def critical_velocity(
        self,
        action: Action,
        vehicle: str | None = None,
        *,
        mass: float | None = None,
        lowest: float = 0.1,
        highest: float = 60.0,
    ) -> CriticalVelocity:
        """How fast a vehicle may be before its impact has this action; as `critical_velocities`."""
        if action == Action.NONE:
            raise ParameterError("action: expected one from inspect to evacuate, found none")
        return self.critical_velocities(vehicle, mass=mass, lowest=lowest, highest=highest)[Action(action)]

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
        model: Model = "bars",
    ) -> Risk:
        """How often vehicles that leave the road damage the column, by Monte Carlo, as `column-twin risk` computes it.

        The same seed gives the same result on any number of threads. Other Python threads run meanwhile, and Ctrl-C interrupts.

        >>> column.risk("parking_garage", vehicles_per_day=2000, distance=0.5, samples=20_000)
        >>> any_way = ["orientation_deg=uniform:-90:90"]
        >>> column.risk("courtyard", vehicles_per_day=50, distributions=any_way, model="both", samples=50)

        Args:
            scenario: `motorway`, `urban`, `courtyard`, `parking_garage`, or one of `scenarios`.
            vehicles_per_day: vehicles that pass the column [1/d].
            years: period for which the probabilities hold [a].
            distance: distance of the column from the edge of the road [m]; default: the distance of the scenario.
            distributions: other distributions of inputs, such as `speed_km_h=lognormal:12:5`, or `orientation_deg=uniform:-90:90` for
                columns whose webs stand in any direction to the road.
            scenarios: file of scenarios of your own, as config/risk.json.
            samples: vehicles that are drawn.
            seed: seed of the random numbers, a whole number from 0 to 2^64 - 1.
            confidence: level of the intervals.
            exact: compute the response of every sample, and predict none from critical speeds.
            threads: number of threads; default: as many as there are processors.
            model: by which model a sample is judged, as in `map`. The two bars predict most samples, and the beam computes those in
                doubt and a share of the others.

        Raises:
            ParameterError: a scenario, law or number that is not accepted, or a damaged column.
        """
        if not isinstance(scenario, str):
            raise ParameterError(f"scenario: expected a name such as 'urban', found {scenario!r}")
        expect_numbers({"vehicles_per_day": vehicles_per_day, "years": years, "distance": distance, "confidence": confidence})
        for name, number in (("vehicles_per_day", vehicles_per_day), ("years", years)):
            if not (np.isfinite(number) and number > 0.0):
                raise ParameterError(f"{name} {number}: expected a finite number > 0")
        if not 0.5 <= confidence <= 0.9999:
            raise ParameterError(f"confidence {confidence}: expected a number from 0.5 to 0.9999, such as 0.95")
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
                "samples": _whole("samples", samples, 1, 10**12),
                "seed": _seed(seed),
                "confidence": float(confidence),
                "model": str(model),
                "exact": bool(exact),
                "threads": _threads(threads),
            }
        )
        return Risk(scenario, json.loads(report))

    def capacity(
        self, vehicle: str | None = None, *, mass: float | None = None, velocity: float | None = None
    ) -> Capacity:
        """The axial capacity of the column as it is, or with arguments, of the column after this impact.

        A static push-down finds the largest force that the column carries; docs/assessment.md describes it.
        Arguments and errors are the same as for `simulate`.
        """
        if vehicle is None and mass is None and velocity is None:
            report, curve = self._native.capacity()
        else:
            report, curve = self._native.capacity_after(_name(vehicle, mass=mass, velocity=velocity), mass, velocity)
        return Capacity(json.loads(report), PushDown(*(np.frombuffer(it, dtype=np.float64) for it in curve)))

    def _title(self) -> str:
        """The section, or the name of the column where the section is user-defined."""
        height = float(self._native.get("geometry.length_below")) + float(self._native.get("geometry.length_above"))
        name = self._native.get("section.name") or self._native.get("column_id") or "column"
        damaged = ", damaged" if self.is_damaged else ""
        return f"{name}, {height:g} m{damaged}"

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

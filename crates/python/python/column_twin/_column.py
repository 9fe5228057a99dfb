"""A column, and the calls that compute impacts on it."""

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
from ._codes import Action, expect_action
from ._errors import (
    ColumnTwinError,
    IncompleteWarning,
    ParameterError,
    ParameterWarning,
    SimulationError,
    UnknownParameterError,
)
from ._evaluation import Evaluation, table_of
from ._files import read_text
from ._keyword_check import nearest, with_checked_keywords, with_explained_calls
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
"""The value of a parameter: a truth value, a number in the SI unit of the parameter, a text, or a list of numbers or of texts."""

Setting = Union[Value, npt.NDArray[Any], np.generic, "os.PathLike[str]"]
"""A value that a parameter may be given: a plain value, or an array or number of numpy, or a path."""

Model = Literal["bars", "beam", "both"]
"""The model by which an impact is judged: the two bars, the fibre beam alone, or the more severe verdict of both."""


def _plain(name: str, value: Any) -> Any:
    """A value of numpy or a path as the plain value that it holds."""
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, (list, tuple)):
        for index, it in enumerate(value):
            if isinstance(it, (bool, np.bool_)):
                raise ParameterError(f"{name}: element {index} is {it}; expected numbers or texts")
    return value


def _changes(changes: Mapping[str, Setting] | None, overrides: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Names with dots from both notations; keywords come last and win."""
    if changes is not None and not isinstance(changes, Mapping):
        raise TypeError(
            f"changes: expected a mapping of names of parameters to values, found {type(changes).__name__}; Column.from_file reads "
            "parameter files"
        )
    # Of a column what was given: what follows from it would otherwise stay as it is under later changes.
    first = changes.parameters if isinstance(changes, Column) else changes or {}
    given = list(first.items()) + [(name.replace("__", "."), it) for name, it in overrides.items()]
    return [(name, _plain(name, value)) for name, value in given]


def _name(vehicle: str | None, **impact: float | None) -> str | None:
    """The name of a vehicle, and not a mass, a velocity or arrays of them; of the impact no number is a truth value."""
    expect_numbers(impact)
    if vehicle is None or isinstance(vehicle, str):
        return vehicle
    raise TypeError(
        f"vehicle: expected a name such as 'mid_car', found {type(vehicle).__name__}; masses and velocities are keywords: "
        "mass=..., velocity=..."
    )


def _no_direction(given: list[tuple[str, Any]]) -> list[str]:
    """A warning about a direction in degrees, most likely, which the two bars take for none."""
    return [
        f"impact.direction: {value} is no direction, so that the two bars take the whole velocity; expected an angle above -pi and at most "
        f"pi, in rad, such as np.radians({value})"
        for name, value in given
        if name == "impact.direction" and isinstance(value, Real) and not -np.pi < float(value) <= np.pi
    ]


def _whole(name: str, number: float, least: int, most: int) -> int:
    """A whole number of this range."""
    if isinstance(number, Real) and not isinstance(number, bool) and least <= number <= most and int(number) == number:
        return int(number)
    raise ParameterError(f"{name}: expected a whole number from {least} to {most}, found {number!r}")


def _seed(seed: int) -> int:
    return _whole("seed", seed, 0, 2**64 - 1)


def _threads(threads: int | None) -> int | None:
    return None if threads is None else _whole("threads", threads, 1, 2**32)


def _shard(shard: tuple[int, int]) -> list[int]:
    """The number of a part, from 1, and the number of parts."""
    if not isinstance(shard, (tuple, list)) or len(shard) != 2:
        raise ParameterError(f"shard: expected the number of a part and the number of parts, such as (1, 4); found {shard!r}")
    number, parts = (_whole("shard", it, 1, 2**63 - 1) for it in shard)
    if number > parts:
        raise ParameterError(f"shard: expected a number from 1 to the number of parts, found {shard}")
    return [number, parts]


def _direction(direction: float | None) -> float | None:
    """A direction of travel [rad]."""
    if direction is None:
        return None
    if not -np.pi < float(direction) <= np.pi:
        raise ParameterError(
            f"direction {direction}: expected an angle above -pi and at most pi, in rad, such as np.radians({direction})"
        )
    return float(direction)


def _read_only(values: bytearray) -> npt.NDArray[np.float64]:
    """An array of a result, which a caller cannot change for the next one."""
    array = np.frombuffer(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def _brackets(found: Sequence[tuple[float | None, float | None]]) -> dict[Action, CriticalVelocity]:
    """The critical velocities of the actions from INSPECT on."""
    return {action: CriticalVelocity(*bracket) for action, bracket in zip(list(Action)[1:], found)}


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

    Every parameter of docs/parameters.md has a default, and all units are SI. A dot in the name of a parameter is two underscores in a
    keyword; a mapping takes the names with their dots, and keywords override it:

    >>> Column(section__name="HEB 300", top__load=8e5)
    >>> Column({"section.name": "HEB 300", "top.load": 8e5})

    A column is a read-only mapping from the names of all parameters to the values with which it is computed: `"top.load" in column`,
    `column.get("top.load")`, `column.items()`, `dict(column)`. `parameters` contains the values as they are given. Columns can be
    compared, hashed and pickled.

    Raises:
        ParameterError: names or values that are not accepted, with all faults together.
        TypeError: a value of another type, such as None, or `changes` that are no mapping.

    Warns:
        ParameterWarning: a deprecated value, a mass that the vehicle cannot have, or a direction that is none.
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
        """The column of one or more parameter files (ROS 2 YAML).

        >>> Column.from_file("config/heb220_s355.yaml", top__load=6e5)

        Args:
            files: parameter files, of which later ones override earlier ones.
            changes: values by the names of parameters, with dots, which override the files.
            overrides: values by keywords, in which two underscores are a dot; they override everything else.

        Raises:
            ParameterError: no file, a file that cannot be read, or names or values that are not accepted, with line and column.

        Warns:
            ParameterWarning: a deprecated value, a mass that the vehicle cannot have, or a direction that is none.
        """
        if not files:
            raise ParameterError("from_file: expected one parameter file or more, found none; Column() has the defaults")
        return cls._of(cls._load([os.fspath(file) for file in files], changes, overrides))

    @classmethod
    @with_explained_calls
    def fleet(
        cls, *files: str | os.PathLike[str], table: str | os.PathLike[str] | None = None
    ) -> dict[str, Column]:
        """The columns of a fleet, in its order, by the names of their nodes, such as `/garage/a3`.

        >>> fleet = Column.fleet("config/fleet.yaml", table="config/fleet.csv")
        >>> {name: column.critical_velocity(Action.SHORE, "van") for name, column in fleet.items()}

        Args:
            files: parameter files of the fleet, as for `column-twin fleet`; later ones override earlier ones.
            table: the table of the columns of the fleet (CSV), which overrides the files; docs/fleet.md describes both.

        Raises:
            ParameterError: a file that cannot be read, names or values that are not accepted, or a fleet without columns.

        Warns:
            ParameterWarning: a deprecated value, or a mass that a vehicle cannot have.
        """
        columns, found = native.Column.fleet(
            [os.fspath(file) for file in files], None if table is None else os.fspath(table)
        )
        for text in found:
            warnings.warn(text, ParameterWarning, stacklevel=3)
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
        """Writes the report of one impact as one HTML file with action, sketches, criteria and figures.

        The program `column-twin` writes it; to install it: `pip install ./packaging/program` in the repository. All parameters go to a
        JSON file next to the report. The fibre beam judges the impact, too, as in `column-twin simulate`.

        >>> column.report("impact.html", "mid_car", velocity=10.0)

        Args:
            path: HTML file; an existing one is replaced.
            vehicle: as in `simulate`.
            mass: as in `simulate` [kg].
            velocity: as in `simulate` [m/s].
            details: file with lines such as `project: Car park North` for the title block; `column-twin report --help` lists their names.

        Raises:
            ParameterError: an impact that is not accepted, or a damaged column.
            ProgramError: the program is missing, is of another version, or has failed.
            SimulationError: a response that cannot be computed.

        Warns:
            ParameterWarning: a mass that this vehicle cannot have, such as one in tonnes.
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
        given = _changes(changes, overrides)
        column, found = native.Column.load(files, given)
        cls._warn(found + _no_direction(given))
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
        """The column with other values of some parameters.

        >>> heavier = column.with_changes(section__name="HEB 260")

        Args:
            changes: values by the names of parameters, with dots.
            overrides: values by keywords, in which two underscores are a dot; they override `changes`.

        Raises:
            ParameterError: names or values that are not accepted, with all faults together, or a damaged column.
            TypeError: a value of another type, such as None, or `changes` that are no mapping.

        Warns:
            ParameterWarning: a deprecated value, a mass that the vehicle cannot have, or a direction that is none.
        """
        return self._changed(_changes(changes, overrides))

    def _changed(self, changes: list[tuple[str, Any]]) -> Column:
        changed, found = self._native.with_changes(changes)
        self._warn(found + _no_direction(changes))
        return self._of(changed)

    def to_file(self, path: str | os.PathLike[str]) -> None:
        """Writes all parameters as a parameter file (ROS 2 YAML), which `from_file`, the command line and the node read. An existing
        file is replaced.

        The file does not contain damage; a pickled column does.

        Raises:
            OSError: a file that cannot be written.
        """
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._native.to_yaml())

    def __getitem__(self, name: str) -> Value:
        """The value of a parameter with which the column is computed, such as `column["top.load"]`. A number that follows from other
        parameters is the computed one: `column["section.area"]` is the area of the named section.

        Raises:
            ParameterError: a name that no parameter has; the text contains the nearest names. It is also a KeyError.
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
        """Every parameter as it is given, by its name, in the order of docs/parameters.md; 0 stands for a number that follows from other
        parameters."""
        return {name: value for name, value, _, _ in self._native.describe()}

    def describe(self) -> list[tuple[str, Value, str, str]]:
        """Name, value as it is given, SI unit and meaning of every parameter; the unit of a parameter without unit is empty."""
        return self._native.describe()

    @property
    def properties(self) -> ColumnProperties:
        """The dimensions, stiffnesses and resistances with which the column is computed."""

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
        """Length of a time step of the two bars [s]."""
        return self._native.derived()[0]

    @property
    def resistance_moment(self) -> float:
        """M^p: plastic moment resistance without normal force [N m]."""
        return self._native.derived()[1]

    @property
    def resistance_axial(self) -> float:
        """N^p: plastic axial resistance, the squash load [N]."""
        return self._native.derived()[2]

    @property
    def is_damaged(self) -> bool:
        """Whether an earlier impact has damaged the column, see `after`."""
        return self._native.is_damaged

    def after(
        self,
        impact: Result | None = None,
        /,
        *,
        vehicle: str | None = None,
        mass: float | None = None,
        velocity: float | None = None,
        direction: float | None = None,
    ) -> Column:
        """The column after an impact, at rest without the vehicle, which can be hit again.

        >>> first = column.simulate("lorry_8t", velocity=8.0)
        >>> second = column.after(first).simulate("mid_car", velocity=8.0)

        A damaged column has `simulate`, `evaluate`, `evaluate_batch`, `map`, `refined_map`, `critical_velocities`,
        `critical_velocity`, `capacity` without arguments, and `after`. The other calls that compute or change it raise a ParameterError
        that names an alternative. The hinges stay at the height at which the first vehicle struck.

        Args:
            impact: a result of `simulate` on this column. Damage in the fibre beam alone, such as from a vehicle that travels across
                the plane of the two bars, is kept where the result contains it (`model="both"` or `model="beam"`).
            vehicle: without a result, the vehicle as in `simulate`.
            mass: as in `simulate` [kg].
            velocity: as in `simulate` [m/s].
            direction: direction of travel [rad], as in `simulate`.

        Raises:
            ParameterError: an impact that is not accepted, or a result of another column.
            SimulationError: the column does not stand after this impact, or the response cannot be computed.

        Warns:
            ParameterWarning: a mass that this vehicle cannot have, such as one in tonnes.
        """
        if impact is not None:
            if not isinstance(impact, Result):
                raise TypeError(
                    f"after: expected a result of simulate, found {type(impact).__name__}; a vehicle is given by a keyword: vehicle=..."
                )
            if any(it is not None for it in (vehicle, mass, velocity, direction)):
                raise ParameterError("after: expected a result, or vehicle, mass, velocity and direction; found both")
            if impact._struck != self._native.to_json():
                raise ParameterError("after: expected a result of this column, found one of another; compute it for this column")
            vehicle, mass, velocity, direction = impact._impact
        beam = None if impact is None else impact.report.get("beam")
        by_beam = isinstance(beam, dict) and beam["outcome"] != "elastic"
        vehicle = _name(vehicle, mass=mass, velocity=velocity, direction=direction)
        left = self._native.after(vehicle, mass, velocity, _direction(direction), by_beam)
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
        """One impact with its history and its report, which contains the criteria and the action.

        The response takes milliseconds. The report needs more responses and push-downs, for the error of the time step and for the range
        of the verdict.

        On a column that an earlier impact has damaged, see `after`, the vehicle strikes once more: displacements and plastic rotations
        are measured from the undamaged column, the base is judged by the largest reactions of all impacts, and the range of the verdict
        varies the last impact alone. The fibre beam first computes the earlier impacts again.

        With `model="both"`, the fibre beam computes the impact, too, as in `column-twin simulate`: `Result.beam` has its results, and the
        action is the more severe one of both models where the verdict of the beam counts (docs/second_opinion.md). With `model="beam"`,
        action and criteria come from the beam alone, without a range. The histories and all other numbers come from the two bars in
        both cases. The beam takes about 0.1 s more.

        >>> column.simulate("mid_car", velocity=10.0).plot()
        >>> column.simulate("mid_car", velocity=10.0, direction=np.radians(10), model="both").report["beam"]["max_sideways_m"]

        Args:
            vehicle: `rigid`, or a name of `vehicles()`; default: the parameter `vehicle.name`.
            mass: total mass of the vehicle [kg]; 0 stands for its own mass, which `rigid` does not have. Default: with `vehicle` its own
                mass, otherwise the parameter `impact.mass`.
            velocity: speed of the vehicle over the ground [m/s], from 1e-6 to 60; default: the parameter `impact.velocity`.
            direction: direction of travel [rad], above -pi and at most pi; 0 bends the column about its strong axis. In any other
                direction, the two bars take the component of the motion in their plane. Default: the parameter `impact.direction`.
            model: model by which the impact is judged: `bars`, the two bars; `beam`, the fibre beam alone; or `both`.

        Raises:
            ParameterError: an impact that is not accepted, or a model that `beam.mode` switches off.
            SimulationError: a response that cannot be computed, or `model="beam"` where the beam has no result. A collapse is a result.

        Warns:
            ParameterWarning: a mass that this vehicle cannot have, such as one in tonnes.
        """
        vehicle = _name(vehicle, mass=mass, velocity=velocity, direction=direction)
        names, columns, report = self._towards(direction).simulate(vehicle, mass, velocity, str(model))
        history = {name: _read_only(it) for name, it in zip(names, columns)}
        fields = json.loads(report)
        if velocity is None:
            velocity = float(self._native.get("impact.velocity"))
        who = fields["vehicle"] or "a user-defined vehicle"
        of = "" if mass is None else f" of {mass:g} kg"
        turned = "" if direction is None else f", {np.degrees(direction):g} degrees"
        result = Result(f"{self._title()}, {who}{of} at {velocity:g} m/s{turned}", history, fields)
        result._impact, result._struck = (vehicle, mass, velocity, direction), self._native.to_json()
        return result

    def evaluate(
        self,
        vehicle: str | None = None,
        *,
        mass: float | None = None,
        velocity: float | None = None,
        direction: float | None = None,
    ) -> Evaluation:
        """One impact by the two bars without its history: action, displacements, contact force and capacity.

        >>> column.evaluate("van", velocity=8.0).action

        Args:
            vehicle: as in `simulate`.
            mass: as in `simulate` [kg].
            velocity: as in `simulate` [m/s].
            direction: direction of travel [rad], as in `simulate`.

        Raises:
            ParameterError: an impact that is not accepted.
            SimulationError: a response that cannot be computed. A collapse is a result.

        Warns:
            ParameterWarning: a mass that this vehicle cannot have, such as one in tonnes.
        """
        vehicle = _name(vehicle, mass=mass, velocity=velocity, direction=direction)
        found = self._towards(direction).evaluate(vehicle, mass, velocity)
        return Evaluation._of(float(self._native.get("impact.velocity") if velocity is None else velocity), *found)

    def evaluate_batch(
        self,
        vehicle: str | None = None,
        *,
        mass: npt.ArrayLike | None = None,
        velocity: npt.ArrayLike | None = None,
        direction: float | None = None,
        threads: int | None = None,
    ) -> npt.NDArray[np.void]:
        """Many impacts by the two bars, on all processors. Each row equals the result of `evaluate` bit for bit.

        All impacts are checked before the first one is computed. Other Python threads run meanwhile, and Ctrl-C ends the call within
        0.2 s. The memory that it needs is at most three times the memory of the array that it returns.

        >>> column.evaluate_batch("van", velocity=np.linspace(1.0, 20.0, 1000))

        Args:
            vehicle: as in `simulate`.
            mass: total masses of the vehicle [kg], a number or an array; default: as in `simulate`.
            velocity: speeds of the vehicle [m/s], a number or an array; default: the parameter `impact.velocity`. Mass and velocity are
                broadcast against each other.
            direction: direction of travel of all impacts [rad], as in `simulate`.
            threads: number of threads; default: as many as there are processors. The result does not depend on it.

        Returns:
            An array of the broadcast shape and of the structured type `EVALUATION`, in SI units. `to_pandas` makes a table of it.

        Raises:
            ParameterError: an impact that is not accepted, an element that is masked or no number, or shapes that do not fit together.
                The text contains the index of the first such element in the flattened array.
            SimulationError: a response that cannot be computed; the text contains the index of its element.

        Warns:
            ParameterWarning: a mass that this vehicle cannot have, such as one in tonnes, with the index of the first such element.
            UserWarning: more threads than are useful; the text states how many are used.
        """
        vehicle = _name(vehicle, direction=direction)
        if velocity is None:
            velocity = float(self._native.get("impact.velocity"))
        speeds = numbers("velocity", velocity)
        if mass is None:
            shape, weights = speeds.shape, None
        else:
            masses = numbers("mass", mass)
            try:
                both = np.broadcast_arrays(masses, speeds)
            except ValueError as reason:
                raise ParameterError(
                    f"mass and velocity: expected shapes that can be broadcast against each other, found {masses.shape} and {speeds.shape}"
                ) from reason
            shape, weights, speeds = both[0].shape, both[0].tobytes(), both[1]
        rows = self._towards(direction).evaluate_batch(vehicle, weights, speeds.tobytes(), _threads(threads))
        table = table_of(rows).reshape(shape)
        # As in `Evaluation`, where the native part has the component in the plane of the two bars.
        table["velocity"] = speeds
        return table

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

        An axis is `mass` [kg], `velocity` [m/s], `height` of the impact point above the base [m], `direction` of travel [rad], `section`,
        `vehicle`, or any parameter that is a number (`top__load`) in its SI unit. Its values are a `Range`, a list or an array of numbers
        in ascending order, or a list of names of a catalogue. It can also be a text in the notation of `column-twin map`, in which a
        direction is in degrees. Each axis has at least two values. All quantities that are not axes have the values of the column.

        >>> column.map(mass=Range(2000, 12000, points=50), velocity=Range(1, 25, points=50), vehicle="lorry_8t")
        >>> column.map("section=HEB 200,HEB 240,HEB 300", velocity=np.linspace(1.0, 20.0, 50), vehicle="van")
        >>> column.map(velocity=Range(1, 25, points=50), top__load=[2e5, 5e5], compare={"section": ["HEB 220", "HEB 300"]})
        >>> column.map(direction=np.radians([0.0, 45.0, 90.0]), velocity=[4.0, 8.0], vehicle="mid_car", model="both")
        >>> column.map(top__load=[2e5, 5e5], vehicle=["van", "mid_car"], mass=[1500, 2500], velocity=Range(2, 12, points=6))

        The velocity is the last axis of the arrays, and the mass is the one before it; vehicle and direction follow all other quantities.
        Apart from that, the axes are in the order in which they are given. The last two axes are the rows and columns of figures;
        `Map.at` chooses values of the others, which may have at most 10 000 combinations. A map has at most 1e8 cells.

        Other Python threads run meanwhile, and Ctrl-C ends the call within 0.2 s.

        On a column that an earlier impact has damaged, every cell is one more impact: mass, velocity, vehicle and direction can vary, and
        the two bars judge.

        Args:
            axes: axes in the notation of the command line, such as `velocity=1:25:100`.
            vehicle: the vehicle of all cells, as in `simulate`; a list of names is an axis.
            compare: one more quantity with its values; the map has a label for each value, and the same axes for each label.
            shard: the number of a part, from 1, and the number of parts, such as (1, 4): only this part is computed, for example on one of
                several machines, and all other cells are masked. `Map.merged` joins the parts.
            threads: number of threads; default: as many as there are processors. The result does not depend on it.
            model: model by which an impact is judged: `bars`, the two bars; `beam`, the fibre beam alone; `both`, the more severe
                verdict of both where the beam counts, as in a node. The beam takes about 0.1 s of processor time for each cell, and
                `Map.beam` contains its results.
            changes: axes by the names of parameters, with dots.
            ranges: axes by keywords, in which two underscores are a dot.

        Raises:
            ParameterError: axes, values, or a number of cells that are not accepted; on a damaged column, also an axis or a comparison
                of a quantity that belongs to the column, or a model other than `bars`.

        Warns:
            IncompleteWarning: cells that cannot be computed. They are masked, and `Map.failures` contains the reasons.
            ParameterWarning: a mass that a vehicle cannot have, such as one in tonnes.
            UserWarning: more threads than are useful; the text states how many are used.
        """
        vehicle, given, compared = self._planned(axes, vehicle, compare, changes, ranges)
        part = None if shard is None else _shard(shard)
        computed = self._native.map(_map_request(vehicle, given, compared, threads, model), part)
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
        """The boundaries of the actions on a map over two quantities, to 1 %, without its cells, as by `column-twin map --refine`.

        >>> column.refined_map(mass=Range(1000, 3000, points=20), velocity=Range(1, 20, points=40), vehicle="van").plot()

        Args:
            axes: as in `map`, two axes in all. The axis of the columns, such as the velocity, is a `Range`, along which a boundary is
                searched.
            vehicle: the vehicle of all responses, as in `simulate`.
            compare: as in `map`.
            threads: as in `map`.
            model: as in `map`.
            changes: as in `map`.
            ranges: as in `map`.

        Raises:
            ParameterError: as in `map`, more than two axes, or an axis of the columns that is a list.

        Warns:
            IncompleteWarning: rows that cannot be computed in whole; `RefinedMap.report` contains the reasons.
            UserWarning: more threads than are useful; the text states how many are used.
        """
        vehicle, given, compared = self._planned(axes, vehicle, compare, changes, ranges)
        refined = RefinedMap._of(json.loads(self._native.refine(_map_request(vehicle, given, compared, threads, model))))
        faults = refined.report["refined"]["faults"]
        if faults:
            warnings.warn(
                f"{len(faults)} of the rows cannot be computed in whole; the first, row {faults[0]['row']}: {faults[0]['reason']}",
                IncompleteWarning,
                stacklevel=3,
            )
        return refined

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
        for axis in axes:
            if not isinstance(axis, str):
                raise TypeError(f"map: expected an axis as a text, such as 'velocity=1:25:100', or as a keyword; found {axis!r}")
        if changes is not None and not isinstance(changes, Mapping):
            raise TypeError(f"changes: expected a mapping of names of quantities to values, found {type(changes).__name__}")
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
        if compare is not None and not isinstance(compare, str):
            raise TypeError(f"compare: expected a quantity with its values, such as {{'section': ['HEB 220', 'HEB 300']}}; found {compare}")
        return vehicle, given, compare

    def sensor_readings(
        self,
        vehicle: str | None = None,
        *,
        mass: float | None = None,
        velocity: float | None = None,
        seed: int = 1,
    ) -> Readings:
        """The simulated readings of the sensors of the column in an impact, with their errors, as `column-twin simulate --readings` writes
        them.

        The parameter `sensors.names` declares the sensors, as in config/sensors_industrial.yaml; docs/estimation.md describes them.

        >>> sensed = Column.from_file("config/heb220_s355.yaml", "config/sensors_industrial.yaml")
        >>> readings = sensed.sensor_readings("mid_car", velocity=12.0)

        Args:
            vehicle: as in `simulate`.
            mass: as in `simulate` [kg].
            velocity: as in `simulate` [m/s].
            seed: seed of the random errors, a whole number from 0 to 2^64 - 1; the same seed gives the same readings.

        Raises:
            ParameterError: an impact or a seed that is not accepted, a column without sensors, or a damaged column.
            SimulationError: a response that cannot be computed.

        Warns:
            ParameterWarning: a mass that this vehicle cannot have, such as one in tonnes.
        """
        vehicle = _name(vehicle, mass=mass, velocity=velocity)
        return Readings(self._native.sensor_readings(vehicle, mass, velocity, _seed(seed)))

    def estimate(self, readings: Readings | str | os.PathLike[str], *, seed: int = 1) -> ImpactEstimate | None:
        """The vehicle that struck the undamaged column, estimated from the readings of its sensors, as `column-twin estimate` computes it.
        It takes seconds.

        >>> print(sensed.estimate(readings))

        Args:
            readings: readings from `sensor_readings`, or a file in the format of `Readings.csv`.
            seed: seed of the random numbers, a whole number from 0 to 2^64 - 1; the same seed gives the same estimate.

        Returns:
            The estimate; None if the readings contain no impact.

        Raises:
            ParameterError: a file that cannot be read, readings that do not fit the sensors of the column, a column without sensors, or
                a damaged column.
        """
        if not isinstance(readings, Readings):
            readings = Readings.from_file(readings)
        found = self._native.estimate(readings.csv, _seed(seed))
        return None if found is None else ImpactEstimate(json.loads(found))

    def critical_velocities(
        self, vehicle: str | None = None, *, mass: float | None = None, lowest: float = 0.1, highest: float = 60.0
    ) -> dict[Action, CriticalVelocity]:
        """The velocities of a vehicle above which its impact has each action, to 1 %, by the two bars.

        A scan goes up from `lowest` in equal ratios of at most 1.1 until it finds the most severe action or reaches `highest`. The
        interval before the first velocity with an action is then halved until its ends differ by at most 1 %. A range of velocities
        with a more severe action that lies between two velocities of the scan is not found.

        >>> column.critical_velocities("lorry_8t")[Action.SHORE].at

        Args:
            vehicle: as in `simulate`.
            mass: as in `simulate` [kg].
            lowest: velocity at which the scan begins [m/s].
            highest: velocity at which the scan ends [m/s], at most 60.

        Returns:
            The critical velocity of each action from INSPECT to EVACUATE.

        Raises:
            ParameterError: an impact that is not accepted, or a lowest velocity that is not below the highest one.
            SimulationError: a response that cannot be computed.

        Warns:
            ParameterWarning: a mass that this vehicle cannot have, such as one in tonnes.
        """
        vehicle = _name(vehicle, mass=mass, lowest=lowest, highest=highest)
        brackets, _ = self._native.critical_velocities(vehicle, mass, lowest, highest)
        return _brackets(brackets)

    def critical_velocity(
        self,
        action: Action,
        vehicle: str | None = None,
        *,
        mass: float | None = None,
        lowest: float = 0.1,
        highest: float = 60.0,
    ) -> CriticalVelocity:
        """The velocity of a vehicle above which its impact has this action or a more severe one, to 1 %, as `critical_velocities` finds it.

        >>> column.critical_velocity(Action.SHORE, "lorry_8t").at

        Args:
            action: the action, from INSPECT to EVACUATE.
            vehicle: as in `critical_velocities`.
            mass: as in `critical_velocities` [kg].
            lowest: as in `critical_velocities` [m/s].
            highest: as in `critical_velocities` [m/s].

        Raises:
            ParameterError: as in `critical_velocities`, and an action that is not one from INSPECT to EVACUATE.
            SimulationError: a response that cannot be computed.

        Warns:
            ParameterWarning: a mass that this vehicle cannot have, such as one in tonnes.
        """
        action = expect_action(action)
        vehicle = _name(vehicle, mass=mass, lowest=lowest, highest=highest)
        # Not by `critical_velocities`, so that a warning names the caller.
        brackets, _ = self._native.critical_velocities(vehicle, mass, lowest, highest)
        return _brackets(brackets)[action]

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
        """The probability that vehicles which leave the road damage the column, by Monte Carlo simulation, as by `column-twin risk`.
        docs/risk.md describes the model and the sources of its data.

        Other Python threads run meanwhile, and Ctrl-C ends the call within 0.2 s.

        >>> column.risk("parking_garage", vehicles_per_day=2000, distance=0.5, samples=20_000)
        >>> any_way = ["orientation_deg=uniform:-90:90"]
        >>> column.risk("courtyard", vehicles_per_day=50, distributions=any_way, model="both", samples=50)

        Args:
            scenario: `motorway`, `urban`, `courtyard`, `parking_garage`, or the name of a scenario in the file `scenarios`.
            vehicles_per_day: number of vehicles that pass the column each day [1/d].
            years: period for which the probabilities hold [a].
            distance: distance of the column from the edge of the road [m]; default: the example of the scenario, so give your own.
            distributions: other distributions of inputs, such as `speed_km_h=lognormal:12:5`, or `orientation_deg=uniform:-90:90` for
                columns whose webs stand in any direction to the road. The inputs are the entries of config/risk.json, whose names end
                with their units; docs/risk.md lists the distributions.
            scenarios: file with your own scenarios, in the format of config/risk.json; default: the scenarios of the program.
            samples: number of vehicles that are drawn, at least 1.
            seed: seed of the random numbers, a whole number from 0 to 2^64 - 1; the same seed gives the same result.
            confidence: confidence level of the intervals, from 0.5 to 0.9999.
            exact: whether the response of every sample is computed; otherwise, critical speeds predict most of them.
            threads: number of threads; default: as many as there are processors. The result does not depend on it.
            model: model by which a sample is judged, as in `map`. The two bars predict most samples, and the beam computes the doubtful
                ones and a share of the others.

        Raises:
            ParameterError: a scenario, a distribution or a number that is not accepted, a file that cannot be read, or a damaged column.
            SimulationError: a study that cannot be computed.

        Warns:
            UserWarning: more threads than are useful; the text states how many are used.
        """
        if not isinstance(scenario, str):
            raise ParameterError(f"scenario: expected a name such as 'urban', found {scenario!r}")
        expect_numbers({"vehicles_per_day": vehicles_per_day, "years": years, "distance": distance, "confidence": confidence})
        for name, number in (("vehicles_per_day", vehicles_per_day), ("years", years)):
            if not 0.0 < float(number) < np.inf:
                raise ParameterError(f"{name} {number}: expected a finite number > 0")
        if not 0.5 <= float(confidence) <= 0.9999:
            raise ParameterError(f"confidence {confidence}: expected a number from 0.5 to 0.9999, such as 0.95")
        text = None if scenarios is None else (os.fspath(scenarios), read_text("scenarios", scenarios))
        # A text is a sequence of letters, too.
        others = [distributions] if isinstance(distributions, str) else list(distributions)
        moved = [] if distance is None else [f"distance_m=fixed:{float(distance)!r}"]
        report = self._native.risk(
            {
                "scenario": scenario,
                "scenarios": text,
                "distributions": moved + others,
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
        self,
        vehicle: str | None = None,
        *,
        mass: float | None = None,
        velocity: float | None = None,
        direction: float | None = None,
    ) -> Capacity:
        """The axial capacity of the column in its present state, or, with arguments, after one impact on the undamaged column.

        A static push-down finds the largest force that the column carries; docs/assessment.md describes it.

        >>> column.capacity("lorry_8t", velocity=7.0).reserve

        Args:
            vehicle: as in `simulate`.
            mass: as in `simulate` [kg].
            velocity: as in `simulate` [m/s].
            direction: direction of travel [rad], as in `simulate`.

        Raises:
            ParameterError: an impact that is not accepted, an impact on a damaged column, or a push-down that cannot be computed.
            SimulationError: a response that cannot be computed.

        Warns:
            ParameterWarning: a mass that this vehicle cannot have, such as one in tonnes.
        """
        if all(it is None for it in (vehicle, mass, velocity, direction)):
            report, curve = self._native.capacity()
        else:
            vehicle = _name(vehicle, mass=mass, velocity=velocity, direction=direction)
            report, curve = self._towards(direction).capacity_after(vehicle, mass, velocity)
        return Capacity(json.loads(report), PushDown(*map(_read_only, curve)))

    def _towards(self, direction: float | None) -> native.Column:
        """The native part whose impacts have this direction of travel [rad]."""
        direction = _direction(direction)
        return self._native if direction is None else self._native.towards(direction)

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

"""Damage maps and critical velocities."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._codes import Action, expect_action
from ._errors import ParameterError
from ._evaluation import CATEGORIES, CELL, UNITS
from ._keyword_check import nearest
from ._range import expect_numbers

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes


_NOT_COMPUTED = tuple(np.nan if CELL[name] == np.float64 else 255 for name in CELL.names or ())
"""A cell without numbers."""


class CriticalVelocity(NamedTuple):
    """The velocity above which the impact of a vehicle has an action or a more severe one. It lies between `below` and `at`, which differ
    by at most 1 %; one of them is None where the search found no such velocity."""

    below: float | None
    """Largest velocity of the search below the critical one, at which the action is not reached [m/s]; None if the lowest velocity
    of the search reaches the action."""
    at: float | None
    """Smallest velocity of the search at which the action is reached [m/s]; None if no velocity of the search reaches the action."""


@dataclass(frozen=True, eq=False)
class MapAxis:
    """The quantity of an axis of a map, and its values."""

    name: str
    """`mass`, `velocity`, `height`, `section`, `vehicle`, `direction`, or the name of a parameter with dots."""
    title: str
    """The quantity in words."""
    unit: str
    """SI unit, or `degrees` for a direction that was given in the notation of the command line; empty for a quantity without unit."""
    values: npt.NDArray[Any]
    """The values, of shape (points,): numbers in ascending order, or names of a catalogue."""

    @property
    def label(self) -> str:
        """Title and unit, as the label of an axis in a figure."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    def __len__(self) -> int:
        return int(self.values.size)

    def _place(self, value: object) -> int:
        """The place of a value; of numbers, differences by rounding do not count."""
        if self.values.dtype.kind == "U":
            wanted = "".join(str(value).split()).casefold()
            found = [index for index, it in enumerate(self.values) if str(it).casefold() == wanted]
        else:
            expect_numbers({self.name: value})
            try:
                found = list(np.flatnonzero(np.isclose(self.values, float(value), rtol=1e-9, atol=0.0)))  # type: ignore[arg-type]
            except (TypeError, ValueError):
                found = []
        if len(found) != 1:
            raise ParameterError(f"{self.name}: expected one of {_listed(self.values)}; found {value!r}")
        return int(found[0])

    def _text(self, place: int) -> str:
        """The name of a value, or the number with title and unit."""
        value = self.values[place]
        return str(value) if self.values.dtype.kind == "U" else f"{self.title} {value:g} {self.unit}".rstrip()


def _place_of(label: str | None, labels: list[str]) -> int:
    """The place of a label; without one, the first place."""
    if label is not None and label not in labels:
        raise ParameterError(f"label: expected one of {', '.join(labels)}; found {label!r}")
    return 0 if label is None else labels.index(label)


def _listed(values: npt.NDArray[Any]) -> str:
    """The values in words; of many, the first and the last."""
    texts = [str(it) for it in values.tolist()]
    return ", ".join(texts if len(texts) <= 8 else [*texts[:4], "...", texts[-1]])


@dataclass(frozen=True, eq=False)
class Map:
    """A damage map: action, displacements, capacity and contact force over two quantities or more, for one column or several.
    `Column.map` computes it.

    `map["max_v1"]` is the array of one field, and iteration gives the names of the fields:

    >>> damage = column.map(mass=[1500, 2500], velocity=[4.0, 8.0], vehicle="van")
    >>> (damage["action"] >= Action.SHORE).mean()
    """

    rows: MapAxis
    """The axis of the rows, the last but one of the arrays: the mass in a map over mass and velocity."""
    columns: MapAxis
    """The axis of the columns, the last one of the arrays: the velocity in a map over mass and velocity."""
    labels: list[str]
    """The labels of the columns that are compared; one label where nothing is compared."""
    cells: npt.NDArray[np.void]
    """A structured array of the fields of `EVALUATION` except mass and velocity, of shape (labels, further axes, rows, columns); the axis
    of the labels exists only in a comparison. It is masked where a cell could not be computed or belongs to another part of the map:
    comparisons, sums and means leave masked cells out. Without the mask, numbers are NaN there and codes are 255. With `model="beam"`,
    `max_v1` and `residual_v1` are displacements in any direction, as magnitudes."""
    failures: dict[tuple[int, ...], str]
    """The reasons for which cells could not be computed, by the indices of the cells in `cells`."""
    compared: str | None = None
    """The quantity that is compared, whose values the labels contain; None where nothing is compared."""
    part: tuple[int, int] | None = None
    """For a part of a map, the number of its first cell and the number after its last cell, counted from 0 in the flattened array; None
    for a whole map."""
    model: str = "bars"
    """The model by which the impacts are judged: `bars`, `beam` or `both`."""
    beam: dict[str, npt.NDArray[Any]] = field(default_factory=dict)
    """The results of the fibre beam by their names, such as `beam_max_sideways_m`, in arrays of the shape of `cells`: numbers in SI
    units, NaN where there is no number, and words, None where there is no word. `no_second_opinion` gives the reason for which the
    beam has no answer. It is empty with `model="bars"`; docs/study.md lists the names."""
    beam_units: dict[str, str] = field(default_factory=dict)
    """The SI unit of each entry of `beam`; empty for one without unit."""
    further: tuple[MapAxis, ...] = ()
    """The axes of a map over more than two quantities that are neither rows nor columns, in the order of the arrays."""
    fixed: tuple[MapAxis, ...] = ()
    """The axes from which `at` has chosen a value, each with this value alone."""

    @property
    def axes(self) -> tuple[MapAxis, ...]:
        """All axes of quantities, in the order of the arrays; in a comparison, the axis of the labels comes before them."""
        return (*self.further, self.rows, self.columns)

    @classmethod
    def _of(cls, computed: dict[str, Any], compared: str | None) -> Map:
        axes = [
            MapAxis(it["name"], it["title"], it["unit"], np.asarray(it["values"]))
            for it in (*computed["further"], computed["rows"], computed["columns"])
        ]
        labels: list[str] = computed["labels"]
        shape = (*([len(labels)] if compared is not None else []), *map(len, axes))
        table = np.frombuffer(computed["cells"], dtype=CELL)
        first: int = computed["first"]
        failures = {first + index: text for index, text in computed["failures"].items()}
        end = first + table.size
        part = None if table.size == int(np.prod(shape)) else (first, end)
        beam = {
            name: np.frombuffer(values, dtype=np.float64) if isinstance(values, bytearray) else np.array(values, dtype=object)
            for name, _, _, values in computed["beam"]
        }
        damage = cls._of_cells(axes, labels, compared, table, failures, part, beam)
        return replace(damage, model=computed["model"], beam_units={name: unit for name, unit, _, _ in computed["beam"]})

    @classmethod
    def _of_cells(
        cls,
        axes: Sequence[MapAxis],
        labels: list[str],
        compared: str | None,
        table: npt.NDArray[np.void],
        failures: dict[int, str],
        part: tuple[int, int] | None,
        beam: dict[str, npt.NDArray[Any]],
    ) -> Map:
        """A map of the cells of `part` and what the beam says of them, with the failures by the numbers of their cells."""
        shape = (*([len(labels)] if compared is not None else []), *map(len, axes))
        count = int(np.prod(shape))

        def whole(values: npt.NDArray[Any], missing: Any) -> npt.NDArray[Any]:
            if part is None:
                return values.reshape(shape)
            cells = np.full(count, missing, dtype=values.dtype)
            cells[slice(*part)] = values
            return cells.reshape(shape)

        cells = whole(table, np.array(_NOT_COMPUTED, dtype=CELL))
        if failures or part is not None:
            out = np.full(cells.size, part is not None)
            if part is not None:
                out[slice(*part)] = False
            out[list(failures)] = True
            mask: Any = np.zeros(shape, dtype=np.ma.make_mask_descr(CELL))
            for name in CELL.names or ():
                mask[name] = out.reshape(shape)
            cells = np.ma.MaskedArray(cells, mask=mask)
        places = {tuple(int(it) for it in np.unravel_index(index, shape)): text for index, text in failures.items()}
        of_beam = {name: whole(it, None if it.dtype == object else np.nan) for name, it in beam.items()}
        *further, rows, columns = axes
        return cls(rows, columns, labels, cells, places, compared, part, beam=of_beam, further=tuple(further))

    @classmethod
    def merged(cls, parts: Sequence[Map]) -> Map:
        """The whole map from its parts, which `Column.map` has computed with each `shard`, on any machines and in any order.

        >>> masses, velocities = Range(1000, 3000, points=20), Range(1, 20, points=40)
        >>> parts = [column.map(mass=masses, velocity=velocities, shard=(number, 4)) for number in (1, 2, 3, 4)]
        >>> Map.merged(parts)

        Raises:
            ParameterError: parts of different maps, a part that is missing, or none at all.
        """
        ordered = sorted((it for it in parts), key=lambda it: it.part or (0, it.cells.size))
        if not ordered:
            raise ParameterError("merged: expected the parts of a map, found none")
        one = ordered[0]
        reached = 0
        failures: dict[int, str] = {}
        tables = []
        of_beam: dict[str, list[npt.NDArray[Any]]] = {name: [] for name in one.beam}
        for it in ordered:
            same = (it.labels, it.compared, len(it.axes)) == (one.labels, one.compared, len(one.axes)) and all(
                (mine.name, mine.unit) == (its.name, its.unit) and np.array_equal(mine.values, its.values)
                for mine, its in zip(one.axes, it.axes)
            )
            if not same:
                raise ParameterError("merged: expected parts of one map, found parts with different axes")
            if it.model != one.model:
                raise ParameterError(f"merged: expected parts of one map, found one by the model {one.model!r} and one by {it.model!r}")
            first, end = it.part or (0, it.cells.size)
            if first != reached:
                raise ParameterError(f"merged: expected a part that begins with cell {reached}, found one that begins with {first}")
            reached = end
            tables.append(it._data.reshape(-1)[first:end])
            for name, parts_of_beam in of_beam.items():
                parts_of_beam.append(it.beam[name].reshape(-1)[first:end])
            failures |= {int(np.ravel_multi_index(place, it.cells.shape)): text for place, text in it.failures.items()}
        if reached != one.cells.size:
            raise ParameterError(f"merged: the cells from {reached} to {one.cells.size - 1} are missing")
        beam = {name: np.concatenate(them) for name, them in of_beam.items()}
        damage = cls._of_cells(one.axes, one.labels, one.compared, np.concatenate(tables), failures, None, beam)
        return replace(damage, model=one.model, beam_units=one.beam_units)

    @property
    def _data(self) -> npt.NDArray[np.void]:
        """The cells without their mask: numbers are NaN and codes 255 where there is nothing."""
        return np.ma.getdata(self.cells)

    def __getitem__(self, field: str) -> npt.NDArray[Any]:
        """The array of one field of `cells`, such as `map["max_v1"]` [m] or `map["action"]`, with its mask.

        Raises:
            ParameterError: a field that a map does not have.
        """
        if field not in self:
            names = CELL.names or ()
            meant = nearest(str(field), names)
            hint = f" (did you mean {meant}?)" if meant else "; `axes` has the values of the axes, and `beam` the results of the fibre beam"
            raise ParameterError(f"a map has the fields {', '.join(names)}; found {field!r}{hint}")
        return self.cells[field]

    def __iter__(self) -> Iterator[str]:
        """The names of the fields."""
        return iter(CELL.names or ())

    def to_pandas(self) -> pd.DataFrame:
        """The map as a table. Needs pandas.

        Returns:
            One row for each cell, in the order of the flattened array. The columns are the label, all axes, the axes from which `at` has
            chosen a value, the fields in SI units, and the results of the beam. Action, outcome and criterion are categories of words;
            a cell that was not computed has no values.
        """
        import pandas as pd

        names = ["label", *(axis.name for axis in self.axes)]
        places = np.meshgrid(np.array(self.labels), *(axis.values for axis in self.axes), indexing="ij", sparse=False)
        table = pd.DataFrame({name: values.ravel() for name, values in zip(names, places)})
        for axis in self.fixed:
            table[axis.name] = axis.values[0]
        flat = self._data.reshape(-1)
        for name in flat.dtype.names or ():
            if name in CATEGORIES:
                codes = flat[name].astype(np.int64)
                codes[codes == 255] = -1
                words = pd.Index(CATEGORIES[name])
                table[name] = pd.Categorical.from_codes(codes.tolist(), words, ordered=name == "action")
            else:
                table[name] = flat[name]
        for name, values in self.beam.items():
            table[name] = values.reshape(-1)
        return table

    def to_xarray(self) -> xr.Dataset:
        """The map as a data set of xarray. Needs xarray.

        >>> damage.to_xarray().max_v1.sel(velocity=10.0, method="nearest")

        Returns:
            One variable for each field and each result of the beam, with its unit as the attribute `units`. Each axis and the compared
            quantity are dimensions with coordinates; a dot in the name of a parameter is an underscore (`top_load`). Codes are numbers
            with `flag_values` and `flag_meanings`. A cell that was not computed is NaN.
        """
        import xarray as xr

        def notes_of(axis: MapAxis) -> dict[str, Any]:
            return {"units": axis.unit or "1", "long_name": axis.title}

        names = [axis.name.replace(".", "_") for axis in self.axes]
        coordinates: dict[str, Any] = {name: (name, axis.values, notes_of(axis)) for name, axis in zip(names, self.axes)}
        for axis in self.fixed:
            coordinates[axis.name.replace(".", "_")] = ((), axis.values[0], notes_of(axis))
        if self.compared is not None:
            label = self.compared.replace(".", "_")
            names.insert(0, label)
            coordinates[label] = (label, np.array(self.labels), {"long_name": self.compared})
        fields: dict[str, Any] = {}
        for name in self._data.dtype.names or ():
            values = self._data[name]
            if name in CATEGORIES:
                values = np.where(values == 255, np.nan, values.astype(np.float64))
                words = CATEGORIES[name]
                notes: dict[str, Any] = {"flag_values": list(range(len(words))), "flag_meanings": " ".join(words)}
            else:
                notes = {"units": UNITS[name]}
            fields[name] = (names, values, notes)
        for name, values in self.beam.items():
            notes = {} if values.dtype == object else {"units": self.beam_units[name] or "1"}
            fields[name] = (names, values, notes)
        return xr.Dataset(fields, coordinates, {"model": self.model})

    def at(self, values: Mapping[str, object] | None = None, /, **keywords: object) -> Map:
        """The part of the map at one value of some of its `further` axes. With one value of each of them, it has two axes, and `plot` can
        draw it.

        >>> damage = column.map(top__load=[2e5, 6e5], mass=[1500, 2500], velocity=[4.0, 8.0], vehicle="van")
        >>> damage.at(top__load=6e5).plot()

        Args:
            values: values by the names of their axes, with dots: numbers in the unit of the axis, or names.
            keywords: values by keywords, in which two underscores are a dot.

        Raises:
            ParameterError: a name that is not a further axis, a value that the axis does not have, or a part of a map.
        """
        if self.part is not None:
            raise ParameterError("at: expected a whole map, found a part of one; put its parts together with Map.merged")
        chosen = {**(values or {}), **{name.replace("__", "."): value for name, value in keywords.items()}}
        names = [axis.name for axis in self.further]
        for name in chosen:
            if name not in names:
                raise ParameterError(f"at: expected one of the further axes, {', '.join(names) or 'of which there are none'}; found {name}")
        places = [axis._place(chosen[axis.name]) if axis.name in chosen else None for axis in self.further]
        # In front of the further axes there are the labels of a comparison, behind them the plane.
        ahead = [None] if self.compared is not None else []
        whole = [*ahead, *places, None, None]
        index = tuple(slice(None) if it is None else it for it in whole)
        failures = {
            tuple(it for it, fixed in zip(place, whole) if fixed is None): text
            for place, text in self.failures.items()
            if all(fixed in (None, it) for it, fixed in zip(place, whole))
        }
        fixed = [replace(axis, values=axis.values[[it]]) for axis, it in zip(self.further, places) if it is not None]
        return replace(
            self,
            cells=self.cells[index],
            failures=failures,
            beam={name: of_beam[index] for name, of_beam in self.beam.items()},
            further=tuple(axis for axis, it in zip(self.further, places) if it is None),
            fixed=(*self.fixed, *fixed),
        )

    def plot(self, ax: Axes | None = None, label: str | None = None) -> Axes:
        """Draws the action as colours, and lines of equal residual displacement [mm]. Needs matplotlib.

        Args:
            ax: axes to draw on; default: new ones.
            label: in a comparison, the label of the column that is drawn; default: the first one.

        Returns:
            The axes.

        Raises:
            ParameterError: a label that the map does not have, or a map over more than two quantities, of which `at` chooses a plane.
        """
        from . import _figures

        return _figures.damage_map(self, ax, label)

    def _of_label(self, label: str | None) -> npt.NDArray[np.void]:
        if self.further:
            plane = ", ".join(f"{axis.name.replace('.', '__')}={axis.values[0].item()!r}" for axis in self.further)
            raise ParameterError(
                f"plot: a figure shows two axes, and this map has {len(self.axes)}; choose a plane, such as map.at({plane}).plot()"
            )
        cells = self._data
        if cells.ndim == 2:
            return cells
        of_label: npt.NDArray[np.void] = cells[_place_of(label, self.labels)]
        return of_label

    def __repr__(self) -> str:
        worst = [str(it) for it in Action if (self._data["action"] == it).any()]
        names = " and ".join(axis.name for axis in self.axes)
        return f"<Map {' x '.join(str(it) for it in self.cells.shape)}, {names}: {', '.join(worst)}>"

    def _repr_html_(self) -> str:
        from . import _html

        return _html.damage_map(self)


@dataclass(frozen=True, eq=False)
class RefinedMap:
    """The boundaries of the actions over a plane of two quantities: the value on the axis of the columns at which an action begins, by the
    value on the axis of the rows, to 1 %. `Column.refined_map` computes it."""

    report: dict[str, Any]
    """`rows` and `columns`, the axes with `name`, `unit` and `values`; `labels`; `model`; and `refined`, the boundaries as
    `column-twin map --refine` writes them. Values are in SI units."""

    @classmethod
    def _of(cls, report: dict[str, Any]) -> RefinedMap:
        return cls(report)

    @property
    def responses(self) -> int:
        """Number of responses that were computed."""
        return int(self.report["refined"]["responses"])

    def boundary(self, action: Action, label: str | None = None) -> tuple[npt.NDArray[Any], npt.NDArray[np.float64]]:
        """The boundary from which on an action, or a more severe one, is required.

        >>> masses, velocities = column.refined_map(mass=[1500, 2500], velocity=Range(1, 20, points=20)).boundary(Action.SHORE)

        Args:
            action: the action, from INSPECT to EVACUATE.
            label: in a comparison, the label of the column; default: the first one.

        Returns:
            Two arrays of the same length: values on the axis of the rows, or the numbers of the rows from 0 where their values are names,
            and for each of them the value on the axis of the columns. They contain the rows that were computed, between which
            interpolation is exact to 1 %, without those in which the action is required everywhere or nowhere.

        Raises:
            ParameterError: an action or a label that the map does not have.
        """
        name = str(expect_action(action))
        variant = _place_of(label, self.report["labels"])
        boundaries = self.report["refined"]["boundaries"]
        found = next(it for it in boundaries if it["variant"] == variant and it["action"] == name)
        between = [it for it in found["points"] if it["place"]["kind"] == "between"]
        values = self.report["rows"]["values"]
        rows = np.array([values[it["row"]] if values else it["row"] for it in between])
        return rows, np.array([0.5 * (it["place"]["below"] + it["place"]["at"]) for it in between], dtype=np.float64)

    def plot(self, ax: Axes | None = None, label: str | None = None) -> Axes:
        """Draws the boundaries of all actions. Needs matplotlib.

        Args:
            ax: axes to draw on; default: new ones.
            label: in a comparison, the label of the column; default: the first one.

        Returns:
            The axes.

        Raises:
            ParameterError: a label that the map does not have.
        """
        from . import _figures

        return _figures.boundaries(self, ax, label)

    def __repr__(self) -> str:
        return f"<RefinedMap, {self.report['rows']['name']} and {self.report['columns']['name']}, {self.responses} responses>"

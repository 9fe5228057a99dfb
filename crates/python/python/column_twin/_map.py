"""Damage maps and critical velocities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.lib.recfunctions import repack_fields

from ._codes import Action
from ._evaluation import CATEGORIES, table_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


class CriticalVelocity(NamedTuple):
    """How fast a vehicle may be before its impact has an action: between `below` and `at`, which differ by at most 1 %."""

    below: float | None
    """Largest velocity found below it at which the action is not reached [m/s]; None if the lowest one reaches it."""
    at: float | None
    """Smallest velocity found at which the action is reached [m/s]; None if no velocity reaches it."""


@dataclass(frozen=True, eq=False)
class MapAxis:
    """What varies along an axis of a map, and its values."""

    name: str
    """`mass`, `velocity`, `height`, `section`, `vehicle`, or the name of a parameter."""
    title: str
    """The same in words."""
    unit: str
    """SI unit; empty where there is none."""
    values: npt.NDArray[Any]
    """Numbers, or names of a catalogue."""

    @property
    def label(self) -> str:
        """Title and unit, for a figure."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    def __len__(self) -> int:
        return int(self.values.size)


@dataclass(frozen=True, eq=False)
class Map:
    """Action, displacements, capacity and contact force over a plane of two quantities, for one column or several."""

    rows: MapAxis
    """The first axis of the arrays: of mass and velocity, the mass."""
    columns: MapAxis
    """The second axis of the arrays."""
    labels: list[str]
    """Names of the columns that are compared; one where nothing is compared."""
    cells: npt.NDArray[np.void]
    """The fields of `EVALUATION` but mass and velocity, of shape (rows, columns), or (labels, rows, columns) for a comparison."""
    failures: dict[tuple[int, ...], str]
    """Why cells could not be computed, by their place: their numbers are NaN and their codes 255, above every action."""

    @classmethod
    def _of(cls, computed: dict[str, Any], compared: bool) -> Map:
        axes = [
            MapAxis(it["name"], it["title"], it["unit"], np.asarray(it["values"]))
            for it in (computed["rows"], computed["columns"])
        ]
        labels: list[str] = computed["labels"]
        shape = (*([len(labels)] if compared else []), len(axes[0]), len(axes[1]))
        table = table_of(computed["cells"])
        fields = [name for name in table.dtype.names or () if name not in ("mass", "velocity")]
        failures = {
            tuple(int(it) for it in np.unravel_index(index, shape)): text for index, text in computed["failures"].items()
        }
        return cls(axes[0], axes[1], labels, repack_fields(table[fields]).reshape(shape), failures)

    def __getitem__(self, field: str) -> npt.NDArray[Any]:
        """An array of one field: `map["max_v1"]` [m], `map["action"]`."""
        return self.cells[field]

    def to_pandas(self) -> pd.DataFrame:
        """A table with one row per cell: label, both axes, then the fields, with codes as words. Needs pandas."""
        import pandas as pd

        labels, rows, columns = np.meshgrid(
            np.array(self.labels), self.rows.values, self.columns.values, indexing="ij", sparse=False
        )
        table = pd.DataFrame(
            {"label": labels.ravel(), self.rows.name: rows.ravel(), self.columns.name: columns.ravel()}
        )
        flat = self.cells.reshape(-1)
        for name in flat.dtype.names or ():
            if name in CATEGORIES:
                codes = flat[name].astype(np.int64)
                codes[codes == 255] = -1
                words = pd.Index(CATEGORIES[name])
                table[name] = pd.Categorical.from_codes(codes.tolist(), words, ordered=name == "action")
            else:
                table[name] = flat[name]
        return table

    def plot(self, ax: Axes | None = None, label: str | None = None) -> Axes:
        """Action as colours, and lines of equal residual displacement [mm], of the column `label`. Needs matplotlib."""
        from . import _figures

        return _figures.damage_map(self, ax, label)

    def _of_label(self, label: str | None) -> npt.NDArray[np.void]:
        if self.cells.ndim == 2:
            return self.cells
        if label is None:
            label = self.labels[0]
        if label not in self.labels:
            raise ValueError(f"the map has no column {label!r}; it has {', '.join(self.labels)}")
        plane: npt.NDArray[np.void] = self.cells[self.labels.index(label)]
        return plane

    def __repr__(self) -> str:
        worst = [str(it) for it in Action if (self.cells["action"] == it).any()]
        return (
            f"<Map {' x '.join(str(it) for it in self.cells.shape)}, {self.rows.name} and {self.columns.name}: "
            f"{', '.join(worst)}>"
        )

    def _repr_html_(self) -> str:
        from . import _html

        return _html.damage_map(self)

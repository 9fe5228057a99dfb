"""Readings of the sensors of a column, and the impact that is estimated from them."""

from __future__ import annotations

import csv
import io
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._errors import ParameterError
from ._files import read_text

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings of sensors over time, in the format of `column-twin simulate --readings`, which docs/estimation.md describes.
    `Column.sensor_readings` simulates them, and `from_file` reads recorded ones."""

    csv: str
    """The table in CSV: `time` [s], then one column for each sensor, by its name and in its SI unit. An empty cell is a missing sample."""

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Readings:
        """The readings of a table in CSV, in the format of `csv`.

        Raises:
            ParameterError: a file that cannot be read.
        """
        return cls(read_text("readings", path))

    def to_file(self, path: str | os.PathLike[str]) -> None:
        """Writes the table, which `column-twin measure` publishes and `column-twin estimate` reads. An existing file is replaced.

        Raises:
            OSError: a file that cannot be written.
        """
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.write(self.csv)

    def to_numpy(self) -> dict[str, npt.NDArray[np.float64]]:
        """The columns of the table by their names: `time` [s], and the readings of each sensor in its SI unit. Each array has one value for
        each row, NaN where a sample is missing.

        Raises:
            ParameterError: a text that is not such a table.
        """
        header, *rows = [row for row in csv.reader(io.StringIO(self.csv)) if row] or [[]]
        if "time" not in header:
            raise ParameterError(f"readings: expected a header with the column time, found {', '.join(header) or 'an empty text'}")
        values = np.full((len(rows), len(header)), np.nan)
        for line, row in enumerate(rows):
            if len(row) != len(header):
                raise ParameterError(f"readings: row {line + 1} has {len(row)} cells; expected {len(header)}, as in the header")
            for place, cell in enumerate(row):
                try:
                    values[line, place] = float(cell or "nan")
                except ValueError:
                    raise ParameterError(f"readings: row {line + 1}, {header[place]}: expected a number, found {cell!r}") from None
        return {name: values[:, index].copy() for index, name in enumerate(header)}

    def to_pandas(self) -> pd.DataFrame:
        """The readings as a table: one column for each sensor, with the time [s] as index. Needs pandas.

        Raises:
            ParameterError: as `to_numpy`.
        """
        import pandas as pd

        return pd.DataFrame(self.to_numpy()).set_index("time")

    def __repr__(self) -> str:
        try:
            columns = self.to_numpy()
        except ParameterError as reason:
            return f"<Readings that cannot be used: {reason}>"
        time = columns.pop("time")
        span = f" from {time[0]:g} s to {time[-1]:g} s" if time.size else ""
        return f"<Readings of {', '.join(columns)}: {time.size} instants{span}>"


@dataclass(frozen=True, eq=False)
class ImpactEstimate:
    """The vehicle and the damage of an impact, estimated from the readings of sensors. `Column.estimate` makes it; docs/estimation.md
    describes the method and its limits."""

    history: list[dict[str, Any]]
    """The estimates in their order, each from more data than the one before it; the last one is from all readings. Each has the fields of
    the message `ImpactEstimate`, in SI units; docs/messages.md lists them."""

    def _interval(self, name: str) -> tuple[float, float, float]:
        found = self.history[-1][name]
        return float(found["mean"]), float(found["low"]), float(found["high"])

    @property
    def mass(self) -> tuple[float, float, float]:
        """Total mass of the vehicle [kg] by all readings: mean, lower and upper end of the 90 % interval."""
        return self._interval("mass")

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Speed of the vehicle [m/s] by all readings: mean, lower and upper end of the 90 % interval."""
        return self._interval("velocity")

    def __repr__(self) -> str:
        (mass, *_), (velocity, low, high) = self.mass, self.velocity
        return f"<ImpactEstimate {mass:.4g} kg at {velocity:.4g} m/s ({low:.4g} to {high:.4g})>"

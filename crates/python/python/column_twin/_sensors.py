"""What the sensors of a column read, and what they say of an impact."""

from __future__ import annotations

import csv
import io
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._errors import ParameterError

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings of sensors over time, in the format of `column-twin simulate --readings`."""

    csv: str
    """The table: `time` [s], then one column for each sensor, by its name."""

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Readings:
        """The readings of a table in CSV.

        Raises:
            ParameterError: a file that cannot be read.
        """
        try:
            with open(path, encoding="utf-8") as file:
                return cls(file.read())
        except (OSError, UnicodeDecodeError) as reason:
            raise ParameterError(f"cannot read the readings {os.fspath(path)}: {reason}") from reason

    def to_file(self, path: str | os.PathLike[str]) -> None:
        """Writes the table, which `column-twin measure` publishes and `column-twin estimate` reads."""
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.write(self.csv)

    def to_numpy(self) -> dict[str, npt.NDArray[np.float64]]:
        """`time` [s] and the readings of each sensor in its own unit; NaN where it has none at that time."""
        header, *rows = csv.reader(io.StringIO(self.csv))
        values = np.array([[float(it) if it else np.nan for it in row] for row in rows], dtype=np.float64)
        return {name: values.reshape(-1, len(header))[:, index].copy() for index, name in enumerate(header)}

    def to_pandas(self) -> pd.DataFrame:
        """The readings with the time as index. Needs pandas."""
        import pandas as pd

        return pd.DataFrame(self.to_numpy()).set_index("time")

    def __repr__(self) -> str:
        columns = self.to_numpy()
        time = columns.pop("time")
        return f"<Readings of {', '.join(columns)}: {time.size} instants from {time[0]:g} s to {time[-1]:g} s>"


@dataclass(frozen=True, eq=False)
class ImpactEstimate:
    """What the readings of sensors say of an impact. docs/estimation.md describes the method and its limits."""

    history: list[dict[str, Any]]
    """The estimates one after the other, each by more data, under the names of the message `ImpactEstimate`; SI units."""

    def _interval(self, name: str) -> tuple[float, float, float]:
        found = self.history[-1][name]
        return float(found["mean"]), float(found["low"]), float(found["high"])

    @property
    def mass(self) -> tuple[float, float, float]:
        """Mass of the vehicle: mean, and the ends of the 90 % interval [kg]."""
        return self._interval("mass")

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Its speed: mean, and the ends of the 90 % interval [m/s]."""
        return self._interval("velocity")

    def __repr__(self) -> str:
        (mass, *_), (velocity, low, high) = self.mass, self.velocity
        return f"<ImpactEstimate {mass:.4g} kg at {velocity:.4g} m/s ({low:.4g} to {high:.4g})>"

"""Exceptions and warnings. Their texts are the same as on the command line."""

from __future__ import annotations


class ColumnTwinError(Exception):
    """Base class of the errors of this package. A column that was pickled by another version raises it, too."""


class ParameterError(ColumnTwinError, ValueError):
    """Parameters, an impact, an axis or a study that are not accepted. It is also a `ValueError`.

    The text states the expected and the given value with its place, and reports all faults together.
    """

    @property
    def faults(self) -> list[str]:
        """The faults, one line each, at least one."""
        first, *faults = str(self).splitlines() or [""]
        return [fault.strip() for fault in faults] or [first]


class UnknownParameterError(ParameterError, KeyError):
    """A parameter name that does not exist. It is also a `KeyError`, which a mapping raises for a missing key."""

    # That of KeyError would put the text into quotes.
    __str__ = Exception.__str__


class SimulationError(ColumnTwinError, RuntimeError):
    """A response that could not be computed, although the input is valid. A collapse is a result, not an error. It is also a
    `RuntimeError`."""


class ProgramError(ColumnTwinError, RuntimeError):
    """The program `column-twin` is missing, is of another version, or has failed. It is also a `RuntimeError`."""


class ParameterWarning(UserWarning):
    """A parameter value that is deprecated or has no effect, a mass that the vehicle cannot have, such as one in tonnes, or a direction
    that is none, such as one in degrees."""


class IncompleteWarning(UserWarning):
    """Cells of a map that could not be computed, and are masked in it, or rows of a refined map that could not be computed in whole."""

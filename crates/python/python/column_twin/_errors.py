"""Exceptions and warnings. Their texts are those of the command line."""

from __future__ import annotations


class ColumnTwinError(Exception):
    """Base class of the errors of this package."""


class ParameterError(ColumnTwinError, ValueError):
    """Parameters, an impact or a study that are not accepted.

    The text names what was expected, what was found and where; all faults are reported together.
    """

    @property
    def faults(self) -> list[str]:
        """The faults, one line each."""
        first, *faults = str(self).splitlines() or [""]
        return [fault.strip() for fault in faults] or [first]


class UnknownParameterError(ParameterError, KeyError):
    """There is no parameter of this name. Also a `KeyError`, by which a mapping tells that it has no such key."""

    # That of KeyError would put the text into quotes.
    __str__ = Exception.__str__


class SimulationError(ColumnTwinError, RuntimeError):
    """A response that could not be computed, although the input is valid. A collapse is a result, not an error."""


class ProgramError(ColumnTwinError, RuntimeError):
    """The program `column-twin` is missing, of another version, or has failed."""


class ParameterWarning(UserWarning):
    """A deprecated value of a parameter, one without effect, or one that nobody can have meant, such as a mass in tonnes."""


class IncompleteWarning(UserWarning):
    """A part of a study that could not be computed, and is masked in its result."""

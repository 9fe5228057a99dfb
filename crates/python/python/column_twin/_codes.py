"""Action, outcome and criteria, which arrays hold as small numbers."""

from __future__ import annotations

from enum import IntEnum

from ._loading import native


class Action(IntEnum):
    """The required action, least severe first, so that `action >= Action.SHORE` reads as it should."""

    NONE = 0
    """No criterion that decides is exceeded."""
    INSPECT = 1
    """Have an engineer examine the column."""
    RESTRICT = 2
    """Keep people away from the column, and additional loads off the part of the building that it carries, until an engineer has
    examined it."""
    SHORE = 3
    """Clear the part of the building that the column carries, and have it shored as an engineer directs."""
    EVACUATE = 4
    """Clear the part of the building that the column carries; nobody enters it before an engineer allows it."""

    def __str__(self) -> str:
        return self.name.lower()


class Outcome(IntEnum):
    """How a response ended."""

    ELASTIC = 0
    """No hinge has flowed."""
    PLASTIC = 1
    """At least one hinge has flowed and the column stands."""
    COLLAPSED = 2
    """The column has lost its shape or its equilibrium."""
    FRACTURED = 3
    """A hinge is fractured and carries nothing."""

    def __str__(self) -> str:
        return self.name.lower()


CRITERIA: tuple[str, ...] = tuple(native.criteria())
"""Names of the criteria; `deciding_criterion` of a batch is a place in this list. docs/assessment.md describes them."""

"""Actions, outcomes and criteria, which arrays contain as small whole numbers."""

from __future__ import annotations

from enum import IntEnum

from ._errors import ParameterError
from ._loading import native


class Action(IntEnum):
    """The action that an impact requires, from the least to the most severe one. Actions are ordered: `action >= Action.SHORE` holds for
    SHORE and EVACUATE. docs/assessment.md describes the criteria from which they follow."""

    NONE = 0
    """No criterion that counts for the action is exceeded."""
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
    """The state in which a response leaves the column."""

    ELASTIC = 0
    """No hinge and no web has yielded."""
    PLASTIC = 1
    """At least one hinge or web has yielded, and the column stands."""
    COLLAPSED = 2
    """The column has lost its shape or its equilibrium."""
    FRACTURED = 3
    """A hinge has exceeded its ultimate plastic rotation, or a web its ultimate plastic shear angle: it is fractured and carries
    nothing."""

    def __str__(self) -> str:
        return self.name.lower()


CRITERIA: tuple[str, ...] = tuple(native.criteria())
"""The names of the criteria. The field `deciding_criterion` of a batch or a map is a place in this tuple, from 0; docs/assessment.md
describes each criterion."""


def expect_action(action: Action) -> Action:
    """An action from INSPECT to EVACUATE, which an impact can reach."""
    if action not in list(Action) or action == Action.NONE:
        raise ParameterError(f"action: expected one from inspect to evacuate, such as Action.SHORE; found {action!r}")
    return Action(action)

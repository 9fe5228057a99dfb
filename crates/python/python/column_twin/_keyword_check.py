"""The nearest keyword of a method, where one is misspelt. Python itself names it from 3.13 on."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from types import FunctionType
from typing import Any, TypeVar

T = TypeVar("T")


def nearest(name: str, names: Iterable[str]) -> str | None:
    """The name that was meant; None where no name is similar."""
    return next(iter(get_close_matches(name, list(names), n=1)), None)


def with_checked_keywords(cls: type[T]) -> type[T]:
    """The class, each of whose public methods with keywords names the nearest one for a misspelt one.

    Warnings of these methods count one more frame up to their caller: `stacklevel` is 3 here, as is `CALLER` in src/batch.rs.
    """
    for name, method in list(vars(cls).items()):
        if isinstance(method, FunctionType) and method.__kwdefaults__ and not name.startswith("_"):
            setattr(cls, name, _checked(method))
    return cls


def _checked(method: Callable[..., Any]) -> Callable[..., Any]:
    parameters = inspect.signature(method).parameters.values()
    names = [it.name for it in parameters if it.kind in (it.POSITIONAL_OR_KEYWORD, it.KEYWORD_ONLY) and it.name != "self"]
    # What takes any name checks it itself.
    takes_any = any(it.kind is it.VAR_KEYWORD for it in parameters)

    @functools.wraps(method)
    def checked(*args: Any, **keywords: Any) -> Any:
        try:
            return method(*args, **keywords)
        except TypeError:
            # Looked for here, so that a right call costs nothing.
            wrong = next((it for it in keywords if it not in names), None)
            if wrong is None or takes_any:
                raise
        meant = nearest(wrong, names)
        hint = f"did you mean '{meant}'?" if meant else f"it takes {', '.join(names)}"
        raise TypeError(f"{method.__qualname__}() got an unexpected keyword argument '{wrong}'; {hint}")

    return checked

"""The nearest keyword of a method where one is misspelt, which Python itself names from 3.13 on, and a number without its keyword."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from types import FunctionType
from typing import Any, TypeVar, cast

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])


def nearest(name: str, names: Iterable[str]) -> str | None:
    """The most similar name; None where no name is similar."""
    return next(iter(get_close_matches(name, list(names), n=1)), None)


def with_checked_keywords(cls: type[T]) -> type[T]:
    """The class, whose public methods with keywords explain a wrong call.

    Warnings of these methods count one more frame up to their caller: `stacklevel` is 3 there, as is `CALLER` in src/batch.rs.
    """
    for name, method in list(vars(cls).items()):
        if isinstance(method, FunctionType) and method.__kwdefaults__ and not name.startswith("_"):
            setattr(cls, name, with_explained_calls(method))
    return cls


def with_explained_calls(method: F) -> F:
    """The method, which names the nearest keyword for a misspelt one, and the keywords for an argument too many."""
    parameters = inspect.signature(method).parameters.values()
    names = [it.name for it in parameters if it.kind in (it.POSITIONAL_OR_KEYWORD, it.KEYWORD_ONLY) and it.name not in ("self", "cls")]
    keyword_only = [it.name for it in parameters if it.kind is it.KEYWORD_ONLY]
    has_any = any(it.kind is it.VAR_POSITIONAL for it in parameters)
    most = sum(it.kind in (it.POSITIONAL_ONLY, it.POSITIONAL_OR_KEYWORD) for it in parameters)
    # What takes any name checks it itself.
    takes_any = any(it.kind is it.VAR_KEYWORD for it in parameters)

    @functools.wraps(method)
    def checked(*args: Any, **keywords: Any) -> Any:
        try:
            return method(*args, **keywords)
        except TypeError:
            # Looked for here, so that a right call costs nothing.
            wrong = next((it for it in keywords if it not in names), None)
            if len(args) > most and not has_any:
                wrong = None
            elif wrong is None or takes_any:
                raise
        if wrong is None:
            found = ", ".join(map(repr, args[most:]))
            of_keywords = ", ".join(f"{it}=..." for it in keyword_only)
            raise TypeError(f"{method.__qualname__}() has no positional argument for {found}; give it by a keyword: {of_keywords}")
        meant = nearest(wrong, names)
        hint = f"did you mean '{meant}'?" if meant else f"it takes {', '.join(names)}"
        raise TypeError(f"{method.__qualname__}() got an unexpected keyword argument '{wrong}'; {hint}")

    return cast(F, checked)

"""Text files that users name."""

from __future__ import annotations

import os

from ._errors import ParameterError


def read_text(contents: str, path: str | os.PathLike[str]) -> str:
    """The text of a file in UTF-8; `contents` names its contents in the error."""
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except (OSError, UnicodeDecodeError) as reason:
        cause = reason.strerror if isinstance(reason, OSError) else "it is not text in UTF-8"
        raise ParameterError(f"cannot read the {contents} {os.fspath(path)}: {cause}") from reason

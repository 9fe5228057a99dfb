"""Loads the native part, and explains where it does not load."""

from __future__ import annotations

import platform
import sys
import sysconfig
from importlib import metadata
from pathlib import Path

__all__ = ["native"]


def _built_for() -> str:
    """The platforms for which the installed wheel was built, as its metadata names them."""
    try:
        wheel = metadata.distribution("column-twin").read_text("WHEEL") or ""
    except metadata.PackageNotFoundError:
        wheel = ""
    tags = [line.removeprefix("Tag:").strip() for line in wheel.splitlines() if line.startswith("Tag:")]
    if tags:
        return "was built for " + ", ".join(tags)
    files = sorted(path.name for path in Path(__file__).parent.glob("_native*"))
    return "consists of " + ", ".join(files) if files else "is missing: this folder holds no _native extension module"


def _explanation(cause: ImportError) -> str:
    libc = " ".join(part for part in platform.libc_ver() if part) or "an unknown libc"
    return (
        f"the native part of column_twin does not load: {cause}.\n"
        f"It {_built_for()}; this is {platform.python_implementation()} {platform.python_version()} "
        f"on {sysconfig.get_platform()} with {libc}.\n"
        "Install a wheel for this platform, or build one in the repository with Rust 1.95 or newer: pip install --force-reinstall ./crates/python"
    )


if sys.version_info < (3, 10):
    raise ImportError(f"column_twin needs Python 3.10 or newer; this is Python {platform.python_version()}")

try:
    from . import _native as native
except ImportError as cause:
    raise ImportError(_explanation(cause), name=__name__) from cause

"""Fixtures of the tests. They test the installed wheels, not the source tree: see `environment.sh`."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from column_twin import Column

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository."""
    return ROOT


@pytest.fixture(scope="session")
def paper() -> Column:
    """The paper's column, hit by its rigid mass of 1500 kg at 10 m/s."""
    return Column.from_file(ROOT / "config/heb220_paper.yaml")


@pytest.fixture(scope="session")
def steel() -> Column:
    """The real column in S355."""
    return Column.from_file(ROOT / "config/heb220_s355.yaml")


@pytest.fixture(scope="session")
def program() -> Callable[..., subprocess.CompletedProcess[str]]:
    """Runs the program `column-twin`, which the environment names or the second wheel has installed."""
    path = os.environ.get("COLUMN_TWIN_PROGRAM") or shutil.which("column-twin")
    if path is None:
        pytest.fail("expected the program column-twin in PATH or in COLUMN_TWIN_PROGRAM; install column-twin-program")

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([path, *arguments], capture_output=True, text=True, timeout=120, check=False)

    return run

"""The examples run as they are."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


def test_the_notebook(root: Path, tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    notebook = nbformat.read(root / "examples/column_twin_in_python.ipynb", as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "commit the notebook without outputs"
    client = nbclient.NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert sum("image/png" in output.get("data", {}) for output in outputs) >= 3
    assert any("RESTRICT" in output.get("data", {}).get("text/html", "") for output in outputs)
    assert not [output for output in outputs if output.get("name") == "stderr"]


def test_a_building_on_two_processes_of_dask_equals_one_process_bit_for_bit(root: Path) -> None:
    pytest.importorskip("distributed")
    script = root / "examples/building_on_dask.py"
    ran = subprocess.run(
        [sys.executable, str(script), "--columns", "60", "--check"], capture_output=True, text=True, timeout=600
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "720 impacts on 60 columns" in ran.stdout
    assert "agree bit for bit" in ran.stdout

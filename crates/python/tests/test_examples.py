"""The examples run as they are."""

from __future__ import annotations

import base64
import importlib.util
import io
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest


def outputs_of(notebook: Any) -> list[Any]:
    return [output for cell in notebook.cells for output in cell.get("outputs", [])]


def words_of(notebook: Any) -> list[str]:
    """What the cells say in words, without the names of objects in memory."""
    return [it["data"]["text/plain"] for it in outputs_of(notebook) if "image/png" not in it.get("data", {}) and "data" in it]


def test_the_notebook(root: Path, tmp_path: Path) -> None:
    """`UPDATE_DOCS=1` writes its outputs; without, those that it has are those that it gives."""
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    place = root / "examples/column_twin_in_python.ipynb"
    kept, notebook = (nbformat.read(place, as_version=4) for _ in range(2))
    client = nbclient.NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute()
    outputs = outputs_of(notebook)
    assert not [output for output in outputs if output.get("name") == "stderr"]
    pictures = [output["data"]["image/png"] for output in outputs if "image/png" in output.get("data", {})]
    # One for each cell that draws, and none of them is empty: two of four once were.
    assert len(pictures) == 4
    for picture in pictures:
        assert share_of_ink(picture) > 0.02
    assert any("RESTRICT" in output.get("data", {}).get("text/html", "") for output in outputs)
    if os.environ.get("UPDATE_DOCS"):
        for cell in notebook.cells:
            cell.get("metadata", {}).pop("execution", None)
        notebook.metadata = kept.metadata
        nbformat.write(notebook, place)
        kept = notebook
    assert words_of(kept) == words_of(notebook), "UPDATE_DOCS=1 crates/python/tests/wheels.sh test test_examples.py"
    assert len([it for it in outputs_of(kept) if "image/png" in it.get("data", {})]) == len(pictures)


def share_of_ink(picture: str) -> float:
    """The part of a picture that is neither white nor transparent."""
    from matplotlib import image

    pixels = image.imread(io.BytesIO(base64.b64decode(picture)), format="png")
    return float((pixels[..., :3].min(axis=-1) < 0.9).mean())


def test_a_building_on_two_processes_of_dask_equals_one_process_bit_for_bit(root: Path) -> None:
    pytest.importorskip("distributed")
    script = root / "examples/building_on_dask.py"
    ran = subprocess.run(
        [sys.executable, str(script), "--columns", "60", "--check"], capture_output=True, text=True, timeout=600
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "720 impacts on 60 columns" in ran.stdout
    assert "agree bit for bit" in ran.stdout


def test_the_weakest_columns_of_the_building_are_no_ties(root: Path) -> None:
    """The example listed ties, and the loads grew towards the roof."""
    pytest.importorskip("distributed")
    spec = importlib.util.spec_from_file_location("building_on_dask", root / "examples/building_on_dask.py")
    assert spec is not None and spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    columns = example.building(150)
    loads = [float(column["top.load"]) for column in columns]
    # The ground floor has the first columns, and carries all floors above.
    assert loads[0] > loads[50] > loads[100]
    reserves = sorted(float(example.study(column)["reserve"][:, 0].min()) for column in columns[:10])
    assert all(first < second for first, second in zip(reserves[:5], reserves[1:6]))

"""Every Python example of the book and of the docstrings runs as it is, or the page has the reason in front of it:
`<!-- not run: REASON -->`."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pytest

import column_twin
from column_twin import Column

ROOT = Path(__file__).resolve().parents[3]
BLOCK = re.compile(r"(?:<!-- not run: (?P<reason>.+?) -->\n)?```python\n(?P<code>.*?)```", re.DOTALL)
# An expression whose value the page gives, such as `result.max_v1       # 0.02111 m`.
VALUE = re.compile(r"^(?P<expression>\S.*?)\s{2,}# (?P<value>-?\d[\d.e+-]*)\b", re.MULTILINE)


def examples() -> dict[str, list[re.Match[str]]]:
    """The examples of each page of the book."""
    summary = (ROOT / "docs/SUMMARY.md").read_text()
    pages = [ROOT / "docs" / link for link in re.findall(r"\]\((.+?\.md)\)", summary)]
    pages += [ROOT / "crates/python/README.md"]
    found = {str(page.resolve().relative_to(ROOT)): list(BLOCK.finditer(page.read_text())) for page in pages}
    return {page: blocks for page, blocks in found.items() if blocks}


@pytest.mark.parametrize("page", examples())
def test_the_examples_of_a_page(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    matplotlib.use("agg")
    (tmp_path / "config").symlink_to(ROOT / "config")
    (tmp_path / "site.yaml").write_text("/**:\n  ros__parameters:\n    top: {load: 5.5e+5}\n")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in examples()[page]:
        if block["reason"]:
            continue
        exec(compile(block["code"], page, "exec"), names)
        for given in VALUE.finditer(block["code"]):
            assert eval(given["expression"], names) == pytest.approx(float(given["value"]), rel=1e-3), given[0]


# It reads a recording, as test_program.py does.
NOT_RUN = {"read_recording"}


def examples_of_docstrings() -> dict[str, str]:
    """The lines behind `>>>` in the docstring of each class and function."""
    found = {}
    for path in sorted((ROOT / "crates/python/python/column_twin").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and node.name not in NOT_RUN:
                lines = (ast.get_docstring(node) or "").splitlines()
                code = [line.removeprefix(">>> ") for line in lines if line.startswith(">>> ")]
                if code:
                    found[f"{path.stem}.{node.name}"] = "\n".join(code)
    return found


@pytest.mark.parametrize("name", examples_of_docstrings())
def test_the_examples_of_a_docstring(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`to_pandas` once showed arguments that `evaluate_batch` no longer took, and `run_program` options that never were."""
    matplotlib.use("agg")
    (tmp_path / "config").symlink_to(ROOT / "config")
    monkeypatch.chdir(tmp_path)
    column = Column.from_file("config/heb220_s355.yaml")
    sensed = Column.from_file("config/heb220_s355.yaml", "config/sensors_industrial.yaml")
    names: dict[str, object] = {**vars(column_twin), "np": np, "column": column, "sensed": sensed}
    names["damage"] = column.map(mass=[1500.0, 2500.0], velocity=[8.0, 10.0], vehicle="van")
    names["readings"] = sensed.sensor_readings("mid_car", velocity=12.0)
    exec(compile(examples_of_docstrings()[name], name, "exec"), names)


def test_the_reference_is_up_to_date() -> None:
    command = [sys.executable, str(ROOT / "crates/python/tests/python_reference.py")]
    generated = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    page = ROOT / "docs/python_reference.md"
    if os.environ.get("UPDATE_DOCS"):
        page.write_text(generated)
    assert page.read_text() == generated, "UPDATE_DOCS=1 crates/python/tests/wheels.sh test test_documents.py"


def test_the_readme_has_an_example() -> None:
    assert {"README.md", "docs/guide.md", "docs/python.md"} <= set(examples())
    assert {"_column.simulate", "_evaluation.to_pandas", "_program.run_program"} <= set(examples_of_docstrings())

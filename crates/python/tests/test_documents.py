"""Every Python example of the book runs as it is, or the page has the reason in front of it: `<!-- not run: REASON -->`."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import matplotlib
import pytest

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


def test_the_reference_is_up_to_date() -> None:
    command = [sys.executable, str(ROOT / "crates/python/tests/python_reference.py")]
    generated = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    page = ROOT / "docs/python_reference.md"
    if os.environ.get("UPDATE_DOCS"):
        page.write_text(generated)
    assert page.read_text() == generated, "UPDATE_DOCS=1 crates/python/tests/wheels.sh test test_documents.py"


def test_the_readme_has_an_example() -> None:
    assert {"README.md", "docs/guide.md", "docs/python.md"} <= set(examples())

"""The package: pickling, notebooks, optional packages, types, catalogues, and a platform that is not supported."""

from __future__ import annotations

import copy
import importlib.metadata
import os
import pickle
import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

import column_twin
from column_twin import Column, ColumnTwinError, sections, vehicles

PACKAGE = Path(column_twin.__file__).parent


def test_a_pickled_column_computes_the_same_bits(steel: Column) -> None:
    for column in (steel, steel.with_changes(section__name="HEB 300", top__load=1.0 / 3.0)):
        for twin in (pickle.loads(pickle.dumps(column)), copy.deepcopy(column)):
            assert twin == column and hash(twin) == hash(column) and twin.parameters == column.parameters
            velocities = [2.0, 7.0, 12.0]
            expected = column.evaluate_batch("van", velocity=velocities).tobytes()
            assert twin.evaluate_batch("van", velocity=velocities).tobytes() == expected
    assert steel != Column() and steel != 3


def test_a_column_of_another_version_is_rejected(steel: Column) -> None:
    restore, (version, parameters) = steel.__reduce__()
    assert version == column_twin.__version__
    with pytest.raises(ColumnTwinError, match="pickled by column-twin 0.1.0"):
        restore("0.1.0", parameters)


def test_the_version_is_that_of_the_distribution() -> None:
    assert column_twin.__version__ == importlib.metadata.version("column-twin")


def test_notebooks_show_columns_results_and_capacities(paper: Column, steel: Column) -> None:
    result = paper.simulate()
    for shown in (paper, result, paper.evaluate(), paper.capacity(), steel.simulate("mid_car", velocity=10.0)):
        html = shown._repr_html_()
        ElementTree.fromstring(html)
        assert len(html) < 40_000
    html = result._repr_html_()
    assert "SHORE" in html and "<svg" in html and "94.6 mm" in html
    assert "94.6 mm" in repr(result) and "shore" in repr(result)
    hostile = Column(column_id="<b>&", section__name="", section__area=9e-3, section__second_moment=8e-5,
                     section__mass_per_length=70.0, resistance__moment=3e5)
    assert "<b>&<" not in hostile._repr_html_()


def test_histories_become_tables_and_figures(paper: Column) -> None:
    pytest.importorskip("pandas")
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    result = paper.simulate()
    table = result.to_pandas()
    assert table.index.name == "t_s" and table["v1_m"].max() == result.v1.max()
    axes = result.plot_all()
    assert len(axes) == 4 and all(ax.lines for ax in axes)
    assert result.plot(axes[0], "force") is axes[0]
    assert result.plot(quantity="moment").get_ylabel() == "bending moment [kN m]"
    with pytest.raises(ValueError, match="expected displacement, force, moment or rotation"):
        result.plot(quantity="energy")  # type: ignore[arg-type]
    ax = paper.capacity(velocity=10.0).plot(paper.capacity().plot())
    assert sum(line.get_label() == "carried load" for line in ax.lines) == 1


def test_without_optional_packages_everything_else_works() -> None:
    script = (
        "import sys\n"
        "for name in ('pandas', 'matplotlib', 'dask'): sys.modules[name] = None\n"
        "import column_twin\n"
        "result = column_twin.Column().simulate('mid_car', velocity=5.0)\n"
        "result._repr_html_()\n"
        "try: result.to_pandas()\n"
        "except ImportError as error: print(error)\n"
    )
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert "pandas" in ran.stdout


def test_the_catalogues(root: Path) -> None:
    heb = sections()["HEB220"]
    assert heb.area == pytest.approx(91.04e-4, rel=1e-3)
    assert heb.depth == 0.22
    rows = (root / "config/sections.csv").read_text().splitlines()
    assert len(sections()) == sum(bool(re.match(r"[A-Z]+\d", row)) for row in rows)
    car = vehicles()["mid_car"]
    assert car.mass == 1719.0 and car.data["masses"]["tag"] in "TCMA" and car.data["masses"]["source"]
    # A catalogue that was read belongs to its reader.
    vehicles().clear()
    sections().clear()
    assert sections() and vehicles()
    for name in vehicles():
        assert Column().evaluate(name, velocity=3.0).max_v1 > 0.0


def test_types() -> None:
    """mypy, strictly, on the package and on these tests, and the stubs against the native module."""
    pytest.importorskip("mypy")
    tests = Path(__file__).parent
    environment = {**os.environ, "MYPY_CACHE_DIR": os.environ.get("MYPY_CACHE_DIR", os.devnull)}
    for command in (
        ["mypy", "--strict", "-p", "column_twin"],
        ["mypy", "--strict", *(str(path) for path in [tests / "conftest.py", *sorted(tests.glob("test_*.py"))])],
        # The other modules are typed in place and have no stubs.
        ["mypy.stubtest", "column_twin._native", "--allowlist", str(tests / "stubtest_allowlist.txt")],
    ):
        ran = subprocess.run(
            [sys.executable, "-m", *command], cwd=os.path.dirname(sys.executable), env=environment, capture_output=True, text=True
        )
        assert ran.returncode == 0, ran.stdout + ran.stderr


KEYWORDS = """
from column_twin import Action, Column, Range

column = Column(section__name="HEB 220", top__load=500e3, solver__scheme="conserving_midpoint")
column.with_changes(vehicle__masses=[1000.0, 500.0])
Column.from_file("a.yaml", publish_rate=10)
column.map(velocity=Range(1, 20, points=5), top__load=[1e5, 2e5], vehicle="van")
column.simulate("mid_car", velocity=10.0, mass=1500)
column.evaluate_batch("van", velocity=[1.0, 2.0])
column.after(column.simulate("van")).evaluate("van")
Column(top__laod=500e3)  # wrong
Column(top__load="heavy")  # wrong
Column(solver__scheme="euler")  # wrong
column.with_changes(section__nam="HEB 300")  # wrong
column.map(velocty=[1.0, 2.0], mass=[1.0, 2.0])  # wrong
column.simulate("mid_car", 10.0)  # wrong
column.evaluate("mid_car", velocty=10.0)  # wrong
column.evaluate_batch("van", velocities=[1.0])  # wrong
column.critical_velocity(Action.SHORE, "van", 1500.0)  # wrong
column.simulate("van").plot(quantity="energy")  # wrong
"""


@pytest.mark.parametrize("checker", ["mypy", "pyright"])
@pytest.mark.parametrize("version", ["3.10", "3.14"])
def test_a_wrong_keyword_is_found_before_the_program_runs(tmp_path: Path, checker: str, version: str) -> None:
    pytest.importorskip(checker)
    script = tmp_path / "keywords.py"
    script.write_text(KEYWORDS)
    environment = {**os.environ, "MYPY_CACHE_DIR": os.environ.get("MYPY_CACHE_DIR", os.devnull)}
    command = {
        "mypy": ["mypy", "--strict", "--python-version", version, str(script)],
        "pyright": ["pyright", "--pythonpath", sys.executable, "--pythonversion", version, str(script)],
    }[checker]
    ran = subprocess.run([sys.executable, "-m", *command], cwd=tmp_path, env=environment, capture_output=True, text=True)
    found = {int(line) for line in re.findall(r"keywords\.py:(\d+)(?::\d+)?(?:: | - )error", ran.stdout)}
    expected = {number for number, line in enumerate(KEYWORDS.splitlines(), start=1) if line.endswith("# wrong")}
    assert found == expected, ran.stdout + ran.stderr


def test_the_keywords_are_those_of_the_parameters() -> None:
    from column_twin._keywords import AxisKeywords, ParameterKeywords

    names = {name.replace(".", "__") for name in Column().parameters}
    assert set(ParameterKeywords.__annotations__) == names
    numbers = {name.replace(".", "__") for name, value in Column().parameters.items() if type(value) in (int, float)}
    assert set(AxisKeywords.__annotations__) == numbers | {"mass", "velocity", "height", "section", "direction"}


@pytest.fixture
def copied_package(tmp_path: Path) -> Path:
    """A folder with a copy of the package and its metadata, as if it came from another machine."""
    shutil.copytree(PACKAGE, tmp_path / "column_twin", ignore=shutil.ignore_patterns("msg", "srv", "__pycache__"))
    for metadata in PACKAGE.parent.glob("column_twin-*.dist-info"):
        shutil.copytree(metadata, tmp_path / metadata.name)
    return tmp_path


def failed_import(folder: Path) -> str:
    """The error of an import from this folder, without the packages that are installed."""
    script = f"import sys; sys.path.insert(0, {str(folder)!r}); import column_twin"
    ran = subprocess.run([sys.executable, "-S", "-c", script], capture_output=True, text=True)
    assert ran.returncode == 1, ran.stdout
    return ran.stderr


def test_a_native_part_for_another_platform_is_explained(copied_package: Path) -> None:
    (native,) = (copied_package / "column_twin").glob("_native*.so")
    foreign = bytearray(native.read_bytes())
    foreign[18:20] = (0xF3).to_bytes(2, "little")  # the processor in the header of ELF: RISC-V
    native.write_bytes(foreign)
    text = failed_import(copied_package)
    assert "ImportError: the native part of column_twin does not load" in text
    assert "was built for cp310-abi3-" in text
    assert f"this is CPython {sys.version.split()[0]}" in text
    assert "pip install" in text


def test_a_native_part_that_is_missing_is_explained(copied_package: Path) -> None:
    (native,) = (copied_package / "column_twin").glob("_native*.so")
    native.rename(native.with_name("_native.cp310-win_amd64.pyd"))
    for metadata in copied_package.glob("*.dist-info"):
        shutil.rmtree(metadata)
    text = failed_import(copied_package)
    assert "ImportError: the native part of column_twin does not load" in text
    assert "consists of _native.cp310-win_amd64.pyd" in text

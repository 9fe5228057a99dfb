#!/usr/bin/env python3
"""Reads damage maps with pyarrow, which shares no code with column_twin, and compares the formats and the parts.

    read_map.py PROGRAM

PROGRAM is the path of column-twin. Run by the Python of tests/interop/environment.sh; rerun-sdk brings pyarrow.
"""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

REPOSITORY = Path(__file__).resolve().parents[2]
PARTS = 3


def run(program, folder, *arguments):
    config = REPOSITORY / "config/heb220_paper.yaml"
    command = [program, "map", "--config", str(config), "--mass", "1000:9000:6", "--velocity", "0.5:15:9", *arguments]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)


def text(value):
    """A value as the CSV has it, numbers compared as numbers."""
    return "" if value is None else value


def check(program, folder):
    run(program, folder, "--csv", "m.csv", "--parquet", "m.parquet", "--arrow", "m.arrow")
    whole = pq.read_table(folder / "m.parquet")
    with pa.OSFile(str(folder / "m.arrow")) as file:
        arrow = pa.ipc.open_file(file).read_all()
    assert whole.column_names == arrow.column_names
    assert whole.to_pylist() == arrow.to_pylist()
    assert arrow.schema.field("max_v1_m").metadata[b"unit"] == b"m"
    with open(folder / "m.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == whole.num_rows == 54
    for found, expected in zip(whole.to_pylist(), rows):
        for name, value in found.items():
            given = expected[name]
            same = text(value) == given if given == "" or isinstance(value, str) else float(given) == value
            assert same, (name, value, given)
    for part in range(1, PARTS + 1):
        run(program, folder, "--parquet", f"part-{part}.parquet", "--shard", f"{part}/{PARTS}")
    paths = [folder / f"part-{part}.parquet" for part in range(1, PARTS + 1)]
    joined = pa.concat_tables([pq.read_table(path) for path in paths])
    assert joined.equals(whole.replace_schema_metadata(joined.schema.metadata)), "the parts are not the map"
    for number, path in enumerate(paths, 1):
        about = pq.read_metadata(path).metadata
        assert about[b"shard"] == f"{number}/{PARTS}".encode()
        assert about[b"complete"] == b"true"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as directory:
        check(sys.argv[1], Path(directory))
    print("pyarrow reads the map and its parts")

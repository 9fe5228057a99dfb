#!/usr/bin/env python3
"""Overhead of the Python package against Rust, both in turns in one run, so that the load of the machine hits both alike.

    cargo bench --package column_twin_python --bench batch --no-run
    python crates/python/benches/overhead.py target/release/deps/batch-*
    python crates/python/benches/overhead.py target/release/deps/batch-* --million --before EARLIER/bin/python

Prints a Markdown table. The overhead of a call is the difference of the fastest rounds; targets: 20 microseconds, 5 % for a batch of
10 000 impacts, 10 % for a list of impacts. With --million, 1 000 000 impacts that are over quickly are computed in batches, too; with --before, also by the
library of another environment, such as that of an earlier version, and the second ratio must be at most 1.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import time

import numpy as np

from column_twin import Column


# The same batches by the library of another environment.
EARLIER = """
import sys, time
import numpy as np
from column_twin import Column
column = Column()
for line in sys.stdin:
    _, vehicle, count, first, last, threads = line.split()
    start = time.perf_counter()
    velocities = float(first) + (float(last) - float(first)) / (int(count) - 1) * np.arange(int(count))
    rows = column.evaluate_batch(vehicle, velocity=velocities, threads=int(threads))
    print(time.perf_counter() - start, rows["max_v1"].sum(), flush=True)
"""


class Other:
    """Another program that answers each command with seconds and a checksum: that of `batch.rs`, or `EARLIER`."""

    def __init__(self, *command: str) -> None:
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, *words: object) -> tuple[float, float]:
        assert self.process.stdin and self.process.stdout
        print(*words, file=self.process.stdin, flush=True)
        seconds, checksum = self.process.stdout.readline().split()
        return float(seconds), float(checksum)


def single(column: Column, rust: Other, rounds: int) -> tuple[float, float]:
    """Fastest seconds per call of `evaluate` in Python and in Rust, of calls in turns. The impact is one that is over quickly."""
    fastest = [float("inf")] * 2
    for _ in range(rounds):
        start = time.perf_counter()
        column.evaluate("mid_car", velocity=0.01)
        fastest[0] = min(fastest[0], time.perf_counter() - start)
        fastest[1] = min(fastest[1], rust.ask("single", "mid_car", 1, 0.01)[0])
    return fastest[0], fastest[1]


# Speeds of the impacts of a batch [m/s], and of those that are over quickly, so that what Python adds weighs most.
USUAL, QUICK = (1.0, 20.0), (0.01, 0.02)


def batch(column: Column, others: list[Other], count: int, threads: int, rounds: int, as_list: bool = False,
          speeds: tuple[float, float] = USUAL) -> list[float]:
    """Fastest seconds of a batch in Python and in each other program, in turns; results by Rust must agree. A list of Python has its
    numbers as objects, which are turned into an array."""
    fastest = [float("inf")] * (1 + len(others))
    first, last = speeds

    def spread() -> np.ndarray:
        return first + (last - first) / (count - 1) * np.arange(count)

    objects = spread().tolist() if as_list else []
    for number in range(rounds):
        start = time.perf_counter()
        velocities = objects if as_list else spread()
        evaluations = column.evaluate_batch("mid_car", velocity=velocities, threads=threads)
        fastest[0] = min(fastest[0], time.perf_counter() - start)
        for place, other in enumerate(others, start=1):
            seconds, checksum = other.ask("batch", "mid_car", count, first, last, threads)
            fastest[place] = min(fastest[place], seconds)
            if number == 0 and place == 1:
                assert np.isclose(evaluations["max_v1"].sum(), checksum, rtol=1e-12), "Python and Rust disagree"
    return fastest


def per_call(call: str, column: Column, number: int) -> float:
    """Fastest seconds of a call that computes nothing but what Python adds, of five rounds."""
    import timeit

    return min(timeit.repeat(call, globals={"column": column}, number=number, repeat=5)) / number


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rust", help="the program that `cargo bench --bench batch --no-run` builds")
    parser.add_argument("--count", type=int, default=10_000, help="impacts of a batch (default: 10 000)")
    parser.add_argument("--rounds", type=int, default=3, help="rounds of the batch (default: 3)")
    parser.add_argument("--million", action="store_true", help="also 1 000 000 impacts that are over quickly, on all threads, in one round")
    parser.add_argument("--before", metavar="PYTHON", help="an interpreter whose environment has another version of the library")
    options = parser.parse_args()
    column, rust = Column(), Other(options.rust, "--serve")
    # In isolation, so that the folder of this file or PYTHONPATH offers no other library.
    others = [rust] + ([Other(options.before, "-I", "-c", EARLIER)] if options.before else [])
    threads = len(os.sched_getaffinity(0))

    def row(name: str, times: list[float], digits: int, factor: float = 1.0) -> None:
        ours, *theirs = (factor * it for it in times)
        cells = [f"{it:.{digits}f}" for it in (ours, theirs[0])]
        ratios = [f"{ours / it:.3f}" for it in theirs]
        print("|", " | ".join([name, *cells, f"{ours - theirs[0]:+.{digits}f}", *ratios, *[""] * (len(others) - len(theirs))]), "|", flush=True)

    print(f"load average {os.getloadavg()[0]:.1f}, {threads} threads\n")
    heads = ["", "Python", "Rust", "difference", "ratio", *(["ratio to before"] if options.before else [])]
    print("|", " | ".join(heads), "|\n" + "|---" * len(heads) + "|")
    row("one `evaluate` [us]", list(single(column, rust, 300)), 1, 1e6)
    for many in (1, threads):
        name = f"batch of {options.count}, {many} thread{'s' if many > 1 else ''} [s]"
        row(name, batch(column, others, options.count, many, options.rounds), 3)
    row(f"list of {options.count}, {threads} threads [s]", batch(column, others, options.count, threads, options.rounds, as_list=True), 3)
    if options.million:
        row(f"batch of 1 000 000 quick ones, {threads} threads [s]", batch(column, others, 1_000_000, threads, 1, speeds=QUICK), 1)
    for call in ('column["top.load"]', 'column.evaluate_batch("mid_car", velocity=[])'):
        print(f"| `{call}` [us] | {1e6 * per_call(call, column, 1000):.1f}" + " |" * (len(heads) - 1))


if __name__ == "__main__":
    main()

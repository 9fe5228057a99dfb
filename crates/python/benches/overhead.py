#!/usr/bin/env python3
"""Overhead of the Python package against Rust, both in turns in one run, so that the load of the machine hits both alike.

    cargo bench --package column_twin_python --bench batch --no-run
    python crates/python/benches/overhead.py target/release/deps/batch-*

Prints a Markdown table. The overhead of a call is the difference of the fastest rounds; targets: 20 microseconds, and 5 % for a
batch of 10 000 impacts.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import time

import numpy as np

from column_twin import Column


class Rust:
    """The Rust program of `batch.rs`."""

    def __init__(self, path: str) -> None:
        self.process = subprocess.Popen([path, "--serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, *words: object) -> tuple[float, float]:
        assert self.process.stdin and self.process.stdout
        print(*words, file=self.process.stdin, flush=True)
        seconds, checksum = self.process.stdout.readline().split()
        return float(seconds), float(checksum)


def single(column: Column, rust: Rust, rounds: int) -> tuple[float, float]:
    """Fastest seconds per call of `evaluate` in Python and in Rust, of calls in turns. The impact is one that is over quickly."""
    fastest = [float("inf")] * 2
    for _ in range(rounds):
        start = time.perf_counter()
        column.evaluate("mid_car", velocity=0.01)
        fastest[0] = min(fastest[0], time.perf_counter() - start)
        fastest[1] = min(fastest[1], rust.ask("single", "mid_car", 1, 0.01)[0])
    return fastest[0], fastest[1]


def batch(column: Column, rust: Rust, count: int, threads: int, rounds: int) -> tuple[float, float]:
    """Fastest seconds of a batch in Python and in Rust, in turns; their results must agree."""
    fastest = [float("inf")] * 2
    for number in range(rounds):
        start = time.perf_counter()
        velocities = 1.0 + (20.0 - 1.0) / (count - 1) * np.arange(count)
        evaluations = column.evaluate_batch("mid_car", velocity=velocities, threads=threads)
        fastest[0] = min(fastest[0], time.perf_counter() - start)
        seconds, checksum = rust.ask("batch", "mid_car", count, 1.0, 20.0, threads)
        fastest[1] = min(fastest[1], seconds)
        if number == 0:
            assert np.isclose(evaluations["max_v1"].sum(), checksum, rtol=1e-12), "Python and Rust disagree"
    return fastest[0], fastest[1]


def per_call(call: str, column: Column, number: int) -> float:
    """Fastest seconds of a call that computes nothing but what Python adds, of five rounds."""
    import timeit

    return min(timeit.repeat(call, globals={"column": column}, number=number, repeat=5)) / number


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rust", help="the program that `cargo bench --bench batch --no-run` builds")
    parser.add_argument("--count", type=int, default=10_000, help="impacts of a batch (default: 10 000)")
    parser.add_argument("--rounds", type=int, default=3, help="rounds of the batch (default: 3)")
    options = parser.parse_args()
    column, rust = Column(), Rust(options.rust)
    threads = len(os.sched_getaffinity(0))

    print(f"load average {os.getloadavg()[0]:.1f}, {threads} threads\n")
    print("| | Python | Rust | difference | ratio |\n|---|---|---|---|---|")
    ours, theirs = single(column, rust, 300)
    print(f"| one `evaluate` [us] | {1e6 * ours:.1f} | {1e6 * theirs:.1f} | {1e6 * (ours - theirs):.1f} | {ours / theirs:.3f} |")
    for many in (1, threads):
        ours, theirs = batch(column, rust, options.count, many, options.rounds)
        name = f"batch of {options.count}, {many} thread{'s' if many > 1 else ''} [s]"
        print(f"| {name} | {ours:.3f} | {theirs:.3f} | {ours - theirs:+.3f} | {ours / theirs:.3f} |")
    for call in ('column["top.load"]', 'column.evaluate_batch("mid_car", velocity=[])'):
        print(f"| `{call}` [us] | {1e6 * per_call(call, column, 1000):.1f} | | | |")


if __name__ == "__main__":
    main()

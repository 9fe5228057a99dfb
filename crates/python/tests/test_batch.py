"""Many impacts at once: equal to single ones, on any number of threads, without the GIL, interruptible."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from column_twin import CRITERIA, EVALUATION, Column, Action, to_pandas


def test_a_batch_equals_single_impacts_bit_for_bit(steel: Column) -> None:
    masses = np.linspace(1000.0, 9000.0, 12)
    velocities = np.linspace(1.0, 25.0, 12)
    for vehicle in (None, "mid_car"):
        batch = steel.evaluate_batch(masses, velocities, vehicle=vehicle)
        for row, mass, velocity in zip(batch, masses, velocities, strict=True):
            one = steel.evaluate(vehicle, mass, velocity)
            for name in EVALUATION.names or ():
                expected = getattr(one, name)
                if name == "deciding_criterion":
                    assert CRITERIA[row[name]] == expected
                else:
                    assert np.float64(row[name]).tobytes() == np.float64(expected).tobytes(), name


def test_the_number_of_threads_does_not_matter(steel: Column) -> None:
    velocities = np.linspace(0.5, 20.0, 60)
    batches = [steel.evaluate_batch(None, velocities, "mid_car", threads=count).tobytes() for count in (1, 2, 3, None)]
    assert len(set(batches)) == 1


def test_arrays_are_broadcast(steel: Column) -> None:
    grid = steel.evaluate_batch(np.array([1500.0, 2500.0]), np.array([[1.0], [2.0], [3.0]]))
    assert grid.shape == (3, 2)
    assert np.array_equal(grid["mass"][0], [1500.0, 2500.0])
    assert np.array_equal(grid["velocity"][:, 0], [1.0, 2.0, 3.0])
    assert steel.evaluate_batch(None, [], "mid_car").shape == (0,)
    assert steel.evaluate_batch(1500.0, 3.0).shape == ()
    own = steel.evaluate_batch([np.nan, 1800.0], 5.0, "mid_car")
    assert np.array_equal(own["mass"], [1719.0, 1800.0])
    # Views that are not contiguous, and whole numbers.
    assert np.array_equal(steel.evaluate_batch(np.arange(1000, 3000, 500)[::2], 3)["mass"], [1000.0, 2000.0])
    with pytest.raises(ValueError, match="broadcast"):
        steel.evaluate_batch([1.0, 2.0], [1.0, 2.0, 3.0])


def test_actions_are_ordered(steel: Column) -> None:
    batch = steel.evaluate_batch(8000.0, np.linspace(0.5, 25.0, 20))
    actions = batch["action"].astype(int)
    assert actions[0] == Action.NONE and actions[-1] == Action.EVACUATE
    assert (np.diff(actions) >= 0).all()
    table = to_pandas(batch)
    assert list(table.columns) == list(EVALUATION.names or ())
    assert (table["action"] >= "shore").sum() == (actions >= Action.SHORE).sum()


def test_other_threads_run_meanwhile(steel: Column) -> None:
    """A counter in Python counts while a batch computes; with the GIL held it would stand still."""
    over = threading.Event()
    count = 0

    def counter() -> None:
        nonlocal count
        while not over.is_set():
            count += 1
            time.sleep(0.001)

    thread = threading.Thread(target=counter)
    velocities = np.linspace(5.0, 20.0, 300)
    thread.start()
    before = count
    start = time.perf_counter()
    steel.evaluate_batch(None, velocities, "mid_car", threads=1)
    elapsed = time.perf_counter() - start
    counted = count - before
    over.set()
    thread.join()
    # Whatever the load of the machine: a thread that runs again after each sleep has counted more than a few times.
    assert counted >= 10, f"{counted} in {elapsed:.3f} s"


def test_two_threads_compute_at_once(steel: Column) -> None:
    velocities = np.linspace(5.0, 20.0, 50)
    expected = steel.evaluate_batch(None, velocities, "mid_car").tobytes()
    found: list[bytes] = []

    def work() -> None:
        found.append(steel.evaluate_batch(None, velocities, "mid_car", threads=1).tobytes())

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected] * 3


def test_ctrl_c_interrupts_a_batch() -> None:
    """In a process of its own: SIGINT while far more impacts run than fit into the time of a test."""
    script = (
        "import numpy as np, column_twin\n"
        "print('ready', flush=True)\n"
        "try:\n"
        "    column_twin.Column().evaluate_batch(None, np.linspace(1.0, 20.0, 2_000_000), 'mid_car')\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted', flush=True)\n"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(1.0)
        os.kill(process.pid, signal.SIGINT)
        rest, _ = process.communicate(timeout=60)
    assert rest == "interrupted\n"
    assert process.returncode == 0

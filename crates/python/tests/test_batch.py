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

from column_twin import CRITERIA, EVALUATION, Action, Column, ParameterError, to_pandas


def test_a_batch_equals_single_impacts_bit_for_bit(steel: Column) -> None:
    masses = np.linspace(1000.0, 9000.0, 12)
    velocities = np.linspace(1.0, 25.0, 12)
    for vehicle in (None, "mid_car"):
        batch = steel.evaluate_batch(vehicle, mass=masses, velocity=velocities)
        for row, mass, velocity in zip(batch, masses, velocities, strict=True):
            one = steel.evaluate(vehicle, mass=mass, velocity=velocity)
            for name in EVALUATION.names or ():
                expected = getattr(one, name)
                if name == "deciding_criterion":
                    assert CRITERIA[row[name]] == expected
                else:
                    assert np.float64(row[name]).tobytes() == np.float64(expected).tobytes(), name


def test_the_number_of_threads_does_not_matter(steel: Column) -> None:
    velocities = np.linspace(0.5, 20.0, 60)
    batches = [steel.evaluate_batch("mid_car", velocity=velocities, threads=count).tobytes() for count in (1, 2, 3, None)]
    assert len(set(batches)) == 1


def test_arrays_are_broadcast(steel: Column) -> None:
    grid = steel.evaluate_batch(mass=np.array([1500.0, 2500.0]), velocity=np.array([[1.0], [2.0], [3.0]]))
    assert grid.shape == (3, 2)
    assert np.array_equal(grid["mass"][0], [1500.0, 2500.0])
    assert np.array_equal(grid["velocity"][:, 0], [1.0, 2.0, 3.0])
    assert steel.evaluate_batch("mid_car", velocity=[]).shape == (0,)
    assert steel.evaluate_batch(mass=1500.0, velocity=3.0).shape == ()
    own = steel.evaluate_batch("mid_car", velocity=[5.0, 6.0])
    assert np.array_equal(own["mass"], [1719.0, 1719.0])
    assert steel.evaluate_batch("mid_car", mass=[1800.0])["velocity"] == steel["impact.velocity"]
    # Views that are not contiguous, and whole numbers.
    assert np.array_equal(steel.evaluate_batch(mass=np.arange(1000, 3000, 500)[::2], velocity=3)["mass"], [1000.0, 2000.0])
    with pytest.raises(ValueError, match="broadcast"):
        steel.evaluate_batch(mass=[1.0, 2.0], velocity=[1.0, 2.0, 3.0])


def test_actions_are_ordered(steel: Column) -> None:
    batch = steel.evaluate_batch(mass=8000.0, velocity=np.linspace(0.5, 25.0, 20))
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
    steel.evaluate_batch("mid_car", velocity=velocities, threads=1)
    elapsed = time.perf_counter() - start
    counted = count - before
    over.set()
    thread.join()
    # Whatever the load of the machine: a thread that runs again after each sleep has counted more than a few times.
    assert counted >= 10, f"{counted} in {elapsed:.3f} s"


def test_two_threads_compute_at_once(steel: Column) -> None:
    velocities = np.linspace(5.0, 20.0, 50)
    expected = steel.evaluate_batch("mid_car", velocity=velocities).tobytes()
    found: list[bytes] = []

    def work() -> None:
        found.append(steel.evaluate_batch("mid_car", velocity=velocities, threads=1).tobytes())

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected] * 3


CALLS = {
    "batch": "column.evaluate_batch('mid_car', velocity=np.linspace(1.0, 20.0, 3_000_000))",
    "map": "column.map(mass=Range(1000, 3000, points=1000), velocity=Range(1, 20, points=3000), vehicle='van')",
    "refined_map": "column.refined_map(mass=Range(1000, 3000, points=20000), velocity=Range(1, 20, points=1000), vehicle='van')",
    "risk": "column.risk('urban', 1000, samples=10_000_000, exact=True)",
    "critical_velocities": "[column.critical_velocities('articulated_36t', lowest=0.1 + 1e-6 * i) for i in range(100_000)]",
}


@pytest.mark.parametrize("call", CALLS)
def test_ctrl_c_ends_every_long_call(call: str) -> None:
    """In a process of its own: SIGINT during a call that takes far longer than the test, once it runs, and at once, when a batch
    still checks its impacts."""
    script = (
        "import time, numpy as np\n"
        "from column_twin import Column, Range\n"
        "column = Column()\n"
        "print('ready', flush=True)\n"
        "try:\n"
        f"    {CALLS[call]}\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted', flush=True)\n"
    )
    for wait in (0.1, 0.6):
        with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            time.sleep(wait)
            os.kill(process.pid, signal.SIGINT)
            assert process.stdout.readline() == "interrupted\n"
            process.kill()


def test_a_batch_takes_at_most_three_times_the_memory_of_its_result() -> None:
    """It took 18 times as much. The impacts are over at once, and what the process has before the batch is subtracted."""
    count = 150_000
    script = (
        "import numpy as np\n"
        "from column_twin import Column\n"
        # In kB, of this program alone: the figure of getrusage begins with that of the process that has started it.
        "def peak():\n"
        "    lines = open('/proc/self/status').read().splitlines()\n"
        "    return int(next(it for it in lines if it.startswith('VmHWM')).split()[1])\n"
        "column = Column()\n"
        "column.evaluate_batch('rigid', mass=1.0, velocity=np.full(5000, 1e-6))\n"
        f"speeds = np.full({count}, 1e-6)\n"
        "before = peak()\n"
        "rows = column.evaluate_batch('rigid', mass=1.0, velocity=speeds)\n"
        "print((peak() - before) * 1024 / rows.nbytes)\n"
    )
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert 1.0 < float(ran.stdout) <= 3.0, ran.stdout


def test_a_wrong_impact_is_found_before_any_is_computed() -> None:
    """The last of so many impacts that the computation of the others would take minutes."""
    velocities = np.full(300_000, 20.0)
    velocities[-1] = 90.0
    with pytest.raises(ParameterError, match="element 299999: "):
        Column().evaluate_batch("articulated_36t", velocity=velocities)

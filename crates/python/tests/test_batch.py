"""Many impacts at once: equal to single ones, on any number of threads, without the GIL, interruptible."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from column_twin import CRITERIA, EVALUATION, Action, Column, ParameterError, to_pandas

ROOT = Path(__file__).resolve().parents[3]


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
    with pytest.raises(ParameterError, match=r"mass and velocity: expected shapes that can be broadcast .* found \(2,\) and \(3,\)"):
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
    # Its 10 000 columns are made before the first cell.
    "map over four quantities": (
        "column.map(top__load=Range(1e5, 5e5, points=100), height=Range(0.5, 1.5, points=100), mass=Range(1000, 3000, points=10), "
        "velocity=Range(1, 20, points=30), vehicle='van')"
    ),
    # One computes only what it needs to find the boundaries, and ends within a second.
    "refined_map": (
        "[column.refined_map(mass=Range(1000, 3000, points=20000), velocity=Range(1, 20, points=1000), vehicle='van') "
        "for _ in range(100_000)]"
    ),
    "risk": "column.risk('urban', 1000, samples=10_000_000, exact=True)",
    # A cell of the beam takes tenths of a second, and the call does not wait for its end.
    "map by the beam": (
        "column.map(mass=Range(1000, 3000, points=100), velocity=Range(1, 20, points=300), vehicle='van', model='both')"
    ),
    "refined_map by the beam": (
        "column.refined_map(mass=Range(1000, 3000, points=100), velocity=Range(1, 20, points=300), vehicle='van', model='both')"
    ),
    "risk by the beam": (
        "column.risk('courtyard', 50, distributions=['orientation_deg=uniform:-90:90'], model='beam', samples=1_000_000)"
    ),
    "risk by both models": (
        "column.risk('courtyard', 50, distributions=['orientation_deg=uniform:-90:90'], model='both', samples=1_000_000)"
    ),
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
        "try:\n"
        "    print('ready', flush=True)\n"
        f"    {CALLS[call]}\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted', flush=True)\n"
    )
    for wait in (0.1, 0.6):
        with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            time.sleep(wait)
            before = time.perf_counter()
            os.kill(process.pid, signal.SIGINT)
            assert process.stdout.readline() == "interrupted\n"
            print(f"{call} ended {1e3 * (time.perf_counter() - before):.0f} ms after Ctrl-C")
            process.kill()


# One computation each, which takes far longer than the test.
SINGLE = {
    # It was followed to its end, because it is short; its steps are many.
    "evaluate": (
        "column = Column(solver__scheme='midpoint', solver__dt=1e-7, response__duration=10.0)",
        "column.evaluate('rigid', mass=1500.0, velocity=3.0)",
    ),
    "estimate": (
        f"column = Column.from_file({str(ROOT / 'config/sensors_industrial.yaml')!r}); "
        "readings = column.sensor_readings('mid_car', velocity=12.0)",
        "column.estimate(readings)",
    ),
}


# The thread of a call; the kernel keeps the first 15 characters of its name.
CALLING = "column_twin cal"


def threads_of(process: int) -> set[str]:
    """The names of its threads."""
    found = set()
    for task in Path(f"/proc/{process}/task").iterdir():
        with contextlib.suppress(OSError):  # it has ended
            found.add((task / "comm").read_text().strip())
    return found


@pytest.mark.parametrize("call", SINGLE)
def test_ctrl_c_does_not_wait_for_the_end_of_one_computation(call: str) -> None:
    """The thread that computes is there when the call has ended."""
    before, computed = SINGLE[call]
    script = (
        "from column_twin import Column\n"
        f"{before}\n"
        "print('ready', flush=True)\n"
        "input()\n"
        "try:\n"
        f"    {computed}\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted', flush=True)\n"
        "    input()\n"
    )
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", script], stdin=pipe, stdout=pipe, text=True) as process:
        assert process.stdin is not None and process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        # The thread of the call before may be about to end.
        while CALLING in threads_of(process.pid):
            time.sleep(0.01)
        process.stdin.write("\n")
        process.stdin.flush()
        while CALLING not in threads_of(process.pid):
            assert process.poll() is None
            time.sleep(0.01)
        os.kill(process.pid, signal.SIGINT)
        assert process.stdout.readline() == "interrupted\n"
        threads = threads_of(process.pid)
        process.kill()
    assert CALLING in threads, threads


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

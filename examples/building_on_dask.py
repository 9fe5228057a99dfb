#!/usr/bin/env python3
"""A thousand columns of a building, each hit by every vehicle at many speeds, on a Dask cluster.

    pip install ./crates/python "dask[distributed]"
    python examples/building_on_dask.py
    python examples/building_on_dask.py --columns 40 --check      # a smaller building, compared with one process

A study is a pure function of a column and two arrays, so that any engine can distribute it: here Dask, with a cluster of two
processes on this machine. For a cluster of many machines, pass the address of its scheduler: --scheduler tcp://...:8786.
Every process needs the same version of column-twin; a column that was pickled by another one is rejected.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import numpy.typing as npt
from dask.distributed import Client, LocalCluster

from column_twin import Column, Action

SECTIONS = ("HEB 180", "HEB 200", "HEB 220", "HEB 260", "HEB 300")
VEHICLES = ("mid_car", "van", "lorry_8t")
BAYS = 50
SPEEDS = np.array([2.0, 5.0, 8.0, 11.0])


def building(count: int) -> list[Column]:
    """The columns of a building: sections by bay, loads that grow towards the lower floors, two heights of storeys."""
    columns = []
    floors = -(-count // BAYS)
    for number in range(count):
        floor, bay = divmod(number, BAYS)
        columns.append(
            Column(
                column_id=f"f{floor}b{bay}",
                section__name=SECTIONS[bay % len(SECTIONS)],
                geometry__length_above=3.0 if floor == 0 else 2.4,
                # Of this floor and of all that it carries.
                top__load=(2.0e4 + 1.0e2 * bay) * (floors - floor),
            )
        )
    return columns


def study(column: Column) -> npt.NDArray[np.void]:
    """One task: all vehicles at all speeds on one column, on one thread, because the cluster has a process per processor."""
    return np.stack([column.evaluate_batch(name, velocity=SPEEDS, threads=1) for name in VEHICLES])


def on_cluster(columns: list[Column], scheduler: str | None) -> npt.NDArray[np.void]:
    """The study of all columns on a cluster: that of the scheduler, or two processes on this machine."""
    if scheduler is not None:
        with Client(scheduler) as client:
            return np.stack(client.gather(client.map(study, columns)))
    # Loopback only, and no dashboard: nothing listens on the network.
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        return np.stack(client.gather(client.map(study, columns)))


def report(columns: list[Column], evaluations: npt.NDArray[np.void]) -> None:
    """The share of the columns that must be shored, and the columns that need protection most: those that have the least reserve
    after an impact of each vehicle at the lowest speed."""
    severe = evaluations["action"] >= Action.SHORE
    print(f"{'vehicle':12}" + "".join(f"{speed:>12g} m/s" for speed in SPEEDS))
    for index, name in enumerate(VEHICLES):
        shares = severe[:, index, :].mean(axis=0)
        print(f"{name:12}" + "".join(f"{100 * share:14.1f} %" for share in shares))
    print("share of the columns that must be shored or left; the weakest ones after an impact at the lowest speed:")
    reserve = evaluations["reserve"][:, :, 0].min(axis=1)
    for index in np.argsort(reserve, kind="stable")[:5]:
        print(f"  {columns[index]['column_id']:8} reserve {reserve[index]:.3f} {columns[index]!r}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--columns", type=int, default=1000, help="number of columns (default: 1000)")
    parser.add_argument("--scheduler", help="address of a Dask scheduler; default: two processes on this machine")
    parser.add_argument("--check", action="store_true", help="compute everything again in this process and compare")
    options = parser.parse_args()

    columns = building(options.columns)
    start = time.perf_counter()
    evaluations = on_cluster(columns, options.scheduler)
    elapsed = time.perf_counter() - start
    print(f"{evaluations.size} impacts on {len(columns)} columns in {elapsed:.1f} s, start of the cluster included\n")
    report(columns, evaluations)
    if options.check:
        alone = np.stack([study(column) for column in columns])
        if evaluations.tobytes() != alone.tobytes():
            raise SystemExit("the cluster and this process differ")
        print("\nThe cluster and this process agree bit for bit.")


if __name__ == "__main__":
    main()

"""Figures with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt

from ._result import HINGES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ._capacity import Capacity
    from ._result import Result


def response(result: Result) -> Figure:
    """Displacements, forces, moments and plastic rotations against time."""
    figure, axes = plt.subplots(2, 2, figsize=(10, 6.5), sharex=True, layout="constrained")
    time = 1e3 * result.time
    (displacement, force), (moment, rotation) = axes

    displacement.plot(time, 1e3 * result.v1, label="v1, impact point")
    displacement.plot(time, 1e3 * result.u2, label="u2, top, down")
    if result.crush.shape[1]:
        displacement.plot(time, 1e3 * result.crush[:, 0], "--", label="crush of the front")
    displacement.set_ylabel("displacement [mm]")

    force.plot(time, 1e-3 * result.contact_force, label="contact force")
    force.plot(time, -1e-3 * result.normal_forces[:, 0], label="compression below")
    force.plot(time, -1e-3 * result.normal_forces[:, 1], label="compression above")
    force.set_ylabel("force [kN]")

    for index, hinge in enumerate(HINGES):
        moment.plot(time, 1e-3 * result.moments[:, index], label=f"hinge {hinge}")
        rotation.plot(time, 1e3 * result.plastic_rotations[:, index], label=f"hinge {hinge}")
    moment.set_ylabel("bending moment [kN m]")
    rotation.set_ylabel("plastic rotation [mrad]")

    for ax in axes.flat:
        ax.grid(alpha=0.3)
        ax.legend(fontsize="small")
    for ax in (moment, rotation):
        ax.set_xlabel("time [ms]")
    figure.suptitle(f"{result.title}: {result.outcome}, {result.severity}")
    return figure


def push_down(capacity: Capacity, ax: Axes | None) -> Axes:
    """Force against displacement of the impact point, with the capacity and the carried load."""
    if ax is None:
        ax = plt.subplots(layout="constrained")[1]
    curve = capacity.push_down
    (line,) = ax.plot(1e3 * curve.v1, 1e-3 * curve.force, label=f"{capacity.report['state']}: {1e-3 * capacity.force:.0f} kN")
    ax.axhline(1e-3 * capacity.force, color=line.get_color(), linestyle=":", linewidth=1)
    if not any(it.get_label() == "carried load" for it in ax.lines):
        ax.axhline(1e-3 * capacity.carried_load, color="0.4", linestyle="--", linewidth=1, label="carried load")
    ax.set_xlabel("v1, bow included [mm]")
    ax.set_ylabel("axial force [kN]")
    ax.grid(alpha=0.3)
    ax.legend(fontsize="small")
    return ax

"""Figures with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

from ._codes import Action
from ._html import COLOURS
from ._result import HINGES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ._capacity import Capacity
    from ._map import Map, MapAxis
    from ._result import Result
    from ._risk import Risk


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
    figure.suptitle(f"{result.title}: {result.outcome}, {result.action}")
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


def damage_map(damage: Map, ax: Axes | None, label: str | None) -> Axes:
    """Action as colours, and lines of equal residual displacement."""
    if ax is None:
        ax = plt.subplots(layout="constrained")[1]
    cells = damage._of_label(label)
    x, y = _positions(damage.columns), _positions(damage.rows)
    colours = ListedColormap([COLOURS[it] for it in Action] + ["#9e9e9e"])
    # A code above every action: not computed.
    norm = BoundaryNorm([*(it - 0.5 for it in Action), max(Action) + 0.5, 255.5], colours.N)
    ax.pcolormesh(x, y, cells["action"], cmap=colours, norm=norm, shading="nearest", alpha=0.8)
    if min(cells.shape) > 1 and not (damage.rows.values.dtype.kind == "U" or damage.columns.values.dtype.kind == "U"):
        residual = 1e3 * cells["residual_v1"]
        levels = [level for level in (1, 2, 5, 10, 20, 50, 100, 200, 500) if np.nanmin(residual) < level < np.nanmax(residual)]
        if levels:
            lines = ax.contour(x, y, residual, levels=levels, colors="black", linewidths=0.8)
            ax.clabel(lines, fmt="%g mm", fontsize="small")
    for axis, values in ((ax.xaxis, damage.columns), (ax.yaxis, damage.rows)):
        if values.values.dtype.kind == "U":
            axis.set_ticks(range(len(values)), labels=list(values.values))
    ax.set_xlabel(damage.columns.label)
    ax.set_ylabel(damage.rows.label)
    present = [it for it in Action if (cells["action"] == it).any()]
    ax.legend(handles=[Patch(color=COLOURS[it], label=str(it)) for it in present], fontsize="small", loc="upper left")
    if damage.cells.ndim == 3:
        ax.set_title(label or damage.labels[0])
    return ax


def _positions(axis: MapAxis) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Where the values of an axis are drawn: names at equal distances."""
    if axis.values.dtype.kind == "U":
        return np.arange(len(axis), dtype=np.float64)
    return np.asarray(axis.values, dtype=np.float64)


def fragility(risk: Risk, ax: Axes | None) -> Axes:
    """Probability of each action of the whole traffic against the speed."""
    if ax is None:
        ax = plt.subplots(layout="constrained")[1]
    for curve in risk.report["fragility"]:
        if curve["vehicle"] is not None:
            continue
        points = [point for point in curve["points"] if point["probability"] is not None]
        if not points:
            continue
        speed = np.array([3.6 * 0.5 * sum(point["speed"]) for point in points])
        value, low, high = (np.array([point["probability"][it] for point in points]) for it in ("value", "low", "high"))
        colour = COLOURS[Action[curve["action"].upper()]]
        ax.plot(speed, value, ".-", color=colour, label=f"{curve['action']} or worse")
        ax.fill_between(speed, low, high, color=colour, alpha=0.15)
    ax.set_xlabel("speed at the column [km/h]")
    ax.set_ylabel("probability given an impact")
    ax.grid(alpha=0.3)
    ax.legend(fontsize="small")
    return ax

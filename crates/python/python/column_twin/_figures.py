"""Figures with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

from ._codes import Action
from ._errors import ParameterError
from ._html import COLOURS, LINES, NOT_COMPUTED
from ._result import HINGES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._capacity import Capacity
    from ._map import Map, MapAxis, RefinedMap
    from ._result import Result
    from ._risk import Risk


_Lines = list[tuple[str, "np.ndarray[tuple[int], np.dtype[np.float64]]"]]


def _new(ax: Axes | None) -> Axes:
    """The axes of the caller, or those of a new figure."""
    return plt.subplots(layout="constrained")[1] if ax is None else ax


def _lines_of(result: Result, quantity: str) -> tuple[str, _Lines]:
    """Title of the axis, and the lines of a quantity with their names."""
    if quantity == "displacement":
        lines: _Lines = [("v1, impact point", 1e3 * result.v1), ("u2, top, down", 1e3 * result.u2)]
        if result.crush.shape[1]:
            lines.append(("crush of the front", 1e3 * result.crush[:, 0]))
        return "displacement [mm]", lines
    if quantity == "force":
        below, above = -1e-3 * result.normal_forces[:, 0], -1e-3 * result.normal_forces[:, 1]
        force = 1e-3 * result.contact_force
        return "force [kN]", [("contact force", force), ("compression below", below), ("compression above", above)]
    if quantity == "moment":
        moments = 1e-3 * result.moments
        return "bending moment [kN m]", [(f"hinge {it}", moments[:, index]) for index, it in enumerate(HINGES)]
    if quantity == "rotation":
        rotations = 1e3 * result.plastic_rotations
        return "plastic rotation [mrad]", [(f"hinge {it}", rotations[:, index]) for index, it in enumerate(HINGES)]
    raise ParameterError(f"quantity: expected displacement, force, moment or rotation; found {quantity!r}")


def response(result: Result, ax: Axes | None, quantity: str) -> Axes:
    """One quantity against time."""
    title, lines = _lines_of(result, quantity)
    ax = _new(ax)
    for (name, values), colour, dash in zip(lines, LINES, ("-", "--", "-.", ":")):
        ax.plot(1e3 * result.time, values, dash, color=colour, label=name)
    ax.set_xlabel("time [ms]")
    ax.set_ylabel(title)
    ax.grid(alpha=0.3)
    ax.legend(fontsize="small")
    return ax


def overview(result: Result) -> list[Axes]:
    """Displacements, forces, moments and plastic rotations against time."""
    figure, axes = plt.subplots(2, 2, figsize=(10, 6.5), sharex=True, layout="constrained")
    for ax, quantity in zip(axes.flat, ("displacement", "force", "moment", "rotation")):
        response(result, ax, quantity)
    for ax in axes[0]:
        ax.set_xlabel("")
    figure.suptitle(f"{result.title}: {result.outcome}, {result.action}")
    return list(axes.flat)


def push_down(capacity: Capacity, ax: Axes | None) -> Axes:
    """Force against displacement of the impact point, with the capacity and the carried load."""
    ax = _new(ax)
    curve = capacity.push_down
    # The next colour: axes may have the curves of other capacities.
    colour = LINES[sum(line.get_linestyle() == "-" for line in ax.lines) % len(LINES)]
    label = f"{capacity.report['state']}: {1e-3 * capacity.force:.0f} kN"
    ax.plot(1e3 * curve.v1, 1e-3 * curve.force, color=colour, label=label)
    ax.axhline(1e-3 * capacity.force, color=colour, linestyle=":", linewidth=1)
    if not any(it.get_label() == "carried load" for it in ax.lines):
        ax.axhline(1e-3 * capacity.carried_load, color="0.4", linestyle="--", linewidth=1, label="carried load")
    ax.set_xlabel("v1, bow included [mm]")
    ax.set_ylabel("axial force [kN]")
    ax.grid(alpha=0.3)
    ax.legend(fontsize="small")
    return ax


def damage_map(damage: Map, ax: Axes | None, label: str | None) -> Axes:
    """Action as colours, and lines of equal residual displacement."""
    ax = _new(ax)
    cells = damage._of_label(label)
    x, y = _positions(damage.columns), _positions(damage.rows)
    colours = ListedColormap([COLOURS[it] for it in Action] + [NOT_COMPUTED])
    # A code above every action: not computed.
    norm = BoundaryNorm([*(it - 0.5 for it in Action), max(Action) + 0.5, 255.5], colours.N)
    ax.pcolormesh(x, y, cells["action"], cmap=colours, norm=norm, shading="nearest")
    if min(cells.shape) > 1 and not (damage.rows.values.dtype.kind == "U" or damage.columns.values.dtype.kind == "U"):
        residual = 1e3 * cells["residual_v1"]
        known = residual[np.isfinite(residual)]
        levels = [level for level in (1, 2, 5, 10, 20, 50, 100, 200, 500) if known.size and known.min() < level < known.max()]
        if levels:
            lines = ax.contour(x, y, residual, levels=levels, colors="black", linewidths=0.8)
            ax.clabel(lines, fmt="%g mm", fontsize="small")
    for axis, values in ((ax.xaxis, damage.columns), (ax.yaxis, damage.rows)):
        if values.values.dtype.kind == "U":
            axis.set_ticks(range(len(values)), labels=list(values.values))
    ax.set_xlabel(damage.columns.label)
    ax.set_ylabel(damage.rows.label)
    present = [it for it in Action if (cells["action"] == it).any()]
    handles = [Patch(color=COLOURS[it], label=str(it)) for it in present]
    if (cells["action"] == 255).any():
        handles.append(Patch(color=NOT_COMPUTED, label="not computed"))
    ax.legend(handles=handles, fontsize="small", loc="upper left")
    title = [label or damage.labels[0]] if damage.compared is not None else []
    title += [axis._text(0) for axis in damage.fixed]
    if title:
        ax.set_title(", ".join(title))
    return ax


def boundaries(refined: RefinedMap, ax: Axes | None, label: str | None) -> Axes:
    """Where each action begins."""
    ax = _new(ax)
    actions = [it for it in Action if it is not Action.NONE]
    for action, dash in zip(actions, ("-", "--", "-.", ":")):
        rows, columns = refined.boundary(action, label)
        if rows.size:
            ax.plot(columns, rows, dash, color=_dark(action), label=str(action))
    for setter, axis in ((ax.set_xlabel, refined.report["columns"]), (ax.set_ylabel, refined.report["rows"])):
        setter(f"{axis['name']} [{axis['unit']}]" if axis["unit"] else axis["name"])
    ax.grid(alpha=0.3)
    ax.legend(fontsize="small")
    return ax


def _dark(action: Action) -> str:
    """The colour of an action as a line, which a light one would hide on white."""
    return LINES[0] if action == Action.INSPECT else COLOURS[action]


def _positions(axis: MapAxis) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Where the values of an axis are drawn: names at equal distances."""
    if axis.values.dtype.kind == "U":
        return np.arange(len(axis), dtype=np.float64)
    return np.asarray(axis.values, dtype=np.float64)


def fragility(risk: Risk, ax: Axes | None) -> Axes:
    """Probability of each action of the whole traffic against the speed."""
    ax = _new(ax)
    for curve in risk.report["fragility"]:
        if curve["vehicle"] is not None:
            continue
        points = [point for point in curve["points"] if point["probability"] is not None]
        if not points:
            continue
        speed = np.array([3.6 * 0.5 * sum(point["speed"]) for point in points])
        value, low, high = (np.array([point["probability"][it] for point in points]) for it in ("value", "low", "high"))
        colour = _dark(Action[curve["action"].upper()])
        ax.plot(speed, value, ".-", color=colour, label=f"{curve['action']} or worse")
        ax.fill_between(speed, low, high, color=colour, alpha=0.15)
    ax.set_xlabel("speed at the column [km/h]")
    ax.set_ylabel("probability given an impact")
    ax.grid(alpha=0.3)
    ax.legend(fontsize="small")
    return ax

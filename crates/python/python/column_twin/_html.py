"""How objects look in a notebook: a table and a small drawing, without any further package."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from itertools import islice, product
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ._codes import Action
from ._loading import native

if TYPE_CHECKING:
    from ._capacity import Capacity
    from ._column import Column
    from ._map import Map
    from ._result import Result
    from ._risk import Risk
    from ._evaluation import Evaluation

COLOURS: dict[Action, str] = {action: "#" + rgb.hex() for action, rgb in zip(Action, native.action_colours())}
"""Colours of the actions, in tables and maps: those of the program, from light to dark, of hues that the colour-blind
distinguish."""

NOT_COMPUTED = "#9e9e9e"
"""Colour of cells that could not be computed."""

LINES = ("#0072b2", "#d55e00", "#009e73", "#e69f00", "#cc79a7", "#56b4e9")
"""Colours of lines, after Okabe and Ito."""

_WIDTH, _HEIGHT = 420, 120


def _badge(action: Action | None) -> str:
    if action is None:
        return "<b>not assessed</b>"
    ink = "#fff" if action == Action.EVACUATE else "#000"
    return (
        f'<span style="background:{COLOURS[action]};color:{ink};padding:1px 8px;border-radius:3px">'
        f"{escape(str(action).upper())}</span>"
    )


def _rows(rows: Iterable[tuple[str, str]]) -> str:
    cells = "".join(
        f'<tr><td style="text-align:left">{escape(name)}</td><td style="text-align:left">{value}</td></tr>'
        for name, value in rows
    )
    return f"<table>{cells}</table>"


def _mm(metres: float | None) -> str:
    return "none" if metres is None or np.isnan(metres) else f"{1e3 * metres:.4g} mm"


def _kn(newtons: float) -> str:
    return f"{1e-3 * newtons:.4g} kN"


def _line(x: npt.NDArray[np.float64], y: npt.NDArray[np.float64], colour: str) -> str:
    """A line over the whole drawing, with at most as many points as it is wide."""
    pick = np.unique(np.linspace(0, x.size - 1, min(x.size, _WIDTH)).astype(int))
    span = x[-1] - x[0] or 1.0
    low, high = min(0.0, float(y.min())), max(0.0, float(y.max()))
    height = high - low or 1.0
    points = " ".join(
        f"{_WIDTH * (x[i] - x[0]) / span:.1f},{4 + (_HEIGHT - 8) * (high - y[i]) / height:.1f}" for i in pick
    )
    return f'<polyline fill="none" stroke="{colour}" stroke-width="1.5" points="{points}"/>'


def _drawing(result: Result) -> str:
    v1 = _line(result.time, result.v1, LINES[0])
    force = _line(result.time, result.contact_force, LINES[1])
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" width="{_WIDTH}" height="{_HEIGHT}" '
        f'role="img" aria-label="v1 and contact force against time">{force}{v1}</svg>'
        f'<div style="font-size:smaller"><span style="color:{LINES[0]}">v1, largest {_mm(result.max_v1)}</span>, '
        f'<span style="color:{LINES[1]}">contact force, largest {_kn(result.report["peak_contact_force_n"])}</span>, '
        f"{1e3 * float(result.time[-1]):.4g} ms</div>"
    )


def result(result: Result) -> str:
    """The verdict, the numbers and a drawing of one impact."""
    report = result.report
    ratio = report["capacity_ratio"]
    rows = [
        ("action", f"{_badge(result.action)} {escape(report['deciding_criterion'] or '')}"),
        ("outcome", escape(str(result.outcome))),
        ("peak v1", _mm(result.max_v1)),
        ("residual v1", _mm(result.residual_v1)),
        ("peak contact force", _kn(report["peak_contact_force_n"])),
        ("residual capacity", "unknown" if ratio is None else f"{100 * ratio:.3g} % of the undamaged column"),
    ]
    if report["crush_max_m"]:
        rows.append(("crush of the front", _mm(report["crush_max_m"][0])))
    return f"<div><b>{escape(result.title)}</b>{_rows(rows)}{_drawing(result)}</div>"


def evaluation(evaluation: Evaluation) -> str:
    """The verdict and the numbers of one impact."""
    title = f"{evaluation.mass:g} kg at {evaluation.velocity:g} m/s"
    rows = [
        ("action", f"{_badge(evaluation.action)} {escape(evaluation.deciding_criterion)}"),
        ("outcome", escape(str(evaluation.outcome))),
        ("peak v1", _mm(evaluation.max_v1)),
        ("residual v1", _mm(evaluation.residual_v1)),
        ("peak contact force", _kn(evaluation.peak_contact_force)),
        ("residual capacity", f"{100 * evaluation.capacity_ratio:.3g} % of the undamaged column"),
    ]
    return f"<div><b>{escape(title)}</b>{_rows(rows)}</div>"


def capacity(capacity: Capacity) -> str:
    """Capacities, load and verdict."""
    reserve = capacity.reserve
    rows = [
        ("action", f"{_badge(capacity.action)} {escape(capacity.report['deciding_criterion'])}"),
        ("push-down of the undamaged column", _kn(capacity.undamaged_force)),
        ("push-down now", f"{_kn(capacity.force)}, {100 * capacity.ratio:.3g} %"),
        ("N_u", _kn(capacity.axial_capacity)),
        ("load", escape(capacity.report["load"])),
        ("reserve N_u / N", "none" if reserve is None else f"{reserve:.3g}"),
    ]
    return f"<div><b>Capacity, {escape(capacity.report['state'])}</b>{_rows(rows)}</div>"


def column(column: Column) -> str:
    """The column, and the parameters that differ from the defaults."""
    defaults = type(column)().parameters
    rows = [
        (f"{name} [{unit}]" if unit else name, escape(str(value)))
        for name, value, unit, _ in column.describe()
        if value != defaults[name]
    ]
    text = escape(repr(column).strip("<>"))
    below = _rows(rows) if rows else "<div>all parameters have their defaults</div>"
    return f"<div><b>{text}</b>{below}</div>"


_PLANES = 12
"""Most planes of a map that are drawn."""


def damage_map(damage: Map) -> str:
    """How many cells have each action, and drawings of the planes, one for each column that is compared and each combination of the
    values of further axes."""
    cells = damage._data.reshape(-1, len(damage.rows), len(damage.columns))
    texts = [[axis._text(it) for it in range(len(axis))] for axis in (*damage.fixed, *damage.further)]
    captions = [", ".join(it) for it in islice(product(damage.labels, *texts), _PLANES)]
    parts = [
        f"<figure style=\"display:inline-block;margin:4px\">{_plane(plane['action'])}"
        f"<figcaption>{escape(caption)}</figcaption></figure>"
        for caption, plane in zip(captions, cells)
    ]
    if len(cells) > _PLANES:
        parts.append(f"<div>{_PLANES} of {len(cells)} planes</div>")
    counts = [
        f"{_badge(action)} {int((cells['action'] == action).sum())}"
        for action in Action
        if (cells["action"] == action).any()
    ]
    axes = f"{damage.columns.label} to the right, {damage.rows.label} upwards"
    return f"<div>{''.join(parts)}<div>{' '.join(counts)} cells; {escape(axes)}</div></div>"


def _plane(action: npt.NDArray[np.uint16]) -> str:
    """Rectangles of equal action, row by row; at most 60 rows and columns are drawn."""
    rows, columns = (np.unique(np.linspace(0, size - 1, min(size, 60)).astype(int)) for size in action.shape)
    width, height = 240 / columns.size, 160 / rows.size
    boxes = []
    for place, row in enumerate(rows):
        line = action[row, columns]
        starts = np.flatnonzero(np.diff(line, prepend=np.uint16(254)))
        ends = np.append(starts[1:], line.size)
        for start, end in zip(starts, ends):
            code = int(line[start])
            colour = COLOURS[Action(code)] if code <= max(Action) else NOT_COMPUTED
            boxes.append(
                f'<rect x="{start * width:.2f}" y="{160 - (place + 1) * height:.2f}" width="{(end - start) * width + 0.3:.2f}" '
                f'height="{height + 0.3:.2f}" fill="{colour}"/>'
            )
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 240 160" width="240" height="160" role="img" '
        f'aria-label="action">{"".join(boxes)}</svg>'
    )


def risk(risk: Risk) -> str:
    """The probability of each action in the period, with its interval."""
    exposure = risk.report["exposure"]
    rows = []
    for row in risk.report["actions"]:
        chance = row["in_period"]
        rows.append(
            (f"{row['action']} or worse", f"{chance['value']:.2e} ({chance['low']:.1e} to {chance['high']:.1e})")
        )
    title = (
        f"Risk, {risk.scenario}: {exposure['vehicles_per_day']:g} vehicles per day, {exposure['years']:g} a, "
        f"{risk.samples} samples"
    )
    return f"<div><b>{escape(title)}</b>{_rows(rows)}</div>"

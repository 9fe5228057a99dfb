#!/usr/bin/env python3
"""Cost of a response by the fibre beam and by OpenSees, both in turns in one run, so that the load of the machine hits both alike.

    pip install openseespy==3.7.1.2
    python crates/beam/benches/opensees.py
    python crates/beam/benches/opensees.py --rounds 1 --only plane01
    python crates/beam/benches/opensees.py --all-in-space

Builds the hits of `crates/beam/tests/data` in OpenSees, with the nodes, fibres and steps that it gives the beam as well, checks that
OpenSees finds the peak of the reference, and prints Markdown tables of processor time: the fastest of the rounds.

OpenSees: `dispBeamColumn` with two Gauss points, corotational, lumped masses, `Steel01`, Newmark's mean acceleration, Newton's method.
Its time begins with the first step and ends with the peak, in one call of `analyze`, so that neither the model nor Python costs it
anything. The time of the beam contains its mesh and its equilibrium under the load.
"""

from __future__ import annotations

import argparse
import glob
import json
import math
import os
import platform
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]

# The libraries that the wheel brings are found only if the loader knows their folder when the interpreter starts.
BUNDLED = "openseespylinux/lib"
if not os.environ.get("COLUMN_BEAM_LIBRARIES"):
    folders = [folder for path in sys.path for folder in glob.glob(f"{path}/{BUNDLED}")]
    paths = os.pathsep.join(filter(None, [*folders, os.environ.get("LD_LIBRARY_PATH")]))
    os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | {"LD_LIBRARY_PATH": paths, "COLUMN_BEAM_LIBRARIES": "found"})

try:
    import openseespy.opensees as ops
except ImportError as error:
    sys.exit(f"OpenSees is missing ({error}); install it with\n    pip install openseespy==3.7.1.2")

# Largest deviation of OpenSees from the peak of the reference, and of the beam on the same mesh from OpenSees.
TOLERANCE, TOLERANCE_IN_SPACE = 0.01, 0.03

CONTACT_STIFFNESS = 2e9  # N/m, as in the beam

# Norm of the unbalanced forces and moments [N, N m]: about the tolerance of the beam. A smaller one makes OpenSees slower.
UNBALANCE = 20.0

# Parts into which a step is divided that OpenSees does not solve.
PARTS = (2, 4, 8, 16, 32, 64)

MOST_STEPS = 20_000

TARGETS = {"plane, rigid": 15.0, "plane, soft": 10.0, "space at 45 degrees": 40.0}  # ms to the peak
TARGET_RATIO = 15.0

# Tags of nodes and elements beside those of the column.
ANCHOR, VEHICLE = 1000, 1001


class Beam:
    """The benchmark `cost`, which answers each command with a line of JSON."""

    def __init__(self) -> None:
        command = ["cargo", "bench", "--quiet", "--package", "column_beam", "--bench", "cost", "--", "--serve"]
        self.process = subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, *words: object) -> Any:
        assert self.process.stdin and self.process.stdout
        print(*words, file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline()
        if not answer:
            sys.exit("the benchmark `cost` has ended; run `cargo bench --package column_beam --bench cost` to see why")
        return json.loads(answer)


def fibres(shape: dict[str, float], in_space: bool) -> list[tuple[float, float, float]]:
    """Places y, z [m] and areas [m2] of the fibres: two layers of ten parts per flange, eight layers of the web, and the fillets."""
    h, b, r = shape["depth"], shape["width"], shape["root_radius"]
    web, flange = shape["web_thickness"], shape["flange_thickness"]
    clear = h - 2.0 * flange
    layers, across, along = 2, 10 if in_space else 1, 8
    found = []
    for side in (-1.0, 1.0):
        for layer in range(layers):
            y = side * (0.5 * h - flange * (layer + 0.5) / layers)
            found += [(y, b * ((part + 0.5) / across - 0.5), b * flange / (layers * across)) for part in range(across)]
        # A fillet is a square less a quarter disc, with its centroid 0.2234 r from the corner.
        y, z, area = side * (0.5 * clear - 0.223416 * r), 0.5 * web + 0.223416 * r, (1.0 - 0.25 * math.pi) * r * r
        found += [(y, -z, area), (y, z, area)]
    for layer in range(along):
        y, area = clear * ((layer + 0.5) / along - 0.5), clear * web / along
        found += [(y, -0.25 * web, 0.5 * area), (y, 0.25 * web, 0.5 * area)] if in_space else [(y, 0.0, area)]
    if not in_space:
        # Fibres at one height strain alike.
        by_height: dict[float, float] = {}
        for y, _, area in found:
            by_height[y] = by_height.get(y, 0.0) + area
        found = [(y, 0.0, area) for y, area in by_height.items()]
    return found


class Model:
    """A column in OpenSees at rest under its load, with a vehicle that touches it."""

    def __init__(self, case: dict[str, Any]) -> None:
        self.in_space = in_space = case["in_space"]
        column, heights = case["column"], case["heights"]
        self.step, steel = case["step"], column["steel"]
        dimensions, unknowns = (3, 6) if in_space else (2, 3)
        ops.wipe()
        ops.model("basic", "-ndm", dimensions, "-ndf", unknowns)
        section = fibres(column["shape"]["rolled"], in_space)
        self.top = len(heights)
        masses = [[0.0] * 3 for _ in heights]
        for below in range(len(heights) - 1):
            half = 0.5 * steel["density"] * (heights[below + 1] - heights[below])
            for y, z, area in section:
                for node in (below, below + 1):
                    masses[node] = [one + half * area * lever for one, lever in zip(masses[node], (1.0, y * y, z * z))]
        on_axis = [0.0] * (dimensions - 1)
        for node, (height, (mass, strong, weak)) in enumerate(zip(heights, masses), 1):
            ops.node(node, height, *on_axis)
            ops.mass(node, *[mass] * dimensions, *([strong + weak, weak, strong] if in_space else [strong]))
        for node, support, along in ((1, column["base"], 1), (self.top, column["top"], 0)):
            built_in = int(support == "built_in")
            assert built_in or support == "pinned", f"expected built_in or pinned; found the support {support}"
            ops.fix(node, along, *[1] * (dimensions - 1), *([1, built_in, built_in] if in_space else [built_in]))
        ops.uniaxialMaterial("Steel01", 1, steel["yield_strength"], steel["young_modulus"], steel["hardening_ratio"])
        ops.section("Fiber", 1, *(["-GJ", case["torsional_rigidity"]] if in_space else []))
        for y, z, area in section:
            ops.fiber(y, z, area, 1)
        ops.geomTransf("Corotational", 1, *([0.0, 0.0, 1.0] if in_space else []))
        ops.beamIntegration("Legendre", 1, 1, 2)
        for below in range(1, self.top):
            ops.element("dispBeamColumn", below, below, below + 1, 1, 1)
        ops.node(ANCHOR, heights[-1], *on_axis)
        ops.fix(ANCHOR, *[1] * unknowns)
        ops.uniaxialMaterial("Elastic", 2, column["top_spring_stiffness"])
        ops.element("zeroLength", ANCHOR, ANCHOR, self.top, "-mat", 2, "-dir", 1)
        self.load(column["top_load"], unknowns)
        self.strike(case, heights, unknowns)

    def load(self, load: float, unknowns: int) -> None:
        ops.timeSeries("Linear", 1)
        ops.pattern("Plain", 1, 1)
        ops.load(self.top, -load, *[0.0] * (unknowns - 1))
        self.solve_with(("LoadControl", 0.1), "Static", 1e-3)
        assert ops.analyze(10) == 0, "OpenSees finds no equilibrium under the load"
        ops.loadConst("-time", 0.0)
        ops.wipeAnalysis()

    def strike(self, case: dict[str, Any], heights: list[float], unknowns: int) -> None:
        """Places the vehicle at the impact point and lets it move."""
        at = min(heights, key=lambda height: abs(height - case["column"]["length_below"]))
        self.node = heights.index(at) + 1
        self.direction = [math.cos(case["direction"]), math.sin(case["direction"])][: 2 if self.in_space else 1]
        self.rest = self.place()
        mass, front = case["mass"], case["front"]
        ops.node(VEHICLE, at, *[0.0] * len(self.direction))
        ops.fix(VEHICLE, 1, *[0] * len(self.direction), *[1] * (unknowns - 1 - len(self.direction)))
        ops.mass(VEHICLE, 0.0, *[mass] * len(self.direction), *[0.0] * (unknowns - 1 - len(self.direction)))
        for axis, share in enumerate(self.direction, 2):
            ops.setNodeVel(VEHICLE, axis, case["velocity"] * share, "-commit")
        # The front and the contact are springs in series; a crushed front keeps its way.
        if front is None:
            ops.uniaxialMaterial("ENT", 3, CONTACT_STIFFNESS)
        else:
            stiffness = 1.0 / (1.0 / front["stiffness"] + 1.0 / CONTACT_STIFFNESS)
            if front["crush_force"] is None:
                ops.uniaxialMaterial("ENT", 3, stiffness)
            else:
                ops.uniaxialMaterial("ElasticPPGap", 3, stiffness, -front["crush_force"], -1e-9, 0.0, "damage")
        orient = [0.0, *self.direction, 1.0, 0.0, 0.0] if self.in_space else [0.0, 1.0, 0.0, -1.0, 0.0, 0.0]
        ops.element("zeroLength", VEHICLE, VEHICLE, self.node, "-mat", 3, "-dir", 1, "-orient", *orient)
        self.solve_with(("Newmark", 0.5, 0.25), "Transient", UNBALANCE)

    @staticmethod
    def solve_with(integrator: tuple[Any, ...], analysis: str, unbalance: float) -> None:
        ops.constraints("Plain")
        ops.numberer("RCM")
        # The fastest of the solvers of OpenSees for this matrix.
        ops.system("ProfileSPD")
        ops.test("NormUnbalance", unbalance, 50)
        ops.algorithm("Newton")
        ops.integrator(*integrator)
        ops.analysis(analysis)

    def place(self) -> float:
        """Displacement of the impact point along the hit [m]."""
        return sum(share * ops.nodeDisp(self.node, axis) for axis, share in enumerate(self.direction, 2))

    def advance(self) -> bool:
        """One step; whether it was solved as one."""
        if ops.analyze(1, self.step) == 0:
            return True
        for parts in PARTS:
            if all(ops.analyze(1, self.step / parts) == 0 for _ in range(parts)):
                return False
        sys.exit(f"OpenSees did not solve the step after {ops.getTime()} s, in {PARTS[-1]} parts either")

    def peak(self) -> tuple[float, int, int]:
        """Peak along the hit [m], its step, and how many steps were divided up to there."""
        largest, last, divided, divided_now = 0.0, 0, 0, 0
        for step in range(1, MOST_STEPS):
            divided_now += not self.advance()
            displaced = self.place() - self.rest
            if displaced > largest:
                largest, last, divided = displaced, step, divided_now
            elif displaced < 0.98 * largest and ops.nodeVel(VEHICLE, 2) < 0.0:
                return largest, last, divided
        sys.exit(f"OpenSees did not come back from its peak within {MOST_STEPS} steps")

    def time(self, steps: int, divided: int) -> float:
        """Processor time of so many steps [ms]."""
        began = time.process_time()
        if divided == 0:
            assert ops.analyze(steps, self.step) == 0
        else:
            for _ in range(steps):
                self.advance()
        return 1e3 * (time.process_time() - began)


def kind(case: dict[str, Any]) -> str:
    if case["in_space"]:
        return f"space at {math.degrees(case['direction']):.0f} degrees"
    return "plane, rigid" if case["front"] is None else "plane, soft"


def tolerance(case: dict[str, Any]) -> float:
    return TOLERANCE_IN_SPACE if case["in_space"] else TOLERANCE


def processor() -> str:
    names = [line.split(":")[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")]
    return f"{len(names)} x {names[0]}, Linux {platform.release()}"


def load() -> str:
    return f"{os.getloadavg()[0]:.1f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3, help="rounds, the fastest of which counts (default: 3)")
    parser.add_argument("--only", default="", help="only cases whose name contains this text")
    parser.add_argument("--all-in-space", action="store_true", help="hits in space at all angles, which take OpenSees minutes; otherwise at 45 degrees")
    arguments = parser.parse_args()
    # OpenSees reports every step that it has to divide on the standard error.
    ops.logFile(os.devnull, "-noEcho")
    beam = Beam()
    cases = list(enumerate(beam.ask("cases")))
    is_wanted = lambda case: arguments.all_in_space or not case["in_space"] or kind(case) in TARGETS
    cases = [(index, case) for index, case in cases if arguments.only in case["name"] and is_wanted(case)]
    began, load_before = time.time(), load()
    rows, faults = {}, []
    for index, case in cases:
        peak, steps, divided = Model(case).peak()
        row = {"steps": steps, "divided": divided, "peak": peak, "opensees": math.inf, "same": math.inf, "automatic": math.inf}
        if abs(peak / case["peak"] - 1.0) > tolerance(case):
            faults.append(f"{case['name']}: OpenSees finds {1e3 * peak:.2f} mm, the reference {1e3 * case['peak']:.2f} mm")
        rows[index] = row
        print(f"{case['name']}: {steps} steps to {1e3 * peak:.2f} mm, {divided} of them divided", file=sys.stderr)
    for number in range(arguments.rounds):
        print(f"round {number + 1} of {arguments.rounds}", file=sys.stderr)
        for index, case in cases:
            row = rows[index]
            model = Model(case)
            row["opensees"] = min(row["opensees"], model.time(row["steps"], row["divided"]))
            for choice in ("same", "automatic"):
                answer = beam.ask("time", index, choice)
                row[choice] = min(row[choice], answer["ms"])
                row[f"{choice} peak"] = answer["peak"]
    for index, case in cases:
        row = rows[index]
        if abs(row["same peak"] / row["peak"] - 1.0) > tolerance(case):
            faults.append(f"{case['name']}: the beam finds {1e3 * row['same peak']:.2f} mm, OpenSees {1e3 * row['peak']:.2f} mm")
    show(cases, rows)
    print(f"\n{processor()}; load {load_before} before and {load()} after {time.time() - began:.0f} s; OpenSees {ops.version()}")
    for fault in faults:
        print("DIFFERENT:", fault)
    sys.exit(len(faults) > 0)


def show(cases: list[tuple[int, dict[str, Any]]], rows: dict[int, dict[str, Any]]) -> None:
    print("| case | kind | elements, step [us] | peak, OpenSees / reference | peak, beam / OpenSees | OpenSees [ms] | beam, same mesh and step [ms] | ratio | beam, automatic [ms] | ratio |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for index, case in cases:
        row = rows[index]
        print(
            f"| {case['name']} | {kind(case)} | {len(case['heights']) - 1}, {1e6 * case['step']:.0f} | {row['peak'] / case['peak']:.4f} "
            f"| {row['same peak'] / row['peak']:.4f} | {row['opensees']:.0f} | {row['same']:.1f} | {row['opensees'] / row['same']:.1f} "
            f"| {row['automatic']:.1f} | {row['opensees'] / row['automatic']:.1f} |"
        )
    plane = {"plane, rigid", "plane, soft"}
    groups = {name: {name} for name in ("plane, rigid", "plane, soft")} | {"plane": plane, "space at 45 degrees": {"space at 45 degrees"}}
    print("\n| mean of | cases | OpenSees [ms] | beam, same mesh and step [ms] | ratio | beam, automatic [ms] | ratio | largest, automatic [ms] | targets |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name, kinds in groups.items():
        of_group = [rows[index] for index, case in cases if kind(case) in kinds]
        if not of_group:
            continue
        opensees, same, automatic = (sum(row[key] for row in of_group) / len(of_group) for key in ("opensees", "same", "automatic"))
        verdicts = []
        if name in TARGETS:
            verdicts.append(f"{TARGETS[name]:.0f} ms: {'met' if automatic <= TARGETS[name] else 'MISSED'}")
        if kinds <= plane:
            ratio = opensees / same
            verdicts.append(f"ratio of {TARGET_RATIO:.0f} on the same mesh: {'met' if ratio >= TARGET_RATIO else 'MISSED'}")
        print(
            f"| {name} | {len(of_group)} | {opensees:.0f} | {same:.1f} | {opensees / same:.1f} | {automatic:.1f} "
            f"| {opensees / automatic:.1f} | {max(row['automatic'] for row in of_group):.1f} | {'; '.join(verdicts)} |"
        )


if __name__ == "__main__":
    main()

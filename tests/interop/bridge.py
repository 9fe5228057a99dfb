#!/usr/bin/env python3
"""Tests two sites on loopback: a twin in one DDS domain, its peers in another, and between them the real bridge over TCP.

    bridge.py COLUMN_TWIN

COLUMN_TWIN is the program. The router and both bridges run with the configurations of config/zenoh/. At the far site, rclpy (Fast
DDS) watches the twin and strikes it, and Cyclone DDS calls services as rmw_cyclonedds does, which is the only mapping of services
that the bridge knows. Then the twin's bridge is killed in the middle of an impact and started again. Prints a table of what the
bridge adds to the time of an answer. Exit code 1 with what went wrong. It waits for conditions and never sleeps.
"""

import math
import os
import re
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
CONFIG = HERE.parents[1] / "config/zenoh"
LOOPBACK = '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo"/></Interfaces></General></Domain></CycloneDDS>'
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"

import rclpy  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy  # noqa: E402

from column_twin_msgs.msg import ColumnState, ImpactEvent, ImpactReport, TwinStatus  # noqa: E402
from column_twin_msgs.srv import PredictImpact  # noqa: E402
from cyclone_service import ServiceCaller  # noqa: E402

# Discovery through two bridges on a loaded machine takes seconds; a bridge repeats lost queries after five.
PATIENCE = 60.0
LIGHT_IMPACTS = 20
# How often an event is sent again after the restart of a bridge, and how long its sender waits for a forecast [s].
ATTEMPTS = 12
ANSWER = 5.0
LIGHT = {"mass": 10.0, "velocity": 0.5, "gap": 0.0}
HEAVY = {"mass": 1500.0, "velocity": 10.0, "gap": 0.0}
# The vehicle approaches for one second and a half, in which a bridge can be killed.
APPROACHING = {"mass": 1500.0, "velocity": 2.0, "gap": 3.0}
# Deep enough for all that comes while the other site is spun.
RELIABLE = QoSProfile(depth=4000, reliability=ReliabilityPolicy.RELIABLE)
LATCHED = QoSProfile(depth=200, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
MAX_DOMAIN = 101
# The damage of the heavy impact, the parameter that is rejected, and a system that grants no real-time priority, or is busy.
EXPECTED_WARNING = re.compile(r"impact \"(interrupted|afterwards)\": [A-Z]+: |a change of parameters by parameter service was rejected: top.load|"
                              r"SCHED_FIFO|lock.*memory|skipped \d+ periods")


class Fault(Exception):
    """What went wrong, for the user."""


def check(what, found, expected):
    if found != expected:
        raise Fault(f"{what}: expected {expected!r}, found {found!r}")


class Process:
    """A program with its output, which ends with this one."""

    running = []

    def __init__(self, name, line, ready, folder, **environment):
        self.name, self.lines, self.ready = name, [], threading.Event()
        self.process = subprocess.Popen(line, cwd=folder, env={**os.environ, **environment}, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True, errors="replace")
        Process.running.append(self)
        self.reading = threading.Thread(target=self.read, args=[ready])
        self.reading.start()
        if not self.ready.wait(PATIENCE):
            raise Fault(f"{name} is not ready after {PATIENCE} s: {''.join(self.lines)}")

    def read(self, ready):
        for text in self.process.stdout:
            self.lines.append(text)
            if ready in text:
                self.ready.set()

    def end(self, number):
        """Ends it with a signal; returns its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        try:
            code = self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = self.process.wait()
        self.reading.join()
        if self in Process.running:
            Process.running.remove(self)
        return code


class Site:
    """rclpy in one domain."""

    def __init__(self, domain, name):
        self.context = rclpy.Context()
        self.context.init(domain_id=domain)
        self.node = rclpy.create_node(name, context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.seen = {}
        self.events = self.node.create_publisher(ImpactEvent, "impact_event", RELIABLE)
        for name, message, qos in [("column_state", ColumnState, RELIABLE), ("impact_forecast", ImpactReport, LATCHED),
                                   ("impact_report", ImpactReport, LATCHED), ("twin_status", TwinStatus, LATCHED)]:
            self.subscribe(name, message, qos)

    def subscribe(self, name, message, qos, key=None):
        seen = self.seen.setdefault(key or name, [])
        self.node.create_subscription(message, name, lambda it: seen.append((time.monotonic(), it)), qos)

    def until(self, what, condition):
        deadline = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > deadline:
                raise Fault(f"timeout while waiting for {what}; seen: { {name: len(them) for name, them in self.seen.items()} }")
            self.executor.spin_once(timeout_sec=0.1)

    def of(self, name, event_id):
        return [it for it in self.seen[name] if it[1].event_id == event_id]

    def event(self, event_id, mass, velocity, gap):
        event = ImpactEvent(column_id="column", event_id=event_id, mass=mass, velocity=velocity, gap=gap, restitution=math.nan,
                            height=math.nan, direction=math.nan)
        event.header.stamp.sec, event.header.stamp.nanosec = divmod(time.time_ns(), 10**9)
        return event

    def strike(self, event_id, **impact):
        """Sends an event and waits for its report; returns the time until its forecast came [s]."""
        sent = time.monotonic()
        self.events.publish(self.event(event_id, **impact))
        self.until(f"the forecast of {event_id}", lambda: self.of("impact_forecast", event_id))
        self.until(f"the report of {event_id}", lambda: self.of("impact_report", event_id))
        return self.of("impact_forecast", event_id)[0][0] - sent

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.shutdown()


def fresh_domains(count):
    """Domains that nobody uses, with the sockets that reserve them, as crates/ros_node/src/fresh_domain.rs does."""
    taken = []
    for step in range(MAX_DOMAIN):
        domain = 1 + (os.getpid() + step) % MAX_DOMAIN
        token = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            token.bind(("127.0.0.1", 7400 + 250 * domain + 249))
        except OSError:
            token.close()
            continue
        taken.append((domain, token))
        if len(taken) == count:
            return taken
    raise Fault(f"expected {count} free domains of {MAX_DOMAIN}, found {len(taken)}")


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Sites:
    """The processes of both sites."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder
        built = subprocess.run([HERE / "bridge_program.sh"], stdout=subprocess.PIPE, text=True, check=True)
        self.bridge_program = built.stdout.strip()
        (self.near_domain, self.near_token), (self.far_domain, self.far_token) = fresh_domains(2)
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.router = Process("the router", [self.bridge_program, "-c", CONFIG / "router.json5", "-l", self.endpoint],
                              "a router only", folder)
        self.twin = Process("the twin", [program, "run", "--ros-args", "-p", "record.mode:=always", "-p", "record.directory:=recordings",
                             "-p", "state.directory:=state"],
                            "is ready in domain", folder, ROS_DOMAIN_ID=str(self.near_domain))

    def bridge(self, domain):
        config = "site.json5" if domain == self.near_domain else "control_room.json5"
        return Process("a bridge", [self.bridge_program, "-c", CONFIG / config, "-e", self.endpoint, "-d", str(domain)],
                       "with the bridge to DDS", self.folder, ROS_DISTRO="jazzy", CYCLONEDDS_URI=LOOPBACK)


def wait_for_twin(site, what):
    """Until the site has the twin's status, and the twin's subscription is known to it."""
    started = time.monotonic()
    site.until(f"a status {what}", lambda: site.seen["twin_status"])
    first = site.seen["twin_status"][0][0] - started
    site.until(f"a subscription of events {what}", lambda: site.events.get_subscription_count() > 0)
    return first


def streams(near, far):
    """Status, event, forecast, states and report; returns the first status' delay and the table's rows."""
    direct = wait_for_twin(near, "without a bridge")
    across = wait_for_twin(far, "across the bridge")
    rows = [("first status after the start of a subscriber", [direct], [across])]
    near_times = [near.strike(f"near-{number}", **LIGHT) for number in range(LIGHT_IMPACTS)]
    far_times = [far.strike(f"far-{number}", **LIGHT) for number in range(LIGHT_IMPACTS)]
    rows.append((f"forecast after its event, {LIGHT_IMPACTS} events", near_times, far_times))
    one = "far-0"
    for site in [near, far]:
        site.until(f"the last state of {one}", lambda: any(it.phase == ColumnState.REST for _, it in site.of("column_state", one)))
    # As text, in which NaN equals NaN.
    near_states, far_states = [[str(it) for _, it in site.of("column_state", one)] for site in [near, far]]
    check(f"number of states of {one}", len(far_states), len(near_states))
    check(f"states of {one} that differ", [it for it in zip(near_states, far_states) if it[0] != it[1]], [])
    print(f"across the bridge: {len(far.of('column_state', one))} states of {one} are equal")
    return rows


def services(sites, near, far):
    """Prediction and parameters; the table's rows."""
    predict = near.node.create_client(PredictImpact, "column_twin/predict")
    near.until("the service predict", predict.service_is_ready)
    request = PredictImpact.Request(restitution=math.nan, height=math.nan, direction=math.nan, **HEAVY)

    def direct():
        started = time.monotonic()
        answer = predict.call_async(request)
        near.until("a prediction", answer.done)
        return time.monotonic() - started, answer.result()

    with ServiceCaller(sites.far_domain, PATIENCE) as caller:
        far_times, near_times = [], []
        for _ in range(LIGHT_IMPACTS):
            took, expected = direct()
            near_times.append(took)
            started = time.monotonic()
            answer = caller.predict(**HEAVY)
            far_times.append(time.monotonic() - started)
            check("prediction", (answer.success, answer.message, answer.report_max_v1), (True, "", expected.report.max_v1))
        rejected = caller.predict(**{**HEAVY, "mass": 0.0})
        check("prediction without a mass", (rejected.success, rejected.rejection_code),
              (False, TwinStatus.REJECTED_IMPACT_OUT_OF_RANGE))
        check("parameters", caller.get_parameters(["section.name", "top.load", "no.such"]), ["HEB220", 5e5, None])
        check("a parameter that can be set", caller.set_double("event.max_age", 7.5), (True, ""))
        check("its value", caller.get_parameters(["event.max_age"]), [7.5])
        successful, reason = caller.set_double("top.load", -1.0)
        check("a parameter that cannot be set", (successful, "top.load" in reason), (False, True))
    # Both mappings at once: the client on Fast DDS got its own answers all the time.
    took, after = direct()
    check("prediction afterwards", after.report.max_v1, expected.report.max_v1)
    print(f"services: {LIGHT_IMPACTS} predictions on Cyclone DDS across the bridge and on Fast DDS beside the twin are equal")
    return [(f"prediction by a service, {LIGHT_IMPACTS} calls", near_times, far_times)]


def interruption(sites, bridge, near, far):
    """The twin's bridge is killed in the middle of an impact and started again; returns the new bridge and the table's rows."""
    event_id = "interrupted"
    far.events.publish(far.event(event_id, **APPROACHING))
    far.until("the first hundred states", lambda: len(far.of("column_state", event_id)) >= 100)
    bridge.end(signal.SIGKILL)
    near.until("the report beside the twin", lambda: near.of("impact_report", event_id))
    near.until("the last state beside the twin", lambda: any(it.phase == ColumnState.REST for _, it in near.of("column_state", event_id)))
    states = len(near.of("column_state", event_id))
    before = len(far.of("column_state", event_id))
    if not 0 < before < states or far.of("impact_report", event_id):
        raise Fault(f"the bridge was not killed in the middle: {before} of {states} states had passed")
    print(f"killed: {before} of {states} states had passed")
    status = near.seen["twin_status"][-1][1]
    started = time.monotonic()
    bridge = sites.bridge(sites.near_domain)
    # Those who were there before, and one who comes now.
    far.subscribe("twin_status", TwinStatus, LATCHED, "late_status")
    far.subscribe("impact_report", ImpactReport, LATCHED, "late_report")
    accepted = status.events_accepted
    for name in ["twin_status", "late_status"]:
        far.until(f"the latest status in {name}",
                  lambda: any(it.event_id == event_id and it.events_accepted == accepted and it.phase in (TwinStatus.IDLE, TwinStatus.REST)
                              for _, it in far.seen[name]))
    for name in ["impact_report", "late_report"]:
        far.until(f"the report in {name}", lambda: far.of(name, event_id))
        # Without or with the range of its verdict, which may come later.
        beside = [str(it) for _, it in near.of("impact_report", event_id)]
        check(f"the report in {name} is one of those beside the twin", str(far.of(name, event_id)[0][1]) in beside, True)
    back = far.of("impact_report", event_id)[0][0] - started
    # An event that is sent before the route stands again is lost: the sender sends it again, as docs/sites.md says.
    event = far.event("afterwards", **LIGHT)
    for _ in range(ATTEMPTS):
        far.events.publish(event)
        deadline = time.monotonic() + ANSWER
        far.until("an answer", lambda: far.of("impact_forecast", "afterwards") or time.monotonic() > deadline)
        if far.of("impact_forecast", "afterwards"):
            break
        event.header.stamp = far.event("", **LIGHT).header.stamp
    far.until("the report of afterwards", lambda: far.of("impact_report", "afterwards"))
    near.until("the same beside the twin", lambda: near.of("impact_report", "afterwards"))
    check("events rejected", near.seen["twin_status"][-1][1].events_rejected, 0)
    return bridge, [("report after the restart of a killed bridge", [], [back])]


def recording(sites):
    """The twin says nothing of the bridge's end, and its recording is complete."""
    check("exit code of the twin", sites.twin.end(signal.SIGTERM), 0)
    alarming = [it for it in sites.twin.lines if re.search(r"^\[(WARN|ERROR|FATAL)\]", it) and not EXPECTED_WARNING.search(it)]
    check("warnings and errors of the twin", alarming, [])
    recordings = sorted(Path(sites.folder, "recordings").iterdir())
    check("number of recordings", len(recordings), 1)
    verified = subprocess.run([sites.program, "verify", *recordings], cwd=sites.folder, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
    check(f"exit code of verify, {verified.stdout}", verified.returncode, 0)
    impacts = 2 * LIGHT_IMPACTS + 2
    # A report comes once more if the range of its verdict is known after the response.
    for topic, most in [("impact_event", impacts), ("impact_report", 2 * impacts)]:
        found = re.search(rf"^ *{topic} +(\d+) +(\d+) +0 +0 ", verified.stdout, re.MULTILINE)
        recorded, compared = map(int, found.groups()) if found else (0, 0)
        if not impacts <= recorded <= most or compared != recorded:
            raise Fault(f"expected {impacts} to {most} messages of {topic}, all of them compared, found: {verified.stdout}")
    print(f"the recording contains all {impacts} impacts and is verified")


def table(rows):
    milliseconds = lambda times: f"{1e3 * statistics.median(times):8.1f} {1e3 * max(times):8.1f}" if times else f"{'-':>8} {'-':>8}"
    print(f"\n{'times in ms, load ' + '%.1f' % os.getloadavg()[0]:52} | {'beside the twin':>17} | {'across the bridge':>17}")
    print(f"{'':52} | {'median':>8} {'max':>8} | {'median':>8} {'max':>8}")
    for name, direct, across in rows:
        print(f"{name:52} | {milliseconds(direct)} | {milliseconds(across)}")


def test(program, folder):
    sites = Sites(program, folder)
    bridge, far_bridge = sites.bridge(sites.near_domain), sites.bridge(sites.far_domain)
    near, far = Site(sites.near_domain, "near_operator"), Site(sites.far_domain, "far_operator")
    try:
        rows = streams(near, far)
        rows += services(sites, near, far)
        bridge, more = interruption(sites, bridge, near, far)
        rows += more
        recording(sites)
        for name, one in [("near bridge", bridge), ("far bridge", far_bridge), ("router", sites.router)]:
            check(f"exit code of the {name}", one.end(signal.SIGTERM), 0)
        table(rows)
    finally:
        near.close()
        far.close()


def main():
    program = str(Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as folder:
        try:
            test(program, folder)
        except Fault as fault:
            print(f"fault: {fault}", file=sys.stderr)
            for process in list(Process.running):
                print(f"--- the end of the output of {process.name}:\n{''.join(process.lines[-15:])}", file=sys.stderr)
            return 1
        finally:
            for process in list(Process.running):
                process.end(signal.SIGKILL)
    return 0


if __name__ == "__main__":
    sys.exit(main())

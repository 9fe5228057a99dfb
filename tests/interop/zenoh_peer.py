#!/usr/bin/env python3
"""Tests a twin over Zenoh against a peer of another make: the Zenoh library of Python, with keys, tokens and attachments as rmw_zenoh
has them, and rosbags for CDR and type hashes.

    zenoh_peer.py COLUMN_TWIN [--router PROGRAM] [--ros FOLDER]

COLUMN_TWIN is the program, built with the feature `zenoh`. PROGRAM is a router with the options of zenohd, such as the one of
packaging/bridge; without it, the router is a session of this process. FOLDER is the environment of environment.sh, with whose type
hashes, made by rosidl, those of the twin are compared. Everything listens and connects on 127.0.0.1, without scouting. Exit code 1
with what went wrong. It waits for conditions and never sleeps.
"""

import argparse

import json
import os
import signal
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from pathlib import Path

import numpy
import xxhash
import zenoh
import zenoh.ext
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

REPOSITORY = Path(__file__).resolve().parents[2]
PATIENCE = 60.0
DOMAIN = 57
NAMESPACE = "/garage"
LIGHT = {"mass": 10.0, "velocity": 0.5, "gap": 0.0}
HEAVY = {"mass": 1500.0, "velocity": 10.0, "gap": 0.0}
FLOOD = 20_000
# Requests and responses of the services of every node, whose definitions are not in the repository.
SERVICES = {
    "rcl_interfaces/GetParameters": "string[] names\n---\nrcl_interfaces/ParameterValue[] values\n",
    "rcl_interfaces/SetParameters": "rcl_interfaces/Parameter[] parameters\n---\nrcl_interfaces/SetParametersResult[] results\n",
    "rcl_interfaces/ListParameters": "string[] prefixes\nuint64 depth\n---\nrcl_interfaces/ListParametersResult result\n",
    "type_description_interfaces/GetTypeDescription":
        "string type_name\nstring type_hash\nbool include_type_sources\n---\nbool successful\nstring failure_reason\n"
        "type_description_interfaces/TypeDescription type_description\ntype_description_interfaces/TypeSource[] type_sources\n"
        "type_description_interfaces/KeyValue[] extra_information\n",
    # An empty request has a hidden byte.
    "std_srvs/Trigger": "uint8 structure_needs_at_least_one_member\n---\nbool success\nstring message\n",
}
TOPICS = {
    "column_state": "column_twin_msgs/msg/ColumnState", "hinge_forces": "column_twin_msgs/msg/HingeForces",
    "impact_forecast": "column_twin_msgs/msg/ImpactReport", "impact_report": "column_twin_msgs/msg/ImpactReport",
    "twin_status": "column_twin_msgs/msg/TwinStatus", "joint_states": "sensor_msgs/msg/JointState",
    "markers": "visualization_msgs/msg/MarkerArray", "impact_estimate": "column_twin_msgs/msg/ImpactEstimate",
}
CONFIG = [word for name in ("heb220_s355", "sensors_industrial") for word in ("--config", str(REPOSITORY / f"config/{name}.yaml"))]
OF_FLEET = {"fleet_status": "column_twin_msgs/msg/FleetStatus"}
LATCHED = ["twin_status", "impact_forecast", "impact_report", "markers"]


class Fault(Exception):
    """What went wrong, for the user."""


def check(what, found, expected):
    if found != expected:
        raise Fault(f"{what}: expected {expected!r}, found {found!r}")


def wait_for(what, condition, patience=PATIENCE):
    """The first true value of the condition."""
    until = time.monotonic() + patience
    with CHANGED:
        while True:
            if value := condition():
                return value
            if time.monotonic() > until:
                raise Fault(f"{what}: not within {patience} s")
            CHANGED.wait(0.1)


CHANGED = threading.Condition()


def tell():
    with CHANGED:
        CHANGED.notify_all()


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def configuration(mode, listen, connect):
    return {
        "mode": mode, "listen": {"endpoints": listen}, "connect": {"endpoints": connect},
        "scouting": {"multicast": {"enabled": False}},
        "timestamping": {"enabled": {"router": True, "peer": True, "client": True}},
    }


def opened(settings):
    return zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))


class Program:
    """The program with what it says, which ends with this one."""

    running = []

    def __init__(self, line, folder, **environment):
        # A session of this machine only, whatever the caller has set.
        clean = {name: value for name, value in os.environ.items() if not name.startswith(("ROS_", "RMW_", "ZENOH_", "RUST_LOG"))}
        self.lines = []
        self.process = subprocess.Popen(line, cwd=folder, env={**clean, "ROS_DOMAIN_ID": str(DOMAIN), **environment},
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
        Program.running.append(self)
        self.reading = threading.Thread(target=self.read)
        self.reading.start()

    def read(self):
        for text in self.process.stdout:
            self.lines.append(text.rstrip())
            tell()

    def said(self, text):
        return sum(text in line for line in list(self.lines))

    def wait_to_say(self, text, times=1):
        try:
            wait_for(f"{text!r} of the program", lambda: self.said(text) >= times or self.process.poll() is not None)
            if self.process.poll() is not None:
                self.reading.join()
            if self.said(text) < times:
                raise Fault(f"the program ended without {text!r}")
        except Fault as fault:
            raise Fault("\n".join([str(fault), *self.lines[-30:]])) from None

    def end(self, number=signal.SIGINT):
        if self.process.poll() is None:
            self.process.send_signal(number)
        return self.ended()

    def ended(self):
        """The exit code, once it has ended by itself."""
        try:
            code = self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = self.process.wait()
        self.reading.join()
        if self in Program.running:
            Program.running.remove(self)
        return code


class Types:
    """CDR and hashes of rosbags, from the definitions in the repository, for the twin of a column in a namespace."""

    def __init__(self, namespace, column):
        self.namespace, self.node, self.column = namespace, f"{namespace}/column_twin", column
        self.store = get_typestore(Stores.ROS2_JAZZY)
        found = {}
        for file in sorted((REPOSITORY / "msg").glob("*.msg")):
            found.update(get_types_from_msg(file.read_text(), f"column_twin_msgs/msg/{file.stem}"))
        self.store.register(found)
        predict = Path(REPOSITORY, "srv/PredictImpact.srv").read_text()
        for name, text in {**SERVICES, "column_twin_msgs/PredictImpact": predict}.items():
            package, bare = name.split("/")
            # rosbags knows messages only, as which the halves of a service are written.
            for half, definition in zip(("Request", "Response"), f"\n{text}".split("\n---\n")):
                self.store.register(get_types_from_msg(definition, f"{package}/msg/{bare}_{half}"))

    def make(self, name, /, **fields):
        return self.store.types[name](**fields)

    def key(self, name, type_name):
        package, _, bare = type_name.split("/")
        return f"{DOMAIN}{self.namespace}/{name}/{package}::msg::dds_::{bare}_/{self.store.hash_rihs01(type_name)}"

    def decode(self, payload, type_name):
        return self.store.deserialize_cdr(payload, type_name)

    def event(self, event_id, mass, velocity, gap, column_id=None):
        nan, now = float("nan"), time.time_ns()
        stamp = self.make("builtin_interfaces/msg/Time", sec=now // 10**9, nanosec=now % 10**9)
        event = self.make(
            "column_twin_msgs/msg/ImpactEvent", header=self.make("std_msgs/msg/Header", stamp=stamp, frame_id=""), column_id=column_id or self.column,
            event_id=event_id, vehicle="", mass=mass, velocity=velocity, gap=gap, restitution=nan, height=nan, direction=nan)
        return bytes(self.store.serialize_cdr(event, "column_twin_msgs/msg/ImpactEvent"))


class Attachment:
    """Number, time [ns] and identifier of a message."""

    def __init__(self, attachment):
        data = bytes(attachment)
        check("bytes of the attachment", len(data), 33)
        self.number, self.time, length = struct.unpack("<qqB", data[:17])
        check("length of the identifier", length, 16)
        self.gid = data[17:]


def attached(number, gid):
    return struct.pack("<qqB", number, time.time_ns(), 16) + gid


def gid_of(token):
    """As rmw_zenoh computes it: both halves in little endian, the low one first."""
    return xxhash.xxh3_128(token.encode()).intdigest().to_bytes(16, "little")


class Peer:
    """A session with the endpoints of a peer."""

    def __init__(self, types, settings):
        self.types = types
        self.session = opened(settings)
        self.seen, self.tokens, self.kept = {}, set(), []
        self.watch = self.session.liveliness().declare_subscriber(f"@ros2_lv/{DOMAIN}/**", self.take_token, history=True)
        token = self.token_of(1, "MP", "impact_event", "column_twin_msgs/msg/ImpactEvent", "::,100:,:,:,,")
        self.gid, self.number, self.calls = gid_of(token), 0, {}
        self.events = self.session.declare_publisher(types.key("impact_event", "column_twin_msgs/msg/ImpactEvent"))
        self.token = self.session.liveliness().declare_token(token)

    def token_of(self, number, kind, name, type_name, qos):
        """The liveliness token by which a writer (MP) or a reader (MS) is seen."""
        topic, (package, _, bare) = f"{self.types.namespace}/{name}".replace("/", "%"), type_name.split("/")
        return f"@ros2_lv/{DOMAIN}/{self.session.zid()}/0/{number}/{kind}/%/%/striker/{topic}/" \
            f"{package}::msg::dds_::{bare}_/{self.types.store.hash_rihs01(type_name)}/{qos}"

    def take_token(self, sample):
        key = str(sample.key_expr)
        if sample.kind == zenoh.SampleKind.PUT:
            self.tokens.add(key)
        else:
            self.tokens.discard(key)
        tell()

    def of_twin(self, kind):
        """The tokens of the twin, by topic or service."""
        found = {}
        for token in list(self.tokens):
            parts = token.split("/")
            if parts[5] == kind and parts[7:9] == [self.types.namespace.replace("/", "%") or "%", "column_twin"]:
                found[parts[9].replace("%", "/") if len(parts) > 9 else ""] = (token, *parts[10:])
        return found

    def subscribe(self, name):
        type_name = {**TOPICS, **OF_FLEET}[name]
        seen = self.seen.setdefault(name, [])

        def take(sample):
            arrived = time.time_ns()
            attachment = Attachment(sample.attachment)
            attachment.arrived = arrived
            seen.append((attachment, self.types.decode(bytes(sample.payload), type_name)))
            tell()
        key = self.types.key(name, type_name)
        if name in LATCHED:
            history = zenoh.ext.HistoryConfig(detect_late_publishers=True)
            self.kept.append(zenoh.ext.declare_advanced_subscriber(self.session, key, take, history=history))
        else:
            self.kept.append(self.session.declare_subscriber(key, take))
        qos = ":1:,1:,:,:,," if name in LATCHED else "::,100:,:,:,,"
        token = self.token_of(2 + len(self.kept), "MS", name, type_name, qos)
        self.kept.append(self.session.liveliness().declare_token(token))

    def strike(self, event_id, impact):
        self.number += 1
        event = self.types.event(event_id, **impact)
        self.events.put(event, attachment=attached(self.number, self.gid))

    def message(self, name, event_id):
        """The first message about an event."""
        return wait_for(f"{name} of {event_id}", lambda: next((it for _, it in list(self.seen[name]) if it.event_id == event_id), None))

    def request(self, service, type_of_service, /, **fields):
        """The response of a service."""
        package, bare = type_of_service.split("/")
        name = f"{self.types.node}/{service}"
        dds_type, hash_, _ = self.of_twin("SS")[name][1:]
        check(f"type of {service}", dds_type, f"{package}::srv::dds_::{bare}_")
        request, response = (f"{package}/msg/{bare}_{half}" for half in ("Request", "Response"))
        payload = bytes(self.types.store.serialize_cdr(self.types.make(request, **fields), request))
        reply = self.call(f"{DOMAIN}{name}/{dds_type}/{hash_}", payload)
        if reply is None:
            raise Fault(f"{service} does not reply")
        return self.types.decode(reply, response)

    def call(self, key, payload):
        """The reply of a service, or None."""
        number = self.calls[key] = self.calls.get(key, 0) + 1
        replies = self.session.get(key, payload=payload, attachment=attached(number, self.gid),
                                   target=zenoh.QueryTarget.ALL_COMPLETE, consolidation=zenoh.ConsolidationMode.NONE, timeout=PATIENCE)
        for reply in replies:
            if reply.ok is not None:
                answer = Attachment(reply.ok.attachment)
                check("number of the reply", answer.number, number)
                check("identifier of the reply", answer.gid, self.gid)
                return bytes(reply.ok.payload)
        return None

    def close(self):
        self.session.close()


def published_hashes(folder):
    """The type hashes that rosidl wrote, by the names of the types in DDS."""
    found = {}
    for file in Path(folder, "share").glob("*/*/*.json"):
        if file.parent.name in ("msg", "srv"):
            for it in json.loads(file.read_text()).get("type_hashes", []):
                package, kind, bare = it["type_name"].split("/")
                found[f"{package}::{kind}::dds_::{bare}_"] = it["hash_string"]
    return found


def check_graph(peer, types, ros):
    """Node, topics and services are announced with the right types and hashes."""
    wait_for("the token of the node", lambda: peer.of_twin("NN"))
    services = ["reset", "predict", "get_parameters", "set_parameters", "list_parameters", "describe_parameters",
                "get_parameter_types", "set_parameters_atomically", "get_type_description", "correct_damage", "confirm_estimate"]
    wait_for("the services", lambda: {f"{types.node}/{it}" for it in services} <= set(peer.of_twin("SS")))
    wait_for("the inputs", lambda: {f"{NAMESPACE}/impact_event", f"{NAMESPACE}/column_parameters"} <= set(peer.of_twin("MS")))
    outputs = wait_for("the outputs", lambda: (found := peer.of_twin("MP")) if {
        f"{NAMESPACE}/{it}" for it in TOPICS} <= set(peer.of_twin("MP")) else None)
    for name, type_name in TOPICS.items():
        _, dds_type, found, qos = outputs[f"{NAMESPACE}/{name}"]
        package, _, bare = type_name.split("/")
        check(f"type of {name}", dds_type, f"{package}::msg::dds_::{bare}_")
        check(f"hash of {name}", found, types.store.hash_rihs01(type_name))
    check("quality of service of twin_status", outputs[f"{NAMESPACE}/twin_status"][3], ":1:,1:,:,:,,")
    check("quality of service of column_state", outputs[f"{NAMESPACE}/column_state"][3], "::,1000:,:,:,,")
    print(f"graph: {len(outputs)} publishers, {len(peer.of_twin('SS'))} services, hashes as rosbags computes them")
    if ros:
        published = published_hashes(ros)
        announced = {it[1]: it[2] for kind in ("MP", "MS", "SS") for it in peer.of_twin(kind).values()}
        check("type hashes", announced, {dds_type: published.get(dds_type) for dds_type in announced})
        print(f"type hashes: those of {len(announced)} types as rosidl wrote them")
    return outputs


def milliseconds(nanoseconds):
    """Median, 99th percentile and maximum."""
    ordered = sorted(nanoseconds)
    last = len(ordered) - 1
    return "/".join(f"{1e-6 * it:.2f}" for it in (statistics.median(ordered), ordered[round(0.99 * last)], ordered[-1])) + " ms"


def stream_arrives(peer, event_id):
    """Whether the states of a light impact arrive. The twin sends them to no one before the router, or the new connection to the twin
    itself, has passed the subscriptions on."""
    peer.strike(event_id, LIGHT)
    streams = [peer.seen[name] for name in ("column_state", "hinge_forces")]
    try:
        wait_for(f"the states of {event_id}", lambda: all(
            any(it.event_id == event_id for _, it in list(seen)) for seen in streams), 2.0)
    except Fault:
        return False
    peer.message("impact_report", event_id)
    return True


def await_stream(peer, event_id):
    """Sends light impacts until the states of one arrive."""
    if not any(stream_arrives(peer, f"{event_id}_{number}") for number in range(int(PATIENCE / 2.0))):
        raise Fault("the states of no light impact arrive")


def check_impact(peer, event_id, outputs):
    """An event is answered, and nothing of the response is lost."""
    await_stream(peer, f"before_{event_id}")
    begun = time.time_ns()
    peer.strike(event_id, HEAVY)
    forecast = peer.message("impact_forecast", event_id)
    answered = next(attachment for attachment, it in peer.seen["impact_forecast"] if it.event_id == event_id).arrived - begun
    report = peer.message("impact_report", event_id)
    check("outcome", report.outcome, forecast.outcome)
    for name in ("column_state", "hinge_forces"):
        states = [(attachment, it) for attachment, it in list(peer.seen[name]) if it.event_id == event_id]
        if len(states) < 50:
            raise Fault(f"only {len(states)} of {name} arrived")
        numbers = [attachment.number for attachment, _ in states]
        check(f"numbers of {name}", numbers, list(range(numbers[0], numbers[0] + len(numbers))))
        check(f"identifier of {name}", states[0][0].gid, gid_of(outputs[f"{NAMESPACE}/{name}"][0]))
        stamps = [it.header.stamp.sec * 10**9 + it.header.stamp.nanosec for _, it in states]
        # In the last period the column came to rest.
        periods = {round(1e-3 * (after - before)) for before, after in zip(stamps[:-1], stamps[1:-1])}
        check(f"periods of {name} [us]", periods, {1000})
        lasted = 1e-9 * (states[-1][0].arrived - states[0][0].arrived)
        print(f"{name}: {len(states)} without a gap in {lasted:.2f} s, {(len(states) - 1) / lasted:.0f} Hz; from the writer to this "
              f"program {milliseconds([it.arrived - it.time for it, _ in states])} (median, 99 %, longest)")
    print(f"forecast: {1e-6 * answered:.1f} ms after the event")


def check_services(peer, types):
    reply = peer.request("reset", "std_srvs/Trigger", structure_needs_at_least_one_member=0)
    check("success of reset", reply.success, True)
    reply = peer.request("get_parameters", "rcl_interfaces/GetParameters", names=["column_id", "publish_rate"])
    check("types of the parameters", [it.type for it in reply.values], [4, 3])
    check("publish_rate", reply.values[1].double_value, 1000.0)
    reply = peer.request("list_parameters", "rcl_interfaces/ListParameters", prefixes=[], depth=0)
    if "publish_rate" not in reply.result.names:
        raise Fault(f"list_parameters does not name publish_rate: {reply.result.names}")

    def load():
        return peer.request("get_parameters", "rcl_interfaces/GetParameters", names=["top.load"]).values[0].double_value

    def set_load(load):
        none = numpy.array([])
        value = types.make("rcl_interfaces/msg/ParameterValue", type=3, bool_value=False, integer_value=0, double_value=load,
                           string_value="", byte_array_value=none, bool_array_value=none, integer_array_value=none,
                           double_array_value=none, string_array_value=[])
        parameter = types.make("rcl_interfaces/msg/Parameter", name="top.load", value=value)
        return peer.request("set_parameters", "rcl_interfaces/SetParameters", parameters=[parameter]).results[0]

    before = load()
    check("top.load that is valid", set_load(0.5 * before).successful, True)
    rejected = set_load(-1.0e5)
    check("top.load that is not", (rejected.successful, "top.load" in rejected.reason), (False, True))
    check("top.load", load(), 0.5 * before)
    check("top.load as before", set_load(before).successful, True)

    nan = float("nan")
    predicted = peer.request("predict", "column_twin_msgs/PredictImpact", column_id="", event_id="what_if", vehicle="", **HEAVY,
                             restitution=nan, height=nan, direction=nan)
    check("success and event of predict", (predicted.success, predicted.report.event_id), (True, "what_if"))
    odd = peer.request("predict", "column_twin_msgs/PredictImpact", column_id="", event_id="odd", vehicle="", mass=-1.0, velocity=nan,
                       gap=nan, restitution=nan, height=nan, direction=nan)
    check("success of a prediction that is none", (odd.success, bool(odd.message)), (False, True))

    name = "column_twin_msgs/msg/ImpactReport"
    described = peer.request("get_type_description", "type_description_interfaces/GetTypeDescription", type_name=name,
                             type_hash=types.store.hash_rihs01(name), include_type_sources=True)
    check("success of get_type_description", described.successful, True)
    check("described type", described.type_description.type_description.type_name, name)
    check("fields", [it.name for it in described.type_description.type_description.fields],
          [field for field, _ in types.store.fielddefs[name][1]])


def check_bad_input(peer, twin):
    """What is malformed is counted and told, and nothing else."""
    before = twin.said("cannot be read")
    event = peer.types.event("odd", **LIGHT)
    peer.events.put(b"no CDR at all", attachment=attached(1, peer.gid))
    peer.events.put(event)
    peer.events.put(event[:-9], attachment=attached(2, peer.gid))
    peer.events.put(b"", attachment=b"\1\2\3")
    peer.events.delete(attachment=attached(3, peer.gid))
    twin.wait_to_say("cannot be read", before + 4)
    # More than the twin takes.
    peer.events.put(bytes(5 << 20), attachment=attached(4, peer.gid))
    twin.wait_to_say("a message of 5242880 bytes on /garage/impact_event was given up")
    for token in [f"@ros2_lv/{DOMAIN}/x/y", f"@ros2_lv/{DOMAIN}/zz/0/1/NN/%/%/odd", f"@ros2_lv/{DOMAIN}/zz/0/1/XX/%/%/odd/%/%/%/%"]:
        peer.session.liveliness().declare_token(token).undeclare()


def check_flood(peer, twin, types, settings):
    """Unreadable messages, and events for another column, as fast as a sender can: the twin counts them, and answers others."""
    before, sender = len(twin.lines), Peer(types, settings)
    other = types.event("flood", **LIGHT, column_id="another")
    begun = time.monotonic()
    for number in range(FLOOD):
        sender.events.put(b"\0\1\0\0nothing", attachment=attached(2 * number + 1, sender.gid))
        sender.events.put(other, attachment=attached(2 * number + 2, sender.gid))
    lasted = time.monotonic() - begun
    peer.strike("after_the_flood", LIGHT)
    peer.message("impact_forecast", "after_the_flood")
    sender.close()
    lines = len(twin.lines) - before
    print(f"flood: {2 * FLOOD} messages in {lasted:.2f} s, {lines} lines in the log, and the next event of another sender is answered")
    if lines > 200:
        raise Fault(f"a flood of {2 * FLOOD} messages makes {lines} lines in the log")


def check_clients(program, folder, environment, peer):
    """The clients of the program find the twin and are answered."""
    names = ["--ros-args", "-r", f"__ns:={NAMESPACE}"]
    watch = Program([program, "watch", "--transport", "zenoh", *names], folder, **environment)
    watch.wait_to_say("watching /garage/column_state")
    impact = Program([program, "impact", "--transport", "zenoh", "--mass", "10", "--velocity", "0.5", "--event", "by_client",
                      "--timeout", "30", *names], folder, **environment)
    impact.wait_to_say("forecast")
    check("exit code of impact", impact.ended(), 0)
    watch.wait_to_say("by_client")
    check("exit code of watch", watch.end(), 0)
    peer.message("impact_report", "by_client")

    readings = Path(folder, "readings.csv")
    heavy = ["--mass", "1500", "--velocity", "10"]
    simulated = Program([program, "simulate", *CONFIG, *heavy, "--readings", str(readings)], folder)
    check("exit code of simulate", simulated.ended(), 0)
    measure = Program([program, "measure", "--transport", "zenoh", str(readings), *CONFIG, *names], folder, **environment)
    check("exit code of measure", measure.ended(), 0)
    wait_for("the estimate", lambda: any(it.is_final for _, it in list(peer.seen["impact_estimate"])))


def check_replay(program, folder, environment, recording, peer):
    """A recording goes to the peer as it was recorded."""
    names = ("column_state", "hinge_forces", "impact_report")
    with Reader(recording) as reader:
        counts = {name: it.msgcount for it in reader.connections if (name := it.topic.rpartition("/")[2]) in names}
    for name in names:
        peer.seen[name].clear()
    replay = Program([program, "replay", str(recording), "--transport", "zenoh", "--rate", "10", "--wait-for-readers", "30"], folder,
                     **environment)
    check("exit code of replay", replay.ended(), 0)
    for name, count in counts.items():
        wait_for(f"{count} of {name} by replay", lambda: len(peer.seen[name]) == count)  # noqa: B023


def check_fleet(program, folder, environment, settings):
    """A fleet has the status of every column, answers events by their column, and serves the topics of a single column to readers."""
    table = Path(folder, "columns.csv")
    table.write_text("namespace,column_id,section.name\n/garage/a1,a1,HEB 220\n/garage/a2,a2,HEB 240\n")
    fleet = Program([program, "fleet", "--transport", "zenoh", "--params-file", str(REPOSITORY / "config/fleet.yaml"), "--columns", str(table),
                     "--ros-args", "-r", f"__ns:={NAMESPACE}", "-p", "state.directory:=''"], folder, **environment)
    fleet.wait_to_say("is ready")
    peer = Peer(Types(NAMESPACE, "a2"), settings)
    for name in ("fleet_status", "column_state", "hinge_forces", "impact_forecast", "impact_report"):
        peer.subscribe(name)
    wait_for("the status of both columns",
             lambda: {"a1", "a2"} <= {it.column_id for _, status in list(peer.seen["fleet_status"]) for it in status.columns})
    reader = Peer(Types(f"{NAMESPACE}/a2", "a2"), settings)
    for name in ("column_state", "twin_status"):
        reader.subscribe(name)
    wait_for("the status of a2 on a topic of its own", lambda: reader.seen["twin_status"])
    await_stream(peer, "of_the_fleet")
    peer.strike("on_a2", HEAVY)
    report = peer.message("impact_report", "on_a2")
    check("the column that was hit", report.column_id, "a2")
    numbers = wait_for("the states on the topic of a2", lambda: [it.header.stamp for _, it in list(reader.seen["column_state"]) if it.event_id == "on_a2"])
    check("exit code of the fleet", fleet.end(), 0)
    shared = sum(it.event_id == "on_a2" for _, it in peer.seen["column_state"])
    print(f"fleet: the status of every column; {shared} states of an impact on the shared topic, {len(numbers)} on the topic of the column so far")
    reader.close()
    peer.close()


def check_late_joiner(types, settings, event_id):
    """Who comes late gets what the twin keeps: its status, and the reports."""
    late = Peer(types, settings)
    for name in ["twin_status", "impact_report", "impact_forecast"]:
        late.subscribe(name)
    wait_for("the kept status", lambda: late.seen["twin_status"])
    late.message("impact_report", event_id)
    late.message("impact_forecast", event_id)
    late.close()


class Router:
    """A router, of this process or a program."""

    def __init__(self, program, settings, folder):
        self.session = self.program = None
        if program:
            file = Path(folder, "router.json5")
            file.write_text(json.dumps(settings))
            self.program = Program([program, "-c", str(file)], folder)
            self.program.wait_to_say("ready")
        else:
            self.session = opened(settings)

    def close(self, number=signal.SIGKILL):
        if self.program:
            self.program.end(number)
        else:
            self.session.close()


def check_configurations(line, folder):
    """What is no configuration is named, and the program ends."""
    files = {"nowhere.json5": None, "text.json5": "no configuration", "other.json5": '{ mode: "twin" }',
             "endpoint.json5": '{ listen: { endpoints: ["tcp/127.0.0.1"] } }'}
    for name, text in files.items():
        file = Path(folder, name)
        if text:
            file.write_text(text)
        odd = Program(line, folder, ZENOH_SESSION_CONFIG_URI=str(file))
        odd.wait_to_say("ZENOH_SESSION_CONFIG_URI")
        check(f"exit code with {name}", odd.ended(), 2)
    print("configurations that are none: named, exit code 2")


def run(program, router_program, ros):
    types, port = Types(NAMESPACE, "heb220_s355"), free_port()
    with tempfile.TemporaryDirectory() as folder:
        session = Path(folder, "session.json5")
        settings = configuration("peer", ["tcp/127.0.0.1:0"], [f"tcp/127.0.0.1:{port}"])
        session.write_text(json.dumps(settings))
        of_router = configuration("router", [f"tcp/127.0.0.1:{port}"], [])
        environment = {"ZENOH_SESSION_CONFIG_URI": str(session)}
        twin_line = [program, "run", "--transport", "zenoh", *CONFIG, "--ros-args", "-r", f"__ns:={NAMESPACE}", "-p", "state.directory:=''",
                     "-p", "record.mode:=always", "-p", f"record.directory:={folder}/recordings"]
        check_configurations(twin_line, folder)

        twin = Program(twin_line, folder, **environment)
        twin.wait_to_say("no Zenoh router is connected")
        twin.wait_to_say("is ready in domain")
        router = Router(router_program, of_router, folder)
        twin.wait_to_say("connected to the Zenoh router")
        print("the twin started without a router and connected to it later")

        peer = Peer(types, settings)
        outputs = check_graph(peer, types, ros)
        for name in TOPICS:
            peer.subscribe(name)
        wait_for("the kept status", lambda: peer.seen["twin_status"])
        check_impact(peer, "first", outputs)
        check_services(peer, types)
        print("services: parameters, predict, get_type_description, reset")
        check_bad_input(peer, twin)
        check_flood(peer, twin, types, settings)
        check_clients(program, folder, environment, peer)
        print("clients: impact, watch, measure")
        check_late_joiner(types, settings, "by_client")
        print("late joiners: status, forecast, report")

        router.close()
        twin.wait_to_say("is lost")
        check_impact(peer, "without_router", outputs)
        router = Router(router_program, of_router, folder)
        twin.wait_to_say("connected to the Zenoh router", 2)
        wait_for("the twin after the loss of the router", lambda: peer.of_twin("NN"))
        check_impact(peer, "afterwards", outputs)
        print("impacts while the router is lost, and after it")

        check("exit code of the twin", twin.end(), 0)
        wait_for("the end of the node", lambda: not peer.of_twin("NN") and not peer.of_twin("MP"))
        recording, = Path(folder, "recordings").iterdir()
        check_replay(program, folder, environment, recording, peer)
        print("clients: replay")

        killed = Program(twin_line, folder, **environment)
        wait_for("the node that will be killed", lambda: peer.of_twin("NN"))
        killed.end(signal.SIGKILL)
        wait_for("the end of the node that was killed", lambda: not peer.of_twin("NN"))
        print("a node that is killed disappears from the graph")
        peer.close()
        check_fleet(program, folder, environment, settings)
        router.close()


def end(test):
    """Runs a test and ends this program with its exit code."""
    code = 1
    try:
        test()
        code = 0
    except Fault as fault:
        for program in Program.running:
            print("\n".join(program.lines[-20:]), file=sys.stderr)
        print(f"FAULT: {fault}", file=sys.stderr)
    except Exception:  # noqa: BLE001
        traceback.print_exc()
    finally:
        for program in list(Program.running):
            program.end(signal.SIGKILL)
    sys.stdout.flush()
    # A session that a fault left open would hold up the end of the interpreter.
    os._exit(code)


def main():
    arguments = argparse.ArgumentParser(usage="zenoh_peer.py COLUMN_TWIN [--router PROGRAM] [--ros FOLDER]")
    arguments.add_argument("program", type=lambda it: str(Path(it).resolve()))
    arguments.add_argument("--router")
    arguments.add_argument("--ros")
    given = arguments.parse_args()
    end(lambda: run(given.program, given.router, given.ros))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Tests a twin over Zenoh against a peer of another make: the Zenoh library of Python, with keys, tokens and attachments as rmw_zenoh
has them, and rosbags for CDR and type hashes.

    zenoh_peer.py COLUMN_TWIN

COLUMN_TWIN is the program, built with the feature `zenoh`. The router is a session of this process. Everything listens and connects
on 127.0.0.1, without scouting. Exit code 1 with what went wrong. It waits for conditions and never sleeps.
"""

import json
import os
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import xxhash
import zenoh
import zenoh.ext
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

REPOSITORY = Path(__file__).resolve().parents[2]
PATIENCE = 60.0
DOMAIN = 57
NODE = "/garage/column_twin"
LIGHT = {"mass": 10.0, "velocity": 0.5, "gap": 0.0}
HEAVY = {"mass": 1500.0, "velocity": 10.0, "gap": 0.0}
# The published hashes of ROS 2 Jazzy, of services, which rosbags does not compute.
SERVICE_HASHES = {
    "rcl_interfaces::srv::dds_::GetParameters_": "RIHS01_bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc",
    "std_srvs::srv::dds_::Trigger_": "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
}
TOPICS = {
    "column_state": "column_twin_msgs/msg/ColumnState", "hinge_forces": "column_twin_msgs/msg/HingeForces",
    "impact_forecast": "column_twin_msgs/msg/ImpactReport", "impact_report": "column_twin_msgs/msg/ImpactReport",
    "twin_status": "column_twin_msgs/msg/TwinStatus", "joint_states": "sensor_msgs/msg/JointState",
    "markers": "visualization_msgs/msg/MarkerArray",
}


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


def opened(*of_configuration):
    return zenoh.open(zenoh.Config.from_json5(json.dumps(configuration(*of_configuration))))


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
            if self.said(text) < times:
                raise Fault(f"the program ended without {text!r}")
        except Fault as fault:
            raise Fault("\n".join([str(fault), *self.lines[-30:]])) from None

    def end(self, number=signal.SIGINT):
        if self.process.poll() is None:
            self.process.send_signal(number)
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
    """CDR and hashes of rosbags, from the definitions in the repository."""

    def __init__(self):
        self.store = get_typestore(Stores.ROS2_JAZZY)
        found = {}
        for file in sorted((REPOSITORY / "msg").glob("*.msg")):
            found.update(get_types_from_msg(file.read_text(), f"column_twin_msgs/msg/{file.stem}"))
        self.store.register(found)

    def key(self, name, type_name):
        package, _, bare = type_name.split("/")
        return f"{DOMAIN}/garage/{name}/{package}::msg::dds_::{bare}_/{self.store.hash_rihs01(type_name)}"

    def decode(self, payload, type_name):
        return self.store.deserialize_cdr(payload, type_name)

    def event(self, event_id, mass, velocity, gap):
        types, nan = self.store.types, float("nan")
        now = time.time_ns()
        stamp = types["builtin_interfaces/msg/Time"](now // 10**9, now % 10**9)
        event = types["column_twin_msgs/msg/ImpactEvent"](
            header=types["std_msgs/msg/Header"](stamp, ""), column_id="", event_id=event_id, vehicle="", mass=mass, velocity=velocity,
            gap=gap, restitution=nan, height=nan, direction=nan)
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

    def __init__(self, types, port):
        self.types = types
        self.session = opened("peer", ["tcp/127.0.0.1:0"], [f"tcp/127.0.0.1:{port}"])
        self.seen, self.tokens, self.kept = {}, set(), []
        self.watch = self.session.liveliness().declare_subscriber(f"@ros2_lv/{DOMAIN}/**", self.take_token, history=True)
        token = f"@ros2_lv/{DOMAIN}/{self.session.zid()}/0/1/MP/%/%/striker/%garage%impact_event/" \
            f"column_twin_msgs::msg::dds_::ImpactEvent_/{types.store.hash_rihs01('column_twin_msgs/msg/ImpactEvent')}/::,100:,:,:,,"
        self.gid, self.number = gid_of(token), 0
        self.events = self.session.declare_publisher(types.key("impact_event", "column_twin_msgs/msg/ImpactEvent"))
        self.token = self.session.liveliness().declare_token(token)

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
            if parts[5] == kind and parts[7:9] == ["%garage", "column_twin"]:
                found[parts[9].replace("%", "/") if len(parts) > 9 else ""] = (token, *parts[10:])
        return found

    def subscribe(self, name, is_latched=False):
        type_name = TOPICS[name]
        seen = self.seen.setdefault(name, [])

        def take(sample):
            seen.append((Attachment(sample.attachment), self.types.decode(bytes(sample.payload), type_name)))
            tell()
        key = self.types.key(name, type_name)
        if is_latched:
            history = zenoh.ext.HistoryConfig(detect_late_publishers=True)
            self.kept.append(zenoh.ext.declare_advanced_subscriber(self.session, key, take, history=history))
        else:
            self.kept.append(self.session.declare_subscriber(key, take))

    def strike(self, event_id, impact):
        self.number += 1
        event = self.types.event(event_id, **impact)
        self.events.put(event, attachment=attached(self.number, self.gid))

    def message(self, name, event_id):
        """The first message about an event."""
        return wait_for(f"{name} of {event_id}", lambda: next((it for _, it in list(self.seen[name]) if it.event_id == event_id), None))

    def call(self, key, request):
        """The reply of a service, or None."""
        self.number += 1
        replies = self.session.get(key, payload=request, attachment=attached(self.number, self.gid),
                                   target=zenoh.QueryTarget.ALL_COMPLETE, consolidation=zenoh.ConsolidationMode.NONE, timeout=PATIENCE)
        for reply in replies:
            if reply.ok is not None:
                answer = Attachment(reply.ok.attachment)
                check("number of the reply", answer.number, self.number)
                check("identifier of the reply", answer.gid, self.gid)
                return bytes(reply.ok.payload)
        return None

    def close(self):
        self.session.close()


def check_graph(peer, types):
    """Node, topics and services are announced with the right types and hashes."""
    wait_for("the token of the node", lambda: peer.of_twin("NN"))
    services = ["reset", "predict", "get_parameters", "set_parameters", "list_parameters", "describe_parameters",
                "get_parameter_types", "set_parameters_atomically", "get_type_description"]
    wait_for("the services", lambda: {f"{NODE}/{it}" for it in services} <= set(peer.of_twin("SS")))
    wait_for("the inputs", lambda: {"/garage/impact_event", "/garage/column_parameters"} <= set(peer.of_twin("MS")))
    outputs = wait_for("the outputs", lambda: (found := peer.of_twin("MP")) if {f"/garage/{it}" for it in TOPICS} <= set(
        peer.of_twin("MP")) else None)
    for name, type_name in TOPICS.items():
        _, dds_type, found, qos = outputs[f"/garage/{name}"]
        package, _, bare = type_name.split("/")
        check(f"type of {name}", dds_type, f"{package}::msg::dds_::{bare}_")
        check(f"hash of {name}", found, types.store.hash_rihs01(type_name))
    check("quality of service of twin_status", outputs["/garage/twin_status"][3], ":1:,1:,:,:,,")
    check("quality of service of column_state", outputs["/garage/column_state"][3], "::,1000:,:,:,,")
    by_type = {dds_type: found for _, dds_type, found, _ in peer.of_twin("SS").values()}
    for dds_type, expected in SERVICE_HASHES.items():
        check(f"hash of {dds_type}", by_type[dds_type], expected)
    return outputs


def check_impact(peer, event_id, outputs):
    """An event is answered, and nothing of the response is lost."""
    peer.strike(event_id, HEAVY)
    forecast = peer.message("impact_forecast", event_id)
    report = peer.message("impact_report", event_id)
    check("outcome", report.outcome, forecast.outcome)
    states = [(attachment, it) for attachment, it in list(peer.seen["column_state"]) if it.event_id == event_id]
    if len(states) < 50:
        raise Fault(f"only {len(states)} states of the response arrived")
    numbers = [attachment.number for attachment, _ in states]
    check("numbers of the states", numbers, list(range(numbers[0], numbers[0] + len(numbers))))
    check("identifier of the states", states[0][0].gid, gid_of(outputs["/garage/column_state"][0]))
    return len(states)


def strings(*texts):
    """A request with a sequence of strings."""
    body = struct.pack("<I", len(texts))
    for text in texts:
        body += b"\0" * (-len(body) % 4) + struct.pack("<I", len(text) + 1) + text.encode() + b"\0"
    return b"\0\1\0\0" + body


def check_services(peer):
    def key(service, dds_type):
        _, _, hash_, _ = peer.of_twin("SS")[f"{NODE}/{service}"]
        return f"{DOMAIN}{NODE}/{service}/{dds_type}/{hash_}"
    reply = peer.call(key("get_parameters", "rcl_interfaces::srv::dds_::GetParameters_"), strings("column_id", "publish_rate"))
    if reply is None:
        raise Fault("get_parameters does not reply")
    count, kind = struct.unpack("<IB", reply[4:9])
    check("values and the type of the first (string)", (count, kind), (2, 4))
    reply = peer.call(key("reset", "std_srvs::srv::dds_::Trigger_"), b"\0\1\0\0\0")
    check("success of reset", reply and reply[4], 1)


def check_bad_input(peer, twin):
    """What is malformed is counted and told, and nothing else."""
    before = twin.said("cannot be read")
    peer.events.put(b"no CDR at all", attachment=attached(1, peer.gid))
    peer.events.put(peer.types.event("without", **LIGHT))
    peer.events.put(b"", attachment=b"\1\2\3")
    twin.wait_to_say("cannot be read", before + 3)
    for token in [f"@ros2_lv/{DOMAIN}/x/y", f"@ros2_lv/{DOMAIN}/zz/0/1/NN/%/%/odd"]:
        peer.session.liveliness().declare_token(token).undeclare()


def check_clients(program, folder, environment, peer):
    """The clients of the program find the twin and are answered."""
    names = ["--ros-args", "-r", "__ns:=/garage"]
    watch = Program([program, "watch", "--transport", "zenoh", *names], folder, **environment)
    watch.wait_to_say("watching /garage/column_state")
    impact = Program([program, "impact", "--transport", "zenoh", "--mass", "10", "--velocity", "0.5", "--event", "by_client",
                      "--timeout", "30", *names], folder, **environment)
    impact.wait_to_say("forecast")
    check("exit code of impact", impact.end(), 0)
    watch.wait_to_say("by_client")
    check("exit code of watch", watch.end(), 0)
    peer.message("impact_report", "by_client")


def check_late_joiner(types, port, event_id):
    """Who comes late gets what the twin keeps: its status, and the reports."""
    late = Peer(types, port)
    for name in ["twin_status", "impact_report", "impact_forecast"]:
        late.subscribe(name, is_latched=True)
    wait_for("the kept status", lambda: late.seen["twin_status"])
    late.message("impact_report", event_id)
    late.message("impact_forecast", event_id)
    late.close()


def run(program):
    types, port = Types(), free_port()
    with tempfile.TemporaryDirectory() as folder:
        session = Path(folder, "session.json5")
        session.write_text(json.dumps(configuration("peer", ["tcp/127.0.0.1:0"], [f"tcp/127.0.0.1:{port}"])))
        environment = {"ZENOH_SESSION_CONFIG_URI": str(session)}
        twin_line = [program, "run", "--transport", "zenoh", "--ros-args", "-r", "__ns:=/garage", "-p", "state.directory:=''"]

        odd = Program(twin_line, folder, ZENOH_SESSION_CONFIG_URI=str(Path(folder, "nowhere.json5")))
        odd.wait_to_say("ZENOH_SESSION_CONFIG_URI: expected")
        check("exit code with a configuration that does not exist", odd.process.wait(PATIENCE), 2)
        odd.end()

        twin = Program(twin_line, folder, **environment)
        twin.wait_to_say("no Zenoh router is connected")
        twin.wait_to_say("is ready in domain")
        router = opened("router", [f"tcp/127.0.0.1:{port}"], [])
        twin.wait_to_say("connected to the Zenoh router")
        print("the twin started without a router and connected to it later")

        peer = Peer(types, port)
        outputs = check_graph(peer, types)
        print(f"graph: {len(outputs)} publishers, {len(peer.of_twin('SS'))} services, hashes as rosbags computes them")
        for name in TOPICS:
            peer.subscribe(name, is_latched=name in ["twin_status", "impact_forecast", "impact_report", "markers"])
        wait_for("the kept status", lambda: peer.seen["twin_status"])
        wait_for("the token of the subscriptions", lambda: peer.of_twin("MS"))
        print(f"an impact: {check_impact(peer, 'first', outputs)} states without a gap")
        check_services(peer)
        print("services: parameters, reset")
        check_bad_input(peer, twin)
        check_clients(program, folder, environment, peer)
        print("clients: impact, watch")
        check_late_joiner(types, port, "by_client")
        print("late joiners: status, forecast, report")

        router.close()
        twin.wait_to_say("is lost")
        router = opened("router", [f"tcp/127.0.0.1:{port}"], [])
        twin.wait_to_say("connected to the Zenoh router", 2)
        wait_for("the twin after the loss of the router", lambda: peer.of_twin("NN"))
        print(f"after the loss of the router: {check_impact(peer, 'afterwards', outputs)} states without a gap")

        check("exit code of the twin", twin.end(), 0)
        wait_for("the end of the node", lambda: not peer.of_twin("NN") and not peer.of_twin("MP"))
        peer.close()
        router.close()


def main():
    if len(sys.argv) != 2:
        sys.exit("expected one argument, the program column-twin; zenoh_peer.py COLUMN_TWIN")
    try:
        run(str(Path(sys.argv[1]).resolve()))
    except Fault as fault:
        for program in Program.running:
            print("\n".join(program.lines[-20:]), file=sys.stderr)
        sys.exit(f"FAULT: {fault}")
    finally:
        for program in list(Program.running):
            program.end(signal.SIGKILL)


if __name__ == "__main__":
    main()

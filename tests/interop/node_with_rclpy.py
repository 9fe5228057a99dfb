#!/usr/bin/env python3
"""A ROS 2 program (rclpy, Fast DDS) that uses the complete interface of the node.

Started by tests/ros/real_peers.rs with a running node in the domain of ROS_DOMAIN_ID, on loopback:

    node_with_rclpy.py EXPECTED.json

EXPECTED.json contains the event to send and every number of the samples and the report that must result. On differences, the
program prints one line per fault and exits with code 1. It waits for conditions and never sleeps.
"""

import json
import math
import sys
import time

import rclpy
from rcl_interfaces.msg import Log, ParameterEvent, ParameterType
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from column_twin_msgs.msg import (
    ColumnParameters, ColumnState, HingeDescription, HingeForces, ImpactEvent, ImpactReport, SecondOpinion, TwinStatus,
)
from column_twin_msgs.srv import PredictImpact

PATIENCE = 30.0
NODE = "column_twin"
TOPICS = {
    "/impact_event": "column_twin_msgs/msg/ImpactEvent",
    "/column_parameters": "column_twin_msgs/msg/ColumnParameters",
    "/column_state": "column_twin_msgs/msg/ColumnState",
    "/hinge_forces": "column_twin_msgs/msg/HingeForces",
    "/impact_forecast": "column_twin_msgs/msg/ImpactReport",
    "/impact_report": "column_twin_msgs/msg/ImpactReport",
    "/impact_estimate": "column_twin_msgs/msg/ImpactEstimate",
    "/twin_status": "column_twin_msgs/msg/TwinStatus",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/markers": "visualization_msgs/msg/MarkerArray",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/rosout": "rcl_interfaces/msg/Log",
    "/parameter_events": "rcl_interfaces/msg/ParameterEvent",
}
SERVICES = {
    "/column_twin/reset": "std_srvs/srv/Trigger",
    "/column_twin/predict": "column_twin_msgs/srv/PredictImpact",
    "/column_twin/confirm_estimate": "column_twin_msgs/srv/ConfirmEstimate",
    "/column_twin/correct_damage": "column_twin_msgs/srv/CorrectDamage",
}
# Those that every node of ROS 2 has.
NODE_SERVICES = {
    f"/column_twin/{name}": kind for name, kind in {
        "get_parameters": "rcl_interfaces/srv/GetParameters",
        "get_parameter_types": "rcl_interfaces/srv/GetParameterTypes",
        "list_parameters": "rcl_interfaces/srv/ListParameters",
        "describe_parameters": "rcl_interfaces/srv/DescribeParameters",
        "set_parameters": "rcl_interfaces/srv/SetParameters",
        "set_parameters_atomically": "rcl_interfaces/srv/SetParametersAtomically",
        "get_type_description": "type_description_interfaces/srv/GetTypeDescription",
    }.items()
}

faults = []


def check(what, found, expected):
    same = found == expected or (
        isinstance(found, float) and isinstance(expected, float) and math.isnan(found) and math.isnan(expected))
    if not same:
        faults.append(f"{what}: expected {expected!r}, found {found!r}")


def value_of(found):
    """A field as `check_fields` expects it."""
    if hasattr(found, "__len__") and not isinstance(found, str):
        return [value_of(it) for it in found]
    if hasattr(found, "get_fields_and_field_types"):
        return {name: value_of(getattr(found, name)) for name in found.get_fields_and_field_types()}
    return found


def check_fields(what, message, expected):
    """Compares every number bit for bit; null means NaN. All fields must be expected except those that the node fills in."""
    told = {"header", "column_id", "event_id", "kind", "compute_time"}
    check(f"fields of {what}", set(message.get_fields_and_field_types()) - told, set(expected))
    for name, value in expected.items():
        found = getattr(message, name)
        if name == "criteria":
            check(f"{what}: criteria", [it.name for it in found], [it["name"] for it in value])
            for one, other in zip(found, value):
                check_fields(f"{what}: {one.name}", one, other)
            continue
        if isinstance(value, dict):
            check_fields(f"{what}: {name}", found, value)
            continue
        if isinstance(value, str):
            check(f"{what}: {name}", found, value)
            continue
        found = [float(it) for it in found] if hasattr(found, "__len__") else float(found)
        value = [math.nan if it is None else float(it) for it in value] if isinstance(value, list) else \
            math.nan if value is None else float(value)
        if isinstance(value, list) and len(found) != len(value):
            faults.append(f"{what}: {name}: expected {len(value)} entries, found {found!r}")
        both = zip(found, value) if isinstance(value, list) else [(found, value)]
        if not all(one == other or (math.isnan(one) and math.isnan(other)) for one, other in both):
            faults.append(f"{what}: {name}: expected {value!r}, found {found!r}")


def check_that(what, condition):
    if not condition:
        faults.append(what)


class Peer:
    def __init__(self):
        self.node = rclpy.create_node("monitor")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.seen = {}
        reliable = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
        latched = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE,
                             durability=DurabilityPolicy.TRANSIENT_LOCAL)
        for name, message, qos in [
            ("column_state", ColumnState, reliable), ("hinge_forces", HingeForces, reliable),
            ("impact_forecast", ImpactReport, latched), ("impact_report", ImpactReport, latched),
            ("twin_status", TwinStatus, latched), ("joint_states", JointState, reliable),
            ("markers", MarkerArray, latched), ("/diagnostics", DiagnosticArray, reliable),
            ("/rosout", Log, latched), ("/parameter_events", ParameterEvent, reliable),
        ]:
            self.seen[name] = []
            self.node.create_subscription(message, name, self.seen[name].append, qos)
        self.events = self.node.create_publisher(ImpactEvent, "impact_event", reliable)
        self.sets = self.node.create_publisher(ColumnParameters, "column_parameters", reliable)

    def until(self, what, condition):
        """Spins until the condition holds; adds a fault and returns False after a timeout."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > deadline:
                faults.append(f"timeout while waiting for {what}")
                return False
            self.executor.spin_once(timeout_sec=0.1)
        return True

    def result(self, what, future):
        return future.result() if self.until(what, future.done) else None

    def meet(self):
        """Waits until publishers and subscriptions are matched with those of the node."""
        for publisher in [self.events, self.sets]:
            self.until(f"a match of {publisher.topic_name}", lambda: publisher.get_subscription_count() > 0)
        for subscription in self.node.subscriptions:
            if subscription.topic_name in TOPICS:
                self.until(f"a publisher of {subscription.topic_name}",
                           lambda: self.node.count_publishers(subscription.topic_name) > 0)
        # The node is matched with the subscriptions created before this one: it has sent this one the latched status.
        self.until("a status", lambda: self.seen["twin_status"])

    def of_node(self, name):
        """Messages of the tested node, without those of this one."""
        return [it for it in self.seen[name] if getattr(it, "name", NODE) == NODE and getattr(it, "node", "/" + NODE) == "/" + NODE]


def graph(peer):
    node = peer.node
    peer.until("the node's name", lambda: (NODE, "/") in node.get_node_names_and_namespaces())
    # It was empty.
    peer.until("the node's enclave", lambda: (NODE, "/", "/") in node.get_node_names_and_namespaces_with_enclaves())
    topics = lambda: {name: types for name, types in node.get_publisher_names_and_types_by_node(NODE, "/")
                      + node.get_subscriber_names_and_types_by_node(NODE, "/")}
    peer.until("all topics", lambda: TOPICS.keys() <= topics().keys())
    for name, type_name in TOPICS.items():
        check(name, topics().get(name), [type_name])
    services = lambda: dict(node.get_service_names_and_types_by_node(NODE, "/"))
    expected = {name: [type_name] for name, type_name in (SERVICES | NODE_SERVICES).items()}
    peer.until("all services", lambda: expected.keys() <= services().keys())
    # What `ros2 node info` shows is complete, and nothing else: a node that is not managed has no services of a lifecycle.
    check("services", services(), expected)
    check("topics", set(topics()), set(TOPICS))
    check("clients", node.get_client_names_and_types_by_node(NODE, "/"), [])
    check_that("/clock is not subscribed without use_sim_time", "/clock" not in topics())
    # This node's publishers and subscriptions must be matched before anything is sent.
    for name in ["/impact_event", "/column_parameters"]:
        peer.until(f"a reader of {name}", lambda: node.count_subscribers(name) > 0)
    peer.meet()


def parameters(peer):
    client = AsyncParameterClient(peer.node, NODE)
    peer.until("parameter services", client.services_are_ready)
    names = peer.result("list", client.list_parameters()).result.names
    check_that(f"the list has top.load: {names}", "top.load" in names and "use_sim_time" in names)
    under = peer.result("list", client.list_parameters(["geometry"], 2)).result.names
    check("geometry.*", sorted(under), ["geometry.height", "geometry.length_above", "geometry.length_below"])

    load, identity, port = peer.result(
        "describe", client.describe_parameters(["top.load", "column_id", "viewer.port"])).descriptors
    check("type of top.load", load.type, ParameterType.PARAMETER_DOUBLE)
    check_that(f"description of top.load: {load.description}", "[N]" in load.description)
    check("range of top.load", [(it.from_value, it.to_value) for it in load.floating_point_range], [(0.0, 1e9)])
    check("top.load is read-only", load.read_only, False)
    check("column_id is read-only", identity.read_only, True)
    check("range of viewer.port", [(it.from_value, it.to_value, it.step) for it in port.integer_range], [(1, 65535, 1)])

    values = peer.result("get", client.get_parameters(["top.load", "section.name", "no.such"])).values
    check("top.load", values[0].double_value, 5e5)
    check("section.name", values[1].string_value, "HEB220")
    check("no.such", values[2].type, ParameterType.PARAMETER_NOT_SET)
    types = peer.result("types", client.get_parameter_types(["top.load", "no.such"])).types
    check("types", list(types), [ParameterType.PARAMETER_DOUBLE, ParameterType.PARAMETER_NOT_SET])

    # A reply of several datagrams.
    every = [it.type for it in peer.result("get", client.get_parameters(names)).values]
    check_that(f"all values at once: {every}", len(every) == len(names) and ParameterType.PARAMETER_NOT_SET not in every)
    described = peer.result("describe", client.describe_parameters(names)).descriptors
    check("all descriptions at once", [it.name for it in described], list(names))

    def set_one(name, value):
        return peer.result("set", client.set_parameters([Parameter(name, value=value)])).results[0]

    check("set top.load", set_one("top.load", 4e5).successful, True)
    check("a whole number", set_one("top.load", 400000).successful, True)
    for name, value, reason in [
        ("top.load", -1.0, "is out of range; allowed: 0 to 1e9 N"), ("top.load", math.nan, "is not a finite number"),
        ("top.load", "heavy", "is a string, not a number"), ("top.laod", 1.0, "did you mean top.load?"),
        ("column_id", "other", "read-only"), ("section.name", "HEB225", "did you mean HEB220?"),
    ]:
        result = set_one(name, value)
        check_that(f"{name} = {value!r} is rejected with {reason!r}: {result}",
                   not result.successful and reason in result.reason)
    # Neither is valid alone: a semi-rigid base requires its stiffness.
    check("half of a pair", set_one("support.base", "semi_rigid").successful, False)
    pair = [Parameter("support.base", value="semi_rigid"), Parameter("support.base_stiffness", value=1e7)]
    check("a pair", peer.result("set", client.set_parameters_atomically(pair)).result.successful, True)
    half = [Parameter("top.load", value=1e5), Parameter("top.mass", value=-1.0)]
    check("half wrong", peer.result("set", client.set_parameters_atomically(half)).result.successful, False)
    check("nothing half applied", peer.result("get", client.get_parameters(["top.load"])).values[0].double_value, 4e5)
    back = [Parameter("support.base", value="built_in"), Parameter("support.base_stiffness", value=0.0),
            Parameter("top.load", value=5e5)]
    check("back", peer.result("set", client.set_parameters_atomically(back)).result.successful, True)
    changed = lambda: [[it.name for it in event.changed_parameters] for event in peer.of_node("/parameter_events")]
    peer.until("parameter events", lambda: ["support.base", "support.base_stiffness"] in [sorted(it) for it in changed()])

    message = ColumnParameters(column_id="column")
    for field, kind in message.get_fields_and_field_types().items():
        if kind == "double":
            setattr(message, field, math.nan)
    message.top_load = 3e5
    peer.sets.publish(message)
    get_load = lambda: peer.result("get", client.get_parameters(["top.load"])).values[0].double_value
    peer.until("a set by topic", lambda: get_load() == 3e5)
    message.top_load = 5e5
    peer.sets.publish(message)
    peer.until("a set by topic", lambda: get_load() == 5e5)
    rejected = peer.seen["twin_status"][-1].parameters_rejected
    check_that(f"all rejections are counted: {rejected}", rejected >= 8)
    message.column_id, message.top_load = "another", 1e5
    peer.sets.publish(message)
    reason = 'the message is for column "another", but this is the twin of column "column"'
    peer.until("its rejection in /rosout", lambda: any(reason in it.msg for it in peer.of_node("/rosout")))
    peer.until("its rejection in twin_status",
               lambda: any(reason in it.last_rejection_reason and it.last_rejection_code == TwinStatus.REJECTED_OTHER_COLUMN
                           for it in peer.seen["twin_status"]))
    check("nothing is changed", get_load(), 5e5)


def event_of(expected, event_id, stamp=None):
    event = ImpactEvent(column_id="column", event_id=event_id, mass=expected["mass"], velocity=expected["velocity"],
                        gap=math.nan, restitution=math.nan, height=math.nan, direction=math.nan)
    stamp = time.time_ns() if stamp is None else stamp
    event.header.stamp.sec, event.header.stamp.nanosec = divmod(stamp, 10**9)
    return event, stamp


def whole_response(peer, expected, event_id):
    """The stream of an impact on the undamaged column equals that of the simulation: complete and bit for bit."""
    event, stamp = event_of(expected, event_id)
    peer.events.publish(event)
    check_response(peer, expected, event_id, stamp)


def check_response(peer, expected, event_id, event_stamp):
    of = lambda name: [it for it in peer.seen[name] if it.event_id == event_id]
    samples = expected["samples"]
    peer.until(f"{len(samples)} states of {event_id}",
               lambda: min(len(of("column_state")), len(of("hinge_forces"))) >= len(samples))
    for name, kind in [("impact_forecast", ImpactReport.FORECAST), ("impact_report", ImpactReport.RESULT)]:
        # The forecast comes again with the error of its time step, as the result has it.
        wanted = 2 if kind == ImpactReport.FORECAST else 1
        if peer.until(name, lambda: len(of(name)) >= wanted):
            check(f"first {name} has an error estimate", math.isnan(of(name)[0].error_estimate), wanted == 2)
            report = of(name)[wanted - 1]
            check(f"kind of {name}", report.kind, kind)
            numbers = dict(expected["report"])
            # The second opinion, which a prediction does not have, is computed behind the forecast, and the action is that of both
            # models from then on.
            both = ["beam"]
            if report.beam.state == SecondOpinion.KNOWN:
                both += ["action", "deciding_criterion", "action_reason", "criteria"]
                check(f"{name}: the beam has a peak", report.beam.max_displacement > 0, True)
            numbers |= {field: value_of(getattr(report, field)) for field in both}
            # The range of the verdict is computed behind the forecast, before or after the response is over.
            if report.range_least != ImpactReport.ACTION_UNKNOWN:
                check(f"{name}: its range contains the action", report.range_least <= report.action <= report.range_most, True)
                numbers |= {field: getattr(report, field) for field in numbers if field.startswith("range_")}
            check_fields(name, report, numbers)
    states, forces = of("column_state"), of("hinge_forces")
    check("number of states", (len(states), len(forces)), (len(samples), len(samples)))
    for index, (state, force, sample) in enumerate(zip(states, forces, samples)):
        for what, message, numbers in [("state", state, sample["state"]), ("forces", force, sample["forces"])]:
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            check(f"stamp of {what} {index}", stamp, event_stamp + sample["since"])
            check(f"names of {what} {index}", (message.column_id, message.header.frame_id), ("column", "column"))
            check_fields(f"{what} {index}", message, numbers)
        if len(faults) > 20:
            return
    print(f"{event_id}: {len(states)} states and hinge forces are equal", flush=True)


def impact(peer, expected):
    whole_response(peer, expected, "e1")
    event, _ = event_of(expected, "e2")
    peer.until("joint states", lambda: peer.seen["joint_states"])
    check("joints", list(peer.seen["joint_states"][-1].name), ["hinge_1a", "hinge_1b", "hinge_2", "hinge_3"])
    status = peer.seen["twin_status"][-1]
    described = [(it.name, it.bar, it.end) for it in status.hinges]
    upper, lower = HingeDescription.UPPER_END, HingeDescription.LOWER_END
    check("hinges", described, [("1a", 0, upper), ("1b", 1, lower), ("2", 1, upper), ("3", 0, lower)])
    check("one entry per hinge", len(status.plastic_rotation), len(described))
    check("webs", [(it.name, it.bar, it.end) for it in status.webs],
          [("a", 0, HingeDescription.WHOLE_BAR), ("b", 1, HingeDescription.WHOLE_BAR)])
    peer.until("markers", lambda: peer.seen["markers"])
    check_that("markers show the column", any(it.ns == "column" for it in peer.seen["markers"][-1].markers))

    event.mass = -1.0
    peer.events.publish(event)
    peer.until("the rejection", lambda: any(it.last_rejection_event_id == "e2" and "mass = -1" in it.last_rejection_reason
                                          and it.last_rejection_code == TwinStatus.REJECTED_IMPACT_OUT_OF_RANGE
                                          for it in peer.seen["twin_status"]))
    rejection = 'impact event "e2" was rejected: mass = -1'
    peer.until("the rejection in /rosout", lambda: any(rejection in it.msg for it in peer.of_node("/rosout")))
    levels = [it.level for it in peer.of_node("/rosout") if rejection in it.msg]
    check("its level", [it if isinstance(it, int) else it[0] for it in levels], [30])
    peer.until("diagnostics", lambda: len(peer.seen["/diagnostics"]) >= 2)
    names = [it.name for it in peer.seen["/diagnostics"][-1].status]
    check_that(f"diagnostics: {names}", {f"column_twin: {it}" for it in ["twin", "solver", "queues", "ros"]} <= set(names))


def services(peer, expected):
    reset = peer.node.create_client(Trigger, "column_twin/reset")
    peer.until("reset", reset.service_is_ready)
    answer = peer.result("reset", reset.call_async(Trigger.Request()))
    check("reset", (answer.success, answer.message), (True, "the column is undamaged"))
    predict = peer.node.create_client(PredictImpact, "column_twin/predict")
    peer.until("predict", predict.service_is_ready)
    request = PredictImpact.Request(event_id="what if", mass=expected["mass"], velocity=expected["velocity"],
                                    gap=math.nan, restitution=math.nan, height=math.nan, direction=math.nan)
    answer = peer.result("predict", predict.call_async(request))
    report = answer.report
    check("predict", (answer.success, report.kind, report.event_id, report.column_id, report.max_v1),
          (True, ImpactReport.PREDICTION, "what if", "column", expected["report"]["max_v1"]))
    check_fields("prediction", report, expected["report"])
    request.mass = 0.0
    answer = peer.result("predict", predict.call_async(request))
    check("predict without mass",
          (answer.success, answer.rejection_code, "mass = 0: is required" in answer.message),
          (False, TwinStatus.REJECTED_IMPACT_OUT_OF_RANGE, True))
    # The undamaged column again, in every bit.
    whole_response(peer, expected, "e3")


def main():
    expected = json.loads(open(sys.argv[1]).read())
    rclpy.init()
    peer = Peer()
    for part, arguments in [(graph, []), (parameters, []), (impact, [expected]), (services, [expected])]:
        before = time.monotonic()
        part(peer, *arguments)
        print(f"{part.__name__}: {time.monotonic() - before:.2f} s, {len(faults)} faults", flush=True)
        if faults:
            break
    end(peer)


def end(peer):
    peer.node.destroy_node()
    rclpy.shutdown()
    for fault in faults[:20]:
        print(fault, file=sys.stderr)
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()

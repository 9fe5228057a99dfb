#!/usr/bin/env python3
"""The node as the tools of ROS 2 use it: `ros2 param set`, `dump` and `load`, `ros2 topic echo`, `ros2 topic info`, and type
descriptions. The tools themselves are not on PyPI; what they do with rclpy is repeated here, with the functions of rclpy
that they call (ros2cli 0.32, Jazzy).

Started by tests/ros/real_peers.rs with a running node in the domain of ROS_DOMAIN_ID, on loopback. On differences, the program
prints one line per fault and exits with code 1. It waits for conditions and never sleeps.
"""

import copy
import json
import re
import sys
import tempfile
import time
from pathlib import Path

import rclpy
import yaml
from rcl_interfaces.msg import Parameter, ParameterType
from rclpy.parameter import get_parameter_value, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import (DurabilityPolicy, QoSDurabilityPolicy, QoSPresetProfiles, QoSReliabilityPolicy, ReliabilityPolicy)
from std_srvs.srv import Trigger
from type_description_interfaces.srv import GetTypeDescription

from column_twin_msgs.msg import ColumnState, ImpactReport
from node_with_rclpy import NODE, Peer, check, check_that, end, event_of, faults

REPOSITORY = Path(__file__).resolve().parents[2]
SHARE = Path(sys.prefix) / "share"
ARRAYS = (ParameterType.PARAMETER_INTEGER_ARRAY, ParameterType.PARAMETER_DOUBLE_ARRAY, ParameterType.PARAMETER_STRING_ARRAY)
WAITS = "takes effect when the response ends"


def parameters_in(path):
    """The parameters of all nodes in a file, as messages; Kilted takes none without the names of the nodes."""
    nodes = list(yaml.safe_load(Path(path).read_text()))
    return rclpy.parameter.parameter_dict_from_yaml_file(path, target_nodes=nodes)


class Tools(Peer):
    def __init__(self):
        super().__init__()
        self.client = AsyncParameterClient(self.node, NODE)

    def param_set(self, name, text):
        """`ros2 param set /column_twin NAME TEXT`: the result of the one parameter."""
        parameter = Parameter(name=name, value=get_parameter_value(text))
        return self.result("set", self.client.set_parameters([parameter])).results[0]

    def param_get(self, name):
        return parameter_value_to_python(self.result("get", self.client.get_parameters([name])).values[0])

    def param_dump(self):
        """`ros2 param dump /column_twin`: the text of a parameter file."""
        names = sorted(self.result("list", self.client.list_parameters()).result.names)
        values = self.result("get", self.client.get_parameters(names)).values
        parameters = {}
        for name, value in zip(names, values):
            python = parameter_value_to_python(value)
            group = parameters
            *groups, last = name.split(".")
            for part in groups:
                group = group.setdefault(part, {})
            group[last] = list(python) if value.type in ARRAYS else python
        return yaml.dump({f"/{NODE}": {"ros__parameters": parameters}}, default_flow_style=False)

    def param_load(self, text):
        """`ros2 param load /column_twin FILE`: every result with the name of its parameter."""
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            file.write(text)
            file.flush()
            names = list(parameters_in(file.name))
            return dict(zip(names, self.result("load", self.client.load_parameter_file(file.name)).results))

    def diagnostics(self):
        """The values of the twin in the newest diagnostics."""
        newest = self.seen["/diagnostics"][-1:]
        return {it.key: it.value for array in newest for one in array.status if one.name == f"{NODE}: twin" for it in one.values}


def parameter_events(tools):
    """One publisher of /parameter_events. How the parameters are announced is tested in tests/ros."""
    publishers = lambda: [it for it in tools.node.get_publishers_info_by_topic("/parameter_events") if it.node_name == NODE]
    tools.until("a publisher of /parameter_events", publishers)
    tools.until("the parameter services", tools.client.services_are_ready)
    check("publishers of /parameter_events", len(publishers()), 1)


def numbers_that_yaml_1_1_reads_as_text(tools):
    for text, number in [("4.0e5", 4e5), ("3e5", 3e5), ("450000", 4.5e5), ("5.0e+5", 5e5)]:
        result = tools.param_set("top.load", text)
        check(f"ros2 param set top.load {text}", (result.successful, tools.param_get("top.load")), (True, number))
    # Otherwise this tests nothing.
    check("what PyYAML makes of 4.0e5", yaml.safe_load("4.0e5"), "4.0e5")
    result = tools.param_set("top.load", "heavy")
    check_that(f"a word is rejected: {result}", not result.successful and "is a string, not a number" in result.reason)
    changed = [(it.name, it.value.double_value) for event in tools.of_node("/parameter_events")
               for it in event.changed_parameters]
    tools.until("the event", lambda: any(it.changed_parameters for it in tools.of_node("/parameter_events")))
    check_that(f"events have the numbers: {changed}", set(changed) <= {("top.load", it) for it in (4e5, 3e5, 4.5e5, 5e5)})


def dump_and_load(tools):
    result = tools.param_set("solver.dt", "2e-05")
    check_that(f"2e-05: {result}", result.successful)
    dumped = tools.param_dump()
    check_that("the dump has a number that YAML 1.1 reads as text after str()", "2.0e-05" in dumped)
    check("str() of it", str(yaml.safe_load("2.0e-05")), "2e-05")
    rejected = {name: it.reason for name, it in tools.param_load(dumped).items() if not it.successful}
    check("rejected by ros2 param load of a dump", rejected, {})
    check("the dump after loading it", tools.param_dump(), dumped)
    # A list of unlike elements, which rclpy sends as one string, and a list that YAML 1.1 reads as texts.
    vehicle = {"name": "", "masses": [400, 800.0], "slack": [0.0],
               "spring_1": {"crush": [0.1, 1], "force": ["1e5", "2e5"], "unloading_stiffness": "1e7"},
               "spring_2": {"crush": ["1e-1"], "force": ["4.0e5"], "unloading_stiffness": 1e7}}
    file = yaml.dump({f"/{NODE}": {"ros__parameters": {"vehicle": vehicle}}})
    loaded = tools.param_load(file)
    # One by one, a vehicle by numbers is inconsistent until its last number has come.
    reasons = [it.reason for it in loaded.values() if not it.successful]
    check_that(f"a rejection names set_parameters_atomically: {reasons}",
               reasons and all("set_parameters_atomically" in it for it in reasons))
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as written:
        written.write(file)
        written.flush()
        parameters = parameters_in(written.name)
    result = tools.result("load", tools.client.set_parameters_atomically(list(parameters.values()))).result
    check_that(f"the vehicle as a whole: {result}", result.successful)
    check("its masses", list(tools.param_get("vehicle.masses")), [400.0, 800.0])
    check("its forces", list(tools.param_get("vehicle.spring_1.force")), [1e5, 2e5])
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as written:
        written.write(dumped)
        written.flush()
        back = tools.result("load", tools.client.set_parameters_atomically(list(parameters_in(written.name).values()))).result
    check_that(f"the dump as a whole: {back}", back.successful)


def a_set_that_waits(tools):
    """What waits for the end of a response says so, is not read back before it holds, and is not undone later."""
    reset = tools.node.create_client(Trigger, f"{NODE}/reset")
    tools.until("reset", reset.service_is_ready)
    check("a longer response", tools.param_set("response.duration", "15").successful, True)

    def approaching(event_id, mass):
        """An impact on its way, for five seconds."""
        event, _ = event_of({"mass": mass, "velocity": 2.0}, event_id)
        event.gap = 10.0
        tools.events.publish(event)
        tools.until("the forecast", lambda: any(it.event_id == event_id for it in tools.seen["impact_forecast"]))

    approaching("light", 10.0)
    result = tools.param_set("top.load", "4.5e5")
    check("a set during a response", (result.successful, result.reason), (True, WAITS))
    check("what is read back", tools.param_get("top.load"), 5e5)
    wanted = "parameters that wait for the end of the response"
    tools.until("the parameter in /diagnostics", lambda: tools.diagnostics().get(wanted) == "top.load")
    tools.until("the report", lambda: any(it.event_id == "light" for it in tools.seen["impact_report"]))
    tools.until("the new value", lambda: tools.param_get("top.load") == 4.5e5)
    tools.until("nothing more waits", lambda: tools.diagnostics().get(wanted) == "")
    check("back", tools.param_set("top.load", "5e5").reason, "")

    approaching("heavy", 1500.0)
    result = tools.param_set("section.name", "HEB300")
    check_that(f"a set that the damage will forbid: {result}",
               not result.successful and "[column_damaged]" in result.reason
               and "cannot take effect when the response to the impact ends" in result.reason)
    check("the section", tools.param_get("section.name"), "HEB220")
    check("reset", tools.result("reset", reset.call_async(Trigger.Request())).success, True)


def chosen_qos(tools, topic, options):
    """The QoS with which `ros2 topic echo TOPIC` subscribes (ros2topic.verb.echo, `choose_qos`)."""
    qos = copy.copy(QoSPresetProfiles.get_from_short_key("sensor_data"))
    reliability, durability = options.get("--qos-reliability"), options.get("--qos-durability")
    if reliability or durability:
        if reliability:
            qos.reliability = QoSReliabilityPolicy.get_from_short_key(reliability)
        if durability:
            qos.durability = QoSDurabilityPolicy.get_from_short_key(durability)
        return qos
    offered = [it.qos_profile for it in tools.node.get_publishers_info_by_topic(topic)]
    if all(it.reliability == ReliabilityPolicy.RELIABLE for it in offered):
        qos.reliability = ReliabilityPolicy.RELIABLE
    if all(it.durability == DurabilityPolicy.TRANSIENT_LOCAL for it in offered):
        qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
    return qos


def documented_echo(tools):
    """Every `ros2 topic echo` of the documents shows what was published before it."""
    documents = [REPOSITORY / it for it in ["launch_notes.md", "README.md"]]
    commands = [line for it in documents for line in re.findall(r"ros2 topic echo[^`\n]*", it.read_text())]
    check_that(f"commands are documented: {commands}", commands)
    for command in commands:
        _, _, _, topic, *options = command.split("#")[0].split()
        topic = "/" + topic.strip("/")
        options = dict(zip(options[::2], options[1::2]))
        tools.until(f"a publisher of {topic}", lambda: tools.node.get_publishers_info_by_topic(topic))
        qos = chosen_qos(tools, topic, options)
        shown = []
        subscription = tools.node.create_subscription(ImpactReport, topic, shown.append, qos)
        tools.until(f"`{command}` to show the past", lambda: shown)
        tools.node.destroy_subscription(subscription)
    # The line that was documented before: without a reliability, best effort is chosen, for which nothing is kept.
    check("reliability of transient local alone",
          chosen_qos(tools, "/impact_forecast", {"--qos-durability": "transient_local"}).reliability, ReliabilityPolicy.BEST_EFFORT)


def type_descriptions(tools):
    """Our descriptions are those that rosidl has installed, and our answer that of a node of rclpy."""
    own = tools.node.create_client(GetTypeDescription, f"/{NODE}/get_type_description")
    rclpys = tools.node.create_client(GetTypeDescription, f"/{tools.node.get_name()}/get_type_description")
    tools.until("the services", lambda: own.service_is_ready() and rclpys.service_is_ready())
    ask = lambda client, name, hash, sources=True: tools.result(
        name, client.call_async(GetTypeDescription.Request(type_name=name, type_hash=hash, include_type_sources=sources)))
    definitions = sorted(it for pattern in ["msg/*.msg", "srv/*.srv", "msg/deps/*/*.msg", "msg/deps/*/*.srv"]
                         for it in REPOSITORY.glob(pattern))
    for path in definitions:
        package = path.parent.name if path.parent.parent.name == "deps" else "column_twin_msgs"
        kind = path.suffix[1:]
        installed = json.loads((SHARE / package / kind / f"{path.stem}.json").read_text())
        name = f"{package}/{kind}/{path.stem}"
        hashes = {it["type_name"]: it["hash_string"] for it in installed["type_hashes"]}
        answer = ask(own, name, hashes[name])
        check(f"answer for {name}", (answer.successful, answer.failure_reason), (True, ""))
        check(f"description of {name}", described(answer.type_description), installed["type_description_msg"])
        check(f"sources of {name}", [it.type_name for it in answer.type_sources], all_types(installed))
        check(f"source of {name}", (answer.type_sources[0].encoding, answer.type_sources[0].raw_file_contents),
              (kind, path.read_text().removesuffix("\n")))
    print(f"{len(definitions)} types are described as rosidl describes them", flush=True)

    # This node has a subscription of the first and a service of the second.
    tools.node.create_service(Trigger, "~/trigger", lambda request, response: response)
    for name in ["column_twin_msgs/msg/ColumnState", "column_twin_msgs/msg/TwinStatus", "visualization_msgs/msg/MarkerArray",
                 "diagnostic_msgs/msg/DiagnosticArray", "std_srvs/srv/Trigger"]:
        package, kind, stem = name.split("/")
        installed = json.loads((SHARE / package / kind / f"{stem}.json").read_text())["type_hashes"]
        hash = next(it["hash_string"] for it in installed if it["type_name"] == name)
        for sources in [True, False]:
            answers = [without_comments(ask(client, name, hash, sources)) for client in [own, rclpys]]
            check(f"answer of rclpy for {name}", *answers)
    answer = ask(own, "column_twin_msgs/msg/ColumnState", "RIHS01_" + "0" * 64)
    check_that(f"an unknown hash: {answer.failure_reason}", not answer.successful and "RIHS01_" in answer.failure_reason)
    check("the parameter", tools.param_get("start_type_description_service"), True)
    check_that("it is read-only", not tools.param_set("start_type_description_service", "false").successful)


def without_comments(answer):
    """The comments of ROS's own definitions depend on the distribution; the node has those of Jazzy."""
    for source in answer.type_sources:
        lines = (line.split("#")[0].split() for line in source.raw_file_contents.splitlines())
        source.raw_file_contents = "\n".join(" ".join(line) for line in lines if line)
    return answer


def described(description):
    one = lambda it: {"type_name": it.type_name, "fields": [
        {"name": field.name, "type": {"type_id": field.type.type_id, "capacity": field.type.capacity,
                                      "string_capacity": field.type.string_capacity,
                                      "nested_type_name": field.type.nested_type_name},
         "default_value": field.default_value} for field in it.fields]}
    return {"type_description": one(description.type_description),
            "referenced_type_descriptions": [one(it) for it in description.referenced_type_descriptions]}


def all_types(installed):
    description = installed["type_description_msg"]
    types = [description["type_description"], *description["referenced_type_descriptions"]]
    return [it["type_name"] for it in types]


def main():
    rclpy.init()
    tools = Tools()
    tools.meet()
    for part in [parameter_events, numbers_that_yaml_1_1_reads_as_text, dump_and_load, a_set_that_waits, documented_echo,
                 type_descriptions]:
        before = time.monotonic()
        part(tools)
        print(f"{part.__name__}: {time.monotonic() - before:.2f} s, {len(faults)} faults", flush=True)
        if faults:
            break
    end(tools)


if __name__ == "__main__":
    main()

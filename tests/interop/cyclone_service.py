"""Calls services of the twin on Cyclone DDS as rmw_cyclonedds does, of which there is no wheel.

bridge.py uses it across two bridges; as a program, started by tests/ros/real_peers.rs, it calls a running node in the domain of
ROS_DOMAIN_ID on loopback, and exits with code 1 and what differs:

    cyclone_service.py EXPECTED.json

A request begins with the client's identity and a number, which the reply repeats; there is no metadata. The participant announces
itself as a ROS node on `ros_discovery_info`, without which the bridge ignores it.
"""

import json
import math
import os
import random
import sys
import time
from dataclasses import dataclass, field

LOOPBACK = ('<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo"/></Interfaces>'
            "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
            '<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>')
os.environ.setdefault("CYCLONEDDS_URI", LOOPBACK)

from cyclonedds.core import InstanceState, Policy, Qos, ReadCondition, SampleState, ViewState, WaitSet  # noqa: E402
from cyclonedds.domain import DomainParticipant  # noqa: E402
from cyclonedds.idl import IdlStruct, types  # noqa: E402
from cyclonedds.pub import DataWriter  # noqa: E402
from cyclonedds.sub import DataReader  # noqa: E402
from cyclonedds.topic import Topic  # noqa: E402
from cyclonedds.util import duration  # noqa: E402

NODE = "cyclone_operator"
PATIENCE = 30.0
# ParameterType of rcl_interfaces: the field of its value.
FIELDS = {1: "bool_value", 2: "integer_value", 3: "double_value", 4: "string_value"}
DOUBLE = 3
# The encoding of every ROS 2 middleware on DDS.
ENCODING = Policy.DataRepresentation(use_cdrv0_representation=True)
RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10), ENCODING)
LATCHED = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.TransientLocal, Policy.History.KeepLast(1), ENCODING)


@dataclass
class Gid(IdlStruct, typename="rmw_dds_common::msg::dds_::Gid_"):
    data: types.array[types.uint8, 16]


@dataclass
class NodeEntitiesInfo(IdlStruct, typename="rmw_dds_common::msg::dds_::NodeEntitiesInfo_"):
    node_namespace: str
    node_name: str
    reader_gid_seq: types.sequence[Gid]
    writer_gid_seq: types.sequence[Gid]


@dataclass
class ParticipantEntitiesInfo(IdlStruct, typename="rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_"):
    gid: Gid
    node_entities_info_seq: types.sequence[NodeEntitiesInfo]


@dataclass
class PredictRequest(IdlStruct, typename="column_twin_msgs::srv::dds_::PredictImpact_Request_"):
    client: types.uint64
    number: types.int64
    column_id: str
    event_id: str
    vehicle: str
    mass: types.float64
    velocity: types.float64
    gap: types.float64
    restitution: types.float64
    height: types.float64
    direction: types.float64


@dataclass
class PredictReply(IdlStruct, typename="column_twin_msgs::srv::dds_::PredictImpact_Response_"):
    """The reply as far as its report's peak displacement; CDR does not mark where a structure begins."""
    client: types.uint64
    number: types.int64
    success: bool
    rejection_code: types.uint16
    message: str
    report_sec: types.int32
    report_nanosec: types.uint32
    report_frame_id: str
    report_column_id: str
    report_event_id: str
    report_vehicle: str
    report_mass: types.float64
    report_velocity: types.float64
    report_direction: types.float64
    report_kind: types.uint8
    report_outcome: types.uint8
    report_max_v1: types.float64


@dataclass
class ParameterValue(IdlStruct, typename="rcl_interfaces::msg::dds_::ParameterValue_"):
    type: types.uint8 = 0
    bool_value: bool = False
    integer_value: types.int64 = 0
    double_value: types.float64 = 0.0
    string_value: str = ""
    byte_array_value: types.sequence[types.uint8] = field(default_factory=list)
    bool_array_value: types.sequence[bool] = field(default_factory=list)
    integer_array_value: types.sequence[types.int64] = field(default_factory=list)
    double_array_value: types.sequence[types.float64] = field(default_factory=list)
    string_array_value: types.sequence[str] = field(default_factory=list)


@dataclass
class Parameter(IdlStruct, typename="rcl_interfaces::msg::dds_::Parameter_"):
    name: str
    value: ParameterValue


@dataclass
class SetParametersResult(IdlStruct, typename="rcl_interfaces::msg::dds_::SetParametersResult_"):
    successful: bool
    reason: str


@dataclass
class GetRequest(IdlStruct, typename="rcl_interfaces::srv::dds_::GetParameters_Request_"):
    client: types.uint64
    number: types.int64
    names: types.sequence[str]


@dataclass
class GetReply(IdlStruct, typename="rcl_interfaces::srv::dds_::GetParameters_Response_"):
    client: types.uint64
    number: types.int64
    values: types.sequence[ParameterValue]


@dataclass
class SetRequest(IdlStruct, typename="rcl_interfaces::srv::dds_::SetParameters_Request_"):
    client: types.uint64
    number: types.int64
    parameters: types.sequence[Parameter]


@dataclass
class SetReply(IdlStruct, typename="rcl_interfaces::srv::dds_::SetParameters_Response_"):
    client: types.uint64
    number: types.int64
    results: types.sequence[SetParametersResult]


class Service:
    """A client of one service."""

    def __init__(self, participant, name, request, reply, patience):
        self.name, self.participant, self.request, self.patience = name, participant, request, patience
        self.client, self.number = random.getrandbits(64), 0
        self.writer = DataWriter(participant, Topic(participant, f"rq/{name}Request", request), qos=RELIABLE)
        self.reader = DataReader(participant, Topic(participant, f"rr/{name}Reply", reply), qos=RELIABLE)
        self.waitset = WaitSet(participant)
        self.waitset.attach(ReadCondition(self.reader, ViewState.Any | InstanceState.Any | SampleState.Any))

    def wait(self, what, condition):
        deadline = time.monotonic() + self.patience
        while not (found := condition()):
            if time.monotonic() > deadline:
                raise TimeoutError(f"{what} of {self.name} after {self.patience} s")
            self.waitset.wait(duration(milliseconds=20))
        return found

    def call(self, *content):
        self.wait("no server", lambda: self.writer.get_matched_subscriptions() and self.reader.get_matched_publications())
        self.number += 1
        self.writer.write(self.request(self.client, self.number, *content))
        # Others' replies come on the same topic.
        ours = lambda: [it for it in self.reader.take(N=100) if (it.client, it.number) == (self.client, self.number)]
        return self.wait("no reply", ours)[0]


class ServiceCaller:
    """A ROS node on Cyclone DDS with clients of the services of the node `column_twin`."""

    def __init__(self, domain, patience):
        self.participant = DomainParticipant(domain)
        service = lambda name, request, reply: Service(self.participant, f"column_twin/{name}", request, reply, patience)
        self.predicting = service("predict", PredictRequest, PredictReply)
        self.getting = service("get_parameters", GetRequest, GetReply)
        self.setting = service("set_parameters", SetRequest, SetReply)
        topic = Topic(self.participant, "ros_discovery_info", ParticipantEntitiesInfo)
        self.announcement = DataWriter(self.participant, topic, qos=LATCHED)
        gid = lambda entity: Gid(list(entity.guid.bytes))
        services = [self.predicting, self.getting, self.setting]
        node = NodeEntitiesInfo("/", NODE, [gid(it.reader) for it in services], [gid(it.writer) for it in services])
        self.announcement.write(ParticipantEntitiesInfo(gid(self.participant), [node]))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        # Its entities end with it, and the bridge forgets the node.
        del self.announcement, self.predicting, self.getting, self.setting, self.participant

    def predict(self, mass, velocity, gap):
        return self.predicting.call("", "", "", mass, velocity, gap, math.nan, math.nan, math.nan)

    def get_parameters(self, names):
        """Values; None for a parameter that is not set."""
        values = self.getting.call(names).values
        return [getattr(it, FIELDS[it.type]) if it.type in FIELDS else None for it in values]

    def set_double(self, name, value):
        """Whether the node took it, and why not."""
        result = self.setting.call([Parameter(name, ParameterValue(type=DOUBLE, double_value=value))]).results[0]
        return result.successful, result.reason


def main():
    expected = json.loads(open(sys.argv[1]).read())
    with ServiceCaller(int(os.environ["ROS_DOMAIN_ID"]), PATIENCE) as caller:
        answer = caller.predict(expected["mass"], expected["velocity"], 0.0)
        found = {
            "prediction": (answer.success, answer.message, answer.report_max_v1),
            "parameters": caller.get_parameters(["section.name", "top.load", "no.such"]),
            "a parameter that can be set": caller.set_double("event.max_age", 7.5),
            "its value": caller.get_parameters(["event.max_age"]),
            "a parameter that cannot be set": caller.set_double("top.load", -1.0)[0],
        }
    wanted = {
        "prediction": (True, "", expected["report"]["max_v1"]),
        "parameters": ["HEB220", 5e5, None],
        "a parameter that can be set": (True, ""),
        "its value": [7.5],
        "a parameter that cannot be set": False,
    }
    faults = [f"{what}: expected {wanted[what]!r}, found {value!r}" for what, value in found.items() if value != wanted[what]]
    sys.exit("\n".join(faults) or None)


if __name__ == "__main__":
    main()

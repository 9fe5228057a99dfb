#!/usr/bin/env python3
"""A DDS program without ROS (Cyclone DDS) that receives rt/column_state with default settings except for the reliability.

Started by tests/ros/real_peers.rs with a running node in the domain of ROS_DOMAIN_ID, on loopback:

    state_with_cyclonedds.py EXPECTED.json

Prints `found` when it has found the node's publisher, and `ready` when the last sample of an impact has come whose identifier
begins with `light`: the publisher has found it too. EXPECTED.json holds the samples that must come then. Exit code 1 with what
differs.
"""

import json
import math
import os
import sys
import time
from dataclasses import dataclass

LOOPBACK = ('<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo"/></Interfaces>'
            "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
            '<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>')
os.environ.setdefault("CYCLONEDDS_URI", LOOPBACK)

from cyclonedds.core import Policy, Qos, ReadCondition, InstanceState, SampleState, ViewState, WaitSet  # noqa: E402
from cyclonedds.domain import DomainParticipant  # noqa: E402
from cyclonedds.idl import IdlStruct, types  # noqa: E402
from cyclonedds.sub import DataReader  # noqa: E402
from cyclonedds.topic import Topic  # noqa: E402
from cyclonedds.util import duration  # noqa: E402

PATIENCE = 30.0
# Phase of the last sample of a response.
REST = 4


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: types.int32
    nanosec: types.uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class ColumnState(IdlStruct, typename="column_twin_msgs::msg::dds_::ColumnState_"):
    header: Header
    column_id: str
    event_id: str
    phase: types.uint8
    time: types.float64
    v1: types.float64
    u1: types.float64
    beta1: types.float64
    u2: types.float64
    v1_rate: types.float64
    u1_rate: types.float64
    u2_rate: types.float64
    impactor_position: types.float64
    impactor_velocity: types.float64
    gap: types.float64
    contact_force: types.float64
    impact_impulse: types.float64
    impulse: types.float64
    kinetic_energy: types.float64
    elastic_energy: types.float64
    plastic_work: types.float64
    impact_loss: types.float64
    damping_work: types.float64
    load_work: types.float64
    ledger_residual: types.float64
    vehicle_velocity: types.sequence[types.float64, 3]
    crush: types.sequence[types.float64, 3]
    permanent_crush: types.sequence[types.float64, 3]
    spring_force: types.sequence[types.float64, 3]
    vehicle_dissipated: types.sequence[types.float64, 3]
    vehicle_elastic_energy: types.float64


def stamp_of(state):
    return state.header.stamp.sec * 10**9 + state.header.stamp.nanosec


def equal(one, other):
    if isinstance(other, list):
        return len(one) == len(other) and all(map(equal, one, other))
    return one == other or (math.isnan(one) and math.isnan(other))


def main():
    expected = json.loads(open(sys.argv[1]).read())
    participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
    topic = Topic(participant, "rt/column_state", ColumnState)
    reader = DataReader(participant, topic, qos=Qos(
        Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepLast(2000)))
    condition = ReadCondition(reader, ViewState.Any | InstanceState.Any | SampleState.Any)
    waitset = WaitSet(participant)
    waitset.attach(condition)
    deadline = time.monotonic() + PATIENCE
    while not reader.get_matched_publications():
        if time.monotonic() > deadline:
            sys.exit("timeout while waiting for a publisher of rt/column_state")
        waitset.wait(duration(milliseconds=20))
    print("found", flush=True)
    states, ready = [], False
    while len(states) < len(expected["samples"]) and time.monotonic() < deadline:
        waitset.wait(duration(milliseconds=200))
        for state in reader.take(N=2000):
            light = state.event_id.startswith("light")
            if light and state.phase == REST and not ready:
                print("ready", flush=True)
                ready = True
            if not light:
                states.append(state)
    if len(states) != len(expected["samples"]):
        sys.exit(f"expected {len(expected['samples'])} states, found {len(states)}")
    first = stamp_of(states[0])
    for index, (state, sample) in enumerate(zip(states, expected["samples"])):
        numbers = {name: math.nan if value is None else value for name, value in sample["state"].items()}
        differing = [name for name, value in numbers.items() if not equal(getattr(state, name), value)]
        if differing or stamp_of(state) - first != sample["since"] or state.header.frame_id != "column":
            sys.exit(f"state {index} differs in {differing}: expected {sample}, found {state}")
    print(f"{len(states)} states are equal", flush=True)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""As answers_with_rclpy.py, on Cyclone DDS without ROS:

    answers_with_cyclonedds.py COLUMN_ID [PERIOD]
"""

import math
import os
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import InstanceState, Policy, Qos, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct, types
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from state_with_cyclonedds import Header, Time

PERIOD = 0.5
# The encoding of every ROS 2 middleware on DDS.
RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10),
               Policy.DataRepresentation(use_cdrv0_representation=True))
# Several forecasts at once, after a stop, are not lost in this reader however busy the machine is.
MANY = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1000),
           Policy.DataRepresentation(use_cdrv0_representation=True))


@dataclass
class ImpactEvent(IdlStruct, typename="column_twin_msgs::msg::dds_::ImpactEvent_"):
    header: Header
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
class ImpactReport(IdlStruct, typename="column_twin_msgs::msg::dds_::ImpactReport_"):
    """Only its beginning: the rest is not read."""

    header: Header
    column_id: str
    event_id: str


@dataclass
class TwinStatus(IdlStruct, typename="column_twin_msgs::msg::dds_::TwinStatus_"):
    """Only its beginning, too."""

    header: Header
    column_id: str
    phase: types.uint8
    event_id: str
    events_accepted: types.uint64


def main():
    participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
    events = DataWriter(participant, Topic(participant, "rt/impact_event", ImpactEvent), qos=RELIABLE)
    forecasts = DataReader(participant, Topic(participant, "rt/impact_forecast", ImpactReport), qos=MANY)
    reports = DataReader(participant, Topic(participant, "rt/impact_report", ImpactReport), qos=MANY)
    statuses = DataReader(participant, Topic(participant, "rt/twin_status", TwinStatus), qos=MANY)
    waitset = WaitSet(participant)
    for reader in (forecasts, reports, statuses):
        waitset.attach(ReadCondition(reader, ViewState.Any | InstanceState.Any | SampleState.Any))
    period = float(sys.argv[2]) if len(sys.argv) > 2 else PERIOD
    number, due = 0, time.monotonic()
    accepted = 0
    while True:
        if time.monotonic() >= due:
            due += period
            number += 1
            now = time.time_ns()
            print("sent", number, flush=True)
            events.write(ImpactEvent(
                Header(Time(now // 10**9, now % 10**9), ""), sys.argv[1], str(number), "", 10.0, 0.5,
                math.nan, math.nan, math.nan, math.nan))
        waitset.wait(duration(milliseconds=50))
        # Not a message when the node's writer is lost.
        for report in forecasts.take(N=100):
            if isinstance(report, ImpactReport):
                print("forecast", report.event_id, flush=True)
        for report in reports.take(N=100):
            if isinstance(report, ImpactReport):
                print("report", report.event_id, flush=True)
        for status in statuses.take(N=100):
            if isinstance(status, TwinStatus) and status.column_id == sys.argv[1] and status.events_accepted > accepted:
                accepted = status.events_accepted
                print("accepted", accepted, flush=True)


if __name__ == "__main__":
    main()

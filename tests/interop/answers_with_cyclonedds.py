#!/usr/bin/env python3
"""As answers_with_rclpy.py, on Cyclone DDS without ROS:

    answers_with_cyclonedds.py COLUMN_ID
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


def main():
    participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
    events = DataWriter(participant, Topic(participant, "rt/impact_event", ImpactEvent), qos=RELIABLE)
    reports = DataReader(participant, Topic(participant, "rt/impact_forecast", ImpactReport), qos=MANY)
    waitset = WaitSet(participant)
    waitset.attach(ReadCondition(reports, ViewState.Any | InstanceState.Any | SampleState.Any))
    number, due = 0, time.monotonic()
    while True:
        if time.monotonic() >= due:
            due += PERIOD
            number += 1
            now = time.time_ns()
            print("sent", number, flush=True)
            events.write(ImpactEvent(
                Header(Time(now // 10**9, now % 10**9), ""), sys.argv[1], str(number), "", 10.0, 0.5,
                math.nan, math.nan, math.nan, math.nan))
        waitset.wait(duration(milliseconds=50))
        for report in reports.take(N=100):
            # Not one when the node's writer is lost.
            if isinstance(report, ImpactReport):
                print("forecast", report.event_id, flush=True)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Sends a light impact to a column every half second or so, and tells which forecasts arrive, until it is ended.

Started by tests/partition with a running node in the domain of ROS_DOMAIN_ID:

    answers_with_rclpy.py COLUMN_ID [PERIOD]

PERIOD is the time between two impacts [s].
Prints `sent NUMBER` before it sends an event, `forecast NUMBER` and `report NUMBER` when the forecast and the report of one have
arrived, `accepted COUNT` and `rejected COUNT` when a status says that the column has accepted or rejected more of them, and
`diagnostics TEXT` when /diagnostics says something else of the messages of the node.
"""

import sys

import rclpy
from rclpy.qos import QoSProfile

from column_twin_msgs.msg import ImpactEvent, ImpactReport, TwinStatus
from diagnostic_msgs.msg import DiagnosticArray

PERIOD = 0.5
# Several forecasts at once, after a stop, are not lost in this reader however busy the machine is.
MANY = QoSProfile(depth=1000)


def main():
    rclpy.init()
    node = rclpy.create_node("persistent_peer")
    events = node.create_publisher(ImpactEvent, "impact_event", QoSProfile(depth=10))
    number = 0
    last, accepted, rejected = None, 0, 0

    def send():
        nonlocal number
        number += 1
        # A light impact, which is over before the next one.
        event = ImpactEvent(column_id=sys.argv[1], event_id=str(number), mass=10.0, velocity=0.5)
        event.gap = event.restitution = event.height = event.direction = float("nan")
        event.header.stamp = node.get_clock().now().to_msg()
        print("sent", number, flush=True)
        events.publish(event)

    def receive(report):
        print("forecast", report.event_id, flush=True)

    def complete(report):
        print("report", report.event_id, flush=True)

    def diagnose(array):
        nonlocal last
        for status in array.status:
            if status.name.endswith(": ros") and status.message != last:
                last = status.message
                print("diagnostics", last, flush=True)

    def count(status):
        nonlocal accepted, rejected
        if status.column_id == sys.argv[1] and status.events_accepted > accepted:
            accepted = status.events_accepted
            print("accepted", accepted, flush=True)
        if status.column_id == sys.argv[1] and status.events_rejected > rejected:
            rejected = status.events_rejected
            print("rejected", rejected, flush=True)

    node.create_subscription(ImpactReport, "impact_forecast", receive, MANY)
    node.create_subscription(ImpactReport, "impact_report", complete, MANY)
    node.create_subscription(DiagnosticArray, "/diagnostics", diagnose, QoSProfile(depth=10))
    node.create_subscription(TwinStatus, "twin_status", count, QoSProfile(depth=10))
    node.create_timer(float(sys.argv[2]) if len(sys.argv) > 2 else PERIOD, send)
    rclpy.spin(node)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Listens to one column of a fleet in its namespace with rclpy.

Started by tests/fleet/real_peers.rs with a fleet in the domain of ROS_DOMAIN_ID, on loopback:

    column_topics_with_rclpy.py NAMESPACE COLUMN

Checks that the topics appear with the status of the column, that an impact arrives on them, that they belong to a node in the
namespace, and that they go when nobody listens. Prints how long the first message takes.
"""

import sys
import time

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from column_twin_msgs.msg import ColumnState, FleetStatus, ImpactEvent, ImpactReport, TwinStatus

PATIENCE = 30.0


def main():
    namespace, column = sys.argv[1:]
    rclpy.init()
    node = rclpy.create_node("listener")
    latched = QoSProfile(
        depth=10, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
    )
    streamed = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)

    def wait_until(what, is_so):
        begun = time.monotonic()
        while not is_so():
            if time.monotonic() - begun > PATIENCE:
                sys.exit(f"expected {what}, waited {PATIENCE} s")
            rclpy.spin_once(node, timeout_sec=0.01)
        return time.monotonic() - begun

    fleet = []
    node.create_subscription(FleetStatus, "/fleet_status", fleet.append, latched)
    events = node.create_publisher(ImpactEvent, "/impact_event", streamed)
    wait_until("a fleet", lambda: fleet and events.get_subscription_count() == 1)
    check("nobody listens to the column yet", node.count_publishers(f"{namespace}/twin_status") == 0)

    statuses, states, forecasts = [], [], []
    subscriptions = [
        node.create_subscription(TwinStatus, f"{namespace}/twin_status", statuses.append, latched),
        node.create_subscription(ColumnState, f"{namespace}/column_state", states.append, streamed),
        node.create_subscription(ImpactReport, f"{namespace}/impact_forecast", forecasts.append, latched),
    ]
    took = wait_until("the status of the column", lambda: statuses)
    check("the status is that of the column", statuses[0].column_id == column)
    wait_until("the writer of states", lambda: node.count_publishers(f"{namespace}/column_state") == 1)
    names = node.get_publishers_info_by_topic(f"{namespace}/twin_status")
    wait_until(
        "the node of the topics", lambda: ("column_topics", namespace) in node.get_node_names_and_namespaces()
    )
    check("one writer of the status", len(names) == 1)

    event = ImpactEvent(column_id=column, event_id="rclpy", mass=1500.0, velocity=8.0)
    for field in ["gap", "restitution", "height", "direction"]:
        setattr(event, field, float("nan"))
    event.header.stamp = node.get_clock().now().to_msg()
    events.publish(event)
    wait_until("a forecast and states", lambda: forecasts and len(states) > 10)
    check("they belong to the impact", {it.event_id for it in forecasts + states} == {"rclpy"})

    for subscription in subscriptions:
        node.destroy_subscription(subscription)
    wait_until("the end of the topics", lambda: node.count_publishers(f"{namespace}/twin_status") == 0)
    wait_until(
        "the end of their node",
        lambda: ("column_topics", namespace) not in node.get_node_names_and_namespaces(),
    )
    print(f"the status {took:.3f} s after the subscription; the topics are gone")


def check(what, is_so):
    if not is_so:
        sys.exit(f"expected: {what}")


main()

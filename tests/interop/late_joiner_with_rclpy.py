#!/usr/bin/env python3
"""Joins late with rclpy and prints the stamps of what it gets of the past, one line for each topic.

Started by tests/ros/real_peers.rs with publishers in the domain of ROS_DOMAIN_ID, on loopback:

    late_joiner_with_rclpy.py

Prints the topic and the seconds of the stamps: `twin_status 500`, `impact_forecast 491 492 ...`.
"""

import sys
import time

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from column_twin_msgs.msg import ImpactReport, TwinStatus

PATIENCE = 30.0
# Time in which nothing more arrives.
QUIET = 1.0


def main():
    rclpy.init()
    node = rclpy.create_node("late_joiner")
    got = {"twin_status": [], "impact_forecast": []}
    last = time.monotonic()

    def receiver(topic):
        def receive(message):
            nonlocal last
            last = time.monotonic()
            got[topic].append(message.header.stamp.sec)

        return receive

    # Deeper than what the publishers offer.
    qos = QoSProfile(
        depth=5000, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
    )
    node.create_subscription(TwinStatus, "twin_status", receiver("twin_status"), qos)
    node.create_subscription(ImpactReport, "impact_forecast", receiver("impact_forecast"), qos)
    deadline = time.monotonic() + PATIENCE
    while not all(got.values()) or time.monotonic() - last < QUIET:
        if time.monotonic() > deadline:
            sys.exit(f"timeout: {got}")
        rclpy.spin_once(node, timeout_sec=0.05)
    for topic, stamps in got.items():
        print(topic, *stamps)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""A ROS 2 program (rclpy, Fast DDS) that receives a replayed recording.

Started by tests/evidence/replayed.rs in the domain of ROS_DOMAIN_ID, on loopback, before the replay begins:

    replay_with_rclpy.py EXPECTED.json

EXPECTED.json holds the rate, and of every message on /column_state when it was recorded, its stamp and its v1. All must come,
in order. Prints how much later than the earliest they came, by the time at which DDS received them. Exit code 1 with what
differs.
"""

import json
import sys
import time

import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy

from column_twin_msgs.msg import ColumnState

PATIENCE = 120.0


def main():
    with open(sys.argv[1]) as file:
        expected = json.load(file)
    rclpy.init()
    node = rclpy.create_node("replay_with_rclpy")
    received = []

    def take(message, info):
        received.append((info["received_timestamp"], message.header.stamp.sec * 10**9 + message.header.stamp.nanosec,
                         message.v1))

    # Deep enough for everything: at ten times its rate, a replay is faster than Python.
    qos = QoSProfile(depth=100_000, reliability=ReliabilityPolicy.RELIABLE)
    node.create_subscription(ColumnState, "/column_state", take, qos)
    deadline = time.monotonic() + PATIENCE
    wanted = len(expected["stamps"])
    while len(received) < wanted and time.monotonic() < deadline:
        rclpy.spin_once(node, timeout_sec=0.5)
    faults = []
    if len(received) != wanted:
        faults.append(f"expected {wanted} messages, received {len(received)}")
    if [it[1] for it in received] != expected["stamps"][:len(received)]:
        faults.append("the messages are out of order")
    if [it[2] for it in received] != expected["v1"][:len(received)]:
        faults.append("values of v1 differ")
    rate = expected["rate"]
    late = sorted(it[0] - time_recorded / rate for it, time_recorded in zip(received, expected["log_times"]))
    if late:
        after = [1e-6 * (it - late[0]) for it in late]
        print(f"rate {rate}: {len(received)} messages, latency relative to the earliest: {after[len(after) // 2]:.3f} ms median, "
              f"{after[int(0.99 * (len(after) - 1))]:.3f} ms 99th percentile, {after[-1]:.3f} ms maximum")
    for fault in faults:
        print(f"FAULT: {fault}")
    node.destroy_node()
    rclpy.shutdown()
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Receives streams of ColumnState and HingeForces with rclpy and prints when each message arrived.

Started by benches/live with its publishers in the domain of ROS_DOMAIN_ID, on loopback:

    stream_with_rclpy.py TOPIC...

Prints `ready` when every topic has a publisher, receives until a line comes on the standard input, and prints one line for
each message: number of the topic, its stamp, when it was given to the writer, when this program's own code had it, all by the
clock of the machine [ns].
"""

import sys
import threading
import time

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy

from column_twin_msgs.msg import ColumnState, HingeForces

PATIENCE = 30.0


def main():
    topics = sys.argv[1:]
    rclpy.init()
    node = rclpy.create_node("stream")
    arrivals = []

    def receiver(number):
        def receive(message, info):
            received = time.time_ns()
            stamp = message.header.stamp
            arrivals.append((number, stamp.sec * 10**9 + stamp.nanosec, info["source_timestamp"], received))
        return receive

    qos = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
    for number, topic in enumerate(topics):
        message = HingeForces if topic.endswith("forces") else ColumnState
        node.create_subscription(message, topic, receiver(number), qos)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    deadline = time.monotonic() + PATIENCE
    while not all(node.count_publishers(topic) for topic in topics):
        if time.monotonic() > deadline:
            sys.exit("timeout while waiting for publishers of " + ", ".join(topics))
        executor.spin_once(timeout_sec=0.05)
    print("ready", flush=True)
    ended = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.readline(), ended.set()), daemon=True).start()
    while not ended.is_set():
        executor.spin_once(timeout_sec=0.05)
    for arrival in arrivals:
        print(*arrival, sep=",")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()

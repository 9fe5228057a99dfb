#!/usr/bin/env python3
"""A node under use_sim_time follows /clock as rclpy publishes it.

Started by tests/ros/real_peers.rs with a running node in the domain of ROS_DOMAIN_ID, on loopback. Exit code 1 when the
node's status does not come to bear the clock's time.
"""

import sys
import time

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

from column_twin.msg import TwinStatus

PATIENCE = 30.0
SIMULATED = 12345


def main():
    rclpy.init()
    node = rclpy.create_node("bag_player")
    stamps = []
    latched = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(TwinStatus, "twin_status", lambda it: stamps.append(it.header.stamp.sec), latched)
    publisher = node.create_publisher(Clock, "/clock", QoSProfile(depth=1))
    clock = Clock()
    clock.clock.sec = SIMULATED
    deadline = time.monotonic() + PATIENCE
    while SIMULATED not in stamps and time.monotonic() < deadline:
        # The node's reader is best effort, so that one message would not do.
        publisher.publish(clock)
        rclpy.spin_once(node, timeout_sec=0.1)
    types = dict(node.get_topic_names_and_types())
    print("/clock:", types.get("/clock"), flush=True)
    node.destroy_node()
    rclpy.shutdown()
    if SIMULATED not in stamps:
        sys.exit(f"waited {PATIENCE} s in vain for a status of the time {SIMULATED}, found {sorted(set(stamps))}")
    if types.get("/clock") != ["rosgraph_msgs/msg/Clock"]:
        sys.exit(f"/clock has the types {types.get('/clock')}")


if __name__ == "__main__":
    main()

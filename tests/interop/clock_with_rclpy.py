#!/usr/bin/env python3
"""A node with use_sim_time follows /clock as played by rclpy: at any rate, the response equals that of the simulation.

Started by tests/ros/real_peers.rs with a running node in the domain of ROS_DOMAIN_ID, on loopback:

    clock_with_rclpy.py EXPECTED.json

Exit code 1 when the node's status does not come to bear the clock's time, or its stream differs from what is expected.
"""

import json
import sys
import time

import rclpy
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock

from node_with_rclpy import PATIENCE, Peer, check_response, end, event_of, faults

START = 12345 * 10**9
# Interval between clock messages, not a multiple of the sampling period: a bag is played faster than real time.
JUMP = 7_300_000


class Player:
    """Plays the clock until the condition holds."""

    def __init__(self, peer):
        self.peer, self.now = peer, START
        self.publisher = peer.node.create_publisher(Clock, "/clock", QoSProfile(depth=1))

    def play(self, what, jump, condition):
        deadline = time.monotonic() + PATIENCE
        clock = Clock()
        while not condition():
            if time.monotonic() > deadline:
                faults.append(f"timeout while waiting for {what}")
                return
            clock.clock.sec, clock.clock.nanosec = divmod(self.now, 10**9)
            # The node's reader is best effort, so a single message is not enough.
            self.publisher.publish(clock)
            self.peer.executor.spin_once(timeout_sec=0.01)
            self.now += jump


def main():
    expected = json.loads(open(sys.argv[1]).read())
    rclpy.init()
    peer = Peer()
    player = Player(peer)
    peer.meet()
    seconds = lambda: [it.header.stamp.sec for it in peer.seen["twin_status"]]
    player.play("a status of the clock's time", 0, lambda: START // 10**9 in seconds())
    types = dict(peer.node.get_topic_names_and_types()).get("/clock")
    if types != ["rosgraph_msgs/msg/Clock"]:
        faults.append(f"/clock has the types {types}")
    event, stamp = event_of(expected, "of the bag", START)
    peer.events.publish(event)
    # The clock is stopped: the forecast arrives nevertheless, and nothing after the first sample.
    player.play("the forecast", 0, lambda: peer.seen["impact_forecast"])
    player.play("the report", JUMP, lambda: peer.seen["impact_report"])
    check_response(peer, expected, "of the bag", stamp)
    end(peer)


if __name__ == "__main__":
    main()

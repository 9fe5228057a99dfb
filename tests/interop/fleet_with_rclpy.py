#!/usr/bin/env python3
"""Joins a fleet late with rclpy, and uses the parameters of one of its columns.

Started by tests/fleet/real_peers.rs with a fleet in the domain of ROS_DOMAIN_ID, on loopback:

    fleet_with_rclpy.py COLUMNS COLUMN

Prints how long it takes until the first `fleet_status` and until all COLUMNS are known, from the creation of the node on. It checks
that `COLUMN.top.load` can be listed, set and read back, and that a value out of range is rejected.
"""

import sys
import time

import rclpy
from rcl_interfaces.srv import ListParameters
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from column_twin_msgs.msg import FleetStatus

PATIENCE = 30.0
LOAD = 3.25e5


def main():
    columns, column = int(sys.argv[1]), sys.argv[2]
    rclpy.init()
    begun = time.monotonic()
    node = rclpy.create_node("late_joiner")
    known, first = set(), []

    def receive(message):
        first.append(time.monotonic() - begun)
        known.update(it.column_id for it in message.columns)

    qos = QoSProfile(
        depth=100, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
    )
    node.create_subscription(FleetStatus, "fleet_status", receive, qos)
    while len(known) < columns:
        if time.monotonic() - begun > PATIENCE:
            sys.exit(f"expected {columns} columns, found {len(known)}")
        rclpy.spin_once(node, timeout_sec=0.05)
    print(f"the first fleet_status after {first[0]:.3f} s, all {columns} columns after {time.monotonic() - begun:.3f} s")

    def result(future):
        rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE)
        if future.result() is None:
            sys.exit("expected an answer of a parameter service, found none")
        return future.result()

    client = AsyncParameterClient(node, "/column_twin")
    if not client.wait_for_services(timeout_sec=PATIENCE):
        sys.exit("expected the parameter services of /column_twin, found none")
    load = f"{column}.top.load"
    listed = result(client.list_parameters([column], ListParameters.Request.DEPTH_RECURSIVE)).result
    check(f"{load} is listed", load in listed.names)
    check("only the column is listed", all(it.startswith(f"{column}.") for it in listed.names))
    changed = result(client.set_parameters([Parameter(load, value=LOAD)])).results[0]
    check(f"it can be set: {changed.reason}", changed.successful)
    check("it reads back", result(client.get_parameters([load])).values[0].double_value == LOAD)
    rejected = result(client.set_parameters([Parameter(load, value=-1.0)])).results[0]
    check(f"a value out of range is rejected: {rejected.reason}", not rejected.successful)
    node.destroy_node()
    rclpy.shutdown()


def check(what, holds):
    if not holds:
        sys.exit(f"expected: {what}")
    print(what)


if __name__ == "__main__":
    main()

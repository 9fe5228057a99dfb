#!/usr/bin/env python3
"""Prints the action after every impact, and its reason, as soon as the forecast of the impact is known."""

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from column_twin_msgs.msg import ImpactReport

ACTIONS = {0: "none", 1: "inspect", 2: "restrict", 3: "shore", 4: "evacuate"}

# Reports are latched: a late subscriber receives the last ones.
LATCHED = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)

rclpy.init()
node = rclpy.create_node("print_verdicts")
node.create_subscription(
    ImpactReport, "impact_forecast",
    lambda report: print(f"{report.column_id}: {ACTIONS.get(report.action, 'not assessed')}: {report.action_reason}", flush=True), LATCHED)
rclpy.spin(node)

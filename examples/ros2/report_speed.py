#!/usr/bin/env python3
"""Reports a vehicle to the twin, as a speed camera in front of the column would: report_speed.py COLUMN_ID VEHICLE SPEED GAP

VEHICLE is a name of `column-twin vehicles`, SPEED is in m/s, and GAP is the distance to the column in m.
"""

import math
import sys
import uuid

import rclpy

from column_twin_msgs.msg import ImpactEvent

rclpy.init()
node = rclpy.create_node("report_speed")
events = node.create_publisher(ImpactEvent, "impact_event", 100)
while events.get_subscription_count() == 0:
    rclpy.spin_once(node, timeout_sec=0.1)
column_id, vehicle, speed, gap = sys.argv[1], sys.argv[2], float(sys.argv[3]), float(sys.argv[4])
# NaN: what the camera does not know has the value of the parameters.
event = ImpactEvent(column_id=column_id, event_id=str(uuid.uuid4()), vehicle=vehicle, velocity=speed, gap=gap, mass=math.nan,
                    restitution=math.nan, height=math.nan, direction=math.nan)
event.header.stamp = node.get_clock().now().to_msg()
events.publish(event)
events.wait_for_all_acked()

#!/usr/bin/env python3
"""Asks the twin what an impact would do to the column as it is now: predict.py NODE VEHICLE SPEED

NODE is the name of the node, /column_twin by default; VEHICLE is a name of `column-twin vehicles`; SPEED is in m/s.
"""

import math
import sys

import rclpy

from column_twin_msgs.srv import PredictImpact

rclpy.init()
node = rclpy.create_node("predict")
predict = node.create_client(PredictImpact, f"{sys.argv[1]}/predict")
predict.wait_for_service()
request = PredictImpact.Request(vehicle=sys.argv[2], velocity=float(sys.argv[3]), mass=math.nan, gap=math.nan,
                                restitution=math.nan, height=math.nan, direction=math.nan)
answer = predict.call_async(request)
rclpy.spin_until_future_complete(node, answer)
report = answer.result().report
print(f"{1e3 * report.max_v1:.1f} mm" if answer.result().success else answer.result().message)

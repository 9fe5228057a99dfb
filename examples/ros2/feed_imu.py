#!/usr/bin/env python3
"""Feeds the twin with an accelerometer, as its driver would: feed_imu.py TOPIC SECONDS

The parameters of the twin declare the sensor with `sensors.<name>.topic: TOPIC` and `sensors.<name>.message: imu`. This one is at
rest and sends noise; replace `read` by the driver of your sensor. The stamps are those of the sample clock: the instants at which
Python sends them would jitter by milliseconds.
"""

import random
import sys

import rclpy
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time

from sensor_msgs.msg import Imu

PERIOD = 1_000_000  # ns


def read():
    """The acceleration in the vehicle's direction [m/s^2]."""
    return random.gauss(0.0, 0.05)


rclpy.init()
node = rclpy.create_node("feed_imu")
samples = node.create_publisher(Imu, sys.argv[1], qos_profile_sensor_data)
due = node.get_clock().now().nanoseconds
end = due + int(float(sys.argv[2]) * 1e9)
while due < end:
    rclpy.spin_once(node, timeout_sec=0.005)
    while due <= node.get_clock().now().nanoseconds:
        imu = Imu()
        imu.header.stamp = Time(nanoseconds=due).to_msg()
        imu.linear_acceleration.x = read()
        samples.publish(imu)
        due += PERIOD

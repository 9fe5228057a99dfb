#!/usr/bin/env python3
"""Feeds the twin with an accelerometer, as its driver would: feed_imu.py TOPIC SECONDS

The parameters of the twin declare the sensor with `sensors.<name>.topic: TOPIC` and `sensors.<name>.message: imu`. This one is at
rest and sends noise; replace `read` by the driver of your sensor.
"""

import random
import sys

import rclpy
from rclpy.qos import qos_profile_sensor_data

from sensor_msgs.msg import Imu

RATE = 1000.0


def read():
    """The acceleration in the vehicle's direction [m/s^2]."""
    return random.gauss(0.0, 0.05)


def send():
    imu = Imu()
    imu.header.stamp = node.get_clock().now().to_msg()
    imu.linear_acceleration.x = read()
    samples.publish(imu)


rclpy.init()
node = rclpy.create_node("feed_imu")
samples = node.create_publisher(Imu, sys.argv[1], qos_profile_sensor_data)
node.create_timer(1.0 / RATE, send)
end = node.get_clock().now().nanoseconds + int(float(sys.argv[2]) * 1e9)
while node.get_clock().now().nanoseconds < end:
    rclpy.spin_once(node)

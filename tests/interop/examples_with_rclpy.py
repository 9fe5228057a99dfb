#!/usr/bin/env python3
"""Runs the examples of examples/ros2 against a node on loopback:

    examples_with_rclpy.py COLUMN_TWIN

COLUMN_TWIN is the program. Exit code 1 with what went wrong.
"""

import os
import signal
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
EXAMPLES = REPOSITORY / "examples/ros2"
PATIENCE = 60.0

SENSOR = """/**:
  ros__parameters:
    column_id: gate
    sensors:
      names: [top]
      top: {quantity: acceleration, height: 2.0, noise: 0.05, rate: 1000.0, topic: /imu, message: imu}
"""


class Process:
    """A program whose output is read line by line."""

    def __init__(self, line, environment, folder):
        self.line = [str(it) for it in line]
        self.process = subprocess.Popen(self.line, cwd=folder, env=environment, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True)
        self.watchdog = threading.Timer(PATIENCE, self.process.kill)
        self.watchdog.start()
        self.said = []

    def wait_for(self, text):
        for line in self.process.stdout:
            self.said.append(line)
            if text in line:
                return line
        raise SystemExit(f"{self.line} ended with {self.process.wait()} and did not say {text!r}:\n{''.join(self.said)}")

    def end(self, number=None):
        """Its exit code, after the signal if one is given."""
        if number is not None:
            self.process.send_signal(number)
        self.said += self.process.stdout.readlines()
        code = self.process.wait()
        self.watchdog.cancel()
        return code


def main():
    program = Path(sys.argv[1]).resolve()
    environment = {**os.environ, "ROS_DOMAIN_ID": str(100 + os.getpid() % 100), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
                   "PYTHONUNBUFFERED": "1"}
    with tempfile.TemporaryDirectory() as folder:
        environment["XDG_STATE_HOME"] = folder
        (Path(folder) / "sensor.yaml").write_text(SENSOR)
        start = lambda *line: Process(line, environment, folder)
        example = lambda name, *arguments: start(sys.executable, EXAMPLES / name, *arguments)
        node = start(program, "run", "--config", REPOSITORY / "config/heb220_s355.yaml", "--config", "sensor.yaml")
        node.wait_for("is ready in domain")

        predict = example("predict.py", "/column_twin", "suv", "10")
        shown = predict.wait_for(" mm")
        assert predict.end() == 0 and 30.0 < float(shown.split()[0]) < 50.0, shown

        verdicts = example("print_verdicts.py")
        camera = example("report_speed.py", "gate", "suv", "10", "0.5")
        assert camera.end() == 0, camera.said
        shown = verdicts.wait_for("gate: ")
        assert shown.startswith("gate: restrict: "), shown
        verdicts.end(signal.SIGINT)

        imu = example("feed_imu.py", "/imu", "6")
        watch = start(sys.executable, "-c", DIAGNOSTICS)
        watch.wait_for("sensors OK")
        watch.end(signal.SIGINT)
        assert imu.end() == 0, imu.said

        assert node.end(signal.SIGINT) == 0, node.said
        assert not any("ERROR" in line for line in node.said), node.said
    print("all examples do what they say")


# Says when the diagnostics report that all sensors send.
DIAGNOSTICS = """
import rclpy
from diagnostic_msgs.msg import DiagnosticArray

def receive(array):
    for status in array.status:
        if status.name.endswith("sensors") and status.message == "all sensors send":
            print("sensors OK", flush=True)

rclpy.init()
node = rclpy.create_node("watch_sensors")
node.create_subscription(DiagnosticArray, "/diagnostics", receive, 10)
rclpy.spin(node)
"""

if __name__ == "__main__":
    main()

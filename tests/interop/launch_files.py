#!/usr/bin/env python3
"""Tests the launch files without an installed ROS 2: loads them with stand-ins for `launch` and `launch_ros` and starts the nodes.

    launch_files.py COLUMN_TWIN

COLUMN_TWIN is the program. For every node of every launch file the command line is made that launch_ros makes, the program is
started with it on loopback in a domain of its own, must say that it is ready under its name, and must end well on SIGINT. With a
wrong parameter it must end by itself, and the launch file must not start it again.
Exit code 1 with what went wrong. What only an installed ROS 2 can show, that `ros2 launch` finds the file, it cannot show.
"""

import importlib.util
import os
import signal
import subprocess
import sys
import tempfile
import threading
import types
from pathlib import Path

import yaml

REPOSITORY = Path(__file__).resolve().parents[2]
PATIENCE = 30.0


class Substitution:
    """A text that is resolved when the launch runs."""

    def __init__(self, perform):
        self.perform = perform


def performed(value, context):
    if isinstance(value, Substitution):
        return value.perform(context)
    if isinstance(value, (list, tuple)):
        return "".join(performed(part, context) for part in value)
    return value


class DeclareLaunchArgument:
    def __init__(self, name, *, default_value, description):
        assert description, f"argument {name} has no description"
        self.name, self.default_value = name, default_value


class Shutdown:
    """The event that ends a launch."""

    def __init__(self, *, reason):
        assert reason


class Node:
    def __init__(self, *, package, executable, arguments, name, parameters, output, namespace="", ros_arguments=(),
                 respawn=False, respawn_delay=0.0, on_exit=None):
        assert (package, executable, output) == ("column_twin", "column-twin", "screen")
        self.arguments, self.name, self.namespace = arguments, name, namespace
        self.parameters, self.ros_arguments = parameters, ros_arguments
        self.respawn, self.on_exit = respawn, on_exit

    def ends(self, code):
        """Whether this exit code of the node ends the launch. A node that is not started again needs nothing of the kind."""
        event = types.SimpleNamespace(returncode=code)
        return not self.respawn or any(isinstance(it, Shutdown) for it in self.on_exit(event, None))

    def command(self, program, context, folder):
        """As launch_ros does: parameters given by value are written to files, with YAML types."""
        line = [program, *self.arguments, "--ros-args", "-r", f"__node:={performed(self.name, context)}"]
        namespace = performed(self.namespace, context)
        if namespace:
            line += ["-r", f"__ns:={namespace}"]
        for number, parameters in enumerate(self.parameters):
            if isinstance(parameters, dict):
                values = {name: yaml.safe_load(text) if isinstance(text := performed(value, context), str) and
                          isinstance(value, Substitution) else performed(value, context)
                          for name, value in parameters.items()}
                path = Path(folder) / f"launch_params_{number}.yaml"
                path.write_text(yaml.dump({"/**": {"ros__parameters": values}}))
                line += ["--params-file", str(path)]
            else:
                line += ["--params-file", performed(parameters, context)]
        return line + [performed(argument, context) for argument in self.ros_arguments]


def stand_ins():
    """The modules that launch files import."""
    def module(name, **content):
        sys.modules[name] = types.ModuleType(name)
        vars(sys.modules[name]).update(content)

    module("launch", LaunchDescription=list)
    module("launch.actions", DeclareLaunchArgument=DeclareLaunchArgument, EmitEvent=lambda *, event: event)
    module("launch.events", Shutdown=Shutdown)
    module("launch.substitutions",
           LaunchConfiguration=lambda name: Substitution(lambda context: context[name]),
           PathJoinSubstitution=lambda parts: Substitution(
               lambda context: "/".join(performed(part, context) for part in parts)))
    module("launch_ros")
    module("launch_ros.actions", Node=Node)
    module("launch_ros.substitutions", FindPackageShare=lambda _: Substitution(lambda _: str(REPOSITORY)))


def description_of(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    launch_file = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(launch_file)
    return launch_file.generate_launch_description()


def start(line, folder, domain):
    """Starts the node and stops it; returns a fault or nothing."""
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
                   "XDG_STATE_HOME": folder}
    process = subprocess.Popen(line, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    watchdog = threading.Timer(PATIENCE, process.kill)
    watchdog.start()
    said = []
    for text in process.stdout:
        said.append(text)
        if "is ready in domain" in text:
            process.send_signal(signal.SIGINT)
    code = process.wait()
    watchdog.cancel()
    if code != 0 or not any("is ready in domain" in text for text in said):
        return f"{line} ended with {code}:\n{''.join(said)}"
    print("ready and stopped:", " ".join(line[1:]))
    return None


def wrong_parameter(action, program, context, folder, domain):
    """Starts the node with a wrong parameter, as often as launch would; returns a fault or nothing."""
    wrong = Path(folder) / "wrong.yaml"
    wrong.write_text("/**:\n  ros__parameters:\n    top.load: -1.0\n")
    line = [*action.command(program, context, folder), "--params-file", str(wrong)]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
                   "XDG_STATE_HOME": folder}
    done = subprocess.run(line, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
                          timeout=PATIENCE)
    if "top.load" not in done.stdout or not action.ends(done.returncode):
        return f"{line}: expected one start that names top.load; after exit code {done.returncode} launch starts it again:\n{done.stdout}"
    print("not started again after", done.returncode)
    return None


def main():
    program = str(Path(sys.argv[1]).resolve())
    stand_ins()
    faults, domain = [], os.getpid() % 100
    for path in sorted(REPOSITORY.glob("launch/*.launch.py")):
        context, nodes = {}, 0
        for action in description_of(path):
            if isinstance(action, DeclareLaunchArgument):
                context[action.name] = performed(action.default_value, context)
                continue
            nodes += 1
            # The launch file once started a node with a wrong parameter again, every 2 s.
            if not action.ends(2) or action.respawn and action.ends(1):
                faults.append(f"{path.name}: respawn must stop after exit code 2 (bad input), and only then")
            with tempfile.TemporaryDirectory() as folder:
                found = [start(action.command(program, context, folder), folder, domain),
                         wrong_parameter(action, program, context, folder, domain)]
            faults += [f"{path.name}: {fault}" for fault in found if fault]
        if nodes == 0:
            faults.append(f"{path.name}: starts no node")
    print("\n".join(faults) or "all launch files start their nodes")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""A managed node as `ros2 lifecycle`, `ros2 node info` and `ros2 doctor` see it, beside a lifecycle node of rclpy: both must answer
alike. The tools themselves are not on PyPI; the functions of rclpy that they call are used here.

Started by tests/ros/real_peers.rs with a managed node in the domain of ROS_DOMAIN_ID, on loopback. On differences, the program
prints one line per fault and exits with code 1. It waits for conditions and never sleeps.
"""

import time

import rclpy
from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from node_with_rclpy import NODE, NODE_SERVICES, PATIENCE, SERVICES, TOPICS, check, check_that, end, faults

REFERENCE = "reference"
LIFECYCLE = {
    "change_state": ChangeState, "get_state": GetState, "get_available_states": GetAvailableStates,
    "get_available_transitions": GetAvailableTransitions, "get_transition_graph": GetAvailableTransitions,
}
INPUTS = ["/impact_event", "/column_parameters"]
OUTPUTS = TOPICS.keys() - set(INPUTS)


class Manager:
    def __init__(self):
        self.node = rclpy.create_node("manager")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.reference = LifecycleNode(REFERENCE)
        self.executor.add_node(self.reference)
        self.events = {NODE: [], REFERENCE: []}
        self.clients = {}
        for name, events in self.events.items():
            self.node.create_subscription(TransitionEvent, f"/{name}/transition_event", events.append, 10)
            for service, kind in LIFECYCLE.items():
                self.clients[name, service] = self.node.create_client(kind, f"/{name}/{service}")

    def until(self, what, condition):
        """Spins until the condition holds; adds a fault and returns False after a timeout."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > deadline:
                faults.append(f"timeout while waiting for {what}")
                return False
            self.executor.spin_once(timeout_sec=0.1)
        return True

    def call(self, name, service, request):
        client = self.clients[name, service]
        self.until(f"/{name}/{service}", client.service_is_ready)
        future = client.call_async(request)
        self.until(f"an answer of /{name}/{service}", future.done)
        return future.result()

    def seen(self, name):
        """All that the services of a node say of its state."""
        state = self.call(name, "get_state", GetState.Request()).current_state
        states = self.call(name, "get_available_states", GetAvailableStates.Request()).available_states
        transitions = [self.call(name, service, GetAvailableTransitions.Request()).available_transitions
                       for service in ["get_available_transitions", "get_transition_graph"]]
        return {
            "state": (state.id, state.label), "states": sorted((it.id, it.label) for it in states),
            "transitions": [sorted(described(it) for it in one) for one in transitions],
        }

    def change(self, name, transition):
        return self.call(name, "change_state", ChangeState.Request(transition=transition)).success


def described(it):
    return (it.transition.id, it.transition.label, it.start_state.id, it.start_state.label, it.goal_state.id, it.goal_state.label)


def graph(manager, is_configured):
    """What `ros2 node info` shows: publishers, subscriptions and services with their types."""
    node = manager.node
    # Its services may answer before it is in the graph, which makes rclpy raise an error.
    manager.until("the node in the graph", lambda: NODE in node.get_node_names())
    services = lambda: dict(node.get_service_names_and_types_by_node(NODE, "/"))
    expected = {f"/{NODE}/{name}": [f"lifecycle_msgs/srv/{kind.__name__}"] for name, kind in LIFECYCLE.items()}
    expected |= {name: [kind] for name, kind in NODE_SERVICES.items()}
    if is_configured:
        expected |= {name: [kind] for name, kind in SERVICES.items()}
    manager.until("all services", lambda: expected.keys() <= services().keys())
    check("services", services(), expected)
    publishers = lambda: dict(node.get_publisher_names_and_types_by_node(NODE, "/"))
    wanted = {name: [TOPICS[name]] for name in OUTPUTS} | {f"/{NODE}/transition_event": ["lifecycle_msgs/msg/TransitionEvent"]}
    manager.until("all publishers", lambda: wanted.keys() <= publishers().keys())
    found = publishers()
    check("publishers", {name: found.get(name) for name in wanted}, wanted)
    subscriptions = lambda: dict(node.get_subscriber_names_and_types_by_node(NODE, "/"))
    if is_configured:
        manager.until("all subscriptions", lambda: set(INPUTS) <= subscriptions().keys())
    check("subscriptions", {name: subscriptions().get(name) for name in INPUTS},
          {name: [TOPICS[name]] if is_configured else None for name in INPUTS})
    check("clients", node.get_client_names_and_types_by_node(NODE, "/"), [])
    # What `ros2 doctor` compares: every endpoint has a node, and publisher and subscription a compatible quality of service.
    infos = node.get_publishers_info_by_topic(f"/{NODE}/transition_event")
    check("publishers of the transitions", [(it.node_name, it.topic_type) for it in infos],
          [(NODE, "lifecycle_msgs/msg/TransitionEvent")])
    reference = node.get_publishers_info_by_topic(f"/{REFERENCE}/transition_event")
    qos = lambda infos: [(it.qos_profile.reliability, it.qos_profile.durability) for it in infos]
    check("their quality of service", qos(infos), qos(reference))
    check_that("it is reliable and volatile", qos(infos) == [(ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)])


def same(manager, when):
    own, reference = manager.seen(NODE), manager.seen(REFERENCE)
    for what in reference:
        check(f"{when}: {what}", own[what], reference[what])


def main():
    rclpy.init()
    manager = Manager()
    for name in manager.events:
        manager.until(f"the transitions of {name}", lambda: manager.node.count_publishers(f"/{name}/transition_event") > 0)
    same(manager, "at the start")
    graph(manager, False)
    made = 0
    by_id = lambda number: Transition(id=number)
    by_label = lambda label: Transition(label=label)
    for transition in [by_id(3), by_id(1), by_label("activate"), by_id(1), by_id(4), by_label("cleanup"), by_id(1), by_id(2),
                       by_id(200), by_label("no such transition"), by_id(10)]:
        what = f"{transition.id} {transition.label!r}"
        # rclpy raises an error in the node where rclcpp answers with false, so that it is only asked for what it has.
        possible = manager.seen(REFERENCE)["transitions"][0]
        is_possible = any(transition.label == it[1] if transition.label else transition.id == it[0] for it in possible)
        check(what, manager.change(NODE, transition), is_possible)
        if is_possible:
            check(f"{what} in rclpy", manager.change(REFERENCE, transition), True)
            made += 1
        same(manager, f"after {what}")
        if faults:
            break
    graph(manager, True)
    # Each transition has a begin and an end.
    manager.until("all transition events", lambda: all(len(it) >= 2 * made for it in manager.events.values()))
    goals = lambda name: [(it.start_state.label, it.goal_state.label) for it in manager.events[name]]
    check("transition events", goals(NODE), goals(REFERENCE))
    check("shutdown", manager.change(NODE, by_label("shutdown")), True)
    manager.reference.destroy_node()
    end(manager)


if __name__ == "__main__":
    main()

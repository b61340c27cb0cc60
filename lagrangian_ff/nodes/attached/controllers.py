"""Asks a controller which joints it moves."""

import time

from rcl_interfaces.srv import GetParameters
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python

PARAMETER = "joints"
"""That of ros2_control's controllers."""
FINDING = 1.0  # s until its services are found
ANSWERING = 2.0  # s until it answers
LOOK = 0.02  # s between looks


def joints_parameter(node: Node, name: str) -> list[str]:
    """Return the joints that a node has as a parameter; none if it has none or does not answer.

    Args:
        node: asks; an executor spins it in another thread.
        name: the full name of the other node.
    """
    client = node.create_client(GetParameters, f"{name}/get_parameters")
    try:
        if not client.wait_for_service(FINDING):
            return []
        future = client.call_async(GetParameters.Request(names=[PARAMETER]))
        end = time.monotonic() + ANSWERING
        while not future.done() and time.monotonic() < end:
            time.sleep(LOOK)
        answer = future.result() if future.done() else None
        values = [] if answer is None else [parameter_value_to_python(v) for v in answer.values]
        return [str(joint) for value in values if isinstance(value, list) for joint in value]
    finally:
        node.destroy_client(client)

"""A ROS graph for the demo alone: on this machine only, in a domain that nobody uses."""

import os
import random
import time
from collections.abc import Iterator
from contextlib import contextmanager

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

from lagrangian_ff.demo.errors import DemoError

DOMAINS = range(1, 102)  # above, DDS's ports may meet those that Linux gives out
LISTEN = 0.8  # s in which the nodes of a domain make themselves known
TRIES = 8
LOCAL = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_STATIC_PEERS": ""}


@contextmanager
def own_graph(domain: int | None) -> Iterator[tuple[Context, int]]:
    """A context in a domain of its own, and the number of that domain.

    Args:
        domain: the domain to use; None looks for one without nodes.

    Raises:
        DemoError: nodes were met in all the domains that were tried.
    """
    before = {name: os.environ.get(name) for name in LOCAL}
    os.environ.update(LOCAL)
    try:
        context, domain = (_join(domain), domain) if domain is not None else _find()
        try:
            yield context, domain
        finally:
            context.try_shutdown()
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _join(domain: int) -> Context:
    context = Context()
    # Ctrl-C must reach the demo as KeyboardInterrupt, so that it ends its nodes.
    rclpy.init(
        args=[], context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
    )
    return context


def _find() -> tuple[Context, int]:
    for domain in random.SystemRandom().sample(DOMAINS, TRIES):
        context = _join(domain)
        node = rclpy.create_node("lagrangian_ff_demo_scout", context=context)
        time.sleep(LISTEN)
        others = [name for name in node.get_node_names() if name != node.get_name()]
        node.destroy_node()
        if not others:
            return context, domain
        context.try_shutdown()
    raise DemoError(f"{TRIES} ROS domains were tried and all have nodes; give one with --domain")

"""Subscriptions that are read when it suits the reader, past the executor.

rclpy's executor builds its wait set anew for every message: 0.3 ms at 500 Hz beside a node's
services, a sixth of a core. A paced loop that takes what has come costs a few µs a message, and
finds the newest command at the very tick that uses it.
"""

from collections.abc import Iterator
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile

from lagrangian_ff.nodes.common.qos import overridable


class _NotForTheExecutor(CallbackGroup):
    """Keeps its entities out of every wait set."""

    def can_execute(self, entity: object) -> bool:
        return False

    def beginning_execution(self, entity: object) -> bool:
        return False

    def ending_execution(self, entity: object) -> None:
        pass


class PolledSubscription:
    """A subscription to read from any one thread.

    Args:
        node: its owner.
        kind: message type.
        topic: may be relative or private.
        profile: its depth bounds what can wait to be read.
        raw: whether messages are left serialised.
    """

    def __init__(
        self, node: Node, kind: type, topic: str, profile: QoSProfile, *, raw: bool = False
    ) -> None:
        self._node = node
        # The node keeps only a weak reference to the group.
        self._group = _NotForTheExecutor()
        self._subscription = node.create_subscription(
            kind,
            topic,
            lambda message: None,
            profile,
            callback_group=self._group,
            raw=raw,
            qos_overriding_options=overridable(),
        )

        self._waiting = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, node.context.handle)

    @property
    def topic(self) -> str:
        """The full name of the topic."""
        return str(self._subscription.topic_name)

    def wait(self, seconds: float) -> None:
        """Return as soon as there is something to take, or after this time."""
        handle = self._subscription.handle
        try:
            with handle:
                self._waiting.clear_entities()
                self._waiting.add_subscription(handle)
                self._waiting.wait(round(seconds * 1e9))
        except InvalidHandle:  # destroyed
            return

    def take(self) -> Iterator[tuple[Any, int]]:
        """What has come since the last call, oldest first, with the ns it was received at."""
        handle = self._subscription.handle
        while True:
            try:
                with handle:
                    found = handle.take_message(self._subscription.msg_type, self._subscription.raw)
            except InvalidHandle:  # destroyed
                return
            if found is None:
                return
            message, information = found
            yield message, int(information["received_timestamp"])

    def destroy(self) -> None:
        """Unsubscribe."""
        self._node.destroy_subscription(self._subscription)

"""Parameters with a description, a range or choices, refused with a reason."""

from collections.abc import Callable, Sequence
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter


class Parameters:
    """The declared parameters of a node.

    Args:
        node: whose parameters they are.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._choices: dict[str, tuple[str, ...]] = {}
        self._declaring = False
        node.add_on_set_parameters_callback(self._check)

    def watch(self, changed: Callable[[], None]) -> None:
        """Call this now, and whenever parameters were set at run time."""

        def after(parameters: list[Parameter]) -> None:
            if not self._declaring:
                changed()

        self._node.add_post_set_parameters_callback(after)
        changed()

    def declare(
        self,
        name: str,
        default: Any,
        description: str,
        *,
        low: float | None = None,
        high: float | None = None,
        choices: Sequence[str] = (),
        read_only: bool = False,
    ) -> Any:
        """Declare a parameter and return its value.

        Args:
            name: snake_case, nested with dots.
            default: its type is the type of the parameter.
            description: what it does, with the unit.
            low: smallest value; needs `high`.
            high: largest value; needs `low`.
            choices: the only texts allowed.
            read_only: can be set at the start only.

        Raises:
            InvalidParameterValueException, InvalidParameterTypeException: of rclpy; the value
                given at the start is not allowed. `run` tells the user.
        """
        if self._node.has_parameter(name):
            return self.value(name)
        descriptor = ParameterDescriptor(description=description, read_only=read_only)
        if low is not None and high is not None:
            if isinstance(default, int):
                descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
            else:
                descriptor.floating_point_range = [
                    FloatingPointRange(from_value=float(low), to_value=float(high))
                ]
        if choices:
            descriptor.additional_constraints = f"one of: {', '.join(choices)}"
            # YAML reads an unquoted `true` as a boolean; it still names the choice.
            descriptor.dynamic_typing = "true" in choices
            self._choices[name] = tuple(choices)
        self._declaring = True
        try:
            return self._plain(name, self._node.declare_parameter(name, default, descriptor).value)
        finally:
            self._declaring = False

    def value(self, name: str) -> Any:
        """The present value."""
        return self._plain(name, self._node.get_parameter(name).value)

    def _plain(self, name: str, value: Any) -> Any:
        return str(value).lower() if name in self._choices else value

    def strings(self, name: str) -> tuple[str, ...]:
        """The present value of a list of texts, without empty ones.

        ROS cannot tell the type of an empty list, so [""] stands for it.
        """
        return tuple(text for text in self.value(name) if text)

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            allowed = self._choices.get(parameter.name)
            value = self._plain(parameter.name, parameter.value)
            if allowed is not None and value not in allowed:
                return SetParametersResult(
                    successful=False,
                    reason=f"{parameter.name} is {value!r}; expected one of {', '.join(allowed)}",
                )
        return SetParametersResult(successful=True)

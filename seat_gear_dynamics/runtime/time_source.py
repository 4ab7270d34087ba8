"""Simulated time: the `use_sim_time` parameter and the /clock subscription behind it."""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.runtime.messages import get_message
from seat_gear_dynamics.runtime.parameters.parameter import Parameter, ParameterType
from seat_gear_dynamics.runtime.qos import QoSProfile, ReliabilityPolicy
from seat_gear_dynamics.runtime.time import Time

if TYPE_CHECKING:
    from seat_gear_dynamics.runtime.clock import ROSClock
    from seat_gear_dynamics.runtime.endpoints import Subscription
    from seat_gear_dynamics.runtime.node import Node

CLOCK_TOPIC = "/clock"
USE_SIM_TIME_NAME = "use_sim_time"


class TimeSource:
    """Sets a node's clock from /clock while its parameter `use_sim_time` is true."""

    def __init__(self, node: Node, clock: ROSClock) -> None:
        self._node = weakref.ref(node)
        self._clock = clock
        self._subscription: Subscription | None = None
        if not node.has_parameter(USE_SIM_TIME_NAME):
            node.declare_parameter(USE_SIM_TIME_NAME, False)
        parameter = node.get_parameter_or(USE_SIM_TIME_NAME)
        if parameter.type_ is ParameterType.BOOL:
            self._activate(parameter.value)
        node.add_on_set_parameters_callback(self._on_set)

    def _on_set(self, parameters: list[Parameter]) -> Any:
        result = get_message("rcl_interfaces/msg/SetParametersResult")(successful=True)
        for parameter in parameters:
            if parameter.name != USE_SIM_TIME_NAME:
                continue
            if parameter.type_ is ParameterType.BOOL:
                self._activate(parameter.value)
            else:
                result.successful = False
                result.reason = f"{USE_SIM_TIME_NAME} parameter set to something besides a bool"
        return result

    def _activate(self, enabled: bool) -> None:
        node = self._node()
        if node is None or enabled == self._clock.ros_time_is_active:
            return
        self._clock._set_ros_time_is_active(enabled)
        if enabled:
            self._subscription = node.create_subscription(
                get_message("rosgraph_msgs/msg/Clock"),
                CLOCK_TOPIC,
                self._on_clock,
                QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT),
            )
        elif self._subscription is not None:
            node.destroy_subscription(self._subscription)
            self._subscription = None

    def _on_clock(self, message: Any) -> None:
        self._clock.set_ros_time_override(Time.from_msg(message.clock))

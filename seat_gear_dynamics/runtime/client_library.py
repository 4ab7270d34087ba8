"""The functions of the `rclpy` module: init, shutdown, spin and their kin."""

from __future__ import annotations

from typing import Any

from seat_gear_dynamics.runtime import signals
from seat_gear_dynamics.runtime.arguments import without_ros_arguments
from seat_gear_dynamics.runtime.context import Context, get_default_context, shutdown_context
from seat_gear_dynamics.runtime.executor import Executor, SingleThreadedExecutor
from seat_gear_dynamics.runtime.node import Node
from seat_gear_dynamics.runtime.parameters.parameter import Parameter
from seat_gear_dynamics.runtime.signals import SignalHandlerOptions
from seat_gear_dynamics.runtime.tasks import Future

_global: dict[str, Executor] = {}


def init(
    *,
    args: list[str] | None = None,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
) -> None:
    """Start a context (the default one) with command line arguments, `sys.argv` without any.

    The default context takes over SIGINT and SIGTERM unless the options say otherwise.

    Raises:
        RuntimeError: it was started before, or an argument or the domain id is wrong.
    """
    default = get_default_context()
    context = default if context is None else context
    if signal_handler_options is None:
        signal_handler_options = SignalHandlerOptions.ALL if context is default else SignalHandlerOptions.NO
    context.init(args, domain_id=domain_id)
    signals.install_signal_handlers(signal_handler_options)


def shutdown(*, context: Context | None = None, uninstall_handlers: bool | None = None) -> None:
    """Shut a context (the default one) down; for that one the signals are given back.

    Raises:
        RuntimeError: it was not started, or was shut down before; `try_shutdown` accepts that.
    """
    is_default = context is None or context is get_default_context()
    try:
        shutdown_context(context=context)
    finally:
        if uninstall_handlers or (uninstall_handlers is None and is_default):
            signals.uninstall_signal_handlers()


def create_node(
    node_name: str,
    *,
    context: Context | None = None,
    cli_args: list[str] | None = None,
    namespace: str | None = None,
    use_global_arguments: bool = True,
    enable_rosout: bool = True,
    start_parameter_services: bool = True,
    parameter_overrides: list[Parameter] | None = None,
    allow_undeclared_parameters: bool = False,
    automatically_declare_parameters_from_overrides: bool = False,
    enable_logger_service: bool = False,
) -> Node:
    """Return a new node; see `Node`."""
    return Node(
        node_name,
        context=context,
        cli_args=cli_args,
        namespace=namespace,
        use_global_arguments=use_global_arguments,
        enable_rosout=enable_rosout,
        start_parameter_services=start_parameter_services,
        parameter_overrides=parameter_overrides,
        allow_undeclared_parameters=allow_undeclared_parameters,
        automatically_declare_parameters_from_overrides=automatically_declare_parameters_from_overrides,
        enable_logger_service=enable_logger_service,
    )


def get_global_executor() -> Executor:
    """Return the executor the spin functions use where none is given."""
    executor = _global.get("executor")
    if executor is None:
        executor = _global["executor"] = SingleThreadedExecutor()

        def forget() -> None:
            _global.pop("executor").shutdown()

        executor.context.on_shutdown(forget)
    elif not executor.context.ok() and executor.context is not get_default_context():
        # A signal ended the context without telling; a program that starts again gets a new executor.
        del _global["executor"]
        return get_global_executor()
    return executor


def spin(node: Node, executor: Executor | None = None) -> None:
    """Run a node's callbacks until the context is shut down.

    Raises:
        ExternalShutdownException: it was shut down by SIGTERM, or in another thread without `shutdown`.
        KeyboardInterrupt: on SIGINT.
    """
    executor = get_global_executor() if executor is None else executor
    try:
        executor.add_node(node)
        while executor.context.ok():
            executor.spin_once()
    finally:
        executor.remove_node(node)


def spin_once(node: Node, *, executor: Executor | None = None, timeout_sec: float | None = None) -> None:
    """Run one callback, waiting for it up to a time in seconds (for ever if None or negative)."""
    executor = get_global_executor() if executor is None else executor
    try:
        executor.add_node(node)
        executor.spin_once(timeout_sec=timeout_sec)
    finally:
        executor.remove_node(node)


def spin_until_future_complete(
    node: Node, future: Future, executor: Executor | None = None, timeout_sec: float | None = None
) -> None:
    """Run a node's callbacks until a future has its result, or a time in seconds is over."""
    executor = get_global_executor() if executor is None else executor
    added = executor.add_node(node)
    try:
        executor.spin_until_future_complete(future, timeout_sec)
    finally:
        if added:
            executor.remove_node(node)


def remove_ros_args(args: list[str] | None = None) -> list[str]:
    """Return the arguments (`sys.argv` without any) that are not for ROS."""
    import sys

    return without_ros_arguments(sys.argv if args is None else args)


def serialize_message(message: Any) -> bytes:
    """Return a message's CDR bytes with the 4-byte header.

    Raises:
        TypeError: it is not a message, or a field holds a wrong value.
    """
    from seat_gear_dynamics.runtime.messages import check_message_class, encoder

    cls: Any = type(message)
    check_message_class(cls)
    return encoder(cls)(message)


def deserialize_message(serialized_message: bytes, message_type: Any) -> Any:
    """Return the message of a type that CDR bytes with the 4-byte header hold.

    Raises:
        TypeError: the type is not a message class.
        ValueError: the bytes are not such a message.
    """
    from seat_gear_dynamics.runtime.messages import check_message_class, decoder

    check_message_class(message_type)
    return decoder(message_type)(bytes(serialized_message))

"""Running nodes as a process: arguments in, clean end on SIGINT and SIGTERM, an exit code out."""

import gc
import signal
import sys
from collections.abc import Callable, Iterable, Sequence

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node


class StartError(RuntimeError):
    """A node that cannot start; its text is one sentence for the person who started it."""


def run(make: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """Make a node, spin it until it is told to end, close it, and return 0, or 1 when it could not start.

    A node may have a method `close`, which is called once, also after an error.
    """
    return run_together([make], args)


def run_together(makes: Iterable[Callable[[], Node]], args: Sequence[str] | None = None) -> int:
    """Run several nodes in this process as `run` does one: one executor, made and closed in their order."""
    nodes: list[Node] = []
    told: list[int] = []
    # rclpy shuts its context down on SIGINT as on SIGTERM and then calls the handler that was there before. Python's
    # would raise KeyboardInterrupt at any line, also amid a compilation or a write to the log, or end the process; this
    # one lets that line finish, and the end comes through the context alone. It stands again once rclpy has gone.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, frame: told.append(number))
    try:
        _begin(args)
        if told:  # before rclpy listened
            return 0
        executor = SingleThreadedExecutor()  # before the nodes speak: rclpy cannot make one amid a shutdown
        for make in makes:
            nodes.append(_made(make))
            executor.add_node(nodes[-1])
        _spare_the_collector()
        _spin(executor, nodes)
    except ExternalShutdownException:
        pass
    except StartError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except Exception:
        # The context may go amid a callback, whose next publish then fails: that is the end that was asked for.
        # Anything raised while the context stands is a fault.
        if rclpy.ok():
            raise
    finally:
        for node in nodes:
            close = getattr(type(node), "close", None)
            if close is not None:
                close(node)
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
        # Only the interpreter's own end is left, in which Python handlers are gone: a second signal, as launch files
        # send it, would make a clean end look like a killed process.
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
    return 0


def _begin(args: Sequence[str] | None) -> None:
    """Start ROS 2; what it refuses (arguments, security that cannot be had) is a sentence."""
    try:
        rclpy.init(args=list(args) if args is not None else None)
    except Exception as error:
        raise StartError(f"ROS 2 does not start: {error}") from error


def _made(make: Callable[[], Node]) -> Node:
    """Make a node; what the client library refuses, such as a network or security that cannot be had, is a sentence."""
    try:
        return make()
    except RuntimeError as error:
        # By name: rclpy keeps RCLError in a private module, the bundled runtime in its own.
        if type(error).__name__ != "RCLError" or not rclpy.ok():
            raise
        raise StartError(f"the node cannot be made: {error}") from error


def _spin(executor: SingleThreadedExecutor, nodes: Sequence[Node]) -> None:
    while rclpy.ok():
        try:
            executor.spin_once()
        except RuntimeError as error:
            # rclpy 7.1 raises out of the executor where anybody asks a managed node for a transition that it does not
            # have now: a request is no reason to end a node that watches a drive.
            if "Transition is not registered" not in str(error):
                raise
            nodes[0].get_logger().warning(f"a transition that is not possible now was asked for: {error}")


def _spare_the_collector() -> None:
    """Take what was made so far out of Python's garbage collection, whose full rounds would hold samples up."""
    gc.collect()
    gc.freeze()

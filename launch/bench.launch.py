"""The bench as a launch file: the managed monitor, and a recorder and a simulator where asked for.

The monitor is led through its transitions by events: configured when its process starts, activated once it is
configured; one that cannot be configured ends the launch. With `respawn` it leads itself: after a crash the services of
the process that died are still known for some seconds, and an event's request would go to them and be lost.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, LogInfo, RegisterEventHandler
from launch.conditions import IfCondition, UnlessCondition
from launch.event_handlers import OnProcessStart
from launch.events import Shutdown, matches_action
from launch.substitutions import AndSubstitution, EqualsSubstitution, LaunchConfiguration, NotSubstitution
from launch_ros.actions import LifecycleNode, Node
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from launch_ros.parameter_descriptions import ParameterValue
from lifecycle_msgs.msg import Transition

PACKAGE = "seat_gear_dynamics"
_RESPAWN_DELAY = 1.0  # s; launch takes it as a number only
ARGUMENTS = {
    "record": ("true", "record a log"),
    "simulate": ("true", "play a simulated bench on the inputs"),
    "system": ("", "system description (YAML file)"),
    "map": ("", "regime map whose bands follow the load; packaged: the packaged machine's"),
    "output": ("", "directory of the log, must not exist"),
    "profile": ("up-down", "what the simulated bench plays"),
    "input": ("topics", "topics, or joint_states"),
    "namespace": ("", "namespace of all nodes and topics"),
    "autostart": ("true", "configure and activate the monitor; false: leave it unconfigured"),
    "respawn": ("false", "start a node again that ends by itself"),
    "use_sim_time": ("false", "take the time from /clock"),
    "diagnostics": ("", "file of diagnostic_aggregator, such as config/diagnostics_aggregator.yaml; empty: none"),
}
"""Name → default and meaning."""


def generate_launch_description() -> LaunchDescription:
    """Return the description with ARGUMENTS."""
    declared = [DeclareLaunchArgument(n, default_value=d, description=text) for n, (d, text) in ARGUMENTS.items()]
    monitor = _monitor()
    recorder = _node("recorder", "bench_recorder", "record", "system", "output")
    simulator = _node("simulator", "bench_simulator", "simulate", "profile")
    aggregator = Node(
        package="diagnostic_aggregator",
        executable="aggregator_node",
        parameters=[LaunchConfiguration("diagnostics")],
        condition=UnlessCondition(EqualsSubstitution(LaunchConfiguration("diagnostics"), "")),
    )
    # The handlers come before the process whose start they wait for.
    return LaunchDescription([*declared, *_transitions(monitor), recorder, monitor, simulator, aggregator])


def _monitor() -> LifecycleNode:
    return LifecycleNode(
        package=PACKAGE,
        executable="monitor",
        name="gear_monitor",
        namespace=LaunchConfiguration("namespace"),
        parameters=[
            {**_parameters("system", "map", "input"), "autostart": ParameterValue(_by_itself(), value_type=bool)}
        ],
        **_respawning(),
    )


def _node(executable: str, name: str, wanted: str, *parameters: str) -> Node:
    return Node(
        package=PACKAGE,
        executable=executable,
        name=name,
        namespace=LaunchConfiguration("namespace"),
        parameters=[_parameters(*parameters)],
        condition=IfCondition(LaunchConfiguration(wanted)),
        **_respawning(),
    )


def _transitions(monitor: LifecycleNode) -> list[RegisterEventHandler]:
    configured = OnStateTransition(
        target_lifecycle_node=monitor,
        start_state="configuring",
        goal_state="inactive",
        entities=[_change(monitor, Transition.TRANSITION_ACTIVATE)],
    )
    reason = "the monitor could not be configured; what it said stands above"
    refused = OnStateTransition(
        target_lifecycle_node=monitor,
        start_state="configuring",
        goal_state="unconfigured",
        entities=[LogInfo(msg=reason), EmitEvent(event=Shutdown(reason=reason))],
    )
    started = OnProcessStart(target_action=monitor, on_start=[_change(monitor, Transition.TRANSITION_CONFIGURE)])
    respawn = LaunchConfiguration("respawn")
    wanted = IfCondition(AndSubstitution(LaunchConfiguration("autostart"), NotSubstitution(respawn)))
    return [RegisterEventHandler(handler, condition=wanted) for handler in (started, configured, refused)]


def _by_itself() -> AndSubstitution:
    return AndSubstitution(LaunchConfiguration("autostart"), LaunchConfiguration("respawn"))


def _change(monitor: LifecycleNode, transition: int) -> EmitEvent:
    return EmitEvent(event=ChangeState(lifecycle_node_matcher=matches_action(monitor), transition_id=transition))


def _parameters(*names: str) -> dict[str, ParameterValue]:
    texts = {name: ParameterValue(LaunchConfiguration(name), value_type=str) for name in names}
    return {**texts, "use_sim_time": ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)}


def _respawning() -> dict[str, object]:
    return {"respawn": LaunchConfiguration("respawn"), "respawn_delay": _RESPAWN_DELAY}

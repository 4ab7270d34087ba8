"""The bench as a launch file: the monitor, and a recorder and a simulator where asked for."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

PACKAGE = "seat_gear_dynamics"


def generate_launch_description() -> LaunchDescription:
    """Return the description; arguments record, simulate, system, output, profile and input."""
    arguments = [
        DeclareLaunchArgument("record", default_value="true", description="record a log"),
        DeclareLaunchArgument("simulate", default_value="true", description="play a simulated bench on the inputs"),
        DeclareLaunchArgument("system", default_value="", description="system description (YAML file)"),
        DeclareLaunchArgument("output", default_value="", description="directory of the log, must not exist"),
        DeclareLaunchArgument("profile", default_value="up-down", description="what the simulated bench plays"),
        DeclareLaunchArgument("input", default_value="topics", description="topics, or joint_states"),
    ]

    def text(name: str) -> ParameterValue:
        return ParameterValue(LaunchConfiguration(name), value_type=str)

    monitor = Node(
        package=PACKAGE, executable="monitor", parameters=[{"system": text("system"), "input": text("input")}]
    )
    recorder = Node(
        package=PACKAGE,
        executable="recorder",
        parameters=[{"system": text("system"), "output": text("output")}],
        condition=IfCondition(LaunchConfiguration("record")),
    )
    simulator = Node(
        package=PACKAGE,
        executable="simulator",
        parameters=[{"profile": text("profile")}],
        condition=IfCondition(LaunchConfiguration("simulate")),
    )
    return LaunchDescription([*arguments, recorder, monitor, simulator])

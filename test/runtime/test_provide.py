"""Which rclpy a program gets, and what happens with names the bundled one lacks."""

from __future__ import annotations

import pytest
from programs import PREAMBLE, Run


def ask(run: Run, text: str, **environment: str) -> list[str]:
    program = run(text, **environment)
    program.wait()
    return program.lines


def test_bundled_when_forced_and_idempotent(run: Run) -> None:
    lines = ask(
        run,
        """
        from seat_gear_dynamics.runtime import STAND_IN, provide_rclpy
        import sys
        print(provide_rclpy(), provide_rclpy(), sys.path.count(STAND_IN), sys.path[0] == STAND_IN)
        import rclpy
        print(provide_rclpy(), rclpy.__file__.startswith(STAND_IN), "cyclonedds" in sys.modules)
        """,
    )
    assert lines == ["bundled bundled 1 True", "bundled True False"]


def test_real_rclpy_is_preferred_where_it_is(run: Run, tmp_path: object) -> None:
    lines = ask(
        run,
        f"""
        import pathlib, sys
        folder = pathlib.Path({str(tmp_path)!r})
        (folder / "rclpy").mkdir()
        (folder / "rclpy" / "__init__.py").write_text("real = True")
        sys.path.insert(0, str(folder))
        from seat_gear_dynamics.runtime import provide_rclpy
        print(provide_rclpy())
        import rclpy
        print(rclpy.real)
        """,
        SEAT_GEAR_RUNTIME="",
    )
    assert lines == ["rclpy", "True"]


@pytest.mark.parametrize(
    ("value", "says"),
    [("other", "expected 'rclpy' or 'bundled'"), ("rclpy", "source a ROS 2 Jazzy installation")],
)
def test_wrong_choice_is_a_sentence(run: Run, value: str, says: str) -> None:
    text = """
    import sys
    sys.path[:] = [entry for entry in sys.path if "ros" not in entry]
    from seat_gear_dynamics.runtime import provide_rclpy
    provide_rclpy()
    """
    assert says in ask(run, text, SEAT_GEAR_RUNTIME=value)[-1]


@pytest.mark.parametrize(
    ("statement", "error"),
    [
        ("import rclpy.action", "ModuleNotFoundError: rclpy.action is not part of the bundled runtime"),
        ("from rclpy import action", "ImportError: rclpy.action is not part of the bundled runtime"),
        ("from rclpy.qos import Nothing", "ImportError: rclpy.qos.Nothing is not part of the bundled"),
        ("rclpy.get_rmw_implementation_identifier()", "AttributeError: rclpy.get_rmw_implementation_identifier"),
        ("from rclpy.executors import MultiThreadedExecutor as M; M()", "or use SingleThreadedExecutor."),
        ("from std_msgs.msg import Nothing", "ImportError"),
        ("Node.__getattr__(Node.__new__(Node), 'add_waitable')", "rclpy.node.Node.add_waitable is not part"),
    ],
)
def test_missing_names_are_sentences(run: Run, statement: str, error: str) -> None:
    lines = ask(run, PREAMBLE + statement + "\n")
    assert error in lines[-1]


def test_unsupported_options_are_sentences(run: Run) -> None:
    lines = ask(
        run,
        PREAMBLE
        + """
rclpy.init()
for options in ({"enable_logger_service": True},):
    try:
        Node("a", **options)
    except NotImplementedError as error:
        print(error)
try:
    Node("b").create_publisher(Float64, "x", 1, qos_overriding_options=object())
except NotImplementedError as error:
    print(error)
""",
    )
    assert len(lines) == 2
    for line in lines:
        assert "is not part of the bundled runtime; source a ROS 2 Jazzy installation to use it, or use" in line

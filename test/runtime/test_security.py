"""Security settings of ROS 2 on the bundled runtime: never insecure where security is demanded."""

from __future__ import annotations

import pytest
from programs import PREAMBLE, Run

from seat_gear_dynamics.runtime.context import Context
from seat_gear_dynamics.runtime.exceptions import RCLError
from seat_gear_dynamics.runtime.node import Node
from seat_gear_dynamics.runtime.security import insecurity

TALKER = (
    PREAMBLE
    + """
rclpy.init()
node = Node("talker")
print("running")
"""
)


@pytest.mark.parametrize("off", ["", "0", "false", "False", "no", "off"])
def test_without_security_nothing_is_said(off: str) -> None:
    assert insecurity({}) is None
    assert insecurity({"ROS_SECURITY_ENABLE": off, "ROS_SECURITY_STRATEGY": "Enforce"}) is None


@pytest.mark.parametrize("strategy", [{}, {"ROS_SECURITY_STRATEGY": ""}, {"ROS_SECURITY_STRATEGY": "Permissive"}])
def test_the_permissive_strategy_runs_with_a_warning(strategy: dict[str, str]) -> None:
    warning = insecurity({"ROS_SECURITY_ENABLE": "true", **strategy})
    assert warning is not None
    assert "WITHOUT security" in warning


def test_the_enforcing_strategy_is_refused() -> None:
    with pytest.raises(RCLError, match="ROS_SECURITY_STRATEGY is Enforce, and the bundled runtime cannot obey"):
        insecurity({"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce"})


@pytest.mark.parametrize("word", ["True", "TRUE", "1", "yes", "on", " true"])
def test_a_word_that_ros_would_silently_take_for_no_is_refused(word: str) -> None:
    with pytest.raises(RCLError, match=f"ROS_SECURITY_ENABLE is '{word}', expected true or false"):
        insecurity({"ROS_SECURITY_ENABLE": word})


@pytest.mark.parametrize("word", ["enforce", "ENFORCE", "strict"])
def test_a_word_that_ros_would_silently_take_for_permissive_is_refused(word: str) -> None:
    with pytest.raises(RCLError, match=f"ROS_SECURITY_STRATEGY is '{word}', expected Enforce or Permissive"):
        insecurity({"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": word})


def test_no_participant_comes_into_being_where_security_is_enforced(
    context: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_SECURITY_ENABLE", "true")
    monkeypatch.setenv("ROS_SECURITY_STRATEGY", "Enforce")
    with pytest.raises(RCLError, match="Enforce"):
        Node("node", context=context)
    assert context._graph_if_open is None


def test_a_program_told_to_be_secure_ends_with_the_sentence(run: Run) -> None:
    program = run(TALKER, ROS_SECURITY_ENABLE="true", ROS_SECURITY_STRATEGY="Enforce")
    program.expect("ROS_SECURITY_STRATEGY is Enforce, and the bundled runtime cannot obey.")
    assert program.wait() != 0
    assert "running" not in program.lines


def test_a_program_that_may_be_insecure_warns_and_runs(run: Run) -> None:
    program = run(TALKER, ROS_SECURITY_ENABLE="true")
    program.expect("running WITHOUT security")
    program.expect("running")
    assert program.wait() == 0

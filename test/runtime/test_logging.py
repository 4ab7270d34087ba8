"""Loggers: format, levels, filters and /rosout."""

from __future__ import annotations

import re
from typing import Any

import pytest
from programs import MakeNode, SpinUntil

from seat_gear_dynamics.runtime import logging
from seat_gear_dynamics.runtime.messages import get_message
from seat_gear_dynamics.runtime.qos import qos_profile_rosout


def test_format_is_rcls(capsys: pytest.CaptureFixture[str]) -> None:
    logging.get_logger("a.b").warning("with {braces}")
    assert re.fullmatch(r"\[WARN\] \[\d{10}\.\d{9}\] \[a\.b\]: with \{braces\}\n", capsys.readouterr().err)


def test_levels_are_inherited(capsys: pytest.CaptureFixture[str]) -> None:
    parent, child = logging.get_logger("levels"), logging.get_logger("levels").get_child("child")
    assert child.debug("no") is False
    parent.set_level(logging.LoggingSeverity.DEBUG)
    assert child.debug("yes")
    assert child.get_effective_level() is logging.LoggingSeverity.DEBUG
    assert "[levels.child]: yes" in capsys.readouterr().err
    with pytest.raises(RuntimeError, match="is not a log level"):
        logging.configure({"": "loud"}, True)


def test_filters(capsys: pytest.CaptureFixture[str]) -> None:
    logger = logging.get_logger("filters")
    for n in range(3):
        logger.info(f"throttled {n}", throttle_duration_sec=60.0)
        logger.info(f"once {n}", once=True)
        logger.info(f"skipping {n}", skip_first=True)
    lines = [line.partition(": ")[2] for line in capsys.readouterr().err.splitlines()]
    assert lines == ["throttled 0", "once 0", "skipping 1", "skipping 2"]
    with pytest.raises(TypeError, match="'twice' is not one of the recognized logging options"):
        logger.info("x", twice=True)


def test_rosout_reaches_late_joiners(make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node("speaker", namespace="/bench")
    node.get_logger().error("trouble")
    got: list[Any] = []
    listener = make_node("listener")
    listener.create_subscription(get_message("rcl_interfaces/msg/Log"), "/rosout", got.append, qos_profile_rosout)
    executor.add_node(listener)
    spin_until(lambda: got)
    assert (got[0].name, got[0].msg, got[0].level) == ("bench.speaker", "trouble", 40)
    assert got[0].function == "test_rosout_reaches_late_joiners"
    assert got[0].stamp.sec > 0

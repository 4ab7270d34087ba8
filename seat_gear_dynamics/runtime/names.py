"""Validate, expand and mangle the names of nodes, topics, services and parameters."""

from __future__ import annotations

import re

from seat_gear_dynamics.runtime.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidParameterException,
    InvalidServiceNameException,
    InvalidTopicNameException,
)

_LONGEST_NODE_NAME = 255


def validate_node_name(node_name: str) -> bool:
    """Return True for a valid node name.

    Raises:
        InvalidNodeNameException: naming the first character that is wrong.
    """
    if not node_name:
        raise InvalidNodeNameException(node_name, "node name must not be empty", 0)
    bad = re.search(r"[^A-Za-z0-9_]", node_name)
    if bad:
        raise InvalidNodeNameException(
            node_name,
            "node name must not contain characters other than alphanumerics or '_'",
            bad.start(),
        )
    if node_name[0].isdigit():
        raise InvalidNodeNameException(node_name, "node name must not start with a number", 0)
    if len(node_name) > _LONGEST_NODE_NAME:
        raise InvalidNodeNameException(node_name, "node name length should not exceed 255", _LONGEST_NODE_NAME)
    return True


def validate_namespace(namespace: str) -> bool:
    """Return True for a valid absolute namespace, such as "/" or "/bench".

    Raises:
        InvalidNamespaceException: naming the first character that is wrong.
    """
    fault = _path_fault(namespace, "namespace")
    if fault is None and not namespace.startswith("/"):
        fault = ("namespace must be absolute, it must lead with a '/'", 0)
    if fault is not None:
        raise InvalidNamespaceException(namespace, *fault)
    return True


def validate_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return True for a valid topic or service name, which may be relative or start with "~".

    Raises:
        InvalidTopicNameException, InvalidServiceNameException: naming the first character that is wrong.
    """
    path = name[1:] if name.startswith("~") else name
    fault: tuple[str, int] | None
    if name.startswith("~") and path and not path.startswith("/"):
        fault = ("tilde (~) must be followed by a '/'", 1)
    elif path:
        fault = _path_fault(path, "topic name")
        if path == "/":
            fault = ("topic name must not end with a forward slash", 0)
    else:
        fault = None if name else ("topic name must not be empty string", 0)
    if fault is not None:
        offset = len(name) - len(path)
        error = InvalidServiceNameException if is_service else InvalidTopicNameException
        raise error(name, fault[0], fault[1] + offset if fault[1] or offset else 0)
    return True


def _path_fault(path: str, what: str) -> tuple[str, int] | None:
    """Return what is wrong with a name made of tokens and slashes, and where."""
    if not path:
        return f"{what} must not be empty", 0
    bad = re.search(r"[^A-Za-z0-9_/]", path)
    if bad:
        return f"{what} must not contain characters other than alphanumerics, '_', '~', or '/'", bad.start()
    if len(path) > 1 and path.endswith("/"):
        return f"{what} must not end with a forward slash", len(path) - 1
    repeated = path.find("//")
    if repeated >= 0:
        return f"{what} must not contain repeated '/'", repeated + 1
    digit = re.search(r"(^|/)[0-9]", path)
    if digit:
        return f"{what} token must not start with a number", digit.end() - 1
    return None


def validate_parameter_name(name: str) -> bool:
    """Return True for a valid parameter name.

    Raises:
        InvalidParameterException: the name is empty.
    """
    if not name:
        raise InvalidParameterException(name)
    return True


def expand_topic_name(topic_name: str, node_name: str, node_namespace: str) -> str:
    """Return the absolute form of a topic or service name.

    "~/x" is taken below the node's own name, "x" below the namespace, "/x" as it is.
    """
    validate_topic_name(topic_name)
    prefix = node_namespace.rstrip("/")
    if topic_name.startswith("~"):
        return f"{prefix}/{node_name}{topic_name[1:]}"
    return topic_name if topic_name.startswith("/") else f"{prefix}/{topic_name}"


def dds_topic(name: str, prefix: str = "rt", suffix: str = "") -> str:
    """Return the DDS topic of an absolute ROS name: "/motor/speed" is "rt/motor/speed".

    Requests take prefix "rq" and suffix "Request", replies "rr" and "Reply".
    """
    return f"{prefix}{name}{suffix}"


def ros_topic(dds_name: str) -> str | None:
    """Return the ROS topic of a DDS topic, or None where it is not a ROS topic."""
    return dds_name[2:] if dds_name.startswith("rt/") else None


def ros_service(dds_name: str) -> str | None:
    """Return the ROS service a DDS topic belongs to, or None where it belongs to none."""
    for prefix, suffix in (("rq/", "Request"), ("rr/", "Reply")):
        if dds_name.startswith(prefix) and dds_name.endswith(suffix):
            return dds_name[2 : -len(suffix)]
    return None


def dds_type(name: str) -> str:
    """Return the DDS type of a ROS type: "std_msgs/msg/Float64" is "std_msgs::msg::dds_::Float64_"."""
    package, folder, short = name.split("/")
    return f"{package}::{folder}::dds_::{short}_"


def ros_type(dds_name: str) -> str:
    """Return the ROS type of a DDS type, or the text unchanged where it is not a ROS type."""
    found = re.fullmatch(r"(\w+)::(msg|srv|action)::dds_::(\w+)_", dds_name)
    return "/".join(found.groups()) if found else dds_name

"""Read parameter values as ROS reads them, from a command line and from parameter files."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any


class _MalformedFileError(RuntimeError):
    """A parameter file is laid out wrongly."""


@dataclass(frozen=True)
class Override:
    """One parameter value for the nodes whose full name fits `pattern` ("/**" is every node)."""

    pattern: str
    name: str
    value: Any


def parse_value(text: str, where: str) -> Any:
    """Return the value of a YAML text as ROS reads it: bool, int, float, str or a list of one of these.

    Raises:
        RuntimeError: the text is not YAML, or not a value a parameter can hold; `where` names it.
    """
    import yaml

    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.YAMLError as error:
        raise RuntimeError(f"{where!r} is not valid YAML: {error}") from error
    return "" if node is None else _node_value(node, where)


def _node_value(node: Any, where: str) -> Any:
    import yaml

    if isinstance(node, yaml.ScalarNode):
        quoted = node.style in ("'", '"', "|", ">") or node.tag == "!!str"
        return node.value if quoted else _scalar(node.value)
    if isinstance(node, yaml.SequenceNode):
        values = [_node_value(item, where) for item in node.value]
        if len({type(value) for value in values}) > 1 or any(isinstance(v, list) for v in values):
            raise RuntimeError(
                f"{where!r} has a list of values of different types, expected one type: "
                "write 1.0 for a whole number among floats."
            )
        return values
    raise RuntimeError(f"{where!r} holds a mapping, expected a bool, a number, text or a list of one of these.")


_TRUE = {"y", "Y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"}
_FALSE = {"n", "N", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"}


def _scalar(text: str) -> Any:
    """Return the value of an unquoted scalar, by the rules of ROS's own parser (so 1e-3 is a float)."""
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    for convert in (_integer, _float):
        try:
            return convert(text)
        except ValueError:
            continue
    return text


def _integer(text: str) -> int:
    if re.fullmatch(r"[+-]?0[0-7]+", text):
        return int(text, 8)
    value = int(text, 0)
    if "_" in text or not -(2**63) <= value < 2**63:
        raise ValueError(text)
    return value


def _float(text: str) -> float:
    if "_" in text:
        raise ValueError(text)
    return float(re.sub(r"^([+-]?)\.(nan|inf)$", r"\1\2", text, flags=re.IGNORECASE))


def read_parameter_file(path: str | Path) -> list[Override]:
    """Return the values of a ROS parameter file (node name, `ros__parameters`, names and values).

    Raises:
        RuntimeError: the file cannot be read or is not laid out that way.
    """
    import yaml

    try:
        root = yaml.compose(Path(path).read_text(encoding="utf-8"), Loader=yaml.SafeLoader)
    except (OSError, UnicodeDecodeError) as error:
        raise RuntimeError(f"The parameter file {str(path)!r} cannot be read: {error}") from error
    except yaml.YAMLError as error:
        raise RuntimeError(f"The parameter file {str(path)!r} is not valid YAML: {error}") from error
    if root is None:
        return []
    found: list[Override] = []
    _walk_nodes(root, "", str(path), found)
    return found


def _walk_nodes(node: Any, prefix: str, path: str, found: list[Override]) -> None:
    import yaml

    if not isinstance(node, yaml.MappingNode):
        raise _MalformedFileError(
            f"The parameter file {path!r} has no mapping under {prefix or 'its top level'!r}: "
            "expected NODE, then ros__parameters, then the parameters."
        )
    for key, value in node.value:
        if key.value == "ros__parameters":
            if not prefix:
                raise RuntimeError(
                    f"The parameter file {path!r} has ros__parameters at its top level: "
                    "put it under a node name or under '/**'."
                )
            _walk_parameters(value, prefix, "", path, found)
        else:
            _walk_nodes(value, f"{prefix}/{key.value.strip('/')}", path, found)


def _walk_parameters(node: Any, pattern: str, prefix: str, path: str, found: list[Override]) -> None:
    import yaml

    if not isinstance(node, yaml.MappingNode):
        raise _MalformedFileError(f"The parameter file {path!r} has no names and values under {pattern!r}: add them.")
    for key, value in node.value:
        name = f"{prefix}{key.value}"
        if isinstance(value, yaml.MappingNode):
            _walk_parameters(value, pattern, f"{name}.", path, found)
        else:
            found.append(Override(pattern, name, _node_value(value, f"{name} in {path}")))

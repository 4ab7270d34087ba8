"""Read the `--ros-args` part of a command line: remapping rules, parameters, log levels."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from seat_gear_dynamics.runtime.exceptions import NameValidationException
from seat_gear_dynamics.runtime.names import expand_topic_name, validate_topic_name
from seat_gear_dynamics.runtime.parameter_files import Override, parse_value, read_parameter_file


class UnknownROSArgsError(RuntimeError):
    """A `--ros-args` part holds something ROS does not know."""


@dataclass(frozen=True)
class Rule:
    """One remapping rule: for nodes called `node` (all without one), `match` becomes `replacement`.

    `kind` is "topic", "service", "any", "node" or "namespace".
    """

    kind: str
    node: str
    match: str
    replacement: str


@dataclass
class Arguments:
    """What the `--ros-args` parts of a command line say."""

    rules: list[Rule] = field(default_factory=list)
    overrides: list[Override] = field(default_factory=list)
    log_levels: dict[str, str] = field(default_factory=dict)
    rosout: bool = True
    console: bool = True

    def remap_node(self, name: str) -> str:
        """Return the node name to use instead of `name`."""
        return self._first("node", name) or name

    def remap_namespace(self, node: str, namespace: str) -> str:
        """Return the namespace to use for a node instead of `namespace`."""
        return self._first("namespace", node) or namespace

    def _first(self, kind: str, node: str) -> str | None:
        rules = (rule for rule in self.rules if rule.kind == kind and rule.node in ("", node))
        return next((rule.replacement for rule in rules), None)

    def remap(self, full_name: str, node: str, namespace: str, kind: str) -> str:
        """Return the name to use instead of an absolute topic or service name; `kind` says which."""
        for rule in self.rules:
            if rule.kind not in (kind, "any") or rule.node not in ("", node):
                continue
            if expand_topic_name(rule.match, node, namespace) == full_name:
                return expand_topic_name(rule.replacement, node, namespace)
        return full_name

    def parameters_for(self, full_node_name: str) -> dict[str, Any]:
        """Return the parameter values given for a node; later ones on the command line win."""
        return {
            override.name: override.value
            for override in self.overrides
            if _pattern(override.pattern).fullmatch(full_node_name)
        }


def _pattern(pattern: str) -> re.Pattern[str]:
    """Return the expression of a node pattern: `*` is one name, `**` any number of them."""
    text = pattern if pattern.startswith("/") else f"/{pattern}"
    parts = {"/**": r"(/\w+)*", "/*": r"/\w+"}
    return re.compile(re.sub(r"/\*\*|/\*|[^/*]+|.", lambda m: parts.get(m[0], re.escape(m[0])), text))


_IGNORED_FLAGS = (
    "--enable-external-lib-logs",
    "--disable-external-lib-logs",
)
_IGNORED_WITH_VALUE = ("--log-config-file", "--log-file-name", "-e", "--enclave")


def parse(arguments: Sequence[str]) -> Arguments:
    """Return what a command line's `--ros-args` parts say; all other arguments are left alone.

    Raises:
        UnknownROSArgsError: something in such a part is not a ROS argument.
        RuntimeError: a rule, a parameter, a level or a parameter file is malformed.
    """
    found = Arguments()
    words = iter(_ros_words(arguments))
    for word in words:
        _read_word(found, word, words)
    return found


def _read_word(found: Arguments, word: str, words: Iterator[str]) -> None:
    if word in ("-r", "--remap"):
        found.rules.append(_rule(_value_of(word, words)))
    elif word in ("-p", "--param"):
        found.overrides.append(_override(_value_of(word, words)))
    elif word == "--params-file":
        found.overrides.extend(read_parameter_file(_value_of(word, words)))
    elif word == "--log-level":
        name, _, level = _value_of(word, words).rpartition(":=")
        found.log_levels[name] = level
    elif word in ("--enable-rosout-logs", "--disable-rosout-logs"):
        found.rosout = word.startswith("--enable")
    elif word in ("--enable-stdout-logs", "--disable-stdout-logs"):
        found.console = word.startswith("--enable")
    elif word in _IGNORED_WITH_VALUE:
        _value_of(word, words)
    elif word not in _IGNORED_FLAGS:
        raise UnknownROSArgsError(
            f"Found unknown ROS arguments: {word!r}. Known are -r FROM:=TO, -p NAME:=VALUE, "
            "--params-file FILE and --log-level LEVEL; put other arguments before --ros-args or after --."
        )


def _ros_words(arguments: Sequence[str]) -> list[str]:
    return [word for word, is_ros in _marked(arguments) if is_ros]


def without_ros_arguments(arguments: Sequence[str]) -> list[str]:
    """Return the arguments outside the `--ros-args` parts."""
    return [word for word, is_ros in _marked(arguments) if is_ros is False]


def _marked(arguments: Sequence[str]) -> Iterable[tuple[str, bool | None]]:
    """Yield each argument with whether it is ROS's; the words that only delimit come with None."""
    inside = False
    for word in arguments:
        if word == "--ros-args":
            inside = True
            yield word, None
        elif inside and word == "--":
            inside = False
            yield word, None
        else:
            yield word, inside


def _value_of(flag: str, words: Iterator[str]) -> str:
    value = next(words, None)
    if value is None:
        raise RuntimeError(f"{flag} is the last ROS argument and its value is missing: add it.")
    return value


def _rule(text: str) -> Rule:
    """Return the rule of `[node:]from:=to`."""
    match = re.fullmatch(
        r"(?:(?P<node>\w+):(?!//|=))?(?P<scheme>ros(topic|service)://)?(?P<from>.+?):=(?P<to>.+)", text
    )
    if match is None:
        raise RuntimeError(f"{text!r} is not a remapping rule: expected FROM:=TO or NODE:FROM:=TO.")
    source, target, node = match["from"], match["to"], match["node"] or ""
    if source in ("__node", "__name"):
        return Rule("node", node, source, target)
    if source == "__ns":
        return Rule("namespace", node, source, target if target.startswith("/") else f"/{target}")
    if "*" in source or "\\" in target:
        raise RuntimeError(f"{text!r} uses wildcards, which remapping rules do not support: name the topic.")
    try:
        validate_topic_name(source)
        validate_topic_name(target)
    except NameValidationException as error:
        raise RuntimeError(f"{text!r} is not a remapping rule. {error}") from error
    kind = match["scheme"][3:-3] if match["scheme"] else "any"
    return Rule(kind, node, source, target)


def _override(text: str) -> Override:
    """Return the parameter value of `[node:]name:=yaml`."""
    match = re.fullmatch(r"(?:(?P<node>\w+):(?!=))?(?P<name>[^:/*]+):=(?P<value>.*)", text, re.DOTALL)
    if match is None:
        raise RuntimeError(f"{text!r} is not a parameter: expected NAME:=VALUE or NODE:NAME:=VALUE.")
    return Override(match["node"] or "/**", match["name"], parse_value(match["value"], text))

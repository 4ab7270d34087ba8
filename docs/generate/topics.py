"""The topics of the contract and the definitions of their types."""

from docs.generate.markdown import block, code, plain, table
from seat_gear_dynamics.logs.schemas import schema
from seat_gear_dynamics.logs.topics import TOPICS, Topic

_USUAL = ("volatile", 10)
"""Durability and depth of a topic of which the table says nothing."""


def reference() -> str:
    """Return the table of topics."""
    return table(("topic", "type", "way", "content"), (_row(each) for each in TOPICS))


def definitions() -> str:
    """Return the definition of each type that a topic has, without those that it is made of."""
    return "\n\n".join(f"### `{name}`\n\n{block(_own(name))}" for name in dict.fromkeys(each.type for each in TOPICS))


def _row(topic: Topic) -> tuple[str, ...]:
    kind = f"[{topic.type.replace('/msg/', '/')}](#{_anchor(topic.type)})"
    return (code(topic.name), kind, topic.direction, plain(topic.description) + _kept(topic))


def _kept(topic: Topic) -> str:
    if (topic.durability, topic.depth) == _USUAL:
        return ""
    return f" ({topic.durability.replace('_', '-')}, depth {topic.depth})"


def _anchor(name: str) -> str:
    return name.lower().replace("/", "")


def _own(name: str) -> str:
    return schema(name).text.split("=" * 80)[0].strip()

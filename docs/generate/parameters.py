"""The parameters of every node, from the schemas that the nodes declare."""

from collections.abc import Sequence

from docs.generate.markdown import code, plain, table
from seat_gear_dynamics.nodes.parameter_table import TABLES
from seat_gear_dynamics.nodes.parameters import CHANGES, Parameter


def reference() -> str:
    """Return a section for each node, with one row for each parameter."""
    return "\n\n".join(_node(name, schema) for name, (_, schema) in TABLES.items())


def _node(name: str, schema: Sequence[Parameter]) -> str:
    heads = ("parameter", "default", "takes", "may be changed", "meaning")
    return f"## `{name}`\n\n{table(heads, (_row(each) for each in schema))}"


def _row(parameter: Parameter) -> tuple[str, str, str, str, str]:
    default = str(parameter.default).lower() if isinstance(parameter.default, bool) else str(parameter.default)
    return (
        code(parameter.name),
        code(default) or "empty",
        _takes(parameter),
        CHANGES[parameter.change].removeprefix("only "),
        plain(parameter.description),
    )


def _takes(parameter: Parameter) -> str:
    if parameter.choices:
        return ", ".join(code(choice) for choice in parameter.choices)
    if parameter.low is None or parameter.high is None:
        return parameter.kind
    return f"{parameter.kind}, {parameter.low:g} to {parameter.high:g}"

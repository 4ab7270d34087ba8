"""The parameters' tables in the docs, from the schemas: `python -m seat_gear_dynamics.nodes.parameter_table`."""

import re
from collections.abc import Sequence
from pathlib import Path

from seat_gear_dynamics.nodes import monitor_parameters, recorder, simulator
from seat_gear_dynamics.nodes.parameters import CHANGES, Parameter

DOCS = Path(__file__).resolve().parents[2] / "docs"
TABLES: dict[str, tuple[str, Sequence[Parameter]]] = {
    "gear_monitor": ("nodes.md", monitor_parameters.PARAMETERS),
    "bench_simulator": ("nodes.md", simulator.PARAMETERS),
    "bench_recorder": ("recorder.md", recorder.PARAMETERS),
}
"""Node → document and schema."""


def table(schema: Sequence[Parameter]) -> str:
    """Return a Markdown table of a schema; when a parameter may change is a column where they differ."""
    mixed = len({parameter.change for parameter in schema}) > 1
    heads = ["parameter", "default", "from … to", *(["changes"] if mixed else []), "meaning"]
    rows = [heads, ["---"] * len(heads)]
    for each in schema:
        changes = [CHANGES[each.change].removeprefix("only ")] if mixed else []
        rows.append([f"`{each.name}`", _default(each), _range(each), *changes, each.description.replace("|", "\\|")])
    return "\n".join(f"| {' | '.join(row)} |" if row[0] != "---" else f"|{'|'.join(row)}|" for row in rows)


def embedded(text: str, node: str, schema: Sequence[Parameter]) -> str:
    """Return a document with the table of a node between its two marks renewed; raises ValueError without the marks."""
    begin, end = f"<!-- parameters of {node}, written by nodes/parameter_table -->", "<!-- end -->"
    pattern = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
    if len(pattern.findall(text)) != 1:
        raise ValueError(f"The document has no place for the parameters of {node}; expected {begin!r} and {end!r}.")
    return pattern.sub(lambda _: f"{begin}\n{table(schema)}\n{end}", text)


def _default(parameter: Parameter) -> str:
    if isinstance(parameter.default, bool):
        return str(parameter.default).lower()
    if isinstance(parameter.default, str):
        return f"`{parameter.default}`" if parameter.default else "empty"
    return repr(parameter.default)


def _range(parameter: Parameter) -> str:
    if parameter.choices:
        return ", ".join(f"`{choice}`" for choice in parameter.choices)
    if parameter.low is None or parameter.high is None:
        return ""
    return f"{parameter.low:g} … {parameter.high:g}"


def main() -> None:
    """Renew the tables in the docs of this checkout."""
    for node, (document, schema) in TABLES.items():
        path = DOCS / document
        path.write_text(embedded(path.read_text(encoding="utf-8"), node, schema), encoding="utf-8")


if __name__ == "__main__":
    main()

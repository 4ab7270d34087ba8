"""The parts of the site that are written from the code: a page names one in a comment, `<!-- generate: NAME -->`."""

import re
from collections.abc import Callable
from typing import Any

from sphinx.application import Sphinx

from docs.generate import (
    architecture,
    commands,
    contents,
    description,
    files,
    interface,
    links,
    messages,
    parameters,
    topics,
)

PARTS: dict[str, Callable[[], str]] = {
    "architecture": architecture.diagram,
    "chapters": contents.chapters,
    "commands": commands.reference,
    "description": description.reference,
    "interface": interface.reference,
    "links": links.listing,
    "map": files.map_arrays,
    "messages": messages.reference,
    "parameters": parameters.reference,
    "sweep": files.sweep_columns,
    "topics": topics.reference,
    "types": topics.definitions,
    "units": description.units,
}
"""Name → what writes it as Markdown."""
MARK = re.compile(r"^<!-- generate: (\w+) -->$", re.MULTILINE)


def expand(text: str) -> str:
    """Return a page with every named part in its place; raises ValueError for a part that nothing writes."""

    def part(match: re.Match[str]) -> str:
        if match[1] not in PARTS:
            raise ValueError(f"Nothing writes the part {match[1]!r}, expected one of {', '.join(PARTS)}.")
        return PARTS[match[1]]()

    return MARK.sub(part, text)


def setup(app: Sphinx) -> dict[str, Any]:
    """Expand each page as Sphinx reads it."""
    app.connect("source-read", _on_source_read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _on_source_read(app: Sphinx, name: str, source: list[str]) -> None:
    source[0] = expand(source[0])

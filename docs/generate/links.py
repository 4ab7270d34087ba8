"""The addresses outside the site that its pages name: listed, since a bench that is offline cannot follow them."""

import re
from pathlib import Path

from docs.generate.markdown import table

DOCS = Path(__file__).resolve().parents[1]
ADDRESS = re.compile(r"https?://[^\s)>\"'`\]]+")


def external() -> dict[str, list[str]]:
    """Return address → pages that name it, each page by its path without `.md`."""
    found: dict[str, list[str]] = {}
    for path in sorted(DOCS.rglob("*.md")):
        for address in sorted(set(ADDRESS.findall(path.read_text(encoding="utf-8")))):
            found.setdefault(address.rstrip(".,;"), []).append(path.relative_to(DOCS).with_suffix("").as_posix())
    return found


def listing() -> str:
    """Return the table of addresses."""
    rows = [(f"`{address}`", ", ".join(pages)) for address, pages in external().items()]
    return table(("address", "named in"), rows) if rows else "None."

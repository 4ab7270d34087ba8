"""The pages that stand in no list of the front page by name: a new one is found where it lies, and none gets lost."""

import re
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
_LISTED = re.compile(r"^(?:.*<)?([\w/]+)>?$", re.MULTILINE)


def chapters() -> str:
    """Return a toctree of every page beside the front page that it does not name itself."""
    named = {*_LISTED.findall((DOCS / "index.md").read_text(encoding="utf-8")), "index"}
    others = sorted(path.stem for path in DOCS.glob("*.md") if path.stem not in named)
    return "\n".join(["```{toctree}", ":caption: More on the parts", ":hidden:", "", *others, "```"])

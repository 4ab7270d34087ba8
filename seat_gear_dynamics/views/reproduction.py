"""The reproduction of the paper as a page of Markdown and as a table for the terminal."""

from collections.abc import Mapping, Sequence
from typing import Any

from seat_gear_dynamics.studies.reproduction.claim import Claim
from seat_gear_dynamics.studies.reproduction.errata import Erratum

MARKS = {"reproduced": "✔ reproduced", "partly": "◐ partly", "not reproduced": "✘ not reproduced"}
"""Told apart without colour."""
_STYLES = {"reproduced": "green", "partly": "yellow", "not reproduced": "red"}


def counted(claims: Sequence[Claim]) -> str:
    """Return how many claims have each verdict, in words."""
    return ", ".join(f"{sum(c.verdict == verdict for c in claims)} {verdict}" for verdict in MARKS)


def markdown(
    claims: Sequence[Claim], errata: Sequence[Erratum], *, setting: str, pictures: Mapping[str, str], command: str
) -> str:
    """Return the page: verdicts, each claim with expected, found and why, figures, errata.

    `setting` says in a sentence what was computed; `pictures` gives caption -> path relative to the page.
    """
    lines = [
        "# Reproduction of the paper",
        "",
        f"Made by `{command}`; nothing in it is typed in by hand. {setting}",
        "",
        f"**{len(claims)} claims: {counted(claims)}.**",
        "",
        "| claim | condition | verdict |",
        "|---|---|---|",
        *(f"| [{c.id}](#{c.id.lower()}) | {_cell(c.condition)} | {MARKS[c.verdict]} |" for c in claims),
        "",
        "## The claims",
        "",
    ]
    for claim in claims:
        lines += [
            f"### {claim.id}",
            "",
            f"*{claim.condition}.*",
            "",
            f"- **Expected:** {claim.expected}.",
            f"- **Found:** {claim.found}.",
            f"- **Verdict:** {MARKS[claim.verdict]}. {_sentence(claim.why)}",
            "",
        ]
    lines += ["## Figures, in the paper's numbering", ""]
    for caption, path in pictures.items():
        lines += [f"**{caption}**", "", f"![{caption}]({path})", ""]
    lines += ["## Errata and gaps of the paper", "", "| where | what | what is done here |", "|---|---|---|"]
    lines += [f"| {e.place} | {_cell(e.finding)} | {_cell(e.followed)} |" for e in errata]
    return "\n".join(lines) + "\n"


def table(claims: Sequence[Claim]) -> Any:
    """Return a rich table of the claims that can be read on 80 columns: the paper's side, and what was found."""
    from rich.table import Table

    shown = Table(title=f"{len(claims)} claims: {counted(claims)}", show_lines=True, expand=True)
    shown.add_column("claim", no_wrap=True)
    shown.add_column("the paper", ratio=2)
    shown.add_column("found, and why the verdict", ratio=5)
    for claim in claims:
        verdict = f"{claim.id}\n[{_STYLES[claim.verdict]}]{MARKS[claim.verdict]}[/]"
        paper = f"[dim]{_escaped(claim.condition)}[/]\n{_escaped(claim.expected)}"
        shown.add_row(verdict, paper, f"{_escaped(claim.found)}.\n[dim]{_escaped(_sentence(claim.why))}[/]")
    return shown


def _escaped(text: str) -> str:
    return text.replace("[", r"\[")


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")

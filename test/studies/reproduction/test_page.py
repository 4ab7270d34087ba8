"""The page and the table, and that the committed page is of the packaged machine."""

import io
import json
from pathlib import Path

import pytest
from rich.console import Console

from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.regimes.regime_map import fingerprint
from seat_gear_dynamics.studies.reproduction.claim import Claim
from seat_gear_dynamics.studies.reproduction.errata import errata
from seat_gear_dynamics.studies.reproduction.frequency import band_speeds
from seat_gear_dynamics.studies.reproduction.geometry import mesh_stiffness_claim
from seat_gear_dynamics.views.reproduction import counted, markdown, table

DOCS = Path(__file__).parents[3] / "docs"
CLAIMS = (
    Claim("C1", "Ω in [0.1, 0.69]", "period-1", "period-1 at 100%", "reproduced", "it is"),
    Claim("C2", "a | b", "chaos", "none", "not reproduced", "it is not."),
)


def test_the_page_holds_every_claim_with_its_verdict_and_why() -> None:
    text = markdown(CLAIMS, errata(load_train()), setting="Here.", pictures={"Fig. 8": "r/fig08.png"}, command="x")
    assert "**2 claims: 1 reproduced, 0 partly, 1 not reproduced.**" in text
    assert "- **Verdict:** ✔ reproduced. It is." in text
    assert r"a \| b" in text
    assert "![Fig. 8](r/fig08.png)" in text
    assert counted(CLAIMS) == "1 reproduced, 0 partly, 1 not reproduced"


@pytest.mark.parametrize("width", [80, 140])
def test_the_table_fits_the_terminal_and_keeps_brackets(width: int) -> None:
    console = Console(file=io.StringIO(), width=width, force_terminal=False)
    console.print(table(CLAIMS))
    printed = console.file.getvalue()  # type: ignore[attr-defined]
    words = " ".join(printed.replace("│", " ").split())
    assert "[0.1," in words  # rich would take an unescaped bracket for a style and drop it
    assert "0.69]" in words
    assert max(map(len, printed.splitlines())) <= width


def test_the_numbers_of_the_errata_are_computed() -> None:
    told = " ".join(f"{e.place} {e.finding} {e.followed}" for e in errata(load_train()))
    for number in ("3.3e-06 kg·m²", "5652 N", "65129 r/min", "over 2000", "this over 200"):
        assert number in told


def test_the_committed_page_is_of_the_packaged_machine() -> None:
    record = json.loads((DOCS / "reproduction.json").read_text(encoding="utf-8"))
    page = (DOCS / "reproduction.md").read_text(encoding="utf-8")
    assert record["fingerprint"] == fingerprint(load_train()), "run: seat-gear reproduce --output docs/reproduction.md"
    assert [c["id"] for c in record["claims"]] == [f"C{n}" for n in range(1, 16)]
    for claim in record["claims"]:
        assert claim["found"] in page
        assert claim["verdict"] in ("reproduced", "partly", "not reproduced")
    own = {c["id"]: c for c in record["claims"]}
    for claim in (band_speeds(load_train()), mesh_stiffness_claim(load_train())):
        assert own[claim.id]["found"] == claim.found

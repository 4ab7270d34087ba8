"""The generated reference against what the code has, and tables that stand in pages by hand against what is written."""

import csv
import re
from pathlib import Path

import pytest

from docs.generate import commands, description, files, interface, messages, parameters, topics
from docs.generate.markdown import plain, table
from seat_gear_dynamics.commands import main
from seat_gear_dynamics.gears import schema
from seat_gear_dynamics.logs.topics import TOPICS
from seat_gear_dynamics.nodes.parameter_table import TABLES

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"


def rows(text: str) -> list[list[str]]:
    """Return the cells of each row of the tables in a page, heads and rules left out."""
    lines = [line for line in text.splitlines() if line.startswith("| `")]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]


def test_every_parameter_has_a_row_with_its_default_and_its_range() -> None:
    found = rows(parameters.reference())
    expected = [each for _, schema_ in TABLES.values() for each in schema_]
    assert [row[0] for row in found] == [f"`{each.name}`" for each in expected]
    rate = next(row for row in found if row[0] == "`publish_rate`")
    assert rate[1] == "`50.0`"
    assert "1 to 1000" in rate[2]


def test_every_topic_has_a_row_and_its_type_a_definition() -> None:
    assert [row[0] for row in rows(topics.reference())] == [f"`{each.name}`" for each in TOPICS]
    latched = next(row for row in rows(topics.reference()) if row[0] == "`gear_monitor/in_forbidden_band`")
    assert "(transient-local, depth 1)" in latched[-1]
    definitions = topics.definitions()
    for each in TOPICS:
        assert f"### `{each.type}`" in definitions
    assert "float64 data" in definitions


def test_every_command_has_a_section_with_its_options() -> None:
    text = commands.reference()
    for name, parser in commands.parsers().items():
        section = text.split(f"## seat-gear {name}\n")[1].split("\n## ")[0]
        for action in parser._actions:
            assert all(f"`{flag}`" in section for flag in action.option_strings)
        assert "```sh\nseat-gear" in section


def test_every_key_of_a_description_has_a_row_with_a_meaning() -> None:
    found = rows(description.reference())
    keys = [
        schema.GEAR_KEYS,
        schema.MESH_KEYS,
        schema.SHAFT_KEYS,
        schema.VARIANT_KEYS,
        schema.MODEL_KEYS,
        schema.BAND_KEYS,
    ]
    assert [row[0] for row in found] == [f"`{name}`" for part in keys for name in part]
    assert all(len(row[1]) > 5 for row in found)


def test_every_public_name_of_the_package_is_documented() -> None:
    import seat_gear_dynamics

    text = interface.reference()
    for name in set(seat_gear_dynamics.__all__) - {"__version__"}:
        assert re.search(
            rf"autoclass:: seat_gear_dynamics\.{name}$|autofunction:: seat_gear_dynamics\.{name}$", text, re.M
        )


def test_columns_of_sweep_and_map_are_explained() -> None:
    assert "| `lyapunov_error` | " in files.sweep_columns()
    assert "| `fingerprint` | " in files.map_arrays()


def stated() -> dict[str, list[str]]:
    """Return table -> columns, as the page on files states them; forces stand there in words."""
    text = (DOCS / "reference" / "files.md").read_text(encoding="utf-8").split("## The tables of a report")[1]
    return {
        name: [column.replace("\\|", "|") for column in re.findall(r"`([^`]+)`", row[1])]
        for row in rows(text)
        for name in re.findall(r"`(\w+\.csv)`", row[0])
    }


def test_the_tables_of_a_report_have_the_columns_that_the_page_states(tmp_path: Path) -> None:
    assert main(["analyze", str(ROOT / "bags" / "bench_dwell"), "--output", str(tmp_path), "--json"]) == 0
    written = {path.name: next(csv.reader(path.open(encoding="utf-8"))) for path in (tmp_path / "tables").glob("*.csv")}
    pages = stated()
    for name, columns in written.items():
        generic = re.sub(r"dwell_\d+", "dwell_1", name)
        assert generic in pages, f"docs/reference/files.md does not state {name}"
        assert [column for column in columns if column in pages[generic]] == pages[generic], name
    assert set(pages) - {"dwell_1_portrait.csv", "dwell_1_section.csv", "dwell_1_order_spectrum.csv"} <= set(written)


def quoted() -> list[str]:
    """Return the messages that the page on troubleshooting quotes: its third-level headings and first cells."""
    text = (DOCS / "troubleshooting.md").read_text(encoding="utf-8")
    by_hand = text.split("<!-- generate: messages -->")[0]
    return [row[0].strip("`") for row in rows(by_hand)]


@pytest.mark.parametrize("message", quoted())
def test_every_message_that_is_explained_is_one_of_the_programs(message: str) -> None:
    assert len(message.replace("…", "")) >= 12, "too short to be told from others"
    assert messages.stands(message)


def test_many_messages_are_explained() -> None:
    assert len(quoted()) >= 40


def test_a_message_that_is_nowhere_in_the_code_is_found_out() -> None:
    assert not messages.stands("The gearbox is on … and has to be put out")
    assert messages.stands("There is no profile …; choose one of …")


def test_words_of_the_code_are_not_taken_for_markup() -> None:
    assert plain("a_b *c* <d> `e_f`") == "a\\_b \\*c\\* \\<d\\> `e_f`"
    assert plain("an open ` stays") == "an open \\` stays"
    assert table(("h",), [("a|b\nc",)]).splitlines()[2] == "| a\\|b c |"

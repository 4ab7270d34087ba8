"""The site as it is built: strict, complete, and without a request to another host."""

import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from docs.generate import links, pages

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
LOADED = re.compile(r"(?:url\(|@import)\s*['\"]?(?!data:)([^'\")\s]+)")  # by a style sheet


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built with every warning an error, unresolved references among them."""
    built = tmp_path_factory.mktemp("site")
    options = ["-b", "html", "-W", "--keep-going", "-n", "-E", "-q", "-d", str(built / "doctrees")]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *options, str(DOCS), str(built / "html")],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=280,
    )
    assert done.returncode == 0, done.stderr
    return built / "html"


class Page(HTMLParser):
    """What a page names: ids, where its links go, and what a browser loads for it."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {key: value or "" for key, value in attrs}
        self.ids.add(given.get("id", ""))
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag == "link" and given.get("rel") not in ("canonical", "next", "prev", "search", "index"):
            self.loaded.append(given.get("href", ""))
        self.loaded += [given[key] for key in ("src", "srcset", "data", "poster") if key in given]


def html(site: Path) -> Iterator[tuple[Path, Page]]:
    for path in sorted(site.rglob("*.html")):
        yield path, Page(path)


def test_nothing_is_loaded_from_another_host(site: Path) -> None:
    for path, page in html(site):
        for address in page.loaded:
            assert not urlsplit(address).netloc, f"{path.name} loads {address}"
    for style in site.rglob("*.css"):
        for address in re.findall(
            r"(?:url\(|@import)\s*['\"]?(?!data:)([^'\")\s]+)", style.read_text(encoding="utf-8")
        ):
            assert not urlsplit(address).netloc, f"{style.name} loads {address}"


def test_every_link_within_the_site_leads_somewhere(site: Path) -> None:
    found = dict(html(site))
    for path, page in found.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            assert target.exists(), f"{path.name} links to {link}"
            if parts.fragment and target in found:
                assert unquote(parts.fragment) in found[target].ids, f"{path.name} links to {link}"


def test_every_page_is_in_the_site_and_its_formulas_are_mathml(site: Path) -> None:
    for path in DOCS.rglob("*.md"):
        assert (site / path.relative_to(DOCS).with_suffix(".html")).exists(), f"{path} is not built"
    written = (site / "physics" / "equations.html").read_text(encoding="utf-8")
    blocks = re.findall(r"\$\$.+?\$\$", (DOCS / "physics" / "equations.md").read_text(encoding="utf-8"), re.DOTALL)
    assert written.count('class="formula') == len(blocks) > 10
    assert "$$" not in written


def test_addresses_outside_are_well_formed() -> None:
    for address, named in links.external().items():
        parts = urlsplit(address)
        assert parts.scheme == "https", f"{named}: {address}"
        assert re.fullmatch(r"[a-z0-9.-]+\.[a-z]{2,}", parts.hostname or ""), f"{named}: {address}"


def test_a_part_that_nothing_writes_is_refused() -> None:
    with pytest.raises(ValueError, match="Nothing writes the part 'nonsense'"):
        pages.expand("# A\n\n<!-- generate: nonsense -->\n")


def test_every_part_is_on_a_page() -> None:
    named = {part for path in DOCS.rglob("*.md") for part in pages.MARK.findall(path.read_text(encoding="utf-8"))}
    assert named == set(pages.PARTS)

"""The page's files, read once: what the server gives out is this table and nothing else."""

from dataclasses import dataclass
from importlib.resources import files

_KINDS = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
    "LICENSE": "text/plain; charset=utf-8",
}
_NAMES = (
    "index.html",
    "style.css",
    "dark.css",
    "panels.css",
    "icon.svg",
    "main.js",
    "link.js",
    "dial.js",
    "map.js",
    "forces.js",
    "orbit.js",
    "plane.js",
    "warning.js",
    "recorder.js",
    "text.js",
    "theme.js",
    "vendor/uPlot.iife.min.js",
    "vendor/uPlot.min.css",
    "vendor/uPlot.LICENSE",
)

HEADERS = {
    # Everything the page is made of comes from this server, and nothing on it may run that is not a file of it.
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
    "Cache-Control": "no-store",
    "Server": "seat-gear",
}
"""Of every answer."""


@dataclass(frozen=True)
class File:
    """One file as it is sent."""

    kind: str
    body: bytes


def read_page() -> dict[str, File]:
    """Return the files by the path that a browser asks for; `/` is the page itself.

    Raises FileNotFoundError where the package is incomplete.
    """
    folder = files(__package__) / "page"
    found = {f"/{name}": File(_KINDS[name.rpartition(".")[2]], (folder / name).read_bytes()) for name in _NAMES}
    return {**found, "/": found["/index.html"]}

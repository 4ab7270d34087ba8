"""One set of colours for terminal and figures, safe for colour-blind readers (Okabe & Ito)."""

LEVEL_NAMES = ("OK", "WARN", "ERROR", "STALE")
LEVEL_COLOURS = ("#009E73", "#E69F00", "#D55E00", "#7F7F7F")
"""In the order of LEVEL_NAMES, which is DiagnosticStatus's numbering."""
BAND = "#D55E00"
SPEED = "#0072B2"
LOAD = "#56B4E9"
MESH_COLOURS = ("#0072B2", "#CC79A7")
"""P12, P34."""

TERMINAL_SPEED = "#56B4E9"
TERMINAL_LOAD = "#F0E442"
TERMINAL_MESHES = ("#56B4E9", "#CC79A7")
"""Lighter shades for text on a dark terminal; they hold on a light one too."""

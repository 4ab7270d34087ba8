"""One set of colours for terminal and figures, safe for colour-blind readers (Okabe & Ito)."""

LEVEL_NAMES = ("OK", "WARN", "ERROR", "STALE")
LEVEL_COLOURS = ("#009E73", "#E69F00", "#D55E00", "#7F7F7F")
"""In the order of LEVEL_NAMES, which is DiagnosticStatus's numbering."""
BAND = "#D55E00"
SPEED = "#0072B2"
LOAD = "#56B4E9"
MESH_COLOURS = ("#0072B2", "#CC79A7")
"""P12, P34."""

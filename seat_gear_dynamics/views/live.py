"""The live terminal view: speed against its forbidden bands, load, both forces, warning, recorder, in 80x24."""

from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from seat_gear_dynamics.views.colours import (
    BAND,
    LEVEL_COLOURS,
    LEVEL_NAMES,
    TERMINAL_LOAD,
    TERMINAL_MESHES,
    TERMINAL_SPEED,
)
from seat_gear_dynamics.views.live_state import LiveState

WIDTH = 80
HEIGHT = 20
"""Columns and lines of the view; a terminal needs one line more, for the cursor."""
_SCALE = 64
"""Columns of a full scale, beside its label."""
_SPARKS = " ▁▂▃▄▅▆▇█"


def render(state: LiveState) -> RenderableType:
    """Return the view of `state`, WIDTH columns by HEIGHT lines."""
    body = Group(
        _progress(state),
        Text(),
        _speed(state),
        _history(state),
        Text(),
        _load(state),
        Text(),
        _forces(state),
        _warning(state),
        _recorder(state),
    )
    return Panel(body, title=state.title, width=WIDTH, padding=(0, 1))


def plain_line(state: LiveState) -> str:
    """Return the state as one line, for output that is not a terminal."""
    forces = "  ".join(f"{mesh} {s.mean:.0f} N (max {s.max:.0f})" for mesh, s in state.meshes.items())
    return (
        f"{state.elapsed:7.1f} s  {_number(state.speed_rpm, '.0f')} r/min  {_number(state.load, '.0f')} N·m  "
        f"{forces or 'no force yet'}  {LEVEL_NAMES[state.level]}: {state.reason}"
    )


def _progress(state: LiveState) -> Text:
    now = _clock(state.elapsed)
    if state.duration is None:
        return Text.assemble(f"{now}   ", (state.ending, "dim"))
    share = min(state.elapsed / state.duration, 1.0)
    filled = round(40 * share)
    left = _clock(max(state.duration - state.elapsed, 0.0))
    return Text.assemble(
        f"{now} of {_clock(state.duration)}  ",
        ("━" * filled, TERMINAL_SPEED),
        ("━" * (40 - filled), "grey37"),
        f"  {left} left",
    )


def _speed(state: LiveState) -> Group:
    covered = state.covered_rpm
    scale = Text()
    for column in range(_SCALE):
        low, high = covered * column / _SCALE, covered * (column + 1) / _SCALE
        banned = any(low < b_high and high > b_low for b_low, b_high in state.forbidden_rpm)
        scale.append("█" if banned else "─", BAND if banned else "grey50")
    marker = Text(" " * 12)
    if state.speed_rpm is not None:
        place = min(int(abs(state.speed_rpm) / covered * _SCALE), _SCALE - 1)
        marker.append(" " * place)
        marker.append("▼", f"bold {TERMINAL_SPEED}")
    reading = "–" if state.speed_rpm is None else f"{state.speed_rpm:+.0f} r/min"
    direction = "" if state.speed_rpm is None or state.speed_rpm >= 0 else "  (running backward)"
    edges = "  ".join(f"{low:.0f}-{high:.0f}" for low, high in state.forbidden_rpm) or "none"
    return Group(
        Text.assemble(
            ("Speed s1    ", "bold"),
            (reading, f"bold {TERMINAL_SPEED}"),
            direction,
            ("   forbidden " if state.by_published_bands else "   nearest band on the map ", "dim"),
            (edges, BAND),
        ),
        marker,
        Text.assemble(" " * 12, scale),
        Text(" " * 12 + "0" + f"{covered:.0f}".rjust(_SCALE - 1), "dim"),
    )


def _history(state: LiveState) -> Text:
    """The last minute of |speed| as a sparkline, each column in its warning level's colour."""
    line = Text.assemble(("last minute ", "dim"))
    recent = [entry for entry in state.history if entry[0] > state.elapsed - 60]
    for column in range(_SCALE):
        begin = state.elapsed - 60 + 60 * column / _SCALE
        inside = [e for e in recent if begin <= e[0] < begin + 60 / _SCALE]
        if not inside:
            line.append(" ")
            continue
        height = max(e[1] for e in inside) / state.covered_rpm
        level = max((e[2] for e in inside), key=lambda n: (0, 1, 2, -1)[n])
        line.append(_SPARKS[max(1, min(8, round(8 * height)))], LEVEL_COLOURS[level])
    return line


def _load(state: LiveState) -> Text:
    full = 1000.0
    value = 0.0 if state.load is None else min(abs(state.load), full)
    filled = round(44 * value / full)
    reading = "–" if state.load is None else f"{state.load:.0f} N·m"
    return Text.assemble(
        ("Load T4     ", "bold"),
        ("█" * filled, TERMINAL_LOAD),
        ("─" * (44 - filled), "grey37"),
        (f"  {reading}", f"bold {TERMINAL_LOAD}"),
    )


def _forces(state: LiveState) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("Mesh force  ", style="bold")
    for name in ("mean", "min", "max", "rms"):
        table.add_column(name, justify="right", min_width=8)
    table.add_column("", style="dim")
    for row, mesh in enumerate(("s1_s2", "s3_s4")):
        s = state.meshes.get(mesh)
        values = ["–"] * 4 if s is None else [f"{v:.0f} N" for v in (s.mean, s.min, s.max, s.rms)]
        note = f"load scale {state.load_scale:.4g}" if row == 0 else ""
        table.add_row(Text(mesh, TERMINAL_MESHES[row]), *values, note)
    return table


def _warning(state: LiveState) -> Panel:
    colour = LEVEL_COLOURS[state.level]
    calm = state.details.get("nearest calm speed (r/min)", "unknown")
    regime = state.details.get("regime", "undecided")
    period = state.details.get("period", "unknown")
    motion = f"{regime}, period {period}" if regime == "periodic" else regime
    advice = f"   nearest calm speed {float(calm):.0f} r/min" if _is_number(calm) and state.level in (1, 2) else ""
    text = Text(no_wrap=True, overflow="ellipsis")
    text.append(f"{LEVEL_NAMES[state.level]}  ", f"bold {colour}")
    text.append(f"{state.reason}\n")
    text.append(f"motion: {motion}{advice}", "dim" if not advice else "")
    trip = Text(" TRIP ", f"bold white on {BAND}") if state.in_band else None
    return Panel(text, border_style=colour, title=trip, title_align="right", width=WIDTH - 4, padding=(0, 1))


def _recorder(state: LiveState) -> Text:
    r = state.recorder
    line = Text(no_wrap=True, overflow="ellipsis")
    if not r:
        line.append("recorder: not heard of", "dim")
        return line
    dropped = r.get("dropped", "0")
    line.append("● " if r.get("state") == "recording" else "○ ", "bold red")
    line.append(f"{r.get('state', '?')}, {r.get('received', '0')} messages, ")
    line.append(f"{dropped} dropped", "" if dropped == "0" else f"bold {BAND}")
    line.append(f"   {state.solver}", "dim")
    return line


def _clock(seconds: float) -> str:
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes:02d}:{rest:02d}"


def _number(value: float | None, form: str) -> str:
    return "–" if value is None else f"{value:{form}}"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True

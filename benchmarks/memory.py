"""Whether memory stays flat as points are added: `python -m benchmarks.memory` prints one JSON object.

Studies of three sizes, each in a process of its own, its peak of resident memory beside the number of points: `sweep`
is `seat-gear sweep` with its tables, `map` is `RegimeMap.compute`, which keeps 48 bytes of each point by its nature.
Points are looked at for 50 mesh periods, whose section takes 800 bytes. `memory_of_largest` is the peak of the largest
over that of the smallest; `bytes_per_point` what each point more takes.
"""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.ratio import Findings, Ratio

SIZES, SHORT_SIZES = (500, 4000, 16000), (200, 2000)
FLAT = 1.1
"""Of the largest over the smallest: flat, but for what an allocator keeps."""
REPEATS = 2

# Not ru_maxrss, which a process that was started by a larger one takes over from it.
_PEAK = "import re; print(re.search(r'VmHWM:\\s+(\\d+)', open('/proc/self/status').read())[1])"
_MAP = f"""
import sys
import numpy as np
from seat_gear_dynamics import RegimeMap, load_system
speeds = np.linspace(60.0, 210.0, int(sys.argv[1]) // 4)
RegimeMap.compute(load_system(), speeds, np.linspace(300.0, 900.0, 4), transient=0, periods=50)
{_PEAK}
"""
_SWEEP = f"""
import contextlib, io, sys
from seat_gear_dynamics.commands import main
words = "sweep --over frequency --start 0.3 --stop 2.0 --transient 0 --periods 50 --json --points".split()
with contextlib.redirect_stdout(io.StringIO()):
    code = main([*words, sys.argv[1], "--output", sys.argv[2]])
assert code == 0, code
{_PEAK}
"""


def measure(*, short: bool = False, progress: Callable[[str], None] | None = None) -> Findings:
    """Measure the peaks."""
    sizes = SHORT_SIZES if short else SIZES
    figures, ratios = {}, {}
    for name, program in (("sweep", _SWEEP), ("map", _MAP)):
        if progress is not None:
            progress(f"memory of a {name}")
        repeats = [[peak_megabytes(program, points) for points in sizes] for _ in range(REPEATS)]
        peaks = [min(peak) for peak in zip(*repeats, strict=True)]
        more = (peaks[-1] - peaks[0]) * 2**20 / (sizes[-1] - sizes[0])
        figures[name] = {"points": list(sizes), "peak_megabytes": peaks, "bytes_per_point": more}
        ratios[f"memory_of_largest_{name}"] = Ratio(
            tuple(one[-1] / one[0] for one in repeats),
            f"peak at {sizes[-1]} points over that at {sizes[0]}",
            better="lower",
            reach=FLAT,
        )
    return Findings(figures, ratios)


def peak_megabytes(program: str, points: int) -> float:
    """Return the peak of a program in a process of its own; raises RuntimeError with its last word where it fails."""
    with TemporaryDirectory(prefix="seat_gear_memory_") as folder:
        command = [sys.executable, "-c", program, str(points), str(Path(folder) / "sweep.csv")]
        done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"A study of {points} points failed: {done.stderr.strip().splitlines()[-1:]}")
    return int(done.stdout.split()[-1]) / 1024


if __name__ == "__main__":
    print(json.dumps(measure().as_dict(), indent=1))

"""Random damage to real logs, in processes of their own: no crash, no hang, no foreign message, no intact chunk lost.

`SEAT_GEAR_RECOVERIES=1000 pytest test/logs/recovery/test_trials.py` runs as many of each kind (minutes).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

TRIALS = int(os.environ.get("SEAT_GEAR_RECOVERIES", "12"))
SCRIPT = Path(__file__).with_name("trials.py")
LIMIT = 200 * 10**6  # bytes; what the requirement allows


@pytest.mark.timeout(60 + 2 * TRIALS)
@pytest.mark.parametrize("kind", ["truncation", "corruption"])
def test_random_damage_costs_what_it_touches_and_nothing_else(kind: str, tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPT), str(tmp_path), kind, "0", str(TRIALS)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["trials"] == TRIALS
    assert found["failures"] == []
    # Were nothing recovered, nothing could be wrong: single damage leaves most of a log, a cut about half of a file.
    assert found["share_kept"] > (0.3 if kind == "truncation" else 0.8)
    assert max(found["peak_resident_bytes"], found["peak_traced_bytes"]) < LIMIT

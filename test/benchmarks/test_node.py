"""What is read of a process, and the programs that are started."""

import os
from pathlib import Path

import pytest

from benchmarks.memory import peak_megabytes
from benchmarks.node import memory, processor_seconds

linux = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="there is no /proc")


@linux
def test_processor_time_only_grows() -> None:
    before = processor_seconds(os.getpid())
    sum(range(100_000))
    assert 0.0 < before <= processor_seconds(os.getpid())


@linux
def test_memory_at_its_peak_is_no_less_than_now() -> None:
    held = memory(os.getpid())
    assert 1.0 < held["VmRSS"] <= held["VmHWM"]


def test_a_program_is_asked_for_its_points_and_gives_its_peak() -> None:
    program = "import sys; assert sys.argv[1] == '7'; print('words'); print(2048)"
    assert peak_megabytes(program, 7) == 2.0


def test_a_program_that_fails_says_why() -> None:
    with pytest.raises(RuntimeError, match="no room for it"):
        peak_megabytes("raise SystemExit('no room for it')", 1)

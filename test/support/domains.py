"""DDS domains for tests: each test on one that no other uses at the moment, also not another run on this machine."""

import fcntl
import os
import random
import tempfile
from collections import deque
from pathlib import Path

_LAST = 99
"""Ports of higher domains lie where Linux takes the ports of outgoing traffic from, and may be taken."""
_HELD = 8
"""Domains a run keeps to itself, the newest: the tests of older ones are over. Twelve runs find enough of them."""
_used: set[int] = set()
_locks: deque[int] = deque()


def fresh_domain() -> int:
    """Return a domain that this run has not used, or once most were used, any; and no other run holds."""
    if len(_used) > 80:
        _used.clear()
    free = [number for number in range(1, _LAST + 1) if number not in _used]
    random.SystemRandom().shuffle(free)
    number = next((each for each in free if _hold(each)), free[0])
    _used.add(number)
    while len(_locks) > _HELD:
        os.close(_locks.popleft())
    return number


def _hold(number: int) -> bool:
    """Lock a domain's file, which the system lets go of when this process ends; return whether it was free."""
    folder = Path(tempfile.gettempdir()) / f"seat_gear_test_domains.{os.getuid()}"
    folder.mkdir(exist_ok=True)
    lock = os.open(folder / str(number), os.O_CREAT | os.O_RDWR)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(lock)
        return False
    _locks.append(lock)
    return True

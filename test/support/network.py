"""Hosts of their own networks on one machine, joined by a cable that loses, delays and can be pulled out.

A host is a Linux network namespace with loopback and one TAP device; the cable is a process that carries every
Ethernet frame between two of them, multicast included. No kernel module is needed, and no root where user namespaces
are open to everybody.
"""

from __future__ import annotations

import ctypes
import fcntl
import heapq
import json
import os
import random
import select
import socket
import struct
import subprocess
import sys
from dataclasses import asdict, dataclass
from itertools import count
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any

ADDRESSES = ("10.77.0.1", "10.77.0.2")
INTERFACE = "bench0"
_NEWUSER, _NEWNET = 0x10000000, 0x40000000
_FRAME = 65536


@dataclass(frozen=True)
class Quality:
    """What a cable does to a frame: lost with probability `loss`, else late by `delay` ± up to `jitter`, in s."""

    loss: float = 0.0
    delay: float = 0.0
    jitter: float = 0.0
    cut: bool = False


class Network:
    """Two hosts and their cable, for as long as the `with` block lasts; `seed` fixes which frames are lost."""

    def __init__(self, seed: int = 0) -> None:
        self._cable = subprocess.Popen(
            [sys.executable, __file__, "cable", str(seed)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self._namespaces: list[int] = self._answer()["namespaces"]

    def __enter__(self) -> Network:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._cable.communicate()

    def on(self, host: int, *command: str) -> tuple[str, ...]:
        """Return the arguments with which Python runs a command of Python's on host 0 or 1."""
        return (__file__, "enter", str(self._cable.pid), str(self._namespaces[host]), *command)

    def set(self, quality: Quality) -> dict[str, int]:
        """Change the cable; returns the counts of frames carried, lost and cut so far."""
        assert self._cable.stdin is not None
        self._cable.stdin.write(json.dumps(asdict(quality)) + "\n")
        self._cable.stdin.flush()
        counts: dict[str, int] = self._answer()
        return counts

    def _answer(self) -> dict[str, Any]:
        assert self._cable.stdout is not None
        line = self._cable.stdout.readline()
        answer: dict[str, Any] = json.loads(line) if line else {"error": "the cable ended without a word"}
        if "error" in answer:
            raise RuntimeError(
                f"No two hosts on this machine: {answer['error']}. Network namespaces and /dev/net/tun are needed: "
                "run as root (in a container with --cap-add SYS_ADMIN,NET_ADMIN --device /dev/net/tun), or allow "
                "user namespaces to everybody."
            )
        return answer


def _checked(code: int, what: str) -> None:
    if code != 0:
        raise OSError(ctypes.get_errno(), f"{what}: {os.strerror(ctypes.get_errno())}")


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _become_root() -> None:
    """Without root, take a user namespace in which this user is."""
    user, group = os.geteuid(), os.getegid()
    if user == 0:
        return
    _checked(_libc().unshare(_NEWUSER), "unshare(CLONE_NEWUSER)")
    Path("/proc/self/setgroups").write_text("deny")
    Path("/proc/self/uid_map").write_text(f"0 {user} 1")
    Path("/proc/self/gid_map").write_text(f"0 {group} 1")


def _make_host(address: str) -> tuple[int, int]:
    """Move this process to a new network; returns its namespace and its TAP device as file descriptors."""
    _checked(_libc().unshare(_NEWNET), "unshare(CLONE_NEWNET)")
    set_interface, is_tap, no_header = 0x400454CA, 0x2, 0x1000
    tap = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tap, set_interface, struct.pack("16sH22x", INTERFACE.encode(), is_tap | no_header))
    _bring_up("lo", None)
    _bring_up(INTERFACE, address)
    return os.open("/proc/self/ns/net", os.O_RDONLY), tap


def _bring_up(name: str, address: str | None) -> None:
    set_flags, set_address, set_mask = 0x8914, 0x8916, 0x891C
    up, running, multicast = 0x1, 0x40, 0x1000
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control:
        for request, value in ((set_address, address), (set_mask, "255.255.255.0")):
            if address is not None:
                where = struct.pack("H2x4s8x", socket.AF_INET, socket.inet_aton(value or ""))
                fcntl.ioctl(control, request, struct.pack("16s16s", name.encode(), where))
        flags = up | running | (multicast if address is not None else 0)
        fcntl.ioctl(control, set_flags, struct.pack("16sH14x", name.encode(), flags))


class _Cable:
    """Carries frames between two TAP devices."""

    def __init__(self, taps: list[int], seed: int) -> None:
        self._other = {taps[0]: taps[1], taps[1]: taps[0]}
        self._random = random.Random(seed)
        self._quality = Quality()
        self._counts = {"carried": 0, "lost": 0, "cut": 0}
        self._order = count()
        self._under_way: list[tuple[float, int, int, bytes]] = []

    def run(self) -> None:
        """Carry until standard input ends; each line there is a new quality and is answered with the counts."""
        while True:
            wait = max(0.0, self._under_way[0][0] - monotonic()) if self._under_way else None
            ready, _, _ = select.select([*self._other, sys.stdin.fileno()], [], [], wait)
            for end in ready:
                if end in self._other:
                    self._take(end)
                elif line := sys.stdin.readline():
                    self._quality = Quality(**json.loads(line))
                    print(json.dumps(self._counts), flush=True)
                else:
                    return
            self._deliver()

    def _take(self, end: int) -> None:
        quality = self._quality
        frame = os.read(end, _FRAME)
        fate = "cut" if quality.cut else "lost" if self._random.random() < quality.loss else "carried"
        self._counts[fate] += 1
        if fate == "carried":
            late = quality.delay + self._random.uniform(-1.0, 1.0) * quality.jitter
            heapq.heappush(self._under_way, (monotonic() + late, next(self._order), self._other[end], frame))

    def _deliver(self) -> None:
        """Hand over what is due; a cut cable delivers nothing that is still under way."""
        now = monotonic()
        while self._under_way and self._under_way[0][0] <= now:
            _, _, end, frame = heapq.heappop(self._under_way)
            if self._quality.cut:
                self._counts["carried"] -= 1
                self._counts["cut"] += 1
            else:
                os.write(end, frame)


def _enter(cable: str, namespace: str, command: list[str]) -> None:
    """Become a Python that runs `command` on a host."""
    if os.geteuid() != 0:
        with open(f"/proc/{cable}/ns/user") as user:
            _checked(_libc().setns(user.fileno(), _NEWUSER), "setns(CLONE_NEWUSER)")
    with open(f"/proc/{cable}/fd/{namespace}") as network:
        _checked(_libc().setns(network.fileno(), _NEWNET), "setns(CLONE_NEWNET)")
    os.execv(sys.executable, [sys.executable, *command])


def _lay_cable(seed: int) -> None:
    try:
        _become_root()
        hosts = [_make_host(address) for address in ADDRESSES]
    except OSError as error:
        print(json.dumps({"error": str(error)}), flush=True)
        return
    print(json.dumps({"namespaces": [namespace for namespace, _ in hosts]}), flush=True)
    _Cable([tap for _, tap in hosts], seed).run()


if __name__ == "__main__":
    if sys.argv[1] == "cable":
        _lay_cable(int(sys.argv[2]))
    else:
        _enter(sys.argv[2], sys.argv[3], sys.argv[4:])

"""From record to record of an MCAP file: which belong where they stand, and which are passed over, for what reason."""

from __future__ import annotations

import os
import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from seat_gear_dynamics.logs.summary import FRAME

IN_CHUNK = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
"""What a chunk may hold."""
IN_DATA = (*IN_CHUNK, Opcode.HEADER, Opcode.CHUNK, Opcode.MESSAGE_INDEX, Opcode.ATTACHMENT, Opcode.METADATA)
"""What the data section may hold before its end."""
_RESERVED, _PRIVATE = 0x10, 0x80  # from here on unknown to this version of the format, from here on applications'
_FOOTER_SIZE, _DATA_END_SIZE = 20, 4
_U32, _U64 = struct.Struct("<I"), struct.Struct("<Q")
_CHUNK_HEAD = 28  # bytes before the name of the codec: times, size, checksum


class DamageError(Exception):
    """A place where a file stops making sense; never leaves this room."""


def belongs(opcode: int, known: Collection[int]) -> bool:
    """Return whether a record of `opcode` may stand where `known` ones do: these, and private ones (0x80 to 0xFF).

    The MCAP specification gives private opcodes to applications, so they are passed over in silence. It reserves 0x01
    to 0x7F: what is unknown there is of a later version of the format, or damage. Readers have to pass over it, but
    nobody says that they may keep silent about it. 0x00 is no opcode.
    """
    return opcode in known or opcode >= _PRIVATE


def frames(file: BinaryIO) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, offset and length of the body of each record of the data section, then of the footer.

    Raises `DamageError` where the file does not begin or end as an MCAP file does.
    """
    size = os.fstat(file.fileno()).st_size
    if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise DamageError("it does not begin like an MCAP file")
    position, in_data, is_footer = len(MCAP0_MAGIC), True, False
    while not is_footer:
        file.seek(position)
        head = file.read(FRAME.size)
        if len(head) < FRAME.size:
            raise DamageError(f"it ends at byte {size} without a footer")
        opcode, length = FRAME.unpack(head)
        begin, position = position + FRAME.size, position + FRAME.size + length
        if position > size:
            raise DamageError(f"it ends at byte {size} inside a record that begins at byte {begin - FRAME.size}")
        is_footer = opcode == Opcode.FOOTER and length == _FOOTER_SIZE
        in_data = in_data and not (opcode == Opcode.DATA_END and length == _DATA_END_SIZE)
        if in_data or is_footer:
            yield opcode, begin, length
    file.seek(position)
    if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise DamageError("its last 8 bytes are not those of an MCAP file")


def misfit(file: BinaryIO, opcode: int, offset: int, length: int) -> str | None:
    """Return why the body at `offset` is none of its opcode in the data section; None where nothing speaks against it.

    Inner lengths must fit the record's, and nothing but a chunk may have a chunk's: so a chunk shows whose opcode was
    damaged into one that is passed over.
    """
    if opcode == Opcode.CHUNK:
        return None if _is_chunk(file, offset, length) else "whose lengths do not agree"
    if opcode == Opcode.MESSAGE_INDEX:
        file.seek(offset)
        head = file.read(min(length, 6))
        size = _U32.unpack_from(head, 2)[0] if len(head) == 6 else 1
        return None if size % 16 == 0 and 6 + size <= length else "whose lengths do not agree"
    if opcode in (Opcode.ATTACHMENT, Opcode.HEADER) or opcode >= _PRIVATE:
        return "with the layout of a chunk" if _is_chunk(file, offset, length, hidden=True) else None
    if opcode in IN_DATA:
        return None
    return "that this version of MCAP does not know" if opcode >= _RESERVED else "that cannot stand there"


def _is_chunk(file: BinaryIO, offset: int, length: int, *, hidden: bool = False) -> bool:
    """Return whether the lengths of codec and records lie within the body; the format may add fields behind them.

    One `hidden` under another opcode has to fill the body and to hold something: zeros alone would fit, too.
    """
    if length < _CHUNK_HEAD + 12:
        return False
    file.seek(offset + _CHUNK_HEAD)
    codec = _U32.unpack(file.read(4))[0]
    if _CHUNK_HEAD + 12 + codec > length:
        return False
    file.seek(offset + _CHUNK_HEAD + 4 + codec)
    records = _U64.unpack(file.read(8))[0]
    end = _CHUNK_HEAD + 12 + codec + records
    return bool(end == length and records if hidden else end <= length)


@dataclass
class Passed:
    """Records of one file that are passed over or missing, gathered for sentences."""

    _faults: dict[tuple[int, str], list[int]] = field(default_factory=dict)
    _lacking: list[str] = field(default_factory=list)
    _nonsense_ends: int = -1

    def take(self, opcode: int, place: int, length: int, fault: str | None) -> None:
        """Count a record at offset `place` if it has a `fault`; raises `DamageError` at the second nonsense in a row.

        One record may be damaged and its length still lead to the next. Two on end are no records.
        """
        if fault is None:
            return
        if not _RESERVED <= opcode < _PRIVATE:
            if place == self._nonsense_ends:
                raise DamageError(f"from byte {place} on it holds no records")
            self._nonsense_ends = place + FRAME.size + length
        self._faults.setdefault((opcode, fault), []).append(place)

    def lack(self, what: str, missing: int | list[int], *, of: int) -> None:
        """Enter how many of those that the summary counts are not there, or the offsets where they should be."""
        count = missing if isinstance(missing, int) else len(missing)
        if count > 0:
            first = "" if isinstance(missing, int) else f" (the first should be at byte {missing[0]})"
            self._lacking.append(f"{count} of {of} {what} that its summary counts are not there{first}.")

    def notes(self) -> Iterator[str]:
        """Yield sentences about all of it."""
        for (opcode, fault), places in self._faults.items():
            count = f"{len(places)} records" if len(places) > 1 else "a record"
            first = "the first " if len(places) > 1 else ""
            yield f"{count} of opcode {opcode:#04x} {fault} ({first}at byte {places[0]}), passed over."
        yield from self._lacking

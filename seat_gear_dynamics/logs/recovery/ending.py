"""The end of a file: its summary, where the checksum is right, is the best witness of all that lies before it."""

from __future__ import annotations

import struct
from bisect import bisect_left
from dataclasses import dataclass, field, replace
from io import BytesIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Statistics
from mcap.writer import MCAP0_MAGIC

from seat_gear_dynamics.logs.recovery.declarations import Declarations
from seat_gear_dynamics.logs.recovery.records import FRAME, DamageError, Record, Source, record_at

_FOOTER = struct.Struct("<QQI")  # offsets of the summary and its offsets section, CRC
_U64 = struct.Struct("<Q")
_DATA_END = FRAME.size + 4
_TAIL = 2**16  # bytes before the end in which the footer is looked for


@dataclass
class Ending:
    """What the end of a file vouches for.

    `found`: there is a footer. `end`: offset where the data section ends. `proven`: the CRC of the whole data section
    is right. `declarations`, `counts` (messages by channel) and `places` (offsets of chunks, attachments and metadata)
    come from a summary with the right CRC; counts and places are None where there is none, or it does not list them.
    """

    found: bool = False
    end: int = 0
    proven: bool = False
    declarations: Declarations = field(default_factory=Declarations)
    counts: dict[int, int] | None = None
    places: list[int] | None = None

    def knows(self, place: int) -> bool:
        """Whether something that the summary lists begins at this offset; without such a list, anything may."""
        if self.places is None:
            return True
        at = bisect_left(self.places, place)
        return at < len(self.places) and self.places[at] == place


def read_ending(source: Source) -> Ending:
    """Read the end of a file, trusting nothing without a checksum."""
    footer = _find_footer(source)
    if footer is None:
        return Ending(end=source.size)
    start, _, crc = _FOOTER.unpack(source.read(footer + FRAME.size, footer + FRAME.size + _FOOTER.size))
    fits = 0 < start <= footer
    ending = Ending(found=True, end=(start if fits else footer) - _DATA_END)
    if fits and crc and source.crc(start, footer + FRAME.size + 16) == crc:
        try:
            _read_summary(source, ending, start, footer)
        except DamageError:
            ending = Ending(found=True, end=ending.end)
    closing = record_at(source, max(0, ending.end))
    if closing is None or closing.opcode != Opcode.DATA_END:
        # Without a proven summary the footer does not tell where the data ends: the walk finds it.
        return ending if ending.counts is not None else replace(ending, end=source.size)
    stated = int.from_bytes(source.read(closing.body, closing.end), "little")
    ending.proven = stated != 0 and source.crc(0, ending.end) == stated
    return ending


def _find_footer(source: Source) -> int | None:
    """Return the offset of the last footer that has an end of file behind it; bytes of a message may look like one."""
    pattern = FRAME.pack(Opcode.FOOTER, _FOOTER.size)
    begin = max(0, source.size - _TAIL)
    at = source.read(begin, source.size).rfind(pattern)
    if at < 0:
        return None
    behind = begin + at + FRAME.size + _FOOTER.size
    closed = source.read(behind, behind + len(MCAP0_MAGIC)) == MCAP0_MAGIC
    return begin + at if closed or 0 <= source.size - behind <= len(MCAP0_MAGIC) else None


def _read_summary(source: Source, ending: Ending, start: int, end: int) -> None:
    places: list[int] = []
    chunks = 0
    statistics: Statistics | None = None
    position = start
    while position < end:
        opcode, length = FRAME.unpack(source.read(position, position + FRAME.size))
        record = Record(opcode, position, position + FRAME.size + length)
        if record.end > end:
            raise DamageError("the summary does not make sense")
        if record.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            ending.declarations.add(record.opcode, source.read(record.body, record.end))
        elif record.opcode == Opcode.STATISTICS:
            statistics = _statistics(source, record)
        elif record.opcode == Opcode.CHUNK_INDEX:
            chunks += 1
            places.append(_U64.unpack(source.read(record.body + 16, record.body + 24))[0])
        elif record.opcode in (Opcode.ATTACHMENT_INDEX, Opcode.METADATA_INDEX):
            places.append(_U64.unpack(source.read(record.body, record.body + 8))[0])
        position = record.end
    if statistics is not None:
        ending.counts = dict(statistics.channel_message_counts)
        if len(places) == statistics.chunk_count + statistics.attachment_count + statistics.metadata_count and chunks:
            ending.places = sorted(places)


def _statistics(source: Source, record: Record) -> Statistics:
    try:
        found: Statistics = Statistics.read(ReadDataStream(BytesIO(source.read(record.body, record.end))))
    except Exception as cause:  # as any other damage
        raise DamageError("the statistics cannot be read") from cause
    return found

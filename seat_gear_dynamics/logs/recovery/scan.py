"""Walks a damaged file from record to record, finds its way again behind damage, and tells what is sound."""

from __future__ import annotations

import hashlib
import re
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from seat_gear_dynamics.logs.metadata import RECORD_NAME
from seat_gear_dynamics.logs.recovery.chunks import LARGEST_CHUNK, Layout, layouts, unpack
from seat_gear_dynamics.logs.recovery.declarations import Declarations
from seat_gear_dynamics.logs.recovery.ending import Ending, read_ending
from seat_gear_dynamics.logs.recovery.records import (
    FRAME,
    MESSAGE,
    DamageError,
    Record,
    Source,
    parse_metadata,
    record_at,
    split,
)

_LATEST = 2**63  # ns; rosbag2 holds times in 64 signed bits
_LARGEST_RUN = 2**20  # bytes of records outside chunks that are handled at a time
_BLOCK = 2**16  # bytes that are searched at a time
_UNPROVEN = "no checksum vouches for it"
# Opcodes whose shape says little, so that a chunk with a damaged opcode can hide behind them.
_WEAK = {Opcode.MESSAGE, Opcode.CHUNK_INDEX, Opcode.STATISTICS, Opcode.ATTACHMENT_INDEX, Opcode.METADATA_INDEX}
# What the search stops at: records of many inner agreements. Loose messages, types and topics have none.
_LANDMARKS = (Opcode.CHUNK, Opcode.MESSAGE_INDEX, Opcode.ATTACHMENT, Opcode.METADATA, Opcode.DATA_END, Opcode.FOOTER)


class Piece(NamedTuple):
    """A sound stretch of the file: a chunk (with its layout), a run of loose records, an attachment, or metadata."""

    opcode: int
    begin: int
    end: int
    layout: Layout | None = None


class Lost(NamedTuple):
    """Bytes that could not be used, and why."""

    begin: int
    end: int
    reason: str


@dataclass
class Content:
    """What the records of a chunk or run hold: declarations, messages by channel, first and last log time."""

    declarations: Declarations = field(default_factory=Declarations)
    counts: Counter[int] = field(default_factory=Counter)
    start_ns: int = _LATEST
    end_ns: int = -1

    def read(self, records: bytes) -> None:
        """Enter records; raises `DamageError` for what does not parse to its last byte."""
        for opcode, begin, end in split(records):
            if opcode == Opcode.MESSAGE:
                channel, _, log_ns, _ = MESSAGE.unpack_from(records, begin)
                self.counts[channel] += 1
                self.start_ns, self.end_ns = min(self.start_ns, log_ns), max(self.end_ns, log_ns)
            else:
                self.declarations.add(opcode, records[begin:end])


@dataclass
class Survey:
    """What a file holds that can be kept (`pieces`, in the file's order) and what cannot (`lost`)."""

    ending: Ending
    pieces: list[Piece] = field(default_factory=list)
    lost: list[Lost] = field(default_factory=list)
    declarations: Declarations = field(default_factory=Declarations)
    counts: Counter[int] = field(default_factory=Counter)
    """Messages by channel in the pieces, those of channels that are not declared included."""
    unproven: int = 0
    """Pieces for which no checksum vouches: kept ones with `unchecked`, else left out."""
    profile: str = ""
    library: str = ""

    def lose(self, begin: int, end: int, reason: str) -> None:
        """Note bytes as lost; neighbours lost for one reason become one range."""
        if self.lost and self.lost[-1].end == begin and self.lost[-1].reason == reason:
            begin = self.lost.pop().begin
        if begin < end:
            self.lost.append(Lost(begin, end, reason))


def survey(source: Source, *, unchecked: bool = False, progress: Callable[[int], None] | None = None) -> Survey:
    """Find everything in a file that can be kept; raises `OSError`.

    With `unchecked`, chunks and loose records without a checksum are kept too if they are well-formed, loose ones up to
    the first damage. One chunk and one MiB are in memory at a time. The time taken grows with the file's size alone.
    `progress` is told the offset reached.
    """
    return _Walk(source, unchecked, progress or (lambda offset: None)).run()


class _Walk:
    def __init__(self, source: Source, unchecked: bool, tell: Callable[[int], None]) -> None:
        self._source = source
        self._tell = tell
        self._unchecked = unchecked
        self._ending = read_ending(source)
        self._found = Survey(self._ending)
        self._found.declarations.include(self._ending.declarations)
        self._trusting = True  # until the first damage; loose records are taken no longer
        self._patience = 16 * source.size + LARGEST_CHUNK  # bytes unpacked in vain before guesses are given up
        zeros = 8 - max(1, (source.size.bit_length() + 7) // 8)
        opcodes = b"".join(re.escape(bytes([opcode])) for opcode in _LANDMARKS)
        # A look-ahead, so that candidates may overlap. No length exceeds the file, hence the zeros.
        self._landmark = re.compile(b"(?=[%s].{%d}\0{%d})" % (opcodes, 8 - zeros, zeros), re.DOTALL)

    def run(self) -> Survey:
        position: int | None = len(MCAP0_MAGIC)
        if self._source.read(0, len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            self._found.lose(0, min(len(MCAP0_MAGIC), self._source.size), "it does not begin like an MCAP file")
        while position is not None and position < self._ending.end:
            position = self._step(position)
            self._tell(self._ending.end if position is None else position)
        return self._found

    def _step(self, position: int) -> int | None:
        """Take or lose what lies at `position`; return where to go on, None at the end of the data."""
        record = record_at(self._source, position)
        reason = "no record begins here that ends within the file"
        if record is not None:
            reason = "the chunk cannot be read"
        if record is None or record.opcode == Opcode.CHUNK or record.opcode in _WEAK:
            for layout in layouts(self._source, position):
                try:
                    return self._take_chunk(layout)
                except DamageError as damage:
                    reason = str(damage) if layout.sure else reason
        if record is None:
            return self._search(position, reason)
        if record.opcode == Opcode.CHUNK:
            return self._leave_chunk(record, reason)
        if record.opcode == Opcode.DATA_END and self._ends(record):
            return None
        try:
            self._take(record)
        except DamageError as damage:
            self._lose(record, str(damage))
        return record.end

    def _take_chunk(self, layout: Layout) -> int:
        if not self._ending.knows(layout.begin):
            raise DamageError("the summary does not know this chunk")
        if not layout.sure and self._patience <= 0:
            raise DamageError("too many guesses have failed")
        content = Content()
        try:
            records, _, proven = unpack(self._source, layout)
            content.read(records)
            proven = proven or self._ending.proven
            if not proven:
                self._accept_unproven(layout, len(records), content)
        except DamageError:
            self._patience -= layout.end - layout.data + 1
            raise
        self._found.declarations.include(content.declarations)
        self._keep(Piece(Opcode.CHUNK, layout.begin, layout.end, layout), content, proven)
        return layout.end

    def _accept_unproven(self, layout: Layout, size: int, content: Content) -> None:
        if not layout.sure:
            raise DamageError(_UNPROVEN)
        if not self._unchecked:
            self._found.unproven += 1
            raise DamageError(_UNPROVEN)
        times = (content.start_ns, content.end_ns) if content.counts else (layout.start_ns, layout.end_ns)
        if size != layout.size or times != (layout.start_ns, layout.end_ns) or content.end_ns >= _LATEST:
            raise DamageError("the chunk, which has no checksum, contradicts its own head")

    def _leave_chunk(self, record: Record, reason: str) -> int | None:
        """Pass over a damaged chunk as a whole if a record follows it, else look for records behind its head."""
        if self._followed(record) or self._patience <= 0:
            self._lose(record, reason)
            return record.end
        return self._search(record.begin, reason)

    def _ends(self, record: Record) -> bool:
        """Whether the data section ends here, which something of a summary or the footer then follows."""
        if self._ending.found and record.begin == self._ending.end:
            return True
        return self._followed(record)

    def _followed(self, record: Record) -> bool:
        return record.end >= self._source.size or record_at(self._source, record.end) is not None

    def _take(self, record: Record) -> None:
        body = record.body
        if record.opcode == Opcode.HEADER and record.begin == len(MCAP0_MAGIC):
            texts = self._source.read(body, record.end)
            self._found.profile, self._found.library = _header(texts)
        elif record.opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
            self._take_loose(record)
        elif record.opcode == Opcode.ATTACHMENT:
            self._take_attachment(record)
        elif record.opcode == Opcode.METADATA:
            self._take_metadata(record)
        # Indexes are made anew, so nothing is lost with them; nor with statistics that have strayed here.

    def _take_loose(self, record: Record) -> None:
        if record.end - record.begin > LARGEST_CHUNK:
            raise DamageError(f"a record of {record.end - record.begin} bytes is too large to be believed")
        if not self._ending.proven and not (self._unchecked and self._trusting):
            self._found.unproven += 1
            raise DamageError(f"it lies outside chunks and {_UNPROVEN}")
        if not self._ending.proven and not self._followed(record):
            raise DamageError("no record follows where this one ends, so that its length is in doubt")
        content = Content()
        content.read(self._source.read(record.begin, record.end))
        if content.end_ns >= _LATEST:
            raise DamageError("its log time is impossible")
        self._found.declarations.include(content.declarations)
        begin, last = record.begin, self._found.pieces[-1] if self._found.pieces else None
        if last and last.opcode == Opcode.MESSAGE and last.end == begin and begin - last.begin < _LARGEST_RUN:
            begin = self._found.pieces.pop().begin
            self._found.unproven -= not self._ending.proven
        self._keep(Piece(Opcode.MESSAGE, begin, record.end), content, self._ending.proven)

    def _take_attachment(self, record: Record) -> None:
        crc = int.from_bytes(self._source.read(record.end - 4, record.end), "little")
        proven = self._ending.proven
        if crc and self._source.crc(record.body, record.end - 4) != crc:
            raise DamageError("the attachment's checksum is wrong")
        if not crc and not proven and not self._unchecked:
            self._found.unproven += 1
            raise DamageError(f"an attachment: {_UNPROVEN}")
        self._keep(Piece(Opcode.ATTACHMENT, record.begin, record.end), Content(), bool(crc) or proven)

    def _take_metadata(self, record: Record) -> None:
        metadata = parse_metadata(self._source.read(record.body, record.end))
        if metadata.name == RECORD_NAME and not _hash_fits(metadata.metadata):
            raise DamageError("the system description does not have the hash that stands beside it")
        # Nothing in the format proves metadata; what is no message is kept without.
        self._found.pieces.append(Piece(Opcode.METADATA, record.begin, record.end))

    def _keep(self, piece: Piece, content: Content, proven: bool) -> None:
        self._found.unproven += not proven
        self._found.counts.update(content.counts)
        self._found.pieces.append(piece)

    def _lose(self, record: Record, reason: str) -> None:
        self._trusting = self._trusting and reason.endswith(_UNPROVEN)
        self._found.lose(record.begin, record.end, reason)

    def _search(self, begin: int, reason: str) -> int | None:
        """Lose the bytes from `begin` to the next place that makes sense, and return it."""
        self._trusting = False
        end = next(self._candidates(begin + 1), None)
        self._found.lose(begin, self._ending.end if end is None else end, reason)
        return end

    def _candidates(self, begin: int) -> Iterator[int]:
        places = self._ending.places
        if places is not None:
            yield from (place for place in places[bisect_left(places, begin) :] if place < self._ending.end)
            return
        while begin < self._ending.end:
            self._tell(begin)
            # The frame of a candidate may reach into the next block, and so may the magic of a file within.
            block = self._source.read(begin, begin + _BLOCK + FRAME.size)
            magic = block.find(MCAP0_MAGIC)
            for match in self._landmark.finditer(block[: magic if magic >= 0 else None]):
                if match.start() < _BLOCK and record_at(self._source, begin + match.start()) is not None:
                    yield begin + match.start()
            if magic >= 0:
                begin = self._behind_embedded(begin + magic)
            else:
                begin += _BLOCK

    def _behind_embedded(self, magic: int) -> int:
        """Return the offset behind a whole MCAP file within the data, whose chunks are none of this file's."""
        begin = magic + len(MCAP0_MAGIC)
        while begin < self._ending.end:
            at = self._source.read(begin, begin + _BLOCK + len(MCAP0_MAGIC) - 1).find(MCAP0_MAGIC)
            if at >= 0:
                return begin + at + len(MCAP0_MAGIC)
            begin += _BLOCK
        return self._ending.end


def _header(body: bytes) -> tuple[str, str]:
    length = int.from_bytes(body[:4], "little")
    profile, library = body[4 : 4 + length], body[8 + length :]
    return profile.decode(errors="replace"), library.decode(errors="replace")


def _hash_fits(metadata: dict[str, str]) -> bool:
    text, stated = metadata.get("system"), metadata.get("system_hash")
    return text is None or not stated or hashlib.sha256(text.encode()).hexdigest() == stated

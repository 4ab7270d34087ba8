"""Writes one sound MCAP file from what a survey has found sound: chunks as they were, indexes and summary anew."""

from __future__ import annotations

import os
import struct
import zlib
from array import array
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

from seat_gear_dynamics.logs.metadata import FileRecord
from seat_gear_dynamics.logs.recovery.chunks import pack
from seat_gear_dynamics.logs.recovery.declarations import Declarations
from seat_gear_dynamics.logs.recovery.records import FRAME, MESSAGE, Record, Source, parse_channel, split
from seat_gear_dynamics.logs.recovery.tally import Tally

_TIMES = struct.Struct("<QQ")
_CHUNK_HEAD = struct.Struct("<QQQII")  # first and last log time, size unpacked, CRC, length of the codec's name
_INDEX_HEAD = struct.Struct("<HI")


class RebuiltFile:
    """One MCAP file being written, in the order of the calls; raises `OSError` as the system does.

    `declarations` are the channels that may appear; messages of others are left out. All of the channels are declared
    in the first chunk. The data section has a CRC, so that metadata is covered too.
    """

    def __init__(self, path: Path, *, profile: str, library: str, declarations: Declarations, tally: Tally) -> None:
        self.path = path
        self._known = declarations
        self._tally = tally
        self._file = open(path, "xb")  # noqa: SIM115  # closed by finish and abandon
        self._position = self._crc = 0
        self._declared = Declarations()
        self._indexes: dict[int, list[McapRecord]] = {
            Opcode.CHUNK_INDEX: [],
            Opcode.ATTACHMENT_INDEX: [],
            Opcode.METADATA_INDEX: [],
        }
        self._counts: Counter[int] = Counter()
        self._start: int | None = None
        self._end: int | None = None
        self._put(MCAP0_MAGIC)
        self._put(_encode(Header(profile=profile, library=library)))

    @property
    def record(self) -> FileRecord:
        """Describe what has been written."""
        counts: Counter[str] = Counter()
        for number, count in self._counts.items():
            counts[self._known.channels[number].topic] += count
        return FileRecord(self.path.name, self._start, self._end, counts)

    def add_records(self, records: bytes, packed: bytes | None, codec: str) -> None:
        """Append the records of a chunk; `packed` are the same bytes compressed, used again where nothing changes."""
        changed = self._revise(records)
        if changed is not None:
            records, packed = changed, None
        index, times = self._note(records)
        if not index:
            return
        self._declared = self._known
        data = pack(records, codec) if packed is None else packed
        fields = _CHUNK_HEAD.pack(*times, len(records), zlib.crc32(records), len(codec)) + codec.encode()
        begin = self._position
        # In two parts, so that large chunks are not copied once more.
        self._put(FRAME.pack(Opcode.CHUNK, len(fields) + 8 + len(data)) + fields + struct.pack("<Q", len(data)))
        self._put(data)
        length, offsets = self._position - begin, {}
        for number, entries in index.items():
            offsets[number] = self._position
            body = np.frombuffer(entries, np.uint64).astype("<u8").tobytes()
            head = FRAME.pack(Opcode.MESSAGE_INDEX, _INDEX_HEAD.size + len(body))
            self._put(head + _INDEX_HEAD.pack(number, len(body)) + body)
        self._indexes[Opcode.CHUNK_INDEX].append(
            ChunkIndex(
                message_start_time=times[0],
                message_end_time=times[1],
                chunk_start_offset=begin,
                chunk_length=length,
                message_index_offsets=offsets,
                message_index_length=self._position - begin - length,
                compression=codec,
                compressed_size=len(data),
                uncompressed_size=len(records),
            )
        )

    def add_attachment(self, source: Source, record: Record) -> None:
        """Copy an attachment byte by byte."""
        begin = self._position
        for piece in source.pieces(record.begin, record.end):
            self._put(piece)
        log_ns, create_ns = _TIMES.unpack(source.read(record.body, record.body + _TIMES.size))
        name, position = _text(source, record.body + _TIMES.size)
        media, position = _text(source, position)
        size = record.end - position - 12  # its own length before the data, the CRC behind
        index = AttachmentIndex(
            offset=begin,
            length=self._position - begin,
            log_time=log_ns,
            create_time=create_ns,
            data_size=size,
            name=name,
            media_type=media,
        )
        self._indexes[Opcode.ATTACHMENT_INDEX].append(index)

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Append a metadata record."""
        begin = self._position
        self._put(_encode(Metadata(name=name, metadata=dict(values))))
        self._indexes[Opcode.METADATA_INDEX].append(
            MetadataIndex(offset=begin, length=self._position - begin, name=name)
        )

    def finish(self) -> None:
        """Write summary and footer, sync and close."""
        self._put(_encode(DataEnd(data_section_crc=self._crc)))
        start = self._position
        summary, offsets = RecordBuilder(), RecordBuilder()
        for opcode, group in self._summary():
            begin = summary.count
            for record in group:
                record.write(summary)
            if summary.count > begin:
                SummaryOffset(group_opcode=opcode, group_start=start + begin, group_length=summary.count - begin).write(
                    offsets
                )
        body = _end(summary)
        section = start + len(body)
        body += _end(offsets)
        fields = FRAME.pack(Opcode.FOOTER, 20) + struct.pack("<QQ", start, section)
        footer = Footer(summary_start=start, summary_offset_start=section, summary_crc=zlib.crc32(body + fields))
        self._put(body)
        self._put(_encode(footer) + MCAP0_MAGIC)
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()

    def abandon(self) -> None:
        """Close the file as it is."""
        self._file.close()

    def _summary(self) -> Iterable[tuple[Opcode, Iterable[McapRecord]]]:
        schemas, channels = self._declared.schemas, self._declared.channels
        chunks, attachments, metadata = self._indexes.values()
        statistics = Statistics(
            attachment_count=len(attachments),
            channel_count=len(channels),
            channel_message_counts=dict(self._counts),
            chunk_count=len(chunks),
            message_count=self._counts.total(),
            message_end_time=self._end or 0,
            message_start_time=self._start or 0,
            metadata_count=len(metadata),
            schema_count=len(schemas),
        )
        yield Opcode.SCHEMA, schemas.values()
        yield Opcode.CHANNEL, channels.values()
        yield Opcode.STATISTICS, [statistics]
        yield Opcode.CHUNK_INDEX, chunks
        yield Opcode.ATTACHMENT_INDEX, attachments
        yield Opcode.METADATA_INDEX, metadata

    def _revise(self, records: bytes) -> bytes | None:
        """Return the records with missing declarations before them and without nameless messages; None if equal."""
        here, sound = Declarations(), True
        for opcode, begin, end in split(records):
            if opcode == Opcode.MESSAGE:
                sound = sound and MESSAGE.unpack_from(records, begin)[0] in self._known.channels
            elif opcode == Opcode.SCHEMA:
                here.add(opcode, records[begin:end])
            elif opcode == Opcode.CHANNEL:
                channel = parse_channel(records[begin:end])
                sound = sound and channel.id in self._known.channels
                here.channels[channel.id] = channel
        prefix = self._missing(here)
        if sound and not prefix:
            return None
        kept = (
            records[begin - FRAME.size : end]
            for opcode, begin, end in split(records)
            if self._wanted(opcode, records, begin, end)
        )
        return prefix + b"".join(kept)

    def _missing(self, here: Declarations) -> bytes:
        schemas = [s for n, s in self._known.schemas.items() if n not in self._declared.schemas | here.schemas]
        channels = [c for n, c in self._known.channels.items() if n not in self._declared.channels | here.channels]
        return b"".join(_encode(record) for record in [*schemas, *channels])

    def _wanted(self, opcode: int, records: bytes, begin: int, end: int) -> bool:
        if opcode == Opcode.CHANNEL:
            return parse_channel(records[begin:end]).id in self._known.channels
        if opcode != Opcode.MESSAGE:
            return True
        return MESSAGE.unpack_from(records, begin)[0] in self._known.channels

    def _note(self, records: bytes) -> tuple[dict[int, array[int]], tuple[int, int]]:
        """Count, tally and index the messages; return the index (time, offset, …) by channel, first and last time."""
        index: dict[int, array[int]] = {}
        start, stop = 2**64, -1
        for opcode, begin, end in split(records):
            if opcode != Opcode.MESSAGE:
                continue
            number, _, log_ns, publish_ns = MESSAGE.unpack_from(records, begin)
            index.setdefault(number, array("Q")).extend((log_ns, begin - FRAME.size))
            start, stop = min(start, log_ns), max(stop, log_ns)
            topic = self._known.channels[number].topic
            self._tally.add(topic, log_ns, publish_ns, records[begin + MESSAGE.size : end])
        for number, entries in index.items():
            self._counts[number] += len(entries) // 2
        if index:
            self._start = start if self._start is None else min(self._start, start)
            self._end = stop if self._end is None else max(self._end, stop)
        return index, (start, stop)

    def _put(self, data: bytes) -> None:
        self._file.write(data)
        self._crc = zlib.crc32(data, self._crc)
        self._position += len(data)


def _encode(record: Schema | Channel | McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return _end(builder)


def _end(builder: RecordBuilder) -> bytes:
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


def _text(source: Source, position: int) -> tuple[str, int]:
    begin = position + 4
    end = begin + int.from_bytes(source.read(position, begin), "little")
    return source.read(begin, end).decode(errors="replace"), end

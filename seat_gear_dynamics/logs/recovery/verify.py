"""Reads a recovered bag back with three readers, none of which shares code with the rebuilding."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Message
from mcap.stream_reader import StreamReader, get_chunk_data_stream
from rosbags.rosbag2 import Reader

from seat_gear_dynamics.logs import container
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.recovery.tally import Tally


def verify(
    bag: Path, written: Tally, *, ros2: bool, progress: Callable[[int, int], None] | None = None
) -> tuple[tuple[str, ...], list[str]]:
    """Return the readers that found exactly the messages that were written, and sentences about those that could not.

    Raises `LogError` where this project's reader or the mcap library finds anything else. rosbags opens the bag and
    counts; it refuses some bags of foreign types, which is told and not fatal. One chunk at a time is in memory.
    `progress` is told (messages read by the first two, how many in all).
    """
    tell, messages = progress or (lambda done, total: None), _count(written)
    _compare("this project's reader", bag, written, _read_ours, lambda done: tell(done, 2 * messages))
    _compare("the mcap library", bag, written, _read_mcap, lambda done: tell(messages + done, 2 * messages))
    verified = ("seat_gear_dynamics", "mcap")
    if not ros2:
        return verified, ["rosbags was not asked: the log does not follow ROS 2's profile."]
    try:
        with Reader(bag) as reader:
            found = reader.message_count
    except Exception as cause:  # what it refuses, it refuses in many ways
        return verified, [f"rosbags does not open the recovered log ({cause})."]
    if found != messages:
        raise LogError(f"The recovered log {bag} was written wrongly: rosbags counts {found} messages in it.")
    return (*verified, "rosbags"), []


def _count(tally: Tally) -> int:
    return sum(count for count, _ in tally.topics.values())


def _read_ours(bag: Path, tell: Callable[[int], None]) -> Tally:
    opened = Bag(bag)
    if opened.damage is not None or not opened.closed:
        raise LogError(f"The recovered log {bag} does not read back: {opened.damage or 'it has no end'}.")
    tally = Tally()
    for path in opened.files:
        contents = container.scan(path)
        names: dict[int, str] = {number: channel.topic for number, channel in contents.channels.items()}
        for block in contents.blocks:
            for message in block.messages(names):
                tally.add(names[message.channel], message.log_time_ns, message.publish_time_ns, message.data)
            tell(_count(tally))
    return tally


def _read_mcap(bag: Path, tell: Callable[[int], None]) -> Tally:
    tally = Tally()
    for path in sorted(bag.glob("*.mcap")):
        with open(path, "rb") as file:
            summary = make_reader(file).get_summary()
            file.seek(0)
            count = 0
            # Not its iterator of messages, which holds all messages of a file at once where they come unsorted.
            for record in StreamReader(file, emit_chunks=True, validate_crcs=True).records:
                if isinstance(record, Chunk) and summary is not None:
                    count += _read_chunk(record, summary.channels, tally)
                    tell(_count(tally))
        if summary is None or summary.statistics is None or summary.statistics.message_count != count:
            raise ValueError(f"the summary of {path.name} does not count {count} messages")
    return tally


def _read_chunk(chunk: Chunk, channels: Mapping[int, Channel], tally: Tally) -> int:
    stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    count = 0
    while stream.count < length:
        opcode, size = stream.read1(), stream.read8()
        if opcode != Opcode.MESSAGE:
            stream.read(size)
            continue
        message = Message.read(stream, size)
        tally.add(channels[message.channel_id].topic, message.log_time, message.publish_time, message.data)
        count += 1
    return count


def _compare(
    reader: str,
    bag: Path,
    written: Tally,
    read: Callable[[Path, Callable[[int], None]], Tally],
    tell: Callable[[int], None],
) -> None:
    try:
        found = read(bag, tell)
    except (LogError, OSError):
        raise
    except Exception as cause:  # each reader has errors of its own; all mean the same here
        raise LogError(f"The recovered log {bag} does not read back: {reader} fails ({cause}).") from cause
    if found.topics != written.topics:
        counts = [_count(tally) for tally in (found, written)]
        raise LogError(
            f"The recovered log {bag} does not read back: {reader} finds {counts[0]} messages of {counts[1]} written, "
            f"or others. Keep the damaged log, and report this with it."
        )

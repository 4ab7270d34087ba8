"""Recovery from end to end: survey every file, name what has lost its name, rebuild, read back, put in place."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from mcap.opcode import Opcode

from seat_gear_dynamics.logs.disk import replace_text, sync_folder
from seat_gear_dynamics.logs.errors import LogError, reason
from seat_gear_dynamics.logs.metadata import FILE_NAME, FileRecord
from seat_gear_dynamics.logs.recovery.chunks import unpack
from seat_gear_dynamics.logs.recovery.claims import Claims, read_claims
from seat_gear_dynamics.logs.recovery.declarations import Declarations, agreeing
from seat_gear_dynamics.logs.recovery.describe import Description
from seat_gear_dynamics.logs.recovery.rebuild import RebuiltFile
from seat_gear_dynamics.logs.recovery.records import DamageError, Record, Source, parse_metadata
from seat_gear_dynamics.logs.recovery.result import FileResult, Recovery, TopicResult
from seat_gear_dynamics.logs.recovery.scan import Piece, Survey, survey
from seat_gear_dynamics.logs.recovery.tally import Tally
from seat_gear_dynamics.logs.recovery.verify import verify

Tell = Callable[[str, int, int], None]
"""Takes (stage, done, in all)."""

_ROSBAG2 = "rosbag2"  # its metadata record: counts and files, which are stated anew
_OURS = re.compile(r"seat_gear_dynamics \d")  # the recorder's library text; its channels have one order in all files


@dataclass
class _File:
    """A file of the damaged log and what has become of it."""

    path: Path
    size: int
    found: Survey
    declarations: Declarations
    record: FileRecord | None = None

    @property
    def kept(self) -> int:
        """Sound messages of known topics."""
        return sum(count for number, count in self.found.counts.items() if number in self.declarations.channels)

    @property
    def nameless(self) -> int:
        """Sound messages that are left out, because nothing says what their channel is."""
        return self.found.counts.total() - self.kept

    @property
    def worth_writing(self) -> bool:
        """Whether anything but metadata is left of the file."""
        return self.kept > 0 or any(piece.opcode == Opcode.ATTACHMENT for piece in self.found.pieces)


def default_output(log: Path) -> Path:
    """Return `NAME_recovered` beside the log."""
    log = Path(os.path.abspath(log))  # without the dots of a relative path, which have no name
    return log.with_name(f"{log.stem if log.is_file() else log.name}_recovered")


def recover(
    log: Path | str,
    output: Path | str | None = None,
    *,
    unchecked: bool = False,
    version: str = "0",
    tell: Tell | None = None,
) -> Recovery:
    """Write a sound bag of everything in a damaged log that a checksum vouches for; the log itself is only read.

    `log`: a bag directory, with metadata.yaml or without, or one .mcap file. `output`: the new bag's directory, which
    must not exist (default: `NAME_recovered` beside the log). `unchecked`: keep well-formed messages without a checksum
    too; a wrong byte in them cannot be found. `version`: of the software, kept in the files. `tell` gets (stage, done,
    in all): MiB searched and written, then messages read back.

    A chunk is kept whole or not at all: when the CRC over its content is right, or a checksum of its codec's, or the
    CRC of the whole data section. Its messages keep bytes, times, sequence numbers and topics. The new bag has been
    read back before it gets its name. Raises `LogError` when nothing can be recovered or written.
    """
    log = Path(os.path.abspath(log))
    target = Path(output).absolute() if output is not None else default_output(log)
    claims = read_claims(log)
    _check_target(log, target)
    tell = tell or (lambda stage, done, total: None)
    try:
        files = list(_surveyed(claims.files, unchecked, tell))
        notes = _name_channels(files, claims, unchecked)
        _demand_something(log, files, unchecked)
        target.parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f".{target.name}_", dir=target.parent))
        try:
            return _write(log, target, folder, claims, files, notes, unchecked, version, tell)
        finally:
            shutil.rmtree(folder, ignore_errors=True)
    except OSError as cause:
        raise LogError(
            f"The log {log} cannot be recovered to {target}: {reason(cause)}. Check the disk, or choose another "
            f"--output."
        ) from cause


def _check_target(log: Path, target: Path) -> None:
    if target.exists() or target.is_symlink():
        raise LogError(f"The folder {target} exists already; move it, or choose another with --output.")
    if log.resolve() in target.resolve().parents:
        raise LogError(f"The folder {target} would lie in the damaged log, which is never touched; choose another.")


def _surveyed(paths: Sequence[Path], unchecked: bool, tell: Tell) -> Iterator[_File]:
    begin, total = 0, sum(path.stat().st_size for path in paths)
    for path in paths:
        told = _in_mebibytes("searching, MiB", begin, total, tell)
        told(0)
        with Source(path) as source:
            found = survey(source, unchecked=unchecked, progress=told)
            yield _File(path, source.size, found, found.declarations.usable())
            begin += source.size


def _in_mebibytes(stage: str, begin: int, total: int, tell: Tell) -> Callable[[int], None]:
    """Return what tells of an offset in a file that `begin` bytes lie before, each MiB once; the end is rounded up."""
    last = -1

    def told(offset: int) -> None:
        nonlocal last
        done = -(-(begin + offset) >> 20)
        if done != last:
            last = done
            tell(stage, done, -(-total >> 20))

    return told


def _name_channels(files: list[_File], claims: Claims, unchecked: bool) -> list[str]:
    """Give channels whose declaration is lost their name, where something else states it; return what was done."""
    notes = [claims.problem] if claims.problem else []
    notes += [f"{name}, which metadata.yaml lists, is missing." for name in claims.missing]
    donors = {f.path.name: f.declarations for f in files if _OURS.match(f.found.library)}
    shared = agreeing(donors)
    for file in files:
        wanted = {n for n in file.found.counts if n not in file.declarations.channels}
        if not wanted or not _OURS.match(file.found.library):
            continue
        if taken := file.declarations.fill(wanted, shared):
            notes.append(f"{file.path.name}: the names of {len(taken)} topics were lost, and taken from other files.")
        if unchecked and (taken := file.declarations.fill(wanted, claims.declarations())):
            notes.append(f"{file.path.name}: the names of {len(taken)} topics were lost, and taken from {FILE_NAME}.")
    return notes


def _demand_something(log: Path, files: list[_File], unchecked: bool) -> None:
    if any(file.worth_writing for file in files):
        return
    nameless = sum(file.nameless for file in files)
    unproven = sum(file.found.unproven for file in files)
    why = "no sound message is left in it"
    if nameless:
        why = f"nothing says to which topics its {nameless} sound messages belong"
    elif unproven and not unchecked:
        why = "no checksum vouches for any message in it"
    hint = "; --unchecked keeps what is at least well-formed" if (nameless or unproven) and not unchecked else ""
    raise LogError(f"Nothing of the log {log} can be recovered: {why}{hint}.")


def _write(
    log: Path,
    target: Path,
    folder: Path,
    claims: Claims,
    files: list[_File],
    notes: list[str],
    unchecked: bool,
    version: str,
    tell: Tell,
) -> Recovery:
    tally = Tally()
    lost = sum(len(file.found.lost) for file in files)
    description = Description(
        claims, claims.custom_data | {"recovered_from": log.name, "recovery": f"{lost} damaged stretches left out"}
    )
    records: list[FileRecord] = []
    begin, total = 0, sum(file.size for file in files)
    for file in files:
        told = _in_mebibytes("writing, MiB", begin, total, tell)
        begin += file.size
        if file.worth_writing:
            path = folder / f"{target.name}_{len(records)}.mcap"
            description.add_topics(file.declarations)
            records.append(_rebuild(file, path, version, tally, description, records, told))
    replace_text(folder / FILE_NAME, description.document(records))
    ros2 = all(_profile(file) == "ros2" for file in files if file.record)
    verified, doubts = verify(folder, tally, ros2=ros2, progress=lambda done, all: tell("reading back", done, all))
    _put_in_place(folder, target)
    notes = [*notes, *_nameless_notes(files), *doubts]
    if unchecked and any(file.found.unproven for file in files):
        notes.append("Some of it has no checksum and was kept unchecked: a wrong byte in it would not be noticed.")
    return Recovery(
        log=log,
        output=target,
        topics=_topics(files, claims, tally),
        files=tuple(_file_result(file) for file in files),
        unchecked=unchecked,
        unproven=sum(file.found.unproven for file in files),
        notes=tuple(notes),
        verified_by=verified,
    )


def _put_in_place(folder: Path, target: Path) -> None:
    folder.chmod(0o755)  # a temporary folder is its owner's alone
    if target.exists():
        raise LogError(f"The folder {target} has come into being meanwhile; choose another with --output.")
    folder.rename(target)
    sync_folder(target.parent)


def _rebuild(
    file: _File,
    path: Path,
    version: str,
    tally: Tally,
    description: Description,
    before: list[FileRecord],
    tell: Callable[[int], None],
) -> FileRecord:
    library = f"seat_gear_dynamics recovery {version}"
    rebuilt = RebuiltFile(
        path, profile=_profile(file), library=library, declarations=file.declarations, tally=tally
    )  # fmt: skip
    try:
        with Source(file.path) as source:
            for piece in file.found.pieces:
                _copy(source, piece, rebuilt)
                tell(piece.end)
        file.record = rebuilt.record
        text = description.serialized([*before, file.record])
        rebuilt.add_metadata(_ROSBAG2, {"serialized_metadata": text})
        rebuilt.finish()
    finally:
        rebuilt.abandon()
    return file.record


def _copy(source: Source, piece: Piece, rebuilt: RebuiltFile) -> None:
    try:
        if piece.layout is not None:
            content = unpack(source, piece.layout)
            rebuilt.add_records(content.records, content.packed, piece.layout.codec)
        elif piece.opcode == Opcode.MESSAGE:
            rebuilt.add_records(source.read(piece.begin, piece.end), None, "zstd")
        elif piece.opcode == Opcode.ATTACHMENT:
            rebuilt.add_attachment(source, Record(piece.opcode, piece.begin, piece.end))
        else:
            metadata = parse_metadata(source.read(Record(piece.opcode, piece.begin, piece.end).body, piece.end))
            if metadata.name != _ROSBAG2:
                rebuilt.add_metadata(metadata.name, metadata.metadata)
    except DamageError as damage:
        raise LogError(f"{source.path} changes while it is read ({damage}); stop what writes to it first.") from damage


def _profile(file: _File) -> str:
    """Return the profile; the header has no checksum, so that channels with ROS 2's types overrule it."""
    for channel in file.declarations.channels.values():
        kind = file.declarations.schemas.get(channel.schema_id)
        if channel.message_encoding == "cdr" and kind is not None and kind.encoding in ("ros2msg", "ros2idl"):
            return "ros2"
    return file.found.profile


def _nameless_notes(files: list[_File]) -> list[str]:
    return [
        f"{file.path.name}: {file.nameless} sound messages were left out, because nothing says to which topics "
        f"they belong."
        for file in files
        if file.nameless
    ]


def _file_result(file: _File) -> FileResult:
    count = file.record.message_count if file.record else 0
    name = file.record.name if file.record else None
    return FileResult(file.path.name, file.size, name, count, tuple(file.found.lost))


def _topics(files: list[_File], claims: Claims, tally: Tally) -> dict[str, TopicResult]:
    """Count losses per topic from summaries that are proven, else from what metadata.yaml claims."""
    types = {topic.name: topic.type for topic in claims.topics}
    expected: Counter[str] = Counter()
    for file in files:
        for number, channel in file.declarations.channels.items():
            types[channel.topic] = file.declarations.type_of(number)
            expected[channel.topic] += (file.found.ending.counts or {}).get(number, 0)
    exact = not claims.missing and all(file.found.ending.counts is not None for file in files)
    claimed = {topic.name: topic.messages for topic in claims.topics}
    harmed = claims.missing or any(file.found.lost or not file.found.ending.found for file in files)
    result = {}
    for name, kind in types.items():
        kept = tally.topics.get(name, (0, 0))[0]
        stated = expected[name] if exact else claimed.get(name, None if harmed else kept)
        lost = None if stated is None else max(0, stated - kept)
        result[name] = TopicResult(kind, kept, lost, exact)
    return result

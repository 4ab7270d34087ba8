"""Topics and types by number, as far as a checksum vouches for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mcap.opcode import Opcode
from mcap.records import Channel, Schema

from seat_gear_dynamics.logs.recovery.records import DamageError, parse_channel, parse_schema


@dataclass
class Declarations:
    """Schemas and channels of one file by number."""

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)

    def add(self, opcode: int, body: bytes) -> None:
        """Enter a schema or channel record; raises `DamageError` where it contradicts an earlier one."""
        if opcode == Opcode.SCHEMA:
            schema = parse_schema(body)
            self._agree(schema, self.schemas.setdefault(schema.id, schema))
        elif opcode == Opcode.CHANNEL:
            channel = parse_channel(body)
            self._agree(channel, self.channels.setdefault(channel.id, channel))

    def include(self, other: Declarations) -> None:
        """Enter everything of `other`; raises `DamageError`, and enters nothing, where the two contradict."""
        for number, schema in other.schemas.items():
            self._agree(schema, self.schemas.get(number, schema))
        for number, channel in other.channels.items():
            self._agree(channel, self.channels.get(number, channel))
        self.schemas |= other.schemas
        self.channels |= other.channels

    def usable(self) -> Declarations:
        """Return the channels whose type is known (or that have none), with the types."""
        channels = {n: c for n, c in self.channels.items() if c.schema_id == 0 or c.schema_id in self.schemas}
        return Declarations(dict(self.schemas), channels)

    def fill(self, numbers: set[int], donor: Declarations) -> set[int]:
        """Take the channels `numbers` and their schemas from `donor` where they are missing; return those taken."""
        taken = set()
        for number in numbers - self.channels.keys():
            channel = donor.channels.get(number)
            if channel is None or channel.schema_id not in donor.schemas:
                continue
            schema = donor.schemas[channel.schema_id]
            if self.schemas.setdefault(schema.id, schema) == schema:
                self.channels[number] = channel
                taken.add(number)
        return taken

    def type_of(self, number: int) -> str:
        """Return the type's name of a channel, empty where it has none."""
        schema = self.schemas.get(self.channels[number].schema_id)
        return schema.name if schema else ""

    @staticmethod
    def _agree(new: Schema | Channel, old: Schema | Channel) -> None:
        if new != old:
            raise DamageError(f"it declares number {new.id} otherwise than the rest of the file")


def agreeing(donors: Mapping[str, Declarations]) -> Declarations:
    """Return what the donors declare, without the numbers on which they disagree."""
    found, disputed = Declarations(), set()
    for donor in donors.values():
        for number, channel in donor.channels.items():
            schema = donor.schemas.get(channel.schema_id)
            known = found.channels.setdefault(number, channel)
            if schema is None or known != channel or found.schemas.setdefault(schema.id, schema) != schema:
                disputed.add(number)
    for number in disputed:
        del found.channels[number]
    return found

"""Generate functions that read messages from little-endian CDR (XCDR1) bytes.

The functions are generated per message type as Python source, as dataclasses do: runs of fixed-size fields
become one `struct` call with their padding worked out beforehand, nested messages are unrolled into their
parent, and number sequences move as blocks. That is what keeps a Float64 near a microsecond.
"""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable
from typing import Any

from seat_gear_dynamics.runtime.cdr.blocks import CODES, SIZES, fixed, unpack_block
from seat_gear_dynamics.runtime.cdr.source import LayoutOf, Source
from seat_gear_dynamics.runtime.interfaces import PLACEHOLDER, Kind


class Readers:
    """Makes readers of message types when first needed.

    `layout_of` gives the fields of a type by name, `class_of` its Python class.
    """

    def __init__(self, layout_of: LayoutOf, class_of: Callable[[str], type]) -> None:
        self._layout_of = layout_of
        self._class_of = class_of
        self._nested: dict[str, Callable[..., Any]] = {}

    def reader(self, name: str) -> Callable[[bytes, int], tuple[Any, int]]:
        """Return a function giving the message at a position (4: after the header) and the position after."""
        return self._reader(name, aligned=True)

    def _reader(self, name: str, aligned: bool) -> Callable[..., Any]:
        source = Source()
        source.names.update(array=array, unpack_block=unpack_block, new=object.__new__, fixed=fixed)
        if aligned:
            source.known = 8
        root = self._read_fields(source, name)
        self._flush_read(source)
        source.emit(f"return {root}, p")
        return source.compile("read", "d, p")

    def _nested_reader(self, name: str) -> Callable[..., Any]:
        if name not in self._nested:
            self._nested[name] = self._reader(name, aligned=False)
        return self._nested[name]

    def _read_fields(self, source: Source, name: str) -> str:
        """Emit the reading of a message and return the name of the variable that holds it."""
        this, cls = source.fresh("m"), source.fresh("class_")
        source.names[cls] = self._class_of(name)
        source.emit(f"{this} = new({cls})")
        layout = self._layout_of(name)
        if not layout or PLACEHOLDER in layout:
            self._read_fixed(source, "uint8", source.fresh("ignored"))
            return this
        for field, kind in layout.items():
            target = f"{this}.{field}"
            if kind.shape != "one":
                self._read_many(source, kind, target)
            elif kind.base == "string":
                self._read_string(source, target)
            elif kind.primitive:
                self._read_fixed(source, kind.base, target)
            else:
                inner = self._read_fields(source, kind.base)
                source.emit(f"{target} = {inner}")
        return this

    def _align_read(self, source: Source, size: int) -> None:
        if source.known >= size:
            pad = -source.offset % size
            source.format += "x" * pad
            source.offset = (source.offset + pad) % source.known
            return
        self._flush_read(source)
        source.emit("p += (4 - p) & 7" if size == 8 else f"p += -p & {size - 1}")
        source.known, source.offset = size, 0

    def _read_fixed(self, source: Source, base: str, target: str) -> None:
        self._align_read(source, SIZES[base])
        source.format += CODES[base]
        source.values.append(target)
        source.offset = (source.offset + SIZES[base]) % source.known

    def _flush_read(self, source: Source) -> None:
        if not source.format:
            return
        layout = struct.Struct("<" + source.format)
        unpack = source.fresh("unpack")
        source.names[unpack] = layout.unpack_from
        targets = ", ".join(source.values)
        source.emit(f"{targets}{',' if targets else '_'} = {unpack}(d, p)")
        source.emit(f"p += {layout.size}")
        source.format, source.values = "", []

    def _read_string(self, source: Source, target: str) -> None:
        count = source.fresh("n")
        self._read_fixed(source, "uint32", count)
        self._flush_read(source)
        # Some writers give an empty string no terminator: its length is 0 then.
        source.emit(f"{target} = d[p:p + {count} - 1].decode() if {count} else ''")
        source.emit(f"p += {count}")
        source.forget()

    def _read_many(self, source: Source, kind: Kind, target: str) -> None:
        count = str(kind.length)
        if kind.shape == "sequence":
            count = source.fresh("n")
            self._read_fixed(source, "uint32", count)
        self._flush_read(source)
        if kind.primitive and kind.base != "string":
            self._read_block(source, kind, target, count)
        else:
            self._read_elements(source, kind, target, count)

    def _read_block(self, source: Source, kind: Kind, target: str, count: str) -> None:
        code, size, end = CODES[kind.base], SIZES[kind.base], source.fresh("e")
        if kind.shape == "array":
            self._align_read(source, size)
            self._flush_read(source)
        elif size == 8:
            source.emit(f"if {count}: p += (4 - p) & 7")
        source.emit(f"{end} = p + {count} * {size}")
        if code == "?":
            source.emit(f"{target} = [x != 0 for x in unpack_block('B', d, p, {end})]")
        elif code == "c":
            source.emit(f"{target} = [bytes((x,)) for x in unpack_block('B', d, p, {end})]")
        elif kind.shape == "array":
            source.emit(f"{target} = fixed(unpack_block({code!r}, d, p, {end}))")
        else:
            source.emit(f"{target} = unpack_block({code!r}, d, p, {end})")
        source.emit(f"p = {end}")
        if kind.shape == "array":
            source.offset = (source.offset + size * kind.length) % source.known
        else:
            source.forget()

    def _read_elements(self, source: Source, kind: Kind, target: str, count: str) -> None:
        items, item = source.fresh("l"), source.fresh("i")
        source.emit(f"{items} = []")
        source.emit(f"for _ in range({count}):")
        source.indent += 1
        source.forget()
        if kind.base == "string":
            self._read_string(source, item)
        else:
            nested = source.fresh("read")
            source.names[nested] = self._nested_reader(kind.base)
            source.emit(f"{item}, p = {nested}(d, p)")
        source.emit(f"{items}.append({item})")
        source.indent -= 1
        source.forget()
        source.emit(f"{target} = {items}")

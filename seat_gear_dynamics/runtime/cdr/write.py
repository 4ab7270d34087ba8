"""Generate functions that write messages as little-endian CDR (XCDR1) bytes.

The functions are generated per message type as Python source, as dataclasses do: runs of fixed-size fields
become one `struct` call with their padding worked out beforehand, nested messages are unrolled into their
parent, and number sequences move as blocks. That is what keeps a Float64 near a microsecond.
"""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable
from typing import Any

from seat_gear_dynamics.runtime.cdr.blocks import CODES, SIZES, need_float, pack_block, pack_flags, pack_octets, within
from seat_gear_dynamics.runtime.cdr.source import LayoutOf, Source
from seat_gear_dynamics.runtime.interfaces import PLACEHOLDER, Kind


class Writers:
    """Makes writers of message types when first needed.

    `layout_of` gives the fields of a type by name.
    """

    def __init__(self, layout_of: LayoutOf) -> None:
        self._layout_of = layout_of
        self._nested: dict[str, Callable[..., Any]] = {}

    def writer(self, name: str) -> Callable[[bytearray, Any], None]:
        """Return a function that appends a message to a buffer holding the 4-byte header."""
        return self._writer(name, aligned=True)

    def _writer(self, name: str, aligned: bool) -> Callable[..., Any]:
        source = Source()
        source.names.update(
            array=array,
            pack_block=pack_block,
            pack_flags=pack_flags,
            pack_octets=pack_octets,
            within=within,
            need_float=need_float,
        )
        if aligned:
            source.known = 8
        self._write_fields(source, name, "m")
        self._flush_write(source)
        return source.compile("write", "b, m")

    def _nested_writer(self, name: str) -> Callable[..., Any]:
        if name not in self._nested:
            self._nested[name] = self._writer(name, aligned=False)
        return self._nested[name]

    def _write_fields(self, source: Source, name: str, path: str) -> None:
        layout = self._layout_of(name)
        if not layout or PLACEHOLDER in layout:
            self._write_fixed(source, "uint8", "0")
            return
        for field, kind in layout.items():
            value = f"{path}.{field}"
            if kind.shape != "one":
                self._write_many(source, kind, value)
            elif kind.base == "string":
                self._write_string(source, value, kind.string_bound)
            elif kind.primitive:
                self._write_fixed(source, kind.base, value)
            else:
                inner = source.fresh("v")
                source.emit(f"{inner} = {value}")
                self._write_fields(source, kind.base, inner)

    def _align_write(self, source: Source, size: int) -> None:
        """Pad to a multiple of `size`, in the running format if that is known, at run time if not."""
        if source.known >= size:
            pad = -source.offset % size
            source.format += "x" * pad
            source.offset = (source.offset + pad) % source.known
            return
        self._flush_write(source)
        # The position counts from after the 4-byte header, which moves an 8-byte boundary.
        odd = "(4 - len(b)) & 7" if size == 8 else f"-len(b) & {size - 1}"
        source.emit(f"b += b'\\0' * ({odd})")
        source.known, source.offset = size, 0

    def _write_fixed(self, source: Source, base: str, value: str) -> None:
        size = SIZES[base]
        self._align_write(source, size)
        if base in ("float32", "float64"):
            name = source.fresh("f")
            source.emit(f"{name} = {value}")
            source.emit(f"if {name}.__class__ is not float: {name} = need_float({name})")
            value = name
        elif base == "bool":
            name = source.fresh("t")
            source.emit(f"{name} = {value}")
            source.emit(f"if {name} is not True and {name} is not False: raise TypeError('bool expected')")
            value = name
        source.format += CODES[base]
        source.values.append(value)
        source.offset = (source.offset + size) % source.known

    def _flush_write(self, source: Source) -> None:
        if not source.format:
            return
        pack = source.fresh("pack")
        source.names[pack] = struct.Struct("<" + source.format).pack
        source.emit(f"b += {pack}({', '.join(source.values)})")
        source.format, source.values = "", []

    def _write_string(self, source: Source, value: str, bound: int) -> None:
        text = source.fresh("s")
        if bound:
            source.emit(f"within({value}, 'sequence', {bound})")
        source.emit(f"{text} = {value}.encode()")
        self._write_fixed(source, "uint32", f"len({text}) + 1")
        self._flush_write(source)
        source.emit(f"b += {text}")
        source.emit("b.append(0)")
        source.forget()

    def _write_many(self, source: Source, kind: Kind, value: str) -> None:
        values, count = source.fresh("v"), source.fresh("n")
        source.emit(f"{values} = {value}")
        source.emit(f"{count} = within({values}, {kind.shape!r}, {kind.length})")
        if kind.shape == "sequence":
            self._write_fixed(source, "uint32", count)
        self._flush_write(source)
        if kind.primitive and kind.base != "string":
            self._write_block(source, kind, values)
        else:
            self._write_elements(source, kind, values)

    def _write_block(self, source: Source, kind: Kind, values: str) -> None:
        code = CODES[kind.base]
        packer = {"?": "pack_flags(", "c": "pack_octets("}.get(code, f"pack_block({code!r}, ")
        size = SIZES[kind.base]
        if kind.shape == "array":
            self._align_write(source, size)
            self._flush_write(source)
            source.emit(f"b += {packer}{values})")
            source.offset = (source.offset + size * kind.length) % source.known
            return
        # An empty sequence ends after its length: the padding belongs to the first element.
        source.emit(f"if len({values}):")
        source.indent += 1
        if size == 8:
            source.emit("b += b'\\0' * ((4 - len(b)) & 7)")
        source.emit(f"b += {packer}{values})")
        source.indent -= 1
        source.forget()

    def _write_elements(self, source: Source, kind: Kind, values: str) -> None:
        item = source.fresh("i")
        if kind.base == "string":
            source.emit(f"if {values}.__class__ is str: raise TypeError('a list of str is expected')")
        source.emit(f"for {item} in {values}:")
        source.indent += 1
        source.forget()
        if kind.base == "string":
            self._write_string(source, item, kind.string_bound)
        else:
            nested = source.fresh("write")
            source.names[nested] = self._nested_writer(kind.base)
            source.emit(f"{nested}(b, {item})")
        source.indent -= 1
        source.forget()

"""Numeric matrices out of R's `.rda` files: just enough of R's serialisation (XDR, versions 2 and
3) for the public records.
"""

from __future__ import annotations

import bz2
import gzip
import lzma
import struct
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError

_ALTREP = 238
_NIL, _GLOBAL, _BASE, _EMPTY, _MISSING, _REF = 254, 253, 241, 242, 251, 255
_SYM, _LIST, _CHAR, _LGL, _INT, _REAL, _STR, _VEC = 1, 2, 9, 10, 13, 14, 16, 19


class Frame(dict):
    """The columns of a data frame by name."""


class _Reader:
    def __init__(self, data: bytes):
        self.data, self.at, self.symbols = data, 0, []

    def integer(self) -> int:
        self.at += 4
        return struct.unpack_from(">i", self.data, self.at - 4)[0]

    def take(self, dtype: str, count: int) -> np.ndarray:
        values = np.frombuffer(self.data, dtype, count, self.at)
        self.at += values.nbytes
        return values

    def item(self):
        """One object: arrays for vectors (with `dim` applied), str, list, or dict of a tagged
        list.
        """
        flags = self.integer()
        kind, has_attributes, has_tag = flags & 0xFF, flags & 0x200, flags & 0x400
        if kind in (_NIL, _GLOBAL, _BASE, _EMPTY, _MISSING):
            return None
        if kind == _REF:
            return self.symbols[(flags >> 8) - 1]
        if kind == _SYM:
            self.symbols.append(self.item())
            return self.symbols[-1]
        if kind == _LIST:
            out = {}
            while True:
                if has_attributes:
                    self.item()
                tag = self.item() if has_tag else len(out)
                out[tag] = self.item()
                flags = self.integer()
                kind, has_attributes, has_tag = flags & 0xFF, flags & 0x200, flags & 0x400
                if kind != _LIST:
                    return out
        if kind == _CHAR:
            length = self.integer()
            return None if length < 0 else bytes(self.take("u1", length)).decode("utf-8", "replace")
        if kind == _ALTREP:  # a sequence kept by its ends, or a wrapper about a vector
            _, state, _ = self.item(), self.item(), self.item()
            if isinstance(state, list):
                return state[0]
            if isinstance(state, np.ndarray) and len(state) == 3:
                return state[1] + state[2] * np.arange(int(state[0]))
            raise ValueError("holds a vector of a kind that is not read here")
        if kind not in (_LGL, _INT, _REAL, _STR, _VEC):
            raise ValueError(f"holds an R object of type {kind}")
        length = self.integer()
        if kind in (_STR, _VEC):
            value = [self.item() for _ in range(length)]
        else:
            value = self.take(">f8" if kind == _REAL else ">i4", length).astype(float)
            if kind != _REAL:
                value[value == -(2.0**31)] = np.nan  # R's NA
        attributes = self.item() if has_attributes else {}
        dim = (attributes or {}).get("dim")
        names = (attributes or {}).get("names")
        if kind == _VEC and isinstance(names, list) and len(names) == len(value):
            return Frame(zip(map(str, names), value))
        return (
            value.reshape(tuple(int(d) for d in dim), order="F")
            if dim is not None and isinstance(value, np.ndarray)
            else value
        )


def read_rdata(path) -> dict[str, np.ndarray]:
    """The numeric vectors and matrices of an `.rda` file by name; columns of a data frame are
    stacked. InputError where it is no such file."""
    out = {}
    for name, value in objects(Path(path).read_bytes(), str(path)).items():
        if isinstance(value, Frame):
            value = list(value.values())
        if isinstance(value, list) and value and all(isinstance(v, np.ndarray) for v in value):
            value = np.column_stack(value)
        if isinstance(value, np.ndarray):
            out[name] = value
    return out


def is_rdata(data: bytes) -> bool:
    return data[:5] in (b"RDX2\n", b"RDX3\n")


def arrays(data: bytes, source: str) -> dict[str, np.ndarray]:
    """Every numeric vector, matrix and column of a data frame by name. InputError where there are
    none.
    """
    out: dict[str, np.ndarray] = {}
    for name, value in objects(data, source).items():
        parts = (
            {f"{name}.{k}": v for k, v in value.items()}
            if isinstance(value, Frame)
            else {name: value}
        )
        for key, part in parts.items():
            if isinstance(part, np.ndarray):
                out[key] = part
            elif isinstance(part, list) and part and all(isinstance(v, str) for v in part):
                out[key] = np.asarray(part, dtype=object)
    return out


def objects(data: bytes, source: str) -> dict[str, object]:
    """The objects of an `.rda` file by name. InputError where it is no such file."""
    try:
        for magic, unpack in (
            (b"\x1f\x8b", gzip.decompress),
            (b"BZh", bz2.decompress),
            (b"\xfd7zXZ", lzma.decompress),
        ):
            if data.startswith(magic):
                data = unpack(data)
        if data[:5] not in (b"RDX2\n", b"RDX3\n") or data[5:7] != b"X\n":
            raise ValueError("does not begin with RDX2 or RDX3 in XDR form")
        reader = _Reader(data)
        reader.at = 7
        version, _, _ = (reader.integer() for _ in range(3))
        if version == 3:
            reader.at += 4 + struct.unpack_from(">i", data, reader.at)[0]
        return {str(name): value for name, value in (reader.item() or {}).items()}
    except (
        ValueError,
        struct.error,
        IndexError,
        OSError,
        EOFError,
        lzma.LZMAError,
        AttributeError,
        RecursionError,
    ) as error:
        raise InputError(f"{source} is not an R data file read here ({error}).") from None

"""Vectors of numbers in files of MATLAB, versions 4 to 7.

`scipy.io.loadmat` ends the process for some damaged files. This reader checks each size before it
takes the bytes, and reads numbers only.
"""

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from gearbow._files import parsing
from gearbow._types import Array
from gearbow.errors import SceneError

#: Largest content of a compressed array [bytes].
_MAX_SIZE = 100_000_000
#: Types of data elements, and the two that contain other elements.
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8"}
_TYPES |= {12: "i8", 13: "u8"}
_MATRIX, _COMPRESSED = 14, 15
#: Classes of arrays of numbers: double, single and whole numbers of 8 to 64 bits.
_NUMERIC = range(6, 16)
_COMPLEX = 0x0800
#: Types of numbers in version 4.
_TYPES_4 = ("f8", "f4", "i4", "i2", "u2", "u1")


def read_vectors(path: Path) -> dict[str, Array]:
    """Read the variables of a file, each of which must be a vector of numbers."""
    data = path.read_bytes()
    vectors = {}
    with parsing(path, "a MATLAB file of a version before 7.3"):
        if data[:8] == b"\x89HDF\r\n\x1a\n" or data[:10] == b"MATLAB 7.3":
            raise ValueError("save it with -v7")
        order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
        variables = _version_4(data) if order is None else _version_5(data, order)
        for name, shape, values in variables:
            if values is None:
                raise SceneError(f"{path}: {name}: must be a vector of numbers")
            if len(shape) > 2 or min(shape, default=1) != 1:
                raise SceneError(f"{path}: {name}: must be a vector, has the shape {shape}")
            vectors[name] = values
    return vectors


def _version_5(data: bytes, order: str) -> Iterator[tuple[str, tuple[int, ...], Array | None]]:
    """Give name, shape and numbers of each variable; None for other variables than real numbers."""
    at = 128
    while at < len(data):
        kind, content, at = _element(data, at, order)
        if kind == _COMPRESSED:
            stream = zlib.decompressobj()
            unpacked = stream.decompress(content, _MAX_SIZE)
            if not stream.eof:
                raise ValueError(f"a compressed array has no end, or over {_MAX_SIZE} bytes")
            kind, content, _ = _element(unpacked, 0, order)
        if kind != _MATRIX:
            raise ValueError(f"an element of type {kind} is no array")
        yield from _array(content, order)


def _array(content: bytes, order: str) -> Iterator[tuple[str, tuple[int, ...], Array | None]]:
    """Give the variable of an array; what has no name belongs to MATLAB."""
    _, flags, at = _element(content, 0, order)
    (what,) = struct.unpack_from(f"{order}I", flags)
    _, sizes, at = _element(content, at, order)
    shape = tuple(np.frombuffer(sizes, f"{order}i4").tolist())
    _, letters, at = _element(content, at, order)
    name = letters.decode("ascii")
    if what & 0xFF not in _NUMERIC or what & _COMPLEX:
        if name:
            yield name, shape, None
        return
    kind, numbers, _ = _element(content, at, order)
    yield name, shape, _numbers(numbers, f"{order}{_TYPES[kind]}", shape, name)


def _element(data: bytes, at: int, order: str) -> tuple[int, bytes, int]:
    """Give type and content of the element at a place, and the place of the next one."""
    kind, size = struct.unpack_from(f"{order}II", data, at)
    begin, step = at + 8, -(-size // 8) * 8
    if kind >> 16:  # at most four bytes, in the place of the size
        kind, size, begin, step = kind & 0xFFFF, kind >> 16, at + 4, 4
        if size > 4:
            raise ValueError(f"a short element has {size} bytes")
    if kind == _COMPRESSED:
        step = size
    if begin + size > len(data):
        raise ValueError(f"an element of {size} bytes is longer than the file")
    return kind, data[begin : begin + size], begin + step


def _version_4(data: bytes) -> Iterator[tuple[str, tuple[int, ...], Array | None]]:
    """Give name, shape and numbers of each variable of a file of version 4."""
    at = 0
    while at < len(data):
        order = "<" if struct.unpack_from("<I", data, at)[0] < 10_000 else ">"
        kind, rows, columns, imaginary, length = struct.unpack_from(f"{order}5I", data, at)
        digit, rest = kind // 10 % 10, kind % 10
        if kind // 1000 != (order == ">") or kind // 100 % 10 or digit >= len(_TYPES_4):
            raise ValueError("it has no header of MATLAB")
        begin = at + 20 + length
        name = data[at + 20 : begin].rstrip(b"\0").decode("ascii")
        dtype = np.dtype(f"{order}{_TYPES_4[digit]}")
        at = begin + rows * columns * dtype.itemsize * (2 if imaginary else 1)
        if begin > len(data) or at > len(data):
            raise ValueError(f"the array {name!r} is longer than the file")
        if rest or imaginary:
            yield name, (rows, columns), None
        else:
            yield name, (rows, columns), _numbers(data[begin:at], dtype, (rows, columns), name)


def _numbers(
    content: bytes, dtype: "np.dtype[np.generic] | str", shape: tuple[int, ...], name: str
) -> Array:
    """Give the numbers of an array, as many as its shape says."""
    found = np.frombuffer(content, dtype)
    wanted = 1
    for size in shape:
        wanted *= size
    if found.size != wanted or min(shape, default=0) < 0:
        raise ValueError(f"the array {name!r} of shape {shape} has {found.size} numbers")
    return found.astype(np.float64)

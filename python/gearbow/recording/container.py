"""Files of recorded runs: archives of arrays with metadata, their checks, and netCDF for export.

An archive declares the shape and type of every array, and contains one JSON text with all other
data. Nothing is pickled. Numbers are not rounded, so that a run can continue from a loaded
response. Arrays are not compressed, so that one is never larger than its file: a larger declaration
is rejected before any memory is allocated. Archives of NumPy contain a checksum of every member.
"""

import errno
import json
import os
import reprlib
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import is_dataclass
from io import BufferedRandom, RawIOBase
from math import prod
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Any, TypeAlias, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from gearbow._core import check_final
from gearbow._extras import extra
from gearbow._files import as_path, check_name, parsing, replacing, reserve
from gearbow.description.layout import Kinematics
from gearbow.description.speed import read_speed
from gearbow.errors import GearbowError, SceneError
from gearbow.recording.channels import (
    CHANNELS,
    FORMAT,
    OWNERS,
    arrays_of,
    metadata_of,
    with_signals,
)
from gearbow.recording.record import (
    OPTIONS,
    ErrorEstimate,
    Errors,
    RunRecord,
    RunRequest,
    Statistics,
)
from gearbow.units.speed import speed_factor

if TYPE_CHECKING:
    from zipfile import ZipFile

    import xarray as xr


# Checks of plain data: the valid values of each entry of a file, as a table of small functions.
#
# A check receives a value and its path in the file. It raises `GearbowError` for an invalid value.
# `record`, `entries`, `each`, `row` and `optional` combine checks; `typed` takes a dataclass.

Check: TypeAlias = Callable[[Any, str], None]

#: Counters are 64-bit integers in the core.
_MOST = 2**63 - 1


def _refuse(where: str, must: str, value: object) -> GearbowError:
    return GearbowError(f"{where}: must be {must}, got {reprlib.repr(value)}")


def text(value: Any, where: str) -> None:
    """Accept a string."""
    if not isinstance(value, str):
        raise _refuse(where, "a text", value)


def whole(value: Any, where: str) -> None:
    """Accept a whole number from 0 to 2⁶³ - 1."""
    if type(value) is not int or not 0 <= value <= _MOST:
        raise _refuse(where, "a whole number, not negative and below 2**63", value)


def number(value: Any, where: str) -> None:
    """Accept a finite number."""
    if type(value) not in {int, float} or not abs(value) <= sys.float_info.max:
        raise _refuse(where, "a finite number", value)


def any_number(value: Any, where: str) -> None:
    """Accept a number, infinity or NaN."""
    if type(value) is not float:
        number(value, where)


def flag(value: Any, where: str) -> None:
    """Accept True and False."""
    if not isinstance(value, bool):
        raise _refuse(where, "true or false", value)


def anything(value: Any, where: str) -> None:
    """Accept every value: another part of the program checks it."""


def optional(check: Check) -> Check:
    """Accept None and every value that `check` accepts."""

    def checked(value: Any, where: str) -> None:
        if value is not None:
            check(value, where)

    return checked


def each(check: Check) -> Check:
    """Accept a list whose entries all pass."""

    def checked(value: Any, where: str) -> None:
        if not isinstance(value, list | tuple):
            raise _refuse(where, "a list", value)
        for i, entry in enumerate(value):
            check(entry, f"{where}[{i}]")

    return checked


def entries(check: Check) -> Check:
    """Accept a mapping whose values all pass."""

    def checked(value: Any, where: str) -> None:
        record()(value, where)
        for name, entry in value.items():
            check(entry, f"{where}.{name}")

    return checked


def row(*checks: Check) -> Check:
    """Accept a list of as many entries as there are checks."""

    def checked(value: Any, where: str) -> None:
        if not isinstance(value, list | tuple) or len(value) != len(checks):
            raise _refuse(where, f"a list of {len(checks)} entries", value)
        for i, (entry, check) in enumerate(zip(value, checks, strict=True)):
            check(entry, f"{where}[{i}]")

    return checked


def record(**checks: Check) -> Check:
    """Accept a mapping that has these entries; it may have others."""

    def checked(value: Any, where: str) -> None:
        if not isinstance(value, dict):
            raise _refuse(where, "a mapping", value)
        for name, check in checks.items():
            place = f"{where}.{name}".lstrip(".")
            if name not in value:
                raise GearbowError(f"{place}: is missing")
            check(value[name], place)

    return checked


#: Checks of values without parts.
_SCALARS: dict[type, Check] = {str: text, int: whole, float: number, bool: flag}


def typed(hint: Any, number: Check = number) -> Check:
    """Make the check of a dataclass, list, tuple, text or number, or of one of them or None."""
    if is_dataclass(hint):
        hints = get_type_hints(hint).items()
        return record(**{name: typed(each, number) for name, each in hints})
    origin, inside = get_origin(hint), get_args(hint)
    if origin is UnionType:
        return optional(typed(inside[0], number))
    if origin is list or inside[-1:] == (...,):
        return each(typed(inside[0], number))
    if origin is tuple:
        return row(*(typed(entry, number) for entry in inside))
    return number if hint is float else _SCALARS[hint]


#: Ending of the archives, from which runs continue, and of the files for other programs.
ARCHIVE, EXPORT = ".npz", ".nc"

#: Declaration of an array in a file.
Header: TypeAlias = tuple[tuple[int, ...], np.dtype[Any]]

_METADATA = "metadata"


def archive_name(path: object, argument: str = "path") -> Path:
    """Check the name of an archive, from which a run continues."""
    if as_path(path, argument).suffix.lower() == EXPORT:
        raise SceneError(
            f"{argument}: {path} is netCDF, which gearbow writes for other programs and does not "
            f"read; give a file {ARCHIVE}, which `save` writes too"
        )
    return check_name(path, (ARCHIVE,), argument)[0]


@contextmanager
def opened(path: str | os.PathLike[str], argument: str = "path") -> Iterator["Archive"]:
    """Open an archive for reading."""
    from zipfile import ZipFile  # noqa: PLC0415

    with (
        archive_name(path, argument).open("rb") as stream,
        parsing(path, "a response of gearbow", own=True),
        ZipFile(stream) as archive,
    ):
        yield Archive(archive, os.fstat(stream.fileno()).st_size)


class Archive:
    """An open archive of NumPy: named arrays and one text."""

    def __init__(self, archive: "ZipFile", size: int) -> None:
        from zipfile import ZIP_STORED  # noqa: PLC0415

        self._archive = archive
        self._members = {entry.filename: entry for entry in archive.infolist()}
        if sum(entry.file_size for entry in archive.infolist()) > size:
            raise GearbowError("it declares more data than the file has bytes")
        if any(entry.compress_type != ZIP_STORED for entry in archive.infolist()):
            raise GearbowError("it is compressed, which gearbow never does")

    def metadata(self) -> str:
        """Read the text."""
        found = self.header(_METADATA)
        if found is None:
            raise GearbowError(f"it has no {_METADATA}")
        shape, dtype = found
        if shape != () or dtype.kind != "U":
            raise GearbowError(f"{_METADATA}: must be a text, is {dtype} of shape {shape}")
        return str(self.read(_METADATA))

    def header(self, name: str) -> Header | None:
        """Give shape and type of an array, None if there is none of this name."""
        entry = self._members.get(f"{name}.npy")
        if entry is None:
            return None
        with self._archive.open(entry) as member:
            version = np.lib.format.read_magic(member)
            if version == (1, 0):
                shape, _, dtype = np.lib.format.read_array_header_1_0(member)
            elif version == (2, 0):
                shape, _, dtype = np.lib.format.read_array_header_2_0(member)
            else:
                raise GearbowError(f"{name}: has an unknown version {version} of its header")
            if min(shape, default=0) < 0 or dtype.hasobject:
                raise GearbowError(f"{name}: has an invalid shape {shape} or type {dtype}")
            # Python's integers do not overflow.
            if member.tell() + prod(shape) * dtype.itemsize != entry.file_size:
                raise GearbowError(
                    f"{name}: has {entry.file_size} bytes, which is not what an array of shape "
                    f"{shape} takes"
                )
        return shape, dtype

    def read(self, name: str) -> NDArray[Any]:
        """Read an array."""
        with self._archive.open(f"{name}.npy") as member:
            values: NDArray[Any] = np.lib.format.read_array(member, allow_pickle=False)
        return values


def require_netcdf() -> None:
    """Import the libraries of netCDF files, which an extra installs."""
    with extra("netcdf"):
        import h5netcdf  # noqa: F401, PLC0415
        import h5py  # noqa: F401, PLC0415
        import xarray  # noqa: F401, PLC0415


def save_netcdf(dataset: "xr.Dataset", path: Path) -> None:
    """Write a data set as a netCDF file, completely or not at all."""
    with replacing(path) as file:
        write_netcdf(dataset, file)


def write_netcdf(dataset: "xr.Dataset", file: BufferedRandom) -> None:
    """Write a data set as a netCDF file."""
    import h5netcdf  # noqa: PLC0415
    from xarray.backends import H5NetCDFStore  # noqa: PLC0415

    reserve(file, dataset.nbytes)
    image = _Image(file.raw)
    try:
        with h5netcdf.File(image, "w") as content:
            dataset.dump_to_store(H5NetCDFStore(content))
    except RuntimeError as error:
        if image.error is None:
            raise OSError(errno.EIO, f"the HDF5 library fails: {error}") from error
    except BaseException:
        if image.error is None:
            raise
    if image.error is not None:
        raise image.error
    file.raw.truncate(image.size)


class _Image:
    """The file that the HDF5 library writes. It keeps errors away from the library."""

    def __init__(self, raw: RawIOBase) -> None:
        self._raw = raw
        self._at = 0
        #: Number of bytes, without the reserved space behind them.
        self.size = 0
        #: The first error.
        self.error: BaseException | None = None

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Move to a place relative to the start, to this place or to the end."""
        self._at = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self.size}[whence]
        return self._at

    def tell(self) -> int:
        """Give the place."""
        return self._at

    def write(self, data: Any) -> int:
        """Write data; after an error nothing is written any more."""
        view = memoryview(data).cast("B")
        done = 0
        try:
            self._raw.seek(self._at)
            while done < len(view) and self.error is None:
                done += self._raw.write(view[done:]) or 0
        except BaseException as error:  # noqa: BLE001  # also Ctrl-C must not reach the library
            self.error = error
        self._at += len(view)
        self.size = max(self.size, self._at)
        return len(view)

    def readinto(self, buffer: Any) -> int:
        """Read data; zeros behind the end and after an error."""
        view = memoryview(buffer).cast("B")
        done = 0
        try:
            self._raw.seek(self._at)
            while done < len(view) and (count := self._raw.readinto(view[done:])):
                done += count
        except BaseException as error:  # noqa: BLE001
            self.error = self.error or error
        view[done:] = bytes(len(view) - done)
        self._at += len(view)
        return len(view)

    def read(self, size: int = -1) -> bytes:
        """Read data."""
        data = bytearray(max(self.size - self._at, 0) if size < 0 else size)
        self.readinto(data)
        return bytes(data)

    def truncate(self, size: int | None = None) -> int:
        """Set the number of bytes; the reserved space stays."""
        self.size = self._at if size is None else size
        return self.size

    def flush(self) -> None:
        """Do nothing: the data are written at once."""


#: Arrays of the final state. Their lengths depend on the method.
_STATE = {"state": np.float64, "memory": np.float64, "contact_modes": np.int64}

#: Required entries of the metadata.
_ENTRY = record(
    format=whole,
    accuracy=optional(text),
    request=optional(
        record(description=record(), options=record(**dict.fromkeys(OPTIONS, anything)))
    ),
    errors=optional(
        record(
            window=number,
            chaotic=flag,
            estimates=entries(typed(ErrorEstimate)),
        )
    ),
    kinematics=optional(typed(Kinematics)),
    points=each(row(text, number, each(text))),
    bearings=each(row(text, number)),
    rolling_bearings=each(row(text, number)),
    meshes=each(row(text, text)),
    sections=each(row(text, number, text)),
    statistics=typed(Statistics, any_number),
    events=each(row(number, text, text, text)),
    final=record(),
)
#: A changing speed; a constant speed is a number.
_PROFILE = record(breaks=each(number), coefficients=each(each(number)))


def save(run: RunRecord, path: str | os.PathLike[str], **more: Any) -> None:
    """Write a recorded run to an archive, completely or not at all."""
    metadata = np.array(metadata_of(run, more))
    with replacing(archive_name(path)) as file:
        np.savez(file, metadata=metadata, **arrays_of(run))  # type: ignore[arg-type]


def read(path: str | os.PathLike[str], argument: str = "path") -> tuple[RunRecord, dict[str, Any]]:
    """Read a file of `save` with its metadata."""
    with opened(path, argument) as file:
        about = json.loads(file.metadata())
        record(format=whole)(about, "")
        if about["format"] != FORMAT:
            raise GearbowError(
                f"it has the format {about['format']}, this version of gearbow reads {FORMAT}"
            )
        # A file may leave out rolling bearings, sections, and the unit of the speed.
        about.setdefault("speed_unit", "rad/s")
        about.setdefault("rolling_bearings", [])
        about.setdefault("sections", [])
        if isinstance(about.get("kinematics"), dict):
            about["kinematics"].setdefault("bearings", [])
            about["kinematics"].setdefault("forces", [])
        checked = dict(about)
        if isinstance(about.get("statistics"), dict):
            # A file may leave out the reduction of a run with all modes.
            checked["statistics"] = {"modes": None, "modes_error": None, **about["statistics"]}
        _ENTRY(checked, "")
        speed_factor(about["speed_unit"])
        (_PROFILE if isinstance(about.get("speed"), dict) else number)(about.get("speed"), "speed")
        arrays = _read_arrays(file, about)
        return _run(about, arrays), about


def _read_arrays(file: Archive, about: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """Check the type and shape of each array, then read it."""
    time = file.header("time")
    sizes: dict[str, int | None] = {
        "time": time[0][0] if time is not None and time[0] else 0,
        "axis": 2,
        "component": 3,
        **{owner: len(about[entry]) for owner, entry in OWNERS.items()},
    }
    expected: dict[str, tuple[type, tuple[int | None, ...]]] = {
        "time": (np.float64, (sizes["time"],)),
        **{
            name: (np.float64, tuple(sizes[axis] for axis in channel.axes))
            for name, channel in CHANNELS.items()
        },
        **{f"final_{name}": (kind, (None,)) for name, kind in _STATE.items()},
    }
    # A run without energies or rates, a system without axial motion, and an older file lack the
    # arrays of a group.
    for group in {channel.group for channel in CHANNELS.values()} - {None}:
        names = [name for name, channel in CHANNELS.items() if channel.group == group]
        if all(file.header(name) is None for name in names):
            expected = {name: value for name, value in expected.items() if name not in names}
    if not about["rolling_bearings"]:
        expected = {
            name: value for name, value in expected.items() if not name.startswith("rolling_")
        }
    arrays: dict[str, NDArray[Any]] = {}
    for name, (kind, shape) in expected.items():
        found = file.header(name)
        if found is None:
            raise GearbowError(f"{name}: is missing")
        fits = len(found[0]) == len(shape) and all(
            wanted in {None, size} for size, wanted in zip(found[0], shape, strict=True)
        )
        if found[1].newbyteorder("=") != kind or not fits:
            wanted = ", ".join("any" if size is None else str(size) for size in shape)
            raise GearbowError(
                f"{name}: must be {np.dtype(kind)} of shape ({wanted}), got {found[1]} of shape "
                f"{found[0]}"
            )
        arrays[name] = np.ascontiguousarray(file.read(name), dtype=kind)
    return arrays


def _run(about: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> RunRecord:
    """Make a recorded run from checked data."""
    final = {**about["final"], **{name: arrays[f"final_{name}"] for name in _STATE}}
    check_final(final)
    plain = {
        "points": [(shaft, position, names) for shaft, position, names in about["points"]],
        **{
            entry: [tuple(each) for each in about[entry]]
            for entry in ("bearings", "rolling_bearings", "meshes", "sections", "events")
        },
        "final": final,
        # JSON has lists, the core gives tuples.
        "statistics": {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in about["statistics"].items()
        },
    }
    recorded = {name: values for name, values in arrays.items() if name in CHANNELS}
    return RunRecord(
        data=with_signals(plain, arrays["time"], recorded),
        speed=read_speed(about["speed"]),
        kinematics=Kinematics.from_plain(about["kinematics"]),
        accuracy=about["accuracy"],
        request=RunRequest.from_plain(about["request"]),
        errors=Errors._from_plain(about["errors"]),
        speed_unit=about["speed_unit"],
    )

"""Matrices of finite-element models in files: NumPy, SciPy, MATLAB, Matrix Market, Nastran.

`scipy.io.mmread` ends the process for some damaged files, and pyNastran 1.4 does not run with NumPy
2; the readers here are of NumPy.
"""

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gearbow._extras import extra
from gearbow._files import check_name, parsing, reading
from gearbow.errors import SceneError
from gearbow.exchange.tables import Sparse, read_variables

#: First letters of the names of matrices, by what they are.
_LETTERS = {"mass": "m", "stiffness": "ks"}
#: A real number of Nastran, whose exponent may have the letter D, or none.
_REAL = re.compile(r"([-+]?[\d.]+)(?:[eEdD]?([-+]?\d+))?", re.ASCII)
#: Forms of square and symmetric matrices, and types of real numbers, in the header of DMIG.
_FORMS, _REAL_TYPES = {"1", "6"}, {"1", "2"}


def read_matrix(path: Any, quantity: str) -> Any:
    """Read the mass or stiffness matrix of a file: the only one, or the one with such a name."""
    file, ending = check_name(path, list(_READERS), quantity)
    with extra("sparse"):
        import scipy.sparse  # noqa: F401, PLC0415

    found = _READERS[ending](file)
    letters = _LETTERS[quantity]
    suited = [name for name in found if len(found) == 1 or name[:1].lower() in letters]
    if len(suited) != 1:
        first = " or ".join(letters)
        raise SceneError(
            f"{quantity}: {file} must have one matrix, or one whose name begins with {first}; it "
            f"has {', '.join(found) or 'none'}"
        )
    matrix = found[suited[0]]
    # Products with indices beyond the matrix would read foreign memory.
    if hasattr(matrix, "check_format"):
        with parsing(file, "a file with a sparse matrix"):
            if matrix.nnz < 0:  # SciPy then checks no further
                raise ValueError(f"its last column ends at {matrix.nnz}")
            matrix.check_format(full_check=True)
    return matrix


def _from_numpy(path: Path) -> dict[str, Any]:
    """Read the arrays of NumPy, or the sparse matrix of SciPy."""
    from scipy import sparse  # noqa: PLC0415

    with path.open("rb") as file, parsing(path, f"a file of NumPy ({path.suffix})"):
        loaded = np.load(file, allow_pickle=False)
        if isinstance(loaded, np.ndarray):
            return {"matrix": np.asarray(loaded, dtype=np.float64)}
        if "format" in loaded.files:
            file.seek(0)
            return {"matrix": sparse.load_npz(file)}
        arrays = {name: loaded[name] for name in loaded.files}
        return {name: np.asarray(a, np.float64) for name, a in arrays.items() if a.ndim == 2}


def _from_matlab(path: Path) -> dict[str, Any]:
    """Read the matrices of a MATLAB file."""
    from scipy import sparse  # noqa: PLC0415

    found: dict[str, Any] = {}
    for name, shape, values in read_variables(path):
        if values is None or len(shape) != 2:
            continue
        with parsing(path, f"a MATLAB file with a matrix {name}"):
            if isinstance(values, Sparse):
                given = (values.numbers, values.rows, values.starts)
                found[name] = sparse.csc_matrix(given, shape=shape)
            else:
                found[name] = values.reshape(shape, order="F")
    return found


def _from_matrix_market(path: Path) -> dict[str, Any]:
    from scipy import sparse  # noqa: PLC0415

    with reading(path, "a Matrix Market file") as text:
        first, _, rest = text.partition("\n")
        banner, _, form, kind, symmetry = first.lower().split()
        known = kind in ("real", "integer", "double") and symmetry in ("general", "symmetric")
        if banner != "%%matrixmarket" or form not in ("array", "coordinate") or not known:
            raise ValueError(f"its first line is {first!r}; it must be a real matrix")
        lines = (line for line in rest.splitlines() if line.strip() and line.lstrip()[0] != "%")
        rows, columns, *_ = (int(size) for size in next(lines).split())
        numbers = np.array(" ".join(lines).split(), dtype=np.float64)
        if form == "coordinate":
            at, to, values = numbers.reshape(-1, 3).T
            places = at.astype(np.int64) - 1, to.astype(np.int64) - 1
            matrix = sparse.coo_matrix((values, places), shape=(rows, columns)).tocsc()
        elif symmetry == "general":
            return {"matrix": numbers.reshape((rows, columns), order="F")}
        else:  # the columns of the lower triangle
            to, at = np.triu_indices(min(rows, numbers.size))
            matrix = sparse.coo_matrix((numbers, (at, to)), shape=(rows, columns)).tocsc()
        return {"matrix": matrix if symmetry == "general" else _both_triangles(matrix)}


def _both_triangles(matrix: Any) -> Any:
    """Complete a symmetric matrix of which a file has one triangle."""
    from scipy import sparse  # noqa: PLC0415

    return matrix + matrix.T - sparse.diags(matrix.diagonal())


def _from_nastran(path: Path) -> dict[str, Any]:
    """Read the DMIG matrices of a Nastran file, in ascending order of grid and component."""
    from scipy import sparse  # noqa: PLC0415

    entries: dict[str, list[tuple[tuple[int, int], tuple[int, int], float]]] = {}
    symmetric = set()
    with reading(path, "a Nastran file with DMIG entries") as text:
        for fields in _dmig_entries(text):
            name, *rest = fields
            if rest[0] == "0":  # the header
                if rest[1] not in _FORMS or rest[2] not in _REAL_TYPES:
                    raise SceneError(f"{path}: DMIG {name}: must be a square matrix of reals")
                entries[name] = []
                if rest[1] == "6":
                    symmetric.add(name)
                continue
            column = int(rest[0]), int(rest[1] or 0)
            for begin in range(3, len(rest), 4):
                grid, component, value, *_ = [*rest[begin : begin + 4], "", ""]
                if grid:
                    entries[name].append(((int(grid), int(component or 0)), column, _real(value)))
        # Both matrices have one order; a mass matrix does not list what has no mass.
        dofs = sorted(
            {dof for own in entries.values() for row, col, _ in own for dof in (row, col)}
        )
        index = {dof: i for i, dof in enumerate(dofs)}
        found = {}
        for name, own in entries.items():
            rows = np.array([index[row] for row, _, _ in own], dtype=np.intp)
            columns = np.array([index[column] for _, column, _ in own], dtype=np.intp)
            values = np.array([value for _, _, value in own])
            matrix = sparse.csc_matrix((values, (rows, columns)), shape=(len(dofs),) * 2)
            if name in symmetric:  # the file has one triangle
                matrix = _both_triangles(matrix)
            found[name] = matrix
    return found


def _dmig_entries(text: str) -> Iterator[list[str]]:
    """Give the fields of each DMIG entry behind its name, continuations included."""
    entry: list[str] = []
    for raw in text.splitlines():
        line = raw.partition("$")[0].rstrip()
        if not line:
            continue
        if line[:4].upper() == "DMIG" or line[0] not in "*+ ,":
            if entry:
                yield entry
            entry = []
        if entry or line[:4].upper() == "DMIG":
            entry += _fields(line)
    if entry:
        yield entry


def _fields(line: str) -> list[str]:
    """Split a line of Nastran behind its first field: separated by commas, or 8 or 16 wide."""
    if "," in line:
        return [field.strip() for field in line.split(",")[1:9]]
    width = 16 if "*" in line[:8] else 8
    return [line[begin : begin + width].strip() for begin in range(8, 72, width)]


def _real(text: str) -> float:
    """Read a real number of Nastran, such as 1.5D+03 or 1.5+3."""
    found = _REAL.fullmatch(text)
    if found is None:
        raise ValueError(f"{text!r} is no number")
    return float(f"{found[1]}e{found[2] or 0}")


#: Readers of matrices, by the ending of the file name.
_READERS: dict[str, Callable[[Path], dict[str, Any]]] = {
    ".npz": _from_numpy,
    ".npy": _from_numpy,
    ".mat": _from_matlab,
    ".mtx": _from_matrix_market,
    **dict.fromkeys((".pch", ".bdf", ".dat"), _from_nastran),
}

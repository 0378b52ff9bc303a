"""Mass and stiffness matrices of elastic housings come from files of several formats."""

from pathlib import Path

import numpy as np
import pytest

import gearbow as gb

scipy_io = pytest.importorskip("scipy.io")
sparse = pytest.importorskip("scipy.sparse")

#: A chain of three masses, of which the first is on the ground; n × n.
MASS = np.diag([5.0, 4.0, 3.0])
STIFFNESS = 1e6 * np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.5]])


def housing(mass, stiffness):
    seat = gb.Interface((0.0, 0.0, 0.0), rows=[0, 1, 2])
    return gb.Housing.from_matrices(
        "box", mass=mass, stiffness=stiffness, interfaces={"seat": seat}, highest_frequency=1e3
    )


def large(text: str, *values: object) -> str:
    return text.ljust(8) + "".join(str(value).rjust(16) for value in values)


def dmig(name: str, matrix: np.ndarray) -> list[str]:
    """Write a symmetric matrix as the punch file of Nastran: grids 2, 10 and 11, component 3."""
    grids = [2, 10, 11]
    lines = [large("DMIG*", name, 0, 6, 2), large("*", 0, "", "", 3)]
    for j, column in enumerate(grids):
        lines.append(large("DMIG*", name, column, 3))
        for i in range(j + 1):
            if matrix[i, j]:
                value = f"{matrix[i, j]:.9E}".replace("E", "D")
                lines.append(large("*", grids[i], 3, value))
    return lines


def write_files(folder: Path) -> dict[str, tuple[Path, Path]]:
    """Write the matrices in every format; give the files of mass and stiffness by its name."""
    found = {}

    def pair(name: str, ending: str, write) -> None:
        paths = folder / f"{name}_m{ending}", folder / f"{name}_k{ending}"
        for path, matrix in zip(paths, (MASS, STIFFNESS), strict=True):
            write(path, matrix)
        found[name] = paths

    def both(name: str, ending: str, write) -> None:
        path = folder / f"{name}{ending}"
        write(path)
        found[name] = path, path

    pair("npy", ".npy", np.save)
    pair("one array", ".npz", np.savez)
    pair("csc", ".npz", lambda path, matrix: sparse.save_npz(path, sparse.csc_matrix(matrix)))
    pair("coo", ".npz", lambda path, matrix: sparse.save_npz(path, sparse.coo_matrix(matrix)))
    pair("market", ".mtx", lambda path, a: scipy_io.mmwrite(path, sparse.coo_matrix(a)))
    pair("dense market", ".mtx", scipy_io.mmwrite)
    pair("general market", ".mtx", lambda p, a: scipy_io.mmwrite(p, a, symmetry="general"))
    pair(
        "all market",
        ".mtx",
        lambda p, a: scipy_io.mmwrite(p, sparse.csc_matrix(a), symmetry="general"),
    )
    both("two arrays", ".npz", lambda path: np.savez(path, M=MASS, K=STIFFNESS, nodes=[1, 2, 3]))
    named = {"M": sparse.csc_matrix(MASS), "K": sparse.csc_matrix(STIFFNESS)}
    both("sparse matlab", ".mat", lambda path: scipy_io.savemat(path, named, do_compression=True))
    dense = {"mass": MASS, "title": "chain", "stiffness": STIFFNESS}
    both("matlab", ".mat", lambda path: scipy_io.savemat(path, dense))
    lines = ["$ punch", *dmig("KAAX", STIFFNESS), *dmig("MAAX", MASS), "ENDDATA"]
    both("nastran", ".pch", lambda path: path.write_text("\n".join(lines)))
    small = """\
DMIG    K       0       6       1       0
DMIG    K       2       1               2       1       3.+6
DMIG    K       10      1               10      1       2.+6
*       2       1       -1.+6
DMIG,K,11,1,,11,1,2.5E6,0.,
,10,1,-1.E6
DMIG    M       0       1       1       0
DMIG    M       2       1               2       1       5.
DMIG    M       10      1               10      1       4.
DMIG    M       11      1               11      1       3.
""".replace("*       2", "        2")
    both("small fields", ".bdf", lambda path: path.write_text(small))
    return found


def test_every_format_gives_the_housing_of_the_arrays(tmp_path):
    expected = housing(MASS, STIFFNESS)
    for name, (mass, stiffness) in write_files(tmp_path).items():
        assert housing(mass, str(stiffness)) == expected, name


def test_errors_name_the_file_and_the_reason(tmp_path):
    np.savez(tmp_path / "two.npz", first=MASS, second=STIFFNESS)
    np.save(tmp_path / "objects.npy", np.array([{}, {}]), allow_pickle=True)
    (tmp_path / "text.npz").write_text("matrix")
    (tmp_path / "text.mtx").write_text("matrix")
    (tmp_path / "no.pch").write_text("GRID 1")
    (tmp_path / "complex.pch").write_text("DMIG,K,0,6,3,0")
    (tmp_path / "short.pch").write_text("DMIG,K,0,6,1,0\nDMIG,K,1,1,,1,1,x")
    bad = sparse.csc_matrix(MASS)
    bad.indices = np.array([0, 1, 1 << 20], dtype=np.int32)
    sparse.save_npz(tmp_path / "index.npz", bad)
    # The last column ends before the first one begins.
    negative = sparse.csc_matrix(MASS)
    negative.indptr = np.array([0, 1, 2, -3], dtype=np.int32)
    sparse.save_npz(tmp_path / "negative.npz", negative)
    for name, wanted in (
        ("two.npz", "one whose name begins with m; it has first, second"),
        ("objects.npy", r"is not a file of NumPy \(.npy\)"),
        ("text.npz", r"is not a file of NumPy \(.npz\)"),
        ("text.mtx", "is not a Matrix Market file"),
        ("no.pch", "it has none"),
        ("complex.pch", "DMIG K: must be a square matrix of reals"),
        ("short.pch", "'x' is no number"),
        ("index.npz", "is not a file with a sparse matrix"),
        ("negative.npz", "its last column ends at -3"),
    ):
        with pytest.raises(gb.SceneError, match=wanted) as caught:
            housing(tmp_path / name, STIFFNESS)
        assert name in str(caught.value)
    with pytest.raises(gb.SceneError, match=r"mass: must end with .npz"):
        housing("matrix.csv", STIFFNESS)
    with pytest.raises(FileNotFoundError):
        housing(tmp_path / "absent.npz", STIFFNESS)


def test_degrees_of_freedom_without_mass_follow_statically():
    """Two springs of 2e6 N/m in series carry 4 kg as one of 1e6 N/m does: 500 rad/s."""
    seat = gb.Interface((0.0, 0.0, 0.0), rows=[1, None, None])
    found = gb.Housing.from_matrices(
        "box",
        mass=np.diag([0.0, 4.0]),
        stiffness=[[4e6, -2e6], [-2e6, 2e6]],
        interfaces={"seat": seat},
        highest_frequency=1e3,
    )
    # round-off of one eigenvalue of two numbers
    assert found.elastic.frequencies == pytest.approx([500.0], rel=1e-12)


def test_matrices_that_are_no_masses_and_springs_are_refused():
    with pytest.raises(gb.SceneError, match="mass: must be positive definite"):
        housing(np.array([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), STIFFNESS)
    with pytest.raises(gb.SceneError, match="stiffness: leaves a degree of freedom without"):
        housing(np.diag([1.0, 1.0, 0.0]), np.diag([1e6, 1e6, 0.0]))

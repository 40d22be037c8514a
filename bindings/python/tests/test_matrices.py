"""Matrices of MFS_MATRIX_DIR (Matrix Market files with a manifest.csv) by mfs and by scipy's splu; a table is printed.

MFS_MATRIX_ROWS limits their size (6 000)."""

import csv
import os
import pathlib
import unittest

import numpy as np
import scipy.io
import scipy.sparse as sparse
import scipy.sparse.linalg

import mfs

FOLDER = os.environ.get("MFS_MATRIX_DIR", "")
ROWS = int(os.environ.get("MFS_MATRIX_ROWS", "6000"))


def backward_error(a, x, b):
    """max |b - Ax| / (|A||x| + |b|), componentwise (Oettli and Prager 1964)."""
    residual, size = abs(b - a @ x), abs(a) @ abs(x) + abs(b)
    return float(np.max(np.where(size > 0, residual / np.where(size > 0, size, 1), residual)))


def by_scipy(a, b):
    try:
        return backward_error(a, scipy.sparse.linalg.splu(a.tocsc()).solve(b), b)
    except RuntimeError:
        return float("inf")


@unittest.skipUnless(FOLDER, "MFS_MATRIX_DIR is not set")
class Matrices(unittest.TestCase):
    def test_solved_or_refused(self):
        folder, solved = pathlib.Path(FOLDER), 0
        with open(folder / "manifest.csv", newline="") as file:
            lines = list(csv.DictReader(file))
        for line in lines:
            if line["n"] != line["m"] or int(line["n"]) > ROWS:
                continue
            with self.subTest(line["name"]):
                a = sparse.csr_array(scipy.io.mmread(folder / (line["name"] + ".mtx.gz")))
                x = np.random.default_rng(3).standard_normal(a.shape[0])
                b = a @ x
                if not line["expect"].startswith("solve"):
                    self.assertRaises(mfs.SingularMatrix, mfs.spsolve, a, b)
                    continue
                errors = []
                for matrix in (a, a.tocsc()):
                    lu = mfs.splu(matrix)
                    errors += [backward_error(a, lu.solve(b), b), backward_error(a.T, lu.solve(b, "T"), b)]
                    lu.refactor(2 * matrix.data)
                    errors.append(backward_error(2 * a, lu.solve(b), b))
                print(f"{line['name']:20} {a.shape[0]:6}  mfs {max(errors):8.1e}  scipy {by_scipy(a, b):8.1e}")
                self.assertLess(max(errors), 1.1e-12)
                solved += 1
        self.assertGreater(solved, 0)


if __name__ == "__main__":
    unittest.main()

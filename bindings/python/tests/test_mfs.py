"""The package mfs beside scipy: right and wrong inputs of each call."""

import doctest
import multiprocessing
import signal
import threading
import unittest

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg

import mfs
import mfs._lu

TYPES = [np.float32, np.float64, np.complex64, np.complex128]


def unsymmetric(n, dtype=np.float64, seed=1):
    """Diagonally dominant in a cyclic order, so that its diagonal is weak."""
    random = np.random.default_rng(seed)
    a = sparse.random(n, n, 4 / n, random_state=random, format="coo")
    values = a.data + (1j * random.random(a.nnz) if np.dtype(dtype).kind == "c" else 0)
    a = sparse.coo_matrix((values, (a.row, a.col)), shape=(n, n)).tocsr()
    shift = sparse.csr_matrix((np.full(n, 9.0), (np.arange(n), (np.arange(n) + 1) % n)), shape=(n, n))
    return (a + shift).astype(dtype).tocsr()


def vectors(shape, dtype=np.float64):
    random = np.random.default_rng(5)
    b = random.standard_normal(shape)
    return (b + 1j * random.standard_normal(shape) if np.dtype(dtype).kind == "c" else b).astype(dtype)


def tolerance(dtype):
    return 1e4 * np.finfo(dtype).eps


class BesideScipy(unittest.TestCase):
    def check(self, a, b, trans="N"):
        x = mfs.splu(a, threads=2).solve(b, trans)
        expected = scipy.sparse.linalg.splu(sparse.csc_matrix(a)).solve(b, trans)
        self.assertEqual(x.dtype, expected.dtype)
        self.assertEqual(x.shape, b.shape)
        self.assertLess(np.linalg.norm(x - expected), tolerance(a.dtype) * np.linalg.norm(expected))

    def test_types_formats_and_transposes(self):
        for dtype in TYPES:
            a = unsymmetric(80, dtype)
            for trans in "NTH":
                for matrix in (a, a.tocsc(), sparse.csr_array(a), sparse.csc_array(a)):
                    self.check(matrix, vectors(80, dtype), trans)
                    self.check(matrix, vectors((80, 5), dtype), trans)

    def test_index_types_unsorted_and_repeated_entries(self):
        a = unsymmetric(40)
        expected = scipy.sparse.linalg.spsolve(a.tocsc(), vectors(40))
        for kind in (np.int32, np.int64, np.int16):
            other = a.copy()
            other.indptr, other.indices = other.indptr.astype(kind), other.indices.astype(kind)
            np.testing.assert_allclose(mfs.spsolve(other, vectors(40)), expected, rtol=1e-9)
        coo = a.tocoo()
        twice = sparse.coo_array((np.tile(coo.data / 2, 2), (np.tile(coo.row, 2), np.tile(coo.col, 2))), shape=a.shape)
        np.testing.assert_allclose(mfs.spsolve(twice, vectors(40)), expected, rtol=1e-9)
        order = np.argsort(-a.indices[: a.indptr[1]])
        a.indices[: a.indptr[1]], a.data[: a.indptr[1]] = a.indices[order], a.data[order]
        np.testing.assert_allclose(mfs.spsolve(a, vectors(40)), expected, rtol=1e-9)

    def test_right_hand_sides_of_other_orders_and_types(self):
        a = unsymmetric(30)
        lu, b = mfs.splu(a), vectors((60, 4))
        for other in (b[::2], np.asfortranarray(b[:30]), b[:30].astype(np.float32), (9 * b[:30]).astype(int)):
            np.testing.assert_allclose(a @ lu.solve(other), other, atol=1e-9)
        both = b[:30] + 1j * b[30:]
        np.testing.assert_allclose(a @ lu.solve(both), both, atol=1e-9)
        self.assertEqual(lu.solve(np.empty((30, 0))).shape, (30, 0))
        x = np.array(b[:30])
        self.assertIs(lu.solve(x, out=x), x)
        np.testing.assert_allclose(a @ x, b[:30], atol=1e-9)

    def test_integers_become_floats(self):
        a = sparse.csr_array([[2, 1], [0, 4]])
        np.testing.assert_allclose(mfs.spsolve(a, np.array([4, 4])), [1.5, 1])

    def test_refactor(self):
        for layout in ("csr", "csc"):
            a, other = unsymmetric(50).asformat(layout), unsymmetric(50).asformat(layout)
            other.data = other.data * np.linspace(1, 2, other.nnz)
            lu, b = mfs.splu(a), vectors(50)
            for new in (other, other.data, list(other.data)):
                lu.refactor(a.data)
                lu.refactor(new)
                np.testing.assert_allclose(other @ lu.solve(b), b, atol=1e-10)
            self.assertGreater(lu.report["time_refactor"], 0)

    def test_figures(self):
        a = unsymmetric(60)
        lu = mfs.splu(a, threads=1, scaling=False, tolerance=1e-11)
        lu.solve(vectors(60))
        sign, logarithm = lu.logdet()
        expected = np.linalg.slogdet(a.toarray())
        self.assertEqual(sign, expected[0])
        self.assertAlmostEqual(logarithm, expected[1], 8)
        exact = np.linalg.cond(a.toarray(), 1)
        self.assertTrue(exact / 10 < lu.condition_estimate() < exact * 1.001)
        report = lu.report
        self.assertEqual((report["n"], report["threads"], report["backend"]), (60, 1, "openmp"))
        self.assertIsInstance(report["nnz"], int)
        self.assertIs(report["single_precision"], False)
        self.assertLess(report["backward_error"], 1e-11)
        self.assertEqual(lu.nnz, report["nnz_factor"])
        self.assertEqual((lu.shape, lu.dtype), ((60, 60), np.float64))

    def test_depths(self):
        a = unsymmetric(600)
        lu = mfs.splu(a)
        depths, report = lu.depths, lu.report
        self.assertEqual(list(depths["depth"]), list(range(report["depths"])))
        for name, whole in (("pivots", 600), ("fronts", report["fronts"]), ("factor_entries", lu.nnz)):
            self.assertEqual(depths[name].sum(), whole)
        self.assertEqual(depths["max_front"].max(), report["max_front"])
        self.assertAlmostEqual(depths["flops"].sum() / report["flops"], 1, 9)

    def test_progress(self):
        seen = []
        lu = mfs.splu(unsymmetric(300), progress=lambda *now: seen.append(now))
        lu.solve(vectors(300))
        self.assertEqual(seen[-1][0], "solve")
        self.assertIn("factor", [phase for phase, _ in seen])
        self.assertTrue(all(0 <= fraction <= 1 for _, fraction in seen))

        class Enough(Exception):
            pass

        def end(phase, fraction):
            if phase == "solve":
                raise Enough("so far")

        lu = mfs.splu(unsymmetric(300), progress=end)
        self.assertRaisesRegex(Enough, "so far", lu.solve, vectors(300))
        self.assertRaisesRegex(mfs.InvalidInput, "progress", mfs.splu, unsymmetric(10), progress=7)

    def test_linear_operator(self):
        a = unsymmetric(70)
        near = a + 0.1 * unsymmetric(70, seed=2)
        inverse = mfs.splu(a).linear_operator()
        b = vectors(70)
        x, info = scipy.sparse.linalg.gmres(near, b, M=inverse, rtol=1e-10, atol=0)
        self.assertEqual(info, 0)
        np.testing.assert_allclose(near @ x, b, atol=1e-8)
        np.testing.assert_allclose(a.T @ (inverse.T @ b), b, atol=1e-9)
        symmetric = sparse.diags_array([np.linspace(1, 8, 70), -np.ones(69), -np.ones(69)], offsets=[0, 1, -1]).tocsc()
        found = scipy.sparse.linalg.eigsh(
            symmetric, 3, sigma=2.0, OPinv=mfs.splu(symmetric - 2 * sparse.eye_array(70)).linear_operator()
        )[0]
        every = np.linalg.eigvalsh(symmetric.toarray())
        nearest = np.sort(every[np.argsort(abs(every - 2))[:3]])
        np.testing.assert_allclose(np.sort(found), nearest, rtol=1e-9)

    def test_factorized(self):
        a = unsymmetric(20)
        np.testing.assert_allclose(a @ mfs.factorized(a)(vectors(20)), vectors(20), atol=1e-10)


class StepByStep(unittest.TestCase):
    def test_plan_factorize_solve_reset(self):
        a, b = unsymmetric(30), vectors(30)
        with mfs.Solver(a, b, threads=1) as solver:
            self.assertRaises(mfs.StateError, solver.factorize)
            solver.plan()
            self.assertRaises(mfs.StateError, solver.solve)
            solver.factorize()
            np.testing.assert_allclose(a @ solver.solve(), b, atol=1e-10)
            solver.reset_operands(b=2 * b)
            np.testing.assert_allclose(a @ solver.solve(), 2 * b, atol=1e-10)
            solver.reset_operands(a=3 * a.data)
            self.assertRaises(mfs.StateError, solver.solve)
            solver.factorize()
            np.testing.assert_allclose(3 * a @ solver.solve(), 2 * b, atol=1e-10)
            solver.reset_operands(a=sparse.eye_array(30).tocsr())
            self.assertRaises(mfs.PatternChanged, solver.factorize)
            solver.plan()
            solver.factorize()
            np.testing.assert_allclose(solver.solve(), 2 * b, atol=1e-10)
        self.assertIsNone(solver.lu)
        self.assertRaises(mfs.StateError, solver.solve)


class Refused(unittest.TestCase):
    def raises(self, kind, part, call, *arguments, **options):
        with self.assertRaisesRegex(kind, part) as caught:
            call(*arguments, **options)
        return caught.exception

    def test_options(self):
        a = unsymmetric(10)
        error = self.raises(mfs.InvalidInput, "treads", mfs.splu, a, treads=1)
        self.assertEqual(error.argument, "treads")
        self.raises(ValueError, "not be negative", mfs.splu, a, threads=-1)
        self.raises(mfs.InvalidInput, "not yes", mfs.splu, a, scaling="maybe")
        self.raises(mfs.InvalidInput, "not an integer", mfs.splu, a, threads=1.5)

    def test_matrices(self):
        self.raises(TypeError, "scipy.sparse", mfs.splu, np.eye(3))
        self.raises(mfs.InvalidInput, "not square", mfs.splu, sparse.csr_array((3, 4)))
        self.raises(mfs.InvalidInput, "", mfs.splu, sparse.csr_array((0, 0)))
        self.raises(TypeError, "no numbers of type", mfs.splu, sparse.csr_array(np.eye(3, dtype=np.longdouble)))
        a = unsymmetric(10)
        a.data[a.indptr[4]] = np.nan
        error = self.raises(mfs.InvalidInput, "row 4", mfs.splu, a)
        self.assertEqual((error.row, error.column), (4, a.indices[a.indptr[4]]))
        a = unsymmetric(10)
        a.indices[a.indptr[6]] = 10
        self.assertEqual(self.raises(mfs.InvalidInput, "", mfs.splu, a).row, 6)
        a = unsymmetric(10)
        a.indices = a.indices[:-1]
        self.raises(mfs.InvalidInput, "fewer", mfs.splu, a)

    def test_places_are_those_of_the_matrix_in_both_formats(self):
        a = unsymmetric(10).tolil()
        a[3, :] = 0
        a[3, 2] = np.inf
        for layout in ("csr", "csc"):
            error = self.raises(mfs.InvalidInput, "", mfs.splu, a.asformat(layout))
            self.assertEqual((error.row, error.column), (3, 2))
        a[3, 2] = 0
        a = sparse.csr_array(a.toarray())
        self.assertEqual(self.raises(mfs.SingularMatrix, "", mfs.splu, a).row, 3)
        self.assertEqual(self.raises(mfs.SingularMatrix, "transposed", mfs.splu, a.tocsc()).row, 3)

    def test_singular_matrices_have_no_solution(self):
        a = sparse.csr_array(np.ones((3, 3)) + np.diag([1.0, 0, 0]))
        error = self.raises(mfs.SingularMatrix, "", mfs.spsolve, a, np.ones(3))
        self.assertEqual((error.kind, error.dependent_rows), ("numerical", 1))
        self.assertIsInstance(error, RuntimeError)

    def test_right_hand_sides(self):
        lu = mfs.splu(unsymmetric(10))
        for b in (np.ones(9), np.ones((9, 10)), np.ones((10, 1, 1)), 1.0):
            self.raises(mfs.InvalidInput, "shape", lu.solve, b)
        self.raises(mfs.InvalidInput, "trans", lu.solve, np.ones(10), "X")
        self.assertEqual(self.raises(mfs.InvalidInput, "", lu.solve, np.full(10, np.nan)).argument, "b")
        np.testing.assert_allclose(lu.solve(np.zeros(10)), 0)

    def test_new_values(self):
        a = unsymmetric(10)
        lu = mfs.splu(a)
        self.raises(mfs.InvalidInput, "not as many", lu.refactor, a.data[1:])
        self.raises(mfs.InvalidInput, "complex", lu.refactor, 1j * a.data)
        self.raises(mfs.InvalidInput, "csc", lu.refactor, a.tocsc())
        self.raises(mfs.InvalidInput, "type", lu.refactor, a.astype(np.float32))
        other = a.tolil()
        other[5, :] = 1
        self.assertEqual(self.raises(mfs.PatternChanged, "", lu.refactor, other.tocsr()).row, 5)
        np.testing.assert_allclose(a @ lu.solve(np.ones(10)), 1, atol=1e-12)


class Threads(unittest.TestCase):
    def test_objects_of_several_threads_and_one_of_all(self):
        a, wrong = unsymmetric(300), []
        shared = mfs.splu(a, threads=1)

        def work(seed):
            b = vectors((300, 2)) * seed
            for lu in (shared, mfs.splu(a, threads=1)):
                if not np.allclose(a @ lu.solve(b), b, atol=1e-9):
                    wrong.append(seed)

        threads = [threading.Thread(target=work, args=(seed,)) for seed in range(1, 5)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_forked_processes(self):
        a, b = unsymmetric(3000), vectors(3000)
        lu = mfs.splu(a, threads=2)

        def work(results):
            found = [lu.solve(b), mfs.splu(a, threads=2).solve(b), mfs.splu(a, threads=1).solve(b)]
            results.put(max(np.linalg.norm(a @ x - b) for x in found))

        processes = multiprocessing.get_context("fork")
        results = processes.Queue()
        children = [processes.Process(target=work, args=(results,)) for _ in range(3)]
        for child in children:
            child.start()
        for child in children:
            self.assertLess(results.get(timeout=60), 1e-9)
        for child in children:
            child.join()

    def test_a_signal_ends_a_phase(self):
        class Ended(Exception):
            pass

        def end(*_):
            raise Ended

        n = 30
        line = sparse.diags_array([2.1 * np.ones(n), -np.ones(n - 1), -np.ones(n - 1)], offsets=[0, 1, -1])
        one = sparse.eye_array(n)
        cube = sparse.kron(sparse.kron(line, one), one) + sparse.kron(one, sparse.kron(line, one) + sparse.kron(one, line))
        before = signal.signal(signal.SIGALRM, end)
        try:
            signal.setitimer(signal.ITIMER_REAL, 0.2)
            try:
                mfs.splu(cube.tocsr(), threads=1)
                signal.setitimer(signal.ITIMER_REAL, 0)
            except Ended:
                pass
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)


def load_tests(loader, tests, pattern):
    tests.addTests(doctest.DocTestSuite(mfs._lu, optionflags=doctest.ELLIPSIS))
    tests.addTests(doctest.DocTestSuite(mfs))
    return tests


if __name__ == "__main__":
    unittest.main()

"""mfs.dae: the program mfs-dae (MFS_DAE_PROGRAM) with right and wrong models, and programs that only say they are it."""

import copy
import doctest
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import unittest
from unittest import mock

import numpy as np

import mfs
import mfs.dae

signal.signal(signal.SIGINT, signal.default_int_handler)  # jobs in the background of a script ignore it

FALLING = {
    "name": "falling", "end": 1, "outputs": 4, "gravity": [0, 0, -10], "parameters": {"m": 2},
    "bodies": {"block": {"type": "rigid", "mass": "m", "inertia": [1, 1, 1]}},
    "points": {"corner": {"body": "block", "point": [1, 0, 0]}},
}  # fmt: skip


class InOneFolder(unittest.TestCase):
    """Temporary folders of a test lie in a folder of its own, which is empty afterwards."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.temporary = self.folder / "temporary"
        self.temporary.mkdir()
        patched = mock.patch.object(tempfile, "tempdir", str(self.temporary))
        patched.start()
        self.addCleanup(patched.stop)

    def tearDown(self):
        self.assertEqual(list(self.temporary.iterdir()), [])

    def raises(self, kind, part, call, *arguments, **options):
        with self.assertRaisesRegex(kind, part) as caught:
            call(*arguments, **options)
        return caught.exception


class Runs(InOneFolder):
    def test_a_block_falls(self):
        given = copy.deepcopy(FALLING)
        result = mfs.dae.run(FALLING, threads=1)
        self.assertEqual(FALLING, given)
        np.testing.assert_allclose(result.t, [0, 0.25, 0.5, 0.75, 1])
        place = result["bodies.block.position"]
        self.assertEqual((place.shape, place.dtype), ((5, 3), np.float64))
        np.testing.assert_allclose(place[:, 2], -5 * result.t**2, atol=1e-6)
        np.testing.assert_allclose(result["energy.kinetic"], 100 * result.t**2, atol=1e-4)
        self.assertEqual(list(result.overview), ["acceleration corner [m/s2]"])
        np.testing.assert_allclose(result.overview["acceleration corner [m/s2]"], 10, atol=1e-6)
        self.assertIn("energy.balance", result)
        self.assertEqual(len(result), len(list(result)))
        self.assertNotIn("t", list(result))
        self.assertRaises(KeyError, lambda: result["bodies.block.posture"])
        self.assertTrue(np.all(np.diff(result.steps["t"]) > 0))
        self.assertEqual(len(result.steps), result.report["steps"])
        self.assertEqual((result.report["name"], result.report["threads"], result.folder), ("falling", 1, None))
        self.assertRegex(repr(result), "falling.*5 outputs")

    def test_models_of_numpy(self):
        model = {**FALLING, "gravity": np.array([0.0, 0, -1]), "outputs": np.int64(2), "end": np.float64(2)}
        model["record"] = np.array(["bodies.block.velocity"])
        result = mfs.dae.run(model)
        self.assertEqual(list(result), ["bodies.block.velocity"])
        np.testing.assert_allclose(result["bodies.block.velocity"][:, 2], [0, -1, -2], atol=1e-6)
        self.assertEqual(len(result.overview), 1)

    def test_more_numbers_than_the_series_has(self):
        model = copy.deepcopy(FALLING)
        model["bodies"] = {f"block{k}": FALLING["bodies"]["block"] for k in range(50)}
        model["points"] = {}
        result = mfs.dae.run(model)
        self.assertGreater(sum(int(np.prod(result[name].shape[1:])) for name in result), 1000)
        self.assertEqual(result.overview, {})
        np.testing.assert_allclose(result["bodies.block49.position"][-1], [0, 0, -5], atol=1e-6)

    def test_folders_files_names_and_parameters(self):
        result = mfs.dae.run(FALLING, folder=self.folder / "out", parameters={"m": 3}, backend="serial")
        self.assertEqual(result.folder, str(self.folder / "out"))
        self.assertTrue((self.folder / "out" / "result.pvd").exists())
        self.assertEqual(list((self.folder / "out").glob("*.png")), [])
        self.assertAlmostEqual(result["energy.kinetic"][-1], 150, 3)
        doubled = mfs.dae.run(FALLING, parameters={"m": "2 * 2"})
        self.assertAlmostEqual(doubled["energy.kinetic"][-1], 200, 3)
        self.assertIn("simple_pendulum: 0 flexible and 1 rigid", mfs.dae.check("simple_pendulum"))
        path = self.folder / "-falling.json"
        path.write_text(mfs.dae._dumped(FALLING), encoding="utf-8")
        before = os.getcwd()
        os.chdir(self.folder)
        try:
            for name in (path, "-falling.json"):
                self.assertRegex(mfs.dae.check(name), "^falling: ")
        finally:
            os.chdir(before)

    def test_models_of_the_library(self):
        names = mfs.dae.models()
        self.assertRegex(names["suspension"], "^Double wishbone")
        model = mfs.dae.model("suspension")
        self.assertEqual(model["name"], "suspension")
        self.assertNotEqual(mfs.dae.check(model), mfs.dae.check(model, refine=2))
        self.raises(KeyError, "perpetuum", mfs.dae.model, "perpetuum")

    def test_equilibrium_and_modes(self):
        rest = mfs.dae.static("simple_pendulum")
        self.assertEqual(rest["bodies.bob.position"].shape, (1, 3))
        self.assertEqual(len(rest.steps), 0)
        found = mfs.dae.modes("simple_pendulum", 1)
        self.assertAlmostEqual(found["frequency"][0], np.sqrt(9.81) / 2 / np.pi, 6)
        self.assertAlmostEqual(abs(found["s"][0]), 2 * np.pi * found["frequency"][0], 6)
        at = mfs.dae.modes("simple_pendulum", 1, at=0.0, undamped=True)
        self.assertLess(at["frequency"][0], found["frequency"][0])  # it begins where it is not at rest


# Two blocks in line along x, between walls: springs k, k, k; the rest is held by translational joints.
BLOCKS = {
    "name": "blocks", "end": 1, "outputs": 1, "parameters": {"k": 300, "c": 0},
    "bodies": {name: {"type": "rigid", "mass": 3, "inertia": [1, 1, 1], "position": [x, 0, 0]}
               for name, x in (("left", 1), ("right", 2))},
    "joints": {"rail_" + name: {"type": "translational", "a": "ground", "b": name, "point": [x, 0, 0], "axis": [1, 0, 0]}
               for name, x in (("left", 1), ("right", 2))},
    "forces": {f"spring_{x}": {"type": "spring_damper", "a": a, "b": b, "point_a": [x, 0, 0], "point_b": [x + 1, 0, 0],
                               "stiffness": "k", "damping": "c"}
               for a, b, x in (("ground", "left", 0), ("left", "right", 1), ("right", "ground", 2))},
}  # fmt: skip


class SmallMotions(InOneFolder):
    def free_motions(self, small):
        """Columns that span what the constraints leave free."""
        _, values, rows = np.linalg.svd(small.Phi_q.toarray())
        return rows[np.count_nonzero(values > 1e-9 * values[0]) :].T

    def test_two_blocks(self):
        small = mfs.dae.linearize(BLOCKS, parameters={"c": 6})
        n, m = len(small.coordinates), len(small.constraints)
        self.assertEqual([a.shape for a in (small.M, small.D, small.K, small.Phi_q)], [(n, n)] * 3 + [(m, n)])
        self.assertEqual((small.F.shape, small.Phi.shape, small.q.shape, small.multipliers.shape), ((n,), (m,), (n,), (m,)))
        self.assertEqual(small.M.format, "csr")
        place = [small.coordinates.index(name) for name in ("left.x", "right.x")]
        np.testing.assert_allclose(small.q[place], [1, 2], atol=1e-9)
        np.testing.assert_allclose(np.concatenate([small.F, small.Phi]), 0, atol=1e-6)
        for matrix, expected in ((small.M, [[3, 0], [0, 3]]), (small.K, [[600, -300], [-300, 600]]), (small.D, [[12, -6], [-6, 12]])):
            np.testing.assert_allclose(matrix.toarray()[np.ix_(place, place)], expected, atol=1e-6)
        z = self.free_motions(small)
        self.assertEqual(z.shape[1], 2)
        np.testing.assert_allclose(z[place] @ z[place].T, np.eye(2), atol=1e-9)  # nothing else is free
        self.assertRegex(repr(small), f"{n} coordinates, {m} constraints")
        self.assertTrue(any("rail_left" in name for name in small.constraints))

    def test_modes_with_shapes(self):
        found = mfs.dae.modes(BLOCKS, shapes=True)
        np.testing.assert_allclose(found["frequency"], np.sqrt([100, 300]) / (2 * np.pi), rtol=1e-9)
        small = mfs.dae.linearize(BLOCKS)
        left, right = (found["x"][:, small.coordinates.index(name)] for name in ("left.x", "right.x"))
        np.testing.assert_allclose(right / left, [1, -1], atol=1e-7)
        np.testing.assert_allclose(np.abs(found["x"]).max(axis=1), 1, rtol=1e-9)
        damped = mfs.dae.modes(BLOCKS, 1, shapes=True, parameters={"c": 6})
        self.assertEqual(damped["x"].shape, (1, len(small.coordinates)))
        self.assertAlmostEqual(damped["s"][0].real, -1, 7)  # 3 s^2 + 6 s + 300 = 0
        self.assertNotIn("x", mfs.dae.modes(BLOCKS, 1).dtype.names)

    def test_pendulums(self):
        # 1 kg at 1 m; upright, 1 kg m2 of each of three rods, 1 kg each of two at 1 m. The latter has redundant constraints.
        for name, squared in (("simple_pendulum", -9.81), ("four_bars_2", 9.81 * (3 / 2 + 2) / (3 / 3 + 2))):
            small = mfs.dae.linearize(name)
            z = self.free_motions(small)
            self.assertEqual(z.shape[1], 1)
            mass, stiffness = (float((z.T @ matrix @ z)[0, 0]) for matrix in (small.M, small.K))
            self.assertAlmostEqual(-stiffness / mass, squared, 4)
            mode = mfs.dae.modes(name, 1, shapes=True)[0]
            self.assertAlmostEqual(mode["s"] ** 2, -stiffness / mass, 7)
            force = (mode["s"] ** 2 * small.M + mode["s"] * small.D + small.K) @ mode["x"]
            np.testing.assert_allclose(z.T @ force, 0, atol=1e-6)
            np.testing.assert_allclose(small.Phi_q @ mode["x"], 0, atol=1e-9)

    def test_of_a_motion(self):
        at = mfs.dae.linearize("simple_pendulum", at=0.4)
        z = self.free_motions(at)
        bob = at.q[at.coordinates.index("bob.y")]
        self.assertLess(-0.9, bob)
        self.assertLess(bob, -0.5)
        # The rod of 1 m pulls with m g cos(angle) + m v^2, where v^2 = 2 g cos(angle).
        self.assertAlmostEqual(float((z.T @ at.K @ z)[0, 0] / (z.T @ at.M @ z)[0, 0]), -3 * 9.81 * bob, 2)

    def test_refused(self):
        self.raises(mfs.InvalidInput, "", mfs.dae.linearize, BLOCKS, at=-1.0)
        self.raises(mfs.InvalidInput, "no parameter 'm'", mfs.dae.linearize, BLOCKS, parameters={"m": 1})
        self.raises(mfs.InvalidInput, "cannot be read", mfs.dae.linearize, "perpetuum")
        self.raises(mfs.dae.Failed, "block.z moves most", mfs.dae.linearize, FALLING)  # no equilibrium
        self.raises(mfs.InvalidInput, "", mfs.dae.modes, BLOCKS, 0, shapes=True)


class Refused(InOneFolder):
    def test_models(self):
        for change, part in (
            ({"ende": 1}, "ende"),
            ({"end": -1}, "^end: "),
            ({"gravity": [0, 0]}, "gravity: must have three numbers, not 2"),
            ({"gravity": [0, 0, np.nan]}, "JSON"),
            ({"bodies": {"block": {"type": "rigid"}}}, "bodies.block.mass"),
            ({"joints": {"pin": {"type": "revolute", "a": "ground", "b": "rod"}}}, "joints.pin"),
        ):
            self.raises(mfs.InvalidInput, part, mfs.dae.run, {**FALLING, **change})
        self.raises(TypeError, "model", mfs.dae.run, 7)
        self.raises(TypeError, "complex", mfs.dae.run, {**FALLING, "end": 1j})
        self.raises(mfs.InvalidInput, "perpetuum: cannot be read", mfs.dae.run, "perpetuum")
        self.raises(mfs.InvalidInput, "--perpetuum: cannot be read", mfs.dae.run, "--perpetuum")

    def test_mesh_files_are_seen_from_here(self):
        mesh = {"type": "flexible", "material": "steel", "mesh": {"gmsh": "none.msh"}}
        steel = {"law": "neo_hookean", "young": 2e11, "poisson": 0.3, "density": 8000}
        model = {**FALLING, "materials": {"steel": steel}, "bodies": {"bar": mesh}, "points": {}}
        self.raises(mfs.InvalidInput, os.path.join(os.getcwd(), "none.msh"), mfs.dae.check, model)
        self.assertEqual(mesh["mesh"]["gmsh"], "none.msh")

    def test_options(self):
        self.raises(mfs.InvalidInput, "backend", mfs.dae.run, FALLING, backend="abacus")
        self.raises(mfs.InvalidInput, "no parameter 'k'", mfs.dae.run, FALLING, parameters={"k": 1})
        self.raises(mfs.InvalidInput, "refine", mfs.dae.run, FALLING, refine=-1)
        self.raises(ValueError, "threads", mfs.dae.run, FALLING, threads=-1)
        blocked = self.folder / "blocked"
        blocked.write_text("")
        self.raises(mfs.InvalidInput, "blocked", mfs.dae.run, FALLING, folder=blocked)

    def test_a_run_that_fails(self):
        model = {**FALLING, "integrator": {"min_step": 0.1, "initial_step": 0.1, "rtol": 1e-12}, "parameters": {"m": 2}}
        model["forces"] = {"push": {"type": "point", "side": "block", "point": [0, 0, 0], "x": "1 / (0.5 - t)^3"}}
        error = self.raises(mfs.dae.Failed, "", mfs.dae.run, model)
        self.assertIsInstance(error, mfs.Error)
        self.assertNotIn("mfs-dae: ", str(error))


class OtherPrograms(InOneFolder):
    def program(self, text):
        path = self.folder / "mfs-dae"
        path.write_text("#!/bin/sh\n" + textwrap.dedent(text), encoding="utf-8")
        path.chmod(0o755)
        patched = mock.patch.dict(os.environ, MFS_DAE_PROGRAM=str(path))
        patched.start()
        self.addCleanup(patched.stop)

    def test_exit_codes(self):
        for code, kind in (
            (2, mfs.InvalidInput), (3, mfs.InvalidInput), (4, mfs.SingularMatrix), (5, MemoryError),
            (6, mfs.AccuracyNotReached), (7, mfs.dae.Failed), (130, mfs.Error),
        ):  # fmt: skip
            self.program(f"echo a note >&2; echo 'mfs-dae: what happened' >&2; exit {code}")
            self.assertEqual(str(self.raises(kind, "", mfs.dae.run, FALLING)), "what happened")
        self.program("exit 99")
        self.raises(mfs.Error, "exit code 99", mfs.dae.run, FALLING)
        self.program("kill -9 $$")
        self.raises(mfs.Error, "ended by signal 9", mfs.dae.run, FALLING)

    def test_no_results(self):
        self.program("exit 0")
        self.raises(mfs.Error, "no results", mfs.dae.run, FALLING)

    def test_none(self):
        with mock.patch.dict(os.environ, MFS_DAE_PROGRAM=str(self.folder / "none")):
            error = self.raises(mfs.BackendError, "none, which is no program", mfs.dae.run, FALLING)
            self.assertEqual(error.library, "mfs-dae")
        with mock.patch.dict(os.environ, PATH=str(self.folder)), mock.patch.object(sys, "executable", "/none/python"):
            os.environ.pop("MFS_DAE_PROGRAM", None)
            self.raises(mfs.BackendError, "not on the PATH", mfs.dae.run, FALLING)
        self.program("echo falling")
        found = os.environ["MFS_DAE_PROGRAM"]
        with mock.patch.dict(os.environ, PATH=os.path.dirname(found) + ":" + os.environ["PATH"]):
            os.environ.pop("MFS_DAE_PROGRAM", None)
            self.assertEqual(mfs.dae.check(FALLING), "falling\n")

    def interrupted(self, text):
        """Has Ctrl-C come while the program sleeps; what it has written to the file `mark` by the time run() is left."""
        mark = self.folder / "mark"
        self.program(text.format(mark=mark))

        def when_it_runs():
            while not mark.exists() or "runs" not in mark.read_text():
                time.sleep(0.01)
            os.kill(os.getpid(), signal.SIGINT)

        waiting = threading.Thread(target=when_it_runs)
        waiting.start()
        try:
            self.assertRaises(KeyboardInterrupt, mfs.dae.run, FALLING)
        finally:
            waiting.join()
        return mark.read_text().split()

    def test_interrupted(self):
        sleeps = "sleep 60 >/dev/null 2>&1 & wait"  # not with the pipes whose end run() waits for
        words = self.interrupted("trap 'echo ends >>{mark}; exit 143' TERM\necho $$ runs >>{mark}\n" + sleeps)
        self.assertEqual(words[1:], ["runs", "ends"])
        self.assertRaises(ProcessLookupError, os.kill, int(words[0]), 0)

    def test_interrupted_and_will_not_end(self):
        with mock.patch.object(mfs.dae, "_SECONDS_TO_END", 0.1):
            words = self.interrupted("trap '' TERM\necho $$ runs >>{mark}\nexec sleep 60")
        self.assertEqual(words[1:], ["runs"])
        self.assertRaises(ProcessLookupError, os.kill, int(words[0]), 0)

    def test_an_interrupted_run_leaves_what_it_had(self):
        script = """
            import os, pathlib, signal, threading, time, mfs.dae
            def when_there_are_results():
                path = pathlib.Path("out/results.npy")
                while not path.exists() or path.stat().st_size < 8192:
                    time.sleep(0.01)
                os.kill(os.getpid(), signal.SIGINT)
            threading.Thread(target=when_there_are_results).start()
            model = mfs.dae.model("simple_pendulum")
            model.update(end=1000, outputs=10**5, record=["bodies.bob.position"])
            mfs.dae.run(model, folder="out", threads=1)
        """
        ended = subprocess.run(
            [sys.executable, "-c", textwrap.dedent(script)],
            cwd=self.folder,
            env={**os.environ, "TMPDIR": str(self.temporary)},
            stderr=subprocess.PIPE,
            text=True,
        )
        self.assertNotEqual(ended.returncode, 0)
        self.assertIn("KeyboardInterrupt", ended.stderr)
        records = mfs.dae._records(str(self.folder / "out" / "results.npy"))
        self.assertGreater(len(records), 10)
        np.testing.assert_allclose(np.linalg.norm(records["bodies.bob.position"], axis=1), 1, rtol=1e-6)


def load_tests(loader, tests, pattern):
    tests.addTests(doctest.DocTestSuite(mfs.dae, optionflags=doctest.ELLIPSIS))
    return tests


if __name__ == "__main__":
    unittest.main()

"""The examples run, and leave what they say."""

import importlib.util
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"
# Of machines, not of the example: processors that are newer than OpenBLAS.
OTHERS = ("-W", "ignore:OpenBLAS does not know:RuntimeWarning")


@unittest.skipUnless(importlib.util.find_spec("matplotlib"), "no matplotlib")
class Examples(unittest.TestCase):
    def test_draw_factorization(self):
        with tempfile.TemporaryDirectory() as folder:
            picture, matrix = pathlib.Path(folder) / "a.png", pathlib.Path(folder) / "a.mtx"
            matrix.write_text("%%MatrixMarket matrix coordinate real general\n2 2 3\n1 1 2\n1 2 1\n2 2 4\n")
            for arguments, part in ((["--points", "6"], "fronts, "), (["--file", matrix], "2 fronts, 0.7 times")):
                picture.unlink(missing_ok=True)
                command = [sys.executable, *OTHERS, EXAMPLES / "draw_factorization.py", *arguments, picture]
                done = subprocess.run(command, capture_output=True, text=True)
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertIn(part, done.stdout)
                data = picture.read_bytes()
                self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
                self.assertEqual(struct.unpack(">II", data[16:24]), (1125, 375))


if __name__ == "__main__":
    unittest.main()

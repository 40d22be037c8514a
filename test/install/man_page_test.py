"""cmake/man_page with the programs MFS_PROGRAMS (separated by :): every command and option is in the page, and roff takes it."""

import gzip
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "cmake" / "man_page"
PROGRAMS = os.environ["MFS_PROGRAMS"].split(":")
# As later versions of CLI11 write it.
IN_CAPITALS = """mfs: a program


Usage: mfs [OPTIONS] [SUBCOMMAND]


OPTIONS:
  -h,     --help              Print this help message
          --long-name-of-an-option TEXT:INT in [1 - 2]
                              in a line
                              of its own

SUBCOMMANDS:
  go                          Go there

Exit codes: 0 done.
.beware of dots
"""


def made(program):
    with tempfile.TemporaryDirectory() as folder:
        page = pathlib.Path(folder) / "page.1.gz"
        subprocess.run([SCRIPT, program, page], check=True)
        return gzip.decompress(page.read_bytes()).decode()


class ManPage(unittest.TestCase):
    def test_nothing_is_left_out(self):
        for program in PROGRAMS:
            page = made(program)
            whole = subprocess.check_output([program, "--help"], text=True)
            commands = re.findall(r"^  (\w+)  ", whole.partition("Subcommands:")[2], re.MULTILINE)
            self.assertGreater(len(commands), 3)
            for command in commands:
                self.assertIn(f"\n.SS {command}\n", page)
                text = subprocess.check_output([program, command, "--help"], text=True)
                for option in re.findall(r"^ +(-{1,2}[\w-]+)", text, re.MULTILINE):
                    self.assertIn("\\fB" + option.replace("-", "\\-"), page)
            for part in (".SH NAME\n", ".SH SYNOPSIS\n", ".SH EXIT STATUS\n0 ", ".SH SEE ALSO\n"):
                self.assertIn(part, page)

    @unittest.skipUnless(shutil.which("groff"), "no groff")
    def test_roff_takes_it(self):
        for program in PROGRAMS:
            taken = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-z"], input=made(program), capture_output=True, text=True)
            self.assertEqual((taken.returncode, taken.stderr), (0, ""))

    def test_another_help(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "mfs"
            program.write_text(f"#!/bin/sh\n[ $1 = --version ] && echo mfs 7 || cat <<'END'\n{IN_CAPITALS}END\n")
            program.chmod(0o755)
            page = made(program)
            self.assertIn('.TH MFS 1 "" "mfs 7" "User Commands"\n', page)
            self.assertIn(".TP\n\\fB\\-h,\\-\\-help\\fR\nPrint this help message\n", page)
            self.assertIn("\\fB\\-\\-long\\-name\\-of\\-an\\-option\\fR TEXT:INT in [1 \\- 2]\nin a line of its own\n", page)
            self.assertIn("\n.SS go\n", page)
            self.assertIn("\n\\&.beware of dots\n", page)
            program.write_text("#!/bin/sh\necho something else\n")
            refused = subprocess.run([SCRIPT, program, os.devnull], capture_output=True, text=True)
            self.assertNotEqual(refused.returncode, 0)
            self.assertIn("no help of CLI11", refused.stderr)


if __name__ == "__main__":
    unittest.main()

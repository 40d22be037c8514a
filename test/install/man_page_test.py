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
# As CLI11 2.5 and 2.6 write it: the latter folds lines, leaves blanks at their ends and has no word before the usage.
IN_CAPITALS = """mfs: a program{blank}


{usage}/usr/bin/mfs [OPTIONS] [SUBCOMMAND]


OPTIONS:
  -h,     --help              Print this help message{blank}
          --long-name-of-an-option TEXT:INT in [1 - 2]{blank}
                              in a line{blank}
                              of its own{blank}
          --to-its-column NUM of so many{blank}

SUBCOMMANDS:
  go                          Go there{blank}

Exit codes: 0 done,
1 not.{blank}
.beware of dots{blank}
"""
VERSIONS = [{"usage": "Usage: ", "blank": ""}, {"usage": "", "blank": " "}]


def made(program):
    with tempfile.TemporaryDirectory() as folder:
        page = pathlib.Path(folder) / "page.1.gz"
        subprocess.run([SCRIPT, program, page], check=True)
        return gzip.decompress(page.read_bytes()).decode()


def says(program, text):
    program.write_text(f"#!/bin/sh\n[ $1 = --version ] && echo mfs 7 || cat <<'END'\n{text}END\n")
    program.chmod(0o755)
    return program


class ManPage(unittest.TestCase):
    def test_nothing_is_left_out(self):
        for program in PROGRAMS:
            page = made(program)
            whole = subprocess.check_output([program, "--help"], text=True)
            commands = re.findall(r"^  (\w+)  ", re.split("subcommands:", whole, flags=re.I)[1], re.MULTILINE)
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

    def test_help_of_other_versions(self):
        for version in VERSIONS:
            with tempfile.TemporaryDirectory() as folder:
                program = says(pathlib.Path(folder) / "mfs", IN_CAPITALS.format(**version))
                page = made(program)
            self.assertIn('.TH MFS 1 "" "mfs 7" "User Commands"\n', page)
            self.assertIn(".SH NAME\nmfs \\- a program\n", page)
            self.assertIn(".TP\n\\fB\\-h,\\-\\-help\\fR\nPrint this help message\n", page)
            self.assertIn("\\fB\\-\\-long\\-name\\-of\\-an\\-option\\fR TEXT:INT in [1 \\- 2]\nin a line of its own\n", page)
            self.assertIn("\\fB\\-\\-to\\-its\\-column\\fR NUM\nof so many\n", page)
            self.assertIn("\n.SS go\n", page)
            self.assertIn(".SH EXIT STATUS\n0 done,\n1 not.\n", page)
            self.assertIn("\n\\&.beware of dots\n", page)

    def test_what_is_no_help_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            program = says(pathlib.Path(folder) / "mfs", "something else\n")
            refused = subprocess.run([SCRIPT, program, os.devnull], capture_output=True, text=True)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("no help of CLI11", refused.stderr)


if __name__ == "__main__":
    unittest.main()

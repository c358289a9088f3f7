"""tools/lint_scripts in a small project of its own: what it reads, and what it finds."""

import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]


class LintScriptsTest(unittest.TestCase):
    def setUp(self):
        self.project = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.project)
        (self.project / "tools").mkdir()
        shutil.copy(ROOT / "tools/lint_scripts", self.project / "tools")
        subprocess.run(["git", "init", "-q"], cwd=self.project, check=True)

    def lint(self, name, text, **environment):
        """Exit status and output with one file more."""
        (self.project / name).write_text(text)
        subprocess.run(["git", "add", "."], cwd=self.project, check=True)
        done = subprocess.run([self.project / "tools/lint_scripts"], stdout=subprocess.PIPE, text=True, check=False,
                              env={**os.environ, **environment})
        return done.returncode, done.stdout

    def test_what_is_clean_passes(self):
        (self.project / "notes.txt").write_text("x = $(ls *)\n")
        (self.project / "rig.py").write_text("ROOM = 1\n")
        self.assertEqual(self.lint("uses.py", "from rig import *\n\nprint(ROOM)\n")[0], 0)
        status, said = self.lint("run", '#!/bin/bash\necho "$1"\n')
        self.assertEqual((status, said), (0, "1 shell scripts, 3 Python files: no findings\n"))

    def test_a_program_that_fails_without_a_word_is_a_finding(self):
        broken = self.project / "bin/shellcheck"
        broken.parent.mkdir()
        broken.write_text("#!/bin/sh\nexit 3\n")
        broken.chmod(0o755)
        status, said = self.lint("run", '#!/bin/bash\necho "$1"\n', PATH=f"{broken.parent}:{os.environ['PATH']}")
        self.assertEqual((status, said), (1, "shellcheck: ended with exit code 3\n"))

    def test_each_language_by_its_name_and_its_first_line(self):
        shell, python = "cd $1 || exit\nx=`ls *.c`\n", "import json\nprint(nothing)\n"
        for name, text, words in (("a.sh", "#!/bin/sh\n" + shell, "a.sh"), ("b", "#!/usr/bin/env bash\n" + shell, "In b line"),
                                  ("c.py", python, "c.py:2"), ("d", "#!/usr/bin/python3\n" + python, "d:3")):
            with self.subTest(name=name):
                status, said = self.lint(name, text)
                self.assertEqual(status, 1)
                self.assertIn(words, said)


if __name__ == "__main__":
    unittest.main()

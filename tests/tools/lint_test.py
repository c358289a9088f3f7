"""tools/lint in a small project of its own: what it reads again, what it does not, and what gets no stamp."""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
CLEAN = '#include "part.h"\nint* nothing() { return nullptr; }\n'
FOUND = '#include "part.h"\nint* nothing() { return 0; }\n'


class LintTest(unittest.TestCase):
    def setUp(self):
        self.place = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.place)
        self.project = self.make_project("one")

    def make_project(self, name):
        project = self.place / name
        (project / "tools").mkdir(parents=True)
        (project / "build").mkdir()
        shutil.copy(ROOT / "tools/lint", project / "tools")
        (project / ".clang-tidy").write_text("Checks: '-*,modernize-use-nullptr'\nWarningsAsErrors: '*'\n")
        (project / "inner.h").write_text("#pragma once\n")
        (project / "part.h").write_text('#pragma once\n#include "inner.h"\n')
        for source in ("first", "second"):
            (project / f"{source}.cpp").write_text(CLEAN)
        self.write_commands(project, "c++")
        return project

    @staticmethod
    def write_commands(project, compiler):
        (project / "build/compile_commands.json").write_text(json.dumps([
            {"directory": f"{project}/build", "file": f"{project}/{name}.cpp",
             "command": f"{compiler} -I{project} -o {name}.o -c {project}/{name}.cpp"} for name in ("first", "second")]))

    def lint(self, project=None, **environment):
        """Exit status, and how many files were read."""
        project = project or self.project
        environment = {**os.environ, "CCACHE_DIR": f"{self.place}/cache", "XDG_CACHE_HOME": f"{self.place}/cache", **environment}
        done = subprocess.run([project / "tools/lint", project / "build", project / "first.cpp", project / "second.cpp"],
                              env=environment, capture_output=True, text=True)
        return done.returncode, int(done.stdout.split("files, ")[1].split()[0])

    def test_what_was_clean_is_not_read_again(self):
        self.assertEqual(self.lint(), (0, 2))
        self.assertEqual(self.lint(), (0, 0))

    def test_neither_in_another_folder(self):
        self.assertEqual(self.lint(), (0, 2))
        self.assertEqual(self.lint(self.make_project("another")), (0, 0))

    def test_a_changed_source_is_read_alone(self):
        self.lint()
        (self.project / "first.cpp").write_text(CLEAN + "// more\n")
        self.assertEqual(self.lint(), (0, 1))

    def test_a_changed_header_makes_all_that_see_it_read(self):
        self.lint()
        (self.project / "inner.h").write_text("#pragma once\n// more\n")
        self.assertEqual(self.lint(), (0, 2))

    def test_a_finding_in_a_changed_header_is_found(self):
        (self.project / ".clang-tidy").write_text("Checks: '-*,modernize-use-nullptr'\nWarningsAsErrors: '*'\nHeaderFilterRegex: '.*'\n")
        self.assertEqual(self.lint(), (0, 2))
        (self.project / "inner.h").write_text("#pragma once\ninline int* none() { return 0; }\n")
        self.assertEqual(self.lint(), (1, 2))

    def test_a_header_that_comes_to_be_found_is_seen(self):
        (self.project / "first.cpp").write_text('#if __has_include("late.h")\n#include "late.h"\n#endif\n')
        self.assertEqual(self.lint(), (0, 2))
        (self.project / "late.h").write_text("inline int* none() { return 0; }\n")
        self.assertEqual(self.lint()[1], 1)

    def test_changed_settings_make_all_read(self):
        self.lint()
        with (self.project / ".clang-tidy").open("a") as settings:
            settings.write("# more\n")
        self.assertEqual(self.lint(), (0, 2))

    def test_changed_compiler_arguments_make_all_read(self):
        self.lint()
        self.write_commands(self.project, "c++ -DMORE")
        self.assertEqual(self.lint(), (0, 2))

    def test_another_clang_tidy_makes_all_read(self):
        self.lint()
        other = self.place / "bin/clang-tidy"
        other.parent.mkdir()
        other.write_text(f'#!/bin/sh\n[ "$1" != --version ] || echo another\nexec {shutil.which("clang-tidy")} "$@"\n')
        other.chmod(0o755)
        self.assertEqual(self.lint(PATH=f"{other.parent}:{os.environ['PATH']}"), (0, 2))

    def test_what_failed_is_read_every_time(self):
        (self.project / "second.cpp").write_text(FOUND)
        self.assertEqual(self.lint(), (1, 2))
        self.assertEqual(self.lint(), (1, 1))
        (self.project / "second.cpp").write_text(CLEAN)
        self.assertEqual(self.lint()[0], 0)

    def test_the_oldest_stamps_go(self):
        for version in range(3):
            (self.project / "first.cpp").write_text(CLEAN + f"// {version}\n")
            self.assertEqual(self.lint(CANSYNC_LINT_STAMPS="2")[0], 0)
        self.assertEqual(self.lint(CANSYNC_LINT_STAMPS="2"), (0, 0))  # the last two are kept
        self.assertEqual(len(list((self.place / "cache/clang-tidy-passed").iterdir())), 2)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])

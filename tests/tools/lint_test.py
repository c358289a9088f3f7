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

    def lint(self, project=None, options=(), **environment):
        """Exit status, and how many files were read."""
        project = project or self.project
        environment = {**os.environ, "CCACHE_DIR": f"{self.place}/cache", "XDG_CACHE_HOME": f"{self.place}/cache", **environment}
        done = subprocess.run([project / "tools/lint", *options, project / "build", project / "first.cpp", project / "second.cpp"],
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

    def test_without_the_analyzer_the_rest_is_found_and_keeps_stamps_of_its_own(self):
        (self.project / ".clang-tidy").write_text("Checks: '-*,clang-analyzer-core.DivideZero,modernize-use-nullptr'\nWarningsAsErrors: '*'\n")
        (self.project / "first.cpp").write_text("int wrong() {\n  int zero = 0;\n  return 1 / zero;\n}\n")
        self.assertEqual(self.lint(options=["--without-analyzer"]), (0, 2))
        self.assertEqual(self.lint(), (1, 2))
        (self.project / "second.cpp").write_text(FOUND)
        self.assertEqual(self.lint(options=["--without-analyzer"]), (1, 1))

    def together(self, sources, checks="modernize-use-nullptr"):
        """What lint says of a target of these texts: exit status, its words, and how often it called clang-tidy."""
        (self.project / ".clang-tidy").write_text(f"Checks: '-*,{checks}'\nWarningsAsErrors: '*'\n")
        for name, text in sources.items():
            (self.project / f"{name}.cpp").write_text(text)
        (self.project / "build/compile_commands.json").write_text(json.dumps([
            {"directory": f"{self.project}/build", "file": f"{self.project}/{name}.cpp",
             "command": f"c++ -I{self.project} -o {name}.o -c {self.project}/{name}.cpp"} for name in sources]))
        counting = self.place / "bin/clang-tidy"
        counting.parent.mkdir(exist_ok=True)
        counting.write_text(f'#!/bin/sh\n[ "$1" = --version ] || echo >>{self.place}/calls\nexec {shutil.which("clang-tidy")} "$@"\n')
        counting.chmod(0o755)
        (self.place / "calls").write_text("")
        done = subprocess.run([self.project / "tools/lint", self.project / "build", *(self.project / f"{name}.cpp" for name in sources)],
                              env={**os.environ, "CCACHE_DIR": f"{self.place}/cache", "XDG_CACHE_HOME": f"{self.place}/cache",
                                   "PATH": f"{counting.parent}:{os.environ['PATH']}"}, capture_output=True, text=True)
        return done.returncode, done.stderr, len((self.place / "calls").read_text())

    def test_clean_sources_of_a_target_are_read_at_once(self):
        clean = {f"source{i}": f'#include "part.h"\nint* nothing{i}() {{ return nullptr; }}\n' for i in range(8)}
        self.assertEqual(self.together(clean), (0, "", 1))

    def test_what_one_of_many_has_is_told_of_it_alone(self):
        many = {f"source{i}": f'#include "part.h"\nint* nothing{i}() {{ return nullptr; }}\n' for i in range(8)}
        many["source5"] = FOUND
        code, said, calls = self.together(many)
        self.assertEqual(code, 1)
        self.assertEqual({line.split(":")[0] for line in said.splitlines() if "error:" in line}, {f"{self.project}/source5.cpp"})
        self.assertEqual(calls, 7)  # the eight, both halves of what was not clean three times
        self.assertEqual(self.together(many)[2], 1)  # the others have their stamps

    def test_sources_that_do_not_go_together_are_read_alone(self):
        same = {f"source{i}": f'#include "part.h"\nnamespace {{\nconst int kSame = {i};\n}}\nint number{i}() {{ return kSame; }}\n' for i in range(2)}
        self.assertEqual(self.together(same), (0, "", 3))

    def test_checks_that_look_at_a_source_alone_find_what_they_do(self):
        """Of each kind of check, one that reads only what stands in the source itself."""
        other = {f"other{i}": f'#include "part.h"\nint other{i}() {{ return {i}; }}\n' for i in range(3)}
        used = {"user": "namespace a { struct T; }\nnamespace { using a::T; }\nT* none();\n"}
        for check, text in {
            "misc-unused-using-decls": "namespace a { struct T; }\nusing a::T;\n",
            "readability-duplicate-include": '#include "part.h"\n\n#include "part.h"\n',
            "misc-unused-parameters": "static int one(int unused) { return 1; }\nint call() { return one(2); }\n",
            "misc-redundant-expression": "bool same(int a) { return a == a; }\n",
            "readability-else-after-return": "int sign(int a) {\n  if (a < 0) {\n    return -1;\n  } else {\n    return 1;\n  }\n}\n",
            "clang-analyzer-core.DivideZero": "int divide(int a) {\n  int zero = 0;\n  return a / zero;\n}\n",
            "bugprone-macro-parentheses": "#define TWICE(a) a * 2\nint two() { return TWICE(1); }\n",
            "bugprone-branch-clone": "int clone(bool a) {\n  if (a) {\n    return 1;\n  } else {\n    return 1;\n  }\n}\n",
        }.items():
            with self.subTest(check):
                code, said, _ = self.together({"finding": text, **other, **used}, check)
                self.assertEqual(code, 1, said)
                self.assertIn(f"[{check}", said)

    def test_the_oldest_stamps_go(self):
        for version in range(3):
            (self.project / "first.cpp").write_text(CLEAN + f"// {version}\n")
            self.assertEqual(self.lint(CANSYNC_LINT_STAMPS="2")[0], 0)
        self.assertEqual(self.lint(CANSYNC_LINT_STAMPS="2"), (0, 0))  # the last two are kept
        self.assertEqual(len(list((self.place / "cache/clang-tidy-passed").iterdir())), 2)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])

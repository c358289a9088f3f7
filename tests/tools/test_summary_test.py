"""What tools/test says at its end, with programs in the place of ctest, cmake and clang-format that only pretend."""

import os
import pathlib
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).parents[2]
PACKAGES = "packages: build, lintian, install"
MACHINES = "whole processes, real kernels, installed packages, in machines (dev)"

# Writes a log as ctest does: 17 tests, the later the longer. FAILS is what fails, and how, when it is chosen so; of what is tried
# alone ALONE is the exit status.
CTEST = """#!/bin/bash
folder=build/$2/Testing/Temporary
mkdir -p $folder
exec >$folder/LastTest.log
for i in $(seq 17); do
  printf '%d/17 Testing: %s%d\\nOutput:\\n' $i "${4//|/_}." $i
  printf 'Test time =  %d.50 sec\\n' $i
done
[ -z "${NOTE:-}" ] || echo "$NOTE" >>"$CANSYNC_NOTES"
[ -z "${SKIPS:-}" ] || echo "skipped: $SKIPS"
[ -z "${WAITS:-}" ] || { echo $$ >waits; sleep 600; }
[ "$3" != --parallel ] || { echo "$@" >>alone; exit "${ALONE:-0}"; }
[ "$4" = "${FAILS:-}" ] || exit 0
printf '3:a.thing\\n12:another\\n' >$folder/LastTestsFailed.log
exit 8
"""


class EndOfToolsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "tools").mkdir()
        for name in ("test", "test_summary"):
            shutil.copy(ROOT / "tools" / name, self.folder / "tools")
        for name, text in (("tools/install_packages", ""), ("tools/lint", ""), ("tools/lint_scripts", ""), ("tools/fuzz", ""), ("bin/cmake", ""), ("bin/clang-format", "exit $FORMAT_STATUS"),
                           ("bin/ctest", CTEST), ("tests/packages/run.py", "#!/usr/bin/python3\n")):
            path = self.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text if text.startswith("#!") else f"#!/bin/bash\n{text}\n")
            path.chmod(0o755)
        (self.folder / "a.h").touch()
        for command in (["init", "-q"], ["add", "a.h"]):
            subprocess.run(["git", *command], cwd=self.folder, check=True)

    def start_tests(self, *arguments, **environment):
        (self.folder / "tmp").mkdir(exist_ok=True)
        environment = {**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}", "TMPDIR": f"{self.folder}/tmp", "FORMAT_STATUS": "0",
                       **environment}
        return subprocess.Popen(["tools/test", *arguments], cwd=self.folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def run_tests(self, *arguments, **environment):
        with self.start_tests(*arguments, **environment) as running:
            told = running.communicate()[0]
        self.assertEqual(list((self.folder / "tmp").iterdir()), [])
        return running.returncode, told.rstrip().splitlines()

    def test_names_steps_and_the_slowest_tests(self):
        status, lines = self.run_tests()
        self.assertEqual(status, 0)
        steps = lines[lines.index("steps") + 1:]
        self.assertEqual([row.split(" s  ")[1] for row in steps[:steps.index("")]],
                         ["Debian packages", "format", "build (dev)", "unit tests (dev)", "whole processes, one boot (dev)"])
        slowest = lines[lines.index("slowest of 34 tests") + 1:]
        slowest = slowest[:slowest.index("")]
        self.assertEqual(len(slowest), 15)
        self.assertEqual(slowest[0].split()[0], "17.5")
        self.assertTrue(slowest[0].endswith(" (dev)"), slowest[0])
        self.assertEqual(slowest[-1].split()[0], "10.5")

    def test_last_line_tells_what_is_to_be_noted(self):
        status, lines = self.run_tests(NOTE="failed once, passed in course 2: the boot")
        self.assertEqual(status, 0)
        self.assertEqual(lines[-1], "tools/test: passed in 0 min; " + "; ".join(["failed once, passed in course 2: the boot"] * 2))

    def test_last_line_names_the_step_that_failed(self):
        status, lines = self.run_tests("--all", FAILS="kernel")
        self.assertEqual(status, 14)
        self.assertIn("slowest of 34 tests", lines)
        self.assertEqual(lines[-1], 'tools/test: FAILED in step "' + MACHINES + '" (exit code 14): a.thing, another')
        self.assertFalse((self.folder / "alone").exists(), "what has a time of its own has one try")

    def test_what_fails_on_the_time_of_the_computer_is_tried_alone_at_the_end(self):
        status, lines = self.run_tests("--all", FAILS="unsanitized")
        self.assertEqual(status, 0)
        self.assertEqual((self.folder / "alone").read_text().splitlines(),
                         [f"--preset dev --parallel 1 --tests-regex ^{name}$" for name in ("a[.]thing", "another")])
        self.assertEqual(lines[-1], "tools/test: passed in 0 min; failed once, passed alone: a.thing (dev); failed once, passed alone: another (dev)")
        status, lines = self.run_tests("--all", FAILS="unsanitized", ALONE="8")
        self.assertEqual(status, 13)
        self.assertEqual(lines[-1], 'tools/test: FAILED in step "tests that failed, alone" (exit code 13): a.thing (dev), another (dev)')

    def test_what_failed_before_is_not_forgotten_when_another_step_fails(self):
        (self.folder / "tools/lint").write_text("#!/bin/bash\necho 'a.cpp:1: error: too long'\nexit 1\n")
        status, lines = self.run_tests("--all", FAILS="unsanitized")
        self.assertEqual(status, 16)
        self.assertEqual(lines[-1], 'tools/test: FAILED in step "lint (clang-tidy)" (exit code 16): a.cpp:1: error: too long; '
                         "failed before, and not tried again: a.thing (dev), another (dev)")

    def test_a_machine_that_cannot_run_is_no_test_that_passed(self):
        for tier, step in (((), "whole processes, one boot (dev)"), (("--all",), MACHINES)):
            status, lines = self.run_tests(*tier, SKIPS="qemu-system-x86_64 is not installed")
            self.assertEqual(status, 10)
            self.assertEqual(lines[-1], f'tools/test: step could not start "{step}" (exit code 10): qemu-system-x86_64 is not installed')

    def test_what_is_stopped_leaves_nothing(self):
        for stop in (signal.SIGTERM, signal.SIGINT, signal.SIGKILL):
            with self.subTest(stop), self.start_tests(WAITS="yes") as running:
                waits = self.folder / "waits"
                while not waits.exists() or not waits.read_text().strip():
                    self.assertIsNone(running.poll())
                    time.sleep(0.05)
                test = int(waits.read_text())
                running.send_signal(stop)
                told = running.communicate()[0]
                self.assertIn(running.returncode, (130, -signal.SIGKILL))
                self.assertIn('tools/test: stopped in step "unit tests (dev)"', told)
                waits.unlink()
                self.assertFalse(pathlib.Path(f"/proc/{test}").exists())
                self.assertEqual(list((self.folder / "tmp").iterdir()), [])

    def test_without_python_the_last_line_still_says_where(self):
        (self.folder / "tools/test_summary").write_text("#!/nowhere/python3\n")
        status, lines = self.run_tests(FORMAT_STATUS="3")
        self.assertEqual(status, 11)
        self.assertEqual(lines[-1], 'tools/test: step "format" ended with exit code 11')

    def test_without_git_it_says_so(self):
        shutil.rmtree(self.folder / ".git")
        status, lines = self.run_tests()
        self.assertEqual(status, 11)
        self.assertIn("not a git repository", lines[-1])

    def test_a_failure_before_any_test_ends_with_the_steps_alone(self):
        status, lines = self.run_tests(FORMAT_STATUS="3")
        self.assertEqual(status, 11)
        self.assertIn("steps", lines)
        self.assertFalse([line for line in lines if line.startswith("slowest")])
        self.assertEqual(lines[-1], 'tools/test: FAILED in step "format" (exit code 11): it said nothing')

    def test_each_step_has_its_exit_code_and_the_last_line_says_why(self):
        for program, says, code, step, why in (
                ("bin/clang-format", "a.h:3:1: error: code should be clang-formatted", 11, "format", "a.h:3:1: error: code should be clang-formatted"),
                ("bin/cmake", "FAILED: a.o\na.cpp:3:1: error: expected ;\na.cpp:9:1: error: x\nninja: build stopped: subcommand failed.", 12, "build (dev)",
                 "a.cpp:3:1: error: expected ;"),
                ("bin/cmake", "CMake Error at CMakeLists.txt:3 (find_package):\n  There is no fmt.\n-- Configuring incomplete, errors occurred!", 12,
                 "build (dev)", "CMake Error at CMakeLists.txt:3 (find_package): There is no fmt."),
                ("tests/packages/run.py", "run.py: lintian --fail-on error,warning x: exit code 2\nE: cansyncd: no-manual-page", 15, PACKAGES,
                 "E: cansyncd: no-manual-page"),
                ("tests/packages/run.py", " 12.3 a unit failed\n 99.1 FAIL: test_5 (a.A.test_5)\n 99.2 FAILED (failures=1)\nrun.py: this course again", 15,
                 PACKAGES, "test_5"),
                ("tools/lint", "a.cpp:1: error: too long\nclang-tidy: 1 files, 1 of them read, 1 with findings", 16, "lint (clang-tidy)",
                 "a.cpp:1: error: too long"),
                ("tools/fuzz", "master failed; all it said: log\nfuzzing has found something", 17, "fuzzing", "master failed; all it said: log")):
            with self.subTest(program):
                path = self.folder / program
                kept = path.read_text()
                path.write_text(f"print({says!r})\nraise SystemExit(1)\n" if program.endswith(".py") else
                                f"#!/bin/bash\nprintf '%s\\n' {shlex.quote(says)}\nexit 1\n")
                status, lines = self.run_tests("--all")
                path.write_text(kept)
                self.assertEqual(status, code)
                self.assertEqual(lines[-1], f'tools/test: FAILED in step "{step}" (exit code {code}): {why}', "\n".join(lines))

    def test_what_cannot_be_had_is_no_failed_test(self):
        (self.folder / "tools/install_packages").write_text("#!/bin/bash\necho 'E: Unable to locate package ninja-build' >&2\nexit 100\n")
        status, lines = self.run_tests()
        self.assertEqual(status, 10)
        self.assertEqual(lines[-1], 'tools/test: step could not start "Debian packages" (exit code 10): E: Unable to locate package ninja-build')
        (self.folder / "tools/install_packages").write_text("#!/bin/bash\n")
        (self.folder / "tests/packages/run.py").write_text("print('no mirror of Debian can be reached')\nraise SystemExit(77)\n")
        status, lines = self.run_tests("--all")
        self.assertEqual(status, 10)
        self.assertIn('could not start "packages: build', lines[-1])

    def test_help_lists_the_exit_codes(self):
        status, lines = self.run_tests("--help")
        self.assertEqual(status, 0)
        self.assertIn("13 tests on this computer", " ".join(lines))

if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])

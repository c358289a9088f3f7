"""What tools/test says at its end, with programs in the place of ctest, cmake and clang-format that only pretend."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]

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
[ -z "${REPEATED:-}" ] || echo "$REPEATED" >>"$CANSYNC_REPEATED"
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
        for name, text in (("tools/install_packages", ""), ("tools/lint", ""), ("tools/fuzz", ""), ("bin/cmake", ""), ("bin/clang-format", "exit $FORMAT_STATUS"),
                           ("bin/ctest", CTEST), ("tests/packages/run.py", "#!/usr/bin/python3\n")):
            path = self.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text if text.startswith("#!") else f"#!/bin/bash\n{text}\n")
            path.chmod(0o755)
        (self.folder / "a.h").touch()
        for command in (["init", "-q"], ["add", "a.h"]):
            subprocess.run(["git", *command], cwd=self.folder, check=True)

    def run_tests(self, *arguments, **environment):
        environment = {**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}", "FORMAT_STATUS": "0", **environment}
        done = subprocess.run(["tools/test", *arguments], cwd=self.folder, env=environment, capture_output=True, text=True)
        return done.returncode, done.stdout.rstrip().splitlines()

    def test_names_steps_and_the_slowest_tests(self):
        status, lines = self.run_tests()
        self.assertEqual(status, 0)
        steps = lines[lines.index("steps") + 1:]
        self.assertEqual([row.split(" s  ")[1] for row in steps[:steps.index("")]],
                         ["packages", "format", "build (dev)", "unit tests (dev)", "whole processes, one boot (dev)"])
        slowest = lines[lines.index("slowest of 34 tests") + 1:]
        slowest = slowest[:slowest.index("")]
        self.assertEqual(len(slowest), 15)
        self.assertEqual(slowest[0].split()[0], "17.5")
        self.assertTrue(slowest[0].endswith(" (dev)"), slowest[0])
        self.assertEqual(slowest[-1].split()[0], "10.5")

    def test_last_line_names_what_passed_only_when_it_was_repeated(self):
        status, lines = self.run_tests(REPEATED="the boot")
        self.assertEqual(status, 0)
        self.assertEqual(lines[-1], "tools/test: passed in 0 min; passed only alone: the boot; passed only alone: the boot")

    def test_last_line_names_the_step_that_failed(self):
        status, lines = self.run_tests("--all", FAILS="kernel")
        self.assertEqual(status, 8)
        self.assertIn("slowest of 34 tests", lines)
        self.assertEqual(lines[-1], "tools/test: FAILED in: whole processes and real kernels, in machines (dev)")
        self.assertFalse((self.folder / "alone").exists(), "what has a time of its own has one try")

    def test_what_fails_on_the_time_of_the_computer_is_tried_alone_at_the_end(self):
        status, lines = self.run_tests("--all", FAILS="unsanitized")
        self.assertEqual(status, 0)
        self.assertEqual((self.folder / "alone").read_text().splitlines(),
                         [f"--preset dev --parallel 1 --tests-regex ^{name}$" for name in ("a[.]thing", "another")])
        self.assertEqual(lines[-1], "tools/test: passed in 0 min; passed only alone: a.thing (dev); passed only alone: another (dev)")
        status, lines = self.run_tests("--all", FAILS="unsanitized", ALONE="8")
        self.assertEqual(status, 1)
        self.assertEqual(lines[-1], "tools/test: FAILED in: tests that failed, alone")

    def test_a_failure_before_any_test_ends_with_the_steps_alone(self):
        status, lines = self.run_tests(FORMAT_STATUS="3")
        self.assertNotEqual(status, 0)
        self.assertIn("steps", lines)
        self.assertFalse([line for line in lines if line.startswith("slowest")])
        self.assertEqual(lines[-1], "tools/test: FAILED in: format")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])

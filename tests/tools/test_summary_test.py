"""What tools/test says at its end, with programs in the place of ctest, cmake and clang-format that only pretend."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]

# Writes a log as ctest does: 17 tests, the later the longer; those of the kernel fail when told to.
CTEST = """#!/bin/bash
mkdir -p build/$2/Testing/Temporary
exec >build/$2/Testing/Temporary/LastTest.log
for i in $(seq 17); do
  printf '%d/17 Testing: %s%d\\nOutput:\\n' $i "${4//|/_}." $i
  printf 'Test time =  %d.50 sec\\n' $i
done
[ -z "${REPEATED:-}" ] || echo "$REPEATED" >>"$CANSYNC_REPEATED"
[ "$4" != kernel ] || exit "${KERNEL_STATUS:-0}"
"""


class EndOfToolsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "tools").mkdir()
        for name in ("test", "test_summary"):
            shutil.copy(ROOT / "tools" / name, self.folder / "tools")
        for name, text in (("tools/install_packages", ""), ("bin/cmake", ""), ("bin/clang-format", "exit $FORMAT_STATUS"), ("bin/ctest", CTEST)):
            path = self.folder / name
            path.parent.mkdir(exist_ok=True)
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
        status, lines = self.run_tests("--quick")
        self.assertEqual(status, 0)
        steps = lines[lines.index("steps") + 1:]
        self.assertEqual([row.split(" s  ")[1] for row in steps[:steps.index("")]],
                         ["packages", "format", "build (dev)", "tests (dev)"])
        slowest = lines[lines.index("slowest of 17 tests") + 1:]
        slowest = slowest[:slowest.index("")]
        self.assertEqual(len(slowest), 15)
        self.assertEqual(slowest[0].split()[0], "17.5")
        self.assertTrue(slowest[0].endswith(" (dev)"), slowest[0])
        self.assertEqual(slowest[-1].split()[0], "3.5")

    def test_last_line_names_what_passed_only_when_it_was_repeated(self):
        status, lines = self.run_tests("--quick", REPEATED="the boot")
        self.assertEqual(status, 0)
        self.assertEqual(lines[-1], "tools/test: passed in 0 min; only when repeated: the boot")

    def test_last_line_names_the_step_that_failed(self):
        status, lines = self.run_tests(KERNEL_STATUS="8")
        self.assertEqual(status, 8)
        self.assertIn("slowest of 51 tests", lines)
        self.assertEqual(lines[-1], "tools/test: FAILED in: tests on real kernels (dev)")

    def test_a_failure_before_any_test_ends_with_the_steps_alone(self):
        status, lines = self.run_tests("--quick", FORMAT_STATUS="3")
        self.assertNotEqual(status, 0)
        self.assertIn("steps", lines)
        self.assertFalse([line for line in lines if line.startswith("slowest")])
        self.assertEqual(lines[-1], "tools/test: FAILED in: format")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])

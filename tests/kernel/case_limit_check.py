"""The limit of a test (case_limit.py) ends what waits for ever, and lets the next one run; no test at all is a failure (inside.py)."""

import io
import os
import signal
import subprocess
import sys
import unittest
from unittest import mock

import case_limit


class CaseLimit(unittest.TestCase):
    def test_an_endless_case_fails_and_the_next_one_runs(self):
        done = []

        class Cases(unittest.TestCase):
            def test_1_waits_for_ever(self):
                while True:
                    signal.pause()

            def test_2_passes(self):
                done.append(True)

        runner = unittest.TextTestRunner(stream=io.StringIO(), resultclass=case_limit.WithLimit)
        with mock.patch.object(case_limit, "CASE", 1):
            result = runner.run(unittest.defaultTestLoader.loadTestsFromTestCase(Cases))
        self.assertEqual((len(result.failures), done), (1, [True]))
        self.assertIn("has not ended within 1 s", result.failures[0][1])

    def test_a_run_without_a_test_fails(self):
        inside = os.path.join(os.path.dirname(os.path.abspath(__file__)), "inside.py")
        done = subprocess.run([sys.executable, "-B", inside, "nobody_has_this_name.py"], capture_output=True, text=True, check=False, timeout=60)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertIn("Ran 0 tests", done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()

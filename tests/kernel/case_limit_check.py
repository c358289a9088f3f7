"""The limit of a test (case_limit.py) ends what waits for ever, and lets the next one run."""

import io
import signal
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


if __name__ == "__main__":
    unittest.main()

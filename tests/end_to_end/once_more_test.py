"""How the tests on real kernels repeat what failed (tests/kernel/once_more.py)."""

import contextlib
import io
import os
import signal
import sys
import unittest
from unittest import mock

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "kernel"))

import once_more  # noqa: E402: found on the path that was set above

tries = {}


class Cases:
    """In a class of its own, so that nobody finds them who looks for tests here."""

    class Good(unittest.TestCase):
        def test_passes(self):
            tries["good"] = tries.get("good", 0) + 1

    class Weak(unittest.TestCase):
        def test_fails_once(self):
            tries["weak"] = tries.get("weak", 0) + 1
            self.assertGreater(tries["weak"], 1)

    class Wrong(unittest.TestCase):
        def test_fails_always(self):
            tries["wrong"] = tries.get("wrong", 0) + 1
            for value in (1, 2):
                with self.subTest(value=value):
                    self.fail()

    class Endless(unittest.TestCase):
        def test_waits_for_ever(self):
            tries["endless"] = tries.get("endless", 0) + 1
            while True:
                signal.pause()

    class NoStart(unittest.TestCase):
        @classmethod
        def setUpClass(cls):
            tries["start"] = tries.get("start", 0) + 1
            if tries["start"] < 2:
                raise OSError("as it is meant to")

        def test_passes(self):
            tries["started"] = 1


class OnceMore(unittest.TestCase):
    def run_cases(self, *cases):
        """Whether all passed, and the last line."""
        tries.clear()
        load = unittest.defaultTestLoader.loadTestsFromTestCase
        shown = io.StringIO()
        with contextlib.redirect_stdout(shown):
            passed = once_more.run(unittest.TestSuite(map(load, cases)), unittest.TextTestRunner(stream=shown))
        return passed, shown.getvalue().splitlines()[-1]

    def test_what_passes_runs_once(self):
        self.assertEqual(self.run_cases(Cases.Good), (True, "OK"))
        self.assertEqual(tries, {"good": 1})

    def test_one_failure_runs_once_more_alone_and_is_told_last(self):
        passed, last = self.run_cases(Cases.Good, Cases.Weak)
        self.assertTrue(passed)
        self.assertEqual(last, "repeated alone, and passed: __main__.Cases.Weak.test_fails_once")
        self.assertEqual(tries, {"good": 1, "weak": 2})

    def test_what_fails_again_has_failed(self):
        passed, last = self.run_cases(Cases.Wrong)
        self.assertFalse(passed)
        self.assertEqual(last, "repeated alone, and failed again: __main__.Cases.Wrong.test_fails_always")
        self.assertEqual(tries, {"wrong": 2})

    def test_a_class_whose_set_up_failed_is_one_failure(self):
        passed, last = self.run_cases(Cases.NoStart, Cases.Good)
        self.assertTrue(passed)
        self.assertEqual(last, "repeated alone, and passed: __main__.Cases.NoStart")
        self.assertEqual(tries, {"start": 2, "started": 1, "good": 1})

    def test_a_case_that_does_not_end_has_failed_and_the_others_run(self):
        with mock.patch.object(once_more, "CASE", 1):
            passed, last = self.run_cases(Cases.Endless, Cases.Good)
        self.assertFalse(passed)
        self.assertEqual(last, "repeated alone, and failed again: __main__.Cases.Endless.test_waits_for_ever")
        self.assertEqual(tries, {"endless": 2, "good": 1})

    def test_two_failures_are_not_repeated(self):
        passed, last = self.run_cases(Cases.Weak, Cases.Wrong)
        self.assertFalse(passed)
        self.assertEqual(last, "2 tests failed, none was repeated: __main__.Cases.Weak.test_fails_once, "
                               "__main__.Cases.Wrong.test_fails_always")
        self.assertEqual(tries, {"weak": 1, "wrong": 1})

    def test_no_test_at_all_is_a_failure(self):
        self.assertFalse(once_more.run(unittest.TestSuite(), unittest.TextTestRunner(stream=io.StringIO())))


if __name__ == "__main__":
    unittest.main()

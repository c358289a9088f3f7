"""Which courses machine.in_courses tries, and what it tells of them."""

import os
import tempfile
import unittest
from unittest import mock

import machine


class Courses(unittest.TestCase):
    def setUp(self):
        self.notes = self.enterContext(tempfile.NamedTemporaryFile("r"))

    def try_all(self, codes, **environment):
        """`codes`: the exit code of each course that there is. What came of it, the courses tried, and what was told."""
        tried = []

        def run(seed):
            tried.append(seed)
            return codes[seed]

        run.name = "the boot"
        with mock.patch.dict(os.environ, {"CANSYNC_NOTES": self.notes.name, **environment}):
            if "CANSYNC_SEED" not in environment:
                os.environ.pop("CANSYNC_SEED", None)
            return machine.in_courses(run), tried, self.notes.read()

    def test_what_passes_is_done_once(self):
        self.assertEqual(self.try_all({1: 0}), (0, [1], ""))

    def test_what_fails_in_one_course_alone_passes_and_is_told(self):
        self.assertEqual(self.try_all({1: 1, 2: 0}), (0, [1, 2], "failed once, passed in course 2: the boot\n"))

    def test_what_does_not_end_has_had_its_time(self):
        self.assertEqual(self.try_all({1: None}), (None, [1], ""))

    def test_what_fails_in_both_fails(self):
        self.assertEqual(self.try_all({1: 1, 2: 3}), (3, [1, 2], ""))
        self.assertEqual(self.try_all({1: 1, 2: None}), (None, [1, 2], ""))

    def test_a_course_that_is_asked_for_is_the_only_one(self):
        self.assertEqual(self.try_all({7: 1}, CANSYNC_SEED="7"), (1, [7], ""))


if __name__ == "__main__":
    unittest.main()

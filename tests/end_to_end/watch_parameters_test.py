"""Parameters in `watch`: read in turn beside the actual values, as processes and on a terminal."""

import os
import re
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "pictures"))
from terminal import KIND, Terminal

from gateway import CANSYNC, LONG, end, wait_for
from names_test import SPEED_LIMIT, TORQUE_OFFSET, Named
from verb_case import ALWAYS_BUSY, BUSY, BUSY_REPLIES, DEVICE_TYPE, NOT_AVAILABLE


class Parameters(Named):
    EXTRA = "[process]\npoll_without_reference = true\n"

    def test_a_name_has_its_unit_and_a_number_is_raw(self):
        self.run_verb("write", 1, "speed-limit", 150000)
        self.run_verb("write", 1, "torque-offset", "-12.3")
        heading, row = self.text("watch", "winder", "--parameter", f"speed-limit,{TORQUE_OFFSET}", "--parameter",
                                 "fault-code", "--count", 1).splitlines()
        self.assertRegex(heading, r"AGE ms +READ ms .* speed-limit +PARAMETER 403 +fault-code$")
        self.assertRegex(row, r" 150000 inc/s +-123 +0: none$")
        row = self.text("watch", 1, "--parameter", "torque-offset", "--raw", "--count", 1).splitlines()[1]
        self.assertRegex(row, r" -123$")

    def test_as_objects(self):
        self.run_verb("write", 0, "torque-offset", 5)
        first, *_, last = self.json("watch", 0, "--parameter", f"torque-offset,{DEVICE_TYPE}", "--interval", 20, "--count", 5)
        found = {one["parameter"]: one for one in first["parameters"]}
        offset = found["torque-offset"]
        self.assertEqual([offset[key] for key in ("number", "raw", "format", "scaled", "unit", "result")],
                         [TORQUE_OFFSET, 50, "word", 5.0, "%", "done"])
        self.assertEqual((found["100"]["raw"], found["100"]["unit"]), (4400, ""))
        self.assertLess(offset["age_ms"], 1000 * LONG)
        refused = self.one("watch", 2, "--parameter", NOT_AVAILABLE, "--count", 1)["parameters"][0]
        self.assertEqual((refused["raw"], refused["age_ms"], refused["result"]), (None, None, "slave_error"))
        self.assertGreater(last["parameters"][0]["read_time_ns"], offset["read_time_ns"], "it is read again")
        self.assertEqual(self.one("watch", 0, "--count", 1)["parameters"], [])

    def test_what_cannot_be_read_is_said_once(self):
        result = self.run_verb("watch", 2, "--parameter", f"{NOT_AVAILABLE},100", "--interval", 20, "--count", 5)
        self.assertEqual(result.stderr.count("slave 2, parameter 420: "), 1, result.stderr)
        self.assertRegex(result.stdout.decode().splitlines()[-1], r" - +4400$")

    def test_names_need_a_profile_that_knows_them(self):
        self.assertIn("slave 2 'slave2' has no profile", self.fails("watch", "0,2", "--parameter", "lag", code=1))
        self.assertIn("has no parameter 'lagg'; allowed: 0..4095 or a name",
                      self.fails("watch", 0, "--parameter", "lagg", code=2))
        # Of all slaves it is shown where it is known.
        rows = self.text("watch", "--parameter", "device-type", "--count", 1).splitlines()[1:]
        self.assertEqual([row.split()[-1] for row in rows], ["4400", "4400", "-", "-"])
        self.assertIn("lagg", self.fails("watch", "--parameter", "device-type,lagg", "--count", 1, code=2))
        for typed, told in (("4096", "found '4096'"), ("100,", "found '100,'"), ("1,2,3,4,5,6,7,8,9", "found 9 parameters")):
            self.assertIn(told, self.fails("watch", "--parameter", typed, code=2))

    def test_one_read_at_a_time_and_none_after_ctrl_c(self):
        self.run_verb("write", 3, BUSY_REPLIES, ALWAYS_BUSY)
        self.addCleanup(self.run_verb, "write", 3, BUSY_REPLIES, 0)
        process = self.gateway.start_job("open_parameter_jobs", "watch", "3,0-2", "--parameter", f"{BUSY},100,301",
                                         "--timeout", 3000, "--plain", "--interval", 20)
        self.addCleanup(end, process)  # the busy read would hold up the write of the other clean-up

        def busy_read_is_the_only_one():
            return ["410" in job["text"] for job in self.json("jobs")] == [True]

        # The reads of the other slaves come before it: the job that was open may have been one of them.
        wait_for("the busy read is open", busy_read_is_the_only_one)
        self.assertEqual(self.one("status")["open_parameter_jobs"], 1)
        self.interrupt(process, code=0)
        self.gateway.wait_status("no job is open", lambda status: status["open_parameter_jobs"] == 0)


class Screen(Named):
    EXTRA = "[process]\npoll_without_reference = true\n"

    def test_parameters_stand_before_the_values(self):
        self.run_verb("write", 0, "speed-limit", 150000)
        environment = dict(self.gateway.environment, TERM=KIND, LC_ALL="C.UTF-8")
        arguments = ["watch", "0-1", "--interval", "50", "--parameter", f"speed-limit,{BUSY},{DEVICE_TYPE}"]
        with Terminal([CANSYNC, *arguments], environment, 160, 32) as terminal:
            def shows(*patterns):
                return terminal.wait(patterns, lambda text: all(re.search(pattern, text) for pattern in patterns))

            shows("READ ms", "speed-limit inc/s", "parameter 100", r"0  slave0 .* 150000 .* 410 .* 4400 ")
            self.run_verb("write", 0, SPEED_LIMIT, 160000)
            shows(r"0  slave0 .* 160000 ")
            terminal.press("r")
            shows("speed-limit raw")
            terminal.press("right", "v")
            shows(f"sorted by parameter {BUSY}")
            terminal.press("q")
            self.assertEqual(terminal.end(), 0)


if __name__ == "__main__":
    unittest.main()

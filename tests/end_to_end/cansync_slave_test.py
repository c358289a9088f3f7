"""The daemon as a slave: beside a simulated master, and the verb `references`."""

import json
import os
import re
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "manual"))
from help_text import help_of

from json_schemas import expect
from gateway import CANSYNC, CANSYNCD, LONG, metrics, wait_for
from verb_case import DaemonTest

CONFIG = """
[bus]
protocol = "cansync-slave"
name = "{bus}"
bit_rate = 125000
[dds]
domain = {domain}
[slave]
number = 5
lock_time_ms = 50
[metrics]
file = "line.prom"
period_s = 1
"""


class SlaveRole(DaemonTest):
    CONFIG = CONFIG

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.metrics = os.path.join(cls.folder, "line.prom")
        wait_for("the master gives reference values", lambda: cls.place.run("slave", "references").returncode == 0)

    def test_a_file_that_is_not_taken_is_told(self):
        self.reload_something_wrong()
        wait_for("it is told", lambda: "reload_refused" in [event["code"] for event in self.json("events")])

    def test_status_and_events_tell_of_the_slave(self):
        status = wait_for("it is synchronized", lambda: (s := self.one("status"))["synchronized"] and s)
        expect(["status"], status)
        self.assertEqual((status["protocol"], status["slave_number"]), ("cansync-slave", 5))
        self.assertEqual((status["option_status"], status["status_word"]), (0x20, 0x8000))
        self.assertGreater(status["answers_sent"], 0)
        text = self.place.run("status").stdout.decode()
        self.assertRegex(text, r"(?m)^slave +5, .*; synchronized; status word 0x8000$")
        events = [json.loads(line) for line in self.place.run("events", "--json").stdout.splitlines()]
        self.assertLessEqual({"state_changed", "sync_locked", "slave_synchronized"}, {event["code"] for event in events})
        self.assertEqual({event["slave"] for event in events if event["code"] == "slave_synchronized"}, {5})
        self.assertEqual(self.place.run("wait", "error-active", "--timeout", LONG).returncode, 0)

    def test_reference_values_are_those_of_the_master(self):
        found = self.one("slave", "references")
        expect(["slave", "references"], found)
        self.assertEqual((found["raw"][1], found["ever"] & 1), (1000, 1))
        with self.place.start("slave", "references", "--follow", "--json") as running:
            ramp = []
            while len(ramp) < 5:
                one = running.next_object()
                if one["telegram"] == 1:
                    ramp.append((one["interval"], one["raw"][0]))
        # The simulated master's value 0 rises by one an interval; what a slow reader misses is missing in both.
        self.assertEqual({value - interval for interval, value in ramp}, {ramp[0][1] - ramp[0][0]})

    def released_for_a_second(self):
        """The status before and after `actual`, and what that told; None where a machine that stood still lost samples."""
        before = self.one("status")
        found = self.one("slave", "actual", "0=1000", "4=7", "--rate", 10, "--seconds", 1)
        expect(["slave", "actual"], found)
        self.assertEqual((found["result"], found["wait_intervals"]), ("done", 38))
        ended = self.one("status")["interval"]
        after = wait_for("a later status", lambda: (s := self.one("status"))["interval"] > ended and s)
        counted = [after["released"][telegram] - before["released"][telegram] for telegram in range(2)]
        return (before, after) if counted == 2 * [found["samples"]] else None

    def test_actual_values_go_out_when_they_are_released(self):
        wait_for("it is synchronized", lambda: self.one("status")["synchronized"])
        before, after = wait_for("all that was written is released", self.released_for_a_second)
        for telegram in range(2):
            sent = after["actual_sent"][telegram] - before["actual_sent"][telegram]
            late = after["actual_late"][telegram] - before["actual_late"][telegram]
            self.assertLessEqual(sent, after["released"][telegram] - before["released"][telegram])
            self.assertGreater(sent + late, 0)
        codes = [json.loads(line)["code"] for line in self.place.run("events", "--json").stdout.splitlines()]
        self.assertIn("actual_writer_began", codes)
        self.assertIn("actual_writer_lost", codes)
        self.assertEqual(self.place.run("slave", "actual", "8=1").returncode, 2)

    def test_the_metrics_are_those_of_the_status(self):
        wait_for("the file tells of the lock", lambda: metrics(self.metrics).get("cansync_slave_side_synchronized") == 1)
        before = self.one("status")
        interval = "cansync_interval"
        told = wait_for("the file is newer", lambda: (now := metrics(self.metrics))[interval] > before["interval"] and now)
        after = wait_for("the status is not older", lambda: (s := self.one("status"))["interval"] >= told[interval] and s)
        self.assertEqual(told["cansync_slave_side_number"], 5)
        self.assertEqual(told["cansync_slave_side_status_word"], 0x8000)
        self.assertEqual(told['cansync_slave_side_fault{state="none"}'], 1)
        asked = told['cansync_slave_side_actual_asked_total{telegram="1"}']
        self.assertTrue(before["asked"][0] <= asked <= after["asked"][0], (before["asked"], asked, after["asked"]))

    def test_the_doctor_says_how_near_the_answers_came_to_the_ends_of_their_slots(self):
        with self.place.start("slave", "actual", "0=77", "--rate", 100) as releasing:
            wait_for("actual values go out", lambda: self.one("status")["actual_sent"][0] > 10)
            releasing.terminate()
        lines = self.place.run("doctor", "--json").stdout.splitlines()
        found = next(one for one in map(json.loads, lines) if one["topic"] == "answers in time")
        self.assertRegex(found["found"], r"^least time left to an actual value telegram -?[0-9.]+ us; longest way from request to "
                                         r"answer [0-9.]+ us; too late and left out: \d+ actual value telegrams, \d+ responses$")
        late = re.findall(r"(\d+) (?:actual value telegrams|responses)", found["found"])
        self.assertEqual(found["level"], "ok" if late == ["0", "0"] else "warning", found)
        self.assertEqual(found["remedy"] is None, found["level"] == "ok")

    def test_the_table_is_explained(self):
        lines = self.place.run("slave", "references", "--count", 2).stdout.decode().splitlines()
        self.assertEqual(len(lines), 3)
        self.assertEqual(re.split("  *", lines[0].strip()), list(help_of(CANSYNC, "slave references").explained("Columns")))

    def test_verbs_of_another_protocol_say_so(self):
        result = self.place.run("slaves", "--timeout", 1)
        self.assertEqual(result.returncode, 6, result.stderr)
        self.assertIn("is served as cansync-slave; `slaves` needs cansync-master", result.stderr)

    def test_the_configuration_is_checked(self):
        result = subprocess.run([CANSYNCD, "--check", self.config], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("slave 5 at 125000 bit/s", result.stdout)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *filter(None, sys.argv[1:])])

"""General frames: the daemon with simulated nodes, and the verbs `frames` and `send`."""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "manual"))
from help_text import helps

from json_schemas import expect
from gateway import CANSYNC, CANSYNCD, LONG, Place, end, wait_for

CONFIG = """
[bus]
protocol = "layer2"
name = "{bus}"
[dds]
domain = {domain}
[send]
timeout_ms = 30000
[[receive]]
number = 0
first = 0x100
last = 0x1FF
[[receive]]
number = 5
extended = true
[[node]]
number = 0
identifier = 0x123
data = [1, 2, 0xFF]
[[node]]
number = 1
identifier = 0x18DAF110
extended = true
data = [0, 7]
period_ms = 20
[[node]]
number = 2
identifier = 0x250
data = [0]
period_ms = 20
[[timer]]
number = 3
identifier = 0x80
period_us = 20000
[script]
power_on = ["// nothing yet", "Send 0x700 1 0"]
"""


class Frames(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.place = Place()
        folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        cls.config = os.path.join(folder, "bus.toml")
        cls.log = os.path.join(folder, "log")
        with open(cls.config, "w", encoding="utf-8") as file:
            file.write(CONFIG.format(bus=cls.place.bus, domain=cls.place.domain))
        with open(cls.log, "wb") as log:
            cls.daemon = subprocess.Popen([CANSYNCD, cls.config], stdout=log, stderr=log)
        cls.addClassCleanup(lambda: end(cls.daemon))
        wait_for("a frame is sent", lambda: cls.place.run("send", "0x100").returncode == 0)

    def one(self, *arguments, code=0):
        """The only object of a verb."""
        result = self.place.run(*arguments, "--json")
        self.assertEqual(result.returncode, code, result.stderr)
        lines = result.stdout.splitlines()
        self.assertEqual(len(lines), 1, lines)
        return json.loads(lines[0])

    def test_frames_of_every_kind_are_sent(self):
        sent = self.one("send", "0x123", "0102FF")
        self.assertEqual((sent["result"], sent["data"], sent["extended"]), ("done", [1, 2, 255], False))
        self.assertGreater(sent["sent_time_ns"], 0)
        self.assertEqual(self.one("send", "0x1FFFFFFF", "00", "--extended")["result"], "done")
        self.assertEqual(self.one("send", "0x123", "--remote", "--length", "3")["length"], 3)
        self.assertEqual(self.one("send", "00000005", "--remote", "--extended")["identifier"], 5)
        self.assertEqual(self.one("send", "7fF", "00")["identifier"], 0x7FF)
        self.assertIn("frame 123 sent", self.place.run("send", "0x123", "01 02").stderr)

    def test_what_is_wrong_is_told(self):
        for arguments, words in ((("send", "0x800"), "ID: found"), (("send", "800"), "allowed: 3 hexadecimal digits, 000..7FF"),
                                 (("send", "5"), "ID: found '5'"), (("send", "0x"), "ID: found"), (("send", "12G"), "ID: found"),
                                 (("send", "0123"), "29 bits: --extended"), (("send", "123", "--extended"), "8 hexadecimal digits"),
                                 (("send", "20000000", "--extended"), "00000000..1FFFFFFF"),
                                 (("send", "0x1", "0"), "DATA: found '0'"), (("send", "001", "1 2"), "DATA: found '1 2'"), (("send", "001", "00" * 9), "DATA: found"),
                                 (("send", "001", "00", "--remote"), "DATA: not with --remote"),
                                 (("frames", "--count", "0"), "--count"), (("can", "fly"), "ACTION: found 'fly'"),
                                 (("can", "run", "1"), "NUMBER: only with"), (("can", "start-timer", "17"), "NUMBER")):
            result = self.place.run(*arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(words, result.stderr)

    def test_status_and_events_find_the_daemon(self):
        self.assertEqual(self.one("send", "0x123", "00")["result"], "done")
        status = wait_for("the frame is counted", lambda: (s := self.one("status"))["sent"] and s)
        expect(["status"], status)
        self.assertEqual((status["bus"], status["protocol"]), (self.place.bus, "layer2"))
        self.assertEqual((status["process"], status["bit_rate"]), (self.daemon.pid, 500000))
        self.assertEqual((status["controller_state"], status["timestamp_source"]), ("error-active", "simulation"))
        text = self.place.run("status").stdout.decode()
        self.assertRegex(text, r"(?m)^frames sent +[1-9]")
        events = [json.loads(line) for line in self.place.run("events", "--json").stdout.splitlines()]
        self.assertIn("send_frame", {event.get("action") for event in events})
        self.assertEqual(self.place.run("wait", "error-active", "--timeout", LONG).returncode, 0)
        found = [json.loads(line) for line in self.place.run("doctor", "--json").stdout.splitlines()]
        self.assertIn("layer2", next(one for one in found if one["topic"] == "daemon")["found"])

    def timer(self):
        return self.one("timers")

    def test_a_timer_is_started_and_stopped(self):
        self.assertEqual((self.timer()["number"], self.timer()["identifier"], self.timer()["period_us"]), (3, 0x80, 20000))
        started = self.one("can", "start-timer", "3")
        self.assertEqual((started["action"], started["number"], started["result"]), ("start-timer", 3, "done"))
        expect(["can"], started)
        running = wait_for("it sends", lambda: (t := self.timer())["running"] and t["sent"] > 2 and t)
        expect(["timers"], running)
        self.assertEqual(self.one("can", "stop-timer", "3")["result"], "done")
        wait_for("it is stopped", lambda: not self.timer()["running"])
        self.assertEqual(self.one("can", "start-timer", "4", code=3)["cause"], "field")
        lines = self.place.run("timers").stdout.decode().splitlines()
        self.assertEqual(re.split("  +", lines[0].strip()), list(helps(CANSYNC)["timers"].explained("Columns")))

    def test_in_stop_nothing_is_sent(self):
        self.assertEqual(self.one("can", "stop")["result"], "done")
        try:
            self.assertEqual(self.one("send", "100", code=3)["cause"], "wrong_state")
            wait_for("the status says so", lambda: not self.one("status")["running"])
        finally:
            self.assertEqual(self.one("can", "run")["result"], "done")
        self.assertEqual(self.one("send", "100", "--high")["result"], "done")
        self.assertEqual(self.one("send", "100", "--by-id")["result"], "done")
        for action in ("clear-queues", "reset-overflow", "reset-controller"):
            self.assertEqual(self.one("can", action)["result"], "done")
        status = wait_for("it runs", lambda: (s := self.one("status"))["running"] and s)
        self.assertEqual(status["status_word"] & 0xFF95, 0x4111)  # runs, everything empty and well
        self.assertEqual(status["status_image"][:6], "410011")
        self.assertEqual((status["send_depth"], status["send_high_depth"]), (400, 20))

    def test_verbs_of_another_protocol_say_so(self):
        for verb in (("slaves",), ("read", "0", "301"), ("watch", "--count", "1")):
            result = self.place.run(*verb, "--timeout", 1)
            self.assertEqual(result.returncode, 6, result.stderr)
            self.assertIn("it speaks layer2 on this bus", result.stderr)

    def test_the_ranges_say_which_frames_come(self):
        with self.place.start("frames", "--json", "--count", 3) as frames:
            found = [frames.next_object() for _ in range(3)]
        for frame in found:
            self.assertEqual((frame["identifier"], frame["extended"], frame["range"]), (0x18DAF110, True, 1))
        counters = [frame["data"][0] for frame in found]
        self.assertEqual(counters, [(counters[0] + i) % 256 for i in range(3)])
        self.assertEqual(sorted(frame["time_ns"] for frame in found), [frame["time_ns"] for frame in found])

    def test_a_remote_frame_brings_the_data(self):
        with self.place.start("frames", "--json") as frames:
            frames.next_object()  # it is listening
            self.assertEqual(self.one("send", "0x123", "--remote", "--length", "3")["result"], "done")
            answer = wait_for("the answer", lambda: (f := frames.next_object())["identifier"] == 0x123 and f)
            self.assertEqual((answer["data"], answer["remote"], answer["range"]), ([1, 2, 255], False, 0))
            frames.send_signal(signal.SIGINT)

    def test_the_table_is_explained(self):
        lines = self.place.run("frames", "--count", 2).stdout.decode().splitlines()
        self.assertEqual(len(lines), 3)
        self.assertEqual(re.split("  *", lines[0].strip()), list(helps(CANSYNC)["frames"].explained("Columns")))
        self.assertRegex(lines[1], r"^\d{4}-\d\d-\d\d [\d:.]+ +18DAF110 +2 +[0-9A-F]{2} 07 +1$")

    def test_the_configuration_is_checked(self):
        result = subprocess.run([CANSYNCD, "--check", self.config], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("general frames at 500000 bit/s, 2 ranges received", result.stdout)
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write('[bus]\nprotocol = "layer2"\n[[slave]]\nnumber = 1\n')
            file.flush()
            result = subprocess.run([CANSYNCD, "--check", file.name], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(result.returncode, 78)
        self.assertIn(":3:", result.stderr)

    def test_without_a_daemon_it_says_where_it_looked(self):
        result = self.place.run("--bus", "nobody", "--timeout", 1, "send", "001")
        self.assertEqual(result.returncode, 6)
        self.assertIn('bus.protocol = "layer2"', result.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *filter(None, sys.argv[1:])])

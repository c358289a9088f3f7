"""General frames: the daemon with simulated nodes, and the verbs of `can`."""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "manual"))
from help_text import help_of

from json_schemas import expect
from gateway import CANSYNC, CANSYNCD, LONG, Place, end, metrics, wait_for
from verb_case import DaemonTest
from secured_case import SecuredCase

CONFIG = """
[bus]
protocol = "layer2"
name = "{bus}"
[dds]
domain = {domain}
[metrics]
file = "line.prom"
period_s = 1
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
[[mapped]]
number = 0
identifier = 0x480
output = true
size = 8
[mapping]
identifier = 0x490
mask = 0x7FF
on_change = true
[script]
power_on = ["// nothing yet", "Send 0x700 1 0"]
"""


class Frames(DaemonTest):
    CONFIG = CONFIG

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        wait_for("a frame is sent", lambda: cls.place.run("can", "send", "100#").returncode == 0)

    def test_frames_of_every_kind_are_sent(self):
        sent = self.one("can", "send", "123#0102FF")
        self.assertEqual((sent["result"], sent["data"], sent["extended"]), ("done", [1, 2, 255], False))
        self.assertGreater(sent["sent_time_ns"], 0)
        self.assertEqual(self.one("can", "send", "1FFFFFFF#00")["result"], "done")
        self.assertEqual(self.one("can", "send", "123#R3")["length"], 3)
        self.assertEqual(self.one("can", "send", "00000005#R")["identifier"], 5)
        self.assertEqual(self.one("can", "send", "7fF#00")["identifier"], 0x7FF)
        self.assertIn("frame 123 sent", self.place.run("can", "send", "123#01.02").stderr)

    def test_what_is_wrong_is_told(self):
        for arguments, words in ((("can", "send", "800#"), "identifier 800 is over 7FF"), (("can", "send", "0x1#"), "FRAME: found '0x1#', expected an identifier of 3"),
                                 (("can", "send", "123"), "expected '#'"), (("can", "send", "20000000#"), "which is an error frame"),
                                 (("can", "send", "001#0"), "second hexadecimal digit"), (("can", "send", "001#0.1"), "FRAME: found '001#0.1'"),
                                 (("can", "send", "001#" + "00" * 9), "more than 8 data bytes"), (("can", "send", "001##100"), "CAN FD"), (("can", "send"), "FRAME is required"),
                                 (("can", "send", "001#", "--every", "0"), "--every: found '0'"), (("can", "send", "001#", "--count", "0"), "--count"),
                                 (("can", "dump", "--count", "0"), "--count"), (("can", "dump", "--id", "123,4"), "--id: found '4'"),
                                 (("can", "dump", "--id", "1FF-100"), "--id: found '1FF-100'"), (("can", "dump", "--id", "100-00000200"), "--id: found"),
                                 (("can", "dump", "--kind", "error"), "--kind: found 'error'"), (("can", "dump", "--candump", "--json"), "found more than one"),
                                 (("can", "dump", "--only-interface", "can0"), "found without FILE"), (("can", "script", "fly", "x"), "ACTION: found 'fly'"),
                                 (("can", "fly"), "ACTION: found 'fly'"), (("can",), "ACTION: found nothing"),
                                 (("can", "run", "1"), "NUMBER: only with"), (("can", "start-timer", "17"), "NUMBER")):
            result = self.place.run(*arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(words, result.stderr)

    def test_status_and_events_find_the_daemon(self):
        self.assertEqual(self.one("can", "send", "123#00")["result"], "done")
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

    def test_the_metrics_are_those_of_the_status(self):
        path = os.path.join(os.path.dirname(self.config), "line.prom")
        before = self.one("status")
        self.assertEqual(self.one("can", "send", "123#00")["result"], "done")
        told = wait_for("the frame is counted", lambda: (now := metrics(path)).get("cansync_layer2_frames_sent_total", -1) > before["sent"] and now)
        after = wait_for("the status is not older", lambda: (s := self.one("status"))["sent"] >= told["cansync_layer2_frames_sent_total"] and s)
        received = told["cansync_layer2_frames_received_total"]
        self.assertTrue(before["received"] <= received <= after["received"], (before["received"], received, after["received"]))
        self.assertEqual(told['cansync_layer2_queue_depth{queue="send"}'], before["send_depth"])
        self.assertEqual((told["cansync_bit_rate_bits_per_second"], told["cansync_layer2_running"]), (500000, 1))

    def timer(self):
        return self.one("can", "timers")

    def test_a_timer_is_started_and_stopped(self):
        self.assertEqual((self.timer()["number"], self.timer()["identifier"], self.timer()["period_us"]), (3, 0x80, 20000))
        started = self.one("can", "start-timer", "3")
        self.assertEqual((started["action"], started["number"], started["result"]), ("start-timer", 3, "done"))
        expect(["can"], started)
        running = wait_for("it sends", lambda: (t := self.timer())["running"] and t["sent"] > 2 and t)
        expect(["can", "timers"], running)
        self.assertEqual(self.one("can", "stop-timer", "3")["result"], "done")
        wait_for("it is stopped", lambda: not self.timer()["running"])
        self.assertEqual(self.one("can", "start-timer", "4", code=3)["cause"], "field")
        lines = self.place.run("can", "timers").stdout.decode().splitlines()
        self.assertEqual(re.split("  +", lines[0].strip()), list(help_of(CANSYNC, "can timers").explained("Columns")))

    def test_many_frames_are_sent_by_one_call(self):
        before = self.one("status")["sent"]
        lines = self.place.run("can", "send", "150#01", "00000150#02", "--count", "3", "--every", "1", "--json").stdout.splitlines()
        found = [json.loads(line) for line in lines]
        self.assertEqual([(one["extended"], one["data"], one["result"]) for one in found], 3 * [(False, [1], "done"), (True, [2], "done")])
        times = [one["sent_time_ns"] for one in found]
        self.assertEqual(times, sorted(times))
        self.assertGreaterEqual(times[4] - times[0], 1000000, "two turns of 1 ms")
        self.assertIn("6 frames sent", self.place.run("can", "send", "150#01", "00000150#02", "--count", "3").stderr)
        wait_for("they are counted", lambda: self.one("status")["sent"] >= before + 12)
        with self.place.start("can", "send", "150#", "--every", "2", "--json") as endless:
            self.assertEqual([endless.next_object()["result"] for _ in range(3)], 3 * ["done"])
            endless.send_signal(signal.SIGINT)

    def test_the_queues_are_shown(self):
        lost = self.wait_well("no queue has overflowed", lambda status: not status["receive_overflowed"])["receive_overflows"]
        send, receive = self.json("can", "queues")
        self.assertEqual((send["queue"], send["room"], send["high_room"], send["lost"], send["not_published"]), ("send", 400, 20, 0, None))
        self.assertEqual((receive["queue"], receive["not_published"]), ("receive", 0))
        self.assertEqual(receive["overflowed"], receive["lost"] != lost, "nothing was lost since")
        lines = self.place.run("can", "queues").stdout.decode().splitlines()
        self.assertEqual(re.split("  +", lines[0].strip()), list(help_of(CANSYNC, "can queues").explained("Columns")))
        self.assertRegex(lines[1], r"^send +\d+ +400 +\d+ +20 +no +0 +-$")

    def script(self, action, text, *options, code=0):
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
            file.write(text)
            file.flush()
            result = self.place.run("can", "script", action, file.name, *options)
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stderr if "--json" not in options else [json.loads(line) for line in result.stdout.splitlines()]

    def test_a_script_is_checked_and_run(self):
        good = "// a comment\nSend 0x150 2 1 0x2\nFetch 0x123\nStart 3\nWait 1\nStop 3\n"
        self.assertIn("5 commands, no errors", self.script("check", good))
        self.assertRegex(self.script("check", "Stop 3\nSend 80 1 1\n", code=1), r":2:6: .*80")
        self.assertEqual(self.script("check", "Send 80 1 1\n", "--numbers", "decimal", "--json")[0]["problems"], [])
        problem, = self.script("check", "Wait 1\n  Jump 3\n", "--json", code=1)[0]["problems"]
        self.assertEqual((problem["line"], problem["column"]), (2, 3))
        self.assertIn("nothing was sent", self.script("run", "Send\n", code=2))
        done = self.script("run", good, "--json")
        self.assertEqual([(one["command"], one["kind"], one["timer"]) for one in done], [(1, "send", 0), (2, "fetch", 0), (3, "start", 3), (5, "stop", 3)])
        self.assertEqual((done[0]["frame"]["data"], {one["result"] for one in done}), ([1, 2], {"done"}))
        self.assertEqual(self.script("run", "Stop 3\nStart 4\nStop 3\n", "--json", code=3)[-1]["cause"], "field")

    def test_frames_are_chosen_and_kept_as_logs_and_captures(self):
        only = json.loads(self.place.run("can", "dump", "--id", "123,18DAF100:1FFFFF00", "--kind", "data", "--count", 1, "--json").stdout)
        self.assertEqual(only["identifier"], 0x18DAF110)
        log = self.place.run("can", "dump", "--candump", "--count", 2).stdout.decode().splitlines()
        self.assertRegex(log[1], r"^\(\d{10}\.\d{6}\) test[\w-]+ 18DAF110#[0-9A-F]{2}07$")
        self.assertEqual(len(log), 2)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bus.pcapng")
            result = self.place.run("can", "dump", "--write", path, "--count", 3)
            self.assertEqual((result.returncode, result.stdout), (0, b""))
            self.assertIn("3 frames written to " + path, result.stderr)
            read = subprocess.run([CANSYNC, "trace", path, "--candump"], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(len(re.findall(r" 18DAF110#[0-9A-F]{2}07\n", read.stdout)), 3, read.stdout + read.stderr)
        coloured = self.place.run("can", "dump", "--count", 2, "--color", "always").stdout.decode().splitlines()
        self.assertRegex(coloured[2], r" \x1b\[33m[0-9A-F]{2}\x1b\[0m 07$")  # the counter has changed

    def test_frames_are_named_by_a_dbc_file(self):
        with tempfile.NamedTemporaryFile("w", suffix=".dbc", encoding="latin-1") as file:
            file.write(f'BO_ {0x18DAF110 | 1 << 31} Engine: 2 ECU\n SG_ Counter : 0|8@1+ (1,0) [0|255] "" X\n'
                       ' SG_ Oil : 8|8@1+ (0.5,-40) [0|0] "\u00b0C" X\nVAL_ 2564485392 Oil 7 "cold" ;\n')
            file.flush()
            lines = self.place.run("can", "dump", "--count", 1, "--dbc", file.name).stdout.decode().splitlines()
            found = json.loads(self.place.run("can", "dump", "--count", 1, "--dbc", file.name, "--json").stdout)
        self.assertEqual(re.split("  *", lines[0].strip()), list(help_of(CANSYNC, "can dump").explained("Columns")))
        self.assertRegex(lines[1], r" ([0-9A-F]{2}) 07 +Engine: Counter \d+, Oil -36.5 \u00b0C \(cold\)$")
        self.assertEqual((found["message"], found["signals"][1]), ("Engine", {"name": "Oil", "raw": 7, "value": -36.5, "unit": "\u00b0C", "word": "cold"}))
        with tempfile.NamedTemporaryFile("w", suffix=".dbc") as file:
            file.write("BO_ 1 A: 8 X\n SG_ S 0|8\n")
            file.flush()
            in_part = self.place.run("can", "dump", "--count", 1, "--dbc", file.name)
            file.truncate(0)
            none = self.place.run("can", "dump", "--dbc", file.name)
        self.assertEqual(in_part.returncode, 11)
        self.assertIn(f"{file.name}:2:8: found '0'; allowed: ':'; the signal is left out", in_part.stderr)
        self.assertEqual(none.returncode, 2)
        self.assertIn(file.name, none.stderr)

    def test_frames_are_named_by_a_table_of_signals(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write('[[message]]\nname = "Engine"\nidentifier = 0x18DAF110\nextended = true\nlength = 2\n[[signal]]\nmessage = "Engine"\n'
                       'name = "Oil"\nstart = 8\nlength = 8\nfactor = 0.5\noffset = -40\nunit = "\u00b0C"\nvalues = ["7 cold"]\n')
            file.flush()
            found = json.loads(self.place.run("can", "dump", "--count", 1, "--signals", file.name, "--json").stdout)
            file.truncate(0)
            wrong = self.place.run("can", "dump", "--signals", file.name)
        self.assertEqual((found["message"], found["signals"]), ("Engine", [{"name": "Oil", "raw": 7, "value": -36.5, "unit": "\u00b0C", "word": "cold"}]))
        self.assertEqual(wrong.returncode, 2)
        self.assertIn(file.name, wrong.stderr)

    def test_message_objects_at_the_terminal(self):
        self.assertEqual(self.one("can", "objects", "configure", "3", "201", "--transmit", "--timeout-ms", "60000")["result"], "done")
        self.assertEqual(self.one("can", "objects", "configure", "4", "250/7F0", "--tell")["result"], "done")
        sent = self.one("can", "objects", "send", "3", "210#0102")
        self.assertEqual((sent["result"], sent["frame"], sent["number"]), ("done", "210#0102", 3))
        expect(["can", "objects"], sent)
        self.assertIsNone(self.one("can", "objects", "read", "4", "--release")["frame"])
        read = wait_for("a frame", lambda: (r := self.one("can", "objects", "read", "4", "--release"))["frame"] and r)
        self.assertRegex(read["frame"], "^250#[0-9A-F]{2}$")
        expect(["can", "objects"], read)
        self.assertEqual(self.one("can", "objects", "send", "3", "201#", "--every-time")["result"], "done")
        told = lambda: {one["number"]: one for one in map(json.loads, self.place.run("can", "objects", "--json").stdout.splitlines())}
        objects = wait_for("both are told", lambda: (found := told()).keys() >= {3, 4} and found)
        for one in objects.values():
            expect(["can", "objects"], one)
        self.assertEqual((objects[3]["state"], objects[3]["timeout_ms"], objects[4]["mask"]), ("held", 60000, 0x7F0))
        self.assertEqual(self.one("can", "objects", "abort", "3")["result"], "done")
        self.assertEqual(self.one("can", "objects", "send", "4", "250#", code=3)["cause"], "wrong_state")
        for arguments, words in ((("fly", "1"), "ACTION: found 'fly'"), (("send", "1"), "WHAT: missing"), (("read", "32"), "NUMBER"),
                                 (("abort", "1", "100#"), "WHAT: not with abort"), (("read", "1", "--transmit"), "only with configure"),
                                 (("configure", "1", "20"), "FRAME: found"), (("configure", "1", "201/7FF", "--transmit"), "a mask only")):
            result = self.place.run("can", "objects", *arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(words, result.stderr)
        lines = self.place.run("can", "objects").stdout.decode().splitlines()
        self.assertEqual(re.split("  +", lines[0].strip()), list(help_of(CANSYNC, "can objects").explained("Columns")))

    def test_the_process_image_at_the_terminal(self):
        self.assertEqual(self.one("can", "image", "write", "4", "0102", "FF")["result"], "done")
        image = wait_for("the bytes", lambda: (i := self.one("can", "image"))["outputs"].startswith("000000000102FF") and i)
        expect(["can", "image"], image)
        self.assertTrue(image["sending"])
        with self.place.start("can", "image", "write", "0", "AB" * 1024, "--hold", "--json") as holder:
            held = wait_for("it is held", lambda: (i := self.one("can", "image"))["writer"] and i)
            self.assertEqual(held["outputs"], "AB" * 1024)
            self.assertEqual(self.one("can", "image", "write", "0", "00", code=3)["cause"], "wrong_state")
            holder.send_signal(signal.SIGINT)
            written = holder.next_object()
        self.assertEqual(written["result"], "done")
        expect(["can", "image"], written)
        wait_for("what it gave is sent no more", lambda: not self.one("can", "image")["sending"])
        wait_for("it is given up", lambda: self.place.run("can", "image", "write", "0", "00").returncode == 0)
        with self.place.start("can", "image", "watch", "--count", "2", "--json") as watch:
            watch.next_object()
            self.assertEqual(self.one("can", "image", "write", "0", "77")["result"], "done")
            self.assertTrue(watch.next_object()["outputs"].startswith("77"))
        for arguments, words in ((("fly",), "ACTION: found 'fly'"), (("write", "1024", "00"), "ADDRESS"), (("write", "0"), "BYTES: missing"),
                                 (("write", "0", "0"), "BYTES: found '0'"), (("write", "1023", "0000"), "end after the image"), (("--hold",), "only with write"),
                                 (("write", "0", "00" * 65), "allowed: 64 at once, or more with --hold"), (("write", "0", "00", "--strength", "1"), "only with --hold")):
            result = self.place.run("can", "image", *arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(words, result.stderr)
        lines = self.place.run("can", "image").stdout.decode().splitlines()
        self.assertEqual(re.split("  +", lines[0].strip()), list(help_of(CANSYNC, "can image").explained("Columns")))

    def test_a_file_changes_the_configuration_that_runs(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write("[[timer]]\nnumber = 3\nidentifier = 0x80\nperiod_us = 20000\n[[timer]]\nnumber = 9\nidentifier = 0x700\n")
            file.flush()
            changed = self.one("can", "configure", file.name)
            expect(["can", "configure"], changed)
            self.assertEqual(changed["result"], "done")
            timers = wait_for("timer 9", lambda: [t for t in map(json.loads, self.place.run("can", "timers", "--json").stdout.splitlines()) if t["number"] == 9])
            self.assertEqual(timers[0]["identifier"], 0x700)
            file.write("[[timer]]\nnumber = 17\n")
            file.flush()
            refused = self.one("can", "configure", file.name, code=3)
        self.assertEqual((refused["result"], refused["cause"]), ("refused", "field"))
        self.assertRegex(refused["reason"], r"^data:9:10: timer\.number: found 17")
        self.assertEqual(self.place.run("can", "configure", "/nowhere").returncode, 1)
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:  # as it was, for the other tests
            file.write("[[timer]]\nnumber = 3\nidentifier = 0x80\nperiod_us = 20000\n")
            file.flush()
            self.assertEqual(self.one("can", "configure", file.name)["result"], "done")
        wait_for("timer 9 is gone", lambda: len(self.place.run("can", "timers", "--json").stdout.splitlines()) == 1)
        self.assertEqual(self.timer()["number"], 3)

    def test_a_program_can_be_followed(self):
        with self.place.start("can", "lead", "anybody", "--json") as lead:
            found = lead.next_object()
            expect(["can", "lead"], found)
            self.assertEqual(found, {"program": "", "running": True})  # this daemon follows nobody
            lead.send_signal(signal.SIGINT)

    def test_in_stop_nothing_is_sent(self):
        self.assertEqual(self.one("can", "stop")["result"], "done")
        try:
            self.assertEqual(self.one("can", "send", "100#", code=3)["cause"], "wrong_state")
            wait_for("the status says so", lambda: not self.one("status")["running"])
        finally:
            self.assertEqual(self.one("can", "run")["result"], "done")
        self.assertEqual(self.one("can", "send", "100#", "--high")["result"], "done")
        self.wait_well("it runs, and no fault lights the LED",
                       lambda status: status["running"] and (status["bus_fault"], status["receiving"]) == ("off", True))
        self.assertRegex(self.place.run("status").stdout.decode(), r"(?m)^module +in run; LED BF (off|overflow)$")
        self.assertEqual(self.one("can", "send", "100#", "--by-id")["result"], "done")
        for action in ("clear-queues", "reset-controller"):
            self.assertEqual(self.one("can", action)["result"], "done")
        status = self.wait_well("it runs, everything is empty and well", lambda status: status["status_word"] & 0xFF95 == 0x4111)
        self.assertEqual(status["status_image"][:6], "410011")
        self.assertEqual((status["send_depth"], status["send_high_depth"]), (400, 20))

    def wait_well(self, what, condition):
        """The status that fits; what a machine that stood still made overflow is forgotten until then."""
        def look():
            self.assertEqual(self.one("can", "reset-overflow")["result"], "done")
            status = self.one("status")
            return status if condition(status) else None

        return wait_for(what, look)

    def test_verbs_of_another_protocol_say_so(self):
        for verb in (("slaves",), ("read", "0", "301"), ("watch", "--count", "1")):
            result = self.place.run(*verb, "--timeout", 1)
            self.assertEqual(result.returncode, 6, result.stderr)
            self.assertIn(f"is served as layer2; `{verb[0]}` needs cansync-master", result.stderr)

    def test_the_ranges_say_which_frames_come(self):
        with self.place.start("can", "dump", "--json", "--count", 3) as frames:
            found = [frames.next_object() for _ in range(3)]
        for frame in found:
            self.assertEqual((frame["identifier"], frame["extended"], frame["range"]), (0x18DAF110, True, 1))
        counters = [frame["data"][0] for frame in found]
        self.assertEqual(counters, [(counters[0] + i) % 256 for i in range(3)])
        self.assertEqual(sorted(frame["time_ns"] for frame in found), [frame["time_ns"] for frame in found])

    def test_a_remote_frame_brings_the_data(self):
        with self.place.start("can", "dump", "--json") as frames:
            frames.next_object()  # it is listening
            self.assertEqual(self.one("can", "send", "123#R3")["result"], "done")
            answer = wait_for("the answer", lambda: (f := frames.next_object())["identifier"] == 0x123 and f)
            self.assertEqual((answer["data"], answer["remote"], answer["range"]), ([1, 2, 255], False, 0))
            frames.send_signal(signal.SIGINT)

    def test_the_table_is_explained(self):
        lines = self.place.run("can", "dump", "--count", 2).stdout.decode().splitlines()
        self.assertEqual(len(lines), 3)
        self.assertEqual(re.split("  *", lines[0].strip()), list(help_of(CANSYNC, "can dump").explained("Columns")))
        self.assertRegex(lines[1], r"^\d{4}-\d\d-\d\d [\d:.]+ +18DAF110 +2 +1 +[0-9A-F]{2} 07$")

    def test_the_configuration_is_checked(self):
        result = subprocess.run([CANSYNCD, "--check", self.config], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("general frames at 500000 bit/s, 2 ranges received", result.stdout)
        of_node = subprocess.run([CANSYNCD, "--check", self.config, "--set", "filter.node=5"], capture_output=True, text=True,
                                 timeout=LONG)
        self.assertIn("general frames at 500000 bit/s, frames of node 5 received", of_node.stdout)
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write('[bus]\nprotocol = "layer2"\n[[slave]]\nnumber = 1\n')
            file.flush()
            result = subprocess.run([CANSYNCD, "--check", file.name], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(result.returncode, 78)
        self.assertIn(":3:", result.stderr)

    def test_without_a_daemon_it_says_where_it_looked(self):
        result = self.place.run("--bus", "nobody", "--timeout", 1, "can", "send", "001#")
        self.assertEqual(result.returncode, 6)
        self.assertIn('bus.protocol = "layer2"', result.stderr)


class Anew(DaemonTest):
    CONFIG = CONFIG

    def test_who_leads_or_holds_hears_of_another_start_of_the_daemon(self):
        wait_for("a frame is sent", lambda: self.place.run("can", "send", "100#").returncode == 0)
        lead = self.place.start("can", "lead", "anybody")
        holder = self.place.start("can", "image", "write", "0", "AB", "--hold")
        self.addCleanup(lead.kill)
        self.addCleanup(holder.kill)
        wait_for("it is held", lambda: self.one("can", "image")["writer"])
        self.daemon.kill()
        self.daemon.wait(LONG)
        self.start()
        for process, words in ((lead, "it does not know that the module is to run"), (holder, "the image is not held any more")):
            _, said = process.communicate(timeout=LONG)
            self.assertEqual(process.returncode, 6, said)
            self.assertIn(f"the daemon was started anew: {words}".encode(), said)


class Secured(SecuredCase):
    CONFIG = CONFIG

    def test_each_does_what_its_role_may(self):
        self.become("viewer")
        self.assertTrue(json.loads(self.place.run("status", "--json").stdout)["secured"])
        self.expect_done("can", "dump", "--count", 1)
        self.expect_done("can", "timers")
        self.expect_no_right("SendRequest", "operator", "can", "send", "123#")
        self.expect_no_right("ImageOutputs", "operator", "can", "image", "write", 0, "01", "--hold")
        self.expect_no_right("ControlRequest", "engineer", "can", "stop")
        self.become("operator")
        self.expect_done("can", "send", "123#")
        self.expect_no_right("ControlRequest", "engineer", "can", "stop")
        self.expect_no_right("ObjectRequest", "engineer", "can", "objects", "configure", 3, "201", "--transmit")
        self.become("engineer")
        for arguments in (("send", "123#"), ("stop",), ("run",), ("objects", "configure", 3, "201", "--transmit")):
            self.expect_done("can", *arguments)
        self.become(None)
        self.assertEqual(self.place.run("--timeout", 1, "can", "send", "123#").returncode, 6)


class FullLoad(unittest.TestCase):
    """A bus that is never free; bench/frames.py has the same at 1 Mbit/s."""

    BIT_RATE = 125000
    LONGEST = 60  # bits of a frame without data, stuffed, and the pause behind it

    @classmethod
    def setUpClass(cls):
        cls.place = Place()
        config = cls.enterClassContext(tempfile.NamedTemporaryFile("w", suffix=".toml", encoding="utf-8"))
        config.write(f'[bus]\nprotocol = "layer2"\nname = "{cls.place.bus}"\nbit_rate = {cls.BIT_RATE}\n[dds]\ndomain = {cls.place.domain}\n')
        # A foreign frame every 20 ms or so; intervals are milliseconds.
        faults = cls.enterClassContext(tempfile.NamedTemporaryFile("w", suffix=".toml", encoding="utf-8"))
        faults.write('[[fault]]\nkind = "inject"\nframe = "7AB#"\nfrom = 10\nprobability = 0.05\n')
        faults.flush()
        config.write(f'[sim]\nfault_script = "{faults.name}"\n')
        config.write("".join(f"[[node]]\nnumber = {n}\nidentifier = {0x100 + n}\nperiod_ms = 1\n" for n in range(31)))
        config.flush()
        cls.daemon = subprocess.Popen([CANSYNCD, config.name], stderr=subprocess.DEVNULL)
        cls.addClassCleanup(lambda: end(cls.daemon))
        wait_for("the daemon runs", lambda: cls.place.run("status", "--json").returncode == 0)

    def test_faults_of_a_script_are_on_the_bus(self):
        found = json.loads(self.place.run("can", "dump", "--json", "--id", "7AB", "--count", 1).stdout)
        self.assertEqual((found["identifier"], found["length"]), (0x7AB, 0))

    def test_every_frame_comes_in_order_and_who_stops_reading_holds_up_nobody(self):
        longest = self.LONGEST * 10**9 // self.BIT_RATE
        with tempfile.TemporaryFile() as shown, self.place.start("can", "dump", "--candump", "--id", "100", stdout=shown) as stopped:
            wait_for("it listens", lambda: os.fstat(shown.fileno()).st_size)
            stopped.send_signal(signal.SIGSTOP)
            # The other one: nothing is missing on a bus that is never free.
            result = self.place.run("can", "dump", "--json", "--count", 5000)
            self.assertNotIn("missed", result.stderr)
            times = [json.loads(line)["time_ns"] for line in result.stdout.splitlines()]
            self.assertEqual(len(times), 5000)
            steps = [later - earlier for earlier, later in zip(times, times[1:])]
            self.assertGreater(min(steps), 0)
            self.assertLess(max(steps), longest)
            stopped.send_signal(signal.SIGCONT)
            missed = stopped.next_line(stopped.stderr).decode()
            stopped.terminate()
        self.assertRegex(missed, r"cansync: [1-9]\d* frames? (was|were) missed, for this program reads too slowly")
        queues = [json.loads(line) for line in self.place.run("can", "queues", "--json").stdout.splitlines()]
        self.assertEqual([(one["lost"], one["not_published"]) for one in queues], [(0, None), (0, 0)])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *filter(None, sys.argv[1:])])

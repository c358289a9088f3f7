"""Every verb of `cansync` once, with cansyncd and cansync-sim on a real CAN socket."""

import json
import os
import re
import signal
import tempfile

from canline import LONG, Candump, Line
from gateway import wait_for

PROFILE = os.path.join(os.path.dirname(__file__), "..", "..", "config", "profiles", "simulated-drive.toml")
DIFFERENT = 9  # exit code of diff and verify


class Verbs(Line):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.log = cls.enterClassContext(Candump())
        cls.folder = cls.enterClassContext(tempfile.TemporaryDirectory())

    def one(self, *arguments):
        """The only object of a verb."""
        objects = self.daemon.objects(*arguments)
        self.assertEqual(len(objects), 1, objects)
        return objects[0]

    def test_status(self):
        status = self.one("status")
        self.assertEqual((status["bus"], status["bit_rate"]), (self.daemon.bus, 125000))
        self.assertEqual((status["link_state"], status["timestamp_source"]), ("up", "kernel"))

    def test_slaves(self):
        self.assertEqual([slave["slave"] for slave in self.daemon.objects("slaves")], [0, 1, 2, 3])

    def test_events(self):
        codes = {event["code"] for event in self.daemon.objects("events")}
        self.assertIn("all_synchronized", codes)

    def test_timing(self):
        self.assertEqual(self.one("timing")["bit_rate"], 125000)

    def test_trace(self):
        objects = [json.loads(line) for line in self.daemon.verb("trace", self.log.file.name, "--json").splitlines()]
        self.assertIn("CC", {found["channel"] for found in objects})

    def test_learn(self):
        points = [json.loads(line) for line in self.daemon.verb("learn", self.log.file.name, "--json").splitlines()]
        found = {point["point"]: point["found"] for point in points if point["kind"] == "point"}
        self.assertEqual((found["bus.bit_rate"], found["slaves"]), ("125000 bit/s", "0-3"))

    def test_read_and_write(self):
        self.assertEqual(self.one("write", 1, 1001, 4321)["result"], "done")
        self.assertEqual(self.one("read", 1, 1001)["value"], 4321)

    def ended(self, *arguments, code=0):
        """What a verb that takes the profile prints, and ends with this code."""
        result = self.daemon.run(*arguments, "--profile", PROFILE)
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stdout.decode()

    def test_params(self):
        self.assertEqual(self.one("write", 2, 1001, 4321)["result"], "done")
        lines = self.ended("params", 2, "--group", "free").splitlines()
        self.assertTrue([line for line in lines if re.match(r" *1001 +word-1 +4321 ", line)], lines)

    def test_passports(self):
        path = os.path.join(self.folder, "passport")
        self.ended("backup", 3, path)
        self.assertEqual(self.one("write", 3, 1002, 77)["result"], "done")
        self.assertIn("word-2", self.ended("diff", path, 3, code=DIFFERENT))
        self.ended("restore", 3, path)
        self.ended("verify", 3, path)

    def test_download_and_upload(self):
        data = os.urandom(1000)
        path = os.path.join(self.folder, "data")
        with open(path, "wb") as file:
            file.write(data)
        self.assertEqual(self.one("download", 3, "0x100", path)["bytes"], 1000)
        self.assertEqual(self.one("upload", 3, "0x100", 1000, path + ".back")["bytes"], 1000)
        with open(path + ".back", "rb") as file:
            self.assertEqual(file.read(), data)

    def test_control_and_broadcast(self):
        self.assertEqual(self.one("control", 1, 7)["result"], "done")
        self.assertEqual(self.one("broadcast", "--yes", "--slaves", "all", "--command", 210)["slave_mask"], 0b1111, "those of the configuration")

    def test_what_others_do(self):
        self.assertIn(self.daemon.bus, [bus["bus"] for bus in self.daemon.objects("buses")])
        self.daemon.verb("jobs")
        self.daemon.verb("clients")
        self.assertEqual(self.daemon.run("cancel", 999999).returncode, 3)

    def test_mode(self):
        self.assertEqual(self.one("mode", "setup", "--yes")["result"], "done")
        self.daemon.wait_status("setting up", lambda status: status["option_status"] == 0x43)
        self.assertEqual(self.one("mode", "run")["result"], "done")
        self.daemon.wait_active()

    def test_set_and_watch(self):
        values = self.daemon.start("set", "0=500", "4=1", "--rate", 20, "--json")
        try:

            def position():
                self.daemon.verb("control", 1, "0x87")
                found = self.one("watch", 1, "--count", 1)["values"]
                return next((value["raw"] for value in found if value["value"] == 0), None)

            wait_for("slave 1 stands at 500", lambda: position() == 500)
        finally:
            values.send_signal(signal.SIGINT)
            out, _ = values.communicate(timeout=LONG)
        self.assertEqual(json.loads(out)["result"], "done")

    def test_wait(self):
        self.assertEqual(self.one("wait", "synchronized", "0-3")["result"], "done")

    def test_batch(self):
        path = os.path.join(self.folder, "batch")
        with open(path, "w", encoding="utf-8") as file:
            file.write("write 0 1003 55\nread 0 1003 --json\n")
        read = self.daemon.verb("batch", path).splitlines()[-1]
        self.assertEqual(json.loads(read)["value"], 55)

    def test_record(self):
        path = os.path.join(self.folder, "values.csv")
        values = self.daemon.start("set", "0=500", "4=1", "--rate", 20)
        try:
            # Rows come once the values are released.
            wait_for("rows", lambda: self.one("record", path, 1, "--duration", 1)["rows"])
        finally:
            values.send_signal(signal.SIGINT)
            values.communicate(timeout=LONG)

    def test_poll(self):
        self.assertEqual(self.one("poll", 1, 2)["result"], "done")
        wait_for("slave 2 is asked", lambda: self.one("poll")["channel_1"] == 2)
        self.assertEqual(self.one("poll", 1, "auto")["result"], "done")

    def test_doctor(self):
        result = self.daemon.run("doctor", "--json")
        found = [json.loads(line) for line in result.stdout.splitlines()]
        amiss = {one["topic"]: one["level"] for one in found if one["level"] != "ok"}
        self.assertEqual((amiss, result.returncode), ({"kernel": "warning", "limits": "warning"}, 1),
                         "it is not a realtime kernel, and no reference value has limits")

    def test_map(self):
        self.assertEqual(self.one("map", 1, 2, "0x11", "0x13")["result"], "done")
        wait_for("it is in effect", lambda: self.daemon.objects("map", 1)[1]["registers"] == [0x11, 0x13, 0, 0])
        self.assertEqual(self.one("map", 1, 2, "0x11", "0x13", "0x15", "0x17")["result"], "done")

    def test_release(self):
        result = self.daemon.run("release", 1)
        self.assertEqual(result.returncode, 3, "nothing is held out")
        self.assertIn("slave 1 'slave1' is not held out", result.stderr)

    def test_no_verb_is_left_out(self):
        verbs = re.findall(r"[a-z][a-z0-9]*", self.daemon.run().stderr.splitlines()[0].split("allowed: ")[1])
        with open(__file__, encoding="utf-8") as file:
            text = file.read()
        # Those of a slave's bus, of J1939, and some of general frames: on the simulated bus alone.
        for other in ("unknown_line.py", "layer2_on_vcan_test.py", "../end_to_end/layer2_test.py", "../end_to_end/record_test.py",
                      "../end_to_end/j1939_test.py",
                      "../end_to_end/cansync_slave_test.py", "../end_to_end/cansync_slave_service_test.py"):
            with open(os.path.join(os.path.dirname(__file__), other), encoding="utf-8") as file:
                text += file.read()
        self.assertEqual([verb for verb in verbs if f'("{verb}"' not in text], [])

"""Every verb of `cansync` but those for jobs as a process, against a running cansyncd with simulated drives."""

import json
import os
import re
import signal
import tempfile
import time
import unittest
from xml.etree import ElementTree

from gateway import ACTIVE, BIT_RATE, LONG, Gateway, Place, wait_for
from verb_case import ALWAYS_BUSY, BUSY, BUSY_REPLIES, CONTROL_WORD, DEVICE_TYPE, LAST_ACTION, WORD, VerbTest


class Looking(VerbTest):
    def test_status(self):
        status = self.one("status")
        self.assertEqual(status["bus"], self.gateway.bus)
        self.assertEqual(status["bit_rate"], BIT_RATE)
        self.assertEqual(status["interval_length_ns"], 10**12 // BIT_RATE)
        self.assertEqual(status["slaves_configured"], 0xF)
        self.assertEqual(status["reference_value"][0], {"name": "target", "unit_symbol": "mm", "factor": 0.001, "offset": 0,
                                                        "width": 32, "is_signed": True})
        self.assertEqual(status["protocol"], "cansync-master")
        self.assertEqual(status["process"], self.gateway.process.pid)
        text = self.text("status")
        self.assertIn(f"(process {self.gateway.process.pid} on {status['host']})", text)
        self.assertRegex(text, r"(?m)^state +run \(0x0080\)")
        self.assertRegex(text, r"(?m)^slaves synchronized +0-3 \(4 of 4\)$")

    def test_slaves(self):
        slaves = self.synchronized_slaves()
        self.assertEqual([slave["slave"] for slave in slaves], [0, 1, 2, 3])
        self.assertEqual(slaves[1]["name"], "winder")
        for slave in slaves:
            self.assertTrue(slave["status_word"] & 0x8000, slave)
        lines = self.text("slaves", "winder", "3").splitlines()
        self.assertEqual([line.split()[:2] for line in lines[1:]], [["1", "winder"], ["3", "slave3"]])
        self.assertIn("9 not configured; configured are 0-3", self.fails("slaves", "9", code=2))

    def test_doctor(self):
        result = self.gateway.run("doctor", "--json")
        findings = {finding["topic"]: finding for finding in map(json.loads, result.stdout.splitlines())}
        levels = {finding["level"] for finding in findings.values()}
        # What this machine grants decides between these; a simulated line has no error to find.
        self.assertEqual(result.returncode, 1 if "warning" in levels else 0, result.stdout)
        self.assertNotIn("error", levels)
        for topic in ("daemon", "version", "data model", "interface", "controller", "second master", "DDS"):
            self.assertEqual(findings[topic]["level"], "ok", findings[topic])
        self.assertEqual(findings["time stamps"]["found"], "by simulation")
        self.assertIn("simulated line", findings["interface"]["found"])
        for topic in ("priority", "locked memory", "processor", "isolated", "idle states", "kernel"):
            self.assertEqual(findings[topic]["remedy"] is None, findings[topic]["level"] == "ok", findings[topic])
        self.assertRegex(self.gateway.run("doctor").stdout.decode(), r"(?m)^ok +daemon +serves bus ")

    def test_events(self):
        events = self.json("events")
        self.assertEqual([event["number"] for event in events], sorted(event["number"] for event in events))
        self.assertIn("all_synchronized", [event["code"] for event in events])
        chosen = self.json("events", "--code", "all_synchronized,slave_lost", "--since", "1d", "--level", "info")
        self.assertEqual({event["code"] for event in chosen}, {"all_synchronized"})
        self.assertEqual({event["slave"] for event in self.json("events", "--slave", "winder")} - {1}, set())
        told = self.run_verb("events", "--code", "no_such")
        self.assertEqual(told.stdout, b"")
        self.assertIn("all_synchronized", told.stderr)
        self.assertRegex(self.text("events"), r"(?m)^\d{4}-\d\d-\d\d [\d:.]{12}  info     all_synchronized ")

    def test_events_are_followed_until_ctrl_c(self):
        follower = self.gateway.start("events", "--follow", "--json")
        known = follower.next_object()["number"]
        self.run_verb("mode", "reset-can")
        self.run_verb("mode", "setup")
        self.run_verb("mode", "run", "--force")
        while True:
            event = follower.next_object()
            self.assertGreater(event["number"], known)
            known = event["number"]
            if event["code"] == "state_changed" and "to 'run'" in event["text"]:
                break
        self.interrupt(follower, code=0)
        self.gateway.wait_active()


class Timing(VerbTest):
    """Lateness and slots of a line with reference values on it."""

    BIT_RATE = 1000000

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        values = cls.gateway.start("set", "0=1", "4=1")
        cls.addClassCleanup(cls.end, values)

    @staticmethod
    def end(process):
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=LONG)

    def slots(self, *arguments):
        """A report in which both reference value telegrams were seen."""

        def look():
            report = self.one("timing", *arguments)
            return report if all(slot["count"] > 0 for slot in report["slots"][1:5]) else None

        return wait_for("all process data are on the bus", look)

    def test_slots(self):
        report = self.slots()
        self.assertEqual([slot["slot"] for slot in report["slots"]], ["RC", "WRC1", "RDC1", "WRC2", "RDC2", "CC"])
        self.assertEqual([slot["allowed_ns"] // 1000 for slot in report["slots"]], [210, 350, 520, 650, 820, 950])
        self.assertEqual([slot["left_out"] is None for slot in report["slots"]], [True, False, True, False, True, False])
        for slot in report["slots"][1:5]:
            self.assertTrue(0 < slot["earliest_ns"] <= slot["mean_ns"] <= slot["latest_ns"] < 1000000, slot)
        self.assertIsNone(report["seconds"])
        self.assertEqual(len(report["lateness_histogram"]), 16)
        self.assertEqual(report["timestamp_source"], "simulation")

    def test_some_seconds_alone(self):
        whole = self.one("timing")
        report = self.one("timing", "--seconds", 2)
        self.assertEqual(report["seconds"], 2)
        self.assertLess(report["intervals"], whole["intervals"] + 2500)
        # An interval has one wake-up; skipped ones have none. The loop may be between counting the one and the other.
        self.assertAlmostEqual(sum(report["lateness_histogram"]), report["intervals"], delta=report["missed_syncs"] + 2)

    def test_diagram(self):
        self.slots()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "interval.svg")
            report = self.one("timing", "--seconds", 1, "--svg", path)
            texts = [element.text for element in ElementTree.parse(path).iter("{http://www.w3.org/2000/svg}text")]
        self.assertIn(f"CANsync interval on bus {self.gateway.bus} at 1000000 bit/s", texts)
        for slot in report["slots"]:
            self.assertIn(slot["slot"], texts)
            if slot["count"]:
                self.assertIn(str(slot["count"]), texts)

    def test_text_fits_the_terminal_and_follows_until_ctrl_c(self):
        text = self.text("timing")
        self.assertRegex(text, r"(?m)^p50 < \d+ us, p90 ")
        self.assertIn("bus load", text)
        self.assertLessEqual(max(map(len, text.splitlines())), 100)
        follower = self.gateway.start("timing", "--follow", "--json")
        for _ in range(2):
            self.assertGreater(follower.next_object()["intervals"], 0)
        self.interrupt(follower, code=0)

    def test_wrong_seconds(self):
        self.assertIn("--seconds: found '0'; allowed: 1..3600", self.fails("timing", "--seconds", 0, code=2))


class Commands(VerbTest):
    def test_control_word(self):
        for text, word in [("0x1234", 0x1234), ("-1", 0xFFFF), ("7", 7)]:
            self.assertEqual(self.one("control", "winder", text)["control_word"], word)
            wait_for("the drive has it", lambda: self.one("read", 1, CONTROL_WORD)["value"] == word)
        self.assertIn("control word 0x0007 to slave 1 sent", self.run_verb("control", 1, 7).stderr)
        self.assertIn("allowed 0..3", self.fails("control", 17, 7, code=3))

    def last_actions(self):
        return [self.one("read", slave, LAST_ACTION)["value"] for slave in range(self.SLAVES)]

    def test_broadcast_reaches_the_group_alone(self):
        before = self.last_actions()
        sent = self.one("broadcast", "--yes", "--slaves", "0,winder", "--command", 200, "--byte", 0x5A, "--word", "0x1234")
        self.assertEqual(
            sent, {"slave_mask": 3, "priority": 2, "command": 200, "byte": 0x5A, "word": 0x1234, "result": "done", "reason": "", "cause": None}
        )
        wait_for("two drives have it", lambda: self.last_actions()[:2] != before[:2])
        after = self.last_actions()
        self.assertEqual(after[0], after[1])
        self.assertEqual(after[2:], before[2:])

    def test_broadcast_in_every_priority(self):
        for priority in range(3):
            before = self.last_actions()
            self.run_verb("broadcast", "--yes", "--slaves", "all", "--command", 201 + priority, "--priority", priority)
            wait_for("all have it", lambda: all(a != b for a, b in zip(self.last_actions(), before)))
            self.assertEqual(len(set(self.last_actions())), 1)

    def test_broadcast_refused(self):
        self.assertIn("command", self.fails("broadcast", "--yes", "--slaves", "all", "--command", 5, code=3).lower())
        self.fails("broadcast", "--yes", "--slaves", "0x100", "--command", 200, code=3)

    def test_modes(self):
        self.addCleanup(self.gateway.wait_active)
        self.assertEqual(self.one("mode", "stop"), {"mode": "stop", "force": False, "result": "done", "reason": "", "cause": None})
        self.assertEqual(self.gateway.status()["option_status"], 0x03)
        self.assertIn("mode setup", self.fails("read", 0, DEVICE_TYPE, code=3))
        self.run_verb("mode", "setup")
        self.gateway.wait_status("all are synchronized", lambda s: s["slaves_synchronized"] == s["slaves_configured"])
        self.assertEqual(self.gateway.status()["option_status"], 0x43)
        self.assertEqual(self.one("read", 0, DEVICE_TYPE)["value"], 4400)
        self.assertEqual(self.run_verb("mode", "run").stderr, "cansync: mode run is in effect\n")
        self.assertEqual(self.gateway.status()["option_status"], ACTIVE)
        self.run_verb("mode", "reset-can")
        self.run_verb("mode", "restart", "--yes")
        status = self.gateway.wait_status("it has started again", lambda s: s["option_status"] in (0x03, 0x43, ACTIVE))
        if status["option_status"] == 0x03:
            self.run_verb("mode", "setup")
        self.gateway.wait_status("all are synchronized", lambda s: s["slaves_synchronized"] == s["slaves_configured"])
        self.run_verb("mode", "run")

    def test_polling_and_cursors(self):
        usual = self.one("poll")
        self.assertEqual(
            usual,
            {"channel_1": "auto", "channel_2": "auto", "maximum_slave": 3, "control_word": "auto"}
            | {"parameter": "auto", "transfer": "auto", "serving": "work_conserving"},
        )
        self.run_verb("poll", 1, "winder", 2, "nobody", "--maximum", 2, "--parameter", 3, "--control-word", "nobody")
        changed = {"channel_1": 1, "channel_2": "nobody", "maximum_slave": 2, "control_word": "nobody", "parameter": 3}
        wait_for("the status shows it", lambda: self.one("poll") == usual | changed)
        self.assertRegex(self.text("poll"), r"(?m)^channel 1 .* slave 1$")
        self.assertEqual(self.one("poll", 1, "auto", 2, "auto", "--maximum", 3)["result"], "done")
        self.run_verb("poll", "--parameter", "auto", "--control-word", "auto")
        wait_for("it is as before", lambda: self.one("poll") == usual)
        self.fails("poll", 1, 9, code=3)

    def test_mapping(self):
        usual = self.json("map")
        self.assertEqual([(m["of"], m["slave"], m["telegram"]) for m in usual[:3]],
                         [("references", None, 1), ("references", None, 2), ("slave", 0, 1)])
        self.assertEqual(usual[0]["words"], ["value0.low", "value0.high", "value1.low", "value1.high"])
        self.assertEqual(usual[0]["registers"], [1, 3, 5, 7])
        self.run_verb("map", "references", 1, "target.low", "target.high", "0x0D", "-")
        wait_for("the status shows it", lambda: self.json("map", "references")[0]["registers"] == [1, 3, 0x0D, 0])
        self.assertEqual(self.one("map", "winder", 2, "4.low")["result"], "done")
        wait_for("the status shows it", lambda: self.json("map", "winder")[1]["words"] == ["value4.low", "-", "-", "-"])
        self.assertEqual(self.json("map", 0), usual[2:4])
        self.assertRegex(self.text("map"), r"(?m)^slave 1 +RDC2 +value4\.low +- +- +-$")
        self.fails("map", "references", 1, "value4.low", code=3)
        self.run_verb("map", "references", 1, "0x01", "0x03", "0x05", "0x07")
        self.run_verb("map", "winder", 2, "0x11", "0x13", "0x15", "0x17")
        wait_for("it is as before", lambda: self.json("map") == usual)


class ReferenceValues(VerbTest):
    def setUp(self):
        # A drive whose reference values stopped has faulted; this control word acknowledges it.
        for slave in range(self.SLAVES):
            self.run_verb("control", slave, 0x87)

    def start_set(self, *arguments):
        process = self.gateway.start("set", *arguments)
        self.addCleanup(lambda: process.poll() is None and self.interrupt(process, code=0))
        return process

    def position(self, slave):
        values = self.one("watch", slave, "--count", 1)["values"]
        return next((value["raw"] for value in values if value["value"] == 0), None)

    def follow(self, position):
        """Acknowledges faults until every drive stands at `position`."""

        def look():
            for slave in range(self.SLAVES):
                self.run_verb("control", slave, 0x87)
            return all(self.position(slave) == position for slave in range(self.SLAVES))

        wait_for(f"every drive stands at {position}", look)

    def test_actual_values_follow_until_ctrl_c(self):
        process = self.start_set("0=5000")
        self.follow(5000)
        winder = self.one("watch", "winder", "--count", 1)
        self.assertEqual(winder["values"][0], {"value": 0, "name": "position", "raw": 5000, "scaled": 5, "unit": "mm"})
        self.assertRegex(self.text("watch", "winder", "--count", 1), r"position.*\n.* 5 mm")
        self.assertRegex(self.text("watch", "winder", "--count", 1, "--raw"), r"position.*\n.* 5000")
        _, remarks = self.interrupt(process, code=0)
        self.assertRegex(remarks, r"sent \d+ reference values? to telegram 1; released")

    def test_scaled_and_named(self):
        self.start_set("target=-2.5", "--scaled", "--rate", 100, "--release", 200)
        self.follow(-2500)

    def test_a_writer_keeps_its_telegram_until_it_is_taken_over(self):
        self.start_set("0=700", "--strength", 9)
        self.follow(700)
        for strength in (2, 9):
            refused = self.one("set", "0=90000", "--strength", strength, "--seconds", 1, code=10)
            self.assertEqual((refused["result"], refused["samples"]), ("no_effect", 0))
            self.assertEqual(self.position(0), 700)
        self.start_set("0=800", "--take-over")
        self.follow(800)

    def test_watch_adds_lines(self):
        lines = self.text("watch", "--count", 3, "--interval", 20).splitlines()
        self.assertEqual(len(lines), 1 + 3 * self.SLAVES)
        self.assertEqual(lines[0].split()[:3], ["TIME", "SLAVE", "NAME"])
        self.assertEqual([line.split()[1] for line in lines[1:]], ["0", "1", "2", "3"] * 3)

    def test_watch_redraws_on_a_terminal(self):
        shown, code = self.gateway.run_on_terminal("watch", "--count", 3, "--interval", 20)
        self.assertEqual(code, 0)
        self.assertEqual(shown.count("\x1b[H"), 3)
        self.assertEqual(shown.count("\x1b[2J"), 1)
        self.assertEqual(len(re.findall(r"winder", shown)), 3)

    def test_watch_ends_with_ctrl_c(self):
        process = self.gateway.start("watch", "--interval", 20)
        process.next_line()
        self.interrupt(process, code=0)

    def test_wrong_values_are_told(self):
        self.assertIn("value", self.fails("set", "nonsense=1", code=2))
        self.assertIn("allowed", self.fails("set", "0=4294967296", code=2))
        self.assertIn("allowed: -2.14748e+06..2.14748e+06", self.fails("set", "target=3e6", code=2))
        remark = self.run_verb("set", "2=1", "--seconds", 0.1).stderr
        self.assertIn("reference value 2 is in no telegram", remark)


class Trace(unittest.TestCase):
    """`trace` on what the simulated line has written."""

    def test_stamps_and_names_are_those_of_recordings(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "line.log")
            began = time.time_ns()
            with Gateway(options=("--trace", path)) as gateway:
                gateway.run("record", os.path.join(folder, "run.csv"), "--duration", 0.1)
                frames = gateway.json("trace", path, "--slave", "winder", "--config", gateway.config, "--count", 20)
            self.assertEqual({frame["slave"] for frame in frames} - {1, None}, set())
            self.assertTrue(began <= frames[0]["time_us"] * 1000 <= time.time_ns(), frames[0])
            wrong = gateway.run("trace", path, "--slave", "nobody", "--config", __file__)
            self.assertEqual(wrong.returncode, 1, wrong.stderr)

    def test_a_read_is_found_in_the_trace_of_the_line(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "line.log")
            with Gateway(bit_rate=1000000, options=("--trace", path)) as gateway:
                self.assertEqual(gateway.run("write", 2, WORD, 4711, "--format", "word").returncode, 0)
                self.assertEqual(gateway.json("read", 2, WORD)[0]["value"], 4711)
            found = gateway.json("trace", path, "--slave", 2)
            texts = [telegram["text"] for telegram in found]
            for text in (
                f"write parameter {WORD} = 4711 (0x1267, word)",
                f"parameter {WORD}: written",
                f"read parameter {WORD}",
                f"parameter {WORD} = 4711 (0x1267, word)",
            ):
                self.assertIn(text, texts)
            self.assertEqual([telegram for telegram in found if "no CANsync telegram" in telegram["text"]], [])
            write = found[texts.index(f"write parameter {WORD} = 4711 (0x1267, word)")]
            self.assertEqual((write["channel"], write["slave"], write["identifier"]), ("CC", 2, 0x502))
            # In active operation a command comes late in its interval; an edge may be produced half an interval late.
            self.assertTrue(300 <= write["after_sync_us"] <= 1000, write)
            with open(path, "rb") as file:
                log = file.read()
            again = gateway.run("trace", "-", "--candump", data=log)
            self.assertEqual((again.returncode, again.stderr), (0, ""))
            # The log's time stamps have leading zeros.
            self.assertEqual(
                re.sub(rb"(?m)^\(0*(?=\d)", b"(", again.stdout), re.sub(rb"(?m)^\(0*(?=\d)", b"(", log)
            )


class WithoutDaemon(unittest.TestCase):
    def test_it_says_where_it_looked(self):
        place = Place()
        for verb in (["status"], ["read", "0", "100", "--json"], ["watch"], ["set", "0=1"]):
            result = place.run(*verb, "--timeout", 1)
            self.assertEqual((result.returncode, result.stdout), (6, b""))
            for part in (f"domain {place.domain}", place.bus, "interface lo", "cansyncd"):
                self.assertIn(part, result.stderr)

    def test_doctor_says_what_it_could_not_see(self):
        place = Place()
        result = place.run("doctor", "--json", "--timeout", 1)
        self.assertEqual((result.returncode, result.stderr), (6, ""))
        findings = {finding["topic"]: finding for finding in map(json.loads, result.stdout.splitlines())}
        self.assertEqual(findings["daemon"]["level"], "error")
        escaped = place.bus.replace("-", "\\x2d")
        self.assertIn(f"'cansyncd@{escaped}'", findings["daemon"]["remedy"])
        self.assertIn("realtime rights", findings["not looked at"]["found"])
        self.assertIn("kernel", findings)

    def test_another_bus_is_not_this_one(self):
        with Gateway() as gateway:
            result = gateway.run("status", "--bus", "another", "--timeout", 1)
            self.assertEqual(result.returncode, 6)
            self.assertIn("another", result.stderr)

    def test_a_daemon_that_stops_answers_open_jobs(self):
        with Gateway() as gateway:
            gateway.run("write", 0, BUSY_REPLIES, ALWAYS_BUSY)
            process = gateway.start_job("open_parameter_jobs", "read", 0, BUSY, "--timeout", 3000, "--json")
            gateway.stop()
            out, err = process.communicate(timeout=LONG)
            self.assertEqual((process.returncode, json.loads(out)["result"]), (7, "master_stopped"), err)


if __name__ == "__main__":
    unittest.main(verbosity=2)

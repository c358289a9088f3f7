"""A daemon that is killed and started again before its absence could be noticed: what follows it says so."""

import csv
import json
import os
import select
import signal
import subprocess
import tempfile
import time
import unittest

from gateway import BIT_RATE, CANSYNCD, LONG, Gateway, wait_for

STARTED_ANEW = "the daemon was started anew"
EXTRA = "[process]\npoll_without_reference = true\n"  # there is something to record without a writer


class Follower:
    """A verb that goes on, its output kept as it comes."""

    def __init__(self, gateway, *arguments):
        self.process = gateway.start(*arguments)
        self.out, self.err = b"", b""

    def read(self):
        streams = {self.process.stdout: "out", self.process.stderr: "err"}
        while ready := select.select(list(streams), [], [], 0)[0]:
            ended = 0
            for stream in ready:
                part = os.read(stream.fileno(), 65536)
                setattr(self, streams[stream], getattr(self, streams[stream]) + part)
                ended += not part
            if ended == len(ready):
                return

    def said(self):
        self.read()
        return self.err.decode(errors="replace")

    def wrote(self):
        self.read()
        return self.out.decode(errors="replace")

    def end(self):
        self.process.kill()
        self.process.stdout.close()
        self.process.stderr.close()
        self.process.wait(LONG)


class Restart(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory())
        self.gateway = self.enterContext(Gateway(extra=EXTRA))

    def follow(self, *arguments):
        follower = Follower(self.gateway, *arguments)
        self.addCleanup(follower.end)
        return follower

    def restart(self):
        self.gateway.process.kill()
        self.gateway.process.wait(LONG)
        time.sleep(1)  # far less than the lease of its participant: nobody sees it go
        with open(self.gateway.log, "ab") as log:
            self.gateway.process = subprocess.Popen([CANSYNCD, self.gateway.config], stdout=log, stderr=log)
        self.gateway.wait_active()

    @staticmethod
    def last_row(path):
        """The last whole line of a recording; its heading, and what it says of a restart, are none."""
        if not os.path.exists(path):
            return None
        with open(path, encoding="utf-8") as file:
            line = file.read().rpartition("\n")[0].rpartition("\n")[2]
        return line if line[:1].isdigit() else None

    def test_everything_that_follows_says_so(self):
        path = os.path.join(self.folder, "line.csv")
        recording = self.follow("record", path)
        watching = self.follow("watch", "--plain", "--interval", "100")
        events = self.follow("events", "--follow")
        waiting = self.follow("wait", "bus-off")
        setting = self.follow("set", "0=5000")
        timing = self.follow("timing", "--seconds", "3", "--follow", "--json")
        wait_for("they have begun", lambda: self.last_row(path) and watching.wrote() and events.wrote())
        wait_for("the values are taken", lambda: self.gateway.status()["reference_release"][0]["writer"] != "")
        self.restart()
        for follower in (recording, watching, events, waiting, setting, timing):
            wait_for(f"{follower.process.arguments} says it", lambda said=follower.said: STARTED_ANEW in said())
            self.assertEqual(follower.said().count(STARTED_ANEW), 1, follower.said())
        wait_for("an empty line between the rows of both starts", lambda: "\n\n" in watching.wrote())
        self.assertIsNone(waiting.process.poll())
        wait_for("timing figures of the new start", lambda: timing.wrote().count("\n") >= 2)
        for line in timing.wrote().splitlines():
            self.assertLess(json.loads(line)["intervals"], 10_000, line)

        wait_for("the recording goes on", lambda: self.last_row(path))
        recording.process.send_signal(signal.SIGINT)
        wait_for("the recording ends", lambda: recording.process.poll() is not None)
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))[1:]
        comments = [index for index, row in enumerate(rows) if row[0].startswith("#")]
        self.assertEqual(len(comments), 1)
        self.assertIn(STARTED_ANEW, rows[comments[0]][0])
        for part in (rows[:comments[0]], rows[comments[0] + 1:]):
            intervals = [int(row[3]) for row in part]
            self.assertGreater(len(intervals), 0)
            self.assertEqual(intervals, sorted(intervals))
        plot = self.gateway.run("plot", path, "--output", os.path.join(self.folder, "plot.svg"))
        self.assertEqual(plot.returncode, 0, plot.stderr)

    def reload(self, *changes):
        """Changes the configuration, and has the daemon read it again."""
        with open(self.gateway.config, encoding="utf-8") as file:
            text = file.read()
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new)
        with open(self.gateway.config, "w", encoding="utf-8") as file:
            file.write(text)
        self.gateway.process.send_signal(signal.SIGHUP)

    def test_a_reload_that_changes_what_values_are(self):
        path = os.path.join(self.folder, "line.csv")
        recording = self.follow("record", path)
        waiting = self.follow("wait", "value", "winder", "position", ">", "1e9")
        wait_for("the recording has begun", lambda: self.last_row(path))
        self.reload(('name = "winder"', 'name = "coiler"'), ("factor = 0.001", "factor = 0.002"))
        wait_for("the recording says it", lambda: "'position [mm]' is number * 0.002" in recording.said())
        wait_for("the wait has no such slave any more", lambda: waiting.process.poll() is not None)
        self.assertEqual(waiting.process.returncode, 2, waiting.said())
        self.assertIn("winder", waiting.said())
        self.assertIsNone(recording.process.poll())

        def rows():
            with open(path, encoding="utf-8", newline="") as file:
                return list(csv.reader(file))[1:-1]  # the last may have no end yet
        wait_for("rows under the new name", lambda: any(row[5:6] == ["coiler"] for row in rows()))
        comments = [index for index, row in enumerate(rows()) if row[0].startswith("#")]
        self.assertEqual(len(comments), 2, rows())
        before, after = rows()[:comments[0]], rows()[comments[-1] + 1:]
        self.assertIn("winder", {row[5] for row in before})
        self.assertNotIn("coiler", {row[5] for row in before})
        self.assertNotIn("winder", {row[5] for row in after})

    def test_a_reload_sets_a_line_up_anew_that_is_not_active(self):
        events = self.follow("events", "--follow")
        wait_for("it has begun", events.wrote)
        self.reload((f"bit_rate = {BIT_RATE}", "bit_rate = 500000"), ("number = 2\n", "number = 9\n"))
        refused = "not changed: slave.9.number takes effect when the line is set up anew, and it is in run"
        wait_for("it is not changed while it is active", lambda: refused in self.gateway.log_text())
        wait_for("who follows hears why", lambda: "not changed before the line is set up anew" in events.wrote())
        self.assertEqual(self.gateway.status()["bit_rate"], BIT_RATE)
        self.assertEqual(self.gateway.status()["slaves_configured"], 0b1111)

        self.assertEqual(self.gateway.run("mode", "stop").returncode, 0)
        waiting = self.follow("wait", "synchronized")  # all that are configured when it looks
        self.gateway.process.send_signal(signal.SIGHUP)
        self.gateway.wait_status("the line is another", lambda s: s["bit_rate"] == 500000)
        self.assertIsNone(waiting.process.poll(), waiting.said())
        # Who stopped it may have hands in the machine.
        self.assertEqual(self.gateway.status()["state"], "stop")
        self.assertEqual(self.gateway.run("mode", "setup").returncode, 0)
        self.gateway.wait_status("all are synchronized", lambda s: s["slaves_synchronized"] == 0b1000001011)
        self.assertEqual(self.gateway.run("mode", "run").returncode, 0)
        self.gateway.wait_status("it is in active operation", lambda s: s["option_status"] == 0x80)
        self.assertIsNone(self.gateway.process.poll(), "the same process")
        wait_for("who follows hears on", lambda: "changed: bus.bit_rate, slave.2.number, slave.9.number" in events.wrote())
        wait_for("those are waited for that are configured now", lambda: waiting.process.poll() is not None)
        self.assertEqual(waiting.process.returncode, 0, waiting.said())
        self.assertEqual(self.gateway.run("read", "9", "301").returncode, 0)
        gone = self.gateway.run("read", "2", "301")
        self.assertEqual(gone.returncode, 3, gone.stderr)
        self.assertIn("not configured", gone.stderr)
        self.assertIsNone(events.process.poll())


if __name__ == "__main__":
    unittest.main(verbosity=2)

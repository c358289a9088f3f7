"""A daemon that is killed and started again before its absence could be noticed: what follows it says so."""

import csv
import os
import select
import signal
import subprocess
import tempfile
import time
import unittest

from gateway import CANSYNCD, LONG, Gateway, wait_for

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

    def test_everything_that_follows_says_so(self):
        path = os.path.join(self.folder, "line.csv")
        recording = self.follow("record", path)
        watching = self.follow("watch", "--plain", "--interval", "100")
        events = self.follow("events", "--follow")
        waiting = self.follow("wait", "bus-off")
        setting = self.follow("set", "0=5000")
        wait_for("they have begun", lambda: os.path.exists(path) and watching.wrote() and events.wrote())
        wait_for("the values are taken", lambda: self.gateway.status()["reference_release"][0]["writer"] != "")
        self.restart()
        for follower in (recording, watching, events, waiting, setting):
            wait_for(f"{follower.process.arguments} says it", lambda said=follower.said: STARTED_ANEW in said())
            self.assertEqual(follower.said().count(STARTED_ANEW), 1, follower.said())
        wait_for("an empty line between the rows of both starts", lambda: "\n\n" in watching.wrote())
        self.assertIsNone(waiting.process.poll())

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


if __name__ == "__main__":
    unittest.main(verbosity=2)

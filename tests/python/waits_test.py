"""Ctrl-C in waits, other threads meanwhile, and interpreters that end with everything open."""

import subprocess
import sys
import unittest

from interrupt import SOON, seconds_to_end
from line import LONG, Line, cansync

TIMES = 10  # on a busy machine the quickest tells what the package takes

OPEN_EVERYTHING = """
import sys, threading, cansync
line = cansync.connect({bus!r}, domain={domain}, timeout={long})
kept = line.subscribe(cansync.MasterStatus, lambda status: sum(range(10000)))
line.subscribe(cansync.SlaveStatus, lambda status: None)
stream = line.follow(cansync.Event)
references = line.references()
references.give(1, [1], release_intervals=1000)
job = line.submit_upload(3, 0x1000, 1 << 20)
timings = line.follow(cansync.Timing)  # here: a thread that comes to it later finds the line closed, and says so
threading.Thread(target=lambda: list(timings), daemon=True).start()
def wait():
    try:
        job.result()
    except cansync.OutcomeUnknown:
        pass
threading.Thread(target=wait, daemon=True).start()
next(stream)
"""


class Waits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.gateway = cls.enterClassContext(Line())
        cls.line = cls.enterClassContext(cls.gateway.connect())

    def check(self, function, call, elsewhere=False):
        took = [seconds_to_end(function, call, elsewhere) for _ in range(TIMES)]
        self.assertLess(min(took), SOON, took)

    def test_connecting(self):
        self.check("call", lambda: cansync.connect("nobody", domain=self.gateway.domain, timeout=LONG))

    def test_connecting_to_a_slave(self):
        self.check("_call", lambda: cansync.connect_slave("nobody", domain=self.gateway.domain, timeout=LONG))

    def test_a_transfer_which_is_cancelled(self):
        self.check("result", lambda: self.line.upload(3, 0x1000, 1 << 20))
        for status in self.line.follow(cansync.MasterStatus, timeout=LONG):
            if status.open_transfers == 0:
                break

    def test_a_stream(self):
        stream = self.line.follow(cansync.Interval)  # which is not switched on
        self.check("get", stream.get)
        self.check("get", lambda: next(stream))

    def test_a_signal_that_another_thread_takes(self):
        stream = self.line.follow(cansync.Interval)
        self.check("get", stream.get, elsewhere=True)
        self.check("result", lambda: self.line.upload(3, 0x1000, 1 << 20), elsewhere=True)
        self.check("poll", lambda: self.line.slave_status(9, LONG), elsewhere=True)

    def test_a_state(self):
        self.check("poll", lambda: self.line.slave_status(9, LONG))

    def end(self, last_line, code):
        text = OPEN_EVERYTHING.format(bus=self.gateway.bus, domain=self.gateway.domain, long=LONG) + last_line
        done = subprocess.run([sys.executable, "-B", "-X", "dev", "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True, timeout=LONG, check=False)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def test_an_interpreter_ends_with_everything_open(self):
        self.assertEqual(self.end("", 0), "")
        self.assertEqual(self.end("sys.exit(3)", 3), "")
        self.assertIn("ZeroDivisionError", self.end("1 / 0", 1))
        self.assertEqual(self.end("del line, kept, stream, timings, references, job", 0), "")
        self.assertEqual(self.end("line.close()", 0), "")

    def test_what_is_dropped_is_closed(self):
        text = "c = line._link\ndel line, stream, job\nimport gc; gc.collect()\n"
        self.end(text + "references.leave()", 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])

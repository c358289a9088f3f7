"""A daemon that is suspended and goes on does not release values that have grown old meanwhile, wherever they waited.

Rounds: SUSPENSIONS in the environment. The lengths lie around failsafe.reference_max_age_ms and the lease of a writer.
"""

import os
import re
import signal
import subprocess
import tempfile
import time
import unittest

from gateway import LONG, Gateway

ROUNDS = int(os.environ.get("SUSPENSIONS", "12"))
MAX_AGE_MS = 200
INTERVAL_MS = 8  # at 125 kbit/s
# A value that is young enough when its interval begins is on the bus by the end of it.
ALLOWED_MS = MAX_AGE_MS + INTERVAL_MS
# Stamps of a trace are of the wall clock; what is compared here, of the monotonic one.
TRACE_OFFSET_MS = round((time.time() - time.monotonic()) * 1000)
FRAME = re.compile(r"\((\d+)\.(\d{6})\) \S+ 1[0-7][0-9A-F]#([0-9A-F]{8})")


def released(path):
    """When each reference telegram was on the bus and what value 0 was, both in ms of CLOCK_MONOTONIC."""
    with open(path, encoding="ascii") as file:
        for line in file:
            frame = FRAME.match(line)
            if frame:
                at = int(frame[1]) * 1000 + int(frame[2]) // 1000 - TRACE_OFFSET_MS
                yield at, int.from_bytes(bytes.fromhex(frame[3]), "little")


def length(turn):
    """Seconds of a suspension: 20..900 ms, evenly spread over any number of rounds."""
    return 0.020 + 0.880 * ((turn * 0.6180339887) % 1)


class Suspension(unittest.TestCase):
    def setUp(self):
        folder = self.enterContext(tempfile.TemporaryDirectory(prefix="cansync_test_"))
        self.trace = os.path.join(folder, "trace.log")
        self.gateway = self.enterContext(Gateway(
            bit_rate=125000, extra=f"[failsafe]\nreference_max_age_ms = {MAX_AGE_MS}\n", options=["--trace", self.trace]))
        self.written = os.path.join(folder, "written")
        with open(self.written, "wb") as output:
            self.writer = subprocess.Popen(
                [os.environ["STAMPED_WRITER"], str(self.gateway.domain), self.gateway.bus, "5", "1"], stdout=output)
        self.addCleanup(self.end_writer)

    def end_writer(self):
        self.writer.kill()
        self.writer.wait(LONG)

    def written_by(self):
        """When each value had surely been written: the writer may be held up between its clock and its write."""
        with open(self.written, encoding="ascii") as file:
            return dict(map(int, line.split()) for line in file if line.endswith("\n"))

    def wait_released(self):
        self.gateway.wait_status("fresh values are released",
                                 lambda status: status["reference_release"][0]["state"] == "released")

    def suspend(self, seconds):
        self.gateway.process.send_signal(signal.SIGSTOP)
        began = time.monotonic()
        time.sleep(seconds)  # how long it is suspended
        self.gateway.process.send_signal(signal.SIGCONT)
        return began * 1000, time.monotonic() * 1000

    def test_nothing_old_is_released(self):
        self.wait_released()
        suspended = []
        for turn in range(ROUNDS):
            suspended.append(self.suspend(length(turn)))
            time.sleep(0.3)  # what waited is released by then, if at all
            if turn % 10 == 9:
                self.wait_released()
        self.wait_released()
        self.assertEqual(self.gateway.stop(), 0)
        self.end_writer()
        written = self.written_by()
        telegrams = list(released(self.trace))
        ages = [(at, at - written[value]) for at, value in telegrams]
        old = [(at, age) for at, age in ages if age > ALLOWED_MS]
        oldest = max(age for _, age in ages)
        print(f"{ROUNDS} suspensions, {len(telegrams)} telegrams, {len(old)} with old values, the oldest of {oldest} ms, "
              f"{MAX_AGE_MS} ms are allowed")
        fresh_after = sum(any(end < at < end + 300 and value > end for at, value in telegrams) for _, end in suspended)
        print(f"fresh values within 300 ms after {fresh_after} of them")
        self.assertEqual(old, [])
        # Not by keeping everything back: what is shorter than the limit and the lease changes nothing.
        self.assertGreater(fresh_after, 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)

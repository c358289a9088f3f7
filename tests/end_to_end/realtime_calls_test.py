"""System calls of the realtime thread of a running daemon: how many in an interval, and which.

Run it by hand to see the figures: ctest --preset dev -R realtime_calls -V
"""

import sys
import unittest

from gateway import LONG, OWN_TIME, Gateway
from realtime_calls import CannotTrace, Counts, count_calls

BIT_RATE = 250000  # intervals of 4 ms: tracing takes time for each call
INTERVAL = 0.004
MOST = 12  # half of the intervals
MOST_IN_ONE = 16  # 8 wake-ups, each of which may find that the gateway has taken all and is to be woken again


class Counting(unittest.TestCase):
    def test_intervals_are_cut_where_the_thread_rests(self):
        # Three calls at 0.9, 1.0 and 1.1 ms of each interval of 4 ms: the cut must not fall between them.
        calls = [(100 + n * 0.004 + phase, "sleep") for n in range(50) for phase in (0.0009, 0.0010, 0.0011)]
        counts = Counts(calls, INTERVAL)
        self.assertEqual(counts.intervals, 48)
        self.assertEqual(counts.of_interval, [3] * 48)
        self.assertEqual(counts.by_name, {"sleep": 144})


class RealtimeCalls(unittest.TestCase):
    def test_no_interval_takes_more_than_documented_and_none_waits_for_a_lock(self):
        with Gateway(slaves=4, bit_rate=BIT_RATE) as gateway:
            writer = gateway.start("set", "target=1", "4=50")
            try:
                counts = count_calls(gateway.process.pid, INTERVAL)
            except CannotTrace as reason:
                self.skipTest(str(reason))
            finally:
                writer.terminate()
                writer.communicate(timeout=LONG)
        print(counts.text())
        self.assertGreater(counts.intervals, 100)
        self.assertLessEqual(counts.median, MOST, counts.text())
        # A computer that stalls moves calls from one interval to the next, so that no single one is judged there.
        self.assertLessEqual(sum(counts.of_interval), MOST * counts.intervals, counts.text())
        if OWN_TIME:
            self.assertLessEqual(max(counts.of_interval), MOST_IN_ONE, counts.text())
        self.assertEqual(set(counts.by_name) - {"clock_nanosleep", "write"}, set(), counts.text())


if __name__ == "__main__":
    program = unittest.main(exit=False)
    skipped = program.result.skipped
    if program.result.wasSuccessful() and skipped:
        print(f"skipped: {skipped[0][1]}")
        sys.exit(77)
    sys.exit(0 if program.result.wasSuccessful() else 1)

"""The realtime thread on a real CAN socket: its SYNC neither drifts nor bunches up."""

import os
import sys

from canline import SYNC, Candump, Line
from gateway import wait_for

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "bench"))
import sync_analysis  # noqa: E402

INTERVAL = 8_000_000  # ns
EDGES = 1250  # 10 s


class Realtime(Line):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        # Reference values in every interval, so that slaves answer and every slot is used.
        cls.writer = cls.enterClassContext(cls.daemon.writer("0=1000", "4=50"))

    def test_sync_keeps_the_grid_and_never_comes_twice_in_a_slot(self):
        with Candump() as log:
            times = wait_for("ten seconds of SYNC", lambda: t if len(t := log.times_of(SYNC)) >= EDGES else None)
        self.assertEqual(sync_analysis.bunched(times, INTERVAL), 0)
        growth = sync_analysis.phase_growth(times, INTERVAL)
        print(f"phase moved {growth / 1000:.0f} us in {len(times)} edges, {sync_analysis.skipped(times, INTERVAL)} skipped, "
              f"shortest step {sync_analysis.shortest(times) / 1000:.0f} us")
        # A timer that is armed anew each time moves by its lateness each time: a hundred intervals here.
        self.assertLess(abs(growth), INTERVAL / 4)

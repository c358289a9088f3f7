"""The realtime thread on a real CAN socket: its SYNC neither drifts nor bunches up, and its priority keeps answers in time."""

import json
import os
import sys
import unittest

from canline import CANSYNC, INTERFACE, SYNC, Candump, Line, Process, create_interface
from gateway import wait_for
from slave_pair import MasterOfOne, Slave

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


# Another realtime program: it takes the processor for 5 of 7 ms.
OTHER = """
import os, time
os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(30))
while True:
    end = time.monotonic() + 0.005
    while time.monotonic() < end:
        pass
    time.sleep(0.002)
"""


class WithPriority(Slave):
    def __init__(self, priority):
        self.priority = priority
        super().__init__(INTERFACE)

    def role(self):
        return f"[realtime]\npriority = {self.priority}\n{super().role()}"

    def releases(self):
        """Keeps releasing actual values; a context manager."""
        return Process(CANSYNC, "--domain", self.domain, "--bus", self.bus, "slave", "actual", "0=1000", "4=7", "--rate", 20)

    def answers_in_time(self):
        """What `doctor` says of them, once many were sent while the other program ran."""
        sent = self.wait_status("it sends", lambda s: s["actual_sent"][0])["actual_sent"][0]
        with Process(sys.executable, "-c", OTHER):
            self.wait_status("many are sent or late", lambda s: s["actual_sent"][0] + s["actual_late"][0] > sent + 100)
        findings = [json.loads(line) for line in self.run("doctor", "--json").stdout.splitlines()]
        return next(one for one in findings if one["topic"] == "answers in time")


class Answers(unittest.TestCase):
    def in_time(self, priority):
        with WithPriority(priority) as slave, MasterOfOne(0) as master, \
                master.writer("0=1000", "4=50"), slave.releases():
            found = slave.answers_in_time()
            print(f"priority {priority}: {found['found']}")
            return found

    def test_the_remedy_of_doctor_helps(self):
        create_interface()
        late = self.in_time(priority=0)
        self.assertEqual(late["level"], "warning")
        self.assertIn("give the realtime thread a priority", late["remedy"])
        self.assertEqual(self.in_time(priority=60)["level"], "ok")

"""The master dies: nothing is left that repeats its telegrams."""

import re
import time
import unittest

from canline import Candump, Master, Simulator, Wire, create_interface
from gateway import wait_for

MARK = "1FFFFFF1#"  # nobody takes it; it shows where in the log the daemon was dead
OBSERVED = 2  # seconds: 250 intervals


class DaemonKilled(unittest.TestCase):
    def setUp(self):
        create_interface()

    def test_no_telegram_follows(self):
        with Simulator(slaves="0-0"), Master(slaves=1) as daemon, Wire() as wire, Candump() as log:
            daemon.wait_active()
            writer = self.enterContext(daemon.writer("0=5000", "4=7", "--rate", 20))
            for identifier in ("080", "10", "18"):
                wait_for(f"{identifier} on the bus", lambda prefix=identifier: any(
                    frame.startswith(prefix) for frame in log.frames()))
            daemon.program.kill()
            wire.send(MARK)
            log.wait_for_frame(MARK)
            self.assertIsNone(writer.process.poll(), "values are still given: " + writer.text())
            deadline = time.monotonic() + OBSERVED
            while time.monotonic() < deadline:
                wire.receive(max(0.001, deadline - time.monotonic()))
            frames = log.frames()
            after = frames[frames.index(MARK) + 1:]
            # The drives may still answer what the master sent last: 300..31F and 380..39F, their actual values.
            self.assertEqual([frame for frame in after if not re.match("3[0189]", frame)], [])
            self.assertLess(len(after), 3)


if __name__ == "__main__":
    unittest.main(verbosity=2)

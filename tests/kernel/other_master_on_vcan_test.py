"""Our daemon beside a master that is not ours, on a bus of a real kernel: it sends nothing while the other one is there."""

import os
import time
import unittest

from canline import INTERFACE, Candump, Master, Process, Simulator, create_interface
from gateway import ACTIVE, wait_for

DEBIAN_PYTHON = "/usr/bin/python3"  # it alone sees Debian's package python3-can
OTHER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "other_master.py")
QUIET = 3  # seconds that another master must have been quiet
LISTEN = 1  # seconds, the default
ACTIVATION = "010#"  # the daemon's first frame after its SYNC; the other master sends none


class Listening(Master):
    STARTUP = ""  # the default


class OtherMaster(Process):
    """It sends when its start returns."""

    def __init__(self, seconds):
        super().__init__(DEBIAN_PYTHON, "-B", OTHER, INTERFACE, seconds)

    def start(self):
        super().start()
        self.wait_text("begun")


class BesideAnotherMaster(unittest.TestCase):
    def setUp(self):
        create_interface()
        self.bus = self.enterContext(Candump())

    def activations(self):
        return [frame for frame in self.bus.frames() if frame.startswith(ACTIVATION)]

    def assert_silent_until_quiet(self):
        """Our first frame comes when the other master's last one is 3 s ago, and not before: both use the same SYNC."""
        lines = [line.split() for line in self.bus.log()]
        ours = next(i for i, line in enumerate(lines) if line[2].startswith(ACTIVATION))
        sync = max(i for i in range(ours) if lines[i][2].startswith("080#"))
        first = float(lines[sync][0].strip("()"))
        last = float(lines[sync - 1][0].strip("()"))
        self.assertGreaterEqual(first - last, QUIET)

    def test_it_listens_before_its_first_frame(self):
        self.enterContext(Simulator())
        begin = time.time()
        with Listening() as daemon:
            daemon.wait_active()
        self.assertGreaterEqual(float(self.bus.log()[0].split()[0].strip("()")) - begin, LISTEN)

    def test_it_starts_beside_one_and_goes_on_when_that_one_has_gone(self):
        with Simulator(), OtherMaster(4) as other, Listening() as daemon:
            status = daemon.wait_status("the other master is seen", lambda s: s["second_master"])
            self.assertEqual(status["state"], "silent: another master on the bus")
            self.assertNotEqual(status["second_master_since_ns"], 0)
            self.assertEqual(len(daemon.wait_event("second_master")), 1)
            self.assertIn("another master sends on this bus", daemon.run("doctor").stdout.decode())
            refused = daemon.run("mode", "setup")
            self.assertNotEqual(refused.returncode, 0)
            self.assertIn("another master sends", refused.stderr)
            missed = daemon.run("wait", "run", "--timeout", 1)
            self.assertIn("another master", missed.stderr)
            other.wait_text("ended")
            daemon.wait_active()
            self.assert_silent_until_quiet()

    def test_it_starts_by_force(self):
        with Simulator(), OtherMaster(60), Listening() as daemon:
            daemon.wait_status("the other master is seen", lambda s: s["second_master"])
            self.assertEqual(self.activations(), [])
            daemon.verb("mode", "setup", "--force")
            wait_for("the daemon's activation", self.activations)

    def test_it_waits_for_a_command_when_it_is_configured_so(self):
        class Waiting(Master):
            STARTUP = 'listen_ms = 10\nafter_other_master = "command"\n'

        with Simulator(), OtherMaster(4) as other, Waiting() as daemon:
            other.wait_text("ended")
            daemon.wait_status("the other master has gone", lambda s: not s["second_master"] and s["second_master_frames"])
            self.assertEqual(daemon.status()["state"], "waiting for a command: another master was on the bus")
            self.assertEqual(self.activations(), [])
            daemon.verb("mode", "setup")
            wait_for("the daemon's activation", self.activations)

    def test_in_run_it_stops_when_it_is_configured_so(self):
        class Stopping(Master):
            STARTUP = 'listen_ms = 10\non_second_master = "stop"\n'

        with Simulator(), Stopping() as daemon:
            daemon.wait_active()
            with OtherMaster(1) as other:
                daemon.wait_status("it has stopped", lambda s: s["option_status"] != ACTIVE)
                other.wait_text("ended")
            daemon.wait_active()


if __name__ == "__main__":
    unittest.main()

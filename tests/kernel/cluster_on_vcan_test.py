"""A cluster of ours between our master above, on vcan0, and simulated drives below, on vcan1."""

import copy
import os
import signal
import tempfile
import time
import unittest

from canline import (BIT_RATE, INTERFACE, LONG, SYNC, Candump, Master, Simulator, create_interface,
                     delete_interface, ip)
from gateway import ACTIVE, wait_for
from line_judge import Judge

ABOVE, BELOW = INTERFACE, "vcan1"
NUMBER = 5  # of the gateway above
DRIVES = 2  # below
WINDER = 101  # CANsync number of drive 1
HOLDOVER = 0.5  # seconds
# us: one processor serves both buses and whoever looks on.
TOLERANCE = 500


class MasterAbove(Master):
    """It expects the gateway alone."""

    def role(self):
        return super().role() + f"[[slave]]\nnumber = {NUMBER}\n"


class Cluster(Master):
    """Below, it is one."""

    PROTOCOL = "cansync-cluster"

    def on_interface(self):
        return ""

    def role(self):
        return f"""[upper.bus]
interface = "{ABOVE}"
[upper.sync]
input = "can"
can_identifier = 0x{SYNC}
holdover_ms = {round(HOLDOVER * 1000)}
[upper.slave]
number = {NUMBER}
lock_time_ms = 50
missing_references = 0
[lower.bus]
interface = "{BELOW}"
[lower.startup]
listen_ms = 10
[lower.sync]
output = "can"
can_identifier = 0x{SYNC}
[[sub_slave]]
number = {WINDER}
slave = 1
[[lead]]
number = 4
value = 0
""" + "".join(f"[[lower.slave]]\nnumber = {drive}\n" for drive in range(DRIVES))

    def level(self, name):
        """One of its two buses, as a daemon of its own."""
        view = copy.copy(self)
        view.bus = f"{self.bus}.{name}"
        view.environment = dict(self.environment, CANSYNC_BUS=view.bus)
        return view


class ClusterOnVcan(unittest.TestCase):
    """One set of daemons for all tests: each leaves both levels in active operation."""

    @classmethod
    def setUpClass(cls):
        for interface in (ABOVE, BELOW):
            create_interface(interface)
        cls.addClassCleanup(delete_interface, BELOW)
        cls.enterClassContext(Simulator(interface=BELOW, slaves=f"0-{DRIVES - 1}"))
        cls.master = cls.enterClassContext(MasterAbove(0, ABOVE))
        cls.cluster = cls.enterClassContext(Cluster(DRIVES))
        cls.upper, cls.lower = cls.cluster.level("upper"), cls.cluster.level("lower")

    def setUp(self):
        self.both_levels_active()

    def both_levels_active(self):
        self.upper.wait_status("the gateway follows the SYNC above", lambda s: s["synchronized"])
        self.lower.wait_active()
        self.master.wait_status("the gateway is synchronized, says the master above",
                                lambda s: s["option_status"] == ACTIVE and s["slaves_synchronized"] == 1 << NUMBER)

    def edges(self, log):
        return len(log.times_of(SYNC))

    def read_winder(self, *more):
        return self.master.run("read", NUMBER, 103, "--sub-slave", WINDER, *more)

    def parameter_passes(self):
        wait_for("a parameter of the drive below is read from above",
                 lambda: (r := self.read_winder()).returncode == 0 and b" 0x0001" in r.stdout)

    def test_a_parameter_below_is_read_and_written_from_above(self):
        self.parameter_passes()
        wait_for("it is written", lambda: self.master.run("write", NUMBER, 1000, 77, "--sub-slave", WINDER).returncode == 0)
        wait_for("the drive has it",
                 lambda: (r := self.lower.run("read", 1, 1000)).returncode == 0 and b" 0x004D" in r.stdout)

    def transfer(self, verb, *arguments):
        return self.master.start(verb, NUMBER, "0x200", *arguments, "--sub-slave", WINDER)

    def test_blocks_go_down_and_come_up_and_a_cancelled_one_ends_below_too(self):
        with tempfile.TemporaryDirectory() as folder:
            given, taken, never = (os.path.join(folder, name) for name in ("given", "taken", "never"))
            with open(given, "wb") as file:
                file.write(bytes(range(256)))
            with self.transfer("download", given) as download:
                self.assertEqual(download.wait(LONG), 0)
            self.lower.wait_status("the status has come to its end, too", lambda s: s["open_transfers"] == 0)
            with self.transfer("upload", 60000, never) as cancelled:
                self.lower.wait_status("it is open below", lambda s: s["open_transfers"] == 1)
                cancelled.send_signal(signal.SIGINT)
                self.assertEqual(cancelled.wait(LONG), 7)
            self.lower.wait_status("nothing of it is left below", lambda s: s["open_transfers"] == 0)
            self.assertFalse(os.path.exists(never))
            with self.transfer("upload", 256, taken) as upload:
                self.assertEqual(upload.wait(LONG), 0)
            with open(taken, "rb") as file:
                self.assertEqual(file.read(), bytes(range(256)))

    def test_a_reference_value_above_is_one_below_in_its_interval(self):
        with Candump(ABOVE) as above, Candump(BELOW) as below:
            writer = self.master.start("set", "0=74565", "--rate", 20)
            try:
                above.wait_for_frame(f"10{NUMBER}#4523010000000000")
                wait_for("it is on the bus below", lambda: [f for f in below.frames() if f[:2] == "18" and "#45230100" in f])
            finally:
                writer.terminate()
                writer.communicate(timeout=LONG)
        for log in (above, below):
            lines = log.log()
            first = next(n for n, line in enumerate(lines) if line.endswith(f" {SYNC}#"))  # it began in the middle
            judge = Judge(lines[first:], BIT_RATE, TOLERANCE)
            print(f"{log.interface}: {judge.count}, {len(judge.wrong)} wrong", flush=True)
            self.assertEqual(judge.wrong, [])

    def test_the_bus_below_goes_and_comes_back(self):
        ip("link", "set", BELOW, "down")
        try:
            self.lower.wait_status("it is down", lambda s: s["link_state"] == "down")
            wait_for("who asks above gets an error, and no silence", lambda: self.read_winder().returncode == 4)
            self.assertTrue(self.upper.status()["synchronized"], "the bus above goes on")
        finally:
            ip("link", "set", BELOW, "up")
        self.both_levels_active()
        self.parameter_passes()

    def test_an_adapter_below_that_comes_and_goes_leaves_the_level_above_alone(self):
        process, lost = self.cluster.program.process.pid, len(self.master.events("slave_lost"))
        gaps = (0.1, 0.3, 0.1, 1, 3)  # seconds
        missing = len(self.lower.events("interface_missing"))
        for count, gap in enumerate(gaps, 1):
            delete_interface(BELOW)
            time.sleep(gap)
            create_interface(BELOW)
            wait_for("it was seen", lambda count=count: len(self.lower.events("interface_missing")) == missing + count)
            self.both_levels_active()
        self.assertEqual(len(self.master.events("slave_lost")), lost, "the gateway answers above all the time")
        self.assertEqual(self.lower.wait_status("a status", lambda status: True)["process"], process)
        self.parameter_passes()

    def test_the_sync_above_goes_and_comes_back(self):
        losses = len(self.upper.events("sync_lost"))
        self.master.verb("mode", "stop", "--yes")
        wait_for("the gateway tells it", lambda: len(self.upper.events("sync_lost")) > losses)
        self.lower.wait_status("the bus below is stopped", lambda s: s["option_status"] != ACTIVE)
        with Candump(BELOW) as log:
            wait_for("it stays so", lambda: self.upper.status()["sync_state"] == "lost")
            self.assertEqual(self.edges(log), 0)
        self.master.verb("mode", "restart", "--yes")
        self.both_levels_active()
        self.parameter_passes()

    def test_the_master_above_dies_and_comes_back(self):
        losses = len(self.upper.events("sync_lost"))
        self.master.restart()
        # It is there again before the holdover is over, or after it.
        self.both_levels_active()
        print(f"SYNC lost meanwhile: {len(self.upper.events('sync_lost')) - losses}", flush=True)
        self.parameter_passes()

    def test_the_gateway_dies_and_comes_back(self):
        self.cluster.program.kill()
        self.master.wait_event("slave_lost")
        self.cluster.program.start()
        self.both_levels_active()
        self.parameter_passes()

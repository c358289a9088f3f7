"""Our master daemon against our slave daemon on one bus: what they say of it, and the line judged by the manual's rules."""

import contextlib
import json
import re

from canline import BIT_RATE, LONG, SYNC, Candump, Daemon, Master
from gateway import wait_for
from line_judge import Judge

NUMBER = 1  # of the slave
# The master expects this slave alone, and its cursors ask number 0, too, which nobody has.
MASTER = f"[[slave]]\nnumber = {NUMBER}\n"
SLAVE = f"""[sync]
input = "can"
can_identifier = 0x{SYNC}
greatest_step_ns = 50000
[slave]
number = {NUMBER}
lock_time_ms = 50
missing_references = 0
"""
LOCKED = f"58{NUMBER}#012D..[89A-F].0000"  # the status word of a slave that is synchronized


class MasterOfOne(Master):
    def role(self):
        return super().role() + MASTER


class Slave(Daemon):
    PROTOCOL = "cansync-slave"

    def role(self):
        return SLAVE


class SlavePair:
    """A test for a class that says on which `interfaces` (of master and slave) the daemons are, and makes them ready."""

    interfaces = ()
    # us: one processor serves both daemons and whoever looks on.
    tolerance = 0

    def test_master_and_slave(self):
        with Candump(self.interfaces[0]) as log:
            self.log = log
            with Slave(self.interfaces[1]) as self.slave, MasterOfOne(0, self.interfaces[0]) as self.master:
                self.set_up()
                with self.running(self.master, "set", "0=74565", "1=-2", "4=0x01020304", "5=1", "--rate", 20):
                    self.reference_values_reach_the_slave()
                    with self.running(self.slave, "slave", "actual", "0=1000", "1=-3", "4=7", "--rate", 20):
                        self.actual_values_reach_the_master()
                    self.parameters()
                status = self.settled_status()
            self.judged(Judge(log.log(), BIT_RATE, self.tolerance), status)

    @contextlib.contextmanager
    def running(self, daemon, *arguments):
        process = daemon.start(*arguments)
        try:
            yield
        finally:
            process.terminate()
            process.communicate(timeout=LONG)

    def wait_for_match(self, pattern):
        wait_for(f"{pattern} on the bus", lambda: [frame for frame in self.log.frames() if re.fullmatch(pattern, frame)])

    def settled_status(self):
        """The slave's status, once it counts every actual value: it comes later than they do."""
        before = None

        def settled():
            nonlocal before
            last, before = before, self.slave.status()
            both = last and before and last["interval"] != before["interval"]
            return both and last["actual_sent"] == before["actual_sent"] and before

        return wait_for("the status has caught up", settled)

    def since_set_up(self):
        return [frame for frame in self.log.frames() if frame != f"{SYNC}#"]

    def set_up(self):
        wait_for("the slave says that it is synchronized", lambda: (s := self.slave.status()) and s["synchronized"])
        self.master.wait_status("the master says so, too", lambda s: s["slaves_synchronized"] == 1 << NUMBER)
        self.log.wait_for_frame(f"50{NUMBER}#712D0000")  # element 7 of parameter 301, sub-slave 0
        self.wait_for_match(LOCKED)
        frames = self.since_set_up()
        self.assertEqual(frames[0], "010#FFFFFFFF02010000", "action 2 with data byte 1, to every slave")
        self.assertFalse([frame for frame in frames if frame[0] in "13"], "no process data before reference values are given")

    def reference_values_reach_the_slave(self):
        self.log.wait_for_frame(f"10{NUMBER}#45230100FEFFFFFF")
        self.log.wait_for_frame("180#0403020101000000")
        wanted = [74565, 0xFFFFFFFE, 0x01020304, 1]

        def received():
            result = self.slave.run("slave", "references", "--json")
            raw = self.objects_of(result)[0]["raw"] if result.returncode == 0 else []
            return raw[0:2] + raw[4:6] == wanted

        wait_for("the slave's application sees the reference values", received)

    @staticmethod
    def objects_of(result):
        return [json.loads(line) for line in result.stdout.splitlines()]

    def actual_values_reach_the_master(self):
        self.log.wait_for_frame(f"30{NUMBER}#E8030000FDFFFFFF")
        self.log.wait_for_frame(f"38{NUMBER}#0700000000000000")
        watched = self.master.objects("watch", NUMBER, "--count", 1)[0]["values"]
        found = {value["value"]: value["raw"] for value in watched}
        self.assertEqual([found[0], found[1], found[4]], [1000, -3, 7])

    def parameters(self):
        """One that the slave has, and one that it cannot answer."""
        def read():
            result = self.master.run("read", NUMBER, 301, "--json")
            return result.returncode == 0 and self.objects_of(result)[0]["value"] == 0x8000

        wait_for("the status word is read", read)
        wait_for("parameter 1000 is refused", lambda: self.master.run("read", NUMBER, 1000).returncode == 4)
        self.log.wait_for_frame(f"50{NUMBER}#73E80000")
        self.wait_for_match(f"58{NUMBER}#23E8F[AB]FF0000")  # ERR and its code

    def judged(self, judge, status):
        print(f"frames: {judge.count}; us from WRC1 to RDC1: {sorted(judge.ways[0])}", flush=True)
        self.assertEqual(judge.wrong, [])
        self.assertEqual([judge.count["RDC1"], judge.count["RDC2"]], status["actual_sent"])
        self.assertGreater(judge.count["WRC1"], 2 * judge.count["RDC1"], "what is not released is not sent")

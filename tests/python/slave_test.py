"""The application behind a real daemon that is a slave, in Python; with it the C face of a slave."""

import os
import signal
import subprocess
import sys
import time
import unittest

from interrupt import SOON, seconds_to_end
from line import LONG, ROOT, cansync

from cansync_slave_service_test import Slave, jobs, wait_for  # noqa: E402  (its folder is named by `line`)
from verb_case import DaemonTest  # noqa: E402
from cansync import Mode, SlaveEventKind as Kind  # noqa: E402

ASKED = jobs("parameter = 400", "parameter = 400\nvalue = 99", "parameter = 401", "control_word = 15",
             "action = 200\ndata_word = 77\ndata_byte = 3", "bytes = 40\ndownload = true", "bytes = 12")


class Behind(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = cls.enterClassContext(Slave("[[parameter]]\nnumber = 401\nvalue = 7\n" + ASKED, extra='target = "none"'))
        place = cls.daemon.place
        cls.slave = cls.enterClassContext(cansync.connect_slave(place.bus, domain=place.domain, timeout=LONG))

    def until(self, what, condition):
        """The first event that fits; every job and block meanwhile is answered."""
        for _ in range(100_000):
            event = self.slave.receive(LONG)
            self.assertIsNotNone(event, what)
            if event.kind == Kind.PARAMETER:
                if event.number == 401:
                    self.slave.refuse(event, 0xFFFC)
                else:
                    self.slave.answer(event, 0x1234)
            elif event.kind == Kind.BLOCK:
                self.slave.allow(event, b"" if event.download else bytes(range(12)))
            elif event.kind == Kind.BLOCK_DATA:
                self.slave.take(event)
            if condition(event):
                return event
        self.fail(what)

    def until_on_the_bus(self, what, identifier, *data):
        """Serves until all of these telegrams have been sent; the trace is long, so it is looked at now and then."""
        def sent():
            end = time.monotonic() + 0.2
            self.until(what, lambda event: time.monotonic() > end)
            return set(data) <= set(self.daemon.frames(identifier))
        wait_for(what, sent)

    def test_everything_that_a_slave_hears_and_answers(self):
        slave = self.slave
        self.assertEqual(slave.state().option_status, 3)
        with self.assertRaises(cansync.Refused) as refused:
            slave.set_mode(Mode.RUN)
        self.assertEqual(refused.exception.cause, cansync.Cause.WRONG_STATE)
        slave.set_mode(Mode.SETUP)
        slave.set_mode(Mode.RUN)
        self.assertEqual(slave.state().option_status, 0x20)

        slave.set_mapping([1, 3, 5, 7, 17, 19, 21, 23], [1, 3, 0, 0, 17, 0, 0, 0])
        self.assertEqual(slave.state().actual_mapping, (1, 3, 0, 0, 17, 0, 0, 0))
        slave.listen(7, [1, 3, 0, 0, 0, 0, 0, 0])
        with self.assertRaises(cansync.Refused):
            slave.listen(5, [1, 3, 0, 0, 0, 0, 0, 0])

        came = self.until("reference values", lambda event: event.kind == Kind.REFERENCES and event.arrived == 1)
        self.assertEqual(came.values[1], 1000)
        word = self.until("a control word", lambda event: event.kind == Kind.CONTROL_WORD)
        self.assertEqual(word.data_word, 15)
        action = self.until("an action", lambda event: event.kind == Kind.ACTION)
        self.assertEqual((action.number, action.data_byte, action.data_word), (200, 3, 77))

        slave.take_over([400, 401], blocks=True)
        written = self.until("a write", lambda event: event.kind == Kind.PARAMETER and event.write)
        self.assertEqual((written.number, written.value, written.element), (400, 99, 7))
        self.until("it was answered", lambda event: event.kind == Kind.PARAMETER_END and event.answered)
        block = self.until("a download", lambda event: event.kind == Kind.BLOCK_DATA)
        self.assertEqual(block.data, bytes(range(40)))
        self.until("a block moved", lambda event: event.kind == Kind.BLOCK_END and event.answered)
        self.until_on_the_bus("both parameters are answered", 0x585, "019034120000", "2191FCFF0000")
        self.assertIn("python", slave.state().application)

        slave.release(1, [0x00112233], wait_intervals=1000)
        self.until_on_the_bus("the actual value is sent", 0x305, "3322110000000000")
        with self.assertRaises(cansync.Invalid):
            slave.release(3, [1])
        with self.assertRaises(cansync.Invalid):
            slave.take_over([4096])
        slave.take_over()
        self.daemon.wait_for_status("it is given back", lambda status: status["application"] == "")

    def test_the_example_is_a_local_drive(self):
        with Slave(jobs("parameter = 1000\nvalue = 9", "parameter = 1001", "parameter = 1001\nvalue = 1")) as daemon:
            daemon.wait_for_status("it is active", lambda status: status["option_status"] == 0x20)
            place = daemon.place
            done = subprocess.run([sys.executable, "-B", ROOT / "tools/examples/local_drive.py", str(place.domain), place.bus, "3"],
                                  capture_output=True, text=True, timeout=LONG, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertRegex(done.stdout, r"^[1-9]\d* reference values, [1-9]\d* parameter jobs, position [1-9]\d*\n$")
            self.assertIn("23E9FCFF0000", daemon.answers())

    def test_ctrl_c_ends_the_wait_for_a_daemon_that_stands_still(self):
        with Slave("", extra='target = "none"') as daemon, \
                cansync.connect_slave(daemon.place.bus, domain=daemon.place.domain, timeout=LONG) as slave:
            slave.set_mode(Mode.SETUP)
            os.kill(daemon.process.pid, signal.SIGSTOP)
            try:
                self.check_waits(slave)
            finally:
                os.kill(daemon.process.pid, signal.SIGCONT)

    def check_waits(self, slave):
        """Ctrl-C ends each."""
        waits = {"set_mode": lambda: slave.set_mode(Mode.RUN), "set_mapping": lambda: slave.set_mapping([0] * 8, [0] * 8),
                 "listen": lambda: slave.listen(7, [1, 3, 0, 0, 0, 0, 0, 0]), "receive": lambda: self.receive_for_ever(slave)}
        for name, wait in waits.items():
            took = [seconds_to_end("_call", wait) for _ in range(5)]  # on a busy machine the quickest tells
            self.assertLess(min(took), SOON, f"{name}: {took}")

    def receive_for_ever(self, slave):
        """What came before the daemon stood still is there at once."""
        while True:
            slave.receive(LONG)

    def test_without_a_daemon_it_says_where_it_looked(self):
        with self.assertRaises(cansync.NotConnected) as nowhere:
            cansync.connect_slave("nobody", domain=self.daemon.place.domain, timeout=0.1)
        self.assertIn("nobody", str(nowhere.exception))


class OfACluster(DaemonTest):
    """The slave on the upper bus of a cluster is as its file says."""

    CONFIG = """
[bus]
protocol = "cansync-cluster"
name = "{bus}"
bit_rate = 250000
[dds]
domain = {domain}
[[lower.slave]]
number = 0
[upper.slave]
number = 5
"""
    REFERENCES = [1, 3, 5, 7, 17, 19, 21, 23]

    def connected(self):
        return cansync.connect_slave(f"{self.place.bus}.upper", domain=self.place.domain, timeout=LONG)

    def refused(self, request):
        with self.assertRaises(cansync.Refused) as refused:
            request()
        self.assertEqual(refused.exception.cause, cansync.Cause.WRONG_STATE)
        return str(refused.exception)

    def test_its_mapping_is_changed_in_the_file_and_its_mode_by_nobody(self):
        with self.connected() as slave:
            wanted = (1, 3, 0, 0, *slave.state().actual_mapping[4:])
            self.assertIn("only reset_can is taken", self.refused(lambda: slave.set_mode(Mode.SETUP)))
            slave.set_mode(Mode.RESET_CAN)
            for request in (lambda: slave.set_mapping(self.REFERENCES, wanted), lambda: slave.listen(7, wanted)):
                self.assertIn("change [upper.slave] or [[upper.monitored]]", self.refused(request))
        with open(self.config, "a", encoding="utf-8") as file:
            file.write("actual_registers_1 = [1, 3, 0, 0]\n[[upper.monitored]]\nnumber = 7\n")
        self.restart()
        with self.connected() as slave:
            self.assertEqual(slave.state().actual_mapping, wanted)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])

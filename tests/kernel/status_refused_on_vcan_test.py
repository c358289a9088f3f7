"""Drives that refuse the parameter under which the master looks for their status word."""

import unittest

from canline import Candump, Master, Simulator, create_interface
from gateway import wait_for

WRONG = 77  # a parameter that the drives have not got; their status word is 301
REMEDY = "status_parameter"


class WrongStatusParameter(Master):
    STARTUP = f"{Master.STARTUP}status_parameter = {WRONG}\n"


class StatusRefused(unittest.TestCase):
    def test_it_is_told_by_an_event_the_slaves_and_the_doctor(self):
        create_interface()
        with Candump() as log, Simulator(slaves="0-0"), WrongStatusParameter(1) as daemon:
            event = daemon.wait_event("slave_status_refused")[0]
            # Element 7 of parameter 77; error bit, no such parameter.
            log.wait_for_frame("500#704D0000")
            log.wait_for_frame("580#204DFBFF0000")
            self.assertEqual((event["slave"], event["severity"]), (0, "error"))
            self.assertIn(REMEDY, event["text"])
            slave = wait_for("its state has the error", lambda: (s := daemon.objects("slaves")[0])["status_error"] and s)
            self.assertEqual((slave["status_error"], slave["synchronized"]), (0xFFFB, False))
            shown = daemon.run("slaves")
            self.assertIn("error 0xFFFB", shown.stdout.decode())
            self.assertIn(REMEDY, shown.stderr)
            found = [line for line in daemon.run("doctor").stdout.decode().splitlines() if "status word" in line]
            self.assertTrue([line for line in found if "0xFFFB" in line], found)

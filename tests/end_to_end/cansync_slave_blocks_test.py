"""Programs behind a real daemon that is a slave: every function block of a slave, and the example of a local drive."""

import os
import re
import subprocess
import time
import unittest

from cansync_slave_service_test import Slave, jobs
from gateway import LONG

# The daemon waits for its start, and its mapping has values 0 and 1 the other way round: both are the program's. The
# simulated master sends by that mapping.
WITHOUT_START = """
target = "none"
reference_registers_1 = [5, 7, 1, 3]
"""
TABLE = "[[parameter]]\nnumber = 400\nmaximum = 100\n"
ASKED = ("parameter = 400", "parameter = 400\nvalue = 99", "control_word = 15", "action = 200\ndata_word = 77",
         "bytes = 40\ndownload = true", "bytes = 40")


class Programs(unittest.TestCase):
    def finish(self, slave, program, *arguments):
        """What it printed."""
        result = subprocess.run([program, str(slave.place.domain), slave.place.bus, *map(str, arguments)],
                                capture_output=True, text=True, timeout=LONG)
        self.assertEqual(result.returncode, 0, f"{result.stdout}\n{result.stderr}")
        return result.stdout

    def example(self, slave):
        return self.finish(slave, os.path.join(os.environ["EXAMPLES"], "example_local_drive"), 3)

    def test_every_block_of_a_slave(self):
        with Slave(TABLE + jobs(*ASKED), extra=WITHOUT_START) as slave:
            slave.wait_for_status("it waits", lambda status: status["option_status"] == 3)
            out = self.finish(slave, os.environ["SLAVE_BLOCKS"], LONG // 2).splitlines()
            self.assertEqual(len(out), 14, out)
            before = [out.index(line) for line in ("MODE_SL waits", "MODE_SL active", "MODE_SL active again")]
            self.assertEqual(before, sorted(before))
            self.assertIn("3322110000000000", slave.frames(0x305), "RDC1 of slave 5 with the block's mapping")
            status = slave.status()
            self.assertEqual(status["reference_mapping"], [1, 3, 5, 7, 17, 19, 21, 23])
            self.assertEqual(status["actual_mapping"], [1, 3, 0, 0, 17, 0, 0, 0])
            slave.wait_for_event("request_done", "slave_mapping", "slave_mode", "slave_listen")

    def test_a_local_drive_behind_the_slave(self):
        asked = jobs("control_word = 15", "parameter = 1000\nvalue = 9", "parameter = 1000", "parameter = 1001",
                     "parameter = 1001\nvalue = 1")
        with Slave(asked) as slave:
            slave.wait_for_status("it is active", lambda status: status["option_status"] == 0x20)
            # M 3.2.3.7: its time constant as it was written, and what may not be written.
            wanted = {"03E809000000", "23E9FCFF0000"}
            end = time.monotonic() + LONG
            out = self.example(slave)
            while not wanted <= set(slave.answers()) and time.monotonic() < end:  # a computer may have stood still
                out = self.example(slave)
            self.assertLessEqual(wanted, set(slave.answers()))
            told = re.fullmatch(r"(\d+) reference values, (\d+) parameter jobs, control word 0x000F, position (\d+)\n", out)
            self.assertTrue(told, out)
            self.assertGreater(int(told[1]), 50)
            self.assertGreater(int(told[2]), 3)
            self.assertGreater(int(told[3]), 0, "it has followed")


if __name__ == "__main__":
    unittest.main(verbosity=2)

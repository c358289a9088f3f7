"""The daemon as a slave answers the simulated master's parameter jobs and transfers."""

import os
import re
import subprocess
import sys
import tempfile
import unittest

from gateway import CANSYNCD, Place, end, wait_for

CONFIG = """
[bus]
protocol = "cansync-slave"
name = "{bus}"
bit_rate = 125000
[dds]
domain = {domain}
[slave]
number = 5
lock_time_ms = 50
{extra}
[sim]
trace = "{trace}"
"""

TABLE = """
[[parameter]]
number = 400
value = 7
maximum = 100
[[parameter]]
number = 401
format = "doubleword"
value = 0x12345678
access = "read_only"
"""


def jobs(*kinds):
    """What the simulated master asks again and again."""
    return "".join(f"[[sim.job]]\nnumber = {number}\nevery = 20\n{kind}\n" for number, kind in enumerate(kinds))


class Slave:
    """A daemon that is a slave beside a simulated master; a context manager."""

    def __init__(self, text, extra=""):
        self.place = Place()
        self.folder = tempfile.TemporaryDirectory(prefix="cansync_test_")
        self.trace = os.path.join(self.folder.name, "trace")
        self.config = os.path.join(self.folder.name, "bus.toml")
        with open(self.config, "w", encoding="utf-8") as file:
            file.write(CONFIG.format(bus=self.place.bus, domain=self.place.domain, trace=self.trace, extra=extra) + text)

    def __enter__(self):
        with open(os.path.join(self.folder.name, "log"), "wb") as log:
            self.process = subprocess.Popen([CANSYNCD, self.config], stdout=log, stderr=log)
        return self

    def __exit__(self, *_):
        end(self.process)
        self.folder.cleanup()

    def frames(self, identifier):
        """The data of every frame of this identifier that is in the trace so far."""
        with open(self.trace, encoding="ascii") as file:
            return re.findall(rf" {identifier:03X}#([0-9A-F]*)\n", file.read())

    def answers(self):
        return self.frames(0x585)


class ParameterTable(unittest.TestCase):
    def test_the_table_answers_without_an_application(self):
        asked = jobs("parameter = 400", "parameter = 400\nvalue = 100", "parameter = 400\nvalue = 101", "parameter = 401",
                     "parameter = 401\nvalue = 1", "parameter = 399", "bytes = 20")
        with Slave(TABLE + asked) as slave:
            # M 3.2.3.7: the value; above its maximum; a doubleword; not changeable; not available now; not possible.
            expected = {"01900700" + "0000", "01906400" + "0000", "2190FDFF" + "0000", "019178563412" + "0000",
                        "2191FCFF" + "0000", "218FFAFF" + "0000", "A0000401"}
            wait_for("all are answered", lambda: os.path.exists(slave.trace) and expected <= set(slave.answers()))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *filter(None, sys.argv[1:])])

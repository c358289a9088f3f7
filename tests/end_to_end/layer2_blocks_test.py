"""A PLC program on a bus of general frames with a real daemon: every function block of a CAN 300 PRO and of a Saia PCD."""

import json
import os
import subprocess
import tempfile
import unittest

from gateway import CANSYNCD, LONG, Place, end, wait_for

# Node 0 answers remote frames; the others send all the time, each into another service of the module.
CONFIG = """
[bus]
protocol = "layer2"
name = "{bus}"
[dds]
domain = {domain}
[send]
timeout_ms = 30000
[[receive]]
number = 0
first = 0x180
last = 0x1FF
[[node]]
number = 0
identifier = 0x123
data = [1, 2, 0xFF]
[[node]]
number = 1
identifier = 0x190
data = [5]
period_ms = 20
[[node]]
number = 2
identifier = 0x250
data = [0]
period_ms = 20
[[node]]
number = 3
identifier = 0x310
data = [0, 0x77, 0x99]
period_ms = 20
[[timer]]
number = 3
identifier = 0x80
period_us = 20000
"""


class Blocks(unittest.TestCase):
    def setUp(self):
        self.place = Place()
        folder = self.enterContext(tempfile.TemporaryDirectory())
        config = os.path.join(folder, "bus.toml")
        with open(config, "w", encoding="utf-8") as file:
            file.write(CONFIG.format(bus=self.place.bus, domain=self.place.domain))
        with open(os.path.join(folder, "log"), "wb") as log:
            daemon = subprocess.Popen([CANSYNCD, config], stdout=log, stderr=log)
        self.addCleanup(lambda: end(daemon))

    def objects(self, *arguments):
        return [json.loads(line) for line in self.place.run("can", *arguments, "--json").stdout.splitlines()]

    def status(self):
        return json.loads(self.place.run("status", "--json").stdout)

    def test_every_block_of_both_modules(self):
        result = subprocess.run([os.environ["LAYER2_BLOCKS"], str(self.place.domain), self.place.bus, str(LONG // 2)],
                                capture_output=True, text=True, timeout=LONG)
        self.assertEqual(result.returncode, 0, f"{result.stdout}\n{result.stderr}")
        self.assertEqual(len(result.stdout.splitlines()), 18, result.stdout)
        # What the program left in the daemon.
        objects = wait_for("three objects are told", lambda: len(
            found := {one["number"]: one for one in self.objects("objects")}) == 3 and found)
        self.assertEqual(objects[1]["sent"], 1)
        timer = wait_for("the timer runs", lambda: (t := self.objects("timers")[0])["running"] and t)
        self.assertEqual(timer["number"], 3)
        # CAN_TX, CAN_TXQ and CANSEND, besides what the timer and the mapping send.
        wait_for("the status counts their frames", lambda: self.status()["sent"] >= 3)
        self.assertEqual(self.place.run("can", "image").returncode, 6, "its mapping has ended with it")


if __name__ == "__main__":
    unittest.main(verbosity=2)

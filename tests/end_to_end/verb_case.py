"""A test of verbs as processes, with one daemon and its simulated drives for all tests of a class."""

import json
import os
import signal
import subprocess
import tempfile
import unittest

from gateway import BIT_RATE, CANSYNCD, LONG, Gateway, Place, end, wait_for

# Parameters of a simulated drive.
DEVICE_TYPE, CONTROL_WORD, LAST_ACTION = 100, 300, 330
BUSY, BUSY_REPLIES, NOT_AVAILABLE = 410, 411, 420
WORD, DOUBLEWORD = 1000, 1020
ALWAYS_BUSY = 0xFFFF
LAG, LONGEST_LAG = 400, 10_000
DATA = 0x100  # first start address of a drive's memory


class VerbTest(unittest.TestCase):
    SLAVES = 4
    BIT_RATE = BIT_RATE
    EXTRA = ""  # further configuration
    OPTIONS = ()  # of cansyncd

    @classmethod
    def setUpClass(cls):
        cls.gateway = cls.enterClassContext(
            Gateway(slaves=cls.SLAVES, bit_rate=cls.BIT_RATE, extra=cls.EXTRA, options=cls.OPTIONS)
        )

    def tearDown(self):
        # What a test left open or changed must not reach the next one.
        self.assertIsNone(self.gateway.process.poll(), self.gateway.log_text())

    def run_verb(self, *arguments, code=0, data=None):
        result = self.gateway.run(*arguments, data=data)
        self.assertEqual(result.returncode, code, f"{arguments}\n{result.stdout}\n{result.stderr}")
        if code == 0 and result.stdout:
            self.assertNotIn("cansync:", result.stdout.decode(errors="replace"))
        return result

    def text(self, *arguments):
        return self.run_verb(*arguments).stdout.decode()

    def fails(self, *arguments, code):
        """What it says on stderr; there must be no data."""
        result = self.run_verb(*arguments, code=code)
        self.assertEqual(result.stdout, b"")
        self.assertTrue(result.stderr.startswith("cansync: "), result.stderr)
        return result.stderr

    def json(self, *arguments, code=0):
        return self.gateway.json(*arguments, code=code)

    def one(self, *arguments, code=0):
        objects = self.json(*arguments, code=code)
        self.assertEqual(len(objects), 1, objects)
        return objects[0]

    def synchronized_slaves(self):
        """The slaves' own status, which follows the master's within a moment."""

        def look():
            slaves = self.json("slaves")
            return slaves if all(slave["responds"] and slave["synchronized"] for slave in slaves) else None

        return wait_for("every slave's status says synchronized", look)

    def interrupt(self, process, code):
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, code, err.decode())
        return out, err.decode()


class DaemonTest(unittest.TestCase):
    """With one daemon of any protocol for all tests of a class."""

    CONFIG = ""  # its file, with the places {bus} and {domain}
    FILES = {}  # beside it: contents by name

    @classmethod
    def setUpClass(cls):
        cls.place = Place()
        cls.folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        cls.config = os.path.join(cls.folder, "bus.toml")
        cls.log = os.path.join(cls.folder, "log")
        files = {"bus.toml": cls.CONFIG.format(bus=cls.place.bus, domain=cls.place.domain), **cls.FILES}
        for name, content in files.items():
            with open(os.path.join(cls.folder, name), "w", encoding="utf-8") as file:
                file.write(content)
        cls.start()
        cls.addClassCleanup(lambda: end(cls.daemon))

    @classmethod
    def start(cls):
        with open(cls.log, "ab") as log:
            cls.daemon = subprocess.Popen([CANSYNCD, cls.config], stdout=log, stderr=log)

    @classmethod
    def restart(cls):
        end(cls.daemon)
        cls.start()

    def json(self, *arguments, code=0):
        result = self.place.run(*arguments, "--json")
        self.assertEqual(result.returncode, code, result.stderr)
        return [json.loads(line) for line in result.stdout.splitlines()]

    def one(self, *arguments, code=0):
        """The only object of a verb."""
        found = self.json(*arguments, code=code)
        self.assertEqual(len(found), 1, found)
        return found[0]

    def reload_something_wrong(self):
        """The daemon is told to read a file with an unknown section; the file is as before when the test ends."""
        with open(self.config, encoding="utf-8") as file:
            before = file.read()

        def give(text):
            with open(self.config, "w", encoding="utf-8") as file:
                file.write(text)
            self.daemon.send_signal(signal.SIGHUP)

        self.addCleanup(give, before)
        give(before + "[unknown]\n")

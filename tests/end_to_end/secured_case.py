"""A daemon with DDS Security, for tests of what each role may."""

import os
import subprocess
import tempfile
import unittest

from gateway import CANSYNCD, Place, end, identities, wait_for


class SecuredCase(unittest.TestCase):
    """Has a daemon with `CONFIG`, which names {bus} and {domain}; `cansync` is a viewer until it becomes somebody else."""

    CONFIG = ""

    @classmethod
    def setUpClass(cls):
        cls.place = Place()
        folder = cls.enterClassContext(tempfile.TemporaryDirectory(prefix="cansync_security_"))
        cls.authority = identities(folder)
        config = os.path.join(folder, "bus.toml")
        with open(config, "w", encoding="utf-8") as file:
            text = cls.CONFIG.format(bus=cls.place.bus, domain=cls.place.domain)
            file.write(text.replace("[dds]\n", f'[dds]\nsecurity = "{cls.authority}/daemon"\n'))
        with open(os.path.join(folder, "log"), "wb") as log:
            daemon = subprocess.Popen([CANSYNCD, config], stdout=log, stderr=log)
        cls.addClassCleanup(lambda: end(daemon))
        cls.become("viewer")
        wait_for("the viewer sees the daemon", lambda: cls.place.run("status").returncode == 0)

    @classmethod
    def become(cls, role):
        """None: without an identity."""
        cls.place.become(role and os.path.join(cls.authority, role))

    def expect_done(self, *arguments):
        result = self.place.run(*arguments)
        self.assertEqual(result.returncode, 0, f"{arguments}: {result.stderr}")
        return result

    def expect_no_right(self, topic, role, *arguments):
        result = self.place.run(*arguments)
        self.assertNotEqual(result.returncode, 0, arguments)
        self.assertIn(f"no right to write topic {topic}; it needs the role {role}", result.stderr, arguments)

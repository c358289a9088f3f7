"""Programs that die while the daemon works for them, as whole processes."""

import os
import signal
import sys
import tempfile
import unittest

from gateway import LONG, Gateway

DATA = 0x1000


class Killed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.gateway = cls.enterClassContext(Gateway(slaves=2, options=("--set", "sim.memory_bytes=2000000")))
        cls.folder = cls.enterClassContext(tempfile.TemporaryDirectory())

    def events(self, code):
        return [event["text"] for event in self.gateway.json("events") if event["code"] == code]

    def kill_in_the_middle(self, *arguments):
        """Kills `cansync` without a word while its transfer runs; back when the daemon has noticed."""
        before = len(self.events("client_gone"))
        process = self.gateway.start_job("open_transfers", *arguments)
        process.kill()
        process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, -signal.SIGKILL)
        # DDS notices that a program is dead when its lease (5 s) is over.
        self.gateway.wait_status("its transfer has ended", lambda status: status["open_transfers"] == 0)
        found = self.events("client_gone")
        self.assertEqual(len(found), before + 1, found)
        self.assertIn("is gone; its 1 open request is cancelled", found[-1])

    def test_a_killed_upload_is_cancelled_and_the_slave_is_free(self):
        self.kill_in_the_middle("upload", 1, DATA, 1000000, os.path.join(self.folder, "cut"))
        after = os.path.join(self.folder, "after")
        (done,) = self.gateway.json("upload", 1, DATA, 600, after)
        self.assertEqual((done["result"], done["bytes"], done["repeated_blocks"]), ("done", 600, 0))

    def test_a_killed_download_is_cancelled_and_the_slave_is_free(self):
        path = os.path.join(self.folder, "big")
        with open(path, "wb") as file:
            file.write(os.urandom(200000))
        self.kill_in_the_middle("download", 0, DATA, path)
        data = os.urandom(900)
        with open(path, "wb") as file:
            file.write(data)
        (done,) = self.gateway.json("download", 0, DATA, path)
        self.assertEqual((done["result"], done["bytes"]), ("done", 900))
        back = os.path.join(self.folder, "back")
        self.gateway.json("upload", 0, DATA, 900, back)
        with open(back, "rb") as file:
            self.assertEqual(file.read(), data)

    def test_who_has_ended_is_not_counted_any_more(self):
        for _ in range(5):
            self.gateway.json("read", 0, 301)
        self.gateway.wait_status("no client is left", lambda status: status["clients"] == 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])

"""`cansync setup` at a terminal: what it asks, what stands afterwards, and that Ctrl-C leaves nothing behind."""

import os
import pty
import select
import signal
import subprocess
import tempfile
import time
import unittest

from gateway import CANSYNC, CANSYNCD, LONG

CONFIGURATION = """# A line.
[bus]
name = "can7"
interface = "can7"
bit_rate = 250000
[[slave]]
number = 3
[[slave]]
number = 5
"""


class Terminal:
    """A program on a terminal, and a person who reads and types."""

    def __init__(self, *command):
        self.end, other = pty.openpty()
        self.process = subprocess.Popen(command, stdin=other, stdout=other, stderr=other, start_new_session=True)
        os.close(other)
        self.shown = ""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait(LONG)
        os.close(self.end)

    def wait_for(self, text):
        deadline = time.monotonic() + LONG
        while text not in self.shown:
            if not select.select([self.end], [], [], max(0.0, deadline - time.monotonic()))[0]:
                raise AssertionError(f"{text!r} did not come:\n{self.shown}")
            try:
                self.shown += os.read(self.end, 4096).decode()
            except OSError as error:  # the program has ended
                raise AssertionError(f"{text!r} did not come:\n{self.shown}") from error

    def answer(self, question, text):
        self.wait_for(question)
        self.shown = ""
        os.write(self.end, (text + "\n").encode())


class Setup(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="cansync_setup_"))
        with open(os.path.join(self.folder, "can7.toml"), "w", encoding="utf-8") as file:
            file.write(CONFIGURATION)
        self.root = os.path.join(self.folder, "root")
        self.command = (CANSYNC, "setup", self.folder, "--root", self.root)

    def test_asks_for_names_sync_and_target(self):
        with Terminal(*self.command) as person:
            person.answer("Name of slave 3 [slave3]: ", "winder")
            person.answer("Name of slave 5 [slave5]: ", "")
            person.answer("Where SYNC comes out", "wire")
            person.wait_for("answer: found 'wire'; allowed: none, gpio, phc, can")
            person.answer("Where SYNC comes out", "can")
            person.answer("How far the daemon goes", "active")
            person.answer("Go on? [y/N] ", "y")
            person.wait_for("next: cansync --bus can7 doctor")
            self.assertEqual(person.process.wait(LONG), 0)
        path = os.path.join(self.root, "etc", "cansync", "can7.toml")
        with open(path, encoding="utf-8") as file:
            text = file.read()
        for line in ('name = "winder"', 'name = "slave5"', 'output = "can"', 'target = "active"'):
            self.assertIn(line + "\n", text)
        self.assertEqual(subprocess.run([CANSYNCD, "--check", path], capture_output=True, timeout=LONG, check=False).returncode, 0)

    def test_ctrl_c_and_no_leave_nothing(self):
        for end in ("Ctrl-C", "no"):
            with self.subTest(end), Terminal(*self.command) as person:
                person.answer("Name of slave 3", "winder")
                if end == "no":
                    for question in ("Name of slave 5", "Where SYNC", "How far"):
                        person.answer(question, "")
                    person.answer("Go on? [y/N] ", "")
                else:
                    person.wait_for("Name of slave 5")
                    person.process.send_signal(signal.SIGINT)
                person.wait_for("ended; nothing was written")
                self.assertEqual(person.process.wait(LONG), 7)
                self.assertFalse(os.path.exists(self.root))


if __name__ == "__main__":
    unittest.main()

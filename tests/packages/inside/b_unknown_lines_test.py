"""From the installed packages to actual values in engineering units, on lines made at random, with the service that `setup` enables.

How many lines: the file `lines` beside this one, if there is one (run.py --lines)."""

import contextlib
import os
import pathlib
import unittest

os.environ.update(CANSYNC="/usr/bin/cansync", CANSYNCD="/usr/sbin/cansyncd", CANSYNC_SIM="/usr/bin/cansync-sim")
import unknown_line  # noqa: E402: takes the programs from the environment
from machine import *  # noqa: E402

FIRST, LINES = 101, 2
MOST = 30  # seconds from `scan` to the last actual value
WRITTEN = ("/etc/cansync", "/etc/systemd/network")  # where `setup` puts files


def files():
    """{path: bytes} of all that is there."""
    return {path: path.read_bytes() for folder in WRITTEN for path in pathlib.Path(folder).rglob("*") if path.is_file()}


def restore(before):
    """Puts the files back as they were."""
    now = files()
    for path in now.keys() - before.keys():
        path.unlink()
    for path, content in before.items():
        if now.get(path) != content:
            path.write_bytes(content)


class InstalledLine(unknown_line.UnknownLine):
    def set_up(self):
        with self.timed("setup"):
            self.command("setup", self.path("line"), "--sync", "can", "--start", "active", "--yes", "--replace")
        return str(CONFIGURATION)

    @contextlib.contextmanager
    def daemon(self, configuration):
        """The service, which `setup` has started."""
        began = properties("ActiveEnterTimestampMonotonic")
        yield lambda: run("journalctl", "--no-pager", "--unit", SERVICE, "--lines=60")
        assert properties("ActiveEnterTimestampMonotonic") == began, "the service was started anew meanwhile"
        assert run("systemctl", "is-enabled", SERVICE).strip() == "enabled"


class UnknownLines(unittest.TestCase):
    def test_random_lines_are_found_set_up_and_read_in_engineering_units(self):
        asked = pathlib.Path(__file__).with_name("lines")
        lines = int(asked.read_text(encoding="ascii")) if asked.exists() else LINES
        for seed in range(FIRST, FIRST + lines):
            with self.subTest(seed=seed):
                before = files()
                try:
                    self.assertLess(unknown_line.run_line(seed, way=InstalledLine)["all"], MOST)
                finally:  # the next line is met as this one was
                    run("systemctl", "disable", "--now", SERVICE)
                    restore(before)

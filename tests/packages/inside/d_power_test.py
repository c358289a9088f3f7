"""A power cut: what was told before it is whole after it. The folder of recordings and configurations is an ext4 of its own, on a
disk whose contents are taken away at an instant, and mounted as after a boot. What Linux has not written by then is lost.

How many: the file `cuts` beside this one, if there is one (run.py --cuts)."""

import contextlib
import json
import os
import pathlib
import random
import re
import signal
import time
import tomllib
import unittest

from machine import *

STATE = pathlib.Path(f"/var/lib/cansync/{INTERFACE}")
DISK, COPY, AFTER = pathlib.Path("/tmp/disk"), pathlib.Path("/tmp/copy"), pathlib.Path("/mnt")
SIZE = 32 << 20  # bytes
CUTS = 6
KEPT = 10  # recorder.files
REGISTERS = "reference_registers_1 = [0x05, 0x{:02x}, 0, 0]"


def contents_of(path):
    """All at one instant: nothing else runs on the one processor while a thread of this priority reads."""
    descriptor = os.open(path, os.O_RDONLY)
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(99))
    try:
        return time.time(), os.read(descriptor, SIZE)
    finally:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        os.close(descriptor)


class PowerCut(unittest.TestCase):
    def setUp(self):
        run("systemctl", "stop", SERVICE)
        DISK.write_bytes(b"")
        os.truncate(DISK, SIZE)
        run("mkfs.ext4", "-q", DISK)
        run("mount", "-o", "loop", DISK, STATE)
        self.addCleanup(self.back)
        run("chown", "cansync:cansync", STATE)
        run("systemctl", "start", SERVICE)
        wait_until_active()

    @staticmethod
    def back():
        run("systemctl", "stop", SERVICE)
        run("umount", STATE)
        run("systemctl", "start", SERVICE)
        wait_until_active()

    def test_what_was_told_is_whole(self):
        asked = pathlib.Path(__file__).with_name("cuts")
        cuts = int(asked.read_text(encoding="ascii")) if asked.exists() else CUTS
        draw, since, told = random.Random(46), int(time.time()), 0
        self.texts = {CONFIGURATION.read_text(encoding="utf-8")}
        for number in range(cuts):
            with self.subTest(cut=number):
                os.kill(main_pid(), signal.SIGUSR1)
                if draw.random() < 0.5:
                    self.other_configuration(number)
                time.sleep(draw.choice((0.01, 0.1, 1, 7)) * draw.random())
                at, disk = contents_of(DISK)
                COPY.write_bytes(disk)
                before = [os.path.basename(re.search(r"(/\S+)[.]log ", entry["MESSAGE"])[1])
                          for entry in journal("EVENT=flight_recording", f"--since=@{since}")
                          if int(entry["__REALTIME_TIMESTAMP"]) < at * 1e6]
                told += len(before)
                with self.mounted():
                    self.expect_whole(before[-(KEPT - 1):])
        self.assertGreater(told, cuts)

    def other_configuration(self, number):
        text = CONFIGURATION.read_text(encoding="utf-8")
        CONFIGURATION.write_text(re.sub(r"reference_registers_1 = .*", REGISTERS.format(7 + number % 2 * 2), text), encoding="utf-8")
        self.texts.add(CONFIGURATION.read_text(encoding="utf-8"))
        run("systemctl", "reload", SERVICE)

    @contextlib.contextmanager
    def mounted(self):
        run("mount", "-o", "loop", COPY, AFTER)
        try:
            yield
        finally:
            run("umount", AFTER)

    def expect_whole(self, told):
        headers = sorted(AFTER.glob("flight-*.json"))
        self.assertLessEqual(set(told), {path.stem for path in headers})
        for path in headers:
            header = json.loads(path.read_text(encoding="utf-8"))
            frames = [line for line in path.with_suffix(".log").read_text(encoding="ascii").splitlines() if " sync 080#" not in line]
            self.assertEqual(len(frames), header["frames"], path)
        kept = [path.read_text(encoding="utf-8") for path in AFTER.glob("*.toml")]
        self.assertGreater(len(kept), 0)
        for text in kept:
            tomllib.loads(text)
            self.assertIn(text, self.texts)

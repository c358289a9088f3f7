"""What cansyncd puts on a real CAN socket, byte for byte. Expected bytes are written by hand from the specification."""

import os
import re
import tempfile
import unittest

from canline import LONG, Candump, Master, Simulator, create_interface
from gateway import wait_for

CANCEL = "9000000000000000"  # telegram that ends a transfer on the slave
# Place of each channel in an interval; the response to the command of the interval before may come first.
RANK = {"1": {"0": "WRC1", "8": "WRC2"}, "3": {"0": "RDC1", "8": "RDC2"}, "5": {"0": "CC", "8": "RC"}}


def channel(frame):
    identifier = frame.split("#")[0]
    if identifier == "010":
        return "CC"
    return RANK[identifier[0]]["8" if int(identifier[1], 16) >= 8 else "0"]


def slave(frame):
    return int(frame[:3], 16) & 0x7F


def intervals(frames):
    """The frames between two SYNC frames each; what comes before the first and after the last is left out."""
    out, current = [], None
    for frame in frames:
        if frame == "080#":
            if current is not None:
                out.append(current)
            current = []
        elif current is not None:
            current.append(frame)
    return out


def without_repetitions(frames):
    return [frame for i, frame in enumerate(frames) if i == 0 or frame != frames[i - 1]]


class Frames(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        create_interface()
        cls.log = cls.enterClassContext(Candump())
        cls.simulator = cls.enterClassContext(Simulator())
        cls.daemon = cls.enterClassContext(Master())
        cls.daemon.wait_active()
        cls.start_up = cls.log.frames()

    def exchange(self, slave_number, *arguments):
        """The telegrams between master and slave for a job, without the status word that is read now and then. A job
        that a late answer ended, or in which the master had to repeat a telegram, is done again."""

        def attempt():
            before = len(self.log.frames())
            if self.daemon.run(*arguments).returncode != 0:
                return None
            ends = (f"{0x500 + slave_number:03X}#", f"{0x580 + slave_number:03X}#")
            frames = without_repetitions([frame for frame in self.log.frames()[before:]
                                          if frame.startswith(ends) and not frame[4:].startswith(("712D", "012D"))])
            commands = [frame for frame in frames if frame.startswith(ends[0])]
            # A slave that was away for a moment is first told to drop what it may have open.
            if ends[0] + CANCEL in commands:
                return None
            return frames if len(commands) == len(set(commands)) else None

        return wait_for(f"{arguments} is done", attempt)

    def test_start_up(self):
        frames = [frame for frame in self.start_up if frame != "080#"]
        self.assertEqual(self.start_up[0], "080#", "SYNC comes first")
        self.assertEqual(frames[0], "010#FFFFFFFF02010000", "action 2 with data byte 1, to every slave")
        self.assertFalse([frame for frame in frames if channel(frame) in ("WRC1", "WRC2", "RDC1", "RDC2")],
                         "no process data before reference values are given")
        for number in range(4):
            read = frames.index(f"50{number}#712D0000")  # element 7 of parameter 301, sub-slave 0
            locked = [i for i, frame in enumerate(frames) if re.fullmatch(f"58{number}#012D..[89A-F].0000", frame)]
            self.assertTrue(locked and locked[0] > read, f"slave {number} tells bit 15 of its status word")

    def test_reference_and_actual_values(self):
        before = len(self.log.frames())
        values = self.daemon.start("set", "0=74565", "1=-2", "4=0x01020304", "5=1", "--rate", 20)
        try:
            # Values 0 and 1, 4 and 5 as doublewords, low word first, low byte first; N asks for actual values.
            for number in range(4):
                self.log.wait_for_frame(f"{0x100 + number:03X}#45230100FEFFFFFF")
                self.log.wait_for_frame(f"{0x180 + number:03X}#0403020101000000")

            for number in range(4):  # each drive stands there
                self.log.wait_for_frame(f"{0x300 + number:03X}#4523010000000000")
            found = wait_for("20 whole intervals", lambda: self.whole_intervals(before))
        finally:
            values.terminate()
            values.communicate(timeout=LONG)
        for frames in found:
            self.assertEqual(slave(frames[0]), slave(frames[1]), "RDC1 is of the slave that WRC1 asked")
            self.assertEqual(slave(frames[2]), slave(frames[3]), "RDC2 is of the slave that WRC2 asked")
            self.assertTrue(all(len(frame) == 4 + 16 for frame in frames[:4]), frames)
        for frames in intervals(self.log.frames()):
            own = [name for name in map(channel, frames) if name in ("WRC1", "WRC2", "CC")]
            self.assertEqual(own, sorted(set(own), key=["WRC1", "WRC2", "CC"].index), "the master's own order")

    def whole_intervals(self, before):
        """At least 20 intervals with all four process data telegrams, in which these come first and in their order."""
        order = ["WRC1", "RDC1", "WRC2", "RDC2"]
        found = [[frame for frame in frames if channel(frame) != "RC"] for frames in intervals(self.log.frames()[before:])]
        found = [frames for frames in found if [channel(frame) for frame in frames[:4]] == order]
        return found if len(found) >= 20 else None

    def test_response_follows_its_command(self):
        asked = set()
        for frame in self.start_up:
            if channel_is(frame, "CC") and frame[0] == "5":
                asked.add((slave(frame), frame[5:8]))
            elif channel_is(frame, "RC"):
                self.assertIn((slave(frame), frame[5:8]), asked, "a response without a command")

    def test_parameter_word(self):
        # Parameter 1000 = 0x3E8: element 7 and bits 11..8 in byte 0.
        self.assertEqual(self.exchange(1, "write", 1, 1000, "0x1234", "--format", "word"),
                         ["501#73E834120000", "581#03E80000"])
        self.assertEqual(self.exchange(1, "read", 1, 1000), ["501#73E80000", "581#03E834120000"])

    def test_parameter_doubleword(self):
        # Parameter 1020 = 0x3FC.
        self.assertEqual(self.exchange(3, "write", 3, 1020, "0x12345678", "--format", "doubleword"),
                         ["503#73FC785634120000", "583#03FC0000"])
        self.assertEqual(self.exchange(3, "read", 3, 1020), ["503#73FC0000", "583#03FC785634120000"])

    def test_parameter_error(self):
        before = len(self.log.frames())
        wait_for("the slave refuses", lambda: self.daemon.run("read", 2, 77).returncode == 4)
        # Parameter 77 = 0x4D: error bit, no such parameter.
        self.assertIn("502#704D0000", self.log.frames()[before:])
        self.assertIn("582#204DFBFF0000", self.log.frames()[before:])

    def test_download_and_upload(self):
        with tempfile.TemporaryDirectory() as folder:
            source, target = os.path.join(folder, "in"), os.path.join(folder, "out")
            with open(source, "wb") as file:
                file.write(bytes.fromhex("A1A2A3A4A5A6B1B2B3B4"))
            self.assertEqual(self.exchange(2, "download", 2, "0x100", source), [
                "502#D00A000100000000", "582#8000",  # initialise 10 bytes at 0x100; only uploads have their length fixed
                "502#E000A1A2A3A4A5A6", "582#8000",
                "502#F006B1B2B3B40000", "582#8006",  # the last one has 6 bytes as well
            ])
            upload = self.exchange(2, "upload", 2, "0x100", 10, target)
            self.assertEqual(upload[0], "502#900A000100000000")
            self.assertIn(upload[1], ("582#8000", "582#800A"))  # length: 0, or fixed by the slave
            self.assertEqual(upload[2:4], ["502#A000", "582#8000A1A2A3A4A5A6"])
            self.assertEqual(upload[4], "502#B006")
            self.assertTrue(upload[5].startswith("582#8006B1B2B3B4"), upload)
            self.assertEqual(len(upload), 6)
            with open(target, "rb") as file:
                self.assertEqual(file.read().hex().upper(), "A1A2A3A4A5A6B1B2B3B4")

    def test_action_commands(self):
        self.daemon.verb("control", 2, "0x1203")
        self.log.wait_for_frame("010#0400000001000312")
        self.daemon.verb("control", 2, 7)
        self.daemon.verb("broadcast", "--yes", "--slaves", "0,3", "--command", 200, "--byte", "0x5A", "--word", "0x1234")
        self.log.wait_for_frame("010#09000000C85A3412")

    def test_nobody_else_is_on_the_bus(self):
        status = self.daemon.status()
        self.assertEqual((status["second_master"], status["second_master_frames"]), (False, 0), status)
        self.assertEqual((status["rejected_frames"], status["link_state"]), (0, "up"), status)


def channel_is(frame, name):
    return frame != "080#" and channel(frame) == name

"""General frames beside programs nobody here wrote: cansequence, cangen, candump and python3-can on a real CAN socket.

Nothing may be lost or out of order. How many frames each case takes: CANSYNC_WITNESS_FRAMES, see docs/layer2.md."""

import os
import subprocess
import unittest

from canline import INTERFACE, LONG, PROBE, Candump, GeneralFrames, Process, Wire, create_interface
from gateway import wait_for

FRAMES = int(os.environ.get("CANSYNC_WITNESS_FRAMES", "4000"))
SENT = 512  # by one call of `can send`
# As a bus of 500 kbit/s carries frames of 8 bytes; each counts 16 bytes here. vcan itself holds nobody back.
RATE = ("rate", "512kbit", "burst", "1600", "limit", "64000")
DEBIAN_PYTHON = "/usr/bin/python3"  # it alone sees Debian's package python3-can
# Sends its frames, and says which of those with identifier 2 it received.
PYTHON_CAN = """
import can, sys
bus = can.Bus(interface="socketcan", channel=sys.argv[1])
count = int(sys.argv[2])
for i in range(count):
    bus.send(can.Message(arbitration_id=0x18DAF155, is_extended_id=True, data=i.to_bytes(4, "big")), timeout=60)
print("sent", flush=True)
found = []
while len(found) < int(sys.argv[3]) and (frame := bus.recv(60)):
    if frame.arbitration_id == 2 and not frame.is_extended_id:
        found.append(frame.data[0])
print(*found)
bus.shutdown()
"""


class Dump(Candump):
    """`cansync can dump` into a file, as `candump -L` writes it."""

    def __init__(self, daemon):
        super().__init__()
        self.daemon = daemon

    def __enter__(self):
        self.process = self.daemon.start("can", "dump", "--candump", stdout=self.file)
        with Wire() as wire:
            wait_for("can dump listens", lambda: wire.send(PROBE) or PROBE in self._read())
        return self

    def wait_for_count(self, count):
        wait_for(f"{count} frames, not {len(self.frames())}", lambda: len(self.frames()) >= count)


class Witnesses(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        create_interface()
        subprocess.run(["tc", "qdisc", "add", "dev", INTERFACE, "root", "tbf", *RATE], check=True, timeout=LONG)
        cls.daemon = cls.enterClassContext(GeneralFrames())

    def run_foreign(self, *command):
        subprocess.run([*command, INTERFACE], check=True, timeout=20 * LONG, stdout=subprocess.DEVNULL)

    def test_every_frame_of_cansequence_comes_in_order(self):
        with Dump(self.daemon) as dump:
            self.run_foreign("cansequence", "--loop", str(FRAMES), "--poll")
            dump.wait_for_count(FRAMES)
            self.assertEqual(dump.frames(), [f"002#{i % 256:02X}" for i in range(FRAMES)])

    def test_frames_of_cangen_are_those_that_candump_sees(self):
        each = max(FRAMES // 10, 1)
        with Dump(self.daemon) as dump, Candump() as log:
            for options in ((), ("-e",), ("-R",), ("-e", "-R")):
                self.run_foreign("cangen", "-g", "0", "-p", "1000", "-n", str(each), *options)
            dump.wait_for_count(4 * each)
            wait_for("candump has them", lambda: len(log.frames()) >= 4 * each)
            self.assertEqual(len(dump.frames()), 4 * each)
            self.assertEqual(dump.frames(), log.frames())

    def send_sequence(self):
        """Frames of one byte that counts, as cansequence expects them."""
        frames = [f"002#{i:02X}" for i in range(256)]
        result = self.daemon.run("can", "send", *frames, "--count", SENT // 256)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(f"{SENT} frames sent", result.stderr)

    def test_cansequence_finds_what_we_send_in_order(self):
        with Process("cansequence", "--receive", "--quit=1", INTERFACE) as judge:
            self.send_sequence()
            self.assertIsNone(judge.process.poll(), judge.text())
            with Wire() as wire:  # the judge did listen
                wait_for("cansequence finds a wrong one", lambda: wire.send("002#77") or judge.process.poll() is not None)

    def test_frames_go_both_ways_with_python_can(self):
        count = max(FRAMES // 10, 1)
        with Dump(self.daemon) as dump:
            with subprocess.Popen([DEBIAN_PYTHON, "-c", PYTHON_CAN, INTERFACE, str(count), str(SENT)], text=True,
                                  stdout=subprocess.PIPE) as other:
                self.assertEqual(other.stdout.readline(), "sent\n")
                self.send_sequence()
                received = other.stdout.readline().split()
            dump.wait_for_count(count)
            self.assertEqual([int(byte) for byte in received], [i % 256 for i in range(SENT)])
            self.assertEqual(dump.frames(), [f"18DAF155#{i:08X}" for i in range(count)])

    def test_frames_that_wait_for_room_are_counted_as_that(self):
        limited = ["tc", "qdisc", "replace", "dev", INTERFACE, "root", "tbf"]
        subprocess.run([*limited, "rate", "1kbit", "burst", "32", "limit", "200"], check=True, timeout=LONG)
        try:
            with Candump() as log:
                sent = self.daemon.run("can", "send", *[f"23{i:X}#{i:02X}" for i in range(16)])
                self.assertEqual(sent.returncode, 0, sent.stderr)
                wait_for("all are on the bus", lambda: len([one for one in log.frames() if one.startswith("23")]) == 16)
            shown = next(line for line in self.daemon.run("status").stdout.decode().splitlines() if line.startswith("bus faults"))
            self.assertRegex(shown, r"\b[1-9]\d* times no room in the send queue\b")
            self.assertIn("; lost: 0 in the controller, 0 in the kernel", shown)
        finally:
            subprocess.run([*limited, *RATE], check=True, timeout=LONG)

    def tearDown(self):
        """Nothing was lost in a queue."""
        for queue in self.daemon.objects("can", "queues"):
            self.assertEqual((queue["overflowed"], queue["lost"], queue["not_published"] or 0), (False, 0, 0), queue)

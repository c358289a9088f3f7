"""Tests on emulated CAN controllers; runs inside the machine of qemu_machine.py.

The master is on can0, the simulated drives are on can1; both controllers (SJA1000, driver kvaser_pci) are on one bus. The
emulation acknowledges every frame and makes no errors of its own: error states cannot be brought about here.
"""

import os
import socket
import struct
import subprocess
import sys
import threading
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "end_to_end"))

from gateway import wait_for  # noqa: E402: found on the path that was set above

CANSYNC_SIM = os.environ["CANSYNC_SIM"]
LONG = 20
BIT_RATE = 125000  # intervals of 8 ms: an emulated processor is slow
SLAVES = 2


def shell(command):
    subprocess.run(command, shell=True, check=True)


def bring_up(interface, bit_rate=BIT_RATE):
    shell(f"ip link set {interface} down")
    shell(f"ip link set {interface} type can bitrate {bit_rate}")
    shell(f"ip link set {interface} up")


class SyncFrames:
    """Software SYNC frames for the simulated drives, in place of the wire that this bus has not got."""

    def __init__(self, interface):
        self.interface = interface
        self.end = threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)

    def run(self):
        with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as bus:
            bus.bind((self.interface,))
            while not self.end.wait(0.008):
                try:
                    bus.send(struct.pack("=IB3x8x", 0x080, 0))
                except OSError:  # the queue is full, or the interface is down for a moment
                    continue

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.end.set()
        self.thread.join()


def drives():
    """`cansync-sim` on can1, running."""
    return subprocess.Popen(
        [CANSYNC_SIM, "can1", f"--slaves=0-{SLAVES - 1}", f"--bit-rate={BIT_RATE}", "--lock-time=50",
         "--sync-id=0x080", "--missing-references=0"]
    )  # fmt: skip


class Drives(unittest.TestCase):
    def test_drives_on_one_controller_answer_a_master_on_the_other(self):
        for interface in ("can0", "can1"):
            bring_up(interface)
        simulator = drives()
        self.addCleanup(simulator.wait)
        self.addCleanup(simulator.terminate)
        with SyncFrames("can0"), socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as master:
            master.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, struct.pack("=II", 0x581, 0x7FF))
            master.settimeout(0.2)
            master.bind(("can0",))

            def answer():
                # Read parameter 301 of slave 1, sub-slave 0.
                master.send(struct.pack("=IB3x8s", 0x501, 4, bytes([0x71, 0x2D, 0, 0])))
                try:
                    return struct.unpack("=IB3x8s", master.recv(16))
                except TimeoutError:
                    return None

            identifier, length, data = wait_for("an answer of slave 1", answer, LONG)
        self.assertEqual((identifier, length), (0x581, 6))
        self.assertEqual((data[0] & 0x0F, data[1]), (1, 0x2D), data.hex())


if __name__ == "__main__":
    unittest.main(verbosity=2)

"""J1939 on a real CAN socket, against the kernel's own stack and its programs (can-utils): j1939cat, j1939acd, j1939spy, testj1939.

What the kernel sends is sent by a socket of its stack: j1939cat 2020.11 ends in the midst of it on this kernel, at a
notification that it takes for truncated."""

import os
import select
import signal
import socket
import subprocess
import tempfile
import unittest

from canline import INTERFACE, Candump, Daemon, create_interface
from gateway import end, wait_for

OTHER = 0x40  # address of the programs
OWN = 0x80
TAKEN = 0x90  # what the daemon takes when it loses that
GROUP = "12300"  # for one destination
CONFIG = """[address]
preferred = 0x80
arbitrary = true
first_other = 0x90
last_other = 0x90
[name]
identity = 1234
manufacturer = 7
[send]
timeout_ms = 30000
[transport]
most_bytes = 20000
[[receive]]
number = 0
first = 0x12300
[[receive]]
number = 1
first = 0xFEF1
"""


class Node(Daemon):
    PROTOCOL = "j1939"
    BIT_RATE = 250000

    def role(self):
        return CONFIG


class KernelStack:
    """Sends messages by the kernel's stack, which puts them into packets."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_CAN, socket.SOCK_DGRAM, socket.CAN_J1939)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        self.socket.bind((INTERFACE, socket.J1939_NO_NAME, socket.J1939_NO_PGN, OTHER))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def send(self, data, group, destination=socket.J1939_NO_ADDR):
        self.socket.sendto(data, (INTERFACE, socket.J1939_NO_NAME, group, destination))


def bytes_of(count):
    return bytes((7 * i + i // 256) % 256 for i in range(count))


class AgainstTheKernelsStack(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        create_interface()
        cls.folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        cls.log = cls.enterClassContext(Candump())
        cls.daemon = cls.enterClassContext(Node())
        cls.kernel = cls.enterClassContext(KernelStack())

    def wait_for_address(self, address):
        self.daemon.wait_status(f"address {address}", lambda s: (s["claim_state"], s["address"]) == ("claimed", address))

    def file_of(self, data):
        path = os.path.join(self.folder, "data")
        with open(path, "wb") as file:
            file.write(data)
        return path

    def transmit(self, *arguments):
        self.assertEqual(self.daemon.objects("j1939", "send", *arguments)[0]["result"], "done")

    # Names begin with their order: the address is lost at the end.
    def test_1_single_frames_and_broadcasts_both_ways(self):
        self.wait_for_address(OWN)
        for count in (8, 100):
            data = bytes_of(count)
            with tempfile.TemporaryFile() as output:
                spy = subprocess.Popen(["j1939cat", "-B", "-r", f"{INTERFACE}:{OTHER:#x}"], stdout=output)
                try:
                    # Until the program listens.
                    wait_for("the program hears it", lambda: self.transmit("0FEF1", "--file", self.file_of(data)) or size_of(output) >= count)
                finally:
                    end(spy)
                output.seek(0)
                self.assertEqual(output.read(count), data)
            with self.daemon.start("j1939", "messages", "--json") as messages:
                self.until_heard(messages, data, lambda data=data: self.kernel.send(data, 0xFEF1))

    def test_2_connections_and_longer_ones_both_ways(self):
        self.wait_for_address(OWN)
        for count, transport in ((9, "connection"), (1785, "connection"), (1786, "extended"), (6000, "extended")):
            data = bytes_of(count)
            with self.daemon.start("j1939", "messages", "--json") as messages:
                self.until_heard(messages, data, lambda data=data: self.kernel.send(data, int(GROUP, 16), OWN), transport)
            with tempfile.TemporaryFile() as output:
                receiver = subprocess.Popen(["j1939cat", "-r", f"{INTERFACE}:{OTHER:#x}"], stdout=output)
                try:
                    self.transmit(GROUP, "--file", self.file_of(data), "--to", str(OTHER))
                    wait_for("it is there whole", lambda: size_of(output) >= count)
                finally:
                    end(receiver)
                output.seek(0)
                self.assertEqual(output.read(count), data)

    def until_heard(self, messages, data, send, transport=None):
        """Sends until the message comes: it may begin before anybody listens."""

        def attempt():
            send()
            return messages.next_object() if select.select([messages.stdout], [], [], 10)[0] else None

        got = wait_for(f"{len(data)} bytes come", attempt)
        messages.send_signal(signal.SIGINT)
        self.assertEqual(bytes(got["data"]), data)
        self.assertEqual(got["source"], OTHER)
        if transport:
            self.assertEqual(got["transport"], transport)
            self.assertEqual(got["destination"], OWN)

    def test_3_the_kernels_programs_read_what_is_sent(self):
        self.wait_for_address(OWN)
        for command in (["testj1939", "-B", "-r", f"{INTERFACE}:{OTHER:#x}"], ["j1939spy", "-P", INTERFACE]):
            with tempfile.TemporaryFile() as output:
                program = subprocess.Popen(["stdbuf", "-o0", *command], stdout=output, stderr=subprocess.STDOUT)
                try:
                    wait_for("it reads", lambda: self.transmit("0FEF1", "C0FFEE0102030405") or size_of(output) > 0)
                    output.seek(0)
                    text = output.read().decode(errors="replace")
                finally:
                    end(program)
            self.assertIn("c0ffee0102030405", text.lower().replace(" ", "").replace(":", ""), text)

    def test_4_a_weaker_name_gets_another_address_and_a_stronger_one_takes_ours(self):
        self.wait_for_address(OWN)
        cache = os.path.join(self.folder, "cache")
        weaker = subprocess.Popen(["j1939acd", "-r", "128,129", "-a", "128", "-c", cache + "1", "FFFFFFFFFFFFFFF0", INTERFACE])
        try:
            wait_for("the weaker one has 129", lambda: 129 in self.others())
            self.assertEqual(self.daemon.status()["address"], OWN)
        finally:
            end(weaker)
        stronger = subprocess.Popen(["j1939acd", "-r", "128", "-a", "128", "-c", cache + "2", "0000000000000010", INTERFACE])
        try:
            self.wait_for_address(TAKEN)
            self.assertEqual(self.others()[128], "0000000000000010")
            self.transmit("0FEF1", "0102030405060708")
            self.log.wait_for_frame("18FEF190#0102030405060708")
        finally:
            end(stronger)

    def others(self):
        return {one["address"]: one["name"] for one in self.daemon.objects("j1939", "addresses") if not one["own"]}


def size_of(file):
    return os.fstat(file.fileno()).st_size

"""Tests of the daemon on emulated CAN controllers; runs inside the machine of machine.py.

The daemon is on can0, the simulated drives are on can1; both controllers (SJA1000, driver kvaser_pci) are on one bus. The
emulation acknowledges every frame and makes no errors of its own: error states cannot be brought about here.
"""

import json
import os
import re
import select
import socket
import struct
import subprocess
import threading
import unittest

import slave_pair
from canline import BIT_RATE, CANSYNC_SIM, LONG, GeneralFrames, Master, Simulator, Wire
from gateway import wait_for

OTHER_RATE = 250000
SLAVES = 2
EVERY = (1 << SLAVES) - 1


def shell(command):
    subprocess.run(command, shell=True, check=True, timeout=LONG)


def bring_up(interface, bit_rate=BIT_RATE):
    shell(f"ip link set {interface} down")
    shell(f"ip link set {interface} type can bitrate {bit_rate} listen-only off")
    shell(f"ip link set {interface} up")


class SyncFrames:
    """Software SYNC frames, in place of the wire that this bus has not got."""

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
        self.thread.join(LONG)


def master():
    return Master(SLAVES, "can0")


def drives():
    return Simulator("--real", slaves=f"0-{SLAVES - 1}", interface="can1")


class Drives(unittest.TestCase):
    def test_drives_on_one_controller_answer_a_master_on_the_other(self):
        for interface in ("can0", "can1"):
            bring_up(interface)
        with drives(), SyncFrames("can0"), Wire("can0") as wire:
            answer = bytes.fromhex(wire.ask("501#712D0000"))  # parameter 301 of slave 1, sub-slave 0
        self.assertEqual((len(answer), answer[0] & 0x0F, answer[1]), (6, 1, 0x2D), answer.hex())


    def test_simulated_drives_and_masters_want_a_bus_of_their_own(self):
        for interface in ("can0", "can1"):
            bring_up(interface)

        def refused(*options):
            result = subprocess.run([CANSYNC_SIM, "can1", *options], capture_output=True, text=True, timeout=LONG, check=False)
            self.assertEqual(result.returncode, 1, result.stderr)
            return result.stderr

        self.assertIn("can1 is not virtual", refused())
        self.assertIn("can1 is not virtual", refused("--master"))
        with SyncFrames("can0"):
            self.assertIn("a master sends on this bus", refused("--master", "--real", "--sync-id", "0x080"))


class WrongBitRate(unittest.TestCase):
    def test_it_is_refused_with_the_command_that_sets_it(self):
        bring_up("can0", OTHER_RATE)
        with master() as daemon:
            self.assertEqual(daemon.program.process.wait(LONG), 1, daemon.log_text())
            refusal = f"can0 is set to {OTHER_RATE} bit/s, bus.bit_rate is {BIT_RATE}; set it with: "
            self.assertIn(refusal, daemon.log_text())
            command = daemon.log_text().split(refusal)[1].splitlines()[0]
        print("the daemon's command:", command, flush=True)
        shell(command)
        with master() as daemon:
            daemon.wait_status(
                "the bit rate is right", lambda s: s["link_state"] == "up" and s["interface_bit_rate"] == BIT_RATE
            )


def path_of(interface):
    """As the kernel has it: both controllers are PCI devices."""
    return "path=pci-" + os.path.basename(os.path.realpath(f"/sys/class/net/{interface}/device"))


def exchange_names():
    """As a boot in which the kernel finds the adapters in the other order."""
    for interface in ("can0", "can1"):
        shell(f"ip link set {interface} down")
    for old, new in (("can0", "other"), ("can1", "can0"), ("other", "can1")):
        shell(f"ip link set {old} name {new}")
    for interface in ("can0", "can1"):
        bring_up(interface)


class PinnedMaster(Master):
    def __init__(self, adapter):
        self.adapter = adapter
        super().__init__(SLAVES, "can0")

    def on_interface(self):
        return super().on_interface() + f'adapter = "{self.adapter}"\n'


class AdaptersExchanged(unittest.TestCase):
    def test_the_daemon_refuses_the_other_adapter_and_names_both(self):
        for interface in ("can0", "can1"):
            bring_up(interface)
        ours, other = path_of("can0"), path_of("can1")
        self.assertNotEqual(ours, other)
        both = f"can0 has the adapter {other},channel=0, bus.adapter is {ours}: nothing is sent or received"
        with PinnedMaster(ours) as daemon:
            daemon.wait_status("its adapter is there", lambda s: (s["link_state"], s["adapter"]) == ("up", ours + ",channel=0"))
            exchange_names()
            self.addCleanup(lambda: path_of("can0") == ours or exchange_names())
            status = daemon.wait_status("another adapter", lambda s: s["link_state"] == "wrong-adapter")
            self.assertEqual((status["adapter"], status["adapter_wanted"]), (other + ",channel=0", ours))
            self.assertTrue(daemon.wait_event("wrong_adapter")[0]["text"].startswith(both))
            sent = daemon.status()["telegrams_sent"]
            with Wire("can0") as wire:
                self.assertIsNone(wire.receive(2), "the daemon sends on the other line")
            self.assertEqual(daemon.status()["telegrams_sent"], sent)
            with PinnedMaster(ours) as second:
                self.assertEqual(second.program.process.wait(LONG), 1, second.log_text())
                self.assertIn(both, second.log_text())
            exchange_names()
            daemon.wait_status("its adapter is back", lambda s: s["link_state"] == "up")
            daemon.wait_status("telegrams are sent again", lambda s: s["telegrams_sent"] > sent)


class AllRates(unittest.TestCase):
    """The emulated bus has no bit rate, so frames come at each of the four: the interval decides."""

    @staticmethod
    def bit_timing():
        """Bit rate, sample point, time quantum, segments and jump width of can1."""
        shown = subprocess.run(["ip", "-details", "link", "show", "can1"], capture_output=True, text=True, check=True,
                               timeout=LONG).stdout
        return re.search(r"bitrate \d+.*?sjw \d+", shown, re.DOTALL)[0].split()

    def test_scan_sets_the_rates_one_after_the_other_and_the_interface_back(self):
        bring_up("can0")
        bring_up("can1", OTHER_RATE)
        before = self.bit_timing()
        with master() as daemon:
            daemon.wait_status("SYNC runs", lambda status: status["interval"] > 0)
            result = daemon.run("scan", "can1", "--try-rates", "--yes", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        points = [json.loads(line) for line in result.stdout.splitlines()]
        self.assertIn((f"{BIT_RATE} bit/s", "of the four, the one at which frames came"),
                      [(one["found"], one["how"]) for one in points if one.get("point") == "bit rate"])
        self.assertEqual(self.bit_timing(), before, "sample point, segments and jump width")
        shown = subprocess.run(["ip", "-details", "link", "show", "can1"], capture_output=True, text=True, check=True,
                               timeout=LONG).stdout
        self.assertIn(f"bitrate {OTHER_RATE} ", shown)
        self.assertIn("state UP", shown)
        self.assertNotIn("LISTEN-ONLY", shown)


class OneBus(unittest.TestCase):
    """One daemon and one set of drives for all tests."""

    @classmethod
    def setUpClass(cls):
        for interface in ("can0", "can1"):
            bring_up(interface)
        cls.enterClassContext(drives())
        cls.daemon = cls.enterClassContext(master())

    def all_respond(self):
        return self.daemon.wait_status("every slave responds", lambda s: s["slaves_responding"] == EVERY)

    def test_bit_rate_state_and_counters_are_read_from_the_kernel_and_shown(self):
        status = self.all_respond()
        self.assertEqual(status["link_state"], "up")
        self.assertEqual(status["interface_bit_rate"], BIT_RATE)
        self.assertEqual(status["sample_point_permille"], 875)
        self.assertEqual(status["controller_state"], "error-active")
        self.assertEqual(status["restart_time_ms"], 0)
        self.assertEqual(status["queue_length"], 10)
        for counter in ("transmit_errors", "receive_errors", "error_frames", "acknowledge_errors", "overruns"):
            self.assertEqual(status[counter], 0, counter)
        self.assertFalse(status["second_master"])
        shown = self.daemon.run("status").stdout.decode()
        for words in (f"{BIT_RATE} bit/s", "error-active", "can0 is up"):
            self.assertIn(words, shown)

    def test_the_doctor_sees_the_controller(self):
        self.all_respond()
        found = [json.loads(line) for line in self.daemon.run("doctor", "--json").stdout.splitlines()]
        by_topic = {finding["topic"]: finding["found"] for finding in found}
        self.assertEqual(by_topic["interface"], "can0 is up")
        self.assertEqual(by_topic["controller"], "error-active")
        self.assertEqual(by_topic["error counters"], "0 transmit, 0 receive")

    def test_a_slave_on_the_other_controller_is_read(self):
        self.all_respond()
        result = self.daemon.run("read", "1", "301", "--json")
        self.assertEqual(result.returncode, 0, f"{result.stdout}\n{result.stderr}\n{self.daemon.log_text()}")

    def test_the_interface_goes_down_and_comes_back(self):
        self.all_respond()
        shell("ip link set can0 down")
        self.daemon.wait_status("the interface is down", lambda s: s["link_state"] == "down")
        shell("ip link set can0 up")
        status = self.daemon.wait_status("the interface is up", lambda s: s["link_state"] == "up")
        sent = status["telegrams_sent"]
        self.daemon.wait_status("telegrams are sent again", lambda s: s["telegrams_sent"] > sent)
        self.all_respond()
        events = self.daemon.run("events", "--json").stdout.decode()
        for code in ("interface_down", "interface_up"):
            self.assertIn(f'"{code}"', events)

    def test_another_bit_rate_while_running_stops_the_telegrams_until_it_is_right_again(self):
        self.all_respond()
        bring_up("can0", OTHER_RATE)
        status = self.daemon.wait_status("the wrong bit rate", lambda s: s["link_state"] == "wrong-bit-rate")
        self.assertEqual(status["interface_bit_rate"], OTHER_RATE)
        bring_up("can0")
        self.daemon.wait_status("the interface is up", lambda s: s["link_state"] == "up")
        self.all_respond()

    def test_the_controller_is_reset_by_command(self):
        self.all_respond()
        result = self.daemon.run("mode", "reset-can", "--yes")
        self.assertEqual(result.returncode, 0, f"{result.stdout}\n{result.stderr}\n{self.daemon.log_text()}")
        self.all_respond()
        self.assertEqual(self.daemon.status()["controller_state"], "error-active")


class FramesOnControllers(unittest.TestCase):
    """The daemon on can0 serves general frames; can1 is somebody else."""

    @classmethod
    def setUpClass(cls):
        for interface in ("can0", "can1"):
            bring_up(interface)
        cls.daemon = cls.enterClassContext(GeneralFrames("[[receive]]\nnumber = 0\nfirst = 0x100\nlast = 0x1FF\n", "can0"))

    def setUp(self):
        # One for each test: what another one sent is not among what it hears.
        self.other = self.enterContext(socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW))
        self.other.bind(("can1",))
        self.other.settimeout(LONG)

    def test_frames_are_on_the_bus_and_answered_once(self):
        # Not a remote frame that asks for bytes: the emulated receive FIFO counts bytes that it does not hold, and what
        # comes afterwards is read one frame late. vcan has such ones.
        extended, remote = socket.CAN_EFF_FLAG, socket.CAN_RTR_FLAG
        for frame, identifier, length, data in (
            ("7FF#0102", 0x7FF, 2, "0102"),
            ("18DAF110#FF", 0x18DAF110 | extended, 1, "FF"),
            ("123#R", 0x123 | remote, 0, ""),
        ):
            self.daemon.verb("can", "send", frame)
            found, size, bytes_ = struct.unpack("=IB3x8s", self.other.recv(16))
            self.assertEqual((found, size), (identifier, length))
            self.assertEqual(bytes_, bytes.fromhex(data).ljust(8, b"\0"))

    def test_every_frame_of_cansequence_comes_in_order(self):
        """In calls of what the receive FIFO of an SJA1000 holds (64 bytes, 4 for a frame): the emulated bus has no bit rate,
        and nothing can be said of frames that the controller itself lost."""
        calls, count = 25, 12
        expected = [f"102#{i:02X}" for i in range(count)]
        with self.daemon.start("can", "dump", "--candump", "--id", "102-104") as frames:
            wait_for("a frame comes", lambda: self.other.send(struct.pack("=IB3x8s", 0x104, 1, b"\x55")) and
                     select.select([frames.stdout], [], [], 0.5)[0])
            for call in range(calls):
                subprocess.run(["cansequence", "can1", "--identifier=0x102", f"--loop={count}", "--poll"], check=True,
                               stdout=subprocess.DEVNULL, timeout=LONG)
                found = []
                while len(found) < count:
                    frame = frames.next_line().split()[2].decode()
                    if frame != "104#55":
                        found.append(frame)
                self.assertEqual(found, expected, f"call {call}")
            frames.terminate()

    def test_in_listen_only_mode_frames_come_and_none_is_sent(self):
        self.addCleanup(bring_up, "can0")
        shell("ip link set can0 down; ip link set can0 type can listen-only on; ip link set can0 up")
        self.daemon.wait_status("listen-only", lambda s: s["link_state"] == "listen-only")
        refused = self.daemon.run("can", "send", "7FF#01")
        self.assertEqual(refused.returncode, 5, refused.stderr)  # not within its monitoring time
        self.assertIn("in listen-only mode", refused.stderr)
        taken = self.daemon.status()["received"]
        wait_for("a frame comes", lambda: self.other.send(struct.pack("=IB3x8s", 0x1AA, 1, b"\x55")) and
                 self.daemon.status()["received"] > taken)
        findings = [json.loads(line) for line in self.daemon.run("doctor", "--json").stdout.splitlines()]
        finding = next(one for one in findings if one["topic"] == "interface")
        self.assertIn("in listen-only mode", finding["found"])
        shell(finding["remedy"])
        self.daemon.wait_status("it sends again", lambda s: s["link_state"] == "up")
        self.daemon.verb("can", "send", "7FF#02")
        self.assertEqual(struct.unpack("=IB3x8s", self.other.recv(16))[2][0], 2, "the first that was ever sent")

    def test_frames_of_others_come_through_the_range(self):
        with self.daemon.start("can", "dump", "--json") as frames:
            came = threading.Event()

            def send():
                while not came.wait(0.2):
                    for identifier in (0x0FF, 0x1FF):
                        self.other.send(struct.pack("=IB3x8s", identifier, 1, b"\x55"))

            sender = threading.Thread(target=send, daemon=True)
            sender.start()
            found = frames.next_object()
            came.set()
            sender.join(LONG)
            frames.terminate()
        self.assertEqual((found["identifier"], found["data"], found["range"]), (0x1FF, [0x55], 0))


class MasterAndSlave(slave_pair.SlavePair, unittest.TestCase):
    """Our master on can0, our slave on can1."""

    interfaces = ("can0", "can1")
    tolerance = 500

    def setUp(self):
        for interface in self.interfaces:
            bring_up(interface)

"""What a stranger sends, by cansend of can-utils: frames after which something was wrong that our own programs on the bus had not
shown. Each test begins with the daemon that it needs."""

import json
import select
import subprocess
import time
import unittest

from canline import INTERFACE, LONG, Candump, Daemon, GeneralFrames, create_interface
from gateway import wait_for

OWN = "80"  # address of the daemon
STRANGER = "40"


def cansend(*frames):
    for frame in frames:
        subprocess.run(["cansend", INTERFACE, frame], check=True, timeout=LONG)


class Node(Daemon):
    PROTOCOL = "j1939"
    BIT_RATE = 250000
    ADDRESS = f"[address]\npreferred = 0x{OWN}\n[name]\nidentity = 1234\n"

    def __init__(self, sections, address=ADDRESS):
        self.sections = address + sections
        super().__init__()

    def role(self):
        return self.sections


def provide(number, group, size, more=""):
    return f"[[provide]]\nnumber = {number}\npgn = 0x{group:04X}\ndata = {list(range(size))}\n{more}"


class Strangers(unittest.TestCase):
    def setUp(self):
        create_interface()
        self.log = self.enterContext(Candump())

    def node(self, sections, **options):
        return self.enterContext(Node(sections, **options))

    def wait_for_claim(self, node, state="claimed"):
        node.wait_status(f"claim state {state}", lambda s: s["claim_state"] == state)

    def announced(self):
        """The groups that the daemon has announced to all, in packets."""
        frames = [frame.split("#") for frame in self.log.frames()]
        return {data[-6:] for identifier, data in frames if identifier[2:] == f"ECFF{OWN}" and data.startswith("20")}

    def test_two_long_groups_of_one_period_are_both_sent(self):
        self.node(provide(0, 0xFF01, 10, "period_ms = 1000\n") + provide(1, 0xFF02, 12, "period_ms = 1000\n"))
        wait_for("both are announced", lambda: self.announced() == {"01FF00", "02FF00"})

    def test_who_asks_for_two_long_groups_at_once_gets_both(self):
        node = self.node(provide(0, 0xFEEB, 20) + provide(1, 0xFEDA, 20))
        self.wait_for_claim(node)
        cansend(f"18EAFF{STRANGER}#EBFE00", f"18EAFF{STRANGER}#DAFE00")
        wait_for("both are announced", lambda: self.announced() == {"EBFE00", "DAFE00"})

    def test_faults_are_told_whatever_the_ranges_take(self):
        node = self.node("[[receive]]\nnumber = 0\nfirst = 0xF004\nlast = 0xF004\n")
        self.wait_for_claim(node)
        cansend(f"18FECA{STRANGER}#10FF64000101FFFF")  # the red stop lamp, and SPN 100, FMI 1
        self.assertIn("SPN 100", node.wait_event("fault_appeared")[0]["text"])
        found = node.objects("j1939", "faults")[0]
        self.assertEqual((found["source"], [one["spn"] for one in found["codes"]]), (0x40, [100]))

    def test_a_node_that_lost_its_address_is_found_by_the_doctor(self):
        node = self.node("", address=Node.ADDRESS.replace("[name]", "arbitrary = false\n[name]"))
        self.wait_for_claim(node)
        cansend(f"18EEFF{OWN}#0100000000000000")  # by a stronger NAME
        self.wait_for_claim(node, "cannot-claim")
        found = [json.loads(line) for line in node.run("doctor", "--json").stdout.decode().splitlines()]
        errors = [one["topic"] for one in found if one["level"] == "error"]
        self.assertIn("address", errors)

    def test_who_has_no_address_sends_nothing(self):
        node = self.node("[[receive]]\nnumber = 0\n", address="")
        self.wait_for_claim(node, "listening")
        asked = f"18EAFF{STRANGER}#00EE00"  # who is there?
        cansend(asked, f"18FEF1{STRANGER}#0102030405060708")
        node.wait_status("it has heard both", lambda s: s["received"] >= 2)
        time.sleep(1)  # an answer may come after a pause of 0 to 153 ms
        self.assertEqual(self.log.frames(), [asked, f"18FEF1{STRANGER}#0102030405060708"])

    def test_a_mapping_of_outputs_takes_no_frame_away(self):
        daemon = self.enterContext(GeneralFrames('[[receive]]\nnumber = 0\nfirst = 0\nlast = 0x7FF\n'
                                                 '[[mapped]]\nnumber = 0\nidentifier = 0x201\naddress = 0\nsize = 2\noutput = true\n'))
        daemon.wait_status("it runs", lambda s: s["running"])
        with daemon.start("can", "dump", "--json") as frames:
            # Until the program listens.
            wait_for("a frame comes", lambda: cansend("150#AA") or select.select([frames.stdout], [], [], 0.5)[0])
            self.assertEqual(frames.next_object()["identifier"], 0x150)
            frames.terminate()

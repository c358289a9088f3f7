"""J1939: the daemon with simulated nodes, and the verbs `messages`, `transmit`, `request`, `addresses` and `faults`."""

import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "manual"))
from help_text import help_of

from json_schemas import expect
from gateway import CANSYNC, CANSYNCD, LONG, Place, end, metrics, wait_for
from verb_case import DaemonTest
from secured_case import SecuredCase

CONFIG = """
[bus]
protocol = "j1939"
name = "{bus}"
[dds]
domain = {domain}
[metrics]
file = "line.prom"
period_s = 1
[address]
preferred = 0x21     # which the stronger simulated node has
arbitrary = true
contest = true
first_other = 0x90
[name]
identity = 500000
[send]
timeout_ms = 20000
[[receive]]
number = 0
first = 0xFECA
[[receive]]
number = 1
first = 0xEF00
[[ecu]]              # three faults: a broadcast
number = 0
address = 0x21
pgn = 0xFECA
data = [0x04, 0xFF, 0xB8, 0x04, 0x03, 0x0A, 0x10, 0x27, 0x45, 0x7F, 0x01, 0x00, 0x02, 0x01]
period_ms = 500
[[ecu]]              # by a connection to the daemon
number = 1
address = 0x22
pgn = 0xEF00
destination = 0x90
data = [0, 2, 3, 4, 5, 6, 7, 8, 9, 10]
period_ms = 300
[[ecu]]              # on request alone
number = 2
address = 0x23
pgn = 0xFEEB
data = [65, 66, 67, 68, 69, 70, 71, 72, 73, 74, 75]
"""


class Messages(DaemonTest):
    CONFIG = CONFIG

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        wait_for("a message is sent", lambda: cls.place.run("j1939", "send", "0FEF1", "01").returncode == 0)

    def json(self, *arguments, code=0):
        found = super().json(*arguments, code=code)
        for one in found:
            expect(arguments, one)
        return found

    def test_it_lost_its_address_and_has_another(self):
        found = {one["address"]: one for one in self.json("j1939", "addresses")}
        self.assertEqual(set(found), {0x21, 0x22, 0x23, 0x90})
        self.assertEqual([address for address, one in found.items() if one["own"]], [0x90])
        self.assertEqual((found[0x90]["identity"], found[0x22]["identity"]), (500000, 1001))
        told = {"address_lost", "address_claimed", "fault_appeared"}
        wait_for("the events are told", lambda: told <= {event["code"] for event in self.json("events")})

    def test_the_metrics_are_those_of_the_status(self):
        path = os.path.join(os.path.dirname(self.config), "line.prom")
        before = self.one("status")
        self.assertEqual(self.one("j1939", "send", "0xFEF1", "01 02")["result"], "done")
        told = wait_for("the message is counted", lambda: (now := metrics(path)).get("cansync_j1939_frames_sent_total", -1) > before["sent"] and now)
        after = wait_for("the status is not older", lambda: (s := self.one("status"))["sent"] >= told["cansync_j1939_frames_sent_total"] and s)
        taken = told["cansync_j1939_messages_taken_total"]
        self.assertTrue(before["taken"] <= taken <= after["taken"], (before["taken"], taken, after["taken"]))
        self.assertEqual(told['cansync_j1939_claim_state{state="claimed"}'], 1)
        self.assertEqual((told["cansync_j1939_address"], told["cansync_bit_rate_bits_per_second"]), (0x90, 250000))

    def test_messages_of_each_length_are_sent(self):
        self.assertEqual(self.one("j1939", "send", "0xFEF1", "01 02")["result"], "done")
        sent = self.one("j1939", "send", "0EF00", "5A" * 1785, "--to", "0x23")
        self.assertEqual((sent["result"], sent["length"], sent["priority"]), ("done", 1785, 7))
        self.assertGreater(sent["sent_time_ns"], 0)
        self.assertEqual(self.one("j1939", "send", "0FEF2", "5A" * 9)["result"], "done")
        nobody = self.one("j1939", "send", "0EF00", "5A" * 9, "--to", "0x55", "--timeout", 30, code=5)
        self.assertEqual(nobody["result"], "no_answer")

    def test_the_event_of_a_sent_message_has_its_group_destination_and_bytes(self):
        self.one("j1939", "send", "0FEF3", "01 02")
        self.one("j1939", "send", "0EF00", "C7" * 9, "--to", "0x23")
        sent = {"PGN 0x0FEF3 to all, 2 bytes: 01 02",
                "PGN 0x0EF00 to address 35, 9 bytes: " + "C7 " * 8 + f".., SHA-256 {hashlib.sha256(bytes([0xC7] * 9)).hexdigest()}"}
        wait_for("the events are there", lambda: sent <= {event.get("new_value") for event in self.json("events")})

    def test_longer_ones_are_sent_from_a_file_to_one_node(self):
        with tempfile.NamedTemporaryFile() as file:
            file.write(bytes(range(250)) * 12)
            file.flush()
            sent = self.one("j1939", "send", "0EF00", "--file", file.name, "--to", "0x23")
            self.assertEqual((sent["result"], sent["length"]), ("done", 3000))
            refused = self.one("j1939", "send", "0EF00", "--file", file.name, code=3)
            self.assertEqual((refused["result"], refused["cause"]), ("refused", "length"))
            self.assertIn("to one node", refused["reason"])
            file.write(bytes(65536))
            file.flush()
            refused = self.one("j1939", "send", "0EF00", "--file", file.name, "--to", "0x23", code=3)
            self.assertIn("transport.most_bytes", refused["reason"])

    def test_signals_have_names(self):
        with tempfile.NamedTemporaryFile("w", suffix=".dbc") as file:
            file.write('VERSION ""\nBO_ 2565800190 Counter: 10 X\n SG_ Count : 0|8@1+ (0.5,-3) [-3|122] "rpm" X\n SG_ Last : 72|8@1+ (1,0) [0|250] "" X\n')
            file.flush()
            with self.place.start("j1939", "messages", "--json", "--dbc", file.name) as messages:
                one = messages.next_object()
                while one["pgn"] != 0xEF00:
                    self.assertEqual((one["message"], one["signals"]), (None, []))
                    one = messages.next_object()
                messages.send_signal(signal.SIGINT)
            self.assertEqual(one["message"], "Counter")
            count, last = one["signals"]
            self.assertEqual((count["name"], count["value"], count["unit"]), ("Count", one["data"][0] / 2 - 3, "rpm"))
            self.assertEqual((last["raw"], last["word"]), (10, ""))
            sent = self.one("j1939", "send", "Counter", "--dbc", file.name, "--set", "Count=-2.5", "--set", "Last=7", "--to", "0x23")
            self.assertEqual((sent["result"], sent["pgn"], sent["length"], sent["priority"]), ("done", 0xEF00, 10, 6))
            wrong = self.place.run("j1939", "send", "Counter", "--dbc", file.name, "--set", "Count=200")
            self.assertEqual(wrong.returncode, 2)
            self.assertIn("-3..122 rpm", wrong.stderr)
            file.write(" SG_ Cut : 0|\n")
            file.flush()
            in_part = self.place.run("j1939", "send", "Counter", "--dbc", file.name, "--set", "Count=-2.5", "--to", "0x23")
            self.assertEqual(in_part.returncode, 11, in_part.stderr)
            self.assertIn("sent", in_part.stderr)

    def test_a_node_is_asked(self):
        answer = self.one("j1939", "request", "0FEEB", "--to", "0x23")
        self.assertEqual((answer["result"], answer["data"]), ("done", list(range(65, 76))))
        refused = self.one("j1939", "request", "0FEE5", "--to", "0x23", code=4)
        self.assertEqual((refused["result"], refused["answer_code"]), ("slave_error", 1))
        self.assertEqual(self.one("j1939", "request", "0EE00")["result"], "done")
        text = self.place.run("j1939", "request", "0FEEB", "--to", "0x23").stdout.decode()
        self.assertEqual(text, "41 42 43 44 45 46 47 48 49 4A 4B\n")

    def test_messages_in_packets_come_whole(self):
        with self.place.start("j1939", "messages", "--json", "--count", 4) as messages:
            found = [messages.next_object() for _ in range(4)]
        self.assertEqual({(one["pgn"], one["transport"], one["source"], one["range"]) for one in found},
                         {(0xFECA, "broadcast", 0x21, 0), (0xEF00, "connection", 0x22, 1)})
        by_connection = [one for one in found if one["pgn"] == 0xEF00]
        self.assertEqual(by_connection[0]["data"][1:], list(range(2, 11)))
        self.assertEqual(by_connection[0]["destination"], 0x90)

    def test_the_faults_of_a_node(self):
        found = wait_for("faults are told", lambda: self.json("j1939", "faults"))[0]
        self.assertEqual((found["source"], found["active"]), (0x21, True))
        codes = [(one["spn"], one["fmi"], one["occurrences"]) for one in found["codes"]]
        self.assertEqual(codes, [(1208, 3, 10), (0x22710, 5, 127), (1, 2, 1)])

    def test_status_and_doctor_find_the_daemon(self):
        status = self.one("status")
        self.assertEqual((status["protocol"], status["claim_state"], status["address"]), ("j1939", "claimed", 0x90))
        self.assertEqual((status["addresses_lost"], status["bit_rate"]), (1, 250000))
        self.assertRegex(self.place.run("status").stdout.decode(), r"(?m)^address +144, claimed; NAME FFFEFFFFFFE7A120")
        found = [json.loads(line) for line in self.place.run("doctor", "--json").stdout.splitlines()]
        self.assertIn("j1939", next(one for one in found if one["topic"] == "daemon")["found"])
        self.assertRegex(self.place.run("status").stdout.decode(), r"(?m)^missed +\d+ reports?$")
        self.assertIn("a lower NAME wins", next(one for one in found if one["topic"] == "address")["found"])

    def test_a_former_name_of_a_verb_says_the_new_one(self):
        result = self.place.run("--json", "addresses")
        self.assertEqual((result.returncode, result.stderr), (0, "cansync: `addresses` is now `cansync j1939 addresses`\n"))
        self.assertEqual(self.place.run("help", "transmit").stdout, self.place.run("j1939", "send", "--help").stdout)
        self.assertNotIn("transmit", self.place.run("--help").stdout.decode())

    def test_a_verb_of_another_protocol_says_so(self):
        for verb, needs in ((("can", "dump"), "layer2"), (("slave", "references"), "cansync-slave"), (("read", 0, 100), "cansync-master"), (("slaves",), "cansync-master")):
            result = self.place.run(*verb, "--timeout", LONG)
            self.assertEqual(result.returncode, 6, result.stderr)
            self.assertIn("j1939", result.stderr)
            self.assertIn(needs, result.stderr)

    def test_the_tables_are_explained(self):
        for verb, arguments in (("messages", ("--count", 1)), ("addresses", ()), ("faults", ())):
            heading = self.place.run("j1939", verb, *arguments).stdout.decode().splitlines()[0]
            self.assertEqual(re.split("  *", heading.strip()), list(help_of(CANSYNC, f"j1939 {verb}").explained("Columns")))

    def test_what_is_wrong_is_told(self):
        for arguments, words in ((("j1939", "send", "FEF1"), "PGN: found"), (("j1939", "send", "40000"), "00000..3FFFF"), (("j1939", "send", "0EF21"), "by --to"),
                                 (("j1939", "send", "0FEF1", "0"), "DATA: found"), (("j1939", "send", "0FEF1", "00" * 1786), "up to 1785 bytes"),
                                 (("j1939", "send", "0FEF1", "00", "--to", "254"), "--to: found 254"), (("j1939", "request", "0FEF1", "--priority", "8"), "--priority"),
                                 (("j1939", "messages", "--count", "0"), "--count")):
            result = self.place.run(*arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(words, result.stderr)
        refused = self.one("j1939", "send", "0FEF1", "00", "--to", "0x23", code=3)
        self.assertEqual((refused["result"], refused["cause"]), ("refused", "field"))


class Secured(SecuredCase):
    CONFIG = CONFIG

    def test_each_does_what_its_role_may(self):
        self.assertTrue(json.loads(self.place.run("status", "--json").stdout)["secured"])
        self.expect_done("j1939", "messages", "--count", 1)
        self.expect_done("j1939", "addresses")
        for arguments in (("j1939", "send", "0xFEF1", "01"), ("j1939", "request", "0xFEEB", "--to", "0x23")):
            self.expect_no_right("MessageRequest", "operator", *arguments)
        self.become("operator")
        wait_for("the operator sends", lambda: self.place.run("j1939", "send", "0xFEF1", "01").returncode == 0)


class Periodic(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.place = place = Place()
        folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        config = os.path.join(folder, "bus.toml")
        with open(config, "w", encoding="utf-8") as file:
            file.write(f'[bus]\nprotocol = "j1939"\nname = "{place.bus}"\n[dds]\ndomain = {place.domain}\n'
                       '[[provide]]\nnumber = 0\npgn = 0xFEE5\ndata = [1, 2]\nperiod_ms = 50\n'
                       '[address]\npreferred = 0x21\n[[receive]]\nnumber = 0\nfirst = 0xFEF1\n[sim]\nfault_script = "faults.toml"\n')
        with open(os.path.join(folder, "faults.toml"), "w", encoding="utf-8") as file:  # an interval is a millisecond
            file.write('[[fault]]\nkind = "inject"\nframe = "18FEF142#0102"\nprobability = 0.1\n')
        with open(os.path.join(folder, "log"), "wb") as log:
            daemon = subprocess.Popen([CANSYNCD, config], stdout=log, stderr=log)
        cls.addClassCleanup(lambda: end(daemon))

    def test_a_group_is_sent_by_itself(self):
        # Nobody asks for anything, and a claim is one frame.
        wait_for("ten of its frames stood on the bus", lambda: (told := self.place.run("status", "--json")).returncode == 0
                 and json.loads(told.stdout)["sent"] > 10)

    def test_faults_of_a_script_are_on_the_bus(self):
        found = json.loads(self.place.run("j1939", "messages", "--json", "--count", 1).stdout)
        self.assertEqual((found["pgn"], found["source"], found["data"]), (0xFEF1, 0x42, [1, 2]))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *filter(None, sys.argv[1:])])

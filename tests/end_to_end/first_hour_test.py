"""What an engineer meets in the first hour with a line: docs/first-hour.md names these tests."""

import json
import os
import pty
import resource
import signal
import socket
import subprocess
import tempfile
import time
import unittest

from gateway import CANSYNC, CANSYNCD, LONG, Gateway, Place, end, wait_for
from verb_case import VerbTest

SETTING_UP = 0x43
# Far below the seconds of a search, far above what a loaded machine needs to hear a signal.
SOON = LONG / 4


class Unready(Gateway):
    """A line one of whose drives is switched off."""

    def wait_active(self):
        return self.wait_status(
            "setup with two of three slaves",
            lambda s: s["option_status"] == SETTING_UP and bin(s["slaves_synchronized"]).count("1") == 2,
        )


def findings(gateway, codes=(0, 1)):
    """What `doctor` finds; whether the kernel is a realtime one decides between 0 and 1."""
    result = gateway.run("doctor", "--json")
    if result.returncode not in codes:
        raise AssertionError(f"doctor: {result.returncode}\n{result.stdout}\n{result.stderr}")
    return {finding["topic"]: finding for finding in map(json.loads, result.stdout.splitlines())}


class Doctor(unittest.TestCase):
    def test_names_the_slave_that_keeps_the_line_in_set_up(self):
        with Unready(slaves=3, options=("--set", "sim.drives=[0,1]")) as gateway:
            found = findings(gateway, (8,))
        self.assertEqual(found["operating state"]["level"], "error")
        self.assertEqual(found["slave"]["found"], "slave 2 'slave2' has never answered")
        self.assertIn("slave number", found["slave"]["remedy"])

    def test_looks_at_operating_state_and_references(self):
        with Gateway(slaves=2) as gateway:
            # Each slave's own status follows the master's within a moment.
            found = wait_for("all slaves are well", lambda: (lambda all: all if "slaves" in all else None)(
                findings(gateway, (0, 1, 8))))
            self.assertEqual(found["operating state"]["level"], "ok")
            self.assertEqual(found["slaves"]["found"], "all 2 answer and are synchronized")
            self.assertEqual(found["references 1"]["found"], "nobody has given any")
            with gateway.start("set", "0=1") as writer:
                gateway.wait_status("values are released", lambda s: s["reference_release"][0]["state"] == "released")
                self.assertIn("cansync", findings(gateway)["references 1"]["found"])
                writer.kill()
            gateway.wait_status("the writer is lost", lambda s: s["reference_release"][0]["cause"] == "writer_lost")
            self.assertEqual(findings(gateway)["references 1"]["level"], "warning")
            gateway.run("mode", "stop")
            found = findings(gateway)["operating state"]
            self.assertEqual(found["level"], "warning")
            self.assertIn("cansync mode", found["remedy"])
            slave = gateway.json("slaves")[0]
            self.assertEqual((slave["state"], slave["responds"], slave["synchronized"]), (None, None, None))
            shown = gateway.run("slaves")
            self.assertRegex(shown.stdout.decode(), r"0 +slave0 +- +- +- ")
            self.assertIn("`cansync mode setup`, then `cansync mode run`", shown.stderr)
            self.assertIn("`cansync mode setup`, then `cansync mode run`", gateway.run("set", "0=1", "--seconds", "0.1").stderr)

    def test_tells_a_configuration_that_was_not_taken(self):
        with Gateway(slaves=1) as gateway:
            with open(gateway.config, encoding="utf-8") as file:
                right = file.read()
            with open(gateway.config, "a", encoding="utf-8") as file:
                file.write("[process]\npolling_1 = 99\n")
            gateway.process.send_signal(signal.SIGHUP)
            found = wait_for("doctor tells", lambda: findings(gateway).get("configuration"))
            self.assertIn("process.polling_1", found["found"])
            self.assertIn("reload_refused", [event["code"] for event in gateway.json("events")])
            time.sleep(1.1)  # two reloads within a second are taken for one
            with open(gateway.config, "w", encoding="utf-8") as file:
                file.write(right)
            gateway.process.send_signal(signal.SIGHUP)
            wait_for("doctor is content", lambda: "configuration" not in findings(gateway))


class Set(VerbTest):
    SLAVES = 1

    def given(self, number, *arguments):
        """The raw reference value that a `set` puts on the bus."""
        with self.gateway.start("set", *arguments, stderr=subprocess.DEVNULL) as writer:
            def follows():
                self.run_verb("control", 0, 0x87)  # acknowledges the fault that the end of another writer was
                values = self.one("watch", 0, "--count", 1)["values"]
                return number in [value["raw"] for value in values if value["value"] == 0]

            try:
                wait_for(f"the drive follows to {number}", follows)
            finally:
                end(writer)

    def is_given_by(self, status, process):
        telegram = status["reference_release"][0]
        return telegram["state"] == "released" and f"process {process} " in telegram["writer"]

    def test_a_name_means_the_unit_and_a_number_means_raw(self):
        self.given(2500, "target=2.5")
        self.given(700, "0=700")
        self.given(800, "target=800", "--raw")
        self.given(1500, "0=1.5", "--scaled")

    def test_a_name_that_is_unknown_is_told_with_those_there_are(self):
        self.assertIn("did you mean 'target'?; configured: target", self.fails("set", "tarjet=1", code=2))

    def without_effect(self, strength):
        """What it says of that; None: it was heard after all, for on a computer that stands still the other is taken for gone."""
        result = self.gateway.run("set", "0=5", "--strength", strength, "--seconds", 1)
        if result.returncode == 0:
            self.assertIn("reference_writer_taken_over", result.stderr)
            return None
        self.assertEqual(result.returncode, 10, result.stderr)
        return result.stderr

    def test_without_effect_it_says_who_is_heard_and_ends_with_a_code_of_its_own(self):
        with self.gateway.start("set", "0=100", "--strength", 3, stderr=subprocess.DEVNULL) as writer:
            try:
                # The status comes once a second: it may still be that of the test before.
                self.gateway.wait_status("it is heard", lambda s: self.is_given_by(s, writer.pid))
                for strength in (2, 1):
                    told = wait_for("it has no effect", lambda strength=strength: self.without_effect(strength))
                    self.assertIn(f"process {writer.pid} on host", told)
                    self.assertIn(f"nothing is given with strength {strength}", told)
                    self.assertIn("--strength 4 takes over", told)
                self.run_verb("set", "0=100", "--take-over", "--seconds", 3)
            finally:
                end(writer)
        self.run_verb("mode", "stop", "--yes")
        self.assertIn("no effect: the line was not", self.fails("set", "0=5", "--seconds", 0.1, code=10))

    def test_on_a_terminal_it_says_what_it_gives(self):
        shown, _ = self.gateway.run_on_terminal("set", "0=100", "--seconds", 0.1)
        self.assertIn("giving 0=100 for 0.1 s, with strength 1", shown)

    def test_read_and_write_take_scaled_as_well(self):
        self.assertIn("--scaled: slave 0: no profile", self.fails("read", 0, 1000, "--scaled", code=2))


class Interrupt(unittest.TestCase):
    """Ctrl-C and SIGTERM while there is nothing to cancel."""

    def ends_soon(self, number, *arguments):
        environment = dict(os.environ, CANSYNC_DOMAIN="1", CANSYNC_BUS="nobody")
        with subprocess.Popen([CANSYNC, *arguments], env=environment, stderr=subprocess.PIPE) as process:
            # The handlers are there, and DDS is up: from then on a search is all that happens.
            wait_for("it looks for the daemon", lambda: threads(process.pid) > 1)
            began = time.monotonic()
            process.send_signal(number)
            code = process.wait(LONG)
            self.assertLess(time.monotonic() - began, SOON, arguments)
            return code

    def test_ends_the_search_for_the_daemon(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            self.assertEqual(self.ends_soon(number, "--timeout", "600", "read", "0", "301"), 7)
            self.assertEqual(self.ends_soon(number, "--timeout", "600", "watch"), 7)
            self.assertEqual(self.ends_soon(number, "--timeout", "600", "wait", "gone"), 7)

    def test_wait_gone_needs_one_search_whatever_the_timeout_is(self):
        environment = dict(os.environ, CANSYNC_DOMAIN="1", CANSYNC_BUS="nobody")
        subprocess.run([CANSYNC, "wait", "gone", "--timeout", "600"], env=environment, check=True, timeout=LONG,
                       stderr=subprocess.DEVNULL)


def threads(process):
    return len(os.listdir(f"/proc/{process}/task"))


class Consent(VerbTest):
    """What reaches the whole line is not done by a slip of the hand."""

    def answered(self, answer, *arguments):
        """`cansync` on a terminal where somebody types an answer; what it showed, and its exit code."""
        terminal, other = pty.openpty()
        os.write(terminal, answer)
        process = self.gateway.start(*arguments, stdin=other, stdout=other, stderr=other)
        code = process.wait(LONG)
        shown = os.read(terminal, 65536).decode()
        os.close(other)
        os.close(terminal)
        return shown, code

    def test_on_a_terminal_it_asks(self):
        for arguments in (("mode", "restart"), ("mode", "stop"), ("broadcast", "--slaves", "all", "--command", 128),
                          ("write", "all", 1000, 1)):
            shown, code = self.answered(b"n\n", *arguments)
            self.assertIn("Go on? [y/N]", shown)
            self.assertIn("not done; nothing was sent", shown)
            self.assertEqual(code, 7)
        self.gateway.wait_active()
        shown, code = self.answered(b"y\n", "write", "all", 1000, 1)
        self.assertEqual((code, shown.count("slaves 0-3: 1 (")), (0, 1), shown)

    def test_what_takes_sync_or_values_from_a_program_names_it(self):
        with self.gateway.start("set", "0=100", stderr=subprocess.DEVNULL) as writer:
            try:
                self.gateway.wait_status("it leads", lambda s: f"process {writer.pid} " in s["reference_release"][0]["writer"])
                for mode in ("stop", "restart", "reset-can", "setup"):
                    said = self.fails("mode", mode, code=2)
                    self.assertRegex(said, rf"mode {mode}: .*process {writer.pid} on host .* gives the reference values of telegram 1; "
                                     r"slaves 0-3 report a fault without them: there is no terminal to ask on; nothing was sent; add --yes")
                said = self.fails("map", "references", 1, "0.low", code=2)
                self.assertRegex(said, rf"map references: the drives get other values in telegram 1 from the next interval on; .*"
                                 rf"process {writer.pid} on host .* gives the reference values of telegram 1: there is no terminal")
                self.run_verb("map", "references", 1, "0x01", "0x03", "0x05", "0x07", "--yes")
                shown, code = self.answered(b"n\n", "mode", "setup")
                self.assertEqual((code, f"process {writer.pid} " in shown), (7, True), shown)
                self.gateway.wait_active()
            finally:
                end(writer)
        self.gateway.wait_status("no program leads", lambda s: not s["reference_release"][0]["writer"])
        self.run_verb("mode", "reset-can")
        self.gateway.wait_active()
        self.run_verb("control", "all", 0x87)

    def test_without_a_terminal_it_says_what_to_add(self):
        for arguments in (("mode", "restart"), ("broadcast", "--slaves", "0-1", "--command", 128), ("write", "all", 1000, 2)):
            self.assertIn("add --yes", self.fails(*arguments, code=2))
        self.assertNotIn(2, [one["value"] for one in self.json("read", "all", 1000)])
        self.run_verb("broadcast", "--slaves", 0, "--command", 128)

    def test_dry_run_says_what_would_come(self):
        said = self.run_verb("mode", "stop", "--dry-run").stderr
        self.assertRegex(said, r"mode stop would be sent; bus \S+ \(process \d+ on host .+\) is in .+ with 4 of 4 slaves; nothing was sent")
        self.run_verb("write", "all", 1000, 3, "--dry-run")
        self.run_verb("broadcast", "--slaves", "all", "--command", 128, "--dry-run")
        self.assertNotIn(3, [one["value"] for one in self.json("read", "all", 1000)])
        self.gateway.wait_active()


class Places(unittest.TestCase):
    """Daemons and clients of a domain have 120 places each on a computer."""

    def fill(self, domain, offset, count):
        for index in range(count):
            place = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.addCleanup(place.close)
            place.bind(("127.0.0.1", 7400 + 250 * domain + offset + 2 * index))

    def test_clients_that_fill_theirs_leave_the_daemon_its_own(self):
        with Gateway(slaves=2) as gateway:
            found = findings(gateway)["DDS places"]
            self.assertEqual(found["level"], "ok")
            gateway.look_no_more()
            self.fill(gateway.domain, 11, 100)
            found = findings(gateway)["DDS places"]
            self.assertEqual(found["level"], "warning")
            self.assertRegex(found["found"], r"1 of 120 places of daemons and 10\d of 120 of clients are taken \(python3\S* 100")
            for index in range(100, 120):
                self.fill(gateway.domain, 11 + 2 * index, 1)
            refused = gateway.run("status")
            self.assertEqual(refused.returncode, 6)
            self.assertRegex(refused.stderr, r"120 of 120 of clients are taken \(.*python3\S* 1[12]\d.*; end some of them, or use another domain")
            # The daemon starts anew all the same.
            self.assertEqual(gateway.stop(), 0)
            with open(gateway.log, "ab") as log:
                gateway.process = subprocess.Popen([CANSYNCD, *gateway.options, gateway.config], stdout=log, stderr=log)
            self.doCleanups()
            gateway.wait_active()

    def test_daemons_that_fill_theirs_are_named(self):
        place = Place()
        self.fill(place.domain, 10, 120)
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write(f"[bus]\nname = \"full\"\ninterface = \"sim\"\n[dds]\ndomain = {place.domain}\n[[slave]]\nnumber = 0\n")
            file.flush()
            result = subprocess.run([CANSYNCD, file.name], timeout=LONG, capture_output=True, check=False)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, rb"In it 120 of 120 places of daemons and \d+ of 120 of clients are taken \(python3\S* 120")


class Limits(unittest.TestCase):
    """Without enough file descriptors the DDS library ends the process; both programs look before it does."""

    def ended(self, program, descriptors):
        def limit():
            resource.setrlimit(resource.RLIMIT_NOFILE, (descriptors, descriptors))

        return subprocess.run(program, env=Place().environment, preexec_fn=limit, timeout=LONG, capture_output=True)

    def test_too_few_file_descriptors_are_named(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write("[bus]\nname = \"few\"\ninterface = \"sim\"\n[[slave]]\nnumber = 0\n")
            file.flush()
            for program, code in (([CANSYNC, "status"], 6), ([CANSYNCD, file.name], 1)):
                for descriptors in range(5, 11):
                    result = self.ended(program, descriptors)
                    self.assertEqual(result.returncode, code, (program, descriptors, result.stderr))
                    self.assertRegex(result.stderr, rb"needs \d+ file descriptors, \d are left .*LimitNOFILE=, ulimit -n")


if __name__ == "__main__":
    unittest.main(verbosity=2)

"""Two daemons of one bus name in one domain: the second does not start, or clients ask neither and say who they are.
One daemon of two buses: each is served as if it were alone."""

import json
import os
import re
import select
import signal
import socket
import subprocess
import time
import unittest

from gateway import CANSYNC, CANSYNCD, LONG, Gateway, end, wait_for

WORD = 1000  # a parameter of a simulated drive
BOTH = ("--set", "dds.name_in_use=event")


class TwoDaemons(unittest.TestCase):
    def setUp(self):
        self.gateway = self.enterContext(Gateway())
        self.first = self.name_of(self.gateway.process)

    @staticmethod
    def name_of(process):
        return f"process {process.pid} on host {socket.gethostname()}"

    def start_second(self, *options):
        """A second daemon, its log beside that of the first."""
        self.log = os.path.join(self.gateway.folder.name, "second.log")
        with open(self.log, "wb") as log:
            process = subprocess.Popen([CANSYNCD, *self.gateway.options, *options, self.gateway.config], stdout=log, stderr=log)
        self.addCleanup(lambda: process.poll() is None and end(process))
        return process

    def second_log(self):
        with open(self.log, encoding="utf-8", errors="replace") as file:
            return file.read()

    def batch(self):
        """A client that stays: `cansync batch`, and what asks it for the result of one line."""
        process = self.gateway.start("batch", "-", "--json", "--continue", stdin=subprocess.PIPE)
        self.addCleanup(process.__exit__, None, None, None)

        def ask(line):
            process.stdin.write(line.encode() + b"\n")
            process.stdin.flush()
            found = [process.next_object()]
            while "exit_code" not in found[-1]:
                found.append(process.next_object())
            return found[0]

        return ask

    def test_the_second_does_not_start_and_says_why(self):
        second = self.start_second()
        self.assertEqual(second.wait(LONG), 1, self.second_log())
        self.assertIn(self.first, self.second_log())
        self.assertIn(f"bus {self.gateway.bus} is served already", self.second_log())
        self.assertIn('dds.name_in_use = "event"', self.second_log())
        self.assertTrue(self.gateway.status())
        self.assertNotIn("second_daemon", self.gateway.log_text())

    def without_a_name(self, *arguments):
        environment = {name: value for name, value in self.gateway.environment.items() if name != "CANSYNC_BUS"}
        return subprocess.run([CANSYNC, *map(str, arguments)], env=environment, capture_output=True, text=True, timeout=LONG)

    def test_without_a_name_the_only_bus_is_taken_and_several_are_named(self):
        bus, domain = self.gateway.bus, self.gateway.domain
        taken = self.without_a_name("status", "--json")
        self.assertEqual((taken.returncode, taken.stderr), (0, f"cansync: bus {bus}, the only one in DDS domain {domain} on interface lo\n"))
        self.assertEqual(json.loads(taken.stdout)["bus"], bus)
        # A batch looks for it once.
        lines = os.path.join(self.gateway.folder.name, "lines")
        with open(lines, "w", encoding="ascii") as file:
            file.write(f"read 0 {WORD}\nread 1 {WORD}\n")
        self.assertEqual(self.without_a_name("batch", lines).stderr.count("the only one in"), 1)
        self.start_second("--set", "bus.name=press")
        def named():
            result = self.without_a_name("status")
            return "press" in result.stderr
        wait_for("both are named", named)
        result = self.without_a_name("mode", "stop", "--yes")
        self.assertEqual(result.returncode, 2, result.stderr)
        for name in (bus, "press"):
            self.assertIn(f"{name} (cansync-master)", result.stderr)
        self.assertIn("CANSYNC_BUS", result.stderr)
        self.gateway.wait_active()

    def test_a_verb_of_another_protocol_says_so_at_once(self):
        bus = self.gateway.bus
        for verb, name, needs in ((("can", "dump"), "can dump", "layer2"), (("slave", "references"), "slave references", "cansync-slave"),
                                  (("j1939", "faults"), "j1939 faults", "j1939")):
            result = self.gateway.run("--timeout", LONG, *verb)
            self.assertEqual((result.returncode, result.stderr), (6, f"cansync: bus {bus} is served as cansync-master; `{name}` needs {needs}\n"))

    def test_one_that_was_killed_a_moment_ago_is_in_nobodys_way(self):
        for _ in range(3):
            self.gateway.process.kill()
            self.gateway.process.wait(LONG)
            with open(self.gateway.log, "ab") as log:
                self.gateway.process = subprocess.Popen([CANSYNCD, self.gateway.config], stdout=log, stderr=log)
            self.gateway.wait_active()
        self.assertNotIn("is served already", self.gateway.log_text())

    def test_of_two_neither_is_asked(self):
        ask = self.batch()
        self.assertEqual(ask(f"write 1 {WORD} 1")["result"], "done")
        following = self.gateway.start("events", "--follow")
        self.addCleanup(following.__exit__, None, None, None)
        wait_for("it follows", lambda: select.select([following.stdout], [], [], 0.1)[0])
        second = self.start_second(*BOTH)
        names = (self.first, self.name_of(second))
        wait_for("the first tells of the second", lambda: f"another daemon serves bus {self.gateway.bus}: " in self.gateway.log_text())
        wait_for("the second tells of the first", lambda: f"another daemon serves bus {self.gateway.bus}: " in self.second_log())
        self.assertIn(names[1], self.gateway.log_text())
        self.assertIn(names[0], self.second_log())

        def refused():
            reply = ask(f"read 1 {WORD}")
            return reply["result"] == "refused" and all(name in reply["reason"] for name in names)

        wait_for("who knew one is told of both", refused)
        told = following.communicate(timeout=LONG)[1].decode()
        self.assertEqual(following.returncode, 6, told)
        self.assertTrue(all(name in told for name in names), told)
        reply = ask(f"write 1 {WORD} 4711")
        self.assertEqual(reply["result"], "refused")

        def not_connected():
            result = self.gateway.run("status")
            return result.returncode == 6 and all(name in result.stderr for name in names)

        wait_for("who comes now connects to neither", not_connected)

        def found():
            result = self.gateway.run("doctor", "--json")
            lines = [json.loads(line) for line in result.stdout.splitlines()]
            daemon = next(line for line in lines if line["topic"] == "daemon")
            return result.returncode == 8 and daemon["level"] == "error" and all(name in daemon["found"] for name in names)

        wait_for("the doctor finds it", found)
        self.assertEqual(end(second), 0)
        wait_for("the first tells that it is gone", lambda: "is gone: " in self.gateway.log_text())
        # It is the daemon that was asked before, so nothing has to be told.
        wait_for("the first is asked again", lambda: ask(f"read 1 {WORD}")["result"] == "done")
        self.assertEqual(ask(f"read 1 {WORD}")["value"], 1)
        for log in (self.gateway.log_text(), self.second_log()):
            self.assertNotIn("4711", log)


class OneDaemonOfTwoBuses(unittest.TestCase):
    def setUp(self):
        self.gateway = self.enterContext(Gateway())
        # The same daemon anew, with a second bus.
        self.assertEqual(end(self.gateway.process), 0)
        self.other = self.gateway.bus + "-other"
        self.path = os.path.join(self.gateway.folder.name, "other.toml")
        with open(self.gateway.config, encoding="utf-8") as file:
            text = file.read()
        with open(self.path, "w", encoding="utf-8") as file:
            file.write(text.replace(self.gateway.bus, self.other))
        self.began = len(self.gateway.log_text())
        with open(self.gateway.log, "ab") as log:
            self.gateway.process = subprocess.Popen([CANSYNCD, *self.gateway.options, self.gateway.config, self.path], stdout=log,
                                                    stderr=log)
        for bus in self.buses():
            self.told(f"{bus}: event .*on 'run'")

    def buses(self):
        return self.gateway.bus, self.other

    def told(self, pattern):
        wait_for(pattern, lambda: re.search(pattern, self.gateway.log_text()[self.began:]))

    def on(self, bus, *arguments):
        result = self.gateway.run("--bus", bus, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout.decode()

    def test_each_is_served_as_if_it_were_alone(self):
        for number, bus in enumerate(self.buses()):
            self.on(bus, "write", 1, WORD, 100 + number)
        for number, bus in enumerate(self.buses()):
            self.assertIn(str(100 + number), self.on(bus, "read", 1, WORD))
            status = json.loads(self.on(bus, "status", "--json"))
            self.assertEqual(status["process"], self.gateway.process.pid)
        self.on(self.other, "mode", "setup")
        self.assertRegex(self.on(self.other, "status"), r"state +setup")
        self.assertRegex(self.on(self.gateway.bus, "status"), r"state +run")

    def test_clients_that_hang_on_four_buses_do_not_hold_up_the_stop(self):
        self.assertEqual(end(self.gateway.process), 0)
        with open(self.path, encoding="utf-8") as file:
            text = file.read()
        paths = [self.gateway.config, self.path]
        for number in (3, 4):
            paths.append(os.path.join(self.gateway.folder.name, f"bus{number}.toml"))
            with open(paths[-1], "w", encoding="utf-8") as file:
                file.write(text.replace(self.other, f"{self.other}{number}"))
        self.began = len(self.gateway.log_text())
        with open(self.gateway.log, "ab") as log:
            self.gateway.process = subprocess.Popen([CANSYNCD, *self.gateway.options, *paths], stdout=log, stderr=log)
        for bus in (*self.buses(), f"{self.other}3", f"{self.other}4"):
            self.told(f"{bus}: event .*on 'run'")
            client = self.enterContext(self.gateway.start("--bus", bus, "batch", "-", "--json", stdin=subprocess.PIPE))
            client.stdin.write(f"read 1 {WORD}\n".encode() * 100)
            client.stdin.flush()
            client.next_object()
            client.send_signal(signal.SIGSTOP)  # the next read is under way
            self.addCleanup(client.kill)
        began = time.monotonic()
        self.assertEqual(end(self.gateway.process), 0)
        self.assertLess(time.monotonic() - began, 10, "TimeoutStopSec= of the unit")

    def test_a_second_daemon_of_one_of_them_does_not_start(self):
        second = subprocess.run([CANSYNCD, *self.gateway.options, self.path], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(second.returncode, 1)
        self.assertIn(f"bus {self.other} is served already", second.stderr)
        self.assertIn(f"process {self.gateway.process.pid} on host {socket.gethostname()}", second.stderr)

    def test_files_are_read_again_and_one_that_is_wrong_changes_its_own_bus_alone(self):
        with open(self.path, "a", encoding="utf-8") as file:
            file.write("[nonsense]\n")
        self.gateway.process.send_signal(signal.SIGHUP)
        self.told(f"{self.other}: {self.path} is wrong; the daemon keeps running as before")
        self.told(f"{self.gateway.bus}: event .* configuration_reloaded")
        self.on(self.other, "read", 1, WORD)

    def test_files_that_do_not_go_together_are_refused(self):
        wrong = subprocess.run([CANSYNCD, self.gateway.config, self.path, self.path], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(wrong.returncode, 78)
        self.assertIn(f"{self.path}: bus.name: {self.other} in DDS domain ", wrong.stderr)
        self.assertIn("each bus needs a name of its own", wrong.stderr)

    def test_of_several_the_file_that_keeps_all_from_starting_is_named(self):
        path = os.path.join(self.gateway.folder.name, "third.toml")
        with open(self.path, encoding="utf-8") as other, open(path, "w", encoding="utf-8") as file:
            file.write(other.read().replace(self.other, self.other + "2").replace('"sim"', '"lo"', 1))
        fourth = path + ".toml"
        with open(self.path, encoding="utf-8") as other, open(fourth, "w", encoding="utf-8") as file:
            file.write(other.read().replace(self.other, self.other + "3"))
        result = subprocess.run([CANSYNCD, *self.gateway.options, fourth, path], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn(f"{path}: lo is no CAN interface", result.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)

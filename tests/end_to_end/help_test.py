"""What the help says of a running line: the columns of every table, and what a shell offers at TAB. No verb hands on the
control characters of others."""

import os
import pty
import re
import select
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "manual"))
from help_text import help_of, helps

from gateway import CANSYNC, LONG, wait_for
from names_test import PROFILE, PROFILES
from verb_case import VerbTest

COMPLETIONS = os.path.join(os.path.dirname(__file__), "..", "..", "tools", "completions", "cansync")
LOG = "(1.000000) can0 080#\n(1.000100) can0 300#\n"

# A run of each verb that prints a table, and the lines above its heading. Verbs without a table say so with None.
TABLES = {
    "slaves": (["slaves"], ""),
    "read": (["read", "winder", "100", "--every", "1", "--count", "1"], ""),
    "jobs": (["jobs"], ""),
    "clients": (["clients"], ""),
    "buses": (["buses"], ""),
    "timing": (["timing"], r"^Starts in us"),
    "doctor": (["doctor"], ""),
    "watch": (["watch", "--parameter", "100", "--count", "1"], ""),
    "events": (["events"], ""),
    "trace": (["trace", "LOG"], ""),
    "scan": (["scan", "LOG"], ""),
    "learn": (["learn", "LOG"], ""),
    "poll": (["poll"], ""),
    "map": (["map"], ""),
    "params": (["params", "winder"], ""),
    "diff": (["diff", "BACKUP", "winder"], ""),
    "verify": (["verify", "winder", "BACKUP"], ""),
    "restore": (["restore", "winder", "BACKUP", "--dry-run"], ""),
    **dict.fromkeys("status cancel write upload download control broadcast mode release set backup record plot wait batch setup".split()),
}


# Their tables are looked at by the tests of their protocol.
OF_OTHER_PROTOCOLS = {"can", "can dump", "can send", "can queues", "can timers", "can script", "can objects", "can image", "can lead", "can configure", "j1939", "j1939 messages", "j1939 send", "j1939 request", "j1939 addresses", "j1939 faults",
                      "slave", "slave references", "slave actual", "slave serve"}


class Columns(VerbTest):
    OPTIONS = ("--set", f"slave.1.profile={PROFILE}")

    def backup(self, folder):
        """A backup of winder, which holds something else meanwhile."""
        self.gateway.environment["CANSYNC_PROFILES"] = PROFILES
        path = os.path.join(folder, "backup")
        self.run_verb("backup", "winder", path)
        self.run_verb("write", "winder", 400, 77)
        return path

    def test_every_heading_is_explained(self):
        told = helps(CANSYNC)
        self.assertEqual(set(TABLES), set(told) - {""} - OF_OTHER_PROTOCOLS, "a new verb is to be added to TABLES")
        with tempfile.TemporaryDirectory() as folder:
            places = {"LOG": os.path.join(folder, "log"), "BACKUP": self.backup(folder)}
            with open(places["LOG"], "w", encoding="ascii") as log:
                log.write(LOG)
            for verb, table in TABLES.items():
                explained = told[verb].explained("Columns")
                if table is None:
                    self.assertEqual(explained, {}, verb)
                    continue
                arguments = [places.get(word, word) for word in table[0]]
                lines = self.gateway.run(*arguments).stdout.decode().splitlines()
                above = next((i + 1 for i, line in enumerate(lines) if table[1] and re.match(table[1], line)), 0)
                found = [self.general(heading) for heading in re.split("  +", lines[above].strip())]
                self.assertEqual(list(dict.fromkeys(found)), list(explained), f"{verb}: {lines[above]}")
                for heading, text in explained.items():
                    self.assertGreater(len(text), 5, f"{verb}: {heading}")

    @staticmethod
    def general(heading):
        """The heading as the help has it: values stand under their name or number."""
        if heading.startswith("PARAMETER "):
            return "PARAMETER n"
        return "VALUE n" if heading == "position" or heading.startswith("VALUE ") else heading

    def test_every_line_of_the_status_is_explained(self):
        explained = help_of(CANSYNC, "status").explained("Lines")
        labels = set()
        for line in self.text("status").splitlines():
            labels.add(re.sub(r"^(reference telegram|reference value) \d$", r"\1", line[:22].strip()))
        general = {re.sub(r" (1, 2|n)$", "", label) for label in explained}
        self.assertEqual(labels - general, set())
        self.assertEqual(general - labels, {"configuration", "restart", "network", "SYNC line", "second master", "cluster",  # only when there is one
                                            # of other protocols
                                            "frames received", "frames sent", "bus load", "module",
                                            "address", "messages received", "in packets", "messages sent", "load of the bus",
                                            "slave", "intervals", "reference values", "actual values", "fault", "answers",
                                            "response", "indicators", "parameters"})


OWN_COLOURS = rb"\x1b\[(3[123]|0)m"
OWN_SCREEN = rb"\x1b\[(2J|H|K|J)"  # of `watch --count`
CONTROLS = rb"[\x00-\x08\x0b-\x1f\x7f]|\xc2[\x80-\x9f]"


class ForeignTexts(VerbTest):
    """A program whose name would clear the screen, set its title and sound the bell."""

    NAME = "evil\x1b[2J\x1b]0;t\x07\x9b2K"

    def shown(self, *arguments):
        """Both streams, without what `cansync` itself sends to a terminal."""
        out = b""
        for colour in ("always", "never"):
            result = self.gateway.run("--color", colour, *arguments)
            text = result.stdout + result.stderr.encode()
            text = re.sub(OWN_COLOURS, b"", text) if colour == "always" else text
            out += re.sub(OWN_SCREEN, b"", text) if arguments[0] == "watch" else text
        return out

    def test_no_verb_writes_them(self):
        writer = subprocess.Popen([os.environ["STAMPED_WRITER"], str(self.gateway.domain), self.gateway.bus, "20", "1", self.NAME],
                                  stdout=subprocess.DEVNULL)
        self.addCleanup(writer.wait, LONG)
        self.addCleanup(writer.kill)
        wait_for("the program is there", lambda: "given by 'evil" in self.text("status"))
        folder = self.enterContext(tempfile.TemporaryDirectory())
        log = os.path.join(folder, "log")
        with open(log, "w", encoding="utf-8") as file:
            file.write(f"# {self.NAME}\n{LOG}{self.NAME}\n")
        runs = [[log if word == "LOG" else word for word in table[0]] for table in TABLES.values() if table and "BACKUP" not in table[0]]
        everything = b""
        for run in [*runs, ["status"], ["set", "0=1", "--seconds", "1"], ["mode", "stop"]]:
            shown = self.shown(*run)
            self.assertNotRegex(shown, CONTROLS, run)
            everything += shown
        self.assertIn(b"evil\\x1b[2J", everything, "they are shown as something else")


class Completion(VerbTest):
    def offered(self, *words):
        result = self.gateway.run("--complete", *words)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return result.stdout.decode().split()

    def until(self, words, wanted):
        """Looks again while a loaded machine takes longer than the search may: what was never there fails."""
        deadline = time.monotonic() + LONG
        while (found := self.offered(*words)) != wanted and time.monotonic() < deadline:
            pass
        self.assertEqual(found, wanted)

    def test_slaves_and_values_of_the_running_daemon(self):
        slaves = ["all", "0", "slave0", "1", "winder", "2", "slave2", "3", "slave3"]
        self.until(["read", ""], slaves)
        self.until(["--json", "read", "win"], ["winder"])
        self.until(["broadcast", "--slaves", "0,w"], ["0,winder"])
        self.until(["control", "0,w"], ["0,winder"])
        self.until(["read", "a"], ["all"])
        self.until(["wait", "released", "2,win"], ["2,winder"])
        self.until(["set", "t"], ["target="])
        self.until(["record", "x.csv", "--values", "po"], ["position"])
        self.until(["map", "winder", "1", "posi"], ["position.low", "position.high"])

    def test_options_that_are_typed_already_choose_the_daemon(self):
        environment = self.gateway.environment
        domain, bus = environment.pop("CANSYNC_DOMAIN"), environment.pop("CANSYNC_BUS")
        try:
            self.until(["--domain", domain, f"--bus={bus}", "read", "win"], ["winder"])
            self.assertEqual(self.offered("--domain", domain, "--bus", "other", "read", "win"), [])
        finally:
            environment.update(CANSYNC_DOMAIN=domain, CANSYNC_BUS=bus)

    def test_tab_in_an_interactive_shell(self):
        """Typed on a terminal: TAB completes the verb, then the slave's name."""
        terminal, other = pty.openpty()
        environment = dict(self.gateway.environment, PATH=os.path.dirname(CANSYNC) + ":" + os.environ["PATH"],
                           PS1="ready> ", TERM="dumb", INPUTRC="/dev/null")
        shell = subprocess.Popen(["bash", "--norc", "--noprofile", "-i"], stdin=other, stdout=other, stderr=other,
                                 env=environment, start_new_session=True)
        os.close(other)
        try:
            self.await_text(terminal, "ready> ")
            os.write(terminal, f"source {os.path.abspath(COMPLETIONS)}; echo loa''ded\n".encode())
            self.await_text(terminal, "loaded\r\nready> ")
            self.assertEqual(self.completed(terminal, "cansync rea\t"), "cansync read ")
            deadline = time.monotonic() + LONG
            # A loaded machine takes longer than the search may. Each try is a line of its own.
            while (line := self.completed(terminal, "cansync read win\t")) != "cansync read winder ":
                self.assertEqual(line, "cansync read win")
                self.assertLess(time.monotonic(), deadline, "TAB did not complete the slave's name")
        finally:
            shell.kill()
            shell.wait(LONG)
            os.close(terminal)

    def completed(self, terminal, typed):
        """The line after the keys `typed`, said by the shell itself: ^A and ^E put it between quotes behind an echo."""
        os.write(terminal, typed.encode() + b"'\x01echo 'line: \x05\n")
        shown = self.await_text(terminal, "\nready> ")
        return re.findall(r"\nline: (.*)\r", shown)[-1]

    def await_text(self, terminal, wanted):
        """What came until `wanted` did."""
        shown = ""
        deadline = time.monotonic() + LONG
        while not shown.endswith(wanted):
            self.assertLess(time.monotonic(), deadline, f"{wanted!r} is not in {shown!r}")
            if select.select([terminal], [], [], 0.1)[0]:
                shown += os.read(terminal, 65536).decode()
        return shown


if __name__ == "__main__":
    unittest.main()

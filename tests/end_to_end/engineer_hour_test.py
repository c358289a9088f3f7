"""The engineer's hour: from a wrong configuration to a running line, a drive in fault and back, a backup, and home.

One daemon, one stranger, one thing after the other, as it is typed at the cabinet door. Each step looks at what the
stranger would look at: the exit status, and whether the words say what is the case and what to do next.
"""

import json
import os
import re
import signal
import subprocess
import unittest

from gateway import BIT_RATE, CANSYNCD, LONG, Gateway, end, wait_for
from names_test import PROFILE, PROFILES

SPEED_LIMIT, FAULT_CODE = 401, 310
RESET, RUNS = 0x87, 0x07  # control words of the simulated drive
PROVOKE, MISSING_REFERENCES = 128, 26


class EngineersHour(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        drives = [argument for slave in range(4) for argument in ("--set", f"slave.{slave}.profile={PROFILE}")]
        cls.line = Gateway(options=drives)
        cls.line.environment["CANSYNC_PROFILES"] = PROFILES

    def types(self, *words, code=0, says=()):
        """A command at the shell: its exit status, and what must stand in what it prints. Gives standard output."""
        done = self.line.run(*words)
        told = done.stdout.decode() + done.stderr
        self.assertEqual(done.returncode, code, f"cansync {' '.join(map(str, words))}\n{told}")
        for part in (says,) if isinstance(says, str) else says:
            self.assertIn(part, told, f"cansync {' '.join(map(str, words))}")
        return done.stdout.decode()

    def checks(self, text, *says, code):
        with open(self.line.config, "w", encoding="utf-8") as file:
            file.write(text)
        done = subprocess.run([CANSYNCD, "--check", self.line.config], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(done.returncode, code, done.stderr)
        for part in says:
            self.assertIn(part, done.stdout + done.stderr)

    def test_the_hour(self):
        for step in (self.asks_for_help, self.finds_no_daemon, self.writes_the_configuration, self.starts_the_line,
                     self.looks_at_a_narrow_terminal, self.reads_and_writes, self.gives_reference_values,
                     self.meets_a_fault, self.keeps_and_restores, self.records, self.stops_and_starts_again,
                     self.changes_the_configuration, self.goes_home):
            with self.subTest(step.__name__):
                step()

    def asks_for_help(self):
        self.assertEqual(self.types("help"), self.types("--help"))
        self.types("--help", says=("Looking at the line:", "Parameters and transfers:", "Exit codes:"))
        self.assertEqual(self.types("help", "read"), self.types("read", "--help"))
        self.assertRegex(self.types("version"), r"\Acansync \d+\.\d+\.\d+ \(.+, \w*\)\ndata model \d+; protocols: cansync-master, ")
        self.types("sttus", code=2, says="did you mean 'status'?")
        self.types(code=2, says="allowed: status, ")
        self.types("read", "0", "301", "--formt", "word", code=2, says="did you mean '--format'?")

    def finds_no_daemon(self):
        self.line.environment["CANSYNC_BUS"] = "nobody"
        self.types("status", "--timeout", 1, code=6, says=("no daemon found: looked for ", "is cansyncd running for bus nobody"))
        self.types("doctor", code=6, says="error")
        self.line.environment["CANSYNC_BUS"] = self.line.bus

    def writes_the_configuration(self):
        with open(self.line.config, encoding="utf-8") as file:
            right = file.read()
        self.checks(right.replace(f"bit_rate = {BIT_RATE}", "bit_rate = 300000"), "bus.bit_rate: found 300000; allowed: ", code=78)
        self.checks(right.replace("interface =", "interfaze ="), "line.toml:4:1: bus.interfaze: no such option", code=78)
        self.checks(right.replace('"winder"', f'"{"w" * 1000}"'), "... (1002 bytes); allowed: ", code=78)
        self.checks(right, "in order", code=0)

    def starts_the_line(self):
        self.line.__enter__()
        self.addClassCleanup(self.line.stop)
        self.types("wait", "run", "--timeout", LONG)
        self.types("wait", "released", "all", "--timeout", LONG)
        status = self.types("status", says=("run (0x0080)", "slaves released       0-3 (4 of 4)", "interval"))
        self.assertNotRegex(status, r"\d(ms|us|s)\b")
        self.assertRegex(self.types("slaves"), r"1 +winder +released +yes +yes +0x[0-9A-F]{4} ")
        self.assertIn("released", self.types("slaves", "winder"))

    def looks_at_a_narrow_terminal(self):
        def synchronized():
            return all(slave["synchronized"] for slave in self.line.json("slaves"))

        wait_for("the slaves' own status follows", synchronized)
        for verb in ("status", "slaves", "doctor"):
            for columns in (80, 120):
                shown, _ = self.line.run_on_terminal(verb, columns=columns)
                lines = re.sub(r"\x1b\[[0-9;]*m", "", shown).splitlines()
                self.assertLess(max(map(len, lines)), columns, f"{verb} at {columns}:\n{shown}")
        narrow, _ = self.line.run_on_terminal("slaves")
        self.assertRegex(narrow, r"SLAVE +NAME +STATE +RESPONDS +SYNCHRONIZED +STATUS ")
        self.assertNotIn("JOBS ENDED", narrow)
        self.assertIn("--wide shows all", narrow)
        wide, _ = self.line.run_on_terminal("slaves", "--wide")
        self.assertEqual(wide.splitlines()[0], self.types("slaves").splitlines()[0])
        self.assertIn("JOBS ENDED", wide)

    def reads_and_writes(self):
        self.types("read", "winder", SPEED_LIMIT, says=" 0x")
        self.types("write", "winder", "speed-limit", 150000, says="150000 inc/s")
        self.assertEqual(json.loads(self.types("read", "winder", SPEED_LIMIT, "--json"))["value"], 150000)
        self.types("write", "winder", "lag", 2000, code=2, says="0.0..1000.0 ms")
        self.types("read", "winder", "sped-limit", code=2, says="sped-limit")
        self.types("read", 9, 301, code=3, says="slave 9: not configured; allowed 0..3")
        self.types("read", "0,9", 301, code=2, says=("SLAVE: 9 not configured", "configured are 0-3"))
        self.types("read", "0-3", "device-type", says=("VALUE", " 4400 "))
        self.types("params", "winder", "--group", "identity", says="serial-number")
        self.types("map", says="WRC1")
        self.types("poll", says="automatic")
        batch = "read winder device-type\nread 0,1 status-word\n"
        done = self.line.run("batch", "-", data=batch.encode())
        self.assertEqual((done.returncode, done.stdout.decode().count("device-type")), (0, 1), done.stderr)

    def gives_reference_values(self):
        self.types("set", "targt=2", code=2, says="did you mean 'target'?; configured: target")
        with self.line.start("set", "target=2.5", "--strength", 2, "--seconds", LONG) as writer:
            self.line.wait_status("values are released", lambda s: s["reference_release"][0]["state"] == "released"
                                  and f"process {writer.pid} " in s["reference_release"][0]["writer"])
            self.types("set", "0=7", "--seconds", 0.5, code=10, says=(f"process {writer.pid} on host", "--strength 3 takes over"))
            writer.send_signal(signal.SIGINT)
            out, told = writer.communicate(timeout=LONG)
        self.assertEqual((writer.returncode, out), (0, b""), told)
        self.assertRegex(told.decode(), r"sent \d+ reference values? to telegrams? \d.*; released")

    def meets_a_fault(self):
        self.types("control", "winder", RESET)
        self.types("broadcast", "--slaves", "winder", "--command", PROVOKE, "--word", MISSING_REFERENCES)
        wait_for("the drive faults", lambda: "reference values missing" in self.types("read", "winder", "fault-code"))
        wait_for("slaves says so", lambda: re.search(r"winder .* fault", self.types("slaves")))
        told = self.line.run("doctor").stdout.decode()
        self.assertRegex(told, r"error +drive fault +(slave 1 'winder'|\d slaves \([0-9,-]+\)): fault")
        self.assertIn("fix: remove the cause", told)
        self.types("control", "winder", RESET)
        self.types("control", "winder", RUNS)
        wait_for("the fault is gone", lambda: not re.search(r"winder .* fault", self.types("slaves")))

    def keeps_and_restores(self):
        folder = self.line.folder.name
        kept = os.path.join(folder, "{name}.toml")
        self.types("backup", "all", kept, says="slave 1: ")
        self.types("verify", "winder", kept)
        self.types("write", "winder", "speed-limit", 90000)
        self.types("verify", "winder", kept, code=9, says=("speed-limit", "differs from", "1 of ", ", 0 marks of identity"))
        self.types("restore", "winder", kept, "--dry-run", says="speed-limit")
        self.types("restore", "winder", kept)
        self.types("verify", "winder", kept, says="holds all ")
        sent, back = os.path.join(folder, "sent"), os.path.join(folder, "back")
        with open(sent, "wb") as file:
            file.write(bytes(range(250)))
        self.types("download", "winder", "0x100", sent, says="250 bytes in ")
        self.types("upload", "winder", "0x100", 250, back, says="250 bytes in ")
        with open(back, "rb") as file:
            self.assertEqual(file.read(), bytes(range(250)))
        self.types("upload", "winder", "0x10", 4, back, code=3, says="allowed 0x100..0xFFFFFFFF")

    def records(self):
        path = os.path.join(self.line.folder.name, "run.csv")

        def lines():
            with open(path, encoding="utf-8") as file:
                return file.read().splitlines()

        with self.line.start("record", path, "winder") as recorder:
            wait_for("the recording has begun", lambda: os.path.exists(path))
            with self.line.start("set", "0=100", "--seconds", LONG) as writer:
                try:
                    wait_for("it has rows", lambda: len(lines()) > 10)
                    recorder.send_signal(signal.SIGINT)
                    _, told = recorder.communicate(timeout=LONG)
                finally:
                    end(writer)
        self.assertEqual(recorder.returncode, 0, told.decode())
        self.assertIn("missing", told.decode())
        rows = lines()
        self.assertTrue(rows[0].startswith("time,seconds,receive_time_ns,interval,slave,name,position [mm]"), rows[0])
        self.types("control", "all", RESET)
        self.types("timing", "--seconds", 1, says=("an interval takes 8 ms", "bus load"))
        self.types("events", "--level", "warning", "--since", "1h")
        self.types("events", "--code", "state_changed", says="to 'run' on 'run'")

    def stops_and_starts_again(self):
        self.types("mode", "stop", "--yes")
        self.types("wait", "stop", "--timeout", LONG)
        both = "`cansync mode setup`, then `cansync mode run`"
        self.types("slaves", says=("the line is in stop", both))
        self.types("set", "0=1", "--seconds", 0.1, code=10, says=both)
        self.types("read", "winder", 100, code=3, says=("the master is in stop", "give mode setup"))
        self.types("mode", "run", code=3, says="run is entered from setup alone: give mode setup, then mode run")
        self.types("mode", "setup")
        self.types("wait", "released", "all", "--timeout", LONG)
        self.types("mode", "run")
        self.types("wait", "run", "--timeout", LONG)
        self.types("read", "winder", 100, says="4400")

    def changes_the_configuration(self):
        with open(self.line.config, encoding="utf-8") as file:
            right = file.read()
        with open(self.line.config, "w", encoding="utf-8") as file:
            file.write(right + "[process]\npolling_1 = 99\n")
        self.line.process.send_signal(signal.SIGHUP)
        wait_for("the refusal is told", lambda: "reload_refused" in self.types("events"))
        self.assertIn("process.polling_1", self.line.run("doctor").stdout.decode())
        with open(self.line.config, "w", encoding="utf-8") as file:
            file.write(right)

    def goes_home(self):
        with self.line.start("events", "--follow") as follower:
            self.assertTrue(follower.next_line())
            self.assertEqual(self.line.stop(), 0)
            _, told = follower.communicate(timeout=LONG)
        self.assertEqual(follower.returncode, 6, told)
        self.assertIn(b"the daemon has gone", told)
        self.types("wait", "gone", "--timeout", LONG)


if __name__ == "__main__":
    unittest.main(argv=[__file__])

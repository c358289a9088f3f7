"""The adversary's hour: everything is done wrong, at bad moments, while one line runs. Nothing may crash, hang or get lost,
each refusal names what and where, and at the end the line runs as before, with no descriptor more than at the beginning.
"""

import fcntl
import os
import pty
import resource
import signal
import struct
import subprocess
import tempfile
import termios
import time
import unittest

from gateway import CANSYNC, CANSYNCD, LONG, Gateway, end, wait_for
from wording import expect_wording

SLOW = LONG / 4  # seconds; what takes longer hangs: nothing here takes one, and a loaded machine is ten times as slow
RIGHT = b'[bus]\nname = "hour"\ninterface = "sim"\n[[slave]]\nnumber = 0\n'
CONTENT = b"(1.000000) can0 080#\n"


def slaves(count):
    return RIGHT.split(b"[[")[0] + b"".join(b"[[slave]]\nnumber = %d\n" % number for number in range(count))


# What a file may be: its bytes, the exit status of --check, and what the error must say.
FILES = {
    "right": (RIGHT, 0, ""),
    "CR LF": (RIGHT.replace(b"\n", b"\r\n"), 0, ""),
    "byte order mark": (b"\xef\xbb\xbf" + RIGHT, 0, ""),
    "comments alone": (b"# nothing\n", 0, ""),
    "empty": (b"", 0, ""),
    "no line end": (RIGHT.rstrip(), 0, ""),
    "UTF-16": (RIGHT.decode().encode("utf-16"), 78, "the file is UTF-16; save it as UTF-8"),
    "UTF-16 without a mark": (RIGHT.decode().encode("utf-16-le"), 78, "save it as UTF-8"),
    "Latin-1": (RIGHT + '[[reference]]\nnumber = 0\nunit = "°"\n'.encode("latin-1"), 78, "save the file as UTF-8"),
    "binary": (bytes(range(256)), 78, ":1:"),
    "zeros": (bytes(1000), 78, ":1:"),
    "half a section": (b"[bus\nname", 78, ":1:5: "),
    "half a string": (b'[bus]\nname = "hour\n', 78, ":2:"),
    "key twice": (RIGHT + b"number = 0\n", 78, ":6:"),
    "section twice": (RIGHT + b"[bus]\n", 78, ":6:"),
    "slave twice": (RIGHT + b"[[slave]]\nnumber = 0\n", 78, "which line 5 has already"),
    "slave without a number": (RIGHT + b"[[slave]]\n", 78, "missing; allowed: 0..31"),
    "slave 32": (RIGHT.replace(b"number = 0", b"number = 32"), 78, "found 32; allowed: 0..31"),
    "slave -1": (RIGHT.replace(b"number = 0", b"number = -1"), 78, "found -1; allowed: 0..31"),
    "33 slaves": (slaves(33), 78, "found 32; allowed: 0..31"),
    "32 slaves": (slaves(32), 0, ""),
    "number as a string": (RIGHT.replace(b"number = 0", b'number = "0"'), 78, 'found "0"; allowed: 0..31'),
    "string as a number": (RIGHT.replace(b'"hour"', b"5"), 78, "bus.name: found 5; allowed: "),
    "number out of every range": (RIGHT.replace(b"number = 0", b"number = 99999999999999999999"), 78, ":5:"),
    "not a number": (RIGHT + b"[[reference]]\nnumber = 0\nname = \"a\"\nfactor = nan\n", 78, "allowed: a finite number"),
    "infinite": (RIGHT + b"[[reference]]\nnumber = 0\nname = \"a\"\nfactor = inf\n", 78, "allowed: a finite number"),
    "factor 0": (RIGHT + b"[[reference]]\nnumber = 0\nname = \"a\"\nfactor = 0.0\n", 78, "other than 0"),
    "bit rate nobody has": (RIGHT.replace(b"[[", b"bit_rate = 300000\n[["), 78, "bus.bit_rate: found 300000; allowed: "),
    "unknown key": (RIGHT.replace(b"name", b"nam"), 78, ":2:1: bus.nam: no such option; allowed in this section: "),
    "unknown section": (RIGHT + b"[buss]\n", 78, "buss: no such section; allowed: "),
    "section for a key": (RIGHT + b"[bus.name]\n", 78, ":"),
    "list for a word": (RIGHT.replace(b'"hour"', b'["hour"]'), 78, "bus.name: found "),
    "date for a word": (RIGHT.replace(b'"hour"', b"2026-11-25"), 78, "bus.name: found a value of type "),
    "long name": (RIGHT.replace(b"hour", b"h" * 100000), 78, "... (100002 bytes); allowed: "),
    "name of a path": (RIGHT.replace(b"hour", b"../etc"), 78, "allowed: 1..63 letters"),
    "control character": (RIGHT + b'name = "a\\u0007"\n', 78, "no control character"),
    "slave called all": (RIGHT + b'name = "all"\n', 78, 'found "all"; allowed: '),
    "deep key": (b".".join([b"a"] * 20000) + b" = 1\n", 78, "more than 16 parts"),
    "deep list": (b"a = " + b"[" * 20000 + b"]" * 20000 + b"\n", 78, ":1:"),
    "many errors": (b"[bus]\n" + b"".join(b"wrong%d = 1\n" % number for number in range(201)), 78, "and 181 more problems"),
}
LINES = (  # command lines, each of which is refused before anything is sent
    [], ["statuss"], ["--nope"], ["status", "extra"], ["read"], ["read", "0"], ["read", "", "301"],
    ["read", "32", "301"], ["read", "-1", "301"], ["read", "nobody", "301"], ["read", "0", "4096"], ["read", "0", "-1"],
    ["read", "0", "1e3"], ["read", "0", "0x"], ["read", "0,", "301"], ["read", "3-1", "301"], ["read", "0", "301", "--element", "8"],
    ["read", "0", "301", "--every", "0"], ["read", "0", "301", "--format", "byte"], ["write", "0", "1000"],
    ["write", "0", "1000", "1.5"], ["write", "0", "1000", "99999999999"], ["write", "0", "1000", "five"],
    ["set"], ["set", "target"], ["set", "target="], ["set", "=5"], ["set", "8=1"], ["set", "nosuch=1"], ["set", "target=nan"],
    ["set", "target=1e300"], ["set", "0=1", "--seconds", "-1"], ["control", "0"], ["control", "0", "65536"],
    ["broadcast", "--slaves", "all"], ["broadcast", "--slaves", "0x0", "--command", "1"],
    ["broadcast", "--slaves", "all", "--command", "300"], ["mode"], ["mode", "fly"], ["wait"], ["wait", "synchronised"],
    ["upload", "0", "0x100", "0", "-"], ["upload", "0", "0x100", "8", "/dev/full"], ["events", "--since", "yesterday"],
    ["events", "--level", "bad"], ["watch", "--interval", "0"], ["record"],
    ["--domain", "231", "status"], ["--domain", "x", "status"], ["--bus", "a b", "status"], ["--bus", "$(reboot)", "status"],
    ["--timeout", "0", "status"], ["--timeout", "nan", "status"], ["--retry", "-1", "status"], ["--color", "red", "status"],
    ["--types", "other", "status"], ["poll", "3", "auto"], ["map", "winder", "1", "nosuch.low"],
)


class AdversarysHour(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.line = cls.enterClassContext(Gateway())
        cls.folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        cls.first_state = cls.state()
        cls.descriptors = cls.open_descriptors()

    @classmethod
    def state(cls):
        return {slave["slave"]: slave["state"] for slave in cls.line.json("slaves")}

    @classmethod
    def open_descriptors(cls):
        return len(os.listdir(f"/proc/{cls.line.process.pid}/fd"))

    def tearDown(self):
        self.assertIsNone(self.line.process.poll(), self.line.log_text())

    @classmethod
    def tearDownClass(cls):
        """The line runs as before, and the daemon holds nothing more."""
        cls.line.wait_active()
        wait_for("every slave is as it was", lambda: cls.state() == cls.first_state)
        wait_for("the daemon holds no descriptor more", lambda: cls.open_descriptors() <= cls.descriptors)

    def ended(self, *words, data=b"", code=None, **options):
        """`cansync` as it is called badly: it ends soon, by itself, and says why in one way."""
        began = time.monotonic()
        done = subprocess.run([CANSYNC, *map(str, words)], input=data, capture_output=True, timeout=LONG,
                              env=self.line.environment, **options)
        self.assertLess(time.monotonic() - began, SLOW, words)
        self.assertGreaterEqual(done.returncode, 0, f"{words}: ended by signal {-done.returncode}")
        if code is not None:
            self.assertEqual(done.returncode, code, f"{words}\n{done.stdout}\n{done.stderr}")
        expect_wording(words, done.stdout, done.stderr)
        return done

    def test_files_of_every_kind(self):
        for name, (content, code, says) in FILES.items():
            with self.subTest(name):
                path = os.path.join(self.folder, "line.toml")
                with open(path, "wb") as file:
                    file.write(content)
                self.check(path, code, says)

    def check(self, path, code, says):
        began = time.monotonic()
        done = subprocess.run([CANSYNCD, "--check", path], capture_output=True, timeout=LONG)
        self.assertLess(time.monotonic() - began, SLOW)
        told = (done.stdout + done.stderr).decode()
        self.assertEqual(done.returncode, code, told[:2000])
        self.assertIn(says, told)
        self.assertLess(len(told), 30000)
        if code != 0:
            self.assertIn(path, told)
            self.assertLess(max(map(len, told.splitlines())), 2000)

    def test_what_is_no_file(self):
        loop, pipe, large = (os.path.join(self.folder, name) for name in ("loop", "pipe", "large"))
        os.symlink(loop, loop)
        os.mkfifo(pipe)
        with open(large, "wb") as file:
            file.truncate(100 * 1024 * 1024)
        for path, says in ((self.folder, "it is a folder"), ("/dev/zero", "it is a device"), (pipe, "it is a device, pipe"),
                           (loop, "symbolic links"), (large, "it has over 262144 bytes"), ("/nowhere/line.toml", "No such file")):
            with self.subTest(path):
                self.check(path, 78, says)

    def test_command_lines_that_are_wrong(self):
        for words in LINES:
            with self.subTest(words):
                done = self.ended(*words, code=2)
                self.assertEqual(done.stdout, b"")
                self.assertTrue(done.stderr.startswith(b"cansync: "), done.stderr)

    def test_places_that_are_full_or_closed(self):
        with open("/dev/full", "wb") as full:
            for words in (["status"], ["slaves"], ["events"], ["read", "0", "100"], ["help"], ["read", "0", "100", "--json"]):
                done = subprocess.run([CANSYNC, *words], stdout=full, stderr=subprocess.PIPE, timeout=LONG, env=self.line.environment)
                self.assertEqual(done.returncode, 1, words)
                self.assertIn(b"No space left on device", done.stderr)
        self.assertIn(b"No space left on device", self.ended("record", "/dev/full", "--duration", 0.2, code=1).stderr)
        for words in (["download", 0, "0x100", "/nowhere/file"], ["batch", "/nowhere/batch"]):
            self.assertIn(b": No such file or directory", self.ended(*words, code=1).stderr)
        kept = os.path.join(self.folder, "kept")
        with open(kept, "wb") as file:
            file.write(CONTENT)
        self.ended("upload", 0, "0x10", 8, kept, code=3)
        with open(kept, "rb") as file:
            self.assertEqual(file.read(), CONTENT, "a transfer that failed leaves the old file")
        for descriptor in (0, 1, 2):
            code = subprocess.run([CANSYNC, "status"], env=self.line.environment, timeout=LONG, stdin=subprocess.DEVNULL,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, preexec_fn=lambda: os.close(descriptor)).returncode
            self.assertIn(code, (0, 1), f"without descriptor {descriptor}")

    def test_a_reader_that_goes_away(self):
        with self.line.start("events", "--follow") as follower:
            wait_for("it writes", follower.stdout.readline)
            follower.stdout.close()
            self.line.run("mode", "reset-can")  # an event more
            wait_for("it ends", lambda: follower.poll() is not None)
            self.assertIn(follower.returncode, (-signal.SIGPIPE, 0))
            self.assertEqual(follower.stderr.read(), b"")

    def test_ctrl_c_as_soon_as_it_begins_and_later(self):
        record = os.path.join(self.folder, "record.csv")
        for words in (["watch", "--plain"], ["record", record, "--force"], ["events", "--follow"], ["set", "0=1"],
                      ["wait", "bus-off"], ["timing", "--follow"], ["read", "0", "100", "--every", "0.1"], ["upload", "0", "0x100", "1000000", "-"]):
            for number in (signal.SIGINT, signal.SIGTERM):
                with self.subTest(words, signal=number), self.line.start(*words) as process:
                    wait_for("its handlers are there", lambda: len(os.listdir(f"/proc/{process.pid}/task")) > 1)
                    process.send_signal(number)
                    began = time.monotonic()
                    out, told = process.communicate(timeout=LONG)
                    self.assertLess(time.monotonic() - began, SLOW)
                    self.assertIn(process.returncode, (0, 7, 10), (out[-200:], told))

    def test_no_descriptors_no_terminal_no_room(self):
        def few():
            resource.setrlimit(resource.RLIMIT_NOFILE, (8, 8))

        self.assertIn(b"LimitNOFILE=, ulimit -n", self.ended("status", code=6, preexec_fn=few).stderr)
        for variables in ({"TERM": "no-such"}, {"TERM": ""}, {"LC_ALL": "C"}, {"LC_ALL": "xx_XX.UTF-8"}, {"HOME": ""},
                          {"COLUMNS": "-5"}, {"NO_COLOR": "1"}, {"TZ": "Nowhere/Atall"}):
            done = subprocess.run([CANSYNC, "events"], env={**self.line.environment, **variables}, capture_output=True, timeout=LONG)
            self.assertEqual(done.returncode, 0, (variables, done.stderr))
        for variable, value in (("CANSYNC_DOMAIN", "x"), ("CANSYNC_BUS", "a/b/c"), ("CANSYNC_TYPES", "y")):
            done = subprocess.run([CANSYNC, "status"], env={**self.line.environment, variable: value}, capture_output=True, timeout=LONG)
            self.assertEqual(done.returncode, 2, (variable, done.stderr))
        for rows, columns in ((1, 1), (0, 0), (5, 20), (60, 1000)):
            for verb in ("status", "slaves", "doctor"):
                terminal, other = pty.openpty()
                fcntl.ioctl(other, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
                with subprocess.Popen([CANSYNC, verb], env=self.line.environment, stdin=other, stdout=subprocess.DEVNULL,
                                      stderr=other) as process:
                    self.assertIn(process.wait(LONG), (0, 1), verb)
                os.close(other)
                os.close(terminal)

    def test_another_master_of_the_same_name(self):
        again = subprocess.run([CANSYNCD, *self.line.options, self.line.config], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(again.returncode, 1, again.stderr)
        self.assertIn(f"process {self.line.process.pid} on host", again.stderr)

    def test_clients_that_are_killed(self):
        processes = [self.line.start("upload", slave, "0x100", 1000000, "-", stdout=subprocess.DEVNULL) for slave in range(3)]
        processes += [self.line.start("set", "0=1", "--strength", strength) for strength in (1, 2)]
        self.line.wait_status("a transfer is open", lambda status: status["open_transfers"] > 0)
        for process in processes:
            process.kill()
            process.communicate(timeout=LONG)
        self.line.wait_status("nothing is left of them", lambda status: status["open_transfers"] == 0)
        self.line.run("control", "all", 0x87)

    def test_a_line_that_is_stopped_while_everybody_works(self):
        with self.line.start("upload", 0, "0x100", 1000000, "-", stdout=subprocess.DEVNULL) as upload, self.line.start("set", "0=1") as writer:
            try:
                self.line.wait_status("a transfer is open", lambda status: status["open_transfers"] == 1)
                self.assertEqual(self.line.run("mode", "stop", "--yes").returncode, 0)
                self.assertEqual(upload.wait(LONG), 7)
                self.assertEqual(self.line.run("read", 0, 100).returncode, 3)
                for mode in ("setup", "run"):
                    self.line.run("--retry", LONG, "mode", mode)
            finally:
                end(writer)
        self.line.wait_active()
        self.line.run("control", "all", 0x87)


if __name__ == "__main__":
    unittest.main(argv=[__file__])

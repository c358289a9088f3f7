"""Programs that name their drives, for an hour, against a daemon that is killed, reloaded with exchanged names, stopped and
exchanged for another: no command reaches another drive than the one that was named, no call waits longer than it may, and
nothing grows.

HOUR_INSTANTS: how often something happens to the daemon (default 12; before a release 500, which take over an hour of the
machine's own time). Seed: CANSYNC_SEED. NAMED_WRITER is the program in C++.
"""

import os
import pathlib
import random
import signal
import subprocess
import sys
import threading
import time
import unittest

from line import LONG, Line, cansync

from gateway import end, end_at_once, wait_for

INSTANTS = int(os.environ.get("HOUR_INSTANTS", "12"))
SEED = int(os.environ.get("CANSYNC_SEED", "1"))
MEAN_PAUSE = 7.0  # seconds between two of them
THOUGHTS = (0, 0, 0.1)  # seconds between two writes of a program
NUMBER = 1000  # it and the next keep what is written
MOST = 40.0  # seconds of one call: that of a request that nobody answers
DRIVES = (1, 3)
NAMES = ("winder", "unwinder")


class Names:
    """Who is called how, as far as it is known."""

    def __init__(self):
        self._lock = threading.Lock()
        self._now = dict(zip(NAMES, DRIVES))
        self._number = 0  # odd while it changes

    def change(self):
        """They are being exchanged from now on."""
        with self._lock:
            self._number += 1
            self._now = dict(zip(NAMES, reversed([self._now[name] for name in NAMES])))

    def changed(self):
        """They have been."""
        with self._lock:
            self._number += 1

    def of(self):
        """The drives by name, and the number of this state."""
        with self._lock:
            return dict(self._now), self._number


class Writer(threading.Thread):
    """Writes a value of its own to drives by name, again and again, and looks by number where it went."""

    def __init__(self, test, who, write):
        super().__init__(daemon=True)
        self.test, self.who, self.write = test, who, write
        self.done, self.while_changing, self.longest, self.faults = 0, 0, 0.0, []

    def run(self):
        dice = random.Random(f"{SEED} {self.who}")
        value = 0
        while not self.test.over.is_set():
            value = (value + 1) % 0x10000
            before, number = self.test.names.of()
            start = self.test.starts
            name = dice.choice(NAMES)
            began = time.monotonic()
            written = self.write(name, value)
            self.longest = max(self.longest, time.monotonic() - began)
            if written:
                changing = number % 2 == 1 or self.test.names.of()[1] != number
                self._look(None if changing else before[name], name, value, start)
            time.sleep(dice.choice(THOUGHTS))

    def _look(self, named, name, value, start):
        """The drive that was named has what was written and no other has it; None: either of them was, while names changed. Unless the
        daemon has gone meanwhile, and the simulated drives with it."""
        try:
            found = [drive for drive in DRIVES
                     if self.test.line.read(drive, NUMBER + self.test.offset(self.who), timeout=2.0).raw == value]
        except cansync.Error:
            return
        if self.test.starts != start:
            return
        self.done += 1
        self.while_changing += named is None
        if len(found) != 1 or named not in (None, *found):
            self.faults.append(f"{self.who}: {value} was written to '{name}', drive {named or DRIVES}; drives {found} have it")


class Hour(unittest.TestCase):
    def setUp(self):
        self.gateway = self.enterContext(Line())
        self.config = pathlib.Path(self.gateway.config)
        self.config.write_text(self.config.read_text(encoding="utf-8").replace(
            "[[slave]]\nnumber = 3\n", '[[slave]]\nnumber = 3\nname = "unwinder"\n'), encoding="utf-8")
        self.names = Names()
        self.reload(exchange=False)
        self.line = self.enterContext(self.gateway.connect())
        self.over = threading.Event()
        self.starts = 0  # of the daemon, with its drives

    def offset(self, who):
        return 0 if who == "python" else 1

    def exchange_in_file(self):
        text = self.config.read_text(encoding="utf-8")
        self.config.write_text(text.replace('"winder"', '"?"').replace('"unwinder"', '"winder"').replace('"?"', '"unwinder"'),
                               encoding="utf-8")
        self.names.change()

    def wait_for_names(self):
        """Until the daemon tells those of the file."""
        text = self.config.read_text(encoding="utf-8")
        first = NAMES[0] if text.index('"winder"') < text.index('"unwinder"') else NAMES[1]

        def told():
            try:
                with self.gateway.connect() as line:
                    return line.slave_status(DRIVES[0]).name == first
            except cansync.Error:
                return False

        wait_for("the daemon tells the names of the file", told, pause=0.1)

    def reload(self, exchange=True):
        if exchange:
            self.exchange_in_file()
        os.kill(self.gateway.process.pid, signal.SIGHUP)
        self.wait_for_names()
        if exchange:
            self.names.changed()

    def kill(self):
        self.starts += 1
        end_at_once(self.gateway.process)
        self.gateway.__enter__()

    def stop_and_exchange(self):
        self.starts += 1
        end(self.gateway.process)
        self.exchange_in_file()
        self.gateway.__enter__()
        self.wait_for_names()
        self.names.changed()

    def stand_still(self):
        os.kill(self.gateway.process.pid, signal.SIGSTOP)
        time.sleep(1.0)
        os.kill(self.gateway.process.pid, signal.SIGCONT)

    def write_with_python(self, name, value):
        try:
            self.line.write(name, NUMBER, value, timeout=2.0)
        except cansync.Error:
            return False
        return True

    def write_with_cpp(self, name, value):
        self.program.stdin.write(f"{name} {NUMBER + 1} {value}\n")
        self.program.stdin.flush()
        return self.program.stdout.readline().startswith("done")

    def memory(self, process):
        """Kilobytes."""
        for line in pathlib.Path(f"/proc/{process}/status").read_text(encoding="ascii").splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1])
        raise AssertionError(f"process {process} has no VmRSS")

    def test_every_command_is_for_who_was_named(self):
        dice = random.Random(SEED)
        self.program = self.enterContext(subprocess.Popen(
            [os.environ["NAMED_WRITER"], str(self.gateway.domain), self.gateway.bus], stdin=subprocess.PIPE,
            stdout=subprocess.PIPE, text=True))
        writers = [Writer(self, "python", self.write_with_python), Writer(self, "c++", self.write_with_cpp)]
        for writer in writers:
            writer.start()
        early = None
        for i in range(INSTANTS):
            time.sleep(dice.expovariate(1 / MEAN_PAUSE))
            dice.choice((self.reload, self.reload, self.kill, self.stop_and_exchange, self.stand_still))()
            if i == INSTANTS // 4:
                early = [self.memory(os.getpid()), self.memory(self.program.pid)]
        time.sleep(MEAN_PAUSE)
        late = [self.memory(os.getpid()), self.memory(self.program.pid)]
        self.over.set()
        for writer in writers:
            writer.join(MOST)
            self.assertFalse(writer.is_alive(), f"a call of {writer.who} does not end")
            self.assertEqual(writer.faults, [])
            self.assertLess(writer.longest, MOST, writer.who)
            self.assertGreater(writer.done, INSTANTS, f"{writer.who} was hardly ever answered")
        for before, after in zip(early, late):
            self.assertLess(after, 1.2 * before + 2000, "kilobytes")
        told = (f"{one.who} {one.done} writes, {one.while_changing} of them while names changed, longest {one.longest:.1f} s" for one in writers)
        print(f"seed {SEED}, {INSTANTS} instants: {'; '.join(told)}; kB {early} -> {late}")
        self.program.stdin.close()
        self.assertEqual(self.program.wait(LONG), 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])

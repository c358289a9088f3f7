"""From an unknown line to actual values in engineering units, as docs/operations.md says it, without a look at how the
line was configured.

    unknown_line.py [--lines N] [--first SEED] [--rates R,R]

Run by run_machine.py.

Each line is made at random by its seed (random_line.py); `cansync-sim` plays its drives on vcan0. What is compared at the
end is what the line's maker knows. The bit rate is given: a virtual interface has none, and no master runs that would tell it.
"""

import argparse
import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "end_to_end")]

from canline import CANSYNC_SIM, INTERFACE, Process, create_interface, interface_exists  # noqa: E402
from gateway import ACTIVE, CANSYNC, CANSYNCD, wait_for  # noqa: E402
from random_line import ECHO, POSITION, RandomLine, carried  # noqa: E402

LONG = 60  # seconds; one line
RATES = (125000, 250000, 500000, 1000000)
TARGET, ECHOED = 1234, 77  # raw reference values 0 and 4


class UnknownLine:
    """One line and the engineer in front of it."""

    def __init__(self, line, folder):
        self.line = line
        self.folder = folder
        self.times = {}
        self.seen = {}

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def command(self, *arguments):
        """A command of the engineer's, to its end; what it printed."""
        result = subprocess.run([CANSYNC, *map(str, arguments)], capture_output=True, text=True, timeout=LONG, check=False)
        if result.returncode != 0:
            raise AssertionError(f"{arguments}: {result.returncode}\n{result.stdout}{result.stderr}")
        return result.stdout

    def objects(self, *arguments):
        return [json.loads(text) for text in self.command(*arguments, "--json").splitlines()]

    @contextlib.contextmanager
    def timed(self, what):
        begin = time.monotonic()
        yield
        self.times[what] = round(time.monotonic() - begin, 2)

    def scan(self):
        with self.timed("scan"):
            found = self.objects("scan", INTERFACE, "--seconds", 1, "--bit-rate", self.line.bit_rate, "--ask", "--yes",
                                 "--profiles", self.path("maker", "profiles"), "--write", self.path("line"))
        answers = {one["slave"]: one for one in found if one["kind"] == "answer"}
        assert sorted(answers) == sorted(self.line.slaves), (sorted(answers), self.line.describe())
        for number, kind in self.line.slaves.items():
            assert answers[number]["profile"] == kind.name, (answers[number], kind.name)
            limit = self.line.block_limit[number]
            assert answers[number]["block_limit"] == (limit if kind.block else limit - limit % 6), answers[number]

    def set_up(self):
        with self.timed("setup"):
            self.command("setup", self.path("line"), "--sync", "can", "--start", "active", "--yes", "--root", self.path("root"))
        return self.path("root", "etc", "cansync", INTERFACE + ".toml")

    @contextlib.contextmanager
    def daemon(self, configuration):
        """The daemon while it runs; what gives its log."""
        with Process(CANSYNCD, configuration) as daemon:
            yield daemon.text

    def states(self):
        status = self.objects("status", "--bus", INTERFACE)[0]
        wanted = sum(1 << number for number in self.line.slaves)
        return status["slaves_synchronized"] == wanted and status["option_status"] == ACTIVE

    def values(self):
        """{slave: {value: object}} when everything that was asked for has come, else nothing."""
        seen = {one["slave"]: {value["value"]: value for value in one["values"]}
                for one in self.objects("watch", "--bus", INTERFACE, "--count", 1)}
        self.seen = seen
        for number in self.line.slaves:
            sent = {**carried(self.line.actual[number][0]), **carried(self.line.actual[number][1])}
            found = seen.get(number, {})
            if sorted(found) != sorted(sent):
                return None
            if POSITION in sent and found[POSITION]["raw"] != TARGET or ECHO in sent and found[ECHO]["raw"] != ECHOED:
                return None
        return seen

    def compare(self, seen):
        for number in self.line.slaves:
            for value, (name, unit, factor, offset) in self.line.named_values(number).items():
                found = seen[number][value]
                assert (found["name"], found["unit"]) == (name, unit), (number, found, name, unit)
                expected = found["raw"] * factor + offset
                assert abs(found["scaled"] - expected) <= 1e-6 * max(1, abs(expected)), (number, found, expected)

    def run(self):
        """The whole way; the seconds of each step."""
        begin = time.monotonic()
        # Telegrams that come late when the computer runs nobody for a while are no fault of a drive here: it would stand still.
        drives = Process(CANSYNC_SIM, "--config", self.line.write(self.path("maker"), INTERFACE), "--set", "sim.missing_references=0",
                         "--set", "sim.missing_edges=65535", "--lock-time", 50, "--verbose")
        with drives:
            drives.wait_text("SYNC frame 0x")
            self.scan()
            configuration = self.set_up()
            with self.daemon(configuration) as log, self.timed("run"):
                try:
                    self.watch()
                except AssertionError as error:
                    with open(configuration, encoding="utf-8") as file:
                        raise AssertionError(f"{self.line.describe()}: {error}\n{self.seen}\n{log()}\n{file.read()}") from error
        self.times["all"] = round(time.monotonic() - begin, 2)
        return self.times

    def watch(self):
        wait_for("the line is in active operation", lambda: self.tried(self.states), LONG)
        writer = subprocess.Popen([CANSYNC, "--bus", INTERFACE, "set", f"0={TARGET}", f"4={ECHOED}", "--rate", "20"])
        try:
            self.compare(wait_for("actual values", lambda: self.tried(self.values), LONG))
        finally:
            writer.send_signal(signal.SIGINT)
            writer.wait(LONG)

    @staticmethod
    def tried(condition):
        """What it gives; nothing while the daemon is not there yet."""
        try:
            return condition()
        except AssertionError as error:
            if "no daemon" in str(error):
                return None
            raise


def run_line(seed, rates=RATES, way=UnknownLine):
    """One line from its seed; the seconds of each step."""
    line = RandomLine(seed, rates)
    with tempfile.TemporaryDirectory(prefix="unknown_") as folder:
        times = way(line, folder).run()
    print(f"line {seed}: {line.describe()}: {times}", flush=True)
    return {"seed": seed, "bit_rate": line.bit_rate, "slaves": len(line.slaves), **times}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--lines", type=int, default=20)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--rates", type=lambda text: [int(rate) for rate in text.split(",")], default=RATES)
    given = parser.parse_args()
    if not interface_exists():
        create_interface()
    for seed in range(given.first, given.first + given.lines):
        run_line(seed, given.rates)


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Makes the pictures of the documentation from a simulated line: make.py FOLDER, for example docs/img.

CANSYNC and CANSYNCD are the programs, EXAMPLES is the folder of the built examples; without them those of build/dev.
Debian's own Python is needed (python3-pyte), and gnuplot-nox.
"""

import contextlib
import os
import random
import re
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
SOURCE = os.path.join(HERE, "..", "..")
sys.path.insert(0, HERE)
sys.path.insert(0, os.path.join(SOURCE, "tests", "end_to_end"))
for variable, place in (("CANSYNC", "tools/cli/cansync"), ("CANSYNCD", "daemon/cansyncd"), ("EXAMPLES", "tools/examples")):
    os.environ.setdefault(variable, os.path.abspath(os.path.join(SOURCE, "build", "dev", place)))

from gateway import CANSYNC, LONG, Gateway, wait_for
from screen_svg import screen_svg
from terminal import KIND, Terminal

PROFILES = os.path.abspath(os.path.join(SOURCE, "config", "profiles"))
RPM = 300
RUNS, STANDS, RESET = 0x0007, 0x0003, 0x0087  # control words of a simulated drive
# What makes the curves differ: a lag of 0.3 s; a slower stop, and no faster than 660 rpm after it.
SOFTER = (("dancer-1", 400, 3000), ("registration-1", 402, 500000), ("registration-1", 401, 720000))
FAULTY, PROVOKE, MISSING_REFERENCES = "dancer-1", 128, 26  # a user command of the simulated drive provokes a fault
PATIENCE = 3  # seconds until faults are acknowledged once more
LOOKS = 24  # so many points of the trends before the picture is taken


class DemoLine(Gateway):
    """The printing line of config/demo.toml, somewhere nobody else is."""

    def __init__(self):
        # At 500 kbit/s drives ride through twice the time that a loaded computer stalls.
        super().__init__(slaves=32, options=("--set", "dds.interval_topic=true", "--set", "sim.missing_references=0",
                                             "--set", "bus.bit_rate=500000"))

    def _toml(self, _):
        self.bus = f"press-{random.SystemRandom().randrange(1000, 10000)}"
        self.environment["CANSYNC_BUS"] = self.bus
        self.environment["CANSYNC_PROFILES"] = PROFILES
        with open(os.path.join(SOURCE, "config", "demo.toml"), encoding="utf-8") as file:
            text = file.read()
        text = text.replace('profile = "simulated-drive"', f'profile = "{PROFILES}/simulated-drive.toml"')
        return text.replace('name = "demo"', f'name = "{self.bus}"', 1) + f"\n[dds]\ndomain = {self.domain}\n"

    def lead(self, seconds):
        """An example program leads all drives, in two seconds to full speed; to be stopped by the caller."""
        program = os.path.join(os.environ["EXAMPLES"], "example_lead_axis")
        return subprocess.Popen([program, str(self.domain), self.bus, str(RPM), str(seconds)], stdout=subprocess.DEVNULL)

    def done(self, *arguments):
        result = self.run(*arguments)
        if result.returncode != 0:
            raise AssertionError(f"{arguments}: {result.stderr}")
        return result


    def acknowledging(self, condition):
        """`condition`, and now and then a reset of what has faulted because this computer stalled."""
        last = [0.0]

        def look(*arguments):
            if time.monotonic() - last[0] > PATIENCE:
                last[0] = time.monotonic()
                self.done("broadcast", "--yes", "--slaves", "all", "--command", 1, "--word", RESET)
            return condition(*arguments)

        return look


class Leading:
    """While this lives the line is led; begins when the drives move."""

    def __init__(self, line):
        self.line = line

    def __enter__(self):
        self.process = self.line.lead(LONG)

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait(LONG)


def make_timing(line, folder):
    """The diagram of an interval; an earlier one is not kept beside it."""
    picture = os.path.join(folder, "timing.svg")
    with contextlib.suppress(FileNotFoundError):
        os.remove(picture)
    with Leading(line):
        line.done("timing", "--seconds", 3, "--svg", picture)


def make_plot(line, folder):
    """A start of the line in which one drive is stopped for a while; the recording is removed afterwards."""
    recording, picture = os.path.join(folder, "line.csv"), os.path.join(folder, "plot.svg")
    line.done("poll", 1, "auto", 2, "auto", "--maximum", 3)  # their values come more often then
    line.done("broadcast", "--yes", "--slaves", "all", "--command", 1, "--word", RESET)
    for drive, number, value in SOFTER:
        line.done("write", drive, number, value)
    with line.start("record", recording, "unwinder", "dancer-1", "registration-1", "--values", "position,speed,torque",
                    "--duration", 8) as recorder:
        wait_for("the recording has begun", lambda: os.path.exists(recording) and os.path.getsize(recording) > 500)
        with Leading(line):
            seconds = lambda: float(open(recording, encoding="utf-8").read().rsplit("\n", 2)[-2].split(",")[1])
            wait_for("full speed", lambda: seconds() > 3.5)
            line.done("control", "registration-1", STANDS)
            wait_for("the drive stands for a while", lambda: seconds() > 5)
            line.done("control", "registration-1", RUNS)
            _, remarks = recorder.communicate(timeout=LONG)
    if recorder.returncode != 0:
        raise AssertionError(remarks.decode())
    line.done("plot", recording, "--output", picture, "--title",
              "A printing line starts; registration-1 is told to stand for a while")
    os.remove(recording)


def keep(picture, folder, name):
    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
        file.write(picture)


def make_watch(line, folder, name="watch", columns=132, rows=34):
    """The full-screen view while the line starts."""
    environment = dict(line.environment, TERM=KIND, LC_ALL="C.UTF-8")
    with Terminal([CANSYNC, "watch", "--interval", "250"], environment, columns, rows) as terminal:
        terminal.wait("timing figures", lambda text: "Bus load [" in text)
        with Leading(line):
            terminal.press("right", "down", "down", "down")
            run = re.compile(r" (?:29\d|30\d)(?:\.\d+)?(?: |$)", re.MULTILINE)
            terminal.wait("the drives run", line.acknowledging(lambda text: len(run.findall(text)) > min(10, rows // 3)))
            seen = set()
            terminal.wait("the trends are full", lambda text: seen.add(text) or len(seen) > LOOKS)
            picture = screen_svg(terminal.screen, "cansync watch")
        terminal.press("q")
        if terminal.end() != 0:
            raise AssertionError("watch has failed")
    keep(picture, folder, f"{name}.svg")


def make_screen(line, folder, columns, rows, verb, *wanted, code=0):
    """What a verb prints on a terminal of this size, below what was typed in a shell; it ends with `code`."""
    typed = " ".join(["cansync", verb, *wanted])
    environment = dict(line.environment, TERM=KIND, LC_ALL="C.UTF-8")
    with Terminal(["sh", "-c", f'echo "$ {typed}"; exec "$0" "$@"', CANSYNC, verb, *wanted], environment, columns, rows) as terminal:
        ended = terminal.end()
        if ended != code:
            raise AssertionError(f"{typed} has ended with {ended}")
        keep(screen_svg(terminal.screen, f"cansync {verb}"), folder, f"{verb}-{columns}x{rows}.svg")


def make_faulty(line, folder):
    """The slaves, one of which is in fault, and what `doctor` says of it."""
    line.done("broadcast", "--slaves", "all", "--command", 1, "--word", RESET, "--yes")
    line.done("broadcast", "--slaves", FAULTY, "--command", PROVOKE, "--word", MISSING_REFERENCES)
    wait_for("its fault is told", lambda: " fault" in line.done("slaves", FAULTY).stdout.decode())
    make_screen(line, folder, 80, 24, "slaves", "0-15")
    make_screen(line, folder, 120, 40, "slaves")
    for columns, rows in ((80, 24), (120, 40)):
        make_screen(line, folder, columns, rows, "doctor", code=8)


def make_jobs(line, folder):
    """What one client waits for behind another."""
    with contextlib.ExitStack() as stack:
        for known, (slave, length) in enumerate(((FAULTY, 60000), (FAULTY, 20000), ("unwinder", 20000))):
            stack.enter_context(line.start("upload", slave, "0x200", length, "-"))
            wait_for("it is known", lambda: line.done("jobs").stdout.decode().count("upload") > known)
        for columns, rows in ((80, 24), (120, 40)):
            make_screen(line, folder, columns, rows, "jobs")


def main():
    if len(sys.argv) != 2 or not os.path.isdir(sys.argv[1]):
        sys.exit("usage: make.py FOLDER")
    with DemoLine() as line:
        make_watch(line, sys.argv[1])
        make_watch(line, sys.argv[1], "watch-80x24", 80, 24)
        make_watch(line, sys.argv[1], "watch-120x40", 120, 40)
        make_faulty(line, sys.argv[1])
        make_jobs(line, sys.argv[1])
        make_timing(line, sys.argv[1])
    with DemoLine() as line:  # begins at position 0
        make_plot(line, sys.argv[1])


if __name__ == "__main__":
    main()

"""Counts the system calls of one thread of a running process, interval by interval, with strace.

For tests of any bus: `count_calls(pid, interval)` attaches to the thread by its name for a while. Reusable inside
a virtual machine too; needs the Debian package strace and the right to trace (skipped with the reason otherwise).
"""

import collections
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time

THREAD = "cansync-rt"
PATIENCE = 60  # seconds; for strace to let go of the thread
LINE = re.compile(r"^(\d+\.\d+) (?:<\.\.\. )?(\w+)")


class CannotTrace(Exception):
    """System calls cannot be counted here; the text says why."""


def thread_of(pid, name=THREAD):
    """Thread of a process by its name."""
    for thread in os.listdir(f"/proc/{pid}/task"):
        try:
            with open(f"/proc/{pid}/task/{thread}/comm", encoding="utf-8") as file:
                if file.read().strip() == name:
                    return int(thread)
        except OSError:  # it has just ended
            continue
    raise AssertionError(f"process {pid} has no thread {name}")


def trace(thread, seconds):
    """(time, name) of each system call a thread made within about so many seconds."""
    if not shutil.which("strace"):
        raise CannotTrace("strace is not installed (Debian package strace)")
    with tempfile.NamedTemporaryFile(mode="r", prefix="cansync_strace_") as log:
        arguments = ["strace", "-ttt", "-s", "0", "-o", log.name, "-p", str(thread)]
        with subprocess.Popen(arguments, stderr=subprocess.PIPE, text=True) as tracer:
            deadline = time.monotonic() + seconds
            while time.monotonic() < deadline and tracer.poll() is None:
                time.sleep(0.05)
            if tracer.poll() is None:
                tracer.send_signal(signal.SIGINT)
            try:
                complaint = tracer.communicate(timeout=PATIENCE)[1]
            except subprocess.TimeoutExpired:
                tracer.kill()
                raise
        lines = log.read().splitlines()
    calls = []
    for line in lines:
        found = LINE.match(line)
        # The second half of a call that was interrupted in the log is no call of its own; signals are none at all.
        if found and "resumed>" not in line and " --- " not in line and " +++ " not in line:
            calls.append((float(found.group(1)), found.group(2)))
    if not calls:
        raise CannotTrace(f"strace saw nothing of thread {thread}: {complaint.strip()}")
    return calls


class Counts:
    """System calls of a thread, sorted into intervals."""

    def __init__(self, calls, interval):
        # Intervals are cut where the thread is at rest the longest, so that none is cut through its work.
        phases = sorted((at - calls[0][0]) % interval for at, _ in calls)
        gaps = [(b - a, a + (b - a) / 2) for a, b in zip(phases, phases[1:] + [phases[0] + interval])]
        begin = calls[0][0] + max(gaps)[1]
        numbered = [(int((at - begin) // interval), name) for at, name in calls]
        last = max(number for number, _ in numbered)
        # What came before the first cut, and what came after the last one, was seen in part.
        whole = [(number, name) for number, name in numbered if 0 <= number < last]
        self.intervals = last
        self.by_name = collections.Counter(name for _, name in whole)
        counted = collections.Counter(number for number, _ in whole)
        self.of_interval = sorted(counted[number] for number in range(last))

    @property
    def median(self):
        return self.of_interval[len(self.of_interval) // 2]

    @property
    def most(self):
        return self.of_interval[-1]

    def text(self):
        kinds = ", ".join(f"{name} {count / self.intervals:.2f}" for name, count in self.by_name.most_common())
        return (
            f"{self.intervals} intervals: at least {self.of_interval[0]}, median {self.median}, at most {self.most} "
            f"system calls each ({kinds})"
        )


def count_calls(pid, interval, seconds=3.0, name=THREAD):
    """Counts of a thread of process `pid`, whose intervals take `interval` seconds."""
    return Counts(trace(thread_of(pid, name), seconds), interval)

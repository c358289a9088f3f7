#!/usr/bin/env python3
"""Runs inside the kernel under test: cyclic frames of the daemon, of the reference sender and of CAN_BCM in turn, and when
a listener saw them. Usage: inside_timers.py BUILD INTERFACE INTERVAL_US ROUNDS SECONDS"""

import json
import subprocess
import sys
import tempfile
import time

from frames import FIRST, PERIODS
from inside_kernel import CPU, PRIORITY, frames, listen, make, tell


def seen_of(build, interface, seconds, command):
    """What a listener sees of a program once it is under way."""
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    time.sleep(3)
    seen = frames(listen(build, interface, seconds))
    process.terminate()
    process.wait(60)
    return {identifier: times for identifier, times in seen.items() if FIRST <= identifier < FIRST + len(PERIODS)}


def main():
    build, interface, _, rounds, seconds = sys.argv[1:]
    make(interface)
    out = []
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(f'[bus]\nprotocol = "layer2"\ninterface = "{interface}"\n[realtime]\nmode = "enforce"\n'
                   f"priority = {PRIORITY}\ncpu = {CPU}\n[script]\npower_on = "
                   f"{json.dumps([f'Start {n + 1}' for n in range(len(PERIODS))])}\n" +
                   "".join(f"[[timer]]\nnumber = {n + 1}\nidentifier = {FIRST + n}\ndata = [0, 0, 0, 0, 0, 0, 0, 0]\n"
                           f"period_us = {period * 1000}\n" for n, period in enumerate(PERIODS)))
        file.flush()
        sender = [f"{build}/bench/reference_timers", interface, str(int(seconds) + 10), str(PRIORITY), str(CPU)]
        for _ in range(int(rounds)):
            out.append({"daemon": seen_of(build, interface, seconds, [f"{build}/daemon/cansyncd", file.name]),
                        "sender": seen_of(build, interface, seconds, sender),
                        "bcm": seen_of(build, interface, seconds, [*sender, "bcm"])})
    tell(out)


if __name__ == "__main__":
    main()

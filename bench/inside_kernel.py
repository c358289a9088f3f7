#!/usr/bin/env python3
"""Runs inside the kernel under test: the daemon and the reference sender in turn on a vcan interface, and what a
listener saw of each. Usage: inside_kernel.py BUILD INTERFACE INTERVAL_US ROUNDS SECONDS"""

import json
import os
import re
import subprocess
import sys
import tempfile
import time

# Of each interval in us: the bit rate, and send_margin_us, large because wake-ups inside are late: 1 Mbit/s allows no more.
LINES = {1000: (1000000, 130), 2000: (500000, 200), 4000: (250000, 200), 8000: (125000, 200)}
PRIORITY, CPU = 80, 0
SYNC = 0x080


def listen(build, interface, seconds):
    return subprocess.Popen([f"{build}/bench/reference_listener", interface, str(seconds)], stdout=subprocess.PIPE,
                            text=True)


def frames(listener):
    """Times in ns of each identifier."""
    seen = {}
    for line in listener.communicate()[0].splitlines():
        identifier, at = line.split()
        seen.setdefault(int(identifier, 16), []).append(int(at))
    return seen


def daemon(build, interface, interval, seconds):
    """SYNC and WRC1 of the daemon's realtime loop, and how long it takes from waking up to handing over."""
    bit_rate, margin = LINES[interval]
    with tempfile.NamedTemporaryFile("w", suffix=".toml", delete=False) as file:
        file.write(f'[bus]\ninterface = "{interface}"\nbit_rate = {bit_rate}\n'
                   f"send_margin_us = {margin}\n"
                   f'[sync]\noutput = "can"\ncan_identifier = {SYNC}\n[startup]\nenable = "any"\n'
                   f'[realtime]\nmode = "enforce"\npriority = {PRIORITY}\ncpu = {CPU}\n'
                   "[process]\npoll_without_reference = true\n[[slave]]\nnumber = 0\n")
    try:
        process = subprocess.Popen([f"{build}/bench/loop_bench", file.name, str(seconds + 4)], stdout=subprocess.PIPE,
                                   text=True)
        time.sleep(2)  # start-up
        seen = frames(listen(build, interface, seconds))
        shown = process.communicate(timeout=60)[0]
    finally:
        os.unlink(file.name)
    handed_over = json.loads(shown)["handed_over"]
    return {"sync": seen.get(SYNC, []), "reference": seen.get(0x100, []),
            "handed_over": [handed_over["p50"], handed_over["p99"]]}


def sender(build, interface, interval, seconds):
    process = subprocess.Popen([f"{build}/bench/reference_sender", interface, str(interval), str(seconds + 4),
                                str(PRIORITY), str(CPU)], stdout=subprocess.PIPE, text=True)
    time.sleep(2)
    seen = frames(listen(build, interface, seconds))
    sent = sorted(int(at) / 1000 for at in re.findall(r"sent (\d+)", process.communicate(timeout=60)[0]))
    return {"sync": seen.get(SYNC, []), "reference": seen.get(0x100, []),
            "handed_over": [sent[len(sent) // 2], sent[len(sent) * 99 // 100]]}


def make(interface):
    subprocess.run(["ip", "link", "add", "dev", interface, "type", "vcan"], check=True)
    subprocess.run(["ip", "link", "set", interface, "up"], check=True)


def tell(found):
    """To bench/kernel.py, outside."""
    print(f"result {json.dumps(found)}")


def main():
    build, interface, interval, rounds, seconds = sys.argv[1:]
    interval, rounds, seconds = int(interval), int(rounds), int(seconds)
    make(interface)
    tell([{"daemon": daemon(build, interface, interval, seconds), "sender": sender(build, interface, interval, seconds)}
          for _ in range(rounds)])


if __name__ == "__main__":
    main()

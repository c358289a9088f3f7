"""General frames: G14 at full bus load on the simulated bus, G15 cyclic frames on vcan."""

import contextlib
import json
import os
import random
import subprocess
import tempfile
import time

import kernel
import sync_analysis
from figures import quantile

NODES = 32
# The same as in reference/timers.c; frame n has the identifier 0x200 + n.
PERIODS = (1, 2, 3, 5, 7, 10, 12, 15, 20, 25, 30, 40, 50, 60, 80, 100)
FIRST = 0x200


def configuration(bus, domain, bit_rate=1000000):
    """Nodes that have always a frame ready, the shortest there is: the bus is never free."""
    text = f'[bus]\nprotocol = "layer2"\nname = "{bus}"\nbit_rate = {bit_rate}\n[dds]\ndomain = {domain}\n'
    return text + "".join(f"[[node]]\nnumber = {n}\nidentifier = {0x100 + n}\nperiod_ms = 1\n" for n in range(NODES))


@contextlib.contextmanager
def daemon(build, bus, domain):
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(configuration(bus, domain))
        file.flush()
        process = subprocess.Popen([f"{build}/daemon/cansyncd", file.name], stderr=subprocess.DEVNULL)
        try:
            yield process.pid
        finally:
            process.terminate()
            process.wait()


def processor(pid):
    """Processor time of all threads so far, in ns."""
    total = 0
    for thread in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{thread}/schedstat", encoding="ascii") as file:
            total += int(file.read().split()[0])
    return total


def status(build, bus, domain):
    shown = subprocess.run([f"{build}/tools/cli/cansync", "--domain", str(domain), "--bus", bus, "status", "--json"],
                           check=True, capture_output=True, text=True)
    return json.loads(shown.stdout)


def of_daemon(build, seconds, domain):
    """What the client recorded, the daemon's processor time and its counters over the same seconds."""
    bus = f"bench{random.randrange(10**9)}"
    with daemon(build, bus, domain) as pid:
        time.sleep(2)
        client = subprocess.Popen([f"{build}/bench/frames_bench", "record", str(domain), bus, str(seconds + 4)],
                                  stdout=subprocess.PIPE, text=True)
        time.sleep(2)
        before, used, begun = status(build, bus, domain), processor(pid), time.monotonic()
        time.sleep(seconds - (time.monotonic() - begun))
        used, after = processor(pid) - used, status(build, bus, domain)
        found = json.loads(client.communicate()[0])
        found["processor"] = used
        found["priority"] = after["realtime_priority"]
        found["counted"] = after["received"] - before["received"]
        found["time"] = (after["time_ns"] - before["time_ns"]) / 1e9
        found["not_taken"] = after["received"] - after["taken"]
        found["lost"] = max(found["lost"], after["lost"] - before["lost"])
        found["load"] = after["bus_load"] / 10 if "bus_load" in after else after["bus_load_permille"] / 10
        return found


def of_bridge(build, seconds, domain, priority):
    """The bridge, at the priority of the daemon's realtime thread."""
    bus = f"bench{random.randrange(10**9)}"
    reader = subprocess.Popen([f"{build}/bench/frames_bench", "listen", str(domain), bus, str(seconds + 2)],
                              stdout=subprocess.PIPE, text=True)
    time.sleep(1)
    command = ["chrt", "-f", str(priority)] if priority else []
    shown = subprocess.run([*command, f"{build}/bench/frames_bench", "bridge", str(domain), bus, str(seconds)], check=True,
                           capture_output=True, text=True)
    reader.communicate()
    return json.loads(shown.stdout)


def full_load(figures, build, rounds, seconds, domain):
    """G14."""
    pairs, missing = [], []
    for _ in range(rounds):
        ours = of_daemon(build, seconds, domain)
        bridge = of_bridge(build, seconds, domain, ours["priority"])
        print(json.dumps({"daemon": ours, "bridge": bridge}), flush=True)
        pairs.append((ours["processor"] / ours["counted"] * ours["time"] / seconds / 1000,
                      bridge["processor"] / bridge["frames"] / 1000))
        missing.append(ours["lost"] + ours["missed_batches"] + ours["not_rising"] + ours["gaps"])
    figures.ratio("G14", "processor time per general frame at full bus load; a bridge of 30 lines", "us", pairs, 1.3)
    figures.limit("G14", "frames lost or out of order at full bus load", "", missing, 0)


def spacing(seen):
    """The deviations of all spacings from their periods, in ns, and the largest growth of a phase."""
    deviations, growth = [], []
    for n, period in enumerate(PERIODS):
        times = seen.get(str(FIRST + n), [])
        if len(times) < 3:
            raise ValueError(f"frame {FIRST + n:03X} came {len(times)} times")
        deviations += sync_analysis.deviations(times, period * 1_000_000)
        growth.append(abs(sync_analysis.phase_growth(times, period * 1_000_000)))
    return deviations, max(growth)


def timers(figures, build, seconds):
    """G15."""
    found = kernel.measure(build, "inside_timers.py", ["daemon/cansyncd", "bench/reference_timers"], seconds)
    if found is None:
        return
    sides = {name: [spacing(one[name]) for one in found] for name in ("daemon", "sender", "bcm")}
    for share, target in ((0.5, None), (0.99, 1.3)):
        figures.ratio("G15", f"deviation of the spacing of 16 cyclic frames p{share * 100:.0f}, vcan; a sender of 30 lines", "us",
                      [(quantile(ours[0], share) / 1000, quantile(other[0], share) / 1000)
                       for ours, other in zip(sides["daemon"], sides["sender"])], target)
        figures.ratio("G15", f"the same p{share * 100:.0f}; CAN_BCM", "us",
                      [(quantile(ours[0], share) / 1000, quantile(other[0], share) / 1000)
                       for ours, other in zip(sides["daemon"], sides["bcm"])], None)
    figures.limit("G15", f"largest growth of a phase over {seconds} s; CAN_BCM", "us", [one[1] / 1000 for one in sides["daemon"]], 250,
                  max(one[1] / 1000 for one in sides["bcm"]))

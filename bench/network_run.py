"""Scenes of many daemons and many clients in one DDS domain of this computer, and what is measured of each."""

import os
import random
import re
import subprocess
import tempfile
import time

from figures import quantile

SLAVES = 4
BIT_RATE = 125000  # an interval takes 8 ms
UPLOAD_BIT_RATE = 1000000  # 1 ms, some 5000 bytes a second
LONG = 120  # seconds after which something has certainly gone wrong
ACTIVE = re.compile(rb"on '(?:run|enable active operation)'")  # the second: builds of before 2026-11-24


class Build:
    """The programs of one build folder, or of a folder with nothing but cansyncd and cansync."""

    def __init__(self, name, folder):
        self.name = name
        flat = os.path.exists(f"{folder}/cansyncd")
        self.daemon = f"{folder}/cansyncd" if flat else f"{folder}/daemon/cansyncd"
        self.client = f"{folder}/cansync" if flat else f"{folder}/tools/cli/cansync"


def processor_time(pids):
    """Seconds that all threads of these processes have used."""
    used = 0
    for pid in pids:
        for task in os.listdir(f"/proc/{pid}/task"):
            with open(f"/proc/{pid}/task/{task}/schedstat", encoding="utf-8") as file:
                used += int(file.read().split()[0])
    return used / 1e9


def carried(interface):
    """Bytes and packets that were sent on lo, and on the interface if it is another one; errors of unreachable ports count as well. What
    programs of one computer send each other goes by lo; what is for everybody by the interface, once."""
    with open("/proc/net/dev", encoding="utf-8") as file:
        lines = [line.replace(":", " ").split() for line in file]
    sent = [(int(line[9]), int(line[10])) for line in lines if line[0] in ("lo", interface)]
    return tuple(map(sum, zip(*sent)))


class Scene:
    """So many buses, in so many daemons, and so many clients that wait for something on these buses in turn; a context manager."""

    def __init__(self, build, buses, daemons, clients, bit_rate=BIT_RATE, interface="lo", domains=1):
        self.bit_rate, self.interface, self.domains = bit_rate, interface, domains
        self.build, self.buses, self.daemons, self.clients = build, buses, daemons, clients
        self.domain = random.SystemRandom().randint(1, 100)
        self.processes, self.waiting = [], []

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory(prefix="cansync_network_")
        began = time.monotonic()
        logs = dict(self._start_daemon(range(first, self.buses, self.daemons)) for first in range(self.daemons))
        try:
            self._wait_active(logs, began)
            self.active_after = time.monotonic() - began
            for number in range(self.clients):
                # Nobody stops the line, so they wait until they are killed.
                self.waiting.append(self._cansync(number % self.buses, "--timeout", "3600", "wait", "stop"))
            # Discovery repeats itself for four seconds; what is measured is what stays.
            time.sleep(6)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for process in self.waiting:
            process.kill()
        for process in self.processes:
            process.terminate()
        for process in self.waiting + self.processes:
            process.wait(LONG)
        self.folder.cleanup()

    def _start_daemon(self, numbers):
        """The file of its log, and how many buses tell there that they are active."""
        paths = [os.path.join(self.folder.name, f"{number}.toml") for number in numbers]
        for number, path in zip(numbers, paths):
            with open(path, "w", encoding="utf-8") as file:
                file.write(f'[bus]\nname = "bench{number}"\ninterface = "sim"\nbit_rate = {self.bit_rate}\n'
                           f"[dds]\ndomain = {self._domain_of(number)}\ninterface = \"{self.interface}\"\n[sim]\nlock_time_ms = 50\n")
                file.writelines(f"[[slave]]\nnumber = {slave}\n" for slave in range(SLAVES))
        with open(paths[0] + ".log", "wb") as log:
            self.processes.append(subprocess.Popen([self.build.daemon, *paths], stdout=log, stderr=log))
        return paths[0] + ".log", len(paths)

    def _wait_active(self, logs, began):
        waiting = set(logs)
        while waiting:
            if time.monotonic() > began + LONG:
                raise RuntimeError(f"{len(waiting)} daemons are not in active operation after {LONG} s")
            for path in list(waiting):
                with open(path, "rb") as file:
                    if len(ACTIVE.findall(file.read())) >= logs[path]:
                        waiting.discard(path)
            time.sleep(0.01)

    def _domain_of(self, bus):
        return self.domain + bus % self.daemons % self.domains

    def _cansync(self, bus, *arguments):
        place = ["--interface", self.interface, "--domain", str(self._domain_of(bus)), "--bus", f"bench{bus}"]
        return subprocess.Popen([self.build.client, *place, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def measure(self, seconds, asked):
        """Processor time and packets for so many seconds; then `status` so many times, of one bus after the other."""
        pids = [process.pid for process in self.processes]
        before, packets, began = processor_time(pids), carried(self.interface)[1], time.monotonic()
        time.sleep(seconds)
        took = time.monotonic() - began
        found = {
            "active_after_s": round(self.active_after, 2),
            "daemons_cpu_percent": round(100 * (processor_time(pids) - before) / took, 2),
            "packets_per_s": round((carried(self.interface)[1] - packets) / took),
            "load": os.getloadavg()[0],
        }
        times, failed = [], 0
        for number in range(asked):
            began = time.monotonic()
            process = self._cansync(number % self.buses, "status")
            failed += process.wait(LONG) != 0
            times.append(1000 * (time.monotonic() - began))
        found["status_p50_ms"], found["status_p90_ms"] = round(quantile(times, 0.5)), round(quantile(times, 0.9))
        found["status_failed"] = failed
        return found

    def measure_uploads(self, clients, size):
        """So many clients, each of which brings as many bytes from a slave; all at once, one after the other on the bus."""
        pids = [process.pid for process in self.processes]
        before, sent, began = processor_time(pids), carried(self.interface)[0], time.monotonic()
        asking = [self._cansync(0, "--timeout", str(LONG), "upload", str(number % SLAVES), "0x200", str(size),
                                os.path.join(self.folder.name, f"{number}.bin")) for number in range(clients)]
        ended = [os.wait4(process.pid, 0) for process in asking]
        for process, (_, status, _) in zip(asking, ended):
            process.returncode = os.waitstatus_to_exitcode(status)
        return {
            "uploads_failed": sum(process.returncode != 0 for process in asking),
            "uploads_s": round(time.monotonic() - began, 2),
            "lo_bytes_per_byte": round((carried(self.interface)[0] - sent) / (clients * size), 1),
            "client_cpu_ms": round(1000 * sum(usage.ru_utime + usage.ru_stime for _, _, usage in ended) / clients, 1),
            "daemon_cpu_ms": round(1000 * (processor_time(pids) - before)),
        }


def run_uploads(builds, clients, size):
    """Uploads of so many clients at once with each build in turn; {(build, buses, daemons, clients): what was measured}."""
    found = {}
    for build in builds:
        with Scene(build, 1, 1, 0, UPLOAD_BIT_RATE) as scene:
            found[(build.name, 1, 1, clients)] = scene.measure_uploads(clients, size)
    return found


def run(builds, scenes, seconds, asked, interface="lo", domains=1):
    """Every scene with each build in turn; {(build, buses, daemons, clients): what was measured}."""
    found = {}
    for buses, daemons, clients in scenes:
        for build in builds:
            with Scene(build, buses, daemons, clients, interface=interface, domains=domains) as scene:
                found[(build.name, buses, daemons, clients)] = scene.measure(seconds, asked)
    for (name, buses, _, _), one in found.items():
        alone = found.get((name, 1, 1, 0))
        if alone and buses > 1:
            one["cpu_of_n_times_one"] = round(one["daemons_cpu_percent"] / (buses * alone["daemons_cpu_percent"]), 2)
    return found

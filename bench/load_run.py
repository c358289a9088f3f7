"""One run of many clients on a daemon with 32 simulated slaves at 1 ms: phases without, with and after them."""

import contextlib
import json
import os
import re
import subprocess
import time

from gateway import Gateway, wait_for

SLAVES = 32
THREADS = ("cansync-rt", "cansync-gateway")
LATE = 8  # lateness_histogram: buckets above this one are those of 256 us and more


class Clients:
    """The program load_clients, and how many of whom."""

    def __init__(self, program, readers, requesters, opened):
        self.program, self.readers, self.requesters, self.opened = program, readers, requesters, opened

    @contextlib.contextmanager
    def connected(self, daemon, seconds):
        """All of them, connected; they work for so many seconds when told to by `work`. Gone at the end."""
        process = subprocess.Popen(
            [self.program, str(daemon.domain), daemon.bus, str(self.readers), str(self.requesters), str(self.opened),
             str(SLAVES), str(seconds)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        try:
            if process.stdout.readline() != "connected\n":
                raise RuntimeError("the clients did not start")
            yield process
        finally:
            process.kill()  # its children end with it
            process.communicate()

    @staticmethod
    def work(process):
        process.stdin.write("\n")
        process.stdin.flush()

    @staticmethod
    def result(process):
        """What all of them counted, when the last has ended."""
        found = json.loads(process.stdout.readlines()[-1])
        found["exit_code"] = process.wait()
        return found


class Daemon(Gateway):
    """cansyncd with reference values in every interval, so that each slave in turn answers with actual values."""

    def __init__(self, bit_rate=1000000):
        super().__init__(slaves=SLAVES, bit_rate=bit_rate)
        self.writer = None

    def __enter__(self):
        super().__enter__()
        self.writer = self.start("set", "0=1", "4=1", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return self

    def __exit__(self, *arguments):
        self.writer.terminate()
        self.writer.wait()
        super().__exit__(*arguments)

    def ask(self, verb):
        """The object of a verb, asked again until it is had: a new client does not get through at once under load."""

        def attempt():
            done = self.run(verb, "--json")
            return done.stdout if done.returncode == 0 else None

        return json.loads(wait_for(f"an answer to {verb}", attempt))

    def resident(self):
        """Memory of the daemon, in KiB."""
        with open(f"/proc/{self.process.pid}/status", encoding="utf-8") as file:
            return int(re.search(r"VmRSS:\s+(\d+)", file.read())[1])

    def threads(self):
        """(number, name) of each thread."""
        for task in os.listdir(f"/proc/{self.process.pid}/task"):
            with contextlib.suppress(FileNotFoundError), open(f"/proc/{self.process.pid}/task/{task}/comm",
                                                              encoding="utf-8") as file:
                yield int(task), file.read().strip()

    def priority(self):
        """Of the realtime thread, as granted; 0: none."""
        return next(os.sched_getparam(task).sched_priority for task, name in self.threads() if name == "cansync-rt")

    def processor_time(self):
        """Seconds of each named thread so far, and of all threads together."""
        seconds = {"all": 0.0}
        for task, name in self.threads():
            try:
                with open(f"/proc/{self.process.pid}/task/{task}/schedstat", encoding="utf-8") as file:
                    used = int(file.read().split()[0]) / 1e9
            except FileNotFoundError:  # it has just ended
                continue
            seconds["all"] += used
            if name in THREADS:
                seconds[name] = seconds.get(name, 0.0) + used
        return seconds

    def counters(self):
        """Everything that is compared at both ends of a phase; the daemon tells it once a second."""
        timing, status = self.ask("timing"), self.ask("status")
        return {
            "at": time.monotonic(),
            "intervals": status["interval"],
            "missed_syncs": status["missed_syncs"],
            "telegrams_sent": status["telegrams_sent"],
            "left_out": status["left_out"],
            "started_late": sum(slot["late"] for slot in timing["slots"]),
            "woken_256_us_late": sum(timing["lateness_histogram"][LATE + 1:]),
            "processor": self.processor_time(),
        }


class Yardstick:
    """cyclictest beside the daemon, with the same priority and period: what the machine alone makes late."""

    def __init__(self, priority, seconds):
        self.process = subprocess.Popen(
            ["cyclictest", "-q", "-m", "-t", "1", "-p", str(priority), "-i", "1000", "-D", f"{seconds}s", "-h", "1000"],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)

    def late(self):
        """How often it woke 256 us late or more, in a thousand."""
        shown = self.process.communicate()[0]
        early = sum(int(count) for step, count in re.findall(r"(?m)^(\d{6}) (\d+)", shown) if int(step) < 256)
        total = int(re.search(r"Total: (\d+)", shown)[1]) + int(re.search(r"Overflows: (\d+)", shown)[1])
        return round(1000 * (total - early) / total, 1)


def phase(daemon, seconds, priority):
    """What happened in so many seconds, or a little more: asking takes its time."""
    before = daemon.counters()
    yardstick = Yardstick(priority, seconds) if priority else None
    time.sleep(seconds)
    after = daemon.counters()
    found = {name: after[name] - before[name] for name in before if name not in ("at", "processor")}
    for name, of in (("missed_syncs", "intervals"), ("left_out", "telegrams_sent"), ("woken_256_us_late", "intervals")):
        found[f"{name} of 1000"] = round(1000 * found[name] / max(found[of], 1), 1)
    found["cyclictest of 1000"] = yardstick.late() if yardstick else "-"
    for name, used in after["processor"].items():
        found[f"processor % {name}"] = round(
            100 * (used - before["processor"].get(name, 0.0)) / (after["at"] - before["at"]), 1)
    return found


def run(clients, seconds):
    """All three phases on a new daemon; what they cost, and what the clients got."""
    found = {"loadavg": os.getloadavg()[0]}
    with Daemon() as daemon:
        priority = found["realtime_priority"] = daemon.priority()
        time.sleep(2)  # warm-up
        found["without"] = phase(daemon, seconds, priority)
        resident = {"without": daemon.resident()}
        with clients.connected(daemon, seconds + 8) as process:
            clients.work(process)
            time.sleep(2)  # until all of them are at work and the daemon's buffers have grown to what that needs
            resident["start"] = daemon.resident()
            found["with"] = phase(daemon, seconds, priority)
            resident["end"] = daemon.resident()
            found["clients"] = clients.result(process)
        time.sleep(2)
        found["after"] = phase(daemon, seconds, priority)
        resident["after"] = daemon.resident()
    found["resident_kib"] = resident
    return found


def table(found):
    """The same for people."""
    phases = ("without", "with", "after")
    lines = [f"load average before {found['loadavg']:.2f}, realtime priority {found['realtime_priority']}",
             f"{'':28}" + "".join(f"{part:>12}" for part in phases)]
    for name in found["without"]:
        lines.append(f"{name:28}" + "".join(f"{found[part].get(name, ''):>12}" for part in phases))
    lines.append("resident KiB: " + ", ".join(f"{part} {size}" for part, size in found["resident_kib"].items()))
    lines.append("clients: " + ", ".join(f"{name} {value}" for name, value in found["clients"].items()))
    return "\n".join(lines)

"""Figures that the machine itself can tell, with the simulated line: G1, G2, G8, G9, G10, G11 and memory."""

import contextlib
import json
import os
import re
import subprocess
import tempfile
import time

import realtime_calls
from figures import quantile

PRIORITY, CPU = 80, 1
SLAVES = 32


def cyclictest(seconds):
    """Quantiles of the wake-up lateness of cyclictest, in us, same priority and processor as ours."""
    shown = subprocess.run(
        ["cyclictest", "-q", "-m", "-t", "1", "-p", str(PRIORITY), "-i", "1000", "-a", str(CPU), "-D", f"{seconds}s",
         "-h", "100000"],
        check=True, capture_output=True, text=True).stdout
    counts = [(int(step), int(count)) for step, count in re.findall(r"(?m)^(\d{6}) (\d+)", shown)]
    total = sum(count for _, count in counts)
    out = {}
    for name, share in (("p50", 0.5), ("p90", 0.9), ("p99", 0.99), ("p99.9", 0.999)):
        below = 0
        for step, count in counts:
            below += count
            if below > share * total:
                out[name] = step
                break
    return out


def configuration(domain, bus, bit_rate=1000000):
    """A line of 32 simulated slaves with realtime enforced."""
    return (f'[bus]\nname = "{bus}"\nbit_rate = {bit_rate}\n[realtime]\nmode = "enforce"\npriority = {PRIORITY}\ncpu = {CPU}\n'
            f"[dds]\ndomain = {domain}\n"
            + "".join(f"[[slave]]\nnumber = {n}\n" for n in range(SLAVES)))


def own_loop(build, seconds):
    """The same quantiles of the daemon's realtime loop at the SYNC edge."""
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(configuration(0, "loop"))
        file.flush()
        shown = subprocess.run([f"{build}/bench/loop_bench", file.name, str(seconds)], check=True, capture_output=True,
                               text=True).stdout
    return json.loads(shown)["late"]


def lateness(figures, build, rounds, seconds):
    """G1 and G2."""
    pairs = [(own_loop(build, seconds), cyclictest(seconds)) for _ in range(rounds)]
    for name, quantiles, target in (("G1", ("p50", "p90"), 1.10), ("G2", ("p99", "p99.9"), 1.5)):
        for q in quantiles:
            figures.ratio(name, f"SYNC wake-up lateness {q}, yardstick cyclictest", "us",
                          [(ours[q], other[q]) for ours, other in pairs], target)


@contextlib.contextmanager
def load(command):
    """Keeps `command` running, again and again, in the background."""
    loop = subprocess.Popen(["bash", "-c", f"while :; do {command}; done"], stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL, start_new_session=True)
    try:
        time.sleep(0.5)  # the load has to build up before the measurement
        yield
    finally:
        os.killpg(loop.pid, 9)
        loop.wait()


def under_load(figures, build, rounds, seconds):
    """G10."""
    loads = (("stress-ng", "stress-ng --quiet --cpu 2 --vm 1 --vm-bytes 64M --timeout 5s"),
             ("hackbench", "hackbench -g 2 -l 2000"))
    for name, command in loads:
        pairs = []
        for _ in range(rounds):
            idle, idle_other = own_loop(build, seconds)["p50"], cyclictest(seconds)["p50"]
            with load(command):
                loaded, loaded_other = own_loop(build, seconds)["p50"], cyclictest(seconds)["p50"]
            pairs.append((loaded / max(idle, 1), loaded_other / max(idle_other, 1)))
        figures.ratio("G10", f"p50 under {name} / p50 idle, yardstick cyclictest", "x", pairs, 1.3)


class Daemon:
    """A daemon with 32 slaves and enforced realtime, reference values in every interval; a context manager.

    `program` is cansyncd with its simulated line, or gateway_bench: the same on a bus whose slaves answer at once.
    """

    def __init__(self, build, domain, bus, program="daemon/cansyncd", bit_rate=1000000):
        self.build, self.domain, self.bus, self.program = build, domain, bus, f"{build}/{program}"
        self.folder = tempfile.TemporaryDirectory(prefix="cansync_bench_")
        self.config = os.path.join(self.folder.name, "line.toml")
        with open(self.config, "w", encoding="utf-8") as file:
            file.write(configuration(domain, bus, bit_rate))

    def __enter__(self):
        self.process = subprocess.Popen([self.program, self.config], stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 30
        while self.cansync("status", "--json").get("option_status") != 0x80:
            if time.monotonic() > deadline or self.process.poll() is not None:
                raise RuntimeError("the daemon did not reach active operation")
        # Reference values in every interval, so that each slave in turn answers with its actual values.
        self.writer = subprocess.Popen(
            [f"{self.build}/tools/cli/cansync", "--domain", str(self.domain), "--bus", self.bus, "set", "0=1", "4=1"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return self

    def __exit__(self, *_):
        for process in (self.writer, self.process):
            process.terminate()
            process.wait(30)
        self.folder.cleanup()

    def cansync(self, *arguments):
        done = subprocess.run(
            [f"{self.build}/tools/cli/cansync", "--domain", str(self.domain), "--bus", self.bus, *arguments],
            capture_output=True, text=True, check=False)
        return json.loads(done.stdout) if done.returncode == 0 and done.stdout else {}

    def thread(self):
        """The realtime thread's number."""
        for task in os.listdir(f"/proc/{self.process.pid}/task"):
            with open(f"/proc/{self.process.pid}/task/{task}/comm", encoding="utf-8") as file:
                if file.read().strip() == "cansync-rt":
                    return int(task)
        raise RuntimeError("no thread cansync-rt")




def cpu_time(pid):
    """Seconds of processor time that a process has used, to the nanosecond."""
    total = 0
    for task in os.listdir(f"/proc/{pid}/task"):
        with contextlib.suppress(FileNotFoundError), open(f"/proc/{pid}/task/{task}/schedstat", encoding="utf-8") as file:
            total += int(file.read().split()[0])
    return total / 1e9


def delays(command):
    shown = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return [int(line) / 1000 for line in shown.split()]


def running(build, domain, bus, program, seconds):
    """What a listener sees of a daemon in `seconds`, and the processor time the daemon used in %."""
    with Daemon(build, domain, bus, program) as daemon:
        before = cpu_time(daemon.process.pid)
        seen = delays([f"{build}/bench/dds_latency", "listen", str(domain), bus, str(seconds)])
        return seen, 100 * (cpu_time(daemon.process.pid) - before) / seconds


def bare(build, domain, bus, per_second, seconds):
    """The same of a program that only writes samples and one that only sends frames, together."""
    writer = subprocess.Popen([f"{build}/bench/dds_latency", "write", str(domain), bus, "3600", str(per_second)])
    sender = subprocess.Popen([f"{build}/bench/reference_sender", "-", "1000", "3600", str(PRIORITY), str(CPU)],
                              stdout=subprocess.DEVNULL)
    try:
        before = cpu_time(writer.pid) + cpu_time(sender.pid)
        seen = delays([f"{build}/bench/dds_latency", "listen", str(domain), bus, str(seconds)])
        return seen, 100 * (cpu_time(writer.pid) + cpu_time(sender.pid) - before) / seconds
    finally:
        for process in (writer, sender):
            process.kill()
            process.wait()


def dds_and_cpu(figures, build, rounds, seconds, domain):
    """G8 and G9: a listener takes what a daemon publishes, then what a bare writer writes."""
    latency, with_line, processor = [], [], []
    for n in range(rounds):
        ours, own_cpu = running(build, domain, f"bench{n}", "bench/gateway_bench", seconds)
        simulated, _ = running(build, domain, f"line{n}", "daemon/cansyncd", seconds)
        plain, bare_cpu = bare(build, domain, f"bare{n}", max(round(len(ours) / seconds), 1), seconds)
        latency.append((quantile(ours, 0.5), quantile(plain, 0.5)))
        with_line.append((quantile(simulated, 0.5), quantile(plain, 0.5)))
        processor.append((own_cpu, bare_cpu))
    figures.ratio("G8", "actual value taken from the bus to a client's listener, p50; yardstick bare writer to listener",
                  "us", latency, 1.5)
    figures.ratio("G8", "the same from the frame's last bit on the simulated line", "us", with_line, 1.5)
    figures.ratio("G9", f"processor time of the daemon, {SLAVES} slaves at 1 kHz; yardstick sender and bare writer of as "
                  "many samples", "%", processor, 1.5)


def exact_counts(figures, build, seconds, domain):
    """G11 and memory."""
    with Daemon(build, domain, "exact") as daemon:
        stat = f"/proc/{daemon.process.pid}/task/{daemon.thread()}"

        def read():
            with open(f"{stat}/stat", encoding="utf-8") as file:
                fields = file.read().rpartition(")")[2].split()
            with open(f"{stat}/status", encoding="utf-8") as file:
                switches = re.search(r"nonvoluntary_ctxt_switches:\s+(\d+)", file.read())[1]
            return int(fields[7]), int(fields[9]), int(switches)

        time.sleep(2)  # warm-up
        before = read()
        time.sleep(seconds)
        faults = [now - then for now, then in zip(read(), before)]
        figures.limit("G11", "minor page faults of the realtime thread", "", faults[0:1], 0)
        figures.limit("G11", "major page faults of the realtime thread", "", faults[1:2], 0)
        figures.limit("G11", "involuntary switches of the realtime thread", "", faults[2:3], 0)
        with open(f"/proc/{daemon.process.pid}/status", encoding="utf-8") as file:
            resident = int(re.search(r"VmRSS:\s+(\d+)", file.read())[1]) / 1024
        figures.limit("memory", f"resident, all memory locked, {SLAVES} simulated slaves", "MiB", [resident], 40)
    system_calls(figures, build, domain)


def system_calls(figures, build, domain):
    """System calls of the realtime thread in an interval: at 4 ms, for tracing takes its time for each."""
    with Daemon(build, domain, "calls", bit_rate=250000) as daemon:
        counts = realtime_calls.count_calls(daemon.process.pid, 0.004)
    figures.limit("G11", "system calls of the realtime thread in an interval, simulated line, median", "", [counts.median], 12)
    figures.limit("G11", "futex calls of the realtime thread", "", [counts.by_name["futex"]], 0)

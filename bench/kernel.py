"""Figures that need a kernel with CAN: G3 to G7, on vcan in a user-mode-linux that has a processor for itself, and G6
and G7 in an emulated computer, whose time is its number of instructions."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile

import sync_analysis
from figures import quantile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.append(os.path.join(ROOT, "tests", "kernel"))

import machine  # noqa: E402: found on the path that was set above

INTERVAL = 2_000_000  # ns
CPU = 1


@contextlib.contextmanager
def processor_kept_awake():
    """A loop at idle priority, so that the host's processor is never asleep when the kernel inside is due."""
    loop = subprocess.Popen(["taskset", "-c", str(CPU), "chrt", "--idle", "0", sys.executable, "-c", "while True: pass"])
    try:
        yield
    finally:
        loop.send_signal(signal.SIGKILL)
        loop.wait()


def run_inside(build, script, arguments, limit):
    """What the script left in its output, the argument behind `arguments`, as an object; None when this machine cannot boot
    that kernel. `limit`: seconds for all of it."""
    with tempfile.TemporaryDirectory(prefix="cansync_bench_") as folder, processor_kept_awake():
        found = os.path.join(folder, "found.json")
        command = ["chrt", "-f", "20", "taskset", "-c", str(CPU), sys.executable, "-B",
                   os.path.join(ROOT, "tests", "uml", "run_uml.py"), script, *arguments]
        environment = dict(os.environ, CANSYNC_UML_LIMIT=str(limit), CANSYNC_UML_RESULT=found,
                           CANSYNC=f"{build}/tools/cli/cansync", CANSYNCD=f"{build}/daemon/cansyncd",
                           CANSYNC_SIM=f"{build}/tools/simulator/cansync-sim",
                           CANSYNC_UML_REGISTERS=f"{build}/tests/uml/libuml_registers.so")
        done = subprocess.run(command, env=environment, check=False)
        if done.returncode == 77:
            return None
        if done.returncode != 0:
            raise RuntimeError(f"the measurement inside the kernel ended with {done.returncode}")
        with open(found, encoding="utf-8") as file:
            return json.load(file)


def measure(build, rounds, seconds, script="inside_kernel.py"):
    """What the script inside found; None when this machine cannot boot that kernel."""
    return run_inside(build, os.path.join(ROOT, "bench", script),
                      [build, "vcan0", str(INTERVAL // 1000), str(rounds), str(seconds)], int(60 + rounds * 3 * (seconds + 15)))


def measure_emulated(build, rounds, seconds):
    """What inside_kernel.py found in the emulated computer; None when this one cannot run it."""
    programs = [f"{build}/bench/{name}" for name in ("loop_bench", "reference_sender", "reference_listener")]
    command = ["/usr/bin/python3", "-B", os.path.join(ROOT, "bench", "inside_kernel.py"), build, "vcan0",
               str(INTERVAL // 1000), str(rounds), str(seconds), "-"]
    lines = []
    try:
        code = machine.run(command, {}, programs, 60 + rounds * 20 * (seconds + 15), lines.append)
    except machine.Missing as reason:
        print(f"no emulated computer: {reason}")
        return None
    if code != 0:
        raise RuntimeError("the measurement in the emulated computer failed:\n" + "\n".join(lines))
    return json.loads(next(line for line in lines if line.startswith("[{")))


def handing_over(figures, found, where):
    """G7."""
    for index, (name, target) in enumerate((("p50", 1.3), ("p99", 2.0))):
        figures.ratio("G7", f"waking up to the last frame handed over, {where}, {name}, yardstick sender", "us",
                      [(one["daemon"]["handed_over"][index], one["sender"]["handed_over"][index]) for one in found], target)


def skipped(figures, found, where, seconds):
    """G6."""
    for one in found:
        mine, theirs = (sync_analysis.skipped(one[side]["sync"], INTERVAL) for side in ("daemon", "sender"))
        figures.limit("G6", f"skipped slots in {seconds} s, {where}, at most 1.5 times the sender's and 5", "", [mine], 1.5 * theirs + 5, theirs)


def figures_emulated(figures, build, rounds, seconds):
    """G6 and G7 where time is instructions: one round is as good as many, two show that it is so."""
    found = measure_emulated(build, min(rounds, 2), seconds)
    if found is not None:
        skipped(figures, found, "emulated computer", seconds)
        handing_over(figures, found, "emulated computer")


def figures_on_vcan(figures, build, rounds, seconds):
    """G3 to G7."""
    found = measure(build, rounds, seconds)
    if found is None:
        return
    pairs = [(one["daemon"], one["sender"]) for one in found]

    def microseconds(of, name, share):
        return quantile(sync_analysis.deviations(of[name], INTERVAL), share) / 1000

    for name, text in (("sync", "SYNC"), ("reference", "WRC1")):
        for share in (0.5, 0.9):
            figures.ratio("G3", f"{text} interval deviation p{share * 100:.0f} on vcan, yardstick sender", "us",
                          [(microseconds(ours, name, share), microseconds(other, name, share)) for ours, other in pairs], 1.3)
    growth = [abs(sync_analysis.phase_growth(ours["sync"], INTERVAL)) / 1000 for ours, _ in pairs]
    figures.limit("G4", f"growth of the phase against the ideal grid over {seconds} s", "us", growth, 250,
                  max(abs(sync_analysis.phase_growth(other["sync"], INTERVAL)) / 1000 for _, other in pairs))
    bunched, other_bunched = ([sync_analysis.bunched(of["sync"], INTERVAL) for of in side] for side in zip(*pairs))
    figures.limit("G5", "SYNC within half an interval of another", "", bunched, 0, max(other_bunched))
    skipped(figures, found, "user-mode-linux", seconds)
    handing_over(figures, found, "user-mode-linux")

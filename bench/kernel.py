"""Figures that need a kernel with CAN, G3 to G7 and G15: on vcan in the emulated computer of tests/kernel. Its time is its number of
instructions, so that nothing outside plays a part, and one round is as good as many: two show that it is so."""

import json
import os
import sys

import sync_analysis
from figures import quantile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.append(os.path.join(ROOT, "tests", "kernel"))

import machine  # noqa: E402: found on the path that was set above
from debian_kernel import Missing  # noqa: E402

INTERVAL = 2_000_000  # ns
ROUNDS = 2
RESULT = "result "  # begins the line with what a program inside has found, as JSON
HOST_SECONDS = 20  # of this computer for one of the emulated one, at most


def run_inside(build, script, arguments, programs, seconds):
    """What the script of bench/ has found; None, and why, when this computer cannot run that one. `programs`: what it needs of the
    build, `seconds`: how long it takes there."""
    command = ["/usr/bin/python3", "-B", os.path.join(ROOT, "bench", script), *map(str, arguments)]
    lines = []
    try:
        code = machine.run(command, {}, [os.path.join(build, program) for program in programs], 120 + HOST_SECONDS * seconds, lines.append)
    except Missing as reason:
        print(f"no emulated computer: {reason}")
        return None
    if code != 0:
        raise RuntimeError("the measurement in the emulated computer failed:\n" + "\n".join(lines))
    return json.loads(next(line for line in lines if line.startswith(RESULT)).removeprefix(RESULT))


def measure(build, script, programs, seconds):
    """What the script found in each of the rounds, in which its senders are heard for `seconds` each."""
    return run_inside(build, script, [build, "vcan0", INTERVAL // 1000, ROUNDS, seconds], ["bench/reference_listener", *programs], ROUNDS * 3 * (seconds + 6))


def figures_on_vcan(figures, build, seconds):
    """G3 to G7."""
    found = measure(build, "inside_kernel.py", ["bench/loop_bench", "bench/reference_sender"], seconds)
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
    for ours, other in pairs:
        mine, theirs = (sync_analysis.skipped(of["sync"], INTERVAL) for of in (ours, other))
        figures.limit("G6", f"skipped slots in {seconds} s, at most 1.5 times the sender's and 5", "", [mine], 1.5 * theirs + 5, theirs)
    for index, (name, target) in enumerate((("p50", 1.3), ("p99", 2.0))):
        figures.ratio("G7", f"waking up to the last frame handed over, {name}, yardstick sender", "us",
                      [(ours["handed_over"][index], other["handed_over"][index]) for ours, other in pairs], target)

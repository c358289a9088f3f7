"""What floods, and clients that are stopped, killed or slow, cost the others: one run on a daemon with simulated slaves."""

import contextlib
import json
import os
import signal
import subprocess
import time

FLOODERS = 3
# What goes on beside the measured clients: the roles of bench/flood_clients.cpp.
FLOODS = {
    "alone": (),
    "library": ("flood",) * FLOODERS,
    "raw parameters": ("raw-parameters",) * FLOODERS,
    "raw commands": ("raw-commands",) * FLOODERS,
}
# What happens to a client that has done nothing, while another reads without pause.
MISHAPS = {"none": None, "stopped": signal.SIGSTOP, "killed": signal.SIGKILL, "slow": None}


class Client:
    """One flood_clients, connected; it begins when told to."""

    def __init__(self, program, daemon, role, seconds):
        self.role = role
        self.process = subprocess.Popen([program, role, str(daemon.domain), daemon.bus, str(seconds)],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        if self.process.stdout.readline() != "connected\n":
            raise RuntimeError(f"the client {role} did not start")

    def work(self):
        self.process.stdin.write("\n")
        self.process.stdin.flush()

    def result(self):
        """What it counted, when it has ended."""
        return json.loads(self.process.stdout.readlines()[-1])


@contextlib.contextmanager
def clients(program, daemon, roles, seconds):
    """One of each, at work; gone at the end."""
    started = []
    try:
        for role in roles:
            started.append(Client(program, daemon, role, seconds))
        for client in started:
            client.work()
        yield started
    finally:
        for client in started:
            client.process.kill()
            client.process.communicate()


def summed(results):
    """How the requests of several clients ended."""
    found = {"requests": 0, "open": 0, "ends": {}}
    for result in results:
        found["requests"] += result["requests"]
        found["open"] += result["open"]
        for name, count in result["ends"].items():
            found["ends"][name] = found["ends"].get(name, 0) + count
    return found


def beside(program, daemon, roles, seconds):
    """Control words and reference values beside clients with these roles."""
    with clients(program, daemon, ("command", "references", *roles), seconds) as (command, references, *others):
        found = {"command": command.result(), "references": references.result()}
        found["others"] = summed(other.result() for other in others)
    return found


def mishap(program, daemon, name, seconds):
    """A client reads without pause; in the middle something happens to another."""
    role = "slow" if name == "slow" else "idle"
    with clients(program, daemon, ("read", "command", role), seconds) as (reader, command, other):
        time.sleep(seconds / 4)
        if MISHAPS[name]:
            os.kill(other.process.pid, MISHAPS[name])
        return {"read": reader.result(), "command": command.result()}


def run(program, daemon, seconds, mishap_seconds=8):
    """All of it. The mishaps come first: buffers that a flood has made larger hide what they cost."""
    mishaps = {name: mishap(program, daemon, name, mishap_seconds) for name in MISHAPS}
    return {"mishaps": mishaps, "floods": {name: beside(program, daemon, roles, seconds) for name, roles in FLOODS.items()}}


def run_on_a_new_daemon(program, seconds):
    from gateway import Gateway

    with Gateway(slaves=4, bit_rate=125000) as daemon:
        return run(program, daemon, seconds)


def table(found):
    """The same for people."""
    lines = [f"{'control words beside':24}{'median ms':>10}{'p99':>8}{'longest':>9}{'references':>12}{'refused':>9}"
             f"{'requests of the others':>24}"]
    for name, of in found["floods"].items():
        command, references, others = of["command"], of["references"], of["others"]
        ends = ", ".join(f"{end} {count}" for end, count in others["ends"].items())
        lines.append(f"{name:24}{command['median_ms']:>10.2f}{command['p99_ms']:>8.1f}{command['longest_ms']:>9.1f}"
                     f"{references['requests']:>12}{references['ends']['refused']:>9}{others['requests']:>24}"
                     f" ({ends}, never ended {others['open']})")
    lines.append(f"{'another client is':24}{'reads':>10}{'median ms':>10}{'longest':>9}{'control words: longest':>24}")
    for name, of in found["mishaps"].items():
        lines.append(f"{name:24}{of['read']['requests']:>10}{of['read']['median_ms']:>10.2f}{of['read']['longest_ms']:>9.1f}"
                     f"{of['command']['longest_ms']:>24.1f}")
    return "\n".join(lines)

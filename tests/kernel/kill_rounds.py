"""`kill -9` of daemon, drives and clients in the middle of their work, round after round, on a real kernel.

    kill_rounds.py --client PROGRAM [--rounds N] [--seed N]    run in the machine by run_machine.py; prints the figures as JSON

Each round lets clients write a parameter, download and upload, kills one process at a random moment, starts it again at
once as systemd would, and then looks: whatever a client was told to be done is there, whatever it was not told is old or
new and nothing else, and every slave serves reads and a whole transfer there and back, within a bound. The seed decides
who is killed when; how far the work has got by then is the machine's affair.
"""

import argparse
import contextlib
import json
import os
import random
import select
import subprocess
import sys
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "end_to_end")]

from canline import LONG, Master, Simulator, create_interface  # noqa: E402
from gateway import ACTIVE, wait_for  # noqa: E402

SLAVES = 3
WRITTEN, LOADED, STORED = 0, 1, 2  # the slave whose parameter is written, who is downloaded to, and uploaded from
PARAMETER = 430  # a doubleword without limits; 0 when the drive starts
NUMBER = 103  # every drive's own number
ADDRESS = 0x1000
BLOCK = 150  # bytes, as job_client asks for
SIZE = 2 * BLOCK  # 52 intervals of 8 ms
# The daemon less often: its clients take 5 s, the lease, to know.
VICTIMS = ("daemon", "drives", "drives", "client", "client")
MOST = 1.3  # seconds after the start of the clients at which the last is killed
BOUND = 60  # seconds from the kill until every slave serves again


class Client:
    """A client process (job_client.cpp) that does one job after the other; started anew when it has been killed."""

    def __init__(self, program, daemon):
        self.command = [program, str(daemon.domain), daemon.bus]
        self.process = None

    def __enter__(self):
        self.process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        if not select.select([self.process.stdout], [], [], LONG)[0] or self.process.stdout.readline() != "ready\n":
            raise AssertionError("a client found no daemon")
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate(timeout=LONG)

    def begin(self, *job):
        """Gives it a job; `end` takes the result."""
        try:
            self.process.stdin.write(" ".join(map(str, job)) + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:  # it has just been killed
            pass

    def end(self):
        """What the job's end was: ("done", what was read), or another code and its reason. Ends by itself."""
        if not select.select([self.process.stdout], [], [], LONG)[0]:
            raise AssertionError(f"a job has not ended within {LONG} s")
        line = self.process.stdout.readline()
        if not line:
            return "killed", f"exit code {self.process.wait(LONG)}"
        code, _, rest = line.rstrip("\n").partition(" ")
        return code, rest

    def do(self, *job):
        self.begin(*job)
        return self.end()

    def until_done(self, *job):
        """A job, again and again until it is done; what was read. An answer may be late on this kernel."""
        last = None

        def attempt():
            nonlocal last
            last = self.do(*job)
            return last if last[0] == "done" else None

        try:
            return wait_for(f"{job[:3]} is done", attempt)[1]
        except AssertionError as error:
            raise AssertionError(f"{error}; last: {last}") from None

    def kill(self):
        self.process.kill()

    def revive(self):
        if self.process.poll() is not None:
            self.__exit__()
            self.__enter__()


class Writer(threading.Thread):
    """Writes 1, 2, 3 ... one after the other to a parameter; knows which value may be there."""

    def __init__(self, client, present, first):
        super().__init__()
        self.client, self.sent = client, first - 1
        self.allowed = {present}  # what was confirmed last, and what was sent since
        self.confirmed = 0
        self.stopping = False

    def run(self):
        while not self.stopping:
            self.sent += 1
            self.allowed.add(self.sent)
            code, _ = self.client.do("write", WRITTEN, PARAMETER, self.sent)
            if code == "done":
                self.confirmed += 1
                self.allowed = {self.sent}
            elif code in ("killed", "no_reply", "no_daemon"):
                return


class Rounds:
    """The line, what is known of it, and what has been counted."""

    def __init__(self, seed, daemon, simulator, clients):
        self.random = random.Random(seed)
        self.daemon, self.simulator = daemon, simulator
        self.writing, self.loading, self.storing = self.clients = clients
        self.order = []
        self.value = 0  # of the parameter
        self.sent = 0
        self.killed = dict.fromkeys(VICTIMS, 0)
        self.done = {"write": 0, "download": 0, "upload": 0}
        self.cut = dict(self.done)
        self.longest = 0.0

    def kill(self, victim):
        """Kills it and starts it again."""
        self.killed[victim] += 1
        if victim == "daemon":
            self.daemon.restart()
        elif victim == "drives":
            self.simulator.kill()
            self.simulator.start()
        else:
            self.random.choice(self.clients).kill()

    def round(self):
        # Shuffled in groups, so that every kind has its share.
        if not self.order:
            self.order = self.random.sample(VICTIMS, len(VICTIMS))
        victim, delay = self.order.pop(), self.random.uniform(0, MOST)
        stored, loaded = self.random.randbytes(SIZE).hex(), self.random.randbytes(SIZE).hex()
        self.storing.until_done("download", STORED, ADDRESS, stored)
        writer = Writer(self.writing, self.value, self.sent + 1)
        writer.start()
        self.loading.begin("download", LOADED, ADDRESS, loaded)
        self.storing.begin("upload", STORED, ADDRESS, SIZE)
        time.sleep(delay)  # the moment is what is tried; nothing waits for it
        writer.stopping = True
        killed_at = time.monotonic()
        self.kill(victim)
        ended = {"download": self.loading.end(), "upload": self.storing.end()}
        writer.join(2 * LONG)  # its job ends by itself within LONG
        if writer.is_alive():
            raise AssertionError("the writer has not ended")
        self.sent = writer.sent
        for client in self.clients:
            client.revive()
        self.wait_status("every slave synchronized in active operation", lambda state, synchronized, *_:
                         state == ACTIVE and synchronized == (1 << SLAVES) - 1)
        self.check(victim, writer, ended, stored, loaded)
        self.probe()
        took = time.monotonic() - killed_at
        self.longest = max(self.longest, took)
        if took > BOUND:
            raise AssertionError(f"it took {took:.1f} s until everything worked again, more than {BOUND} s")
        return (f"{victim} killed after {delay:.2f} s, {took:.1f} s until all works again, {writer.confirmed} writes, "
                f"download {ended['download'][0]}, upload {ended['upload'][0]}")

    def check(self, victim, writer, ended, stored, loaded):
        """What was told to be done is there."""
        for name, (code, _) in ended.items():
            (self.done if code == "done" else self.cut)[name] += 1
        self.done["write"] += writer.confirmed
        self.cut["write"] += len(writer.allowed) > 1
        self.value = int(self.writing.until_done("read", WRITTEN, PARAMETER))
        # Drives that were killed have begun anew.
        allowed = writer.allowed | ({0} if victim == "drives" else set())
        if self.value not in allowed:
            raise AssertionError(f"the parameter is {self.value}, allowed {sorted(allowed)}")
        if ended["upload"][0] == "done":
            self.check_upload(victim, ended["upload"][1], stored)
        if ended["download"][0] == "done" and victim != "drives":
            if self.loading.until_done("upload", LOADED, ADDRESS, SIZE) != loaded:
                raise AssertionError("a download was done, and other bytes are there")

    @staticmethod
    def check_upload(victim, read, stored):
        """What was read is what the drive had. One that starts anew between two blocks has zeros from then on."""
        for first in range(0, 2 * SIZE, 2 * BLOCK):
            allowed = [stored[first:first + 2 * BLOCK]]
            if victim == "drives":
                allowed.append("0" * 2 * BLOCK)
            if read[first:first + 2 * BLOCK] not in allowed:
                raise AssertionError(f"an upload was done with bytes the drive never had: {read}, it had {stored}")

    def wait_status(self, what, condition):
        last = None

        def look():
            nonlocal last
            last = code, rest = self.writing.do("status")
            return code == "done" and condition(*map(int, rest.split()))

        try:
            wait_for(what, look)
        except AssertionError as error:
            raise AssertionError(f"{error}; last: {last}") from None

    def nothing_left_over(self):
        """No job is open. The status tells it once a second."""
        self.wait_status("no job is left over", lambda state, synchronized, *jobs: jobs == (0, 0))

    def probe(self):
        """Every slave answers, and a transfer goes there and back."""
        for slave in range(SLAVES):
            if int(self.writing.until_done("read", slave, NUMBER)) != slave:
                raise AssertionError(f"slave {slave} gave a wrong number")
        sent = self.random.randbytes(SIZE // 2).hex()
        for slave, client in ((LOADED, self.loading), (STORED, self.storing)):
            client.until_done("download", slave, ADDRESS, sent)
            if client.until_done("upload", slave, ADDRESS, SIZE // 2) != sent:
                raise AssertionError(f"slave {slave}: not what was downloaded")


def run(chosen):
    """All rounds; the figures."""
    begin = time.monotonic()
    create_interface()
    with contextlib.ExitStack() as stack:
        simulator = stack.enter_context(Simulator(slaves=f"0-{SLAVES - 1}"))
        daemon = stack.enter_context(Master(slaves=SLAVES))
        daemon.wait_active()
        clients = [stack.enter_context(Client(chosen.client, daemon)) for _ in range(3)]
        rounds = Rounds(chosen.seed, daemon, simulator, clients)
        for number in range(chosen.rounds):
            try:
                if number % 5 == 0:
                    rounds.nothing_left_over()
                print(f"round {number}: {rounds.round()}", flush=True)
            except AssertionError as error:
                raise AssertionError(
                    f"round {number} of seed {chosen.seed}: {error}\n{daemon.log_text()[-4000:]}") from None
        rounds.nothing_left_over()
    return {"rounds": chosen.rounds, "seconds": round(time.monotonic() - begin), "killed": rounds.killed,
            "done": rounds.done, "cut": rounds.cut, "longest_s": round(rounds.longest, 1)}


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--client", required=True, help="the program job_client")
    options.add_argument("--rounds", type=int, default=50)
    options.add_argument("--seed", type=int, default=1)
    print(json.dumps(run(options.parse_args())))


if __name__ == "__main__":
    main()

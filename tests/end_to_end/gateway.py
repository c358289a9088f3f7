"""A running cansyncd with simulated drives, and the command `cansync`, for tests of whole processes.

The paths of both programs come from the environment: CANSYNC and CANSYNCD.
"""

import fcntl
import json
import os
import pty
import random
import re
import select
import shlex
import shutil
import socket
import struct
import subprocess
import tempfile
import termios
import time
import weakref

from json_schemas import expect, expect_lines
from wording import expect_wording

CANSYNC = os.environ["CANSYNC"]
CANSYNCD = os.environ["CANSYNCD"]
LONG = 120  # seconds after which something has certainly gone wrong, also on a loaded machine under a sanitizer
# In a machine whose clock no stall reaches (tests/kernel): there everything must be as on a computer that is never late.
OWN_TIME = "CANSYNC_OWN_TIME" in os.environ
# A computer that is busy skips SYNC edges, and a drive that faults for it follows nobody any more. Without realtime priority it
# wakes the daemon later than the usual margin of 50 us, again and again, and commands wait for the next interval until one is
# met; and what is late on the way can cost the answer to a write.
AGAINST_STALLS = () if OWN_TIME else (
    "--set", "sim.missing_edges=65535", "--set", "bus.send_margin_us=100", "--set", "command_channel.command_timeout_ms=30000",
    "--set", "command_channel.parameter_timeout_ms=30000", "--set", "command_channel.repeat_unanswered_writes=true")
# A drive that nobody gives reference values does not fault, so that one client after the other may move it.
NEVER_MISSING_REFERENCES = ("--set", "sim.missing_references=0")
# Making them takes such a machine 20 s: tests of the same boot share them.
MADE_IDENTITIES = os.path.join(tempfile.gettempdir(), "cansync_identities")
PAUSES = 1  # between two looks, each as long as a look takes
ACTIVE = 0x80  # w_OPTION_STATUS
# The slowest, intervals of 8 ms: at 1 ms each second of a daemon in a machine with a time of its own costs the host nine times
# as much. What a test says of another rate is a rate of its own; line_test has all of them.
BIT_RATE = 125000


def wait_for(what, condition, seconds=None, pause=0.02):
    """The first result of `condition` that is true. `pause`: at least so many seconds between two looks."""
    seconds = LONG if seconds is None else seconds
    deadline = time.monotonic() + seconds
    while (began := time.monotonic()) < deadline:
        result = condition()
        if result:
            return result
        # Looking costs processor time that the line needs as well: never more than half of it.
        time.sleep(min(1.0, max(pause, PAUSES * (time.monotonic() - began))))
    raise AssertionError(f"not within {seconds} s: {what}")


def end(process, seconds=None):
    """SIGTERM, and the exit code; what does not end is killed, and an error."""
    process.terminate()
    try:
        return process.wait(LONG if seconds is None else seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait(LONG)
        raise


def end_at_once(process):
    """SIGKILL, and nothing of it is left."""
    process.kill()
    process.communicate(timeout=LONG)


def metrics(path):
    """The numbers of a metrics file by "NAME" or "NAME{LABELS}", without the label of the bus; none while it is not there."""
    if not os.path.exists(path):
        return {}
    with open(path, encoding="utf-8") as file:
        found = re.findall(r'(?m)^(cansync_\w+)\{bus="[^"]*",?(.*)\} (\S+)$', file.read())
    return {name + (f"{{{labels}}}" if labels else ""): float(value) for name, labels, value in found}


def identities(folder):
    """One identity for each role, made by cansync-security; the folder that they lie in."""
    script = os.path.join(os.path.dirname(__file__), "..", "..", "tools", "security", "cansync-security")
    authority = os.path.join(folder, "ca")
    if OWN_TIME and os.path.isdir(MADE_IDENTITIES):
        return shutil.copytree(MADE_IDENTITIES, authority)
    roles = ("daemon", "viewer", "operator", "engineer")
    for arguments in (["init", authority], *(["add", authority, role, "--role", role] for role in roles)):
        subprocess.run([script, *arguments], check=True, capture_output=True, timeout=LONG)
    if OWN_TIME:
        shutil.copytree(authority, MADE_IDENTITIES)
    return authority


class Verb(subprocess.Popen):
    """`cansync` running; what it writes with --json is compared with the schemas of docs/json."""

    def __init__(self, arguments, **options):
        self.arguments = arguments
        # Lines read one by one must leave nothing in a buffer for communicate() to miss.
        options.setdefault("bufsize", 0)
        super().__init__([CANSYNC, *map(str, arguments)], **options)

    def __exit__(self, kind, *rest):
        # A test that failed must not wait for what it would have ended: that would hide why.
        if kind is not None:
            self.kill()
        super().__exit__(kind, *rest)

    def wait(self, timeout=None):
        """As that of Popen, but never without a limit; the end of a `with` waits by this one, too."""
        return super().wait(LONG if timeout is None else timeout)

    def communicate(self, input=None, timeout=None):
        """As that of Popen, but never without a limit."""
        out, err = super().communicate(input, LONG if timeout is None else timeout)
        if isinstance(out, bytes):
            # The last line of a program that was killed may be cut.
            expect_lines(self.arguments, out[: out.rfind(b"\n") + 1] if (self.returncode or 0) < 0 else out)
        expect_wording(self.arguments, *([] if "--json" in self.arguments else [out]), err)
        return out, err

    def next_line(self, stream=None):
        """The next line of one that goes on, as bytes; of its standard output, or of `stream`."""
        stream = stream or self.stdout
        if not select.select([stream], [], [], LONG)[0]:
            raise AssertionError(f"{self.arguments}: nothing came within {LONG} s")
        return stream.readline()

    def next_object(self):
        """The next object of one that goes on."""
        found = json.loads(self.next_line())
        expect(self.arguments, found)
        return found


class Looker:
    """`cansync` that goes on and is asked for one object after another: of what is looked at until it is so, a process for each look
    would be most of what a test costs."""

    SAID_ALONE = 1  # seconds after which a message is not a note beside an object

    def __init__(self, environment):
        self.process = subprocess.Popen([CANSYNC, "batch", "--continue", "-"], env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, bufsize=0)
        self.end = weakref.finalize(self, end_at_once, self.process)
        self.lines = 0
        self.seen = set()

    def look(self, arguments):
        """The one object that `cansync ARGUMENTS --json` prints; None when it says why not."""
        command = shlex.join(map(str, [*arguments, "--json"]))
        self.lines += 1
        out, err = self.process.stdout, self.process.stderr
        try:
            self.process.stdin.write(f"{command}\n".encode())
        except BrokenPipeError:
            return None
        said = b""
        while True:
            is_told = b"input:%d:" % self.lines in said
            ready = select.select([out, err], [], [], self.SAID_ALONE if is_told else LONG)[0]
            if out in ready:
                break
            text = os.read(err.fileno(), 65536) if ready else b""
            said += text
            if not text and is_told:
                return None
            if not text:
                raise AssertionError(f"{command}: nothing came within {LONG} s; it said {said}")
        line = out.readline()
        if not line:
            return None
        found = json.loads(line)
        if command not in self.seen:
            self.seen.add(command)
            expect(arguments, found)
        return found


def reserved_port(domain, offset):
    """A UDP port of the domain's range, bound; None: another program has it."""
    reserved = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        reserved.bind(("", 7400 + 250 * domain + offset))
        return reserved
    except OSError:
        reserved.close()
        return None


def own_domain():
    """A DDS domain that no other test has, and what reserves it: a port that DDS never uses, as tests/support/free_domain.h."""
    # Ports of these domains lie below those the system gives to outgoing connections.
    for domain in random.SystemRandom().sample(range(1, 101), 100):
        reservation = reserved_port(domain, 5)
        first_participant = reserved_port(domain, 10)
        if first_participant is not None:
            first_participant.close()
            if reservation is not None:
                return domain, reservation
        if reservation is not None:
            reservation.close()
    raise AssertionError("no DDS domain in 1..100 is free on this computer")


class Place:
    """A DDS domain and a partition that nobody else uses."""

    def __init__(self):
        self.domain, reservation = own_domain()
        weakref.finalize(self, reservation.close)
        self.bus = f"test{os.getpid()}-{random.SystemRandom().randrange(10**9)}"
        self.environment = dict(os.environ, CANSYNC_DOMAIN=str(self.domain), CANSYNC_BUS=self.bus, TZ="UTC",
                                TERM="xterm")
        self._looker, self._looked_at = None, None

    def become(self, identity):
        """From now on `cansync` has this identity, a folder; None: without."""
        self.environment.pop("CANSYNC_SECURITY", None)
        if identity is not None:
            self.environment["CANSYNC_SECURITY"] = identity

    def start(self, *arguments, **options):
        """`cansync` with these arguments, running."""
        options.setdefault("stdout", subprocess.PIPE)
        options.setdefault("stderr", subprocess.PIPE)
        return Verb(arguments, env=self.environment, **options)

    def run(self, *arguments, data=None):
        """`cansync` with these arguments, to its end. Output as text; `data` is its standard input."""
        with self.start(*arguments, stdin=subprocess.PIPE) as process:
            try:
                out, err = process.communicate(data, timeout=LONG)
            except subprocess.TimeoutExpired:
                process.kill()
                raise
        return subprocess.CompletedProcess(arguments, process.returncode, out, err.decode())

    def look(self, *arguments, daemon=None):
        """The one object that `cansync` with these arguments and --json prints, for what is looked at again and again; None when it says
        anything else. `daemon`: the process that is to tell it; of another one's nothing is taken over."""
        looked_at = daemon, self.environment.get("CANSYNC_SECURITY")
        if self._looker and self._looked_at != looked_at:
            self.look_no_more()
        if not self._looker:
            self._looker, self._looked_at = Looker(self.environment), looked_at
        found = self._looker.look(arguments)
        if found is None:
            self.look_no_more()
        return found

    def look_no_more(self):
        if self._looker:
            self._looker.end()
        self._looker = None

    def run_on_terminal(self, *arguments, columns=80, rows=24):
        """Like `run`, with standard output and error on one terminal; all that it showed, and the exit code."""
        terminal, other = pty.openpty()
        fcntl.ioctl(other, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        process = self.start(*arguments, stdout=other, stderr=other)
        os.close(other)
        shown = b""
        deadline = time.monotonic() + LONG
        while time.monotonic() < deadline:
            if not select.select([terminal], [], [], 0.1)[0]:
                continue
            try:
                part = os.read(terminal, 65536)
            except OSError:  # the last process has closed it
                break
            shown += part
        os.close(terminal)
        expect_wording(arguments, shown)
        return shown.decode(), process.wait(LONG)


class Gateway(Place):
    """A daemon with a simulated line; a context manager."""

    def __init__(self, slaves=4, bit_rate=BIT_RATE, extra="", options=()):
        super().__init__()
        self.slaves = slaves
        self.folder = tempfile.TemporaryDirectory(prefix="cansync_test_")
        self.config = os.path.join(self.folder.name, "line.toml")
        self.log = os.path.join(self.folder.name, "daemon.log")
        with open(self.config, "w", encoding="utf-8") as file:
            file.write(self._toml(bit_rate) + extra)
        self.options = [*AGAINST_STALLS, *options]
        self.process = None

    def _toml(self, bit_rate):
        text = f"""
[bus]
name = "{self.bus}"
interface = "sim"
bit_rate = {bit_rate}
[dds]
domain = {self.domain}
[sim]
lock_time_ms = 50
[[reference]]
number = 0
name = "target"
unit = "mm"
factor = 0.001
"""
        for slave in range(self.slaves):
            text += f"[[slave]]\nnumber = {slave}\n"
            if slave == 1:
                text += 'name = "winder"\n[[slave.value]]\nnumber = 0\nname = "position"\nunit = "mm"\nfactor = 0.001\n'
        return text

    def __enter__(self):
        with open(self.log, "wb") as log:
            self.process = subprocess.Popen([CANSYNCD, *self.options, self.config], stdout=log, stderr=log)
        try:
            self.wait_active()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, kind=None, *_):
        code = self.stop()
        expect_wording("the daemon", self.log_text())
        self.folder.cleanup()
        if code != 0 and kind is None:
            raise AssertionError(f"the daemon ended with {code}")

    def stop(self):
        """Ends the daemon in order; its exit code."""
        self.look_no_more()
        return end(self.process)

    def log_text(self):
        with open(self.log, encoding="utf-8", errors="replace") as file:
            return file.read()

    def status(self):
        """The daemon's status, or None while it cannot be had."""
        if self.process.poll() is not None:
            raise AssertionError("the daemon has ended:\n" + self.log_text())
        return self.look("status", daemon=self.process.pid)

    def wait_status(self, what, condition):
        def look():
            status = self.status()
            return status if status and condition(status) else None

        return wait_for(what, look, pause=0.1)

    def start_job(self, counter, *arguments):
        """`cansync` with a job that does not end by itself; back as soon as `counter` of the status shows it open."""
        # The status comes up to a second late: an earlier job must not be taken for this one.
        self.wait_status("no job is open", lambda status: status[counter] == 0)
        process = self.start(*arguments)

        def is_open(status):
            if process.poll() is not None:
                out, err = process.communicate(timeout=LONG)
                raise AssertionError(f"{arguments} has ended with {process.returncode}:\n{out}\n{err}")
            return status[counter] == 1

        self.wait_status("the job is open", is_open)
        return process

    def wait_active(self):
        every = (1 << self.slaves) - 1
        return self.wait_status(
            "every slave synchronized in active operation",
            lambda s: s["option_status"] == ACTIVE and s["slaves_synchronized"] == every,
        )

    def json(self, *arguments, code=0):
        """The objects that `cansync ... --json` printed; its exit code must be `code`."""
        result = self.run(*arguments, "--json")
        if result.returncode != code:
            raise AssertionError(
                f"{arguments}: exit code {result.returncode} instead of {code}\n{result.stdout}\n{result.stderr}\n"
                f"status: {self.run('status', '--json').stdout}\nthe daemon's log:\n{self.log_text()}"
            )
        return [json.loads(line) for line in result.stdout.splitlines()]

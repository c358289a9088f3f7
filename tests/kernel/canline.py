"""vcan0 and the programs on it, for tests inside the machine."""

import json
import os
import socket
import struct
import subprocess
import tempfile
import time
import unittest

import gateway
from gateway import CANSYNC, ACTIVE, CANSYNCD, Place, end, wait_for

LONG = 90  # seconds; one wait
gateway.LONG = LONG
gateway.PAUSES = 4  # a pause costs the machine nothing, a look half a second of its host
CANSYNC_SIM = os.environ["CANSYNC_SIM"]
INTERFACE = "vcan0"
SYNC = "080"  # identifier of the software SYNC frame
BIT_RATE = 125000  # an interval of 8 ms: the shorter, the more the processor has to do
RECEIVE_BUFFER = "8000000"  # bytes: no frame is missed while candump gets no processor time
PROBE = "1FFFFFF0#"  # nobody takes it; it shows that candump listens


def ip(*arguments):
    subprocess.run(["ip", *arguments], check=True, timeout=LONG)


def interface_exists(interface=INTERFACE):
    return os.path.exists(f"/sys/class/net/{interface}")


def create_interface(interface=INTERFACE):
    """A new one that is up, in the place of one that is there."""
    if interface_exists(interface):
        delete_interface(interface)
    ip("link", "add", "dev", interface, "type", "vcan")
    ip("link", "set", interface, "up")


def delete_interface(interface=INTERFACE):
    ip("link", "delete", interface)


class Wire:
    """A raw socket on an interface: somebody else on the bus. Frames are written as candump does, `identifier#data`,
    remote ones `identifier#R`."""

    def __init__(self, interface=INTERFACE):
        self.socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self.socket.bind((interface,))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def send(self, text):
        identifier, data = text.split("#")
        number = int(identifier, 16) | (socket.CAN_EFF_FLAG if len(identifier) == 8 else 0)
        if data == "R":
            number, data = number | socket.CAN_RTR_FLAG, ""
        payload = bytes.fromhex(data)
        self.socket.send(struct.pack("=IB3x8s", number, len(payload), payload))

    def receive(self, seconds=10):
        """The next frame; None when none comes in that time."""
        self.socket.settimeout(seconds)
        try:
            identifier, length, data = struct.unpack("=IB3x8s", self.socket.recv(16))
        except TimeoutError:
            return None
        return f"{identifier:03X}#{data[:length].hex().upper()}"

    def receive_from(self, identifier, seconds=10):
        """The next frame with this identifier; None when none comes in that time."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            frame = self.receive(max(0.001, deadline - time.monotonic()))
            if frame is not None and frame.startswith(identifier + "#"):
                return frame
        return None

    def ask(self, command):
        """Sends a command `5NN#...` until its slave answers, as a master does: drives leave out answers
        that come too late. The answer's data."""
        answer = f"{int(command[:3], 16) + 0x80:03X}"

        def answered():
            self.send(command)
            return self.receive_from(answer, 0.5)

        return wait_for(f"an answer to {command}", answered).split("#")[1]


class Candump:
    """`candump -L` of an interface into a file; a context manager."""

    def __init__(self, interface=INTERFACE):
        self.interface = interface
        self.file = tempfile.NamedTemporaryFile(prefix="candump_", suffix=".log")
        self.reader = open(self.file.name, encoding="ascii")
        self.lines, self.pending = [], ""
        self.process = None

    def __enter__(self):
        self.process = subprocess.Popen(["candump", "-L", "-r", RECEIVE_BUFFER, self.interface], stdout=self.file)
        with Wire(self.interface) as wire:
            wait_for("candump listens", lambda: wire.send(PROBE) or PROBE in self._read())
        return self

    def __exit__(self, *_):
        end(self.process)
        self.reader.close()

    def _read(self):
        """All lines so far; those read before are not read again."""
        self.pending += self.reader.read()
        *lines, self.pending = self.pending.split("\n")
        self.lines += [line.split()[2] for line in lines]
        return self.lines

    def frames(self):
        """All frames so far, as `identifier#data`, in the order of the bus."""
        return [frame for frame in self._read() if frame != PROBE]

    def log(self):
        """All lines so far, as candump wrote them."""
        with open(self.file.name, encoding="ascii") as file:
            return [line for line in file.read().split("\n")[:-1] if PROBE not in line]

    def times_of(self, identifier):
        """When the frames with this identifier came, in ns."""
        lines = [line.split() for line in self.log()]
        return [int(line[0].strip("()").replace(".", "")) * 1000 for line in lines if line[2].startswith(identifier + "#")]

    def wait_for_frame(self, frame):
        wait_for(f"{frame} on the bus", lambda: frame in self._read())


class Process:
    """A program with its output in a file; a context manager that ends it."""

    def __init__(self, *command):
        self.command = [str(part) for part in command]
        self.log = tempfile.NamedTemporaryFile(prefix="program_", suffix=".log")
        self.process = None

    def start(self):
        self.process = subprocess.Popen(self.command, stdout=self.log, stderr=subprocess.STDOUT)

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.kill()

    def text(self):
        with open(self.log.name, encoding="utf-8", errors="replace") as file:
            return file.read()

    def wait_text(self, text, count=1):
        wait_for(f"{count} times '{text}' from {self.command[0]}", lambda: self.text().count(text) >= count or
                 self._must_live())

    def _must_live(self):
        if self.process.poll() is not None:
            raise AssertionError(f"{self.command} has ended:\n{self.text()}")

    def stop(self):
        """SIGTERM; the exit code."""
        return end(self.process)

    def kill(self):
        self.process.kill()
        self.process.wait(LONG)


class Simulator(Process):
    """`cansync-sim` at 125 kbit/s."""

    def __init__(self, *options, slaves="0-3", interface=INTERFACE):
        super().__init__(CANSYNC_SIM, interface, "--slaves", slaves, "--bit-rate", BIT_RATE, "--lock-time", 50,
                         "--sync-id", "0x" + SYNC, "--missing-references", 0, "--verbose", *options)

    def start(self):
        super().start()
        self.wait_text("SYNC frame 0x")


class Daemon(Place):
    """cansyncd on a CAN interface; a context manager. A class of it says what it is on the bus."""

    PROTOCOL = ""
    BIT_RATE = BIT_RATE

    def __init__(self, interface=INTERFACE):
        super().__init__()
        self.interface = interface
        self.config = tempfile.NamedTemporaryFile("w", prefix="line_", suffix=".toml", encoding="utf-8")
        self.config.write(f'[bus]\nprotocol = "{self.PROTOCOL}"\nname = "{self.bus}"\nbit_rate = {self.BIT_RATE}\n'
                          f'{self.on_interface()}[dds]\ndomain = {self.domain}\n{self.role()}')
        self.config.flush()
        self.program = Process(CANSYNCD, self.config.name)

    def on_interface(self):
        """Goes on with [bus]."""
        return f'interface = "{self.interface}"\n'

    def role(self):
        """The sections of the configuration that belong to the role on the bus."""
        return ""

    def __enter__(self):
        self.program.start()
        return self

    def __exit__(self, *_):
        self.program.__exit__()

    def log_text(self):
        return self.program.text()

    def restart(self):
        """As after a crash: SIGKILL, then started anew."""
        self.program.kill()
        self.program.start()

    def verb(self, *arguments):
        """A verb that must end well; what it printed."""
        result = self.run(*arguments)
        if result.returncode != 0:
            raise AssertionError(f"{arguments}: {result.returncode}\n{result.stderr}\nthe daemon:\n{self.log_text()}")
        return result.stdout.decode()

    def objects(self, *arguments):
        return [json.loads(line) for line in self.verb(*arguments, "--json").splitlines()]

    def status(self):
        """The daemon's status, or None while it cannot be had."""
        if self.program.process.poll() is not None:
            raise AssertionError("the daemon has ended:\n" + self.log_text())
        return self.look("status", daemon=self.program.process.pid)

    def wait_status(self, what, condition):
        last = None

        def look():
            nonlocal last
            last = self.status()
            return last if last and condition(last) else None

        try:
            return wait_for(what, look, pause=0.1)
        except AssertionError as error:
            raise AssertionError(f"{error}\nstatus: {last}\nthe daemon:\n{self.log_text()}") from None

    def events(self, code):
        """The events with this code, since the daemon started."""
        return [event for event in self.objects("events") if event["code"] == code]

    def wait_event(self, code):
        return wait_for(f"event {code}", lambda: self.events(code))


class Master(Daemon):
    """The master of slaves 0 and more at 125 kbit/s, with the software SYNC frame."""

    PROTOCOL = "cansync-master"
    STARTUP = "listen_ms = 10\n"  # of [startup]; the tests know that no other master is there

    def __init__(self, slaves=4, interface=INTERFACE):
        self.slaves = slaves
        super().__init__(interface)

    def role(self):
        text = f'[sync]\noutput = "can"\ncan_identifier = 0x{SYNC}\n[startup]\n{self.STARTUP}'
        return text + "".join(f"[[slave]]\nnumber = {slave}\n" for slave in range(self.slaves))

    def wait_active(self):
        every = (1 << self.slaves) - 1
        return self.wait_status("every slave synchronized in active operation",
                                lambda s: s["option_status"] == ACTIVE and s["slaves_synchronized"] == every)

    def writer(self, *values):
        """Keeps writing these reference values; a context manager."""
        return Process(CANSYNC, "--domain", self.domain, "--bus", self.bus, "set", *values)


class GeneralFrames(Daemon):
    """General frames, with these sections of its configuration."""

    PROTOCOL = "layer2"

    def __init__(self, sections="", interface=INTERFACE):
        self.sections = sections
        super().__init__(interface)

    def role(self):
        return f"[send]\ntimeout_ms = 30000\n{self.sections}"


class Line(unittest.TestCase):
    """A master in active operation with its simulated drives on vcan0, one for all tests of a class: each leaves it so."""

    @classmethod
    def setUpClass(cls):
        create_interface()
        cls.simulator = cls.enterClassContext(Simulator())
        cls.daemon = cls.enterClassContext(Master())
        cls.daemon.wait_active()

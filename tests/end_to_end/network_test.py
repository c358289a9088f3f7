"""A network interface for DDS that comes late, goes, and comes back with another address, and a bus name that another
computer has: the line runs on, no SYNC edge is left out or made twice, no value is released more often than its writer asks
for, and each request has one answer. In network namespaces."""

import collections
import json
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from gateway import ACTIVE, CANSYNC, CANSYNCD, LONG, OWN_TIME, end, wait_for

INSIDE = "CANSYNC_NETWORK_TEST"
INTERVAL = 8000  # us, at 125 kbit/s
PARAMETER = 1000  # of a simulated drive
UNCERTAIN = ("no_reply", "no_answer")  # whether it was done is not known
NO_DAEMON = 6  # exit code
PLACE = ("--domain", "7", "--bus", "press")


def ip(*arguments, check=True):
    return subprocess.run(["ip", *arguments], check=check, capture_output=True, timeout=LONG)


class Wire:
    """The bus of the daemon and all that was on it: a virtual CAN interface with simulated drives where the kernel has one, else
    the simulation in the daemon. A context manager."""

    def __init__(self, folder):
        self.log = os.path.join(folder, "frames.log")
        self.programs = []

    def __enter__(self):
        self.is_there = ip("link", "add", "vcan0", "type", "vcan", check=False).returncode == 0
        if self.is_there:
            ip("link", "set", "vcan0", "up")
            with open(self.log, "wb") as out:
                self.programs.append(subprocess.Popen(["candump", "-L", "-r", "8000000", "vcan0"], stdout=out))
            self.programs.append(subprocess.Popen(
                [os.environ["CANSYNC_SIM"], "vcan0", "--slaves", "0-3", "--bit-rate", "125000", "--lock-time", "50", "--sync-id",
                 "0x080", "--missing-references", "0"], stdout=subprocess.DEVNULL))
        return self

    def __exit__(self, *_):
        for program in self.programs:
            end(program)
        self.programs = []

    def configuration(self):
        text = f'[bus]\nbit_rate = 125000\ninterface = "{"vcan0" if self.is_there else "sim"}"\n[startup]\nlisten_ms = 10\n'
        if self.is_there:
            text += '[sync]\noutput = "can"\ncan_identifier = 0x080\n'
        return text

    def options(self):
        return () if self.is_there else ("--trace", self.log, "--set", "sim.missing_edges=65535", "--set", "sim.missing_references=0")

    def end(self):
        """Time in us and frame of everything that was on the bus."""
        self.__exit__()
        with open(self.log, encoding="ascii") as file:
            lines = [line.split() for line in file]
        return [(int(line[0].strip("()").replace(".", "")), line[2]) for line in lines]


class Client:
    """A client that writes another value again and again and reads what the drive has. A context manager."""

    def __init__(self, slave, interface, *before):
        self.slave = slave
        self.course = []  # value, answer to the write, answer to the read, value that was read
        self.process = subprocess.Popen([*before, CANSYNC, "--interface", interface, *PLACE, "batch", "-", "--json", "--continue"],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.ending = self.finished = False
        self.thread = threading.Thread(target=self.run)

    def __enter__(self):
        self.thread.start()
        return self

    def ask(self, line):
        """What the command tells; exactly one answer."""
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        found = []
        while not found or "exit_code" not in found[-1]:
            found.append(json.loads(self.process.stdout.readline()))
        *answers, ended = found
        if not answers and ended["exit_code"] == NO_DAEMON:
            return {"result": "no_daemon"}
        answer, = answers
        return answer

    def run(self):
        while not self.ending:
            value = 10000 * self.slave + len(self.course)
            written = self.ask(f"write {self.slave} {PARAMETER} {value}")
            read = self.ask(f"read {self.slave} {PARAMETER}")
            self.course.append((value, written["result"], read["result"], read.get("value")))
            time.sleep(0.2)  # a request costs processor time of the host, a pause nothing
        self.finished = True

    def told(self):
        return self.process.poll(), self.course[-3:]

    def served(self):
        return sum(written == "done" for _, written, *_ in self.course)

    def end(self):
        """After what it has asked for last."""
        self.ending = True
        self.thread.join(LONG)
        if not self.finished:
            raise AssertionError(f"a request without an answer: {self.told()}")
        self.process.stdin.close()
        self.process.wait(LONG)

    def __exit__(self, *_):
        self.ending = True
        self.process.kill()
        self.process.wait(LONG)
        for pipe in (self.process.stdin, self.process.stdout):
            pipe.close()


class Writer:
    """Gives another reference value every 50 ms, each for `release` intervals. A context manager."""

    def __init__(self, interface, release):
        self.release = release
        self.output = tempfile.NamedTemporaryFile("r", prefix="writer_")
        with open(self.output.name, "wb") as out:
            self.process = subprocess.Popen([os.environ["STAMPED_WRITER"], "7", "press", "50", str(release), interface, interface],
                                            stdout=out, stderr=out)

    def __enter__(self):
        return self

    def values(self):
        """Those that it has given; it tells before which it could not."""
        self.output.seek(0)
        return [int(value) for refused, value in re.findall(r"(?m)^(?:(not written).*\n)?(\d+) \d+\n", self.output.read()) if not refused]

    def told(self):
        self.output.seek(0)
        return self.output.read()[-300:]

    def served(self):
        return len(self.values())

    def end(self):
        self.process.kill()
        self.process.wait(LONG)

    def __exit__(self, *_):
        self.end()
        self.output.close()


class Network(unittest.TestCase):
    """The test itself runs in a namespace of its own, that of this computer; `plc2` is another one."""

    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="cansync_test_"))
        self.other = subprocess.Popen(["unshare", "--net", "--uts", "sleep", "infinity"])
        self.addCleanup(self.end_other)
        wait_for("the other namespace", lambda: self.in_other("ip", "link").returncode == 0
                 and os.readlink(f"/proc/{self.other.pid}/ns/net") != os.readlink("/proc/self/ns/net"))
        self.in_other("hostname", "plc2")
        self.in_other("ip", "link", "set", "lo", "up")
        self.addCleanup(ip, "link", "delete", "plant0", check=False)

    def end_other(self):
        self.other.kill()
        self.other.wait(LONG)

    def in_other(self, *command):
        return subprocess.run(["nsenter", f"--target={self.other.pid}", "--net", "--uts", *command],
                              capture_output=True, timeout=LONG, check=False)

    def plug(self, address):
        """The cable between both computers."""
        ip("link", "add", "plant0", "type", "veth", "peer", "name", "plant0", "netns", str(self.other.pid))
        self.assertEqual(self.in_other("ip", "address", "add", "10.93.0.2/24", "dev", "plant0").returncode, 0)
        self.assertEqual(self.in_other("ip", "link", "set", "plant0", "up").returncode, 0)
        ip("link", "set", "plant0", "up")
        self.address(address)

    def address(self, address):
        ip("address", "flush", "dev", "plant0")
        ip("address", "add", address, "dev", "plant0")

    def start(self, *before, configuration='[bus]\ninterface = "sim"\n[sim]\nmissing_edges = 65535\n', options=()):
        path = os.path.join(self.folder, f"line{len(before)}.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(f'{configuration}[dds]\ndomain = 7\ninterface = "plant0"\n' + "".join(f"[[slave]]\nnumber = {n}\n" for n in range(4)))
        log = os.path.join(self.folder, f"log{len(before)}")
        with open(log, "wb") as out:
            process = subprocess.Popen([*before, CANSYNCD, "--set", "bus.name=press", *options, path], stdout=out, stderr=out)
        self.addCleanup(lambda: process.poll() is None and end(process))

        def text():
            with open(log, encoding="utf-8", errors="replace") as file:
                return file.read()

        return process, text

    def ask(self, interface, *before):
        """The status by this interface; None: no daemon is there."""
        found = subprocess.run([*before, CANSYNC, "--interface", interface, *PLACE, "status", "--json"], capture_output=True, timeout=LONG, check=False)
        return json.loads(found.stdout) if found.returncode == 0 else None

    def verb(self, interface, bus, *arguments, before=()):
        return subprocess.run([*before, CANSYNC, "--interface", interface, "--domain", "7", "--bus", bus, *map(str, arguments)],
                              capture_output=True, timeout=LONG, check=False, text=True)

    def wait_at(self, interface, condition, *before):
        def look():
            status = self.ask(interface, *before)
            return status if status and condition(status) else None

        return wait_for(f"a status by {interface}", look)

    def other_asks(self):
        return ["nsenter", f"--target={self.other.pid}", "--net", "--uts"]

    def test_an_interface_that_comes_late_goes_and_has_another_address(self):
        wire = self.enterContext(Wire(self.folder))
        daemon, log = self.start(configuration=wire.configuration(), options=wire.options())
        first = self.wait_at("lo", lambda s: s["option_status"] == ACTIVE)
        self.assertEqual(first["network"], "local")
        self.assertIn("'plant0' (dds.interface) does not exist", first["network_reason"])
        near = self.enterContext(Client(1, "lo"))
        writers = [self.enterContext(Writer("lo", release=3))]
        calm = [self.work(near, writers[-1])]
        far = None
        for address, bring in [("10.93.0.1/24", self.plug), ("10.93.0.7/24", self.address)]:
            bring(address)
            status = self.wait_at("plant0", lambda s: s["network"] == "joined", *self.other_asks())
            self.assertEqual(status["network_reason"], "")
            self.assertEqual(status["dds_interface"], "plant0")
            self.expect_same_line(first, status)
            far = far or self.enterContext(Client(2, "plant0", *self.other_asks()))
            writers.append(self.enterContext(Writer("plant0", release=2)))
            calm.append(self.work(far, writers[-1]))
            writers[-1].end()
        ip("link", "delete", "plant0")
        status = self.wait_at("lo", lambda s: s["network"] == "local")
        self.expect_same_line(first, status)
        calm.append(self.work(near, writers[0]))
        self.plug("10.93.0.9/24")
        status = self.wait_at("plant0", lambda s: s["network"] == "joined", *self.other_asks())
        self.expect_same_line(first, status)
        self.assertEqual(log().count("clients of the network are served"), 3)
        self.assertEqual(log().count("only clients of this computer are served"), 2)
        for one in (near, far, *writers):
            one.end()
        self.assertEqual(end(daemon), 0, log())
        seen = wire.end()
        self.expect_every_edge(seen)
        self.expect_released_as_asked(seen, writers, calm)
        for client in (near, far):
            self.expect_every_answer(seen, client)

    def work(self, client, writer):
        """Until both have been served for a second; from when to when that was, in ms, and whose values."""
        began = time.monotonic()
        for one, least in ((client, 5), (writer, 20)):
            before = one.served()
            wait_for("it is served", lambda: one.served() >= before + least)
        return began * 1000, time.monotonic() * 1000 - 100, writer

    def expect_same_line(self, first, now):
        """The master never left run."""
        self.assertEqual(now["daemon"], first["daemon"])
        self.assertEqual(now["option_status"], ACTIVE)
        self.assertEqual(now["state"], first["state"])
        self.assertGreater(now["interval"], first["interval"])

    def expect_every_edge(self, seen):
        """From the first SYNC to the last one in each interval, whatever happened to the network."""
        edges = [at for at, frame in seen if frame == "080#"]
        intervals = round((edges[-1] - edges[0]) / INTERVAL)
        print(f"{len(edges)} SYNC in {intervals} intervals, steps of {min(map(int.__sub__, edges[1:], edges))} to "
              f"{max(map(int.__sub__, edges[1:], edges))} us")
        if OWN_TIME:
            self.assertEqual(len(edges), intervals + 1)
            self.assertEqual([step for step in map(int.__sub__, edges[1:], edges) if round(step / INTERVAL) != 1], [])

    def expect_released_as_asked(self, seen, writers, calm):
        """No value more often than its writer asked for; and while the network did not change, not less often either."""
        released = collections.Counter(int.from_bytes(bytes.fromhex(frame[4:12]), "little") for _, frame in seen
                                       if re.match("1[0-7].#", frame))
        released.pop(0, None)
        asked = {value: writer.release for writer in writers for value in writer.values()}
        self.assertEqual({value: count for value, count in released.items() if count > asked.get(value, 0)}, {})
        for began, ended, writer in calm:
            given = [value for value in writer.values() if began <= value <= ended]
            counts = [released[value] for value in given]
            print(f"{len(given)} values, each for {writer.release} intervals: {dict(collections.Counter(counts))}")
            if OWN_TIME:
                # Until then another writer may have had the telegram, and what it wrote while it and the daemon got to know each
                # other may come all at once: the newest counts.
                first = next(number for number, count in enumerate(counts) if count == writer.release)
                self.assertEqual(set(counts[first:]), {writer.release})
                self.assertGreaterEqual(len(counts[first:]), 10)

    def expect_every_answer(self, seen, client):
        """Each request has one answer; no write was on the bus twice, and one that is done was there, and its drive has it."""
        sent = collections.Counter(int.from_bytes(bytes.fromhex(frame[8:12]), "little") for _, frame in seen
                                   if frame.startswith(f"50{client.slave}#") and len(frame) >= 16)
        answers = collections.Counter(answer for _, answer, *_ in client.course)
        print(f"slave {client.slave}: {dict(answers)}")
        self.assertGreater(answers["done"], 0)
        allowed = set()
        for value, written, read, found in client.course:
            if written == "done":
                allowed = {value}
            elif written in UNCERTAIN:
                allowed.add(value)
            if read == "done":
                self.assertIn(found, allowed)
                allowed = {found}
            if OWN_TIME:
                self.assertIn(sent[value], {"done": (1,)}.get(written, (0, 1) if written in UNCERTAIN else (0,)), (value, written))

    def test_a_name_that_another_computer_has_is_not_taken_from_it(self):
        self.plug("10.93.0.1/24")
        other, _ = self.start(*self.other_asks())
        there = self.wait_at("plant0", lambda s: s["option_status"] == ACTIVE, *self.other_asks())
        _, log = self.start()
        here = self.wait_at("lo", lambda s: s["option_status"] == ACTIVE)
        self.assertEqual(here["name_taken_by"], "plc2")
        self.assertEqual(here["network"], "local")
        self.assertIn("has the name of bus press", here["network_reason"])
        self.assertIn("computer plc2", log())
        # Whoever asks on the network gets the one that was there, and that one alone.
        self.assertEqual(self.ask("plant0", *self.other_asks())["daemon"], there["daemon"])
        self.assertEqual(self.ask("plant0")["daemon"], there["daemon"])
        # A client that means one of the two computers reaches that one or none.
        for address, before, lacks in (("plc1/press", self.other_asks(), True), ("plc1/press", (), True), ("plc2/press", (), False)):
            written = self.verb("plant0", address, "write", "1", PARAMETER, "4711", before=before)
            self.assertEqual(written.returncode, NO_DAEMON if lacks else 0, written.stderr)
            if lacks:
                self.assertIn("bus press of computer plc1 is not served", written.stderr)
                self.assertIn("on host plc2", written.stderr)
                self.assertNotIn("4711", self.verb("plant0", "press", "read", "1", PARAMETER).stdout)
        self.assertIn("4711", self.verb("plant0", "press", "read", "1", PARAMETER).stdout)
        self.assertNotIn("4711", self.verb("lo", "plc1/press", "read", "1", PARAMETER).stdout)
        doctor = [json.loads(line) for line in self.verb("lo", "plc1/press", "doctor", "--json").stdout.splitlines()]
        self.assertTrue(any(line["topic"] == "network" and "computer plc2" in line["found"] for line in doctor), doctor)
        end(other)
        joined = self.wait_at("plant0", lambda s: s["daemon"] == here["daemon"] and s["network"] == "joined")
        self.assertEqual(joined["name_taken_by"], "")


if __name__ == "__main__":
    if INSIDE not in os.environ:
        # As root the daemon has its realtime rights, too.
        user = [] if OWN_TIME else ["--user", "--map-root-user"]
        enter = ["unshare", *user, "--net", "--uts", "--mount-proc", "--pid", "--fork"]
        if subprocess.run([*enter, "ip", "link", "add", "a0", "type", "veth", "peer", "name", "b0"], check=False,
                          capture_output=True, timeout=LONG).returncode != 0:
            print("skipped: this system makes no network namespaces with interfaces")
            sys.exit(77)
        os.environ[INSIDE] = "1"
        os.execvp(enter[0], [*enter, sys.executable, "-B", *sys.argv])
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True, timeout=LONG)
    subprocess.run(["hostname", "plc1"], check=True, timeout=LONG)
    unittest.main(argv=[sys.argv[0], *[f"Network.{name}" for name in sys.argv[1:] if name]])

"""What happens to cansyncd when bus, interface or drives do what they should not. Nothing here may need a restart."""

import signal
import subprocess
import time
import unittest

from canline import (INTERFACE, LONG, SYNC, Candump, Line, Master, Process, Simulator, Wire, create_interface, delete_interface,
                     interface_exists, ip)
from gateway import CANSYNCD, wait_for


class DisturbanceTest(Line):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.process = cls.daemon.program.process.pid

    def tearDown(self):
        self.assertIsNone(self.daemon.program.process.poll(), self.daemon.log_text())

    def assert_healthy(self):
        """Active, every slave synchronized, jobs are served, and it is still the same process."""
        self.daemon.wait_active()
        wait_for("a parameter is read", lambda: self.daemon.run("read", 1, 100).returncode == 0)
        self.assertEqual(self.daemon.program.process.pid, self.process)

    def count(self, name):
        return self.daemon.wait_status("a status", lambda status: True)[name]

    def events_since(self, before, code):
        return len(self.daemon.events(code)) - before


class Interface(DisturbanceTest):
    def setUp(self):
        self.addCleanup(self.bring_up)

    @staticmethod
    def bring_up():
        """Whatever a test left behind: the next one finds the interface up."""
        if not interface_exists():
            create_interface()
        ip("link", "set", INTERFACE, "up")

    def test_cable_pulled(self):
        down, up = len(self.daemon.events("interface_down")), len(self.daemon.events("interface_up"))
        ip("link", "set", INTERFACE, "down")
        self.daemon.wait_status("the interface is down", lambda s: s["link_state"] == "down")
        self.daemon.wait_event("interface_down")
        self.assertEqual(self.events_since(down, "interface_down"), 1)
        ip("link", "set", INTERFACE, "up")
        self.assert_healthy()
        self.assertEqual(self.events_since(down, "interface_down"), 1, "told once")
        self.assertEqual(self.events_since(up, "interface_up"), 1, "told once")

    def test_interface_deleted_and_created_again(self):
        missing = len(self.daemon.events("interface_missing"))
        delete_interface()
        self.daemon.wait_status("the interface is missing", lambda s: s["link_state"] == "missing")
        self.daemon.wait_event("interface_missing")
        self.assertEqual(self.events_since(missing, "interface_missing"), 1)
        create_interface()
        self.daemon.wait_status("the interface is up", lambda s: s["link_state"] == "up")
        self.assert_healthy()
        self.assertEqual(self.events_since(missing, "interface_missing"), 1, "told once")

    def test_full_queue(self):
        # vcan takes every frame at once; a queueing discipline that lets eight frames a second through does not.
        before, events = self.count("queue_full"), len(self.daemon.events("sending_failed"))
        self.tc("add", "tbf", "rate", "1kbit", "burst", "32", "limit", "64")
        try:
            self.daemon.wait_status("telegrams do not fit", lambda s: s["queue_full"] > before + 100)
        finally:
            self.tc("del")
        self.assert_healthy()
        self.assertGreaterEqual(self.events_since(events, "sending_failed"), 1)

    @staticmethod
    def tc(what, *discipline):
        subprocess.run(["tc", "qdisc", what, "dev", INTERFACE, "root", *discipline], check=True, timeout=LONG)


class InterfaceMissingAtStart(unittest.TestCase):
    def test_it_starts_and_goes_on_when_the_interface_comes(self):
        if interface_exists():
            delete_interface()
        with Master() as daemon, Simulator("--wait") as simulator:
            daemon.wait_status("the interface is missing", lambda s: s["link_state"] == "missing")
            daemon.wait_event("interface_missing")
            self.assertEqual(len(daemon.events("interface_missing")), 1)
            create_interface()
            daemon.wait_active()
            self.assertEqual(len(daemon.events("interface_missing")), 1, "told once")
            self.assertIn("vcan0 does not exist; waiting for it", simulator.text())


class TwoBuses(unittest.TestCase):
    OTHER = "vcan1"
    GAPS = (0.1, 0.3, 0.1, 1, 3, 0.3, 0.1)  # seconds
    INTERVAL = 8_000_000  # ns

    def test_an_adapter_that_comes_and_goes_leaves_the_other_bus_alone(self):
        for interface in (INTERFACE, self.OTHER):
            create_interface(interface)
            self.addCleanup(delete_interface, interface)
        steady, flapping = Master(), Master(interface=self.OTHER)
        steady.program = flapping.program = Process(CANSYNCD, steady.config.name, flapping.config.name)
        with Simulator(), Simulator(interface=self.OTHER), steady:
            steady.wait_active()
            flapping.wait_active()
            with flapping.start("watch") as hangs, flapping.writer("0=1") as writer, Candump() as wire:
                hangs.stdout.readline()
                hangs.send_signal(signal.SIGSTOP)
                for gap in self.GAPS:
                    before = flapping.objects("events")[-1]["number"]
                    delete_interface(self.OTHER)
                    time.sleep(gap)
                    create_interface(self.OTHER)
                    # The topic keeps the last 100 events of a severity: they are not counted over all gaps.
                    wait_for("it has its interface", lambda before=before: any(event["number"] > before for event in flapping.events("interface_up")))
                    flapping.wait_active()
                    released = flapping.wait_status("the writer's values are released", lambda s: s["reference_release"][0]["state"] == "released")
                    self.assertIn(f"process {writer.process.pid} ", released["reference_release"][0]["writer"])
                self.assertIsNone(writer.process.poll())
                hangs.kill()
                times = wire.times_of(SYNC)
            self.assertEqual(len(flapping.events("interface_missing")), len(self.GAPS))
            self.assertEqual(len(times), 1 + round((times[-1] - times[0]) / self.INTERVAL), "no SYNC edge is missing on the other bus")
            self.assertLess(max(abs(late - early - self.INTERVAL) for early, late in zip(times, times[1:])), 1_000_000)
            self.assertEqual(steady.events("slave_lost"), [])


class Strangers(DisturbanceTest):
    def setUp(self):
        self.wire = self.enterContext(Wire())

    def test_foreign_frames_do_not_matter(self):
        rejected = self.count("rejected_frames")
        for frame in ("7FF#0102030405060708", "200#", "011#00", "1FFFFFFF#AA"):
            self.wire.send(frame)
        self.assert_healthy()
        self.assertEqual(self.count("rejected_frames"), rejected, "the kernel's filter keeps them away")

    def test_extended_and_remote_frames_on_identifiers_of_cansync_are_counted(self):
        extended, remote = self.count("frames_extended"), self.count("frames_remote")
        for frame in ("00000501#70670000", "00000581#0000", "581#R"):
            self.wire.send(frame)
        self.daemon.wait_status("extended ones are counted", lambda s: s["frames_extended"] >= extended + 2)
        self.daemon.wait_status("remote ones are counted", lambda s: s["frames_remote"] >= remote + 1)
        self.assert_healthy()

    def test_malformed_and_unasked_answers_are_counted(self):
        rejected, unexpected = self.count("rejected_frames"), self.count("unexpected_frames")
        for _ in range(3):
            self.wire.send("581#03")  # a response has two bytes or more
            self.wire.send("583#006703000000")  # nobody has asked for parameter 103
        self.daemon.wait_status("malformed ones are counted", lambda s: s["rejected_frames"] >= rejected + 3)
        self.daemon.wait_status("unasked ones are counted", lambda s: s["unexpected_frames"] >= unexpected + 3)
        self.assert_healthy()

    def test_second_master(self):
        before = self.count("second_master_frames")
        events = len(self.daemon.events("second_master"))
        for _ in range(5):
            subprocess.run(["cansend", INTERFACE, "502#70670000"], check=True, timeout=LONG)
        self.daemon.wait_status("it is seen", lambda s: s["second_master_frames"] >= before + 5)
        self.assertEqual(self.events_since(events, "second_master"), 1, "told once")
        self.daemon.wait_status("it is gone", lambda s: not s["second_master"])
        self.assert_healthy()

    def test_garbage(self):
        # Random standard identifiers, lengths and contents, remote frames too: many look like CANsync.
        subprocess.run(["cangen", INTERFACE, "-n", "2000", "-g", "0", "-R", "-i"], check=True, timeout=LONG)
        self.assert_healthy()


class WrongDrives(unittest.TestCase):
    def setUp(self):
        create_interface()

    def script(self, text):
        with open("/dev/shm/drives.toml", "w", encoding="utf-8") as file:
            file.write(text)
        return file.name

    def test_wrong_answers(self):
        script = self.script('[[fault]]\nkind = "wrong_answer"\nslave = 1\nprobability = 0.5\n')
        with Simulator("--faults", script), Master() as daemon:
            daemon.wait_active()
            for _ in range(10):
                result = daemon.run("read", 1, 103, "--timeout", 1)
                # Never the value of another parameter.
                self.assertIn(result.stdout.split()[-6:], ([], [b"1", b"slave1", b"103", b"-", b"1", b"0x0001"]), result)
            self.assertGreater(daemon.wait_status("a status", lambda status: True)["unexpected_frames"], 0)
            wait_for("a right answer", lambda: daemon.run("read", 1, 103).returncode == 0)

    def test_a_silent_slave_is_lost_and_comes_back(self):
        # From the 1000th SYNC frame, when the line is up, for 8 s.
        script = self.script('[[fault]]\nkind = "silent"\nslave = 2\nfrom = 1000\nto = 2000\n')
        with Simulator("--faults", script), Master() as daemon:
            daemon.wait_active()
            daemon.wait_status("slave 2 is lost", lambda s: s["slaves_responding"] == 0b1011)
            daemon.wait_active()
            self.assertTrue([event for event in daemon.events("slave_lost") if event["slave"] == 2])

    def test_killed_simulator_and_killed_daemon(self):
        with Simulator() as simulator, Master() as daemon:
            daemon.wait_active()
            simulator.kill()
            daemon.wait_status("no slave responds", lambda s: s["slaves_responding"] == 0)
            simulator.start()
            daemon.wait_active()
            daemon.restart()
            daemon.wait_active()
            self.assertIn(" 0x0003", daemon.verb("read", 3, 103))

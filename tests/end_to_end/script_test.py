"""What scripts are made of: lists of slaves, waiting for states, trying again; as processes."""

import json
import os
import signal
import tempfile
import unittest

from gateway import LONG, Gateway, Place, wait_for
from names_test import PROFILE, PROFILES
from verb_case import ALWAYS_BUSY, BUSY, BUSY_REPLIES, DATA, DEVICE_TYPE, NOT_AVAILABLE, WORD, VerbTest

TRYING = "trying again for "


class Running:
    """`cansync` running, whose remarks can be read meanwhile."""

    def __init__(self, place, *arguments, **options):
        self.remarks_file = tempfile.NamedTemporaryFile()  # closed with this object
        self.process = place.start(*arguments, stderr=self.remarks_file, **options)

    def remarks(self):
        with open(self.remarks_file.name, encoding="utf-8") as file:
            return file.read()

    def await_remark(self, text):
        wait_for(f"it says {text!r}", lambda: text in self.remarks())

    def end(self, send=None):
        """Exit code and data."""
        if send is not None:
            self.process.send_signal(send)
        out, _ = self.process.communicate(timeout=LONG)
        return self.process.returncode, out.decode()


class Script(VerbTest):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory())

    def path(self, name):
        return os.path.join(self.folder, name)

    def file(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)

    def content(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()


class Lists(Script):
    OPTIONS = ("--set", f"slave.0.profile={PROFILE}", "--set", f"slave.1.profile={PROFILE}")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.gateway.environment["CANSYNC_PROFILES"] = PROFILES

    def slaves(self, *arguments, code=0):
        return [found["slave"] for found in self.json(*arguments, code=code)]

    def test_read_and_write(self):
        # What slaves have in common is one line.
        self.assertEqual(self.text("write", "2-3,0", WORD, 5), "slave 0: 5 (0x0005, word); word-0 5\nslaves 2-3: 5 (0x0005, word)\n")
        self.assertEqual(self.slaves("read", "winder,2", DEVICE_TYPE), [1, 2])
        self.assertEqual(self.slaves("read", "all", DEVICE_TYPE), [0, 1, 2, 3])
        self.assertEqual(self.slaves("read", "3,1,1-2,slave0", DEVICE_TYPE), [0, 1, 2, 3])
        self.assertEqual(self.text("read", "3,3", DEVICE_TYPE), self.text("read", 3, DEVICE_TYPE), "one slave is one slave")

    def test_the_list_is_looked_at_as_a_whole_before_anything_is_sent(self):
        self.run_verb("write", "all", WORD, 1, "--yes")
        for wrong in ("0-4", "0,9", "0,nobody", "0,,1", "2-1", "0,32"):
            self.assertIn("SLAVE: ", self.fails("write", wrong, WORD, 2, code=2), wrong)
        self.assertIn("4-9 not configured; configured are 0-3", self.fails("control", "0-9", 0, code=2))
        # No profile, no name: that of slave 2 is missed before slave 0 is asked.
        self.assertIn("slave 2 'slave2' has no profile", self.fails("write", "0,2", "lag", 3, code=1))
        self.assertEqual({found["value"] for found in self.json("read", "all", WORD)}, {1})

    def test_every_slave_is_tried_and_the_first_failure_is_the_exit_code(self):
        self.run_verb("write", 1, BUSY_REPLIES, ALWAYS_BUSY)
        self.addCleanup(self.run_verb, "write", 1, BUSY_REPLIES, 0)
        objects = self.json("read", "0-2", BUSY, "--timeout", 0.3, code=5)
        self.assertEqual([found["result"] for found in objects], ["done", "timeout", "done"])
        result = self.run_verb("read", "2-3", NOT_AVAILABLE, code=4)
        self.assertRegex(result.stderr, rf"^cansync: slaves 2-3, parameter {NOT_AVAILABLE}: .*\n$")

    def test_commands(self):
        self.assertEqual(self.slaves("control", "0-1,3", 0), [0, 1, 3])
        self.assertEqual(self.run_verb("control", "0-1,3", 0).stderr, "cansync: control word 0x0000 to slaves 0-1,3 sent\n")
        self.assertEqual(self.slaves("release", "2,winder", code=3), [1, 2])
        self.assertEqual(self.one("broadcast", "--yes", "--slaves", "winder,2-3", "--command", 128)["slave_mask"], 0b1110)
        self.assertEqual(self.one("broadcast", "--yes", "--slaves", "all", "--command", 128)["slave_mask"], 0b1111)
        self.assertIn("every slave on the bus, configured or not",
                      self.run_verb("broadcast", "--yes", "--slaves", "0xFFFFFFFF", "--command", 128).stderr)

    def test_looking(self):
        self.assertEqual(self.slaves("slaves", "0,2-3"), [0, 2, 3])
        self.assertEqual(self.slaves("slaves", "winder", "2-3"), [1, 2, 3])
        self.assertEqual(self.slaves("watch", "0-1", "--count", 1), [0, 1])
        log = self.file("log", "".join(f"({n}.000000) can0 100#0000\n({n}.000500) can0 300#{n:02X}00\n" for n in range(8)))
        everything = self.json("trace", log)
        some = self.json("trace", log, "--slave", "1-2")
        self.assertEqual(some, [found for found in everything if found["slave"] in (1, 2)])
        self.assertEqual(len(self.json("trace", log, "--slave", "all")), len(everything))
        found = self.json("scan", log)
        self.assertEqual([one["slave"] for one in found if one["kind"] == "slave"], [0])
        configuration = self.file("can7.toml", '[bus]\nname = "can7"\ninterface = "can7"\n[[slave]]\nnumber = 1\n')
        planned = self.json("setup", configuration, "--dry-run", "--root", "/nowhere")
        self.assertEqual([one["what"] for one in planned], ["/nowhere/etc/cansync/can7.toml", "runuser -u cansync -- cansyncd --check /etc/cansync/can7.toml", "systemctl enable cansyncd@can7",
                          "systemctl start cansyncd@can7"])
        heard = self.json("learn", log)
        self.assertEqual([found["slave"] for found in heard if found["kind"] == "slave"], [0])

    def test_mappings(self):
        self.assertEqual(self.slaves("map", "0-1"), [0, 0, 1, 1])
        before = self.json("map", "1-2")
        changed = self.json("map", "1,2", 1, "value0.low", "-")
        self.assertEqual([(found["slave"], found["telegram"]) for found in changed], [(1, 1), (2, 1)])
        self.assertEqual([found["words"] for found in self.json("map", "1-2")][::2], [["value0.low", "-", "-", "-"]] * 2)
        for found in before[::2]:
            self.run_verb("map", found["slave"], 1, *found["words"])

    def test_transfers_have_a_file_for_each_slave(self):
        self.file("in", "0123456789")
        self.assertEqual(self.slaves("download", "1-2", DATA, self.path("in")), [1, 2])
        self.assertEqual(self.slaves("upload", "1-2", DATA, 10, self.path("{slave}-{name}.bin")), [1, 2])
        self.assertEqual([self.content("1-winder.bin"), self.content("2-slave2.bin")], [b"0123456789"] * 2)
        refused = self.fails("upload", "1-2", DATA, 10, self.path("one"), code=2)
        self.assertIn("allowed: a name with {slave} (the number) or {name} in it", refused)
        self.assertFalse(os.path.exists(self.path("one")))

    def test_params_and_passports(self):
        self.assertEqual(set(self.slaves("params", "0-1", "--group", "motion")), {0, 1})
        text = self.text("params", "0-1", "--group", "motion").splitlines()
        self.assertEqual([line for line in text if line.startswith("slave ")], ["slave 0:", "slave 1:"])
        self.assertIn("{slave}", self.fails("backup", "0-1", self.path("one"), code=2))
        pattern = self.path("{name}.toml")
        self.assertEqual([os.path.basename(found["file"]) for found in self.json("backup", "0-1", pattern)],
                         ["slave0.toml", "winder.toml"])
        self.assertEqual([found["different"] for found in self.json("verify", "0-1", pattern)], [0, 0])
        self.run_verb("write", "0-1", WORD, 4321)
        found = self.json("verify", "0-1", pattern, code=9)
        self.assertEqual([(one.get("number"), one["slave"]) for one in found], [(WORD, 0), (None, 0), (WORD, 1), (None, 1)])
        self.assertIn("{slave}", self.fails("verify", "0-1", self.path("winder.toml"), code=2))
        done = self.json("restore", "0-1", pattern)
        self.assertEqual([one["slave"] for one in done if one.get("action") == "written"], [0, 1])
        self.assertEqual([one["written"] for one in done if "written" in one], [1, 1])
        # A file that is missing is missed before the first slave is written to.
        self.run_verb("write", 0, WORD, 4321)
        os.unlink(self.path("winder.toml"))
        self.assertIn("winder.toml", self.fails("restore", "0-1", pattern, code=1))
        self.assertEqual(self.one("read", 0, WORD)["value"], 4321)
        self.run_verb("restore", "0", pattern)


class Wait(Script):
    def test_states_of_the_master(self):
        self.addCleanup(self.gateway.wait_active)
        self.addCleanup(self.run_verb, "wait", "run")
        reached = self.one("wait", "run")
        self.assertEqual((reached["state"], reached["reached"], reached["slave_mask"]), ("run", True, None))
        self.run_verb("wait", "error-active")
        waiting = self.gateway.start("wait", "stop", "--json")
        self.run_verb("mode", "stop")
        out, _ = waiting.communicate(timeout=LONG)
        self.assertEqual((waiting.returncode, json.loads(out)["reached"]), (0, True))
        missed = self.one("wait", "run", "--timeout", 1, code=5)
        self.assertEqual((missed["reached"], missed["result"]), (False, "timeout"))
        self.assertIn("seen last: the master is in ", missed["reason"])
        self.assertGreaterEqual(missed["seconds"], 1)
        self.run_verb("mode", "setup")
        self.run_verb("wait", "setup")
        self.run_verb("mode", "run", "--force")

    def test_states_of_slaves(self):
        self.assertEqual(self.one("wait", "released")["slave_mask"], 0b1111)
        self.assertEqual(self.one("wait", "synchronized", "winder", "2-3")["slave_mask"], 0b1110)
        self.run_verb("wait", "responding", "all")
        missed = self.one("wait", "held", "0,1", "--timeout", 1, code=5)
        self.assertIn("slave 0 is released, responds, synchronized; slave 1 is", missed["reason"])
        self.assertIn("SLAVE: 7 not configured", self.fails("wait", "released", "7", code=2))

    def test_an_actual_value(self):
        with self.gateway.start("set", "0=5000", "--strength", 3) as writer:
            self.addCleanup(writer.kill)
            reached = self.one("wait", "value", "winder", "position", ">", "0.5", "--timeout", LONG)
            self.assertEqual((reached["state"], reached["reached"]), ("value", True))
            said = self.run_verb("wait", "value", 1, 0, ">=", 500, "--timeout", LONG).stderr
            self.assertRegex(said, r"^cansync: 0 is \d+ after")
            missed = self.one("wait", "value", "winder", "position", "<", -1e6, "--timeout", 1, code=5)
            self.assertRegex(missed["reason"], r"seen last: position is \S+ mm")
            writer.send_signal(signal.SIGINT)
        for words, text in ((("winder", "position", "10"), "found 3 words"), (("winder", "position", "=>", "1"), "COMPARISON: found '=>'"),
                            (("winder", "nosuch", ">", "1"), "found 'nosuch'"), (("winder", 7, ">", 1), "is not mapped")):
            self.assertIn(text, self.fails("wait", "value", *words, "--timeout", 1, code=2))

    def test_ctrl_c(self):
        waiting = self.gateway.start("wait", "bus-off", "--json")
        wait_for("it waits", lambda: any(self.waits(waiting.pid)))
        out, _ = self.interrupt(waiting, code=7)
        self.assertEqual(json.loads(out)["result"], "cancelled")

    @staticmethod
    def waits(process):
        """Has the program caught SIGINT? Its handler is what ends the wait in order."""
        with open(f"/proc/{process}/status", encoding="ascii") as file:
            caught = next(int(line.split()[1], 16) for line in file if line.startswith("SigCgt"))
        yield bool(caught & (1 << (signal.SIGINT - 1)))


class Retry(Script):
    def stop(self):
        """No job is taken until `start`."""
        self.run_verb("mode", "stop")
        self.assertIn("state: the master is", self.fails("write", 0, WORD, 11, code=3))

    def test_several_slaves_that_are_refused_alike_are_one_line(self):
        self.stop()
        self.assertRegex(self.fails("control", "all", 0, code=3), r"^cansync: control word 0x0000 to slaves 0-3: state: .*\n$")
        self.file("in", "0123456789")
        for verb, arguments in (("download", (DATA, self.path("in"))), ("upload", (DATA, 10, self.path("{slave}.bin")))):
            self.assertRegex(self.fails(verb, "0-3", *arguments, code=3), rf"^cansync: slaves 0-3, {verb} at 0x.*: state: .*\n$")
        self.start()

    def start(self):
        self.run_verb("mode", "setup")

    def tearDown(self):
        self.run_verb("mode", "run", "--force", "--retry", LONG)
        self.gateway.wait_active()
        super().tearDown()

    def test_a_refusal_that_passes(self):
        self.stop()
        running = Running(self.gateway, "write", "0,2", WORD, 12, "--retry", LONG, "--json")
        running.await_remark(TRYING)
        self.start()
        code, out = running.end()
        self.assertEqual(code, 0, running.remarks())
        self.assertEqual([json.loads(line)["result"] for line in out.splitlines()], ["done", "done"])
        self.assertRegex(running.remarks(), r"^cansync: trying again for [0-9.]+ s: state: .*\ncansync: tried again \d+ times?\n$")
        self.assertEqual({found["value"] for found in self.json("read", "0,2", WORD)}, {12})

    def test_it_gives_up_when_the_time_is_over(self):
        self.stop()
        said = self.fails("control", 0, 0, "--retry", 0.5, code=3)
        self.assertRegex(said, r"^cansync: trying again for 0.5 s: (state: .*)\ncansync: control word 0x0000 to slave 0: \1\n"
                               r"cansync: tried again \d times\n$")
        self.start()

    def test_what_never_passes_is_said_at_once(self):
        self.assertNotIn(TRYING, self.fails("read", 9, 1, "--retry", LONG, code=3))
        self.assertNotIn(TRYING, self.fails("read", 0, NOT_AVAILABLE, "--retry", LONG, code=4))
        self.assertNotIn(TRYING, self.fails("read", "nobody", 1, "--retry", LONG, code=2))

    def test_ctrl_c_ends_it(self):
        self.stop()
        running = Running(self.gateway, "write", 0, WORD, 13, "--retry", 3000, "--json")
        running.await_remark(TRYING)
        code, out = running.end(signal.SIGINT)
        self.assertEqual((code, json.loads(out)["result"]), (7, "cancelled"))
        self.start()


class WriteOnce(Script):
    """What may have reached the slave is repeated only when repeating it changes nothing."""

    def setUp(self):
        super().setUp()
        self.run_verb("write", 3, BUSY_REPLIES, ALWAYS_BUSY)
        self.addCleanup(self.run_verb, "write", 3, BUSY_REPLIES, 0)

    def requests(self, mark):
        """How many requests for the busy parameter the daemon had since then."""
        events = self.json("events")
        return [event for event in events if event["number"] > mark and f"{BUSY}" in event["text"]]

    def test_a_write_without_an_answer_is_never_repeated(self):
        mark = self.json("events")[-1]["number"]
        result = self.run_verb("write", 3, BUSY, 1, "--format", "word", "--timeout", 0.3, "--retry", LONG, "--json", code=5)
        self.assertIn(json.loads(result.stdout)["result"], ("timeout", "no_answer"))
        self.assertNotIn(TRYING, result.stderr)
        self.assertEqual(len(self.requests(mark)), 1, self.requests(mark))

    def test_a_read_without_an_answer_is(self):
        running = Running(self.gateway, "read", 3, BUSY, "--timeout", 0.3, "--retry", LONG, "--json")
        running.await_remark(TRYING)
        self.run_verb("write", 3, BUSY_REPLIES, 0)
        code, out = running.end()
        self.assertEqual(code, 0, running.remarks())
        self.assertEqual([json.loads(line)["result"] for line in out.splitlines()], ["done"], "only the last attempt")


class WithoutDaemon(unittest.TestCase):
    def test_retry_waits_for_the_daemon(self):
        place = Place()
        result = place.run("status", "--timeout", 1, "--retry", 0.2)
        self.assertEqual((result.returncode, result.stdout), (6, b""))
        self.assertIn(f"cansync: {TRYING}0.2 s: no daemon found", result.stderr)
        gateway = Gateway()
        running = Running(gateway, "read", 0, DEVICE_TYPE, "--timeout", 1, "--retry", LONG)
        running.await_remark(TRYING)
        with gateway:
            code, out = running.end()
        self.assertEqual((code, out.split()[-2:]), (0, ["4400", "0x1130"]), running.remarks())

    def test_waiting_for_the_daemon_to_come_and_to_go(self):
        gateway = Gateway()
        missed = gateway.run("wait", "run", "--timeout", 1, "--json")
        self.assertEqual((missed.returncode, json.loads(missed.stdout)["reason"][-9:]), (5, "no daemon"))
        self.assertEqual(gateway.run("wait", "gone").returncode, 0)
        coming = gateway.start("wait", "present")
        released = gateway.start("wait", "released", "all")
        with gateway:
            for process in (coming, released):
                _, err = process.communicate(timeout=LONG)
                self.assertEqual(process.returncode, 0, err)
            self.assertEqual(gateway.run("wait", "gone", "--timeout", 1).returncode, 5)
            going = gateway.start("wait", "gone", "--json")
            gateway.stop()
            out, _ = going.communicate(timeout=LONG)
            self.assertEqual((going.returncode, json.loads(out)["reached"]), (0, True))


if __name__ == "__main__":
    unittest.main(verbosity=2)

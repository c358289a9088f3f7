"""Slaves that come and go, as whole processes: a fault script unplugs a drive now and then and plugs it in again."""

import json
import os
import unittest

from gateway import LONG, Gateway, wait_for

BUSY, BUSY_REPLIES, WORD, OTHER_WORD = 410, 411, 1000, 1001
ALWAYS_BUSY = 0xFFFF
LOST, OTHER = 1, 2  # the drive that is unplugged, and one that is not
PERIOD, AWAY = 20000, 2000  # intervals of 1 ms: unplugged for the last ones of each period
TURN = 12000  # that a test has from the begin of a fresh turn: its commands may be slow to come
ENABLING, STOPPING = 0x000F, 0x0000


class Slaves(unittest.TestCase):
    RETURN = ""

    @classmethod
    def setUpClass(cls):
        cls.gateway = Gateway(slaves=3, bit_rate=1000000)  # when it is unplugged stands in intervals
        faults = os.path.join(cls.gateway.folder.name, "faults.toml")
        with open(faults, "w", encoding="utf-8") as file:
            for turn in range(1, 60):
                file.write(
                    f'[[fault]]\nkind = "silent"\nslave = {LOST}\nfrom = {turn * PERIOD - AWAY}\nto = {turn * PERIOD}\n'
                )
        with open(cls.gateway.config, encoding="utf-8") as file:
            text = file.read()
        text = text.replace("lock_time_ms = 50\n", f'lock_time_ms = 50\nfault_script = "{faults}"\n')
        text = text.replace('name = "winder"\n', 'name = "winder"\n' + cls.RETURN)
        with open(cls.gateway.config, "w", encoding="utf-8") as file:
            file.write(text)
        cls.enterClassContext(cls.gateway)

    def slave(self, number=LOST):
        return self.gateway.look("slaves", number, daemon=self.gateway.process.pid)

    def wait_state(self, *states):
        def look():
            slave = self.slave()
            return slave if slave and slave["state"] in states else None

        return wait_for(f"slave {LOST} is {' or '.join(states)}", look, pause=0.1)

    def wait_fresh_turn(self):
        """Back when the drive has been there for a moment and stays for a while."""

        def look():
            at = self.gateway.status()["interval"] % PERIOD
            return 500 < at < PERIOD - AWAY - TURN

        wait_for("the drive is plugged in", look)

    def events(self):
        """The codes of the drive's events, newest last, with their texts."""
        return [(e["code"], e["text"]) for e in self.gateway.json("events") if e["slave"] == LOST]

    def codes_since(self, mark):
        """What happened to the drive; not who asked for what."""
        return [e["code"] for e in self.gateway.json("events")
                if e["slave"] == LOST and e["number"] > mark and e["code"] != "request_done"]

    def last_event(self):
        return self.gateway.json("events")[-1]["number"]


class Release(Slaves):
    def test_jobs_of_an_unplugged_drive_end_and_it_is_used_again_when_it_is_back(self):
        self.wait_fresh_turn()
        self.wait_state("released")
        mark = self.last_event()
        before = self.slave()
        self.assertEqual(self.gateway.run("write", LOST, BUSY_REPLIES, ALWAYS_BUSY).returncode, 0)
        # The drive answers busy until it is unplugged; the status, told once a second, might not show the job at all.
        job = self.gateway.start("read", LOST, BUSY, "--timeout", 60, "--json")
        out, err = job.communicate(timeout=LONG)
        self.assertEqual(job.returncode, 5, err)
        reply = json.loads(out)
        self.assertEqual(reply["result"], "slave_lost")
        self.assertIn("slave 1 'winder' stopped answering", reply["reason"])
        # Meanwhile the others are served, and what is asked of it is refused.
        self.assertEqual(self.gateway.run("read", OTHER, WORD).returncode, 0)
        back = wait_for(
            "it has come back and is released",
            lambda: (s := self.slave()) and s["state"] == "released" and s["times_returned"] > before["times_returned"] and s,
        )
        self.assertEqual(back["jobs_ended"], before["jobs_ended"] + 1)
        self.assertGreater(back["times_lost"], before["times_lost"])
        codes = self.codes_since(mark)
        first = codes.index("slave_lost")
        steps = [c for c in codes[first:] if c != "slave_not_synchronized"]
        self.assertEqual(steps[:4], ["slave_lost", "slave_returned", "slave_synchronized", "slave_released"])
        # The drive is asked for nothing that it was busy with.
        self.wait_fresh_turn()
        self.assertEqual(self.gateway.run("write", LOST, BUSY_REPLIES, 0).returncode, 0)


class Check(Slaves):
    RETURN = f'on_return = "check"\nreturn_parameters = ["{OTHER_WORD}=0", "{WORD}=1234"]\n'

    def test_a_wrong_parameter_holds_it_out_until_it_is_right(self):
        self.wait_state("held")
        code, text = next(event for event in reversed(self.events()) if event[0] == "slave_check_failed")
        self.assertEqual(code, "slave_check_failed")
        self.assertIn(f"parameter {WORD}, expected 1234 (0x4D2), found 0 (0x0)", text)
        self.assertIn(f"cansync release {LOST}", text)
        self.wait_fresh_turn()
        self.wait_state("held")
        self.assertEqual(self.gateway.status()["slaves_released"], 0b101)
        refused = self.gateway.run("control", LOST, ENABLING)
        self.assertEqual(refused.returncode, 3, refused.stderr)
        self.assertIn("slave 1 'winder' is held out", refused.stderr)
        self.assertEqual(self.gateway.run("control", LOST, STOPPING).returncode, 0)
        self.assertEqual(self.gateway.run("control", OTHER, ENABLING).returncode, 0)
        self.assertEqual(self.gateway.run("release", OTHER).returncode, 3)
        # Set right and released: it passes its list.
        mark = self.last_event()
        self.assertEqual(self.gateway.run("write", LOST, WORD, 1234).returncode, 0)
        self.gateway.json("release", LOST)
        self.wait_state("released")
        self.assertEqual(self.codes_since(mark)[:2], ["slave_checked", "slave_released"])
        self.assertEqual(self.gateway.run("control", LOST, ENABLING).returncode, 0)


class Write(Slaves):
    RETURN = f'on_return = "write"\nreturn_parameters = ["{WORD}=1234", "1020=0x12345678"]\n'

    def test_the_parameters_are_written_again(self):
        wait_for("it has come back", lambda: (s := self.slave()) and s["times_returned"] > 0)
        self.wait_fresh_turn()
        self.wait_state("released")
        self.assertEqual(self.gateway.json("read", LOST, WORD)[0]["value"], 1234)
        self.assertEqual(self.gateway.json("read", LOST, 1020)[0]["value"], 0x12345678)
        self.assertIn("slave_checked", [code for code, _ in self.events()])


class LineThatWaits(Gateway):
    """Its drives never run all of them."""

    def wait_active(self):
        return self.wait_status("the daemon answers", lambda status: status["slaves_wrong"] != 0)


class Expect(unittest.TestCase):
    def test_a_drive_that_is_not_the_one_expected_is_held_until_it_is_released_by_force(self):
        gateway = LineThatWaits(slaves=3)
        with open(gateway.config, encoding="utf-8") as file:
            text = file.read()
        with open(gateway.config, "w", encoding="utf-8") as file:
            file.write(text.replace('name = "winder"\n', 'name = "winder"\nexpect = ["100=4400", "102=77"]\n'))
        with gateway:
            def held():
                slave = json.loads(gateway.run("slaves", 1, "--json").stdout)
                return slave if slave["state"] == "held" else None

            slave = wait_for("the drive is held", held)
            reason = "not the drive expected: parameter 102, expected 77 (0x4D), found 1001 (0x3E9)"
            self.assertEqual(slave["held_reason"], reason)
            self.assertIn(f"slave 1 'winder' is held out: {reason}", gateway.run("slaves").stderr)
            self.assertEqual(gateway.status()["slaves_wrong"], 0b010)
            refused = gateway.run("mode", "run")
            self.assertEqual(refused.returncode, 3, refused.stderr)
            self.assertIn("slave 1 'winder'", refused.stderr)
            self.assertIn("is held out: not the drive expected", gateway.run("doctor").stdout.decode())
            self.assertEqual(gateway.run("release", 1, "--force").returncode, 0)
            wait_for("run is entered", lambda: gateway.status()["state"] == "run")


if __name__ == "__main__":
    unittest.main()

"""Every cause that a program can bring about, by name, through each face of the library: tests/client/refusals.json."""

import json
import os
import subprocess
import unittest

from gateway import LONG, Gateway, Place, wait_for

HERE = os.path.dirname(os.path.abspath(__file__))
PROFILE = os.path.join(HERE, "..", "..", "config", "profiles", "simulated-drive.toml")
SETTING_UP = 0x0043

with open(os.path.join(HERE, "..", "client", "refusals.json"), encoding="utf-8") as table:
    TABLE = json.load(table)
ROWS = TABLE["provoked"]


class SetUpOnly(Gateway):
    """A line two slaves of which are not there: it stays in set-up."""

    def wait_active(self):
        return self.wait_status("two slaves are synchronized in set-up",
                                lambda s: s["option_status"] == SETTING_UP and s["slaves_synchronized"] == 0b11)


class Refusals(unittest.TestCase):
    def ask(self, program, gateway, call):
        """What the program printed: code, cause, and whether to ask again, of each call between two '--'."""
        arguments = [os.environ[program], str(gateway.domain), gateway.bus, *map(str, call)]
        done = subprocess.run(arguments, capture_output=True, text=True, timeout=LONG)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout.split()

    def faces(self, gateway, calls):
        """By face, what its program printed of each of these calls, three words: code, cause, and whether to ask again."""
        programs = {"c++": "PROVOKE", "c": "PROVOKE_C", "python": "PROVOKE_PYTHON"}  # no Python under a sanitizer
        told = {}
        for face, program in programs.items():
            if program in os.environ and (through := [call for call in calls if face in call["through"]]):
                words = self.ask(program, gateway, [word for call in through for word in ("--", *call["call"])][1:])
                self.assertEqual(len(words), 3 * len(through), face)
                told[face] = list(zip(through, zip(*[iter(words)] * 3)))
        return told

    def provoke(self, situation, gateway):
        rows = [row for row in ROWS if row["situation"] == situation]
        self.assertTrue(rows)
        retries = {}
        for face, told in self.faces(gateway, rows).items():
            for row, (code, cause, retry) in told:
                self.assertEqual((code, cause), ("refused", row["cause"]), f"{face}: {row}")
                self.assertEqual(retry, retries.setdefault(id(row), retry), f"{face}: {row}")
        for row in rows:
            if "json" in row["through"]:
                target = os.path.join(gateway.folder.name, "uploaded")
                found = gateway.json(*(target if word == "{file}" else word for word in row["cli"]), code=3)[-1]
                self.assertEqual((found["result"], found["cause"]), ("refused", row["cause"]), row)
                self.assertNotEqual(found["reason"], "")

    def test_active_and_stopped(self):
        with Gateway(options=("--set", f"slave.0.profile={PROFILE}")) as gateway:
            self.provoke("active", gateway)
            done = gateway.json("read", 0, 100)[0]
            self.assertEqual((done["result"], done["cause"]), ("done", None))
            self.assertEqual(gateway.run("mode", "stop").returncode, 0)
            self.provoke("stopped", gateway)
            # The journal's word for it is in the event too.
            refused = [e["result"] for e in gateway.json("events") if e["code"] == "request_refused"]
            self.assertTrue(any(result.startswith("refused: wrong_state: ") for result in refused), refused)

    def test_read_only(self):
        with Gateway(options=("--set", "access.read_only=true")) as gateway:
            self.provoke("read_only", gateway)

    def test_missing(self):
        with SetUpOnly(options=("--set", "sim.drives=[0,1]")) as gateway:
            wait_for("the one that is not there is known to be lost",
                     lambda: gateway.run("read", 3, 100, "--json").returncode == 3)
            self.provoke("missing", gateway)

    def test_held(self):
        gateway = Gateway(slaves=3, bit_rate=1000000)  # when it is silent stands in intervals
        faults = os.path.join(gateway.folder.name, "faults.toml")
        with open(faults, "w", encoding="utf-8") as file:
            file.write('[[fault]]\nkind = "silent"\nslave = 1\nfrom = 1500\nto = 3500\n')
        with open(gateway.config, encoding="utf-8") as file:
            text = file.read()
        text = text.replace("lock_time_ms = 50\n", f'lock_time_ms = 50\nfault_script = "{faults}"\n')
        text = text.replace('name = "winder"\n', 'name = "winder"\non_return = "check"\nreturn_parameters = ["1000=1234"]\n')
        with open(gateway.config, "w", encoding="utf-8") as file:
            file.write(text)
        with gateway:
            wait_for("slave 1 is held out", lambda: gateway.json("slaves", 1)[0]["state"] == "held")
            self.provoke("held", gateway)

    def test_every_cause_through_every_face(self):
        causes = {row["cause"] for rows in (ROWS, TABLE["without_library"], TABLE["decided"]) for row in rows}
        place = Place()
        command = [os.environ["REFUSING_DAEMON"], str(place.domain), place.bus]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as daemon:
            self.assertEqual(daemon.stdout.readline(), "serving\n")
            # As refusing_daemon has it: the number of a cause on top of 3400.
            numbers = range(3401, 3401 + len(causes))
            done = place.run("read", "0", *numbers, "--json")
            found = [json.loads(line) for line in done.stdout.splitlines()]
            self.assertEqual({one["result"] for one in found}, {"refused"}, done)
            self.assertEqual(sorted(one["cause"] for one in found), sorted(causes))
            calls = [{"call": ("read", 0, number), "through": ("c++", "c", "python")} for number in numbers]
            for face, told in self.faces(place, calls).items():
                self.assertEqual([words[:2] for _, words in told], [("refused", one["cause"]) for one in found], face)
            daemon.stdin.close()
            self.assertEqual(daemon.wait(LONG), 0)

    def ask_raw(self, gateway, row):
        """The causes told; asked again where the machine stood still so long meanwhile that all of it was stale."""
        def heard():
            causes = self.ask("RAW_ASKER", gateway, [row["way"]])
            return None if causes == ["stale"] != [row["cause"]] else causes

        return wait_for("what was asked is heard in time", heard)

    def test_what_the_library_never_asks(self):
        for row in TABLE["without_library"]:
            with self.subTest(row["way"]), Gateway() as gateway:
                self.assertEqual(self.ask_raw(gateway, row), [row["cause"]])


if __name__ == "__main__":
    unittest.main()

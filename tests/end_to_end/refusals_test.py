"""Every cause that a program can bring about, by name, through each face of the library: tests/client/refusals.json."""

import json
import os
import subprocess
import unittest

from gateway import LONG, Gateway, wait_for

HERE = os.path.dirname(os.path.abspath(__file__))
PROFILE = os.path.join(HERE, "..", "..", "config", "profiles", "simulated-drive.toml")
SETTING_UP = 0x0043

with open(os.path.join(HERE, "..", "client", "refusals.json"), encoding="utf-8") as table:
    ROWS = json.load(table)["provoked"]


class SetUpOnly(Gateway):
    """A line two slaves of which are not there: it stays in set-up."""

    def wait_active(self):
        return self.wait_status("two slaves are synchronized in set-up",
                                lambda s: s["option_status"] == SETTING_UP and s["slaves_synchronized"] == 0b11)


class Refusals(unittest.TestCase):
    def ask(self, program, gateway, call):
        """What the program printed: code, cause, and whether to ask again."""
        arguments = [os.environ[program], str(gateway.domain), gateway.bus, *map(str, call)]
        done = subprocess.run(arguments, capture_output=True, text=True, timeout=LONG)
        self.assertEqual(done.returncode, 0, done.stdout)
        return done.stdout.split()

    def provoke(self, situation, gateway):
        rows = [row for row in ROWS if row["situation"] == situation]
        self.assertTrue(rows)
        for row in rows:
            said = {}
            if "c++" in row["through"]:
                said["c++"] = self.ask("PROVOKE", gateway, row["call"])
            if "c" in row["through"]:
                said["c"] = self.ask("PROVOKE_C", gateway, row["call"])
            if "python" in row["through"] and "PROVOKE_PYTHON" in os.environ:  # not under a sanitizer
                said["python"] = self.ask("PROVOKE_PYTHON", gateway, row["call"])
            for face, (code, cause, retry) in said.items():
                self.assertEqual((code, cause), ("refused", row["cause"]), f"{face}: {row}")
                self.assertEqual(retry, next(iter(said.values()))[2], f"{face}: {row}")
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
        gateway = Gateway(slaves=3)
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


if __name__ == "__main__":
    unittest.main()

"""Parameters by the names of a drive profile, as processes."""

import json
import os
import re
import subprocess
import tempfile
import unittest

from gateway import CANSYNCD, LONG, OWN_TIME, wait_for
from verb_case import DEVICE_TYPE, VerbTest

PROFILES = os.path.join(os.path.dirname(__file__), "..", "..", "config", "profiles")
PROFILE = os.path.abspath(os.path.join(PROFILES, "simulated-drive.toml"))
SPEED_LIMIT, TORQUE_OFFSET = 401, 403


class Named(VerbTest):
    """Slaves 0 and 1 have the profile of the simulated drive, the others none."""

    OPTIONS = ("--set", f"slave.0.profile={PROFILE}", "--set", f"slave.1.profile={PROFILE}")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.gateway.environment["CANSYNC_PROFILES"] = PROFILES

    def in_folder(self, text, name="simulated-drive"):
        """A folder with one profile."""
        folder = self.enterContext(tempfile.TemporaryDirectory())
        with open(os.path.join(folder, f"{name}.toml"), "w", encoding="utf-8") as file:
            file.write(text)
        return folder

    @staticmethod
    def profile_text():
        with open(PROFILE, encoding="utf-8") as file:
            return file.read()


class ByName(Named):
    def test_a_name_shows_the_value_in_its_unit(self):
        self.run_verb("write", "winder", "speed-limit", 150000)
        shown = ["1", "winder", "401", "speed-limit", "150000", "inc/s", "0x000249F0"]
        self.assertEqual(self.text("read", "winder", "speed-limit").splitlines()[1].split(), shown)
        self.assertEqual(self.text("write", 1, "torque-offset", "-12.34"), "-12.3 % (torque-offset, parameter 403, raw 65413)\n")
        self.assertEqual(self.text("read", 1, "torque-offset", "--raw").splitlines()[1].split()[3:], ["torque-offset", "-12.3", "%", "0xFF85"])
        self.run_verb("write", 1, "torque-offset", 50, "--raw")
        self.assertEqual(self.one("read", 1, "torque-offset")["scaled"], 5.0)

    def test_several_parameters_of_several_slaves_again_and_again(self):
        lines = self.text("read", "0,1", "device-type", TORQUE_OFFSET).splitlines()
        self.assertEqual([line.split()[0:4:3] for line in lines[1:]], [
            [slave, name] for slave in "01" for name in ("device-type", "torque-offset")])
        rounds = self.text("read", "0,1", "device-type", "--every", 0.1, "--count", 2).splitlines()
        self.assertEqual(rounds[0].split()[:2], ["TIME", "SLAVE"])
        self.assertEqual([line.split()[1] for line in rounds[1:]], ["0", "1", "0", "1"])
        found = self.json("read", "0,1", DEVICE_TYPE, "torque-offset", "--every", 0.1, "--count", 2)
        self.assertEqual([(o["slave"], o["number"]) for o in found],
                         2 * [(slave, number) for slave in (0, 1) for number in (DEVICE_TYPE, TORQUE_OFFSET)])
        # An answer may take some intervals less in the second round.
        self.assertGreaterEqual(found[4]["time_ns"] - found[0]["time_ns"], 95_000_000 if OWN_TIME else 50_000_000)

    def test_a_number_works_as_before_and_shows_the_name(self):
        self.assertEqual(self.text("read", 0, DEVICE_TYPE).splitlines()[1].split()[3:], ["device-type", "4400", "0x1130"])
        self.run_verb("write", 0, TORQUE_OFFSET, "-10")
        read = self.one("read", 0, TORQUE_OFFSET)
        self.assertEqual((read["value"], read["signed"], read["scaled"]), (65526, -10, -1.0))
        self.assertEqual((read["name"], read["unit"]), ("torque-offset", "%"))
        self.assertEqual(self.text("read", 2, DEVICE_TYPE).splitlines()[1].split()[3:], ["-", "4400", "0x1130"])

    def test_status_words_and_faults_are_put_into_words(self):
        self.run_verb("control", 0, 0x87)
        self.assertRegex(self.text("read", 0, "status-word"), r"0x[0-9A-F]{4} +ready, powered")
        # User command 128 provokes the fault that is its data word.
        self.run_verb("broadcast", "--slaves", 0, "--command", 128, "--word", 26)

        def faulty():
            return "reference values missing" in self.text("read", 0, "fault-code")

        wait_for("the drive faults", faulty)
        self.assertRegex(self.text("params", 0, "--group", "state"), r"fault-code +26 .*: reference values missing\n")
        wait_for("slaves tells it", lambda: re.search(r"0x[0-9A-F]{4} fault ", self.text("slaves", 0)))
        self.assertRegex(self.one("slaves", 0)["fault"], "^fault")
        self.assertRegex(self.one("watch", 0, "--count", 1)["fault"], "^fault")
        told = [json.loads(line) for line in self.gateway.run("doctor", "--json").stdout.splitlines()]
        self.assertRegex([found["found"] for found in told if found["topic"] == "drive fault"][0], "^slave 0 'slave0': fault")
        self.assertEqual(self.text("slaves", "--color", "always").count("\x1b[31m"), 1)
        shown, _ = self.gateway.run_on_terminal("slaves")
        self.assertEqual(shown.count("\x1b[31m"), 1)
        self.gateway.environment["NO_COLOR"] = "1"
        self.addCleanup(self.gateway.environment.pop, "NO_COLOR")
        shown, _ = self.gateway.run_on_terminal("slaves")
        self.assertNotIn("\x1b[31m", shown)
        given = self.gateway.run("set", "0=0", "--seconds", "0.2")
        self.assertIn("in fault: slave0: a drive in fault follows no reference values", given.stderr)
        self.run_verb("control", 0, 0x87)

    def test_every_parameter_in_a_table(self):
        lines = self.text("params", "winder").splitlines()
        self.assertEqual(lines[0].split(), "NUMBER NAME VALUE UNIT LIMITS ACCESS GROUP TEXT".split())
        rows = {line.split()[1]: line.split() for line in lines[1:]}
        self.assertEqual(len(rows), 67)
        self.assertEqual(rows["lag"][:6], ["400", "lag", "5.0", "ms", "0.0..1000.0", "read-write"])
        self.assertEqual(rows["serial-number"][2], "1001")
        self.assertEqual(rows["not-available"][2:4], ["-", "none"])
        self.assertIn("read-only, volatile", next(line for line in lines if " temperature " in line))

    def test_a_group_as_objects(self):
        objects = self.json("params", 1, "--group", "motion")
        self.assertEqual([o["name"] for o in objects], ["lag", "speed-limit", "deceleration", "torque-offset"])
        self.assertEqual([objects[3][k] for k in ("minimum", "maximum", "unit")], [-100.0, 100.0, "%"])
        self.assertEqual({o["result"] for o in objects}, {"done"})
        trial = {o["name"]: o for o in self.json("params", 1, "--group", "trial")}
        self.assertEqual((trial["not-available"]["result"], trial["not-available"]["value"]), ("not_asked", None))
        self.assertIn("'identity', 'state', 'actual'", self.fails("params", 1, "--group", "x", code=2))

    def test_a_width_that_is_not_the_profiles_is_said_and_not_scaled(self):
        self.run_verb("write", 1, 430, 100000)
        wrong = self.profile_text().replace('name = "free-doubleword"\nformat = "doubleword"', 'name = "free"\nformat = "word"\nfactor = 0.1')
        arguments = ("params", 1, "--group", "trial", "--profile", os.path.join(self.in_folder(wrong), "simulated-drive.toml"))
        row = next(line for line in self.text(*arguments).splitlines() if " free " in line)
        self.assertEqual(row.split()[2], "100000")
        self.assertIn("the slave has it as doubleword, the profile as word", row)
        found = next(o for o in self.json(*arguments) if o["number"] == 430)
        self.assertEqual((found["value"], found["signed"], found["scaled"], found["format"]), (100000, 100000, None, "doubleword"))

    def test_events_and_slaves_have_the_names(self):
        self.run_verb("write", "winder", "speed-limit", 777)

        def told():
            return [e for e in self.json("events") if "speed-limit (parameter 401) = 777" in e["text"]]

        self.assertEqual(wait_for("the event", told)[0]["code"], "request_done")
        self.assertEqual([s["profile"] for s in self.json("slaves")], ["simulated-drive"] * 2 + [""] * 2)


class Refusals(Named):
    def test_what_the_profile_does_not_allow_is_not_sent(self):
        last = self.json("events")[-1]["number"]
        for arguments, text in [
            (("speed-limit", 0), "found 0 inc/s (raw 0); allowed: 1..2147483647 inc/s"),
            (("torque-offset", "100.1"), "found 100.1 % (raw 1001); allowed: -100.0..100.0 %"),
            (("lag", "x"), "found 'x'; allowed: a number in ms"),
            ((SPEED_LIMIT, 0), "speed-limit (parameter 401): found 0 inc/s"),
            (("device-type", 1), "device-type (parameter 100): read-only"),
            (("lag", 1, "--format", "doubleword"), "allowed: word, auto"),
            (("word-0", 65536), "allowed: 0..65535"),
        ]:
            self.assertIn(text, self.fails("write", "winder", *arguments, code=2))
        self.assertIn("access none", self.fails("read", "winder", "not-available", code=2))
        # A refusal of the daemon would be an event. That an earlier one is over is told 10 s later.
        told = [e for e in self.json("events") if e["number"] > last and e["code"].startswith("request")
                and e["code"] != "requests_rejected_before"]
        self.assertEqual(told, [])

    def test_the_daemon_refuses_too(self):
        folder = self.in_folder(self.profile_text().replace("minimum = 1\n", "minimum = 0\n"))
        lax = ("--profile", os.path.join(folder, "simulated-drive.toml"))
        refused = self.one("write", "winder", "speed-limit", 0, *lax, code=3)
        self.assertEqual(refused["cause"], "profile")
        self.assertIn("allowed: 1..2147483647 inc/s", refused["reason"])
        self.assertEqual(self.one("read", "winder", "speed-limit")["result"], "done")

    def test_a_name_that_is_not_known(self):
        self.assertIn("no parameter 'sped'", self.fails("read", "winder", "sped", code=2))
        self.assertIn("set profile = ", self.fails("read", 2, "speed-limit", code=1))
        self.assertIn("has no profile", self.fails("params", 3, code=1))

    def test_a_slave_without_a_profile_leaves_the_others_their_list(self):
        result = self.gateway.run("params", "1,2", "--json")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("slave 2: slave 2 'slave2' has no profile", result.stderr)
        listed = [json.loads(line) for line in result.stdout.splitlines()]
        self.assertEqual({found["slave"] for found in listed if found["number"] == DEVICE_TYPE}, {1})

    def test_a_profile_that_is_wrong_in_part(self):
        wrong = self.in_folder(self.profile_text() + "colour = 3\n")
        lines = self.profile_text().count("\n") + 1
        path = os.path.join(wrong, "simulated-drive.toml")
        self.assertIn(f"simulated-drive.toml:{lines}:1: parameter.colour", self.run_verb("params", 1, "--profile", path, code=11).stderr)

    def test_a_wrong_profile_is_named_with_its_place_by_check(self):
        folder = self.in_folder(self.profile_text().replace("number = 401\n", "number = 400\n"))
        line = os.path.join(folder, "line.toml")
        with open(line, "w", encoding="utf-8") as file:
            file.write('[[slave]]\nnumber = 0\nprofile = "./simulated-drive.toml"\n')
        place = self.profile_text()[: self.profile_text().index("number = 401")].count("\n") + 1
        ended = subprocess.run([CANSYNCD, "--check", line], capture_output=True, timeout=LONG, check=False)
        self.assertEqual(ended.returncode, 78)
        self.assertIn(f"simulated-drive.toml:{place}:10: parameter.number: found 400 again", ended.stderr.decode())


class PassedOn(VerbTest):
    """Slave 0 has a profile that is too long to be passed on, slave 1 that of the simulated drive."""

    @classmethod
    def setUpClass(cls):
        folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        cls.LONG_ONE = os.path.join(folder, "long-one.toml")
        with open(PROFILE, encoding="utf-8") as file:
            text = file.read().replace('name = "simulated-drive"', 'name = "long-one"')
        with open(cls.LONG_ONE, "w", encoding="utf-8") as file:
            file.write(text + "#" * 65536 + "\n")
        cls.OPTIONS = ("--set", f"slave.0.profile={cls.LONG_ONE}", "--set", f"slave.1.profile={PROFILE}")
        super().setUpClass()

    def test_a_profile_comes_from_the_daemon(self):
        self.assertRegex(self.text("read", "winder", "speed-limit"), r"speed-limit +\S+ +inc/s")
        self.assertIn("speed-limit", self.text("params", "winder"))
        # One that is here, but another, is not used.
        folder = self.enterContext(tempfile.TemporaryDirectory())
        with open(PROFILE, encoding="utf-8") as ours, open(
                os.path.join(folder, "simulated-drive.toml"), "w", encoding="utf-8") as other:
            other.write(ours.read().replace('name = "speed-limit"', 'name = "limit-of-speed"'))
        self.assertEqual(self.one("read", "winder", "speed-limit", "--profiles", folder)["name"], "speed-limit")

    def test_one_that_is_too_long_is_named(self):
        said = self.fails("read", 0, "speed-limit", code=1)
        self.assertIn("copy its file from the daemon's computer", said)
        self.assertIn(f"passes on no file of more than 65536 bytes, this one has {os.path.getsize(self.LONG_ONE)}", said)
        self.assertEqual(self.text("read", 0, DEVICE_TYPE).splitlines()[1].split()[3:], ["-", "4400", "0x1130"])


if __name__ == "__main__":
    unittest.main()

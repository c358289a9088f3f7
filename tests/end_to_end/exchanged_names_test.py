"""Names that a reload gives to other drives while a verb runs: no command reaches another drive than the one that was named."""

import json
import signal
import unittest

from gateway import Gateway, wait_for
from restart_test import Follower

WORD = "1000"
EXCHANGED = "slave 1 was 'winder' and is 'unwinder'"


class ExchangedNames(unittest.TestCase):
    def setUp(self):
        self.gateway = self.enterContext(Gateway())

    def follow(self, *arguments):
        follower = Follower(self.gateway, *arguments)
        self.addCleanup(follower.end)
        return follower

    def run_verb(self, *arguments, code=0):
        result = self.gateway.run(*arguments)
        self.assertEqual(result.returncode, code, f"{arguments}: {result.stderr}")
        return result

    def exchange(self):
        """Slave 2 is the winder, and slave 1 the unwinder."""
        with open(self.gateway.config, encoding="utf-8") as file:
            text = file.read()
        text = text.replace('"winder"', '"unwinder"').replace("number = 2\n", 'number = 2\nname = "winder"\n')
        with open(self.gateway.config, "w", encoding="utf-8") as file:
            file.write(text)
        self.gateway.process.send_signal(signal.SIGHUP)
        wait_for("the daemon tells the new names",
                 lambda: [one["name"] for one in self.gateway.json("slaves", "1-2")] == ["unwinder", "winder"])

    def value(self, slave):
        return self.gateway.json("read", slave, WORD)[0]["value"]

    def test_what_is_tried_again_goes_to_nobody_else(self):
        self.run_verb("write", "1-2", WORD, "5")
        self.run_verb("mode", "stop")
        named = [self.follow("--retry", "3600", "write", slaves, WORD, "7") for slaves in ("winder", "winder,0")]
        numbered = self.follow("--retry", "3600", "control", "3", "0")
        for one in (*named, numbered):
            wait_for("it tries again", lambda one=one: "trying again" in one.said())
        self.exchange()
        for one in named:
            wait_for("it ends", lambda one=one: one.process.poll() is not None)
            self.assertEqual(one.process.returncode, 3, one.said())
            self.assertIn(f"{EXCHANGED} since this command was looked up: not sent", one.said())
        self.run_verb("mode", "setup")
        self.run_verb("mode", "run", "--force")
        wait_for("a number means what it meant", lambda: numbered.process.poll() is not None)
        self.assertEqual(numbered.process.returncode, 0, numbered.said())
        self.gateway.wait_active()
        self.assertEqual([self.value(1), self.value(2)], [5, 5])

    def test_what_goes_on_for_long_follows_the_name(self):
        reading = self.follow("read", "winder", WORD, "--every", "0.2", "--json")
        watching = self.follow("watch", "winder", "--json", "--interval", "100")
        waiting = self.follow("wait", "held", "winder", "--json")
        telling = self.follow("events", "--follow", "--slave", "winder", "--json")
        expecting = self.follow("batch", self.script("write 3 1000 9\nexpect read winder 1000 = 4711 within 3600\n"))

        def slaves(follower):
            return [json.loads(line)["slave"] for line in follower.wrote().splitlines(keepends=True) if line.endswith("\n")]

        for one in (reading, watching):
            wait_for("it has begun", lambda one=one: 1 in slaves(one))
        wait_for("the script expects next", lambda: self.value(3) == 9)
        self.exchange()
        for one in (reading, watching, telling):
            if one is not watching:
                wait_for("it says so", lambda one=one: f"{EXCHANGED}; names are looked up again" in one.said())
        for one in (reading, watching):
            wait_for("it goes on with the other drive", lambda one=one: slaves(one)[-1] == 2)
            self.assertEqual(sorted(set(slaves(one))), [1, 2])
        self.run_verb("write", "2", WORD, "4711")
        wait_for("what was expected has come", lambda: expecting.process.poll() is not None)
        self.assertEqual(expecting.process.returncode, 0, expecting.said())
        wait_for("events of the other drive are told", lambda: 2 in slaves(telling))
        self.run_verb("write", "1", WORD, "4711")
        wait_for("it is looked up again", lambda: "mean other slaves now: 2" in waiting.said())
        waiting.process.send_signal(signal.SIGINT)
        wait_for("it ends", lambda: waiting.process.poll() is not None)
        self.assertEqual(json.loads(waiting.wrote())["slave_mask"], 0b100)

    def script(self, text):
        path = f"{self.gateway.folder.name}/script"
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path


if __name__ == "__main__":
    unittest.main()

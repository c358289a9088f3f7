"""What happens when the program that gives reference values dies, hangs or is taken over from."""

import signal
import time
import unittest

from gateway import LONG, OWN_TIME, wait_for
from verb_case import CONTROL_WORD, VerbTest


class FailsafeTest(VerbTest):
    def start_set(self, *arguments):
        process = self.gateway.start("set", *arguments)
        self.addCleanup(self.end, process)
        return process

    def end(self, process):
        process.kill()
        process.communicate(timeout=LONG)
        # Until the daemon misses it, it has its telegram, and the next one is refused.
        self.release("it has no telegram", lambda release: f"process {process.pid} " not in release["writer"])

    def release(self, what, condition):
        """The status of telegram 1, as soon as it fits."""
        status = self.gateway.wait_status(what, lambda status: condition(status["reference_release"][0]))
        return status["reference_release"][0]

    def given_by(self, process):
        return self.release("the status says who gives the values",
                            lambda release: f"process {process.pid} " in release["writer"])

    def events(self, code):
        return [event for event in self.json("events") if event["code"] == code]

    def beginnings(self, process):
        """How often it was told that this writer gives the values; it takes over when the one before is not missed yet."""
        return sum(f"process {process.pid} " in event["text"]
                   for event in self.events("reference_writer_began") + self.events("reference_writer_taken_over"))

    def wait_event(self, code, text):
        """The events with this code and text, as soon as there is one."""
        return wait_for(f"event {code} with '{text}'",
                        lambda: [event for event in self.events(code) if text in event["text"]])


class WriterLost(FailsafeTest):
    EXTRA = "[failsafe]\nreference_deadline_ms = 700\n"

    def test_a_killed_writer(self):
        process = self.start_set("0=5000", "--strength", 3)
        release = self.given_by(process)
        self.assertEqual(release["strength"], 3)
        self.assertIn("cansync", release["writer"])
        self.assertRegex(self.text("status"), r"(?m)^reference telegram 1 .* given by .*strength 3$")
        process.kill()
        lost = self.wait_event("reference_writer_lost", f"process {process.pid} ")
        self.assertEqual(len(lost), 1, "told once")
        release = self.release("nobody gives them", lambda release: release["cause"] == "writer_lost")
        self.assertEqual((release["state"], release["writer"]), ("stopped", ""))

    def test_a_suspended_writer_is_lost_and_found_again(self):
        process = self.start_set("0=5000")
        self.given_by(process)
        process.send_signal(signal.SIGSTOP)
        self.wait_event("reference_writer_lost", f"process {process.pid} ")
        self.release("nobody gives them", lambda release: release["cause"] == "writer_lost")
        process.send_signal(signal.SIGCONT)
        self.given_by(process)
        self.release("they are released", lambda release: release["state"] == "released")
        # More than two where the machine is so slow that the writer is missed once more.
        wait_for("its second beginning is told", lambda: self.beginnings(process) >= 2)

    def test_a_stronger_writer_takes_over_until_it_dies(self):
        weak = self.start_set("0=700", "--strength", 2)
        self.given_by(weak)
        strong = self.start_set("0=900", "--strength", 9)
        self.given_by(strong)
        taken = self.wait_event("reference_writer_taken_over", f"process {strong.pid} ")
        self.assertIn(f"process {weak.pid} ", taken[0]["text"])
        strong.kill()
        self.given_by(weak)
        release = self.release("the weaker one's are released", lambda release: release["state"] == "released")
        self.assertEqual(release["strength"], 2)

    def test_a_suspended_daemon_does_not_take_what_has_grown_old_meanwhile(self):
        # So slow that the oldest of the 16 samples DDS keeps is over 500 ms old when they are all taken together.
        process = self.start_set("0=5000", "--rate", 20)
        self.given_by(process)
        self.gateway.process.send_signal(signal.SIGSTOP)
        time.sleep(2)  # how long it is suspended
        self.gateway.process.send_signal(signal.SIGCONT)
        # Which of these is told depends on what DDS does first: hand the samples over, or notice that the writer's lease
        # ended meanwhile and drop them. That none of them is on the bus is shown by suspension_test.
        wait_for("it is told what became of them", lambda: [
            event for event in self.json("events")
            if "telegram 1" in event["text"] and (event["code"] in ("references_too_old", "reference_writer_lost")
                                                  or " age " in event["text"])])
        self.given_by(process)
        self.release("fresh ones are released", lambda release: release["state"] == "released")

    def test_a_writer_that_lives_but_gives_nothing_new(self):
        process = self.start_set("0=5000", "--rate", 0.2, "--release", 100)
        missed = self.wait_event("reference_deadline_missed", f"process {process.pid} ")
        self.assertIn("for 700 ms", missed[0]["text"])


class Restart(FailsafeTest):
    def test_a_daemon_that_was_started_anew_gets_nothing_from_the_programs_before(self):
        process = self.start_set("0=5000")
        self.given_by(process)
        before = self.gateway.status()["daemon"]
        self.gateway.process.kill()
        self.gateway.process.wait(timeout=LONG)
        self.gateway.__enter__()  # within the lease after which DDS tells that a peer has gone
        _, remarks = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 6)
        # On a computer that is too slow for that, the daemon is missed first.
        self.assertRegex(remarks.decode(), "the daemon was started anew|the daemon has gone|no daemon takes reference values")
        status = self.gateway.status()
        self.assertNotEqual(status["daemon"], before)
        self.assertEqual(status["reference_release"][0]["updates"], 0)

    def test_a_writer_that_ends_gives_its_telegram_up_also_while_a_weaker_one_lives(self):
        weak = self.start_set("0=700", "--strength", 2, "--rate", 0.01, "--release", 1)
        self.given_by(weak)
        strong = self.start_set("0=900", "--strength", 9, "--release", 1000)
        self.given_by(strong)
        self.interrupt(strong, code=0)
        given_up = self.wait_event("reference_given_up", f"process {strong.pid} ")
        self.assertEqual(len(given_up), 1)
        release = self.release("nobody gives them", lambda release: release["cause"] == "given_up")
        self.assertEqual((release["state"], release["writer"]), ("stopped", ""))


class Hold(FailsafeTest):
    BIT_RATE = 1000000
    EXTRA = '[failsafe]\nreaction = "hold"\nhold_intervals = 5000\nreference_max_intervals = 400\n'

    def test_the_last_values_are_held_for_a_while(self):
        process = self.start_set("0=5000", "--release", 1000)
        self.given_by(process)
        process.kill()
        release = self.release("they are held", lambda release: release["state"] == "held")
        self.assertIn(release["cause"], ("too_old", "writer_lost"))
        self.release("they are stopped", lambda release: release["state"] == "stopped")
        # On a computer that is late values may have been too old before; the last time counts. It skips SYNC edges, so
        # that the hold can end in a later interval than its last, but never in an earlier one.
        self.wait_event("references_too_old", "telegram 1")
        held = self.wait_event("references_held", "telegram 1")[-1]["interval"]
        stopped = wait_for("the end of the hold is told", lambda: [
            event["interval"] for event in self.events("references_stopped")
            if "telegram 1" in event["text"] and event["interval"] >= held])
        self.assertGreaterEqual(stopped[0], held + 5000)
        if OWN_TIME:
            self.assertEqual((len(stopped), stopped[0]), (1, held + 5000))


class ControlWord(FailsafeTest):
    EXTRA = '[failsafe]\nreaction = "control_word"\ncontrol_word = 0x0104\ncontrol_word_slaves = ["winder", 3]\n'

    def words(self):
        return [self.one("read", slave, CONTROL_WORD)["value"] for slave in range(self.SLAVES)]

    def test_the_named_slaves_get_it_when_the_writer_dies(self):
        process = self.start_set("0=5000")
        self.given_by(process)
        before = self.words()
        self.assertNotIn(0x0104, before)
        process.kill()
        wait_for("two drives have it", lambda: self.words() == [before[0], 0x0104, before[2], 0x0104])
        self.assertIn("slave 1 'winder', slave 3", self.wait_event("failsafe_control_word", "0x0104")[0]["text"])
        ended = self.wait_event("failsafe_control_word_ended", "0x0104")
        self.assertEqual((len(ended), ended[0]["severity"]), (1, "info"))
        self.assertIn("by the failsafe reaction: done", self.gateway.log_text())


class Limits(FailsafeTest):
    OPTIONS = ("--set", "reference.0.maximum=5")

    def test_a_value_beyond_its_limit_is_refused_and_reported_to_its_writer(self):
        good = self.start_set("0=5000", "--seconds", 1)
        self.release("the limit itself is released", lambda release: release["state"] == "released")
        good.communicate(timeout=LONG)
        updates = self.release("all are counted", lambda release: release["state"] == "stopped")["updates"]
        result = self.gateway.run("set", "0=5001", "--seconds", 1)
        self.assertIn("reference value 0 'target': 5.001 mm is above its maximum 5 mm", result.stderr)
        release = self.release("they are counted", lambda release: release["refused"] > 0)
        self.assertIn("above its maximum 5 mm", release["refused_reason"])
        self.assertEqual(release["updates"], updates, "none was released")


if __name__ == "__main__":
    unittest.main(verbosity=2)

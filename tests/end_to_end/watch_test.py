"""The full-screen view of `watch`: keys are pressed on a terminal, and its screen is read (python3-pyte)."""

import os
import re
import signal
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "pictures"))
from terminal import KIND, Terminal

from gateway import CANSYNC, Gateway
from verb_case import VerbTest


class WatchTest(VerbTest):
    EXTRA = "[process]\npoll_without_reference = true\n"  # there is something to see without a writer

    def watch(self, *arguments, gateway=None, columns=120, rows=32, **variables):
        environment = dict((gateway or self.gateway).environment, TERM=KIND, LC_ALL="C.UTF-8", **variables)
        return Terminal([CANSYNC, "watch", "--interval", "50", *arguments], environment, columns, rows)

    def shows(self, terminal, *parts):
        return terminal.wait(f"{parts} on the screen", lambda text: all(part in text for part in parts))

    @staticmethod
    def slaves(text):
        """Names of the table from the top."""
        return re.findall(r"(?m)^ *\d+  (\S+) +(?:released|starting|lost|returning|held|checking|absent) ", text)

    def wait_order(self, terminal, *names):
        return terminal.wait(f"the slaves are {names}", lambda text: self.slaves(text) == list(names))


class Keys(WatchTest):
    def test_shows_the_line_and_restores_the_terminal(self):
        with self.watch() as terminal:
            text = terminal.wait("slaves, load and events", lambda text: "LAST EVENTS" in text and "% of 125" in text
                                 and len(self.slaves(text)) == self.SLAVES and "all_synchronized" in text
                                 and re.search("winder .* mm ", text) and text)
            self.assertIn(f"bus {self.gateway.bus}: run", text)
            for part in ("SYNC 8 ms", "p99.9", "missed", "value 0", "AGE ms"):
                self.assertIn(part, text)
            self.assertRegex(text, r"1  winder +released +0x[0-9A-F]{4}")
            terminal.press("q")
            self.assertEqual(terminal.end(), 0)
            self.assertTrue(terminal.restored())

    def test_sort_and_order(self):
        with self.watch() as terminal:
            self.wait_order(terminal, "slave0", "winder", "slave2", "slave3")
            terminal.press("s")
            self.wait_order(terminal, "slave0", "slave2", "slave3", "winder")
            terminal.press("o")
            self.wait_order(terminal, "winder", "slave3", "slave2", "slave0")
            self.shows(terminal, "sorted by name, from the top")

    def test_filter(self):
        with self.watch() as terminal:
            self.wait_order(terminal, "slave0", "winder", "slave2", "slave3")
            terminal.press(*"/WIND")
            self.wait_order(terminal, "winder")
            terminal.press("enter")
            self.shows(terminal, "only WIND", "1 of 4 slaves")
            terminal.press("escape")
            self.wait_order(terminal, "slave0", "winder", "slave2", "slave3")
            terminal.press(*"/0,2-3")
            self.wait_order(terminal, "slave0", "slave2", "slave3")

    def test_pause_raw_values_and_selection(self):
        with self.watch() as terminal:
            self.shows(terminal, "value 0", "winder", " 0 mm ")
            terminal.press("r")
            self.shows(terminal, "numbers as on the bus", "value 0 raw")
            terminal.press("right", "v")
            self.shows(terminal, "sorted by value 1")
            terminal.press("p")
            marked = terminal.wait("it pauses", lambda text: "PAUSED at" in text and text)
            terminal.press("down")
            terminal.wait("the first slave is highlighted", lambda _: terminal.screen.buffer[5][10].reverse)
            self.assertEqual(terminal.text(), marked, "nothing moves while paused")
            terminal.press(" ")
            terminal.wait("it goes on", lambda text: "PAUSED" not in text and text != marked)

    def test_help_size_and_control_c(self):
        with self.watch() as terminal:
            self.shows(terminal, "winder")
            terminal.press("?")
            self.shows(terminal, "any key closes this page")
            terminal.press("x")
            self.shows(terminal, "winder", "LAST EVENTS")
            terminal.resize(50, 10)
            self.shows(terminal, "At least 60 x 12 characters are needed,", "this terminal has 50 x 10.")
            terminal.resize(90, 20)
            self.shows(terminal, "winder", "LAST EVENTS")
            terminal.press("ctrl-c")
            self.assertEqual(terminal.end(), 0)
            self.assertTrue(terminal.restored())

    def test_a_signal_restores_the_terminal(self):
        with self.watch() as terminal:
            self.shows(terminal, "winder")
            self.assertEqual(terminal.end(signal.SIGTERM), 0)
            self.assertTrue(terminal.restored())

    def test_ascii_where_the_locale_has_nothing_else(self):
        environment = dict(self.gateway.environment, TERM="vt100", LC_ALL="C")
        with Terminal([CANSYNC, "watch"], environment) as terminal:
            self.shows(terminal, "winder", "Bus load [")
            terminal.press("q")
            self.assertEqual(terminal.end(), 0)
            self.assertTrue(all(byte < 0x80 for byte in terminal.everything))


class Lines(WatchTest):
    def test_lines_without_a_full_screen(self):
        for arguments, variables in ((["--plain"], {}), ([], {"TERM": "dumb"}), ([], {"TERM": ""})):
            with self.subTest(arguments=arguments, **variables):
                environment = dict(self.gateway.environment, **variables)
                with Terminal([CANSYNC, "watch", "--interval", "50", *arguments], environment) as terminal:
                    terminal.wait("lines", lambda text: text.count("winder") > 2)
                    terminal.press("ctrl-c")
                    self.assertEqual(terminal.end(), 0)
                    self.assertNotIn(b"\x1b", terminal.everything)

    def test_a_terminal_nobody_knows(self):
        environment = dict(self.gateway.environment, TERM="no-such-terminal")
        with Terminal([CANSYNC, "watch", "--interval", "50"], environment) as terminal:
            terminal.wait("lines", lambda text: text.count("winder") > 2)
            terminal.press("ctrl-c")
            self.assertEqual(terminal.end(), 0)
            self.assertIn(b"plain lines instead", terminal.everything)


class DaemonGone(WatchTest):
    def test_says_so_and_goes_on_looking(self):
        with Gateway() as gateway, self.watch(gateway=gateway) as terminal:
            self.shows(terminal, "winder", "released")
            gateway.process.send_signal(signal.SIGTERM)
            self.shows(terminal, "The daemon has gone; looking for it")
            self.assertEqual(gateway.stop(), 0)
            gateway.__enter__()
            terminal.wait("the new daemon is found", lambda text: "has gone" not in text and "winder" in text)
            gateway.process.send_signal(signal.SIGTERM)
            self.shows(terminal, "The daemon has gone")
            terminal.press("q")
            self.assertEqual(terminal.end(), 6)
            self.assertTrue(terminal.restored())


if __name__ == "__main__":
    unittest.main()

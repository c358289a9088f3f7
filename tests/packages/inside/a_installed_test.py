"""The machine after the packages were installed by apt: its network, its units, its manual."""

import pathlib
import unittest

from machine import *


class Installed(unittest.TestCase):
    def test_1_the_machine_is_up_without_failed_units(self):
        wait_for("the machine has booted", lambda: "starting" not in run("systemctl", "is-system-running", expect=None))
        self.assertEqual(run("systemctl", "--failed", "--no-legend", "--plain"), "")

    def test_2_networkd_made_the_virtual_interface_as_the_examples_say(self):
        wait_for("vcan0 is up", lambda: "UP" in run("ip", "-brief", "link", "show", INTERFACE, expect=None))
        self.assertIn("qlen 10", run("ip", "link", "show", INTERFACE))

    def test_3_units_are_in_order(self):
        units = ("/lib/systemd/system/cansyncd@.service", "/lib/systemd/system/cansync-sim@.service")
        self.assertEqual(run("systemd-analyze", "verify", "--man=yes", *units), "")

    def test_4_exposure_is_at_most_1_5(self):
        run("systemd-analyze", "security", "--offline=yes", "--threshold=15", "/lib/systemd/system/cansyncd@.service")

    def test_5_every_program_has_its_manual_page(self):
        for section, page in ((8, "cansyncd"), (1, "cansync"), (1, "cansync-sim"), (1, "cansync-security"),
                              (5, "cansync.toml"), (7, "cansync-dds")):
            self.assertTrue(pathlib.Path(run("man", "-w", section, page).strip()).exists(), page)

    def test_6_the_user_has_no_shell_and_no_password(self):
        entry = run("getent", "passwd", "cansync").strip().split(":")
        self.assertTrue(entry[6].endswith("nologin"), entry)
        self.assertIn(run("getent", "shadow", "cansync").split(":")[1], ("!*", "!", "*"))

    def test_7_completion_knows_the_verbs(self):
        script = ("source /usr/share/bash-completion/completions/cansync; COMP_WORDS=(cansync stat); COMP_CWORD=1; "
                  "COMP_LINE='cansync stat'; COMP_POINT=12; $(complete -p cansync | sed 's/.*-F \\([^ ]*\\).*/\\1/') cansync stat cansync; "
                  "echo ${COMPREPLY[@]}")
        self.assertIn("status", run("bash", "-c", script))
        for path in ("fish/vendor_completions.d/cansync.fish", "fish/vendor_completions.d/cansyncd.fish",
                     "fish/vendor_completions.d/cansync-sim.fish", "zsh/vendor-completions/_cansync",
                     "zsh/vendor-completions/_cansyncd"):
            self.assertTrue(pathlib.Path("/usr/share", path).exists(), path)

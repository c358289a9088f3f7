"""bash with tools/completions/cansync loaded offers what the programs' help says, and never hangs, fails or complains."""

import os
import re
import subprocess
import sys
import tempfile
import unittest

from help_text import helps

COMPLETIONS = os.path.join(os.path.dirname(__file__), "..", "..", "tools", "completions", "cansync")
PROGRAMS = {os.path.basename(os.environ[name]): os.environ[name] for name in ("CANSYNC", "CANSYNCD", "CANSYNC_SIM")}

# Sets the variables that bash sets for a completion function, calls it, and prints what it offers.
ASK = """
source "$1" || exit 9
_cansync_configurations=$2
COMP_LINE=$3 COMP_POINT=${#3} COMP_WORDBREAKS=$' \\t\\n"\\'><=;|&(:'
shift 3
COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
_cansync
printf '%s\\n' "${COMPREPLY[@]}"
"""


def cut(line):
    """The words of a line as bash cuts them for a completion."""
    words = [part for word in line.split() for part in re.findall("[=:]+|[^=:]+", word)]
    return words + [""] if line.endswith(" ") else words


def offered(line, folder="/nowhere", inside=None):
    """What TAB offers at the end of `line`."""
    program, _, rest = line.partition(" ")
    path = PROGRAMS[program]
    words = [path, *cut(" " + rest)] if rest.strip() or not rest else [path, ""]
    # No daemon is there to be found: this domain's loopback ports are those of nobody.
    environment = dict(os.environ, CANSYNC_DOMAIN="229", CANSYNC_BUS=f"nobody-{os.getpid()}")
    result = subprocess.run(
        ["bash", "--norc", "--noprofile", "-c", ASK, "bash", os.path.abspath(COMPLETIONS), folder, f"{path} {rest}", *words],
        capture_output=True, text=True, env=environment, cwd=inside, timeout=120,
    )
    if result.returncode != 0 or result.stderr:
        raise AssertionError(f"{line!r}: exit code {result.returncode}, {result.stderr!r}")
    return [word for word in result.stdout.splitlines() if word]


class Completion(unittest.TestCase):
    def test_verbs(self):
        verbs = helps(PROGRAMS["cansync"])[""].verbs
        self.assertGreater(len(verbs), 10)
        self.assertEqual(offered("cansync "), verbs)
        self.assertEqual(offered("cansync --bus=can0 "), verbs)
        self.assertEqual(offered("cansync --bus can0 --json "), verbs)
        self.assertEqual(sorted(offered("cansync s")), sorted(verb for verb in verbs if verb.startswith("s")))
        self.assertEqual(offered("cansync no-such-verb "), [])

    def test_options_of_every_verb(self):
        for program, path in PROGRAMS.items():
            told = helps(path)
            for verb, text in told.items():
                line = f"{program} {verb} --" if verb else f"{program} --"
                self.assertEqual(offered(line), sorted({*text.options, *told[""].options}), line)

    def test_choices_of_options_and_arguments(self):
        choices = 0
        for verb, text in helps(PROGRAMS["cansync"]).items():
            for option, takes in text.options.items():
                if "|" in takes:
                    choices += 1
                    self.assertEqual(offered(f"cansync {verb} {option} "), takes.split("|"))
                    self.assertEqual(offered(f"cansync {verb} {option}="), takes.split("|"))
        self.assertGreaterEqual(choices, 3)
        self.assertEqual(offered("cansync mode "), ["setup", "run", "stop", "reset-can", "restart"])
        self.assertEqual(offered("cansync mode re"), ["reset-can", "restart"])
        self.assertEqual(offered("cansync mode stop "), [])

    def test_files_where_files_are_wanted(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("recipe.bin", "recipe two.bin", "other"):
                with open(os.path.join(folder, name), "w", encoding="utf-8"):
                    pass
            os.mkdir(os.path.join(folder, "identity"))
            files = ["recipe two.bin", "recipe.bin"]
            for line in ("cansync download 3 0x100 re", "cansync upload 3 0 4 re", "cansync timing --svg re",
                         "cansync timing --svg=re", "cansyncd re", "cansyncd --check re", "cansync-sim --faults re",
                         "cansync trace re"):
                self.assertEqual(sorted(offered(line, inside=folder)), files, line)
            self.assertEqual(offered("cansync --security ", inside=folder), ["identity"])

    def test_buses_and_interfaces(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("can0.toml", "can1.toml", "notes.txt"):
                with open(os.path.join(folder, name), "w", encoding="utf-8"):
                    pass
            self.assertEqual(offered("cansync --bus ", folder), ["can0", "can1"])
            self.assertEqual(offered("cansync status --bus=can1", folder), ["can1"])
        self.assertEqual(offered("cansync --bus "), [])
        self.assertIn("lo", offered("cansync --interface "))
        self.assertEqual(offered("cansync-sim l"), ["lo"])

    def test_without_a_daemon_fixed_words_are_offered_all_the_same(self):
        self.assertEqual(offered("cansync read "), ["all"])
        self.assertEqual(offered("cansync poll 1 nobody --maximum "), [])
        self.assertEqual(offered("cansync poll 1 "), ["auto", "nobody"])
        self.assertEqual(offered("cansync broadcast --slaves a"), ["all"])
        self.assertIn("value7=", offered("cansync set "))
        self.assertEqual(offered("cansync map references 1 value3."), ["value3.low", "value3.high"])

    def test_a_program_that_is_not_there_offers_nothing(self):
        missing = dict(PROGRAMS)
        PROGRAMS["cansync"] = "/nowhere/cansync"
        try:
            self.assertEqual(offered("cansync "), [])
        finally:
            PROGRAMS.update(missing)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])

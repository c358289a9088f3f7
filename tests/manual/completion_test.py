"""bash, zsh and fish with tools/completions loaded offer what the programs' help says, and never hang, fail or complain."""

import os
import pty
import re
import select
import subprocess
import sys
import tempfile
import time
import unittest

from help_text import helps

COMPLETIONS = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", "tools", "completions"))
PROGRAMS = {os.path.basename(os.environ[name]): os.environ[name] for name in ("CANSYNC", "CANSYNCD", "CANSYNC_SIM")}

# Each: the file of the completion, the folder of the configurations, the line, its words.
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
# The builtins that work inside the line editor alone are replaced by what they would show.
ASK_ZSH = """
compadd() {
  local -a shown
  while (($#)); do
    case $1 in
      -a) shown+=("${(@P)2}"); shift 2 ;;
      -V | -S) shift 2 ;;
      *) return 9 ;;
    esac
  done
  for each in "${shown[@]}"; do [[ $each == "$PREFIX"* ]] && print -r -- "$each"; done
}
compset() { PREFIX=${PREFIX#*=} }
_files() { if [[ $1 == -/ ]]; then print -rl -- ${~PREFIX}*(N-/); else print -rl -- ${~PREFIX}*(N); fi }
completion=$1 _cansync_configurations=$2
shift 3
words=("$@") CURRENT=$# PREFIX=${@[-1]}
_as_function() { source $completion }
_as_function
"""
# fish completes a line by itself.
ASK_FISH = """
set -g _cansync_configurations $argv[2]
source $argv[1]; or exit 9
complete -C $argv[3]
"""


def cut(line):
    """The words of a line as bash cuts them for a completion."""
    words = [part for word in line.split() for part in re.findall("[=:]+|[^=:]+", word)]
    return words + [""] if line.endswith(" ") else words


def offered(line, folder="/nowhere", inside=None, shell="bash"):
    """What TAB offers at the end of `line`; of `--option=value` the value."""
    program, _, rest = line.partition(" ")
    path = PROGRAMS[program]
    if shell == "bash":
        words = [path, *cut(" " + rest)] if rest.strip() or not rest else [path, ""]
        command = ["bash", "--norc", "--noprofile", "-c", ASK, "bash", f"{COMPLETIONS}/cansync"]
    elif shell == "zsh":
        words = [path, *rest.split(), *([""] if rest.endswith(" ") or not rest else [])]
        command = ["zsh", "-f", "-c", ASK_ZSH, "zsh", f"{COMPLETIONS}/_cansync"]
    else:
        words = []
        command = ["fish", "--no-config", "-c", ASK_FISH, f"{COMPLETIONS}/cansync.fish"]
    # No daemon is there to be found: this domain's loopback ports are those of nobody.
    environment = dict(os.environ, CANSYNC_DOMAIN="229", CANSYNC_BUS=f"nobody-{os.getpid()}")
    result = subprocess.run(
        [*command, folder, f"{path} {rest}", *words],
        capture_output=True, text=True, env=environment, cwd=inside, timeout=120,
    )
    if result.returncode != 0 or result.stderr:
        raise AssertionError(f"{line!r}: exit code {result.returncode}, {result.stderr!r}")
    option = re.match(r"--[a-z-]+=", rest.rpartition(" ")[2])
    return [word.removeprefix(option[0] if option else "") for word in result.stdout.splitlines() if word]


class Completion(unittest.TestCase):
    """What is the same in every shell; here bash."""

    SHELL = "bash"

    def offered(self, line, *arguments, **options):
        return offered(line, *arguments, shell=self.SHELL, **options)

    def test_verbs(self):
        verbs = helps(PROGRAMS["cansync"])[""].verbs
        self.assertGreater(len(verbs), 10)
        self.assertCountEqual(self.offered("cansync "), verbs)
        self.assertCountEqual(self.offered("cansync --bus=can0 "), verbs)
        self.assertCountEqual(self.offered("cansync --bus can0 --json "), verbs)
        self.assertCountEqual(self.offered("cansync s"), [verb for verb in verbs if verb.startswith("s")])
        self.assertEqual(self.offered("cansync no-such-verb "), [])

    def test_options_of_every_verb(self):
        for program, path in PROGRAMS.items():
            told = helps(path)
            for verb, text in told.items():
                line = f"{program} {verb} --" if verb else f"{program} --"
                self.assertEqual(self.offered(line), sorted({*text.options, *told[""].options}), line)

    def test_choices_of_options_and_arguments(self):
        choices = 0
        for verb, text in helps(PROGRAMS["cansync"]).items():
            for option, takes in text.options.items():
                if "|" in takes:
                    choices += 1
                    self.assertEqual(self.offered(f"cansync {verb} {option} "), takes.split("|"))
                    self.assertEqual(self.offered(f"cansync {verb} {option}="), takes.split("|"))
        self.assertGreaterEqual(choices, 3)
        self.assertEqual(self.offered("cansync mode "), ["setup", "run", "stop", "reset-can", "restart"])
        self.assertEqual(self.offered("cansync mode re"), ["reset-can", "restart"])
        self.assertEqual(self.offered("cansync mode stop "), [])

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
                self.assertEqual(sorted(self.offered(line, inside=folder)), files, line)
            self.assertEqual([name.rstrip("/") for name in self.offered("cansync --security ", inside=folder)], ["identity"])

    def test_buses_and_interfaces(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("can0.toml", "can1.toml", "notes.txt"):
                with open(os.path.join(folder, name), "w", encoding="utf-8"):
                    pass
            self.assertEqual(self.offered("cansync --bus ", folder), ["can0", "can1"])
            self.assertEqual(self.offered("cansync status --bus=can1", folder), ["can1"])
        self.assertEqual(self.offered("cansync --bus "), [])
        self.assertIn("lo", self.offered("cansync --interface "))
        self.assertEqual(self.offered("cansync-sim l"), ["lo"])

    def test_without_a_daemon_fixed_words_are_offered_all_the_same(self):
        self.assertEqual(self.offered("cansync read "), ["all"])
        self.assertEqual(self.offered("cansync poll 1 nobody --maximum "), [])
        self.assertEqual(self.offered("cansync poll 1 "), ["auto", "nobody"])
        self.assertEqual(self.offered("cansync broadcast --slaves a"), ["all"])
        self.assertIn("value7=", self.offered("cansync set "))
        self.assertEqual(self.offered("cansync map references 1 value3."), ["value3.low", "value3.high"])

    def test_a_program_that_is_not_there_offers_nothing(self):
        missing = dict(PROGRAMS)
        PROGRAMS["cansync"] = "/nowhere/cansync"
        try:
            self.assertEqual(self.offered("cansync "), [])
        finally:
            PROGRAMS.update(missing)

    def test_an_option_is_offered_beside_its_values(self):
        self.assertEqual(self.offered("cansync --col"), ["--color"])
        self.assertCountEqual(self.offered("cansync --color="), ["auto", "always", "never"])


class OtherShell(Completion):
    """The words come from the program; asked are those that a shell treats in its own way."""

    SHELL = "zsh"
    test_options_of_every_verb = None

    def test_choices_of_options_and_arguments(self):
        self.assertCountEqual(self.offered("cansync mode "), ["setup", "run", "stop", "reset-can", "restart"])
        self.assertCountEqual(self.offered("cansync mode re"), ["reset-can", "restart"])
        self.assertEqual(self.offered("cansync mode stop "), [])


class Fish(OtherShell):
    SHELL = "fish"


class LivingZsh(unittest.TestCase):
    def test_tab_in_an_interactive_shell(self):
        """Typed on a terminal: the builtins that the other tests replace take what they are given."""
        terminal, other = pty.openpty()
        with tempfile.TemporaryDirectory() as folder:
            environment = dict(os.environ, PATH=os.path.dirname(PROGRAMS["cansync"]) + ":" + os.environ["PATH"], PS1="ready> ",
                               TERM="dumb", HOME=folder, CANSYNC_DOMAIN="229")
            shell = subprocess.Popen(["zsh", "-f", "-i"], stdin=other, stdout=other, stderr=other, env=environment,
                                     start_new_session=True)
            os.close(other)
            try:
                self.await_text(terminal, "ready> ")
                os.write(terminal, f"fpath=({COMPLETIONS} $fpath); autoload -U compinit; compinit -u -D; echo loa''ded\n".encode())
                self.await_text(terminal, "loaded\r")
                os.write(terminal, b"cansync rea\t")
                self.await_text(terminal, "read ")
                os.write(terminal, b"\x15cansync mode rese\t")
                self.await_text(terminal, "reset-can ")
            finally:
                shell.kill()
                shell.wait(120)
                os.close(terminal)

    def await_text(self, terminal, wanted):
        shown = ""
        deadline = time.monotonic() + 120
        while wanted not in shown:
            self.assertLess(time.monotonic(), deadline, f"{wanted!r} is not in {shown!r}")
            if select.select([terminal], [], [], 0.1)[0]:
                shown += os.read(terminal, 65536).decode()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])

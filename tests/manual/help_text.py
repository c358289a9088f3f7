"""What the programs say of themselves with --help: verbs, options, arguments, columns."""

import functools
import re
import subprocess

# A line of the options: names, what the option takes, whence else it comes, whether it may be given again.
OPTION = re.compile(
    r"^  ((?:-\w,)?--[a-z][a-z-]*)(?: ([A-Z]+(?:=[A-Z]+)?|[a-z0-9-]+(?:\|[a-z0-9-]+)+))?(?: \(Env:(\w+)\))?"
    r"(?: \.\.\.)?(?: REQUIRED)?(?:\s.*)?$"
)


class Help:
    """The parsed help of a program or of one of its verbs."""

    def __init__(self, program, *verb):
        self.text = subprocess.run(
            [program, *verb, "--help"], check=True, capture_output=True, text=True, timeout=60
        ).stdout
        self.options = {}  # long name -> what it takes, "" for a flag
        self.environment = {}  # variable -> long name
        self.short = set()
        for line in self._section("Options"):
            if found := OPTION.match(line):
                names = found[1].split(",")
                self.options[names[-1]] = found[2] or ""
                self.short.update(names[:-1])
                if found[3]:
                    self.environment[found[3]] = names[-1]
        # heading -> the verbs below it; those of two words have one heading.
        titles = re.findall(r"(?m)^([A-Z][A-Za-z0-9 ]+):$", self.text.split("Exit codes:")[0])
        self.groups = {title: [line.split()[0] for line in self._section(title) if re.match(r"  [a-z]", line)]
                       for title in titles if (title == "Verbs" if verb else title not in ("Options", "Positionals"))}
        self.verbs = [name for names in self.groups.values() for name in names]
        usage = re.search(r"(?m)^Usage: (.*)$", self.text)[1]
        self.arguments = re.findall(r"[A-Z]+(?:=[A-Z]+)?", usage.split("[OPTIONS]")[1])
        if "VERB" in self.arguments:
            self.arguments.remove("VERB")

    def _section(self, title):
        """The lines below `title:` up to an empty one."""
        found = re.search(rf"(?m)^{title}:\n((?:.+\n)*)", self.text)
        return found[1].splitlines() if found else []

    def explained(self, title):
        """The entries of the list under `title` (Columns, Lines): heading -> explanation."""
        entries = {}
        heading = None
        for line in self._section(title):
            if found := re.match(r"^  (\S+(?: \S+)*)  +(\S.*)$", line):
                heading = found[1]
                entries[heading] = found[2]
            elif heading and line.startswith("   "):
                entries[heading] += " " + line.strip()
        return entries


@functools.cache
def help_of(program, words):
    """The help of one verb ("read", "can dump"); asked once, for a sanitized program starts slowly."""
    return Help(program, *words.split())


@functools.cache
def helps(program):
    """The help of the program under "", and of each of its verbs."""
    found = {"": help_of(program, "")}
    waiting = list(found[""].verbs)
    while waiting:
        words = waiting.pop(0)
        told = found[words] = help_of(program, words)
        waiting = [f"{words} {verb}" for verb in told.verbs] + waiting
    return found

"""The man pages say what the programs' help says, no more and no less, and are clean roff."""

import os
import re
import subprocess
import sys
import unittest

from help_text import Help, helps

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PAGES = os.environ["MAN_PAGES"]  # folder of the joined pages
ALL = ["cansync.1", "cansync-sim.1", "cansync-security.1", "cansync.toml.5", "cansync-dds.7", "cansyncd.8"]
OF_MARKDOWN = ["cansync.1", "cansync-sim.1", "cansync-dds.7"]  # written in man(7) by lowdown; the others are mdoc(7)
CANSYNC, CANSYNCD, CANSYNC_SIM = (os.environ[name] for name in ("CANSYNC", "CANSYNCD", "CANSYNC_SIM"))
OPTION = re.compile(r"Fl -([a-z-]+)(?: (?:Ar|Cm) (.+?))?$")


def source(page):
    with open(os.path.join(PAGES, page), encoding="utf-8") as file:
        return file.read()


def section(text, title, macro="Sh"):
    """The lines of a section, or of a subsection (.Ss)."""
    end = r"^\.(?:Sh|Ss) " if macro == "Ss" else r"^\.Sh "
    found = re.search(rf"(?msi)^\.{macro} {re.escape(title)}\n(.*?)(?={end}|\Z)", text)
    if not found:
        raise AssertionError(f"no section {title}")
    return found[1]


def takes(argument):
    """What an option takes as the help writes it: `Ar KEY Ns = Ns Ar VALUE` is KEY=VALUE, `Cm 0 | 1` is 0|1."""
    return re.sub(r" ?(?:Ns|Ar|\||=) ?", lambda part: part[0].strip() if part[0].strip() in "|=" else "", argument or "")


def listed(text):
    """Options that have an item, as the help has them: name -> what it takes."""
    options = {}
    for line in re.findall(r"(?m)^\.It (Fl .*)$", text):
        found = OPTION.search(line.split(" , ")[-1])
        options["--" + found[1]] = takes(found[2])
    return options


def in_cells(text):
    """The options of the tables of a page made of Markdown, as the help has them: name -> what it takes."""
    cells = re.findall(r"(?s)T\{\n(.*?)\nT\}", text)
    found = (re.fullmatch(r"(?:-\w, )?(--[a-z-]+)(?: (\S+))?", re.sub(r"\\f.", "", cell).replace("\\-", "-")) for cell in cells)
    return {option[1]: option[2] or "" for option in found if option}


def document(name):
    with open(os.path.join(SOURCE, "docs", name), encoding="utf-8") as file:
        return file.read()


def parts(text, level):
    """The parts of a document below its headings of that level, and what stands before them under "": heading -> text."""
    found = re.split(rf"(?m)^{'#' * level} (.*)\n", text)
    return {"": found[0], **dict(zip(found[1::2], found[2::2]))}


def items(text):
    """Options that have an item of a list in a document: name -> what it takes, the variable that gives it, what it means."""
    found = re.findall(r"(?m)^- `(?:-\w, )?(--[a-z-]+)(?: ([^`]+))?`(?: \(`(\w+)`\))?: (.{3,})$", text)
    return {option[0]: option[1:] for option in found}


def in_items(text):
    """The options of the items of a document, as the help has them: name -> what it takes."""
    return {name: item[0] for name, item in items(text).items()}


def in_synopsis(line):
    """Options and arguments of a line such as `plot FILE --output PICTURE [--values NAMES]`."""
    option = r"(--[a-z-]+)(?: ([A-Z][A-Z=]*|[a-z0-9]+\|[a-z0-9|]+))?"
    return dict(re.findall(option, line)), re.findall(r"[A-Z]+(?:=[A-Z]+)?", re.sub(option, "", line))


class Roff(unittest.TestCase):
    def test_mandoc_finds_nothing(self):
        for page in ALL:
            result = subprocess.run(["mandoc", "-Tlint", "-W", "warning", os.path.join(PAGES, page)],
                                    capture_output=True, text=True, check=False)
            self.assertEqual((result.returncode, result.stdout, result.stderr), (0, "", ""), page)

    def test_groff_warns_of_nothing(self):
        for page in ALL:
            result = subprocess.run(["man", "--warnings", "-l", os.path.join(PAGES, page)], capture_output=True, text=True,
                                    check=False, env=dict(os.environ, LC_ALL="C.UTF-8", MANWIDTH="80", PAGER="cat"))
            self.assertEqual((result.returncode, result.stderr), (0, ""), page)
            self.assertIn("SEE ALSO", result.stdout)

    def test_pages_refer_to_pages_that_there_are(self):
        foreign = {"openssl 1", "ip-link 8", "gnuplot 1"}
        for page in ALL:
            name, number = page.rsplit(".", 1)
            text = source(page)
            if page in OF_MARKDOWN:
                self.assertIn(f'.TH "{name.upper()}" "{number}" ', text)
                self.assertRegex(text, rf"\.SH NAME\n{name} - \S")
            else:
                self.assertIn(f".Dt {name.upper()} {number}\n", text)
                self.assertIn(f".Nm {name}\n.Nd ", text)
            for title in ("DESCRIPTION", "DIAGNOSTICS"):
                self.assertTrue(section(text, title))
            others = re.findall(r"(?m)^\.(?:Pq )?Xr (\S+ \d)", text)
            if page in OF_MARKDOWN:
                others = [" ".join(pair) for pair in re.findall(r"([\w.-]+)\((\d)\)", section(text, "SEE ALSO"))]
                self.assertGreater(len(others), 1)
            for other in others:
                self.assertIn(other, {page.replace(".1", " 1").replace(".5", " 5").replace(".7", " 7").replace(".8", " 8")
                                      for page in ALL} | foreign)


class Programs(unittest.TestCase):
    def same_options(self, page, text, told):
        self.assertEqual(listed(text), told.options, page)

    def test_options(self):
        self.same_options("cansyncd.8", section(source("cansyncd.8"), "DESCRIPTION"), Help(CANSYNCD))
        self.assertEqual(in_cells(section(source("cansync-sim.1"), "DESCRIPTION")), Help(CANSYNC_SIM).options, "cansync-sim.1")

    def test_synopsis_of_the_daemon(self):
        found = set(re.findall(r"Fl -([a-z-]+)|\| -([a-z-]+)", section(source("cansyncd.8"), "SYNOPSIS")))
        names = {"--" + (one or other) for one, other in found}
        self.assertEqual(names, set(Help(CANSYNCD).options) - {"--help", "--version"})

    def test_exit_codes(self):
        told = {
            "cansync-sim.1": re.findall(r"(?:: |, )(\d+) ", re.search(r"Exit codes: .*", Help(CANSYNC_SIM).text)[0]),
            "cansyncd.8": re.findall(r"(?:: |, )(\d+) ", re.search(r"Exit codes: .*\n?.*", Help(CANSYNCD).text)[0]),
        }
        for page, codes in told.items():
            self.assertGreaterEqual(len(codes), 3, page)
            item = r"(?m)^\\fB(\d+)\\fR$" if page in OF_MARKDOWN else r"(?m)^\.It (\d+)$"
            self.assertEqual(re.findall(item, section(source(page), "EXIT STATUS")), codes, page)

    def test_security_helper(self):
        usage = subprocess.run([os.path.join(SOURCE, "tools/security/cansync-security"), "--help"], check=True,
                               capture_output=True, text=True).stdout
        text = source("cansync-security.1")
        self.assertEqual(set(re.findall(r"--[a-z]+", usage)), set(listed(text)))
        verbs = re.findall(r"(?m)^  \S+ ([a-z]+) (?:DIR|IDENTITY)", usage)
        self.assertEqual(re.findall(r"(?m)^\.Nm\n\.Cm (\w+)\n\.Ar (?:DIR|IDENTITY)$", text), verbs)
        roles = re.findall(r"(?m)^(?: +ROLE: | {12})([a-z]+) {2,}", usage)
        self.assertEqual(re.findall(r"(?m)^\.It Cm (\w+)$", text), verbs + roles)


class CommandLine(unittest.TestCase):
    """The documents of which cansync(1) is made."""

    PARTS = ("command-line.md", "command-line-verbs.md", "command-line-columns.md")

    def test_options_and_environment(self):
        told = Help(CANSYNC)
        text = parts(document("command-line.md"), 2)["Options of every verb"]
        self.assertEqual(in_items(text), told.options)
        self.assertEqual({item[1]: name for name, item in items(text).items() if item[1]}, told.environment)
        self.assertEqual(len(re.findall("(?m)^- ", text)), len(told.options))

    def test_exit_codes(self):
        told = re.findall(r"(?m)^ {1,2}(\d+)  ", Help(CANSYNC).text.split("Exit codes:\n")[1])
        self.assertGreaterEqual(len(told), 9)
        text = parts(document("command-line.md"), 2)["Exit status"]
        self.assertEqual(re.findall(r"(?m)^- \*\*(\d+)\*\*: \S{3}", text), told)

    def test_every_verb_with_its_options_and_arguments(self):
        told = helps(CANSYNC)
        found = []
        for group, text in parts(document("command-line-verbs.md"), 2).items():
            verbs = parts(text, 3)
            shared = in_items(verbs.pop(""))  # of more than one verb of the group
            used = []
            for verb, words in verbs.items():
                found.append(verb)
                synopsis, description = words.split("\n\n", 1)
                self.assertRegex(synopsis, rf"\A`{verb}[ `]")
                options, arguments = in_synopsis(synopsis)
                own = {name: value for name, value in told[verb].options.items() if name != "--help"}
                self.assertEqual(options, own, f"synopsis of {verb}")
                self.assertEqual(arguments, told[verb].arguments, f"synopsis of {verb}")
                listed_here = in_items(description)
                of_group = {name: value for name, value in shared.items() if name in options}
                used += of_group
                self.assertEqual(listed_here.keys() & of_group.keys(), set(), f"{verb}: in its group, too")
                self.assertEqual({**of_group, **listed_here}, own, verb)
                self.assertRegex(description, r"\A[A-Z]\w* \w", f"{verb} is not described")
            self.assertEqual({name for name in shared if used.count(name) < 2}, set(), group)
        self.assertEqual(sorted(found), sorted(set(told) - {""}))

    def test_every_verb_stands_in_its_group(self):
        """The groups of `--help` are the headings of the document; a verb without one would be below "Subcommands"."""
        groups = {group: {verb.split()[0] for verb in parts(text, 3) if verb} for group, text in parts(document("command-line-verbs.md"), 2).items()
                  if group}
        told = {group: set(verbs) for group, verbs in helps(CANSYNC)[""].groups.items()}
        self.assertEqual(told, groups, "give the verb a group (tools/cli/base/verb_groups.h) and its section there")
        self.assertEqual(list(told), list(groups), "the order of the groups")

    def test_columns_are_those_of_the_help(self):
        printed = subprocess.run([sys.executable, "-B", os.path.join(SOURCE, "docs/man/make_columns"), CANSYNC], check=True,
                                 capture_output=True, text=True).stdout
        self.assertEqual(document("command-line-columns.md"), printed,
                         "run: docs/man/make_columns CANSYNC > docs/command-line-columns.md")

    def test_the_page_has_every_word_of_the_documents(self):
        text = ""
        for name in self.PARTS:
            whole = document(name)
            text += whole.split("\n", 1)[1] if name == self.PARTS[0] else whole[whole.index("\n## "):]
        text = re.sub(r"(?m)^!\[.*$|(?<=\])\([^)]*\)|^```$", "", text)
        text = re.sub(r"(?ms)^The man page `.*?^$", "", text)
        page = subprocess.run(["mandoc", "-Tutf8", os.path.join(PAGES, "cansync.1")], check=True,
                              capture_output=True, text=True).stdout
        page = re.sub(".\x08", "", page)  # bold, as typewriters did it
        page = page.split("\nDESCRIPTION\n")[1].split("\nFILES\n")[0]
        words = [re.findall(r"\w+", side.lower()) for side in (text, page)]
        self.assertGreater(len(words[0]), 4000)
        self.assertEqual(words[1], words[0])


class Topics(unittest.TestCase):
    def test_topics_are_those_of_the_documentation(self):
        with open(os.path.join(SOURCE, "docs/dds-api.md"), encoding="utf-8") as file:
            table = file.read().split("| topic | written by | key | QoS |\n|---|---|---|---|\n")[1].split("\n\n")[0]
        told = [[cell.strip(" `") for cell in row.strip("|").split("|")] for row in table.splitlines()]
        self.assertGreater(len(told), 10)
        rows = section(section(source("cansync-dds.7"), "DESCRIPTION"), "Topics", "Ss").split(".TS\n")[1].split(".TE\n")[0]
        cells = [re.sub(r"\\f.|\\&", "", cell).replace("\\(en", "–") for cell in re.findall(r"(?s)T\{\n(.*?)\nT\}", rows)]
        self.assertEqual([cells[at:at + 4] for at in range(4, len(cells), 4)], told)

    def test_nothing_of_the_document_is_missing(self):
        with open(os.path.join(SOURCE, "docs/dds-api.md"), encoding="utf-8") as file:
            headings = re.findall(r"(?m)^##+ (.*)$", re.sub(r"(?ms)^```.*?^```", "", file.read()))
        found = re.findall(r'(?m)^\.SS (.*)$', section(source("cansync-dds.7"), "DESCRIPTION"))
        self.assertEqual(found, headings)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])

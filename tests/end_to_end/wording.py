"""What texts for people must not say: "1 slaves", "3000ms"."""

import re

NOUNS = """actions addresses answers attempts batches bits blocks bytes clients commands daemons drives edges entries errors
events faults fields files frames identities intervals jobs lines marks messages nodes packets parameters places programs
ranges records replies reports requests restarts rows samples slaves steps telegrams times timers transfers turns values
words writers"""
# "slave 1 answers": a number that names something, and a verb.
ADJECTIVES = "open|parameter|status|error|foreign|SYNC|further|more"
NAMED = "command|slave|telegram|value|element|strength|interval|bus|winder"
ONE = re.compile(rf"(?<![\w.,:/'-])(?P<named>(?:{NAMED}) )?1 (?:(?:{ADJECTIVES}) )?(?:{'|'.join(NOUNS.split())})\b(?!/)")
GLUED = re.compile(r"\b\d+(?:ms|us|ns)\b")


def badly_said(text):
    """The places of a text that say a number badly."""
    return [found[0] for found in ONE.finditer(text) if not found["named"]] + GLUED.findall(text)


def expect_wording(where, *texts):
    """AssertionError when one of the outputs (bytes or text, or None) says a number badly."""
    for text in texts:
        found = badly_said(text.decode(errors="replace") if isinstance(text, bytes) else text or "")
        if found:
            raise AssertionError(f"{where}: {found}")

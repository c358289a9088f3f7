"""The sources that the checks of this folder read."""

import os
import re

PROTOCOL_LIST = "lib/protocols.def"


def load(root, places):
    """{path: text} of the C and C++ sources below `places` of `root`; paths are those below `root`."""
    files = {}
    for place in places:
        for folder, _, names in os.walk(os.path.join(root, place)):
            for name in names:
                if name.endswith((".h", ".cpp", ".hpp", ".c")):
                    path = os.path.join(folder, name)
                    with open(path, encoding="utf-8") as file:
                        files[os.path.relpath(path, root)] = file.read()
    return files


def protocols_in(text):
    """The names in the text of the list of protocols, in its order."""
    return re.findall(r"^PROTOCOL\((\w+)\)", text, re.MULTILINE)


def load_list(root):
    """The text of the list of protocols."""
    with open(os.path.join(root, PROTOCOL_LIST), encoding="utf-8") as file:
        return file.read()

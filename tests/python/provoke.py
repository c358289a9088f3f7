#!/usr/bin/python3
"""Requests of tests/client/refusals.json through the Python package: prints code, cause and whether to ask again of each.

Usage: provoke.py DOMAIN BUS CALL NUMBER... [-- CALL NUMBER...]...
"""

import sys

import cansync

FORMATS = {"word": 0, "doubleword": 1, "auto": 2}


def ask(line, call, words):
    if call == "mode":
        return line.set_mode(cansync.Mode[words[0].upper()])
    if call == "write":
        slave, number, value = map(int, words[:3])
        kind, element = words[3:] or ("auto", 7)
        return line.submit_write(slave, number, value, format=FORMATS[kind], element=int(element)).result()
    numbers = [int(word, 0) for word in words]
    if call == "broadcast":
        priority, mask, action, data_byte, data_word = numbers
        slaves = [slave for slave in range(32) if mask >> slave & 1]
        return line.broadcast(slaves, action, priority=priority, data_byte=data_byte, data_word=data_word)
    if call == "upload":
        return line.submit_upload(*numbers[:3], block_size=numbers[3] if len(numbers) > 3 else 0).result()
    if call == "map_references":
        return line.map_references(numbers)
    return {"read": line.read, "control_word": line.control_word, "release": line.release}[call](*numbers)


with cansync.connect(sys.argv[2], domain=int(sys.argv[1]), timeout=60) as line:
    for call in " ".join(sys.argv[3:]).split(" -- "):
        try:
            name, *numbers = call.split()
            ask(line, name, numbers)
            print("done none never")
        except cansync.Error as error:
            print(error.code.name.lower(), error.cause.name.lower(), error.retry.name.lower())

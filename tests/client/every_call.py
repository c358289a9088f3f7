#!/usr/bin/env python3
"""Writes a call of each public function of the client library's classes and C face, from their headers, for every_call_test.cpp; or of
the C face of a slave's application, for every_application_call_test.cpp.

Usage: every_call.py INCLUDE_FOLDER client|application OUTPUT. A parameter of a type or name that has no value in ARGUMENTS is an error: a new
function comes with values for its parameters, and is called then without a line elsewhere.
"""

import pathlib
import re
import sys

# Header, class, and how the test reaches an object of it.
CLASSES = (
    ("client.h", "Client", "client"),
    ("client.h", "ReferenceWriter", "writer"),
    ("reference_repeater.h", "ReferenceRepeater", "repeater"),
    ("job.h", "Job", "job"),
)
C_HEADERS = ("cansync_c.h", "cansync_c_jobs.h", "cansync_c_parameters.h", "cansync_c_topics.h")
APPLICATION_HEADER = "cansync_c_slave.h"
# What makes and ends the objects of the test, and needs none.
C_OF_THE_TEST = {"cansync_new", "cansync_connect", "cansync_free", "cansync_job_free", "cansync_unsubscribe", "cansync_version",
                 "cansync_application_new", "cansync_application_connect", "cansync_application_free"}
# By name first, then by type. Waits are short, requests are such that the daemon of the test would do them.
BY_NAME = {"timeout_ms": "50u", "address": "0x100u", "length": "4u", "number_or_name": '"slave2"', "telegram": "std::uint8_t{1}"}
ARGUMENTS = {
    "std::chrono::milliseconds": "std::chrono::milliseconds(50)",
    "std::uint8_t": "std::uint8_t{1}",
    "std::uint32_t": "1u",
    "std::uint64_t": "0u",
    "bool": "false",
    "std::vector<std::uint8_t>": "std::vector<std::uint8_t>{1, 2}",
    "const std::function<bool(const MasterStatus&)>&": "[](const MasterStatus&) { return false; }",
    "const std::array<std::int32_t, 4>&": "std::array<std::int32_t, 4>{}",
    "const std::atomic<bool>&": "on.stop",
    "const OnProgress&": "OnProgress{}",
    "const ParameterRequest&": "ParameterRequest{.slave = 1, .number = 1, .timeout_ms = 50}",
    "const TransferRequest&": "TransferRequest{.slave = 1, .address = 0x100, .length = 4, .timeout_ms = 50}",
    "const Broadcast&": "Broadcast{.slave_mask = 1, .action = 130, .timeout_ms = 50}",
    "const Polling&": "Polling{}",
    "const Cursors&": "Cursors{}",
    "const MappingBytes&": "MappingBytes{}",
    "const Validity&": "on.client.validity()",
    "Mode": "Mode::setup",
}
C_BY_NAME = {"timeout_ms": "50u", "address": "0x100u", "number_or_name": '"slave2"', "topic": "CANSYNC_TOPIC_BUS_STATUS",
             "user": "nullptr",
             "out of cansync_get_sample": "room<gateway_BusStatus>()", "size of cansync_get_sample": "sizeof(gateway_BusStatus)",
             "size": "4u", "data": "room<std::uint32_t>()", "count": "1u",
             "data of cansync_application_allow_block": "*room<std::uint8_t[4]>()",
             "data of cansync_application_step_block": "*room<std::uint8_t[4]>()"}
C_ARGUMENTS = {"cansync_client*": "&on.handle", "const cansync_client*": "&on.handle", "cansync_job*": "on.job",
               "const cansync_job*": "on.job", "uint32_t": "1u", "uint8_t": "1", "int": "0", "double": "0.0", "int32_t": "0",
               "uint64_t": "0", "const int32_t[4]": "*room<std::int32_t[4]>()", "cansync_application*": "on.application",
               "const cansync_application*": "on.application", "uint16_t": "1", "const uint8_t[8]": "*room<std::uint8_t[8]>()"}
# What is done with what a function gives.
C_GIVES = {"cansync_job*": "cansync_job_free", "cansync_subscription*": "cansync_unsubscribe"}
CALLBACK = re.compile(r"std::function<void\((const \w+&)\)>$")
# What runs in a callback of each type.
CALLBACKS = {
    "const std::function<bool(const MasterStatus&)>&": "[run](const MasterStatus&) { return run(), true; }",
    "const OnProgress&": "[run](std::uint32_t, std::uint32_t) { run(); }",
}


def split(text: str, at: str) -> list[str]:
    """The parts of `text` between signs `at` that stand in no brackets."""
    parts, depth = [""], 0
    for sign in text:
        depth += (sign in "(<{[") - (sign in ")>}]")
        if sign == at and depth == 0:
            parts.append("")
        else:
            parts[-1] += sign
    return parts


def public_part(header: str, name: str) -> str:
    """What the class declares under public, without comments."""
    body = re.search(rf"class CANSYNC_PUBLIC {name} \{{\n(.*?)\n\}};", header, re.DOTALL)
    assert body, f"no class {name}"
    text = re.sub(r"//[^\n]*", "", body[1])
    return re.sub(r"^ *public:", "", text.split("private:")[0].strip())


def kind_and_name(parameter: str) -> tuple[str, str]:
    """Of what a function declares: type, name."""
    declared = parameter.split(" = ")[0].strip()
    kind, _, name = declared.rpartition(" ")
    if not kind or name.endswith(("&", ">", ")")):
        kind, name = declared, ""
    return kind.replace("const R&", "const TransferReply&"), name


def callback(kind: str) -> str | None:
    """A callback of this type that calls `run`; None: it is no callback."""
    if found := CALLBACK.match(kind):
        return f"[run]({found[1]}) {{ run(); }}"
    return CALLBACKS.get(kind)


def argument(parameter: str, where: str) -> str:
    """A value of the parameter."""
    kind, name = kind_and_name(parameter)
    if found := CALLBACK.match(kind):
        return f"[]({found[1]}) {{}}"
    value = BY_NAME.get(name) or ARGUMENTS.get(kind)
    if value is None:
        sys.exit(f"every_call.py: {where}: parameter '{parameter.strip()}' has no value; give its type one in ARGUMENTS")
    return value


def functions(header: str, name: str) -> list[tuple[str, str, list[str]]]:
    """What each function of the class gives, its name and its parameters."""
    found = []
    for statement in split(public_part(header, name), ";"):
        declared = " ".join(statement.split())
        function = re.match(r"(?:\[\[nodiscard\]\] )?([\w:<>, ]+?[&>]?) (\w+)\((.*)\)(?: const)?(?: noexcept)?$", declared)
        if function and not declared.startswith(("static ", "explicit ", "friend ", "struct ")):
            found.append((function[1], function[2], [one for one in split(function[3], ",") if one.strip()]))
        elif re.search(r"\w+\(", declared):
            # Objects of the test are made and destroyed by it.
            assert re.search(rf"~?{name}\(|operator=|static ", declared), declared
    assert found, name
    return found


def calls(header: str, name: str, reached: str) -> tuple[list[str], list[str]]:
    """An entry for each function of the class, and one for each callback that they take."""
    all_calls, with_callback = [], []
    for gives, function, parameters in functions(header, name):
        where = f"{name}::{function}({', '.join(one.strip() for one in parameters)})".replace('"', "'")
        values = [argument(one, where) for one in parameters]
        call = f"on.{reached}.{function}({', '.join(values)})"
        all_calls.append(f'    {{"{where}", [](On& on) {{ {call if gives == "void" else f"said(on, {call})"}; }}}},')
        for i, parameter in enumerate(parameters):
            if run := callback(kind_and_name(parameter)[0]):
                call = f"on.{reached}.{function}({', '.join(values[:i] + [run] + values[i + 1:])})"
                keep = f"{call}; return nullptr;" if gives == "void" else f"return kept({call});"
                with_callback.append(f'    {{"{where}", [](On& on, const std::function<void()>& run) -> std::shared_ptr<void> '
                                     f'{{ {keep} }}}},')
    return all_calls, with_callback


def c_argument(parameter: str, function: str, callbacks: dict[str, tuple[str, str]], body: str) -> str:
    """A value of the parameter; a callback does what `body` says."""
    found = re.match(r"(.*?)(\w+)(\[\d+\])?$", " ".join(parameter.split()))
    assert found, parameter
    kind, name = found[1].strip() + (found[3] or ""), found[2]
    if kind in callbacks:
        gives, parameters = callbacks[kind]
        return f"[]({parameters}) -> {gives} {{ {body} {'return 0; ' if gives == 'int' else ''}}}"
    value = C_BY_NAME.get(f"{name} of {function}") or C_BY_NAME.get(name) or C_ARGUMENTS.get(kind)
    if value is None and (pointer := re.match(r"(?:const )?(\w+)\*$", kind)):
        value = f"room<{pointer[1]}>()"
    if value is None:
        sys.exit(f"every_call.py: {function}: parameter '{parameter.strip()}' has no value; give its type one in C_ARGUMENTS")
    return value


def c_calls(headers: str, on: str) -> tuple[list[str], list[str]]:
    """An entry for each function of the C face, called `on` what the test has, and one for each that subscribes."""
    text = re.sub(r"/\*.*?\*/", "", headers, flags=re.DOTALL)
    unnamed = re.compile(r"(?<=[\s*])(?!user\b)\w+(?=,|$)")
    callbacks = {name: (gives, unnamed.sub("", parameters).replace("void* user", "[[maybe_unused]] void* user"))
                 for gives, name, parameters in re.findall(r"typedef (int|void) \(\*(\w+)\)\((.*?)\);", text)}
    all_calls, subscriptions = [], []
    declared = re.findall(r"CANSYNC_C_API\s+([\w ]+?[ *]+)(\w+)\((.*?)\)\s*CANSYNC_C_NOEXCEPT;", text, re.DOTALL)
    assert declared and len(declared) == text.count("CANSYNC_C_API "), "a declaration is of a form that is not known"
    for gives, function, parameters in declared:
        if function in C_OF_THE_TEST:
            continue
        values = [c_argument(one, function, callbacks, "") for one in parameters.split(",")]
        call = f"{function}({', '.join(values)})"
        if given_back := C_GIVES.get(gives.strip()):
            call = f"{given_back}({call})"
        all_calls.append(f'    {{"{function}", []([[maybe_unused]] {on}& on) {{ {call}; }}}},')
        if "subscribe" in function:
            values = [c_argument(one, function, callbacks, "run_from(user);") for one in parameters.split(",")]
            call = f"{function}({', '.join(values[:-1])}, on.user)"
            keep = f"{call}; return nullptr;" if given_back is None else \
                f"return std::shared_ptr<{gives.strip()[:-1]}>({call}, {given_back});"
            subscriptions.append(f'    {{"{function}", []({on}& on) -> std::shared_ptr<void> {{ {keep} }}}},')
    return all_calls, subscriptions


def write(output: pathlib.Path, tables: dict[str, list[str]]) -> None:
    """Of each table: type and name, entries."""
    output.write_text("// Made by every_call.py from the headers.\n" + "".join(
        f"const {table}[] = {{\n" + "\n".join(lines) + "\n};\n" for table, lines in tables.items()))


def main() -> int:
    """Writes the tables."""
    folder, face, output = pathlib.Path(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    if face == "application":
        write(output, {"ApplicationCall kApplicationCalls": c_calls((folder / APPLICATION_HEADER).read_text(), "OnApplication")[0]})
        return 0
    made = [calls((folder / header).read_text(), name, reached) for header, name, reached in CLASSES]
    tables = {"Call kCalls": [line for part in made for line in part[0]],
              "Callback kCallbacks": [line for part in made for line in part[1]]}
    tables["CCall kCCalls"], tables["CSubscription kCSubscriptions"] = c_calls(
        "".join((folder / header).read_text() for header in C_HEADERS), "OnC")
    write(output, tables)
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Checks that every public declaration of the installed headers and of the protocols' cores has a docstring.

Usage: docstrings_check.py PROJECT | docstrings_check.py --self-test PROJECT
The headers are those of lib/client/include, which are installed, those of the function blocks in
lib/client/src, and the *.h of CORES. A docstring is `///` right above the declaration or at its end; in cansync_c*.h, which C
compilers read, a plain comment. Needed by:
  - functions, constructors, and C's types of callbacks; one that follows another of its name at once, without
    a blank line, shares the docstring. Not by destructors, operators == and <=>, defaulted and deleted ones.
  - classes, structs and enumerations, not by forward declarations.
  - public data members that are plain numbers, unless their struct's docstring has their name: unit or range.
The self-test plants one violation of each kind, takes away every docstring in turn, and fails if one is not found.
"""
import pathlib
import re
import sys

CORES = ("lib/cansync", "lib/layer2", "lib/j1939")
NUMBER = re.compile(
    r"(?:std::array<\s*)?(?:std::)?(?:u?int(?:8|16|32|64)_t|size_t|unsigned|int|double|float"
    r"|BYTE|D?WORD|U?S?INT|U?DINT|[A-Z]+INT_\d+_BMARRAY)\b"
)
SKIPPED = re.compile(r"(?:using|friend|static_assert|extern)\b")
MACRO = re.compile(r"\b(?:CANSYNC_\w+|__attribute__\(\(.*?\)\)|\[\[.*?\]\])\s*")
KIND = re.compile(r"(?:typedef\s+)?(class|struct|union|enum)\s+(?:class\s+|struct\s+)?(\w+)")
NO_CODE = re.compile(
    r"//[^\n]*|/\*.*?\*/"
    r'|"(?:\\.|[^"\\\n])*"'
    r"|(?<!\w)'(?:\\.|[^'\\\n])+'"
    r"|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*",
    re.S | re.M,
)
EMPTY_COMMENT = re.compile(r"^[/*<\s]*$")


class Declaration:
    """One public declaration: its lines, and the lines of its docstring (numbers from 1)."""

    def __init__(self, kind, name, first, owner):
        self.kind, self.name, self.first, self.owner = kind, name, first, owner
        self.last = first
        self.needed = True
        self.shared = False
        self.doc = []


def split_comments(text):
    """The text with comments, literals and preprocessor lines blanked, and {line: comment that ends the line}."""
    comments, out, line, i = {}, [], 1, 0
    for match in NO_CODE.finditer(text):
        out.append(text[i : match.start()])
        line += text.count("\n", i, match.start())
        token = match.group(0)
        if token.startswith(("//", "/*")):
            for offset, part in enumerate(token.split("\n")):
                comments[line + offset] = part
        keep = '""' if token[0] == '"' else "0" if token[0] == "'" else ""
        out.append(keep + " " * (len(token.split("\n")[0]) - len(keep)) + "\n" * token.count("\n"))
        line += token.count("\n")
        i = match.end()
    return "".join(out) + text[i:], comments


def unwrapped(head):
    """A declaration without macros, attributes and `template <...>`."""
    head = MACRO.sub("", " ".join(head.split())).strip()
    while head.startswith("template"):
        depth = 0
        for i, char in enumerate(head):
            depth += (char == "<") - (char == ">")
            if char == ">" and depth == 0:
                break
        head = head[i + 1 :].strip()
    return head


def function_name(head):
    """The name before the first parenthesis that is not inside <> or behind =; None: no function."""
    operator = re.search(r"\boperator\s*(\(\)|[^\s(\w]+|[\w:]+[^(]*)\s*\(", head)
    if operator:
        return "operator" + operator.group(1).strip()
    depth = 0
    for i, char in enumerate(head):
        depth += (char == "<") - (char == ">" and head[i - 1] != "-")
        if depth == 0 and char in "={":
            return None
        if depth == 0 and char == "(":
            name = re.search(r"~?\w+$", head[:i].rstrip())
            return name.group(0) if name else None
    return None


def classified(head, ends_with, scope):
    """Kind and name of a declaration, and whether it must have a docstring."""
    if not head or SKIPPED.match(head):
        return None
    kind = KIND.match(head)
    if kind and ends_with == "{":
        return kind.group(1), kind.group(2), True
    if head.startswith("typedef"):
        callback = re.search(r"\(\*(\w+)\)\s*\(", head)
        return ("callback", callback.group(1), True) if callback else None
    if kind and re.fullmatch(KIND.pattern + r"(?:\s*:.*)?", head):
        return None  # forward declaration
    name = function_name(head)
    if name:
        exempt = name.startswith("~") or name in ("operator==", "operator<=>")
        return "function", name, not exempt and not re.search(r"=\s*(?:default|delete)\s*$", head)
    if scope != "class":
        return None
    plain = re.sub(r"^(?:(?:static|constexpr|inline|const|mutable)\s+)*", "", head)
    name = re.match(r".*?(\w+)\s*(?:\[.*\]\s*)?(?:[={].*)?$", plain)
    return "member", name.group(1) if name else plain, bool(NUMBER.match(plain)) and not head.startswith("static")


class Reader:
    """Goes through the code of one header and collects its public declarations."""

    def __init__(self, text):
        self.code, self.comments = split_comments(text)
        self.lines = self.code.split("\n")
        self.c_face = 'extern "C"' in text
        self.found = []
        self.scope(0, "namespace", True, None)
        self.attach()

    def line(self, i):
        return self.code.count("\n", 0, i) + 1

    def closing(self, i):
        """Position behind the bracket that closes the one at `i`."""
        depth = 0
        for k in range(i, len(self.code)):
            depth += (self.code[k] in "{(") - (self.code[k] in "})")
            if depth == 0:
                return k + 1
        return len(self.code)

    def scope(self, i, kind, visible, owner):
        """Reads declarations from `i` to the end of the scope; the position behind it."""
        public = visible and owner_is_open(owner)
        begin = None
        while i < len(self.code):
            char = self.code[i]
            if begin is None:
                if char.isspace() or char == ";":
                    i += 1
                    continue
                if char == "}":
                    return i + 1
                label = re.compile(r"(public|protected|private)\s*:(?!:)").match(self.code, i)
                if label:
                    public = visible and label.group(1) == "public"
                    i = label.end()
                    continue
                begin = i
            if char == "(":
                i = self.closing(i)
            elif char == ";":
                self.add(begin, i, ";", kind, public, owner)
                begin, i = None, i + 1
            elif char == "{":
                begin, i = self.block(begin, i, kind, public, owner)
            else:
                i += 1
        return i

    def block(self, begin, i, kind, public, owner):
        """A `{` at `i`: where the declaration begins that is still open behind the block, and where to go on."""
        head = unwrapped(self.code[begin:i])
        if re.match(r"(?:inline )?namespace\b|extern\b", head):
            return None, self.scope(i + 1, "namespace", True, None)
        if KIND.match(head) and not function_name(head):
            declaration = self.add(begin, i, "{", kind, public, owner)
            is_enum = KIND.match(head).group(1) == "enum"
            end = self.closing(i) if is_enum else self.scope(i + 1, "class", public, declaration)
            return None, self.code.index(";", end) + 1
        end = self.closing(i)
        if not function_name(head):
            return begin, end
        after = self.code[end:].lstrip()[:1]
        if after and after in ",{":  # a member's initialiser in front of the body
            return begin, end
        self.add(begin, end - 1, "}", kind, public, owner)
        return None, end

    def add(self, begin, end, ends_with, kind, public, owner):
        head = self.code[begin:end]
        if ends_with == "}":
            head = head[: head.find("{")]
        result = classified(unwrapped(head), ends_with, kind)
        if not result:
            return None
        declaration = Declaration(result[0], result[1], self.line(begin), owner)
        declaration.last = self.line(end)
        declaration.needed = result[2] and public
        self.found.append(declaration)
        return declaration

    def says(self, number, trailing):
        """Is there a docstring in this line that is (not) at the end of code?"""
        comment = self.comments.get(number, "")
        alone = not self.lines[number - 1].strip()
        if trailing == alone or EMPTY_COMMENT.match(comment):
            return False
        if self.c_face:
            return True
        return comment.startswith("///") and comment.startswith("///<") <= trailing

    def attach(self):
        before = None
        for each in self.found:
            number = each.first - 1
            while number > 0 and self.says(number, False):
                each.doc.append(number)
                number -= 1
            for number in {each.first, each.last}:
                if each.kind not in ("class", "struct", "enum") and self.says(number, True):
                    each.doc.append(number)
            same = before and before.kind == each.kind == "function" and before.name == each.name
            if same and not each.doc and before.last + 1 == each.first:
                each.shared = True
            before = each

    def problems(self):
        """Declarations that need a docstring and have none."""
        lines, said = [], False
        for each in self.found:
            said = bool(each.doc) or (each.shared and said)
            if not each.needed or said:
                continue
            if each.kind == "member" and each.owner and each.name in self.words(each.owner):
                continue
            lines.append(each)
        return lines

    def words(self, declaration):
        return re.findall(r"\w+", " ".join(self.comments[number] for number in declaration.doc))


def owner_is_open(owner):
    """Members are public from the start, unless they are a class's."""
    return owner is None or owner.kind != "class"


def headers(project):
    places = ["lib/client/include/**/*.h", "lib/client/src/function_blocks/*.h", *(f"{core}/*.h" for core in CORES)]
    found = [path for place in places for path in sorted(project.glob(place))]
    return found + [path for core in CORES for path in sorted(project.glob(f"{core}/*/*.h"))
                    if path.parent.name not in ("dds", "sim", "client")]


SAMPLE = """
namespace a {
class Forward;
/// Said.
class Said {
  int private_function();
 public:
  Said() = default;
  Said(const Said&) = delete;
  ~Said();
  friend bool operator==(const Said&, const Said&) = default;
  void planted_function(int x = f());
  template <class T, int n = 3>
  std::array<T, 3> planted_template(std::function<void(int)> call) const {
    return {};
  }
  /// Shares.
  void overload(int);
  void overload(double);
  void line(); ///< said
  explicit Said(int planted) : a_{1}, b_(2) {}
  enum class PlantedEnum { a, b };
  struct PlantedStruct { bool flag = false; };
  static constexpr int planted_static() { return 1; }
  virtual void planted_virtual() noexcept = 0;
  Said& operator++();

  ///< Belongs to the line before.
  void planted_after_trailing();
  ///
  void planted_empty();
  // no docstring
  void planted_plain_comment();
 private:
  void hidden();
  struct Hidden { int number; };
 public:
  void planted_public_again();
};
/// `covered` is in metres.
struct Plain {
  std::uint32_t planted_number = 0;
  std::array<std::uint8_t, 3> planted_array = {};
  int covered{3};
  std::string text;
  Number own_type;
};
template <class T>
class PlantedClass {};
using Alias = int;
inline constexpr int kValue = [] { return 1; }();
constexpr int planted_free(
    int a);
}
"""
SAMPLE_C = """
#ifdef __cplusplus
extern "C" {
#endif
/* Said. */
int said(void);
int planted_c(void) CANSYNC_C_NOEXCEPT;
typedef int (*planted_callback)(void* user);
typedef struct planted_c_struct {
  uint32_t planted_c_number;
  uint32_t said_number; /* metres */
} planted_c_struct;
"""


def self_test(paths):
    found = [each.name for each in Reader(SAMPLE).problems()] + [each.name for each in Reader(SAMPLE_C).problems()]
    wanted = re.findall(r"\b(?:planted_\w+|Planted\w+)", SAMPLE + SAMPLE_C)
    wanted = sorted(set(wanted) | {"Said", "operator++"})
    if sorted(found) != wanted:
        return [f"of the sample {sorted(set(wanted) ^ set(found)) or found} was not (or wrongly) found"]
    planted = 0
    for path in paths:
        text = path.read_text(encoding="utf-8")
        lines = text.split("\n")
        reader = Reader(text)
        for each in reader.found:
            if not each.needed or not each.doc or each.owner and each.name in reader.words(each.owner):
                continue
            bare = lines[:]
            for number in each.doc:
                bare[number - 1] = re.sub(r"///.*|/\*.*|^ \*.*", "", bare[number - 1])
            planted += 1
            if not any(problem.first == each.first for problem in Reader("\n".join(bare)).problems()):
                return [f"{path}:{each.first}: {each.name} without its docstring was not found"]
    return [] if planted >= 300 else [f"only {planted} violations could be planted"]


def main():
    test = sys.argv[1] == "--self-test"
    project = pathlib.Path(sys.argv[2 if test else 1])
    paths = headers(project)
    if test:
        found = self_test(paths)
    else:
        found, needed = [], 0
        for path in paths:
            reader = Reader(path.read_text(encoding="utf-8"))
            needed += sum(each.needed for each in reader.found)
            found += [
                f"{path.relative_to(project)}:{each.first}: {each.name} has no docstring" for each in reader.problems()
            ]
        print(f"{needed} declarations, {len(found)} without a docstring")
    for problem in found:
        print(problem, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

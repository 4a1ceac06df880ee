"""Finds the function definitions of a C++ file without a compiler.

Comments, literals and preprocessor lines become blanks first. Then every '{' outside of a function is judged by the text
between it and the last ';', '{' or '}': a namespace, a type, a function body (a lambda that initialises a variable is one),
or the braces of an initialiser. Lambdas and types inside of a function belong to it and are not counted again.
"""
import re
from dataclasses import dataclass

_LITERAL = re.compile(
    r"""//[^\n]*|/\*.*?\*/|(?:u8|[uUL])?R"(?P<tag>[^()\\\s]{0,16})\((?P<raw>.*?)\)(?P=tag)"|"""
    r""""(?:\\.|[^"\\\n])*"|(?<![0-9a-zA-Z_])'(?:\\.|[^'\\\n])*'|^[ \t]*\#(?:\\\n|[^\n])*""", re.S | re.M)
_ACCESS = re.compile(r"^\s*(?:public|private|protected)\s*:(?!:)")
_ATTRIBUTE = re.compile(r"\[\[.*?\]\]|\b(?:alignas|__attribute__|noexcept|requires)\s*(?=\()")
_OPERATOR = re.compile(r"\boperator\s*(?:\(\s*\)|\[\s*\]|[-+*/%^&|~!=<>,]+)")
_TYPE = re.compile(r"^\s*(?:typedef\s+)?(?:class|struct|union|enum)\b")
_NAMESPACE = re.compile(r"^\s*(?:inline\s+)?namespace\b|^\s*extern\s+0\s*$")  # 0: the literal "C"
_LAMBDA = re.compile(r"(\w+)\s*=\s*\[[^\]]*\]\s*(?:\(.*\))?\s*(?:mutable|noexcept|->[^=;]*)*\s*$", re.S)
_DECISION = re.compile(r"\b(?:if|for|while|case|catch)\b|&&|\|\||\?")
_AFTER_PARAMETERS = re.compile(r"\s*(?:(?:const|noexcept|override|final|mutable|try|&&?)\s*|->[^=;]*|requires\b[^=;]*)*$")


@dataclass
class Function:
    name: str
    first: int  # line on which the signature begins, counted from 1
    last: int   # line of the closing brace
    lines: int  # from first to last, without the inner lines of raw strings
    decisions: int  # in the body: if, for, while, case, catch, &&, ||, ?


def blank(text):
    """`text` with the same lines, without comments, literals and preprocessor lines; and the lines inside raw strings."""
    raw_lines = set()

    def replace(match):
        found = match.group(0)
        if match.group("raw") is not None:
            first = text.count("\n", 0, match.start()) + 1
            raw_lines.update(range(first + 1, first + found.count("\n")))
        spaces = re.sub(r"[^\n]", " ", found)
        return spaces if found.lstrip()[0] in "#/" else "0" + spaces[1:]  # a literal stays something

    return _LITERAL.sub(replace, text), raw_lines


def _skip(text, start, opening, closing):
    """The index behind the group that opens at `start`."""
    depth = 0
    for i in range(start, len(text)):
        depth += (text[i] == opening) - (text[i] == closing and text[i - 1] != "-")
        if depth == 0:
            return i + 1
    return len(text)


def _declaration(head):
    """`head` without access labels, attributes, template parameters and requires clauses."""
    while True:
        shorter = _ACCESS.sub("", head).lstrip()
        if re.match(r"template\s*<", shorter):
            shorter = shorter[_skip(shorter, shorter.index("<"), "<", ">"):].lstrip()
        if shorter == head:
            break
        head = shorter
    while match := _ATTRIBUTE.search(head):
        end = match.end() if match.group(0).startswith("[[") else _skip(head, match.end(), "(", ")")
        head = head[:match.start()] + " " + head[end:]
    return head.lstrip()


def _name_if_function(head):
    """The name of the function that `head` declares, or None."""
    head = _OPERATOR.sub("operator_", head)
    groups, depth, start = [], 0, 0
    for i, c in enumerate(head):
        if c == "(":
            start = i if depth == 0 else start
            depth += 1
        elif c == ")":
            depth -= 1
            if depth == 0:
                groups.append((start, i + 1))
        elif c == "=" and depth == 0:
            return None
    if not groups or not _AFTER_PARAMETERS.fullmatch(head[groups[-1][1]:]):
        return None
    if test := re.match(r"TEST\w*\s*\(\s*(\w+)\s*,\s*(\w+)\s*\)", head):
        return f"{test[1]}.{test[2]}"
    words = re.findall(r"[\w:~]+", re.sub(r"<[^<>]*>", "", head[:groups[0][0]]))
    return words[-1] if words else None


def _opens(head):
    """The kind of '{' after `head`: 'scope', 'initialiser', or the name of a function."""
    head = _declaration(head)
    if _NAMESPACE.match(head):
        return "scope"
    if _TYPE.match(head) and "(" not in head:
        return "initialiser" if "=" in head else "scope"
    # In a constructor's initialisers a member's braces follow its name, the body's follow a ')' or '}'.
    if re.search(r"\)\s*(?:noexcept\s*)?:(?!:)", head) and re.search(r"[\w>]\s*$", head):
        return "initialiser"
    if match := _LAMBDA.search(head):
        return match.group(1)
    return _name_if_function(head) or "initialiser"


def find_functions(text):
    code, raw_lines = blank(text)
    functions, head_start, head, i, line = [], 1, "", 0, 1
    while i < len(code):
        c = code[i]
        if c == "{":
            kind = "initialiser" if head.count("(") > head.count(")") else _opens(head)
            if kind == "scope":
                head = ""
            else:
                end = _skip(code, i, "{", "}")
                last = line + code.count("\n", i, end)
                if kind == "initialiser":
                    head += "()" if re.search(r"[\w>]\s*$", head) else " 0 "
                else:
                    inner = sum(1 for n in range(head_start, last) if n in raw_lines)
                    functions.append(Function(kind, head_start, last, last - head_start + 1 - inner,
                                              len(_DECISION.findall(code, i, end))))
                    head = ""
                i, line = end, last
                continue
        elif c in ";}" and head.count("(") <= head.count(")"):
            head = ""
        elif head or not c.isspace():
            head_start = line if not head else head_start
            head += c
            if _ACCESS.fullmatch(head) and code[i + 1:i + 2] != ":":
                head = ""
        line += c == "\n"
        i += 1
    return functions

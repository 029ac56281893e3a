#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts sentences in the source below `report` and `app`: string literals of three words and more that are neither the
message of an error, nor the help of an option, nor a line of the log, nor a stage of progress. Fails when there is one. Values
leave modules, sentences are made of them in `report` and `app`. What a literal is shows in the call that it is an argument
of (EXEMPT), but not in one around a lambda in whose body it stands, nor in the type of whose definition it is part. Not counted
either, by the type they are declared with: tables of the words of an enumeration (`Word`, base/words.h), whose meanings are
helps of options; and texts that are bytes of a file (`FileText`, base/file_text.h: descriptions of rasters, heads of files,
well-known text), which belong to its format; nor statements of SQL.

What it does not see: sentences put together of literals of one or two words, those of any call named as one in EXEMPT, and
all of `io`."""
import pathlib, re, sys

FACES = {"report", "app", "serve"}
FORMATS = {"io"}  # words of its readers are messages of errors, those of its writers belong to the formats
# Calls whose texts are messages of errors, helps of options, lines of the log, stages of progress (`list_of`: of units).
EXEMPT = {
    "fail", "within", "bug", "Error", "error", "bad", "bad_line", "bad_row", "damaged", "failed", "refused", "map_error", "invalid",
    "invalid_argument", "png_error", "check_name", "check_image_names", "Field", "Choice", "or_auto", "list_of", "say", "report", "static_assert", "advising",
}
DECLARED = {"Word", "FileText"}  # types whose texts are not counted
SQL = re.compile(
    r"\s*(SELECT\s.*\sFROM\s|(INSERT|REPLACE)( OR \w+)? INTO\s|UPDATE \w+ SET\s|DELETE FROM\s|(CREATE|DROP|ALTER) (UNIQUE )?(TABLE|INDEX)\s|"
    r"PRAGMA \w+|BEGIN\b|COMMIT\b|VACUUM\b|ATTACH DATABASE\s|WHERE \w+ (=|<|>|IN\b|IS\b))", re.S)
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:[^"\\\n]|\\.)*"|(?<![0-9a-fA-F])\'(?:[^\'\\\n]|\\.)+\'|\w+|\n|[^\s\w]', re.S)


def is_sentence(text):
    if SQL.match(text):
        return False
    text = re.sub(r"\{[^{}]*\}", " ", text)  # what is formatted
    words = [word for word in text.split(" ") if re.fullmatch(r"[(\"']?[A-Za-z][a-z'-]+[.,:;)\"']*(\\n)?", word)]
    return len(words) >= 3


def opens_body(tokens, declared):
    """Whether the brace behind these tokens opens the body of a function, of a lambda or of a type, and not values."""
    if len(tokens) > 1 and tokens[-2] in ("struct", "class", "enum"):
        return True
    arrow = next((k for k in range(len(tokens) - 3, -1, -1) if tokens[k : k + 3] == [")", "-", ">"]), None)
    returns = arrow is not None and "(" not in tokens[arrow + 3 :]
    return not declared and (returns or tokens[-1:] in ([")"], ["]"], ["const"], ["mutable"], ["override"], ["noexcept"]))


def literals(source):
    """(line, text, names of the calls around it, and of the type it is declared with) of each literal; neighbours are one.
    Calls around a body are not around what stands in it."""
    line, calls, tokens, declared, joined = 1, [], [], "", None
    for match in TOKEN.finditer(source):
        token = match[0]
        if token.startswith('"') or token.startswith('R"'):
            text = token[token.index("(" if token.startswith("R") else '"') + 1 : -1]
            body = max((k for k, call in enumerate(calls) if call is None), default=-1)
            names = {name for call in calls[body + 1 :] for name in call} | {declared}
            joined = (joined[0], joined[1] + text, joined[2]) if joined else (line, text, names)
        elif not token.isspace() and not token.startswith("//") and not token.startswith("/*"):
            if joined:
                yield joined
                joined = None
            if token in "({":
                calls.append(None if token == "{" and opens_body(tokens, declared) else (tokens[-1] if tokens else "", declared))
            elif token in ")}" and calls:
                calls.pop()
            if token in DECLARED:
                declared = token
            elif token in "({)};":
                declared = ""
        if not token.isspace() and not token.startswith(("//", "/*")):
            tokens = [] if token in "{};" else [*tokens[-12:], token]
        line += token.count("\n")
    if joined:
        yield joined


def sentences(root):
    for path in sorted(root.rglob("*.[hc]*")):
        module = path.relative_to(root).parts[0]
        if module in FACES | FORMATS or path.name.endswith("_test.cc") or path.name.startswith("test_"):
            continue
        for line, text, names in literals(path.read_text()):
            if is_sentence(text) and not (EXEMPT | DECLARED).intersection(names):
                yield path, line, text


if __name__ == "__main__":
    root = pathlib.Path(__file__).resolve().parent.parent / "src" / "collinea"
    found = list(sentences(root))
    for path, line, text in found:
        print(f"{path.relative_to(root)}:{line}: {text[:110]}")
    print(f"{len(found)} sentences below report and app")
    sys.exit(bool(found))

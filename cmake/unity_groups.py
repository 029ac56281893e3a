#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""unity_groups.py SIZE FILE...: parts source files into groups of at most SIZE that can be compiled as one text.

Prints one line `group file` for each. Two files may not share a group when a name that one of them keeps to itself (in an
unnamed namespace, or as a macro) occurs in the other or is called or declared in a header that the other reads, for there it
would clash or, worse, be taken for another. Files that
read themselves again (Highway's foreach_target) stay alone and are not printed. First fit in the order given, so that an
edit moves a file only where it must."""
import functools
import os
import re
import sys

STRINGS_AND_COMMENTS = re.compile(
    r'R"([^(\s]*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'|//[^\n]*|/\*.*?\*/', re.S)
OPENING = re.compile(r"\bnamespace\s*\{")
TOKEN = re.compile(r"[A-Za-z_]\w*|\d[\w.']*|::|\[\[.*?\]\]|\S", re.S)
WORD = re.compile(r"[A-Za-z_]\w*")
FREE_WORD = re.compile(r"(?<![.\w])(?<!->)(?<!std::)(?<!Eigen::)[A-Za-z_]\w*")  # not a member of something
NO_NAMES = {"operator", "final", "TEST", "TEST_F", "TEST_P", "TYPED_TEST"}


def statements(text):
    """The statements of all unnamed namespaces of a text, without what stands in their braces and parentheses."""
    for opening in OPENING.finditer(text):
        depth, parentheses, words = 0, 0, []
        for token in TOKEN.finditer(text, opening.end()):
            word = token.group()
            if word == "(":
                parentheses += 1
                if parentheses == 1 and depth == 0:
                    words.append(word)
            elif word == ")":
                parentheses -= 1
            elif word == "{":
                if depth == 0 and parentheses == 0:
                    words.append(word)
                depth += 1
            elif word == "}":
                depth -= 1
                if depth < 0:
                    break
                if depth == 0 and parentheses == 0:
                    yield words
                    words = []
            elif depth == 0 and parentheses == 0:
                words.append(word)
                if word == ";":
                    yield words
                    words = []


INCLUDED = re.compile(r'#include "(collinea/[^"]+)"')
CALLED_OR_DECLARED = re.compile(FREE_WORD.pattern + r"(?=\()|(?<=struct )\w+|(?<=class )\w+|(?<=using )\w+(?= =)")


@functools.cache
def header_words(path):
    """Names that a header of the project calls or declares, and the headers that it reads itself."""
    if not os.path.exists(path):
        return set(), ()
    with open(path, encoding="utf-8") as file:
        raw = file.read()
    return set(CALLED_OR_DECLARED.findall(STRINGS_AND_COMMENTS.sub(" ", raw))), tuple(INCLUDED.findall(raw))


def words_below(top, headers):
    """What all the headers read, directly or not, call or declare."""
    words, seen, waiting = set(), set(), list(headers)
    while waiting:
        header = waiting.pop()
        if header in seen:
            continue
        seen.add(header)
        own, further = header_words(os.path.join(top, header))
        words |= own
        waiting += further
    return words


class Source:
    """What of a source file may clash: the names it keeps to itself, and all its words."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            raw = file.read()
        self.path = path
        self.alone = "hwy/foreach_target.h" in raw
        text = STRINGS_AND_COMMENTS.sub(" ", raw)
        top = os.path.abspath(path).rpartition("/collinea/")[0]
        self.words = set(FREE_WORD.findall(text)) | words_below(top, INCLUDED.findall(raw))
        self.aliases = set()
        self.names = set(re.findall(r"#\s*define\s+(\w+)", text)) | set(re.findall(r"^static\b[^;={(]*\b(\w+)", text, re.M))
        self.names |= {"using " + name for name in re.findall(r"\busing\s+namespace\s+([\w:]+)", text)}
        for statement in statements(re.sub(r"^\s*#[^\n]*", " ", text, flags=re.M)):
            self._declare(statement)

    def _declare(self, statement):
        if statement[0] in ("using", "namespace"):
            self.aliases.add(" ".join(statement))
            return
        ends = [at for at, word in enumerate(statement) if word in ("(", "=", "{", ";", "[", ":")]
        words = statement[:ends[0]] if ends else []
        if words and WORD.fullmatch(words[-1]) and words[-1] not in NO_NAMES and "::" not in words[-2:-1]:
            self.names.add(words[-1])

    def clashes_with(self, other):
        if self.names & other.words or other.names & self.words:
            return True
        mine = {alias for alias in self.aliases - other.aliases}
        theirs = {alias for alias in other.aliases - self.aliases}
        return self._leaks(mine, other) or self._leaks(theirs, self)

    @staticmethod
    def _leaks(aliases, into):
        """Whether one of these aliases would be seen under a name that the other file uses for something of its own."""
        return any(alias.split()[1] in into.words for alias in aliases if "=" in alias.split())


def groups_of(sources, size):
    groups = []
    for source in sources:
        for group in groups:
            if len(group) < size and not any(source.clashes_with(member) for member in group):
                group.append(source)
                break
        else:
            groups.append([source])
    return groups


def main():
    size, paths = int(sys.argv[1]), sys.argv[2:]
    sources = [source for source in map(Source, paths) if not source.alone]
    for number, group in enumerate(groups_of(sources, size)):
        if len(group) > 1:
            for source in group:
                print(f"group_{number} {source.path}")


if __name__ == "__main__":
    main()

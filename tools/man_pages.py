#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes man pages and the completion for bash, from `collinea COMMAND --help` and docs/manual.

usage: tools/man_pages.py [--collinea PROGRAM] FOLDER
FOLDER/man/man1 gets collinea.1 and collinea-COMMAND.1, FOLDER/man/man5 the adjustment file, all compressed;
FOLDER/bash-completion/completions/collinea completes commands and options.
"""
import argparse
import gzip
import pathlib
import re
import subprocess

import manual_options
from manual_options import BEGIN, END, ROOT

LINK = re.compile(r"\[([^\]]+)\]\(([^)]+)\)")


def inline(text):
    """A line of Markdown as roff."""
    text = LINK.sub(r"\1", text).replace("\\|", "|").replace("\\", "\\e").replace("-", "\\-")
    text = re.sub(r"`([^`]+)`", r"\\fB\1\\fR", text)
    text = re.sub(r"\*\*([^*]+)\*\*", r"\\fB\1\\fR", text)
    return "\\&" + text if text.startswith((".", "'")) else text


def option_rows(rows):
    """A table of options or of anything else: a tagged paragraph each."""
    for row in rows:
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", row.strip().strip("|"))]
        if len(cells) == 5 and cells[0].startswith("`"):
            option, value, unit, default, meaning = cells
            known = [text for text in (value and value + (f" [{unit}]" if unit else ""),
                                       default and (default if default == "required" else f"default {default}")) if text]
            yield ".TP"
            yield inline(option)
            yield inline(meaning + (f" ({', '.join(known)})" if known else ""))
        else:
            yield ".TP"
            yield inline(cells[0])
            yield inline(" \\(en ".join(cells[1:]).replace("\\(en", ";")) if len(cells) > 1 else ""


def body(markdown):
    """The text of a manual page below its title as roff."""
    lines, out, at = markdown.splitlines(), [], 0
    while at < len(lines):
        line = lines[at]
        if line.startswith("    "):
            out += [".PP", ".nf", ".RS 4"]
            while at < len(lines) and (lines[at].startswith("    ") or not lines[at].strip()):
                out.append(inline(lines[at][4:]))
                at += 1
            out += [".RE", ".fi", ".PP"]
            continue
        if line.startswith("|"):
            rows = []
            while at < len(lines) and lines[at].startswith("|"):
                rows.append(lines[at])
                at += 1
            out += [*option_rows(rows[2:]), ".PP"]
            continue
        if heading := re.match(r"##+ (.*)", line):
            out.append(f'.SH "{inline(heading[1]).upper()}"')
        elif group := re.fullmatch(r"\*\*(.+)\*\*", line):
            out.append(f'.SS "{inline(group[1])}"')
        elif item := re.match(r"[-*] (.*)", line):
            out += [".IP \\(bu 2", inline(item[1])]
        elif not line.strip():
            out.append(".PP")
        elif not line.startswith("<!--"):
            out.append(inline(line.strip()))
        at += 1
    return out


def page(name, section, version, summary, text):
    return "\n".join([f'.TH "{name.upper()}" {section} "" "collinea {version}" "collinea"', ".SH NAME",
                      f"{inline(name)} \\- {inline(summary)}", *text, ""])


def write(folder, name, section, text):
    place = folder / "man" / f"man{section}"
    place.mkdir(parents=True, exist_ok=True)
    (place / f"{name}.{section}.gz").write_bytes(gzip.compress(text.encode(), mtime=0))


def commands_of(program):
    """Commands and what they do, as the program lists them."""
    commands = {}
    for line in manual_options.help_of(program, None)[1:]:
        if found := re.match(r"^  ([a-z]+)\s\s+(\S.*)$", line):
            commands[found[1]] = found[2]
    return commands


def command_page(program, command, summary, version):
    text = (ROOT / "docs/manual" / f"{command}.md").read_text()
    if BEGIN in text:
        before, rest = text.split(BEGIN, 1)
        text = before + manual_options.options_of(program, command) + rest.split(END, 1)[1]
    title, rest = text.split("\n", 1)
    synopsis = [".SH SYNOPSIS", f".B collinea {command}", "[\\fIOPTIONS\\fR] [\\fIARGUMENTS\\fR]", ".SH DESCRIPTION"]
    return page(f"collinea-{command}", 1, version, summary, synopsis + body(rest) + [".SH SEE ALSO", ".BR collinea (1)"])


def top_page(commands, version):
    text = [".SH SYNOPSIS", ".B collinea", "\\fICOMMAND\\fR [\\fIOPTIONS\\fR]", ".SH DESCRIPTION",
            "Photographs (drone, aerial, hand\\-held) and survey control go in; oriented images, a point cloud, surface and terrain models,",
            "an orthophoto and a quality report come out.", ".PP",
            ".B collinea\\-demo", "renders a small survey with known truth, makes its map and says how good it is.", ".SH COMMANDS"]
    for command, summary in commands.items():
        text += [".TP", f".BR collinea\\-{command} (1)", inline(summary)]
    readme = (ROOT / "README.md").read_text()
    codes = re.search(r"Exit codes: (.*?)\n\n", readme, re.S)
    text += [".SH EXIT STATUS", inline(" ".join(codes[1].split())) if codes else ""]
    text += [".SH EXAMPLE", ".nf", "collinea run PHOTOS \\-o PROJECT", "xdg\\-open PROJECT/report/report.html", ".fi",
             ".SH SEE ALSO", ".BR collinea\\-adjustment\\-file (5)"]
    return page("collinea", 1, version, "photographs to maps, with standard deviations", text)


def completion(program, commands):
    """A bash function: commands first, then options of the command, files where neither is meant."""
    cases = []
    for command in commands:
        names = sorted(set(re.findall(r"(?<![\w-])--?[a-z][a-z0-9-]*", "\n".join(
            line.split("  ")[1] for line in manual_options.help_of(program, command) if line.startswith("  -")))))
        cases.append(f"    {command}) options='{' '.join(names)}' ;;")
    return "\n".join([
        "# bash completion of collinea", "_collinea() {", "  local word=${COMP_WORDS[COMP_CWORD]} options=", "  COMPREPLY=()",
        "  if [ \"$COMP_CWORD\" -eq 1 ]; then",
        f"    COMPREPLY=($(compgen -W '{' '.join(commands)} --help --version' -- \"$word\"))", "    return", "  fi",
        "  case ${COMP_WORDS[1]} in", *cases, "  esac",
        "  [[ $word == -* ]] && COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))", "}",
        "complete -o default -F _collinea collinea", ""])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--collinea", default=str(ROOT / "build/release/bin/collinea"))
    parser.add_argument("folder", type=pathlib.Path)
    args = parser.parse_args()
    program = str(pathlib.Path(args.collinea).resolve())
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]
    commands = commands_of(program)
    write(args.folder, "collinea", 1, top_page(commands, version))
    for command, summary in commands.items():
        write(args.folder, f"collinea-{command}", 1, command_page(program, command, summary, version))
    title, rest = (ROOT / "docs/manual/adjustment-file.md").read_text().split("\n", 1)
    write(args.folder, "collinea-adjustment-file", 5,
          page("collinea-adjustment-file", 5, version, "measurements of an adjustment, as text", [".SH DESCRIPTION", *body(rest)]))
    place = args.folder / "bash-completion/completions"
    place.mkdir(parents=True, exist_ok=True)
    (place / "collinea").write_text(completion(program, commands))
    print(f"== {len(commands) + 2} man pages and the completion for bash in {args.folder}")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""page_files.py FOLDER SOURCE.cc: puts the files of a folder into a C++ source as page_file() of serve/internal/page.h.

The bytes lie beside the source in one file that the assembler takes in; its name holds their hash, so that a compiler cache
that sees only the source does not take old for new. What gets smaller by a tenth or more is there compressed, too."""
import gzip
import hashlib
import pathlib
import sys

TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8",
         ".svg": "image/svg+xml", ".json": "application/json", ".wasm": "application/wasm", ".png": "image/png", ".woff2": "font/woff2"}


def escaped(text):
    return str(text).replace("\\", "\\\\").replace('"', '\\"')


def main():
    folder, source = map(pathlib.Path, sys.argv[1:])
    bytes_, lines = bytearray(), []

    def part(content):
        begin = len(bytes_)
        bytes_.extend(content)
        return f"{{page_bytes + {begin}, {len(content)}}}"

    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        name = path.relative_to(folder).as_posix()
        if path.suffix not in TYPES:
            sys.exit(f"{path}: page_files.py knows no content type of {path.suffix}")
        content = path.read_bytes()
        small = gzip.compress(content, 9, mtime=0)
        zipped = part(small) if len(small) < 0.9 * len(content) else "{}"
        name = "" if name == "index.html" else name
        lines.append(f'    {{"{escaped(name)}", "{TYPES[path.suffix]}", {part(content)}, {zipped}}},')
    packed = source.with_name(f"page-{hashlib.sha256(bytes_).hexdigest()[:16]}.bin")
    for old in source.parent.glob("page-*.bin"):
        old.unlink()
    packed.write_bytes(bytes_)
    source.write_text(f"""// Made by cmake/page_files.py.
#include "collinea/serve/internal/page.h"

asm(".pushsection .rodata\\n.balign 16\\n.globl collinea_page_bytes\\n.hidden collinea_page_bytes\\ncollinea_page_bytes:\\n"
    ".incbin \\"{escaped(escaped(packed))}\\"\\n.popsection\\n");
extern "C" __attribute__((visibility("hidden"))) const char collinea_page_bytes[];

namespace collinea {{
namespace {{

const char* const page_bytes = collinea_page_bytes;
const PageFile kFiles[] = {{
""" + "\n".join(lines) + """
};

}  // namespace

std::optional<PageFile> page_file(std::string_view name) {
  for (const PageFile& file : kFiles)
    if (file.name == name) return file;
  return std::nullopt;
}

}  // namespace collinea
""")


if __name__ == "__main__":
    main()

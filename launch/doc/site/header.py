#!/usr/bin/python3
"""A header as Doxygen has to read it: `launch/doc/site/header.py FILE` prints it, each line in its place.

The comment that opens a header is about the file; Doxygen would give it to the namespace below. A comment on `double a, b;`
is about both; Doxygen would give it to one of them. A tag such as <inertial> is text. The list of a struct's fields, which
files and recordings use, says the same everywhere.
"""
import re
import sys

DECLARATION = re.compile(r"^(\s*)((?:\w[\w:]*(?:<.*?>)?[&*]*\s+)+)(\w+\b(?!\s*\().*);\s*(?:///<\s*(.*))?$")
VALUE_OF_ENUM = re.compile(r"^(\s*)(enum class (\w+)[^{]*\{[^}]*\}) (\w+(?: = [^;]*)?;)(.*)$")
TAG = re.compile(r"(?<![`\\])<(?=/?[a-z_]+[ >=])")
FIELDS = re.compile(r"\s*(static )?void (eachField\(Self&|remember\(Numbers&)")
FIELD_WORDS = "/** Visits every field, in order: what is saved, compared and hashed (base/fields.h). */ "
OPENING, CLOSING = "([{<", ")]}>"


def declarators(text):
    """`a = f(1, 2), b` as ["a = f(1, 2)", "b"]."""
    parts, depth = [""], 0
    for character in text:
        depth += (character in OPENING) - (character in CLOSING)
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts]


def as_doxygen_reads(text):
    above = ""  # the comment that ends on the line before
    lines = text.split("\n")
    for number, line in enumerate(lines):
        if "///" in line:
            code, mark, comment = line.partition("///")
            line = code + mark + TAG.sub(r"\\<", comment)
        if number == 0 and line.startswith("///"):
            yield "/// \\file\n" + line
            continue
        if line == "#pragma once":  # its line is the one of \file
            continue
        several = DECLARATION.match(line)
        if several and not line.lstrip().startswith(("using", "return", "typedef", "template", "friend")):
            indent, kind, names, comment = several.groups()
            names = declarators(names)
            comment = comment or above
            if len(names) > 1 and comment:
                line = indent + " ".join(f"/** {comment} */ {kind.strip()} {name};" for name in names)
        value = VALUE_OF_ENUM.match(line)
        if value and above:
            line = "{0}{1}; /** {5} */ {2} {3}{4}".format(*value.groups(), above)
        if line.strip().startswith("template <") and FIELDS.match(lines[min(number + 1, len(lines) - 1)]) and not above:
            line = FIELD_WORDS + line.strip()
        above = f"{above} {line.strip()[3:].strip()}".strip() if re.match(r"\s*///($|\s)", line) else ""
        yield line


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        sys.stdout.write("\n".join(as_doxygen_reads(file.read())))


if __name__ == "__main__":
    main()

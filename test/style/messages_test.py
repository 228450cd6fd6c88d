#!/usr/bin/python3
"""Every field of every message says what it is; every number that has a dimension says its unit."""
import glob
import os
import re
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FIELD = re.compile(r"^(?P<type>[\w/]+(\[\d*\])?)\s+(?P<name>\w+)\s*(?P<value>=\s*[^#]*)?(#\s*(?P<comment>.*))?$")
UNIT = re.compile(r"\[[^\]]+\]")
SELF_EXPLAINING = ("haptic_msgs/",)  # messages of this package: their own fields carry the units


def violations(name, text):
    first_comment = False
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if line.startswith("#"):
            first_comment = True
        if not line or line.startswith("#") or line == "---":
            continue
        match = FIELD.match(line)
        if not match:
            yield f"{name}:{number}: not understood: {line}"
            continue
        if match["value"] is not None or match["type"].startswith(SELF_EXPLAINING):
            continue
        comment = match["comment"] or ""
        if not comment:
            yield f"{name}:{number}: {match['name']} has no comment"
        elif match["type"].startswith("float") and not (UNIT.search(comment) or "YAML" in comment or "World::" in comment):
            yield f"{name}:{number}: {match['name']} has no unit in brackets"
        elif match["name"] == "header" and not ("frame_id" in comment or "stamp" in comment):
            yield f"{name}:{number}: header does not say which frame"
    if not first_comment:
        yield f"{name}: says nowhere what the message is"


class Messages(unittest.TestCase):
    def test_every_field(self):
        files = sorted(glob.glob(os.path.join(ROOT, "msgs", "*", "*.msg")) + glob.glob(os.path.join(ROOT, "msgs", "*", "*.srv")))
        self.assertTrue(files)
        found = []
        for path in files:
            with open(path, encoding="utf-8") as text:
                found += violations(os.path.basename(path), text.read())
        self.assertEqual(found, [], "\n" + "\n".join(found))

    def test_each_rule_can_fail(self):
        good = "# A thing.\nfloat64 x # position [m]\nuint8 A = 1\n"
        self.assertEqual(list(violations("good", good)), [])
        for bad in ("float64 x # [m]\n", "# A.\nfloat64 x\n", "# A.\nfloat64 x # position\n", "# A.\n!?\n",
                    "# A.\nstd_msgs/Header header # of it\n"):
            self.assertEqual(len(list(violations("bad", bad))), 1, bad)


if __name__ == "__main__":
    unittest.main()

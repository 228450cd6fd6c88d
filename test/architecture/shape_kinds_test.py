#!/usr/bin/python3
"""The kind of a shape is asked in geometry's rooms shapes and pairs alone; all other code asks a shape for what it needs.

`--figures` prints how many other files ask:
    shapes.files_that_ask_kind       sources of the core and of the ROS packages
    shapes.test_files_that_ask_kind  tests, benchmarks and adapters of peers
"""
import os
import re
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SOURCES = ("src", "penalty_sim", "haptic_bridge", "spidar_driver")
# Rooms that may ask.
OWN = tuple(os.path.join("src", "haptic_core", "geometry", room) + os.sep for room in ("shapes", "pairs"))
ASKS = re.compile(r"(?:\.|->)\s*(?:kind|polyhedron|ball|rod|halfSpace|ellipsoid)\s*\(\s*\)"
                  r"|\bShapeKind\b|dynamic_(?:pointer_)?cast<\s*const\s+(?:haptic::)?(?:Ball|Rod|ConvexPolyhedron|HalfSpace|Ellipsoid|Cone|SupportShape)\b")
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)
# Rooms of geometry -> rooms that they may include besides themselves.
ROOMS = {
    "shapes": set(),
    "hulls": {"shapes"},
    "volume": {"shapes"},
    "search": {"shapes", "volume"},
    "pairs": {"shapes", "volume", "search"},
}
INCLUDE = re.compile(r'^\s*#\s*include\s*"haptic_core/geometry/(\w+)/', re.M)


def asking(root, folders):
    """Files below `folders` that ask for a kind, with the first line that does."""
    for folder in folders:
        for path, names, files in os.walk(os.path.join(root, folder)):
            names.sort()
            for name in sorted(files):
                place = os.path.relpath(os.path.join(path, name), root)
                if not name.endswith((".h", ".cpp")) or place.startswith(OWN):
                    continue
                with open(os.path.join(root, place), encoding="utf-8") as text:
                    code = COMMENT.sub(lambda m: "\n" * m.group(0).count("\n"), text.read())
                found = ASKS.search(code)
                if found:
                    yield f"{place}:{code.count(chr(10), 0, found.start()) + 1}: {found.group(0).strip()}"


def wrong_arrows(root):
    """Includes between geometry's rooms that ROOMS does not have."""
    geometry = os.path.join(root, "src", "haptic_core", "geometry")
    for room in sorted(os.listdir(geometry)):
        if not os.path.isdir(os.path.join(geometry, room)):
            if room.endswith((".h", ".cpp")):
                yield f"{room}: is in no room"
            continue
        for name in sorted(os.listdir(os.path.join(geometry, room))):
            with open(os.path.join(geometry, room, name), encoding="utf-8") as text:
                for target in INCLUDE.findall(text.read()):
                    if target != room and target not in ROOMS.get(room, ()):
                        yield f"{room}/{name}: must not include {target}"


class ShapeKinds(unittest.TestCase):
    def test_only_shapes_and_pairs_ask(self):
        self.assertEqual(list(asking(ROOT, SOURCES)), [])

    def test_rooms_point_one_way(self):
        self.assertEqual(list(wrong_arrows(ROOT)), [])

    def test_a_question_and_a_wrong_arrow_are_found(self):
        texts = {
            "src/haptic_core/world/a.cpp": "// shape.ball()\nif (shape->ball()) return;\n",
            "src/haptic_core/world/b.cpp": "// shape.ball() in a comment, and /* x.rod() */ too\nball(); rods();\n",
            "src/haptic_core/geometry/pairs/c.cpp": "shape.polyhedron();\n",
            "src/haptic_core/geometry/volume/d.cpp": '#include "haptic_core/geometry/pairs/table.h"\n',
            "src/haptic_core/geometry/e.cpp": "\n",
            "penalty_sim/f.h": "switch (shape.kind()) {}\n",
            "penalty_sim/g.h": "shape.ellipsoid();\n",
        }
        with tempfile.TemporaryDirectory() as root:
            for name, text in texts.items():
                os.makedirs(os.path.dirname(os.path.join(root, name)), exist_ok=True)
                with open(os.path.join(root, name), "w", encoding="utf-8") as out:
                    out.write(text)
            self.assertEqual(list(asking(root, SOURCES)),
                             ["src/haptic_core/world/a.cpp:2: ->ball()", "penalty_sim/f.h:1: .kind()", "penalty_sim/g.h:1: .ellipsoid()"])
            self.assertEqual(len(list(wrong_arrows(root))), 2)


if __name__ == "__main__":
    if sys.argv[1:] == ["--figures"]:
        for name, folders in (("shapes.files_that_ask_kind", SOURCES), ("shapes.test_files_that_ask_kind", ("test",))):
            found = list(asking(ROOT, folders))
            print("\n".join(found + [f"figure {name} {len(found)} 1"]))
    else:
        unittest.main()

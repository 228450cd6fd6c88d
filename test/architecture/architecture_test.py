#!/usr/bin/python3
"""Dependencies point one way: reads every #include and fails on an arrow that the design does not have."""
import os
import re
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

# Module of the core -> modules it may include besides itself.
CORE = {
    "base": set(),
    "geometry": {"base"},
    "contact": {"base", "geometry"},
    "dynamics": {"base"},
    "spidar": {"base"},
    "design": {"base", "spidar"},
    "world": {"base", "geometry", "contact", "dynamics", "stepping"},
    "stepping": {"base", "geometry", "contact", "dynamics", "world"},
    "analysis": {"base", "geometry", "contact", "dynamics", "world", "spidar"},
    "loop": {"base", "geometry", "contact", "dynamics", "world", "spidar"},
}
# Two rooms of one house: world's step calls the steppers, which know world's structs. What they must not know is the step,
# and the handle over it.
ONE_HOUSE = {"world", "stepping"}
NOT_FOR_STEPPING = {"haptic_core/world/step.h", "haptic_core/world/world.h"}
# ROS package -> packages of this repository that it may include besides itself.
PACKAGES = {
    "spidar_driver": {"haptic_core", "haptic_msgs"},
    "penalty_sim": {"haptic_core", "haptic_msgs"},
    "haptic_bridge": {"haptic_core", "haptic_msgs", "spidar_driver", "penalty_sim"},
}
ROS_HEADER = re.compile(
    r"^(ros|nodelet|pluginlib|tf2\w*|rosbag|urdf|\w+_msgs|haptic_msgs|std_srvs|diagnostic_\w+|dynamic_reconfigure"
    r"|interactive_markers|resource_retriever)/")
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]')
SUFFIXES = (".h", ".hpp", ".cpp", ".cc")


def sources(folder):
    for path, folders, files in os.walk(folder):
        folders.sort()
        for name in sorted(files):
            if name.endswith(SUFFIXES):
                yield os.path.join(path, name)


def includes(path):
    with open(path, encoding="utf-8") as text:
        for number, line in enumerate(text, 1):
            match = INCLUDE.match(line)
            if match:
                yield number, match.group(1)


def core_violations(root):
    """Arrows between the core's modules that the design does not have, and ROS headers in the core."""
    core = os.path.join(root, "src", "haptic_core")
    for path in sources(core):
        module = os.path.relpath(path, core).split(os.sep)[0]
        place = os.path.relpath(path, root)
        if module not in CORE:
            yield f"{place}: module '{module}' is not in the design; name its place in {__file__}"
            continue
        for number, header in includes(path):
            if header.startswith("haptic_core/"):
                target = header.split("/")[1]
                if target != module and target not in CORE[module]:
                    yield f"{place}:{number}: {module} must not include {header}"
                elif module == "stepping" and header in NOT_FOR_STEPPING:
                    yield f"{place}:{number}: a stepper must not know {header}"
            elif ROS_HEADER.match(header):
                yield f"{place}:{number}: the core must not include {header}"


def package_violations(root):
    """Arrows between the ROS packages that the design does not have."""
    names = set(PACKAGES) | {"haptic_core", "haptic_msgs"}
    for package, allowed in PACKAGES.items():
        for path in sources(os.path.join(root, package)):
            for number, header in includes(path):
                target = header.split("/")[0]
                if target in names and target != package and target not in allowed:
                    yield f"{os.path.relpath(path, root)}:{number}: {package} must not include {header}"


def cycles(graph):
    """Modules that reach themselves: the tables above must themselves point one way."""
    def reach(start):
        seen, todo = set(), list(graph[start])
        while todo:
            node = todo.pop()
            if node not in seen:
                seen.add(node)
                todo.extend(graph.get(node, ()))
        return seen
    return sorted(module for module in graph if module in reach(module))


class Architecture(unittest.TestCase):
    def test_tables_have_no_cycle(self):
        self.assertEqual(set(cycles(CORE)), ONE_HOUSE)
        self.assertEqual(cycles(PACKAGES), [])
        self.assertEqual(cycles({"a": {"b"}, "b": {"a"}}), ["a", "b"])

    def test_headers_have_no_cycle(self):
        """Within one house too: no header reaches itself."""
        headers = {}
        for path in sources(os.path.join(ROOT, "src", "haptic_core")):
            name = os.path.relpath(path, os.path.join(ROOT, "src"))
            if name.endswith(".h"):
                headers[name] = {header for _, header in includes(path)}
        self.assertGreater(len(headers), 50)
        self.assertEqual(cycles(headers), [])

    def test_core_points_one_way(self):
        self.assertTrue(list(sources(os.path.join(ROOT, "src", "haptic_core"))), "no sources found")
        self.assertEqual(list(core_violations(ROOT)), [])

    def test_packages_point_one_way(self):
        self.assertEqual(list(package_violations(ROOT)), [])

    def test_a_wrong_arrow_is_found(self):
        wrong = {
            "src/haptic_core/base/a.h": '#include "haptic_core/world/world.h"\n',
            "src/haptic_core/spidar/b.cpp": '#include <ros/ros.h>\n',
            "src/haptic_core/extra/c.h": "\n",
            "src/haptic_core/stepping/e.cpp": '#include "haptic_core/world/step.h"\n',
            "spidar_driver/src/d.cpp": '#include "penalty_sim/scene.h"\n',
        }
        with tempfile.TemporaryDirectory() as root:
            for name, text in wrong.items():
                os.makedirs(os.path.dirname(os.path.join(root, name)), exist_ok=True)
                with open(os.path.join(root, name), "w", encoding="utf-8") as out:
                    out.write(text)
            self.assertEqual(len(list(core_violations(root))), 4)
            self.assertEqual(len(list(package_violations(root))), 1)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
"""Equal bits on every processor: arithmetic that can enter a hash calls no function of the C library or the compiler.

Allowed are + - * /, sqrt, fabs, floor, ceil, round, remainder, fmod, copysign, ldexp: their results are exact or correctly
rounded everywhere. Everything else is in haptic_core/base/elementary.h."""
import os
import re
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# Sources that compute a state or its start.
FOLDERS = ["src/haptic_core", "penalty_sim/scene", "penalty_sim/replay", "penalty_sim/python", "haptic_bridge", "spidar_driver",
           "test/scenes"]
# No number of these reaches a world or a loop.
NOT_HASHED = {"haptic_bridge/panel", "spidar_driver/emulator"}
FUNCTIONS = ("a?sinh?|a?cosh?|a?tanh?|atan2|exp|exp2|expm1|log|log2|log10|log1p|pow|hypot|cbrt|fma|erfc?|[tl]gamma|sincos|nexttoward"
             "|cexp|polar|arg")
FORBIDDEN = [
    (re.compile(r"(?<![\w:.>])(?:std::|::|__builtin_)(?:%s)[fl]?\s*\(" % FUNCTIONS), "call haptic::elementary"),
    (re.compile(r"(?<![\w:.>])(?:%s)[fl]?\s*\((?!const )" % FUNCTIONS), "call haptic::elementary"),
    (re.compile(r"\.(?:%s)\(\)" % FUNCTIONS), "an array's function: call haptic::elementary"),
    (re.compile(r"\.(?:pow|array\(\)\.pow)\("), "multiply, or call haptic::elementary"),
    (re.compile(r"\blong double\b|__float128\b"), "its width differs between processors: use double"),
    (re.compile(r"_distribution\b"), "distributions of <random> differ between libraries: draw from the bits"),
    (re.compile(r"\b(?:std::)?(?:random_shuffle|shuffle)\s*\("), "its order differs between libraries"),
    (re.compile(r"\bAngleAxis"), "calls std::sin: use rotationAbout, rotationFromRpy or vectorFromRotation"),
    (re.compile(r"\.(?:slerp|angularDistance|eulerAngles|computeDirect)\("), "calls std::acos: use vectorFromRotation"),
    (re.compile(r"::(?:UnitRandom|Random)\(|\.setRandom\("), "calls rand(): draw from the bits"),
    (re.compile(r"\bset(?:FromRPY|RPY|Rotation)\(|\bgetRPY\("), "calls std::sin: use rotationFromRpy"),
    (re.compile(r"std::(?:reduce|transform_reduce|execution::)"), "the order of its sums is left open"),
]
ANY = re.compile("|".join(pattern.pattern for pattern, _ in FORBIDDEN))
OWN = {"src/haptic_core/base/elementary.h", "src/haptic_core/base/elementary.cpp"}


def code(line):
    """The line without its comment and texts; <cmath>'s names may stand in both."""
    return re.sub(r'"(?:\\.|[^"\\])*"', '""', line).partition("//")[0]


def found_in(line):
    text = code(line)
    return [(pattern.search(text).group(0).strip(), advice) for pattern, advice in FORBIDDEN if pattern.search(text)][:1]


def violations(root):
    for folder in FOLDERS:
        for path, folders, files in os.walk(os.path.join(root, folder)):
            folders[:] = sorted(f for f in folders if os.path.relpath(os.path.join(path, f), root) not in NOT_HASHED)
            for name in sorted(files):
                place = os.path.relpath(os.path.join(path, name), root)
                if not name.endswith((".h", ".cpp")) or place in OWN:
                    continue
                with open(os.path.join(path, name), encoding="utf-8") as text:
                    for number, line in enumerate(text, 1):
                        if ANY.search(line):
                            for text_found, advice in found_in(line):
                                yield f"{place}:{number}: '{text_found}': {advice}"


class ForbiddenCalls(unittest.TestCase):
    def test_sources(self):
        found = list(violations(ROOT))
        self.assertEqual(found, [], "\n" + "\n".join(found))

    def test_each_is_found(self):
        for line in ["x = std::sin(a);", "y = cos (a);", "::tanh(x)", "b = std::pow(x, 2);", "f(log1p(x))", "std::asinh(u / e)",
                     "long double s = 0;", "std::normal_distribution<double> n;", "Eigen::AngleAxisd(q, axis)", "a.slerp(t, b)",
                     "v.array().exp()", "R.eulerAngles(0, 1, 2)", "q.angularDistance(p)", "expf(x)", "std::hypot(a, b)",
                     "Quaternion::UnitRandom()", "std::atan(x)", "__builtin_cos(x)", "v.array().pow(2)"]:
            self.assertEqual(len(found_in(line)), 1, line)

    def test_others_are_not(self):
        for line in ["elementary::sin(x)", "std::sqrt(x)", "// std::sin(x)", "/// cos(x)", "cosine(x)", "std::remainder(a, b)",
                     "report.log(text)", "logs.exp", "spin()", "out->log(x)", "throw Error(\"std::exp(x)\");"]:
            self.assertEqual(found_in(line), [], line)


if __name__ == "__main__":
    unittest.main()

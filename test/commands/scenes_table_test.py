#!/usr/bin/python3
"""The table of all shipped scenes, against the log it is made of."""
import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/benchmark"))
import scenes_table  # noqa: E402

LOG = """scene left out: no model
scene                p50_us  p999_us worst_us  missed    energy   force_%  inside_%  ringing   given
a_cube                 12.0     80.5    120.0       0  1.00e-05      1.25     0.75     0.02    1.00
gear                   30.0    180.5   1120.0       3  2.00e-04      2.50     1.50     0.10    0.40
figure scenes.count 2 1
c_bin.urdf        p50 1 us, p99.9 2 us, worst 3 us, missed 0; 1 N rms on the hand, at a tenth 1.1
"""


class ScenesTable(unittest.TestCase):
    def test_every_scene_is_a_row_and_nothing_else(self):
        found = scenes_table.rows(LOG.splitlines())
        self.assertEqual([row["scene"] for row in found], ["a_cube", "gear"])
        table = [line for line in scenes_table.markdown(found, "HERE").splitlines() if line.startswith("|")]
        self.assertEqual(len(table), 4)
        self.assertEqual({line.count("|") for line in table}, {len(scenes_table.COLUMNS) + 1})
        self.assertEqual(table[3].replace(" ", ""), "|gear|2.50|1.50|2.00e-04|1120.0|180.5|3|0.10|0.40|")

    def test_columns_are_those_that_the_benchmark_prints(self):
        source = (ROOT / "test/benchmark/scenes_bench.cpp").read_text(encoding="utf-8")
        for name, _ in scenes_table.COLUMNS:
            self.assertIn(f'"{name}"', source)

    def test_a_log_without_a_table_is_refused(self):
        for log in ("", "figure scenes.count 2 1\n", LOG.replace("   given", "").replace("    1.00\n", "\n").replace("    0.40\n", "\n")):
            with self.assertRaises(ValueError):
                scenes_table.rows(log.splitlines())


if __name__ == "__main__":
    unittest.main()

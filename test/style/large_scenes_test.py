#!/usr/bin/python3
"""The large scenes are what their program writes."""
import importlib.util
import os
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOLDER = os.path.join(ROOT, 'urdf', 'scenes', 'large')


class LargeScenes(unittest.TestCase):
    def test_files_are_what_the_program_writes(self):
        spec = importlib.util.spec_from_file_location('make_scenes', os.path.join(FOLDER, 'make_scenes.py'))
        program = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(program)
        written = program.files()
        there = {name for name in os.listdir(FOLDER) if name.endswith(('.urdf', '.yaml'))}
        self.assertEqual(there, set(written))
        for name, text in written.items():
            with open(os.path.join(FOLDER, name), encoding='utf-8') as file:
                self.assertEqual(file.read(), text, name + ': run urdf/scenes/large/make_scenes.py')


if __name__ == '__main__':
    unittest.main()

"""YAML read strictly: each value is taken by name with its kind and bounds; what is left over is an error. Every complaint names
file and line."""
import re

import yaml

REQUIRED = object()


class Refused(Exception):
    """One line for the user: what, where, what to do."""


class Mapping:
    """One mapping of a file. Keys are taken one by one; `finish` refuses those that remain."""

    def __init__(self, path, node, name):
        self.path, self.name, self.node = path, name, node
        if not isinstance(node, yaml.MappingNode):
            raise Refused(f'{path}:{node.start_mark.line + 1}: {name} is no mapping; write KEY: VALUE below it')
        self.left, self.known = {}, []
        for key, value in node.value:
            if key.value in self.left:
                raise Refused(f'{path}:{key.start_mark.line + 1}: {name} has {key.value} twice; keep one')
            self.left[key.value] = (key, value)

    def fail(self, key, why):
        node = next((value for name, value in self.node.value if name.value == key), self.node)
        raise Refused(f'{self.path}:{node.start_mark.line + 1}: {self.name}: {key} {why}')

    def has(self, key):
        return key in self.left

    def node_of(self, key, default=REQUIRED):
        self.known.append(key)
        if key in self.left:
            return self.left.pop(key)[1]
        if default is REQUIRED:
            raise Refused(f'{self.path}:{self.node.start_mark.line + 1}: {self.name} has no {key}; add it')
        return None

    def number(self, key, default=REQUIRED, low=None, high=None, whole=False):
        node = self.node_of(key, default)
        if node is None:
            return default
        return self.checked(key, number_of(self.path, node, f'{self.name}: {key}'), low, high, whole)

    def checked(self, key, value, low, high, whole):
        if (low is not None and value < low) or (high is not None and value > high):
            self.fail(key, f'is {value:g}; give {f"at least {low:g}" if high is None else f"{low:g} to {high:g}"}')
        if whole and value != int(value):
            self.fail(key, f'is {value:g}; give a whole number')
        return int(value) if whole else value

    def numbers(self, key, default=REQUIRED, low=None, high=None, count=None):
        node = self.node_of(key, default)
        if node is None:
            return default
        if not isinstance(node, yaml.SequenceNode) or not node.value:
            self.fail(key, 'is no list of numbers; write [1, 2]')
        values = [self.checked(key, number_of(self.path, item, f'{self.name}: {key}'), low, high, False) for item in node.value]
        if count is not None and len(values) != count:
            self.fail(key, f'has {len(values)} numbers; give {count}')
        return values

    def text(self, key, default=REQUIRED, choices=None, pattern=None):
        node = self.node_of(key, default)
        if node is None:
            return default
        if not isinstance(node, yaml.ScalarNode) or not node.value.strip():
            self.fail(key, 'is no text')
        if choices is not None and node.value not in choices:
            self.fail(key, f"is '{node.value}'; there are {', '.join(choices)}")
        if pattern is not None and not re.fullmatch(pattern, node.value):
            self.fail(key, f"is '{node.value}'; letters, digits and _ only")
        return node.value

    def texts(self, key, default=REQUIRED):
        node = self.node_of(key, default)
        if node is None:
            return default
        if isinstance(node, yaml.ScalarNode) and node.value.strip():
            return [node.value]
        if not isinstance(node, yaml.SequenceNode) or not all(isinstance(item, yaml.ScalarNode) for item in node.value):
            self.fail(key, 'is no list of words; write [one, two]')
        return [item.value for item in node.value]

    def flag(self, key, default=REQUIRED):
        word = self.text(key, default if default is REQUIRED else None)
        if word is None:
            return default
        if word not in ('true', 'false'):
            self.fail(key, f"is '{word}'; give true or false")
        return word == 'true'

    def mapping(self, key, default=REQUIRED):
        node = self.node_of(key, default)
        return None if node is None else Mapping(self.path, node, key if self.name == 'the study' else f'{self.name}: {key}')

    def mappings(self, key, default=REQUIRED):
        node = self.node_of(key, default)
        if node is None:
            return default
        if not isinstance(node, yaml.SequenceNode) or not node.value:
            self.fail(key, 'is no list; write - KEY: VALUE below it')
        return [Mapping(self.path, item, f'{key} {i + 1}') for i, item in enumerate(node.value)]

    def finish(self):
        for name, (key, _) in self.left.items():
            known = f'; there are {", ".join(sorted(set(self.known)))}' if self.known else ''
            raise Refused(f"{self.path}:{key.start_mark.line + 1}: {self.name} has the unknown key '{name}'{known}")


def number_of(path, node, what):
    """YAML 1.1 takes 1e7 for a word: it is a number here."""
    try:
        value = float(node.value) if isinstance(node, yaml.ScalarNode) else float('nan')
    except ValueError:
        value = float('nan')
    if not -1e300 < value < 1e300:
        shown = f"'{node.value}'" if isinstance(node, yaml.ScalarNode) else 'a list or mapping'
        raise Refused(f'{path}:{node.start_mark.line + 1}: {what} is {shown}; give a finite number')
    return value


def read(path, name):
    """The root mapping of a file."""
    try:
        with open(path, encoding='utf-8') as file:
            text = file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise Refused(f'{path}: cannot be read: {getattr(error, "strerror", None) or "it is no text"}') from error
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise Refused(f'{path}:{line}: is no YAML: {error.problem}') from error
    except yaml.YAMLError as error:
        raise Refused(f'{path}: is no YAML: {str(error).splitlines()[0]}') from error
    if node is None:
        raise Refused(f'{path}:1: is empty; copy one of urdf/experiments')
    return Mapping(path, node, name), text

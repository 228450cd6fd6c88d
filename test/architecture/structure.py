#!/usr/bin/python3
"""Counts what the structure of the sources is held to, and prints it as figures.

    structure.core_lines            code lines below src/haptic_core, without blanks and comments
    structure.functions_over_60     functions longer than 60 lines, from signature to brace, in all packages
    structure.private_methods_max   the most private methods of one class, in all packages
    structure.files_for_...         files that a worked example of CONTRIBUTING touches

`--list` names the longest functions and the classes with most private methods.
"""
import argparse
import os
import re
import sys

import worked_examples_test

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
CORE = 'src/haptic_core'
PACKAGES = [CORE, 'spidar_driver', 'penalty_sim', 'haptic_bridge', 'msgs']
LONG = 60
NO_CODE = re.compile(r'R"(?P<mark>\w*)\(.*?\)(?P=mark)"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<![\w])\'(?:\\.|[^\'\\\n])\'', re.S)
SCOPE = re.compile(r'\b(namespace|class|struct|union|enum|extern)\b(?![^(]*\()')
CLASS = re.compile(r'\b(class|struct)\s+(?:\[\[\w+\]\]\s*)?(\w+)')
CALLABLE = re.compile(r'(~?\w+|operator\s*\S+)\s*\(')


def plain(text):
    """The code with comments gone and literals emptied; lines keep their numbers."""
    def blank(match):
        found = match.group(0)
        return '""' + '\n' * found.count('\n') if found[0] in 'R"\'' else '\n' * found.count('\n')
    return re.sub(r'^[ \t]*#(?:[^\n]*\\\n)*[^\n]*', lambda m: '\n' * m.group(0).count('\n'), NO_CODE.sub(blank, text), flags=re.M)


def code_lines(text):
    return sum(bool(line.strip()) for line in NO_CODE.sub(
        lambda m: m.group(0) if m.group(0)[0] in 'R"\'' else '\n' * m.group(0).count('\n'), text).split('\n'))


def functions_and_classes(code):
    """([(name, lines)], [(class, private methods)]) of one file's plain code."""
    functions, classes = [], []
    scopes = []      # per open brace: [kind, name, line, access, private methods]
    head, line, head_line, parentheses = '', 1, 1, 0
    for c in code:
        if c == '\n':
            line += 1
        if not head.strip():
            head, head_line = '', line
        if c in '()':
            parentheses += 1 if c == '(' else -1
        inside = scopes[-1][0] if scopes else 'namespace'
        if parentheses > 0 or inside in ('function', 'enum') and c not in '{}':
            head += c
            continue
        if inside == 'class' and c in '{;' and CALLABLE.search(head) and not re.search(r'\b(friend|using)\b', head):
            declared = scopes[-1]
            initialised = re.match(r'[^(]*=', head.replace('operator=', '').replace('==', ''))
            if declared[3] == 'private' and not SCOPE.search(head) and not initialised:
                declared[4] += 1
        if c == '{':
            if inside == 'function':
                kind = 'function'
            elif SCOPE.search(head):
                kind = 'enum' if re.search(r'\benum\b', head) else 'class' if CLASS.search(head) else 'namespace'
            else:
                kind = 'function' if CALLABLE.search(head) else 'other'
            name = CLASS.search(head).group(2) if kind == 'class' else (CALLABLE.search(head) or [head])[0].strip(' (')
            access = 'private' if kind == 'class' and CLASS.search(head).group(1) == 'class' else 'public'
            scopes.append([kind, name, head_line, access, 0])
            head = ''
        elif c == '}':
            if scopes:
                kind, name, start, _, methods = scopes.pop()
                if kind == 'class':
                    classes.append((name, methods))
                elif kind == 'function' and (not scopes or scopes[-1][0] != 'function'):
                    functions.append((name, line - start + 1))
            head = ''
        elif c == ';':
            head = ''
        elif c == ':' and inside == 'class' and head.strip() in ('public', 'private', 'protected'):
            scopes[-1][3] = head.strip()
            head = ''
        else:
            head += c
    return functions, classes


def sources(folder):
    for path, folders, files in os.walk(os.path.join(ROOT, folder)):
        folders.sort()
        for name in sorted(files):
            if name.endswith(('.h', '.cpp')):
                with open(os.path.join(path, name), encoding='utf-8') as file:
                    yield os.path.relpath(os.path.join(path, name), ROOT), file.read()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--list', action='store_true')
    listed = parser.parse_args().list
    functions, classes, lines = [], [], {}
    for package in PACKAGES:
        for path, text in sources(package):
            if package == CORE:
                room = path.split('/')[2]
                lines[room] = lines.get(room, 0) + code_lines(text)
            its_functions, its_classes = functions_and_classes(plain(text))
            functions += [(size, name, path) for name, size in its_functions]
            classes += [(methods, name, path) for name, methods in its_classes]
    functions.sort(reverse=True)
    classes.sort(reverse=True)
    if listed:
        print('code lines by room:', ', '.join(f'{room} {count}' for room, count in sorted(lines.items())))
        for size, name, path in functions[:12]:
            print(f'{size:4d} lines             {name}  ({path})')
        for methods, name, path in classes[:12]:
            print(f'{methods:4d} private methods   {name}  ({path})')
    print(f'figure structure.core_lines {sum(lines.values())} lines')
    print(f'figure structure.functions_over_60 {sum(size > LONG for size, _, _ in functions)} functions')
    print(f'figure structure.private_methods_max {classes[0][0]} methods')
    found = worked_examples_test.examples()
    for heading, (figure, _, _) in worked_examples_test.EXAMPLES.items():
        print(f'figure {figure} {worked_examples_test.filesTouched(found[heading])} files')


if __name__ == '__main__':
    sys.stdout.reconfigure(line_buffering=True)
    main()

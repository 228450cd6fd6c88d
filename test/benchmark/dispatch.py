#!/usr/bin/python3
"""`./run bench dispatch`: the core's two libraries compute the same bits, on every processor and for every user, and what a user gets
is as fast as the build for x86-64-v3 that one had to ask for before.

The loader chooses the library; a mask of processor features (GLIBC_TUNABLES) makes it choose the baseline, and the C library its
functions without fused multiplications. Each run says which library it used; a run with another than intended ends this program."""
import argparse
import concurrent.futures
import math
import os
import re
import shlex
import statistics
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
HERE = os.path.dirname(os.path.abspath(__file__))
V3 = os.path.join('glibc-hwcaps', 'x86-64-v3')
TICKS = 2000
ROUNDS = 7  # of both programs, in turn: the median of paired ratios needs few where a pair takes seconds
BASELINE = {'GLIBC_TUNABLES': 'glibc.cpu.hwcaps=-AVX2'}
NO_FMA = {'GLIBC_TUNABLES': 'glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2'}
PROCESSORS = ('x86-64', 'x86-64-v2', 'x86-64-v3', 'native')


def run(command, **settings):
    """Its output and what it said beside; ends this program with that if it fails."""
    environment = {key: value for key, value in os.environ.items() if key not in ('LD_LIBRARY_PATH', 'GLIBC_TUNABLES')}
    done = subprocess.run(command, env={**environment, **settings}, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f'dispatch: {shlex.join(command)} ended with {done.returncode}: {(done.stderr or done.stdout).strip()[-400:]}')
    return done.stdout, done.stderr


def figure(name, value, unit='1'):
    print(f'figure dispatch.{name} {value:.4g} {unit}', flush=True)


def find(folder, name):
    for path, folders, files in os.walk(folder):
        folders[:] = sorted(f for f in folders if f != 'before')
        if name in files:
            return os.path.join(path, name)
    return sys.exit(f'dispatch: {name} is not built below {folder}')


def expect(level, said):
    if f'library {level}' not in said:
        sys.exit(f'dispatch: a run was to use the library {level}, but said: {said.strip()}')


def hashes(program, level, **settings):
    """{scene: hash} after TICKS steps, and the bits of the C library's own functions."""
    out, said = run([program, str(TICKS)], **settings)
    expect(level, said)
    found = dict(line.rsplit(None, 1) for line in out.splitlines() if 'refused' not in line)
    if len(found) < 20:
        sys.exit(f'dispatch: only {len(found)} scenes ran')
    return found, re.search(r'C library (\w+)', said).group(1)


def differing(reference, other, what):
    """Scenes whose hashes are not those of `reference`."""
    names = sorted(name for name in reference.keys() | other.keys() if reference.get(name) != other.get(name))
    for name in names:
        print(f'{what}: {name}: {reference.get(name)} and {other.get(name)}')
    return len(names)


def bits(options, library, v3_here):
    """Both libraries over all scenes and a recording; one of them with and without the C library's fused variants."""
    program = find(options.build, 'scene_hashes')
    level, folder = ('x86-64-v3', os.path.join(library, V3)) if v3_here else ('baseline', library)
    jobs = [('baseline', BASELINE), (level, {}), (level, {'LD_LIBRARY_PATH': folder}), (level, {'LD_LIBRARY_PATH': folder, **NO_FMA})]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        baseline, default, plain, masked = pool.map(lambda job: hashes(program, job[0], **job[1]), jobs)
    count = differing(baseline[0], default[0], 'baseline and default')
    for name, settings in (('default', {}), ('baseline', BASELINE)):
        out, _ = run(['sh', '-c', '. "$1/devel/setup.sh" && unset LD_LIBRARY_PATH && exec "$1/devel/lib/penalty_sim/haptic_replay" "$2" '
                      '|| true', 'sh', options.stack, options.bag], **settings)
        match = re.search(r'^figure replay.steps (\d+).*\n^figure replay.mismatches (\d+)', out, re.MULTILINE)
        same = match and int(match.group(1)) > 1000 and match.group(2) == '0'
        print(f'recording, {name} library: {match.group(0) if match else out}')
        count += not same
    figure('bits_differ', count)
    figure('libm_bits_differ', differing(plain[0], masked[0], 'C library with and without fused variants'))
    if plain[1] == masked[1]:
        print('note: the C library computes the same bits with and without its variants on this processor: libm_bits_differ shows nothing')
    figure('scenes', len(baseline[0]))


def times(program, **settings):
    return {name: float(seconds) for name, seconds in re.findall(r'^case (\S+) (\S+)', run([program], **settings)[0], re.MULTILINE)}


def instructions(program, case, **settings):
    out, said = run(['valgrind', '--tool=callgrind', '--callgrind-out-file=/dev/null', '--toggle-collect=haptic_counted_pass', program,
                     '--count', case], **settings)
    return int(re.search(r'Collected : (\d+)', out + said).group(1))


def mean_of(ratios, what):
    for case, ratio in sorted(ratios.items()):
        print(f'{what}: {case} {ratio:.4f}')
    return math.exp(statistics.fmean(math.log(ratio) for ratio in ratios.values()))


def speed(options, library):
    """What a user gets against the build for x86-64-v3 of before, in turn."""
    before_library = os.path.dirname(find(options.before_build, 'libhaptic_core.so'))
    # The same source beside the scenes of then.
    source = os.path.join(options.before, 'test', 'benchmark', 'dispatch_bench.cpp')
    with open(os.path.join(HERE, 'dispatch_bench.cpp'), encoding='utf-8') as text, open(source, 'w', encoding='utf-8') as copy:
        copy.write(text.read())
    before = os.path.join(options.before_build, 'bench_dispatch')
    run(['g++', '-std=c++17', '-O3', '-DNDEBUG', '-march=x86-64-v3', '-ffp-contract=off', '-I' + os.path.join(options.before, 'src'),
         '-isystem', '/usr/include/eigen3', source, '-o', before, '-L' + before_library, '-lhaptic_core', '-Wl,-rpath,' + before_library])
    program = find(options.build, 'bench_dispatch')
    ratios = {}
    for each in range(ROUNDS):
        pair = [times(p) for p in ((before, program) if each % 2 else (program, before))]
        theirs, ours = pair if each % 2 else reversed(pair)
        for case, seconds in ours.items():
            ratios.setdefault(case, []).append(seconds / theirs[case])
    figure('default_over_v3', mean_of({case: statistics.median(all_of) for case, all_of in ratios.items()}, 'time over before'))
    v3 = {'LD_LIBRARY_PATH': os.path.join(library, V3)}
    figure('instructions_over_v3', mean_of({case: instructions(program, case, **v3) / instructions(before, case) for case in ratios},
                                           'instructions over before'))


def foreign(library):
    """A user's source, compiled for several processors, with and without fused multiplications."""
    source, results = os.path.join(HERE, 'dispatch_user.cpp'), {}
    for processor in PROCESSORS:
        for contraction in ('off', 'fast'):
            program = os.path.join(library, f'dispatch_user_{processor}_{contraction}')
            run(['g++', '-std=c++17', '-O2', '-march=' + processor, '-ffp-contract=' + contraction, '-I' + os.path.join(ROOT, 'src'),
                 '-isystem', '/usr/include/eigen3', source, '-o', program, '-L' + library, '-lhaptic_core', '-Wl,-rpath,' + library])
            for level, settings in (('default', {}), ('baseline', BASELINE)):
                results[processor, contraction, level] = dict(line.split() for line in run([program], **settings)[0].splitlines())
    reference = results['x86-64', 'off', 'baseline']
    figure('foreign_march_bits_differ', sum(differing(reference, found, ', '.join(key)) for key, found in results.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n', maxsplit=1)[0])
    parser.add_argument('--build', required=True, help='build folder of the core and its benchmarks')
    parser.add_argument('--stack', required=True, help='build folder of the stack')
    parser.add_argument('--bag', required=True, help='a recording of it')
    parser.add_argument('--before', required=True, help='sources of the release with one library per build')
    parser.add_argument('--before-build', required=True, help='its build for x86-64-v3')
    options = parser.parse_args()
    library = os.path.dirname(os.path.realpath(find(options.build, 'libhaptic_core.so')))
    _, said = run([find(options.build, 'bench_dispatch'), '--version'])
    v3_here = 'library x86-64-v3' in said
    bits(options, library, v3_here)
    foreign(library)
    if v3_here:
        speed(options, library)
    else:
        print('note: this processor has no x86-64-v3: nothing to compare times with')


if __name__ == '__main__':
    main()

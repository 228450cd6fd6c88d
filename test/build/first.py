#!/usr/bin/python3
"""A user's first calls, on systems on which nothing was installed or called before (test/build/bare_call.sh).

    test/build/first.py ci            what .ci/run calls: the README's commands on one release, or on both where packages.apt, run, a verb or
                                      a CMakeLists.txt has changed within a day. Ends with `bare system: PASSED`, `FAILED` or `NOT RUN`
    test/build/first.py releases      which that are
    test/build/first.py [GROUP...]    figures first.*, of all groups or of: readme verbs tutorials wrong product interrupted deb

Calls whose time is a figure have the machine to themselves and a disk that keeps what it is told to; of all others those of the two
releases run side by side.
"""
import concurrent.futures
import os
import random
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, 'test', 'commands'))
from tutorial_pages import PAGES, blocks_of  # noqa: E402
BARE_CALL = os.path.join(ROOT, 'test', 'build', 'bare_call.sh')
SYSTEMS = os.path.join(ROOT, 'build', 'debian', 'systems')
RELEASES = ('bookworm', 'trixie')
CANNOT = 77
SHIPS = re.compile(r'^(packages\.apt|run|launch/verbs/.*|(.*/)?CMakeLists\.txt)$')  # changes that are tried on both releases
NETWORK, ALONE = 'network', 'alone'


class NotHere(Exception):
    """This machine cannot make a bare system."""


class System:
    """A bare system that keeps what its calls write, until it is removed. `timed`: its disk obeys fsync, as a user's does."""

    def __init__(self, release, name, timed=False, **environment):
        self.release, self.name, self.environment = release, f'{name}-{release}', environment
        if timed:
            self.environment = {**environment, 'HAPTIC_BARE_DISK': 'true'}
        self.remove()

    @property
    def written(self):
        return os.path.join(SYSTEMS, self.name, 'written')

    def remove(self):
        shutil.rmtree(os.path.join(SYSTEMS, self.name), ignore_errors=True)

    def start(self, command, reach=NETWORK, log=subprocess.PIPE):
        return subprocess.Popen([BARE_CALL, self.release, self.name, reach, 'sh', '-c', command], stdin=subprocess.DEVNULL,
                                stdout=log, stderr=subprocess.STDOUT, text=True, env={**os.environ, **self.environment})

    def call(self, command, reach=NETWORK):
        """Exit code, output, wall seconds, CPU seconds of all processes."""
        before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        process = self.start(command, reach)
        said, _ = process.communicate()
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if process.returncode == CANNOT:
            raise NotHere(said.strip().splitlines()[-1] if said.strip() else 'no reason given')
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return process.returncode, said, time.monotonic() - began, cpu

    def megabytes(self):
        """What the calls have written, by the blocks of the disk, without the clone of the sources."""
        listed = subprocess.run(['du', '-s', '-B1', self.written], capture_output=True, text=True, check=True).stdout
        clone = subprocess.run(['du', '-s', '-B1', '--exclude=build', os.path.join(self.written, 'haptics')], capture_output=True, text=True,
                               check=True).stdout
        return (int(listed.split()[0]) - int(clone.split()[0])) / 1e6


def figure(name, value, unit='1'):
    print(f'figure {name} {value:.6g} {unit}', flush=True)


def tell(line):
    print(line + '\n', end='', flush=True)  # at once: releases tell side by side


class Totals:
    """How each call ended, and the figures of one release."""

    def __init__(self):
        self.right, self.figures = [], {}

    def add(self, name, release, value, unit):
        self.figures.setdefault((name, unit), []).append(value)
        figure(f'first.{name}_{release}', value, unit)


def on_both(function, totals):
    """`function(release, totals)` of both releases, side by side; its results."""
    with concurrent.futures.ThreadPoolExecutor(len(RELEASES)) as pool:
        return list(pool.map(lambda release: function(release, totals), RELEASES))


def failed(what, said, code):
    tell(f'FAILED with exit code {code}: {what}\n' + '\n'.join(f'    {line}' for line in said.splitlines()[-15:]))


# What the README says first, and what follows from it without a network.
def readme_calls():
    return (('./run demo --seconds 2', NETWORK), ("./run test '^core_base$'", NETWORK), ('./run demo --seconds 2 --record first.bag', NETWORK),
            ('./run replay first.bag', ALONE), ('./run demo --seconds 2', ALONE))


def releases_of_commit():
    """One by the parity of the commit's hash; both, that one first, where what ships has changed within a day before it."""
    def git(*words):
        return subprocess.run(['git', '-c', 'safe.directory=*', '-C', ROOT, *words], capture_output=True, text=True, check=True).stdout
    day = int(git('log', '-1', '--format=%ct').strip()) - 86400
    first = int(git('rev-parse', 'HEAD').strip()[-1], 16) % 2
    changed = set(git('log', f'--since=@{day}', '--name-only', '--format=').split('\n'))
    if any(SHIPS.match(name) for name in changed):
        return RELEASES[first], RELEASES[1 - first]
    return (RELEASES[first],)


def cache_of(release):
    """The compiler's cache of this machine, where a system of its release would compile once more what was compiled here."""
    with open('/etc/os-release', encoding='utf-8') as file:
        if f'VERSION_CODENAME={release}\n' not in file.read() or not shutil.which('ccache'):
            return {}
    folder = subprocess.run(['ccache', '--get-config', 'cache_dir'], capture_output=True, text=True, check=True).stdout.strip()
    return {'HAPTIC_BARE_CACHE': folder} if os.path.isdir(folder) else {}


def ci_release(release, tests):
    """The README's commands on a system of `release`, up to the first that fails."""
    system = System(release, 'ci', **cache_of(release))
    for command, reach in readme_calls():
        if 'test' in command and not tests:
            continue  # the tests' packages and their compilation once: CI has its time
        code, said, wall, _ = system.call(command, reach)
        tell(f'{release}: {command}: exit code {code} after {wall:.0f} s')
        if code:
            failed(command, said, code)
            return False
    system.remove()
    return True


def ci():
    releases = releases_of_commit()
    try:
        with concurrent.futures.ThreadPoolExecutor(len(releases)) as pool:
            right = all(pool.map(ci_release, releases, (True, False)))
    except NotHere as reason:
        tell(f'bare system: NOT RUN ({reason})')
        return 0
    tell(f'bare system: {"PASSED" if right else "FAILED"} ({", ".join(releases)})')
    return 0 if right else 1


def shared_cache(release):
    """A compiler's cache of all systems of a release but those whose demo is timed: hours of compiling would tell nothing more."""
    folder = os.path.join(ROOT, 'build', 'debian', f'ccache-{release}')
    os.makedirs(folder, exist_ok=True)
    return {'HAPTIC_BARE_CACHE': folder}


def keep(folder, place):
    """A copy of what a call has made, if it has."""
    if os.path.isdir(folder):
        shutil.copytree(folder, place, dirs_exist_ok=True)


ESTIMATE = re.compile(r'setup: installs (\d+) Debian packages: (\d+) MB to fetch, with the build about (\d+) MB to write \(\d+ MB are free\) '
                      r'in about (\d+) (s|min)')


def fetched(system):
    """Megabytes that apt fetched, by its own words."""
    total = 0
    for name in ('packages.log', 'setup.log'):
        path = os.path.join(system.written, 'haptics', 'build', 'log', name)
        if os.path.exists(path):
            with open(path, encoding='utf-8', errors='replace') as file:
                for number, unit in re.findall(r'^Fetched ([\d.,]+) (k?M?G?B) in', file.read(), re.M):
                    total += float(number.replace(',', '')) * {'B': 1e-6, 'kB': 1e-3, 'MB': 1, 'GB': 1e3}[unit]
    return total


def packages_that_came(system):
    """By name, dpkg's fields of what the calls have installed."""
    def installed(path):
        with open(path, encoding='utf-8') as file:
            for paragraph in file.read().split('\n\n'):
                fields = dict(re.findall(r'^([A-Za-z-]+): (.*)$', paragraph, re.M))
                if fields.get('Status', '').endswith(' installed'):
                    yield fields['Package'], fields
    status = os.path.join('var', 'lib', 'dpkg', 'status')
    before = dict(installed(os.path.join(ROOT, 'build', 'debian', system.release, status)))
    return {name: fields for name, fields in installed(os.path.join(system.written, status)) if name not in before}


def large_packages(came):
    """Those above 5 MB, largest first, each with those that depend on it."""
    for name, fields in sorted(came.items(), key=lambda item: -int(item[1].get('Installed-Size', 0))):
        if int(fields.get('Installed-Size', 0)) > 5000:
            users = [user for user, other in came.items() if re.search(rf'(^|[ ,|]){re.escape(name)}([ ,:|]|$)', other.get('Depends', ''))]
            yield int(fields['Installed-Size']) / 1000, name, users


def first_demo(release, totals):
    """The README's first command, and what it costs."""
    system = System(release, 'demo', timed=True)
    code, said, wall, cpu = system.call('./run demo --seconds 2')
    totals.right.append(code == 0)
    if code:
        failed(f'{release}: ./run demo --seconds 2', said, code)
        return system
    wrote, came = system.megabytes(), packages_that_came(system)
    count, _, size, time_said, unit = ESTIMATE.search(said).groups()
    seconds = float(time_said) * (60 if unit == 'min' else 1)
    off = max(abs(seconds - wall) / wall, abs(float(size) - wrote) / wrote) * 100
    for name, value, unit in (('demo_s', wall, 's'), ('demo_cpu_s', cpu, 's'), ('packages', len(came), '1'), ('fetched_mb', fetched(system), 'MB'),
                              ('written_mb', wrote, 'MB'), ('estimate_off_pct', off, '%')):
        totals.add(name, release, value, unit)
    tell(f'    said {count} packages, {size} MB, {seconds:.0f} s; it wrote {wrote:.0f} MB and took {wall:.0f} s. Above 5 MB:')
    for megabytes, name, users in large_packages(came):
        tell(f'    {megabytes:6.1f} MB {name} <- {" ".join(users[:4])}')
    return system


def first_test(release, totals):
    system = System(release, 'test', **shared_cache(release))
    run(totals, system, './run test')
    if not totals.right[-1]:  # of which test said what
        keep(os.path.join(system.written, 'haptics', 'build', 'Testing'), os.path.join(ROOT, 'build', 'log', f'first-{release}'))
    system.remove()


HAS_DEMO = {}  # systems that have had the README's first command
PACKAGES = {}  # folders of the packages that `./run package` has made on a bare system


def readme(totals):
    """Each of the README's two commands begins on a system of its own. What the demo compiled is in the cache of all that comes later."""
    for release in RELEASES:
        system = HAS_DEMO[release] = first_demo(release, totals)
        keep(os.path.join(system.written, 'root', '.cache', 'ccache'), shared_cache(release)['HAPTIC_BARE_CACHE'])
        system.environment = shared_cache(release)
        for command, reach in readme_calls()[2:]:
            run(totals, system, command, reach)
    on_both(first_test, totals)
    for (name, unit), values in totals.figures.items():
        figure(f'first.{name}', max(values), unit)


def run(totals, system, command, reach=NETWORK, wanted=0):
    code, said, wall, _ = system.call(command, reach)
    totals.right.append(code == wanted)
    tell(f'{system.release}: {command}: exit code {code} after {wall:.0f} s')
    if code != wanted:
        failed(f'{system.release}: {command}', said, code)
    return said


# One call of each verb of the README's table, with the arguments of its first example; hardware excepted.
VERBS = ('./run check touch_cube', './run check spidar_g6x3r', './run check friction', './run demo --emulate --device uart --seconds 2',
         # (Systems that run side by side share the machine's sockets: each has a display of its own.)
         'apt-get install -y --no-install-recommends xvfb xauth >/dev/null; . /etc/os-release; '
         'xvfb-run -n 1$VERSION_ID ./run demo --rviz --seconds 3',
         './run demo --seconds 2 --record a.bag', './run latency --device spidar_g6x3r --transport twin --seconds 1', './run replay a.bag',
         './run report a.bag', './run export a.bag --mcap', './run experiment friction --power', './run version', './run bench python',
         './run build', './run package', './run docs', './run report rest --quick')


def verbs_of(release, totals):
    system = HAS_DEMO.pop(release, None) or System(release, 'verbs', **shared_cache(release))
    for command in VERBS:
        run(totals, system, command)
    for name in sorted(name[:-3] for name in os.listdir(os.path.join(ROOT, 'launch', 'verbs')) if name.endswith('.sh')):
        run(totals, system, f'./run {name} --help', ALONE)
    keep_packages(system)
    system.remove()


def verbs(totals):
    on_both(verbs_of, totals)


def keep_packages(system):
    PACKAGES[system.release] = os.path.join(ROOT, 'build', 'debian', f'packages-{system.release}')
    shutil.rmtree(PACKAGES[system.release], ignore_errors=True)
    keep(os.path.join(system.written, 'haptics', 'build', 'packages'), PACKAGES[system.release])


def tutorials_of(release, totals):
    """In the order of their numbers, on a machine that has built nothing."""
    system = System(release, 'tutorials', **shared_cache(release))
    for page in PAGES:
        for block in blocks_of(page):
            if block['file']:
                system.call(f"cat >'{block['file']}' <<'end-of-the-block'\n{block['text']}end-of-the-block\n", ALONE)
            elif block['language'] == 'sh':
                run(totals, system, block['text'])
    system.remove()


def tutorials(totals):
    on_both(tutorials_of, totals)


WRONG = ('demo --scene nosuch', 'demo --scene no/such.urdf', 'demo --rate fast', 'demo --seconds -1', 'demo --port /dev/nosuch', 'demo --record /no/such/x.bag',
         'demo --missing-meshes some', 'demo --nosuch', 'check nosuch', 'check touch_cube --rate x', 'check touch_cube --device nosuch', 'replay nosuch.bag',
         'replay README.md', 'report nosuch.bag', 'report nosuch', 'report rest --scheduler nowhere', 'export nosuch.bag', 'export README.md',
         'experiment nosuch --subject a', 'experiment friction --subject a/b', 'experiment friction', 'analyse /tmp', 'latency --device nosuch',
         'latency --device spidar_g6x3r --seconds x', 'bench nosuch', 'bench --before /no/such house', 'test (', 'test --sanitize nosuch', 'test a b',
         'setup nosuch', 'docs nosuch', 'package nosuch', 'build nosuch', 'stop a b', 'nosuch', 'demo --scene ./README.md', 'demo --device ',
         'demo --device ./packages.apt', 'demo --xacro a', 'demo --emulate --hardware --device uart', 'demo --master-port 80', 'version now',
         'check ./README.md', 'report ./packages.apt', 'experiment ./packages.apt --subject a')


def wrong(totals):
    worst = 0
    for release in RELEASES:
        system = System(release, 'wrong')
        for words in WRONG:
            call = ' '.join(map(shlex.quote, ['./run'] + words.split(' ')))
            _, said, _, _ = system.call(f'began=$(date +%s%N); {call}; code=$?; echo "took $(($(date +%s%N) - began)) $code"', ALONE)
            took, code = re.search(r'^took (\d+) (\d+)$', said, re.M).groups()
            lines = [line for line in said.splitlines() if line.startswith('run: ')]
            totals.right.append(code != '0' and len(lines) == 1)
            if not totals.right[-1]:
                failed(f'{release}: ./run {words}', said, code)
            worst = max(worst, float(took) * 1e-9)
        system.remove()
    figure('first.wrong_call_s_max', worst, 's')


def demo_time(release):
    """Seconds of a first demo: what an interruption may hit. Its objects fill the cache that all calls of this group share."""
    system = System(release, 'interrupted', **shared_cache(release))
    code, said, wall, _ = system.call('./run demo --seconds 2')
    if code:
        failed(f'{release}: ./run demo --seconds 2', said, code)
    return system, wall


def interrupted_of(release, totals, count=15):
    """Calls that are ended at instants uniform over the first demo; the same call must end well then, with no other command. They share
    the compiler's cache, or an hour of compiling would be spent on each dozen; set-up and unpacking are whole."""
    order, recovered = random.Random(f'60 {release}'), 0
    demo_time(release)
    system, wall = demo_time(release)  # the cache is filled
    for index in range(count):
        system.remove()
        word = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)[index % 3]
        after = order.uniform(0, wall)
        process = system.start(f'env --default-signal=INT,QUIT ./run demo --seconds 2 & call=$!; (sleep {after:.2f}; kill -{word.value} $call) & wait $call; sleep 1')
        said, _ = process.communicate()
        code, again, _, _ = system.call('./run demo --seconds 2')
        totals.right.append(code == 0)
        recovered += code == 0
        tell(f'{release}: {word.name} after {after:.1f} of {wall:.0f} s: the next call ended with {code}')
        if code:
            failed(f'{release}: ./run demo --seconds 2 after {word.name} at {after:.1f} s', said + again, code)
    system.remove()
    return recovered, count


def interrupted(totals):
    recovered, tried = (sum(column) for column in zip(*on_both(interrupted_of, totals)))
    figure('first.interrupted_tried', tried)
    figure('first.interrupted_recovers', recovered)


def product(totals):
    """Every call by every caller, with every machine, from every place: programs in front of the path stand for apt (first_call_test.py)."""
    done = subprocess.run([sys.executable, '-B', os.path.join(ROOT, 'test', 'commands', 'first_call_test.py'), 'Product.test_all'],
                          env={**os.environ, 'HAPTIC_FIRST_PRODUCT': '1'}, capture_output=True, text=True, check=False)
    tell(done.stdout.strip())
    totals.right.append(done.returncode == 0)
    if done.returncode:
        failed('product of first calls', done.stderr, done.returncode)


def deb_of(release, totals):
    if release not in PACKAGES:
        maker = System(release, 'deb', **shared_cache(release))
        run(totals, maker, './run package')
        keep_packages(maker)
        maker.remove()
    done = subprocess.run([os.path.join(ROOT, 'test', 'package', 'install.sh'), '--release', release, '--packages', PACKAGES[release]],
                          capture_output=True, text=True, check=False)
    tell(f'{release}: packages installed and run: exit code {done.returncode}')
    if done.returncode:
        failed(f'{release}: install.sh', done.stdout + done.stderr, done.returncode)
    return done.returncode == 0


def deb(totals):
    """From packages alone: made on one bare system, installed on another that has neither compiler nor checkout."""
    figure('first.deb_demo', int(all(on_both(deb_of, totals))))


GROUPS = {'readme': readme, 'verbs': verbs, 'tutorials': tutorials, 'wrong': wrong, 'product': product, 'interrupted': interrupted, 'deb': deb}


def main(words):
    if words == ['ci']:
        return ci()
    if words == ['releases']:
        print(*releases_of_commit())
        return 0
    unknown = [word for word in words if word not in GROUPS]
    if unknown:
        print(f"first.py: unknown group '{unknown[0]}'; there are: {' '.join(GROUPS)}", file=sys.stderr)
        return 2
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job has it ignored, and so would all that is called
    totals = Totals()
    try:
        for name in words or GROUPS:
            began = time.monotonic()
            GROUPS[name](totals)
            tell(f'{name}: {time.monotonic() - began:.0f} s')
    except NotHere as reason:
        tell(f'bare system: NOT RUN ({reason})')
        return 1
    for system in HAS_DEMO.values():
        system.remove()
    figure('first.commands', len(totals.right))
    figure('first.commands_failed', totals.right.count(False))
    return 0 if all(totals.right) else 1


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))

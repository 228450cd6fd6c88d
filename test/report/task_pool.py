"""Runs programs as tasks, several at once, and keeps what they print: here or on the workers of a Dask cluster.

A finished task is kept in a file named by its key and never run again. A task whose process is killed by a signal (a
worker that died) is repeated; one that fails by itself, by exit code or by exceeding its CPU time, is a result.
"""
import collections
import concurrent.futures
import hashlib
import json
import os
import resource
import signal
import subprocess
import sys
import threading
import time

Task = collections.namedtuple('Task', 'key command cpu_limit weight')
Task.__doc__ = '''One process: `command` with at most `cpu_limit` seconds of CPU time. `weight`: expected cost, for the
time that is left.'''

REPEATS = 2  # times that a task is run again after its process was killed from outside


def key_of(*parts):
    """Name of a task's file: the same parts give the same name, on every machine."""
    return hashlib.sha1('\x1f'.join(str(p) for p in parts).encode()).hexdigest()[:20]


def file_stamp(*paths):
    """Hash of the contents of files: of programs, so that a new build is measured again, and of scenes."""
    digest = hashlib.sha1()
    for path in paths:
        with open(path, 'rb') as file:
            digest.update(file.read())
    return digest.hexdigest()[:16]


def stamp_of(*programs):
    """Changes when a program or a library of ours that it uses does."""
    libraries = set()
    for path in programs:
        listed = subprocess.run(['ldd', path], capture_output=True, text=True, check=False).stdout
        libraries |= {line.split('=>')[1].split('(')[0].strip() for line in listed.splitlines()
                      if 'libhaptic' in line or 'libpenalty' in line}
    return file_stamp(*programs, *sorted(libraries))


RUNNING = set()  # processes of this one, to be ended with it
ENDING = threading.Event()  # they are being ended: a process that is killed now is not repeated


def run_task(command, cpu_limit):
    """Runs one process and returns a dictionary: output, error, code, seconds. Works on any machine."""
    def limit():
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (int(cpu_limit), int(cpu_limit) + 5))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    start = time.time()
    try:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=limit,
                                   stdin=subprocess.DEVNULL)
        RUNNING.add(process)
        try:
            # A process that waits for ever uses no CPU time: 20 times its limit is more than a busy machine needs.
            output, error = process.communicate(timeout=20 * cpu_limit + 60)
            result = {'output': output, 'error': error[-2000:], 'code': process.returncode}
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            result = {'output': '', 'error': 'the process hung', 'code': -signal.SIGXCPU}
        finally:
            RUNNING.discard(process)
    except OSError as error:
        result = {'output': '', 'error': f'{command[0]}: {error.strerror}', 'code': 127}
    result['seconds'] = time.time() - start
    return result


def outcome(result, cpu_limit):
    """What went wrong with a task in one line; empty when nothing did."""
    code = result['code']
    if code == 0:
        return ''
    if code == -signal.SIGXCPU:
        return f'took more than {cpu_limit:g} s of CPU time'
    if code < 0:
        try:
            return f'killed by {signal.Signals(-code).name}'
        except ValueError:
            return f'killed by signal {-code}'
    lines = result['error'].strip().splitlines()
    return lines[-1] if lines else f'exit code {code}'


class Progress:
    """A bar with the time that is left, on standard error; without a terminal a line every ten seconds."""

    def __init__(self, title, total, stream=None):
        self.title, self.total, self.done, self.count = title, max(total, 1e-9), 0.0, 0
        self.start, self.stream, self.shown = time.time(), stream or sys.stderr, time.time()

    def advance(self, weight, of):
        self.done += weight
        self.count += 1
        now = time.time()
        if now - self.shown < (0.2 if self.stream.isatty() else 10) and self.count < of:
            return
        self.shown = now
        share = min(1.0, self.done / self.total)
        left = (now - self.start) * (1 - share) / share if share > 0 else 0
        bar = '=' * round(30 * share)
        text = f'{self.title} [{bar:<30}] {self.count}/{of}, {100 * share:3.0f} %, {left:.0f} s left'
        self.stream.write('\r\033[K' + text if self.stream.isatty() else text + '\n')
        self.stream.flush()

    def close(self):
        if self.stream.isatty():
            self.stream.write('\r\033[K')
            self.stream.flush()


class Kept:
    """Results on disk, one file per task, written whole or not at all."""

    def __init__(self, folder):
        self.folder = folder
        os.makedirs(folder, exist_ok=True)

    def path(self, key):
        return os.path.join(self.folder, key + '.json')

    def load(self, key):
        try:
            with open(self.path(key)) as file:
                return json.load(file)
        except (OSError, ValueError):
            return None

    def save(self, key, result):
        part = self.path(key) + f'.{os.getpid()}.{threading.get_ident()}'
        with open(part, 'w') as file:
            json.dump(result, file)
        os.replace(part, self.path(key))


def run_tasks(tasks, kept, title='', scheduler=None, workers=None):
    """Results by key. Runs what `kept` does not have: here on `workers` processes, or on the cluster at `scheduler`."""
    results = {}
    waiting = []
    for task in {t.key: t for t in tasks}.values():
        result = kept.load(task.key)
        if result is None:
            waiting.append(task)
        else:
            results[task.key] = result
    if not waiting:
        return results
    # Long ones first: at the end no process waits for one that began last.
    waiting.sort(key=lambda task: -task.weight)
    progress = Progress(title, sum(task.weight for task in waiting))
    finished = _on_cluster(waiting, scheduler) if scheduler else _here(waiting, workers or os.cpu_count())
    for task, result in finished:
        result['failure'] = outcome(result, task.cpu_limit)
        kept.save(task.key, result)
        results[task.key] = result
        progress.advance(task.weight, len(waiting))
    progress.close()
    return results


def run_repeatedly(command, cpu_limit):
    """`run_task`, repeated when the process was killed, for that says nothing about the task."""
    for attempt in range(1 + REPEATS):
        result = run_task(command, cpu_limit)
        result['attempts'] = attempt + 1
        if ENDING.is_set() or result['code'] >= 0 or result['code'] in (-signal.SIGXCPU, -signal.SIGABRT, -signal.SIGSEGV, -signal.SIGFPE):
            break
    return result


def _here(tasks, workers):
    ENDING.clear()
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        running = {pool.submit(run_repeatedly, list(t.command), t.cpu_limit): t for t in tasks}
        try:
            for future in concurrent.futures.as_completed(running):
                yield running[future], future.result()
        except BaseException:
            ENDING.set()
            for future in running:
                future.cancel()
            for process in list(RUNNING):
                process.kill()
            raise


def _on_cluster(tasks, scheduler):
    """The workers run the same programs under the same paths (a shared folder, or the same machine)."""
    import distributed
    client = distributed.Client(scheduler, timeout='10s')
    try:
        client.upload_file(os.path.abspath(__file__))
        running = {}
        for task in tasks:
            # The priority keeps the order; a task whose worker dies goes to another one (3 times at most).
            running[client.submit(run_repeatedly, list(task.command), task.cpu_limit, key='report-' + task.key,
                                  pure=False, priority=task.weight)] = task
        for future in distributed.as_completed(list(running)):
            if future.status == 'finished':
                yield running[future], future.result()
            else:
                yield running[future], {'output': '', 'error': f'worker lost: {future.exception()}', 'code': 1,
                                        'seconds': 0.0}
    finally:
        client.close()


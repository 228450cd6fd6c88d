"""Where a subject is asked and an experimenter steers: a terminal, or windows (windows.py). All speak in events: (kind, value) with
kinds answer, begin, pause, skip, repeat, abort, stop, calibrate and note. STOP does not wait for the session's thread, which may be busy."""
import os
import queue
import select
import shutil
import subprocess
import sys
import tempfile
import threading
import wave

WORDS = {'p': 'pause', 's': 'skip', 'r': 'repeat', 'q': 'abort', 'c': 'calibrate'}  # and x: STOP


class Front:
    """Shows nothing: for simulated subjects."""

    def __init__(self):
        self.events = queue.Queue()
        self.on_stop = lambda: None     # ends all force
        self.status = lambda: ''        # one line for the experimenter: device, force, time left

    def stop(self):
        """STOP by a key or button: the force ends and both sides see it at once; the session hears of it as an event."""
        threading.Thread(target=self.on_stop, daemon=True).start()
        self.state('STOP: the force is off', 'the experimenter goes on: Pause, or Space in the other window')
        self.events.put(('stop', ''))

    def state(self, text, detail=''):
        """To both at once, until the next one: what holds the session, and what ends it. Empty: it goes on."""

    def show(self, text, detail=''):
        """To the subject."""

    def progress(self, done, total, now, after):
        """To the experimenter: trials done of how many, this condition, and the next."""

    def tell(self, line):
        """To the experimenter: one line that matters."""
        print(f'experiment: {line}', file=sys.stderr, flush=True)

    def ask(self, question, answers):
        """Shows the question; the answer comes as an event."""

    def tone(self):
        """At each start of an interval."""

    def questionnaire(self, questions):
        """Answers by name; nothing is asked of a simulated subject."""
        return {}

    def run(self, work):
        """Runs the session and returns its exit code."""
        return work()


class Tone:
    """A short tone through the system's player, if there is one."""

    def __init__(self):
        self.player = next((found for found in map(shutil.which, ('pw-play', 'paplay', 'aplay')) if found), None)
        self.file = None
        if self.player:
            self.file = tempfile.NamedTemporaryFile(suffix='.wav')  # pylint: disable=consider-using-with
            with wave.open(self.file.name, 'wb') as sound:
                sound.setparams((1, 2, 8000, 0, 'NONE', ''))
                # 500 Hz for 0.1 s: a square wave of eight samples up and eight down, quiet.
                sound.writeframes((b'\x00\x08' * 8 + b'\x00\xf8' * 8) * 50)

    def play(self):
        if self.player:
            subprocess.Popen([self.player, self.file.name], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                             stdin=subprocess.DEVNULL, start_new_session=True)


class TerminalFront(Front):
    """One line a thing, answers from the keyboard: 1, 2, a number, or a letter of WORDS."""

    def __init__(self):
        super().__init__()
        self.sound, self.open = Tone(), True
        threading.Thread(target=self._read, daemon=True).start()
        print('keys, each with Enter: Enter alone begins; 1 or 2 or a number answers; p pause and go on, s skip, r repeat, x STOP, c calibrate, q end, '
              'n TEXT a note')

    def _read(self):
        rest = b''
        while self.open:
            if not select.select([0], [], [], 0.2)[0]:
                continue
            read = os.read(0, 4096)  # readline would keep a second line where select does not see it
            if not read:
                self.events.put(('begin', ''))  # without a keyboard no key can come
                return
            *lines, rest = (rest + read).split(b'\n')
            for line in lines:
                self._heed(line.decode('utf-8', 'replace').strip())

    def _heed(self, word):
        if word.startswith('n '):
            self.events.put(('note', word[2:]))
        elif word == 'x':
            self.stop()
        elif word in WORDS:
            self.events.put((WORDS[word], ''))
        else:
            self.events.put(('answer', word) if word else ('begin', ''))

    def state(self, text, detail=''):
        if text:
            self.show(text, detail)
            self.tell(f'{text}; {detail}' if detail else text)

    def show(self, text, detail=''):
        print(text + (f'  ({detail})' if detail else ''), flush=True)

    def progress(self, done, total, now, after):
        print(f'[{done + 1} of {total}] {now}', file=sys.stderr, flush=True)

    def ask(self, question, answers):
        choices = ', '.join(f'{i + 1}: {a}' for i, a in enumerate(answers)) or 'a number'
        self.show(f'{question} ({choices})')

    def tone(self):
        self.sound.play()

    def questionnaire(self, questions):
        answers = {}
        for question in questions:
            print(question['text'] + (f" ({', '.join(question['choices'])})" if question['choices'] else ''), flush=True)
            answers[question['name']] = self.events.get()[1]
        return answers

    def run(self, work):
        try:
            return work()
        finally:
            self.open = False

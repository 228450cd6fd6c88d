"""Two windows: the subject's, full screen, with text and the answers' keys; the experimenter's, with progress, buttons and notes. Where the
scene is shown (scene_view.py) it fills the subject's screen, and the text is a strip at its lower end that stays above it. The session runs in a thread of its own; what it says comes here as signals, what is pressed goes there as events."""
import os
import signal
import threading

from PyQt5.QtCore import QObject, Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QFont
from PyQt5.QtWidgets import (QApplication, QDialog, QFormLayout, QGridLayout, QComboBox, QLabel, QLineEdit, QPlainTextEdit, QProgressBar,
                             QPushButton, QVBoxLayout, QWidget)

from fronts import Front, Tone

SUBJECT_POINTS, EXPERIMENTER_WIDTH = 28, 460
STRIP_SHARE = 0.22   # of the subject's screen that the text takes, below the scene [1]
SPACE, STOP_HEIGHT, BUTTON_HEIGHT = 8, 44, 36       # [pixels]
BUTTONS_AT = 2 * SPACE + STOP_HEIGHT + BUTTON_HEIGHT // 2  # height of the buttons' middle in the experimenter's window
BUTTONS = (('Begin, pause', 'pause'), ('Repeat', 'repeat'), ('Skip', 'skip'), ('Calibrate', 'calibrate'), ('End', 'abort'))


class Said(QObject):
    """What the session's thread says, delivered in the windows' thread."""
    text = pyqtSignal(str, str)
    question = pyqtSignal(str, list)
    progress = pyqtSignal(int, int, str, str)
    line = pyqtSignal(str)
    state = pyqtSignal(str, str)
    ended = pyqtSignal(int)


class Banner(QLabel):
    """What holds the session, in a strip of its own colour above all else."""

    def __init__(self, points):
        super().__init__()
        self.setAlignment(Qt.AlignCenter)
        self.setWordWrap(True)
        self.setFont(QFont('Sans', points))
        self.setStyleSheet('background:#b00;color:white;font-weight:bold;padding:10px')
        self.hide()

    def say(self, text, detail):
        self.setText(f'{text}\n{detail}' if detail else text)
        self.setVisible(bool(text))


class SubjectWindow(QWidget):
    """Text in the middle; the question waits for a key: 1, 2, or a number and Enter."""

    def __init__(self, events, stop):
        super().__init__()
        self.events, self.stop, self.answers, self.asking, self.typed = events, stop, [], False, ''
        self.banner = Banner(SUBJECT_POINTS)
        self.setWindowTitle('study')
        self.setStyleSheet('background:#111;color:#eee')
        self.text, self.detail = QLabel(), QLabel()
        for label, points in ((self.text, SUBJECT_POINTS), (self.detail, SUBJECT_POINTS // 2)):
            label.setAlignment(Qt.AlignCenter)
            label.setWordWrap(True)
            label.setFont(QFont('Sans', points))
        layout = QVBoxLayout(self)
        layout.addWidget(self.banner)
        layout.addStretch()
        layout.addWidget(self.text)
        layout.addWidget(self.detail)
        layout.addStretch()

    def show_text(self, text, detail):
        self.asking = False
        self.text.setText(text)
        self.detail.setText(detail)

    def ask(self, question, answers):
        self.answers, self.asking, self.typed = answers, True, ''
        self.text.setText(question)
        self.detail.setText('     '.join(f'{i + 1}: {answer}' for i, answer in enumerate(answers)) or 'type a number, then Enter')

    def keyPressEvent(self, event):  # noqa: N802 (Qt's name)
        if event.key() == Qt.Key_Escape:
            self.stop()
        elif not self.asking and event.key() in (Qt.Key_Space, Qt.Key_Return, Qt.Key_Enter):
            self.events.put(('begin', ''))
        elif self.asking and self.answers and event.text() in ('1', '2'):
            self.asking = False
            self.events.put(('answer', event.text()))
        elif self.asking and not self.answers:
            self.type_number(event)

    def type_number(self, event):
        if event.key() in (Qt.Key_Return, Qt.Key_Enter):
            if self.typed:
                self.asking = False
                self.events.put(('answer', self.typed))
            return
        if event.key() == Qt.Key_Backspace:
            self.typed = self.typed[:-1]
        elif event.text() and event.text() in '0123456789.':
            self.typed += event.text()
        self.detail.setText(self.typed or 'type a number, then Enter')


class ExperimenterWindow(QWidget):
    def __init__(self, events, stop):
        super().__init__()
        self.events, self.stop = events, stop
        self.banner, self.status = Banner(14), QLabel()
        self.status.setWordWrap(True)
        self.setWindowTitle('experimenter')
        self.setMinimumWidth(EXPERIMENTER_WIDTH)
        self.bar, self.now, self.after, self.lines, self.note = QProgressBar(), QLabel('starting'), QLabel(), QPlainTextEdit(), QLineEdit()
        self.seen = QLabel()  # the text that the subject reads
        self.seen.setWordWrap(True)
        self.lines.setReadOnly(True)
        self.lines.setFocusPolicy(Qt.NoFocus)
        self.note.setFocusPolicy(Qt.ClickFocus)  # else the keys are the window's
        self.setFocusPolicy(Qt.StrongFocus)
        self.note.setPlaceholderText('a note for this trial, then Enter')
        self.note.returnPressed.connect(self.take_note)
        button = QPushButton('STOP (Esc)')
        button.setStyleSheet('background:#b00;color:white;font-weight:bold;padding:10px')
        button.setFocusPolicy(Qt.NoFocus)  # Space goes on; it must not stop
        button.clicked.connect(lambda: stop())
        button.setFixedHeight(STOP_HEIGHT)
        layout = QGridLayout(self)
        layout.setContentsMargins(SPACE, SPACE, SPACE, SPACE)
        layout.setSpacing(SPACE)
        layout.addWidget(button, 0, 0, 1, len(BUTTONS))
        layout.addWidget(self.bar, 2, 0, 1, len(BUTTONS))
        layout.addWidget(self.now, 3, 0, 1, len(BUTTONS))
        layout.addWidget(self.after, 4, 0, 1, len(BUTTONS))
        for column, (text, kind) in enumerate(BUTTONS):
            button = QPushButton(text)
            button.setFocusPolicy(Qt.NoFocus)
            button.setFixedHeight(BUTTON_HEIGHT)
            button.clicked.connect(lambda _, kind=kind: events.put((kind, '')))
            layout.addWidget(button, 1, column)
        for row, widget in enumerate((self.status, self.seen, self.banner, self.note, self.lines), 5):
            layout.addWidget(widget, row, 0, 1, len(BUTTONS))

    def take_note(self):
        if self.note.text().strip():
            self.events.put(('note', self.note.text().strip()))
            self.lines.appendPlainText(f'note: {self.note.text().strip()}')
            self.note.clear()
        self.setFocus()

    def show_text(self, text, detail=''):
        self.seen.setText(f'the subject reads: {text}' + (f' ({detail})' if isinstance(detail, str) and detail else ''))

    def show_progress(self, done, total, now, after):
        self.bar.setRange(0, total)
        self.bar.setValue(done)
        self.bar.setFormat(f'%v of {total}')
        self.now.setText(f'now: {now}')
        self.after.setText(f'next: {after}' if after else '')

    def keyPressEvent(self, event):  # noqa: N802 (Qt's name)
        if event.key() == Qt.Key_Escape:
            self.stop()
        elif event.key() in (Qt.Key_Space, Qt.Key_Return, Qt.Key_Enter):
            self.events.put(('pause', ''))

    def closeEvent(self, event):  # noqa: N802 (Qt's name)
        self.events.put(('abort', ''))
        event.accept()


class Questionnaire(QDialog):
    """The study's own questions; closing it leaves them empty."""

    def __init__(self, questions):
        super().__init__()
        self.setWindowTitle('questionnaire')
        self.fields, layout = {}, QFormLayout(self)
        for question in questions:
            field = QComboBox() if question['choices'] else QLineEdit()
            if question['choices']:
                field.addItems([''] + question['choices'])
            self.fields[question['name']] = field
            layout.addRow(question['text'], field)
        done = QPushButton('Done')
        done.clicked.connect(self.accept)
        layout.addRow(done)

    def answers(self):
        return {name: field.currentText() if isinstance(field, QComboBox) else field.text() for name, field in self.fields.items()}


class WindowFront(Front):
    def __init__(self):
        super().__init__()
        self.scene = None  # a SceneView, set before `run`: the subject sees the scene
        self.application = QApplication.instance() or QApplication(['experiment'])
        self.sound, self.said, self.code = Tone(), Said(), 0
        self.subject, self.experimenter = SubjectWindow(self.events, self.stop), ExperimenterWindow(self.events, self.stop)
        self.said.text.connect(self.subject.show_text)
        self.said.question.connect(self.subject.ask)
        for said in (self.said.text, self.said.question):
            said.connect(self.experimenter.show_text)
        self.said.progress.connect(self.experimenter.show_progress)
        for window in (self.subject, self.experimenter):
            self.said.state.connect(window.banner.say)
        self.said.line.connect(self.experimenter.lines.appendPlainText)
        self.said.ended.connect(self.end)

    def show(self, text, detail=''):
        self.said.text.emit(text, detail)

    def ask(self, question, answers):
        self.said.question.emit(question, list(answers))

    def progress(self, done, total, now, after):
        self.said.progress.emit(done, total, now, after)

    def tell(self, line):
        super().tell(line)
        self.said.line.emit(line)

    def state(self, text, detail=''):
        self.said.state.emit(text, detail)

    def tone(self):
        self.sound.play()

    def questionnaire(self, questions):
        dialog = Questionnaire(questions)
        dialog.exec_()
        return dialog.answers()

    def run(self, work):
        """The session in a thread, the windows in this one. On a second screen the subject's window fills that."""
        screens = self.application.screens()
        if self.scene:
            self.show_scene(screens)
        else:
            self.subject.setGeometry(screens[-1].geometry())
            if os.environ.get('HAPTIC_STUDY_FULL_SCREEN', 'yes') == 'yes' and len(screens) > 1:
                self.subject.showFullScreen()
            else:
                self.subject.showMaximized()
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, lambda *_: self.events.put(('abort', '')))
        heed = QTimer()  # Python hears a signal only while it runs
        heed.timeout.connect(self.keep_keys)
        heed.timeout.connect(lambda: self.experimenter.status.setText(self.status()))
        heed.start(200)
        self.experimenter.show()
        self.experimenter.raise_()
        thread = threading.Thread(target=lambda: self.said.ended.emit(work()))
        thread.start()
        self.application.exec_()
        thread.join()
        if self.scene:
            self.scene.close()
        return self.code

    def show_scene(self, screens):
        """On a second screen the scene has that; on a single one the experimenter's window stands above it, at the right."""
        there = screens[-1].geometry()
        beside = EXPERIMENTER_WIDTH if len(screens) == 1 else 0
        strip = round(STRIP_SHARE * there.height())
        self.scene.start(there.x(), there.y(), there.width(), there.height())
        self.subject.setWindowFlags(Qt.Window | Qt.FramelessWindowHint | Qt.WindowStaysOnTopHint)
        self.subject.setGeometry(there.x(), there.y() + there.height() - strip, there.width() - beside, strip)
        self.subject.show()
        if beside:
            self.experimenter.setWindowFlags(Qt.Window | Qt.WindowStaysOnTopHint)
            self.experimenter.setGeometry(there.x() + there.width() - beside, there.y(), beside, there.height())

    def keep_keys(self):
        """The text stays above the scene, which comes later and takes no keys: where neither of these two has them, the subject's gets
        them back."""
        if not self.scene:
            return
        self.subject.raise_()
        if len(self.application.screens()) == 1:
            self.experimenter.raise_()
        if self.application.activeWindow() is None:
            self.subject.activateWindow()

    def end(self, code):
        self.code = code
        self.application.quit()

"""The scene as a subject sees it: rviz in a window of its own that fills a screen, without panels, menus, tools, forces or numbers."""
import os
import subprocess
import tempfile

from stack_rig import dies_with_parent

CONFIG = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), 'launch', 'rviz', 'study.rviz')


class SceneView:
    """One rviz. It outlives a stack that is started anew at another rate: its master stays."""

    def __init__(self, log):
        self.log, self.process = log, None
        self.folder = tempfile.TemporaryDirectory(prefix='haptic_view_')  # removed with this object

    def start(self, x, y, width, height):
        """On the screen that lies there [pixels]."""
        with open(CONFIG, encoding='utf-8') as file:
            text = file.read()
        path = os.path.join(self.folder.name, 'study.rviz')
        with open(path, 'w', encoding='utf-8') as file:
            file.write(text + f'  Height: {height}\n  Width: {width}\n  X: {x}\n  Y: {y}\n')
        with open(self.log, 'ab') as log:
            self.process = subprocess.Popen(['rviz', '-d', path, '--fullscreen', '__name:=subject_view'], stdin=subprocess.DEVNULL,
                                            stdout=log, stderr=log, preexec_fn=dies_with_parent)

    def close(self):
        if self.process and self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(5)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.folder.cleanup()

"""Motor boards in a process of their own, on a pseudo-terminal, for the tests of this folder."""
import os
import shutil
import signal
import subprocess
import tempfile

import rospkg
from topic_probe import program, wait_until


class EmulatedBoards:
    """The boards of `device`, with the twin's hand behind them; `close` ends them."""

    def __init__(self, device="spidar_g6x5r", hand="rest"):
        self.folder = tempfile.mkdtemp()
        self.port, self._control = os.path.join(self.folder, "boards"), os.path.join(self.folder, "control")
        file = os.path.join(rospkg.RosPack().get_path("haptic_description"), "devices", device + ".yaml")
        self._process = subprocess.Popen([program("spidar_driver", "spidar_board_emulator"), "--device", file, "--link", self.port,
                                          "--control", self._control, "--hand", hand], stdout=subprocess.PIPE, text=True)
        wait_until("the boards' port", lambda: os.path.exists(self.port) and os.path.exists(self._control))

    @property
    def process(self):
        """Its number, to stop it as hardware does not."""
        return self._process.pid

    def order(self, text):
        """One of the orders that `spidar_board_emulator --help` lists."""
        with open(self._control, "w", encoding="utf-8") as control:
            control.write(text + "\n")

    def drive(self):
        """"on" or "off": what the motors are told, by the emulator's own word."""
        self.order("drive")
        for line in self._process.stdout:
            if line.startswith("drive "):
                return line.split()[1]
        raise AssertionError("the emulator has ended")

    def driver_parameters(self):
        """Of a driver that is calibrated at home and enabled on these boards."""
        return {"transport": "file", "port": self.port, "calibrate_at_start": True, "enable_force_at_start": True}

    def close(self):
        self._process.send_signal(signal.SIGINT)
        self._process.communicate(timeout=10)
        shutil.rmtree(self.folder)

"""A study's loop as it runs on a device: the stack of demo.launch with its services, on the twin or on hardware. Programs that it
starts end with this one, however that ends."""
import ctypes
import os
import signal
import socket
import subprocess
import threading
import time

import numpy as np
import rospy
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import PoseStamped, WrenchStamped
from haptic_msgs.msg import DeviceState, StudyMarker, TickStatistics
from haptic_msgs.srv import LoadScene
from sensor_msgs.msg import Joy
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import InteractiveMarkerFeedback

import session_data
from presented import Samples
from strict_yaml import Refused
from trial_recorder import TrialRecorder

DEVICE = 'spidar'          # of demo.launch
START_PATIENCE = 120.0     # [s] for the stack to start
HAND_PERIOD = 0.01         # the simulated hand is led so often [s]
SOFT_START = 0.5           # ~soft_start of the bridge: the force is whole so long after it was let in [s]
FADE_PATIENCE = 10.0       # the loop fades by 10 N/s, in 0.5 s at least (loop/hand_settings.h) [s]
LOOK_PERIOD = 0.02         # at what is told every 10 or 100 ms [s]
TOUCH = 0.05               # a force below it does not count as touch [N]
DEATH_SIGNAL = 1           # PR_SET_PDEATHSIG of prctl(2)


class TrialEnded(Exception):
    """The trial cannot go on; `status` is what its row says."""

    def __init__(self, status, reason):
        super().__init__(reason)
        self.status, self.reason = status, reason


def dies_with_parent():
    os.setsid()
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # a shell's background job ignores it, and hands that on
    ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGINT)


def free_port():
    with socket.socket() as s:
        s.bind(('127.0.0.1', 0))
        return s.getsockname()[1]


class StackRig:
    def __init__(self, device, wire, log, program, port='', simulated=False):
        """`wire`: twin or file. `program`: session_table."""
        self.device, self.wire, self.log, self.program, self.port = device, wire, log, program, port
        self.simulated = simulated
        self.launch = self.recorder = self.client = None
        self.rate = 0
        self.pose = self.wrench = self.state = None
        self.statistics, self.compute_missed, self.presses, self.fade = [], 0, [], 0.0
        self.lock, self.faded = threading.Lock(), False
        self.on_answer = lambda word: None
        master = free_port()
        os.environ['ROS_MASTER_URI'] = f'http://127.0.0.1:{master}'
        self.master = self._start(['rosmaster', '--core', '-p', str(master)])
        self._wait(lambda: self._master_answers(master), 'the master did not start')
        rospy.init_node('experiment', disable_signals=True, log_level=rospy.ERROR)
        topic = '/' + DEVICE
        self.marker = rospy.Publisher('experiment/marker', StudyMarker, queue_size=100, tcp_nodelay=True)
        self.hand = rospy.Publisher(f'{topic}/hand/feedback', InteractiveMarkerFeedback, queue_size=1, tcp_nodelay=True)
        rospy.Subscriber(f'{topic}/pose', PoseStamped, self._on_pose, queue_size=1)
        rospy.Subscriber(f'{topic}/wrench', WrenchStamped, self._on_wrench, queue_size=1)
        rospy.Subscriber(f'{topic}/state', DeviceState, self._on_state, queue_size=10)
        rospy.Subscriber('/tick_statistics', TickStatistics, self._on_statistics, queue_size=10)
        rospy.Subscriber(f'{topic}/joy', Joy, self._on_joy, queue_size=10)
        rospy.Subscriber('joy', Joy, self._on_joy, queue_size=10)
        rospy.Subscriber('experiment/answer', String, lambda m: self.on_answer(m.data), queue_size=10)

    def _start(self, command):
        with open(self.log, 'ab') as log:
            return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, preexec_fn=dies_with_parent)

    @staticmethod
    def _master_answers(port):
        with socket.socket() as s:
            return s.connect_ex(('127.0.0.1', port)) == 0

    def _wait(self, ready, what, seconds=START_PATIENCE):
        end = time.monotonic() + seconds
        while not ready():
            if self.launch and self.launch.poll() is not None:
                raise Refused(f'{what}: {self._reason()}')
            if time.monotonic() > end:
                raise Refused(f'{what} within {seconds:.0f} s; see {self.log}')
            time.sleep(0.02)

    def _reason(self):
        """The line in which a node said why it ended."""
        with open(self.log, encoding='utf-8', errors='replace') as log:
            lines = [line for line in log if 'FATAL' in line]
        return lines[0].split(']: ')[-1].strip().replace('\x1b[0m', '') if lines else f'the stack ended; see {self.log}'

    def publish_marker(self, stamp, code, event, trial):
        message = StudyMarker(code=code, event=event, trial=trial)
        message.header.stamp = rospy.Time.from_sec(stamp)
        self.marker.publish(message)

    # From the stack.

    def _on_pose(self, message):
        self.pose = np.array([message.pose.position.x, message.pose.position.y, message.pose.position.z])

    def _on_wrench(self, message):
        self.wrench = np.array([message.wrench.force.x, message.wrench.force.y, message.wrench.force.z])

    def _on_state(self, message):
        self.state = message

    def _on_statistics(self, message):
        with self.lock:
            self.compute_missed += message.tick_us_max > 1e6 / message.rate
            if message.hands:
                hand = message.hands[0]
                self.fade = hand.fade
                self.statistics.append((message.header.stamp.to_sec(), hand.in_contact, hand.stiffness_share))

    def _on_joy(self, message):
        pressed = [i for i, b in enumerate(message.buttons) if b]
        for button in pressed:
            if button not in self.presses:
                self.on_answer(f'button {button}')
        self.presses = pressed

    # The loop.

    def start(self, scene, rate):
        """The stack at `rate`, with `scene` loaded and the force on."""
        self.stop_stack()
        self.state = self.pose = None
        self.recorder = TrialRecorder()
        arguments = {'scene': scene, 'device': self.device, 'transport': self.wire, 'rate': repr(float(rate)), 'port': self.port,
                     'hand': 'marker' if self.simulated or self.wire == 'twin' else 'script', 'rviz': 'false'}
        self.launch = self._start(['roslaunch', '--disable-title', '--skip-log-check', '--no-summary', 'haptic_bringup',
                                   'experiment.launch'] + [f'{name}:={value}' for name, value in arguments.items()])
        self._wait(lambda: self.recorder.wait_start(1) if self.recorder.count() else False, 'the loop did not start')
        rospy.wait_for_service('/simulation/load_scene', START_PATIENCE)
        self.client = Client('/bridge', timeout=START_PATIENCE)
        self.rate, self.faded = rate, False
        self._wait(lambda: self.state is not None, 'the device said nothing')  # of pose and wrench nothing before it is calibrated
        if self.wire == 'twin':
            self._wait(lambda: self.gives_force() and self.wrench is not None, 'the force did not come on')

    def stop_stack(self):
        for process in (self.launch,):
            if process and process.poll() is None:
                process.send_signal(signal.SIGINT)
                try:
                    process.wait(15)
                except subprocess.TimeoutExpired:
                    os.killpg(process.pid, signal.SIGKILL)
                    process.wait()
        self.launch = None
        if self.recorder:
            self.recorder.close()

    def close(self):
        self.stop_stack()
        if self.master.poll() is None:
            self.master.terminate()
            self.master.wait()

    def gives_force(self):
        return self.state is not None and self.state.state == DeviceState.ENABLED

    def check(self):
        """Raises TrialEnded when the device gives no force any more."""
        if self.launch is None or self.launch.poll() is not None:
            raise TrialEnded('interrupted', 'the stack ended')
        state = self.state
        if state is None or self.gives_force():
            return
        raise TrialEnded('unplugged' if state.state == DeviceState.DISCONNECTED else 'stopped', state.message)

    def load(self, scene, rate):
        """Another condition: nothing is felt while it changes."""
        if self.launch is None or rate != self.rate:
            self.start(scene, rate)
            return
        self.check()
        if self.force() > TOUCH:
            self.fade_out()
        before = self.recorder.count()
        answer = rospy.ServiceProxy('/simulation/load_scene', LoadScene)(scene)
        if not answer.success:
            raise Refused(answer.message)
        if not self.recorder.wait_start(before + 1):
            self.stop_stack()
            raise TrialEnded('interrupted', 'the loop did not go on after a condition was loaded: it is started anew')

    def force(self):
        return float(np.linalg.norm(self.wrench)) if self.wrench is not None else 0.0

    def fade_out(self):
        """The loop fades the force out, in steps of a tick that a hand does not feel. It stays out, whatever is loaded, until `fade_in`."""
        self.faded = True
        self.client.update_configuration({'silent': True})
        end = time.monotonic() + FADE_PATIENCE
        while self.fade > 0 and time.monotonic() < end:
            time.sleep(LOOK_PERIOD)

    def fade_in(self):
        """The soft start begins."""
        self.client.update_configuration({'silent': False})
        self.faded = False

    def whole_force(self):
        """The force back, once the hand touches nothing: then nothing changes with it."""
        if not self.faded:
            return
        self._wait(lambda: self.statistics and not self.statistics[-1][1], 'the hand did not leave what it touched')
        self.fade_in()
        time.sleep(SOFT_START)

    def stop(self):
        """STOP by the device's socket: no master is needed."""
        try:
            with socket.socket(socket.AF_UNIX) as s:
                s.settimeout(2)
                s.connect(self.state.stop_socket)
                s.recv(256)
        except (OSError, AttributeError):
            subprocess.run(['spidar_stop'], check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def calibrate(self):
        """The grip is held at home now; what the device says to it."""
        try:
            return rospy.ServiceProxy(f'/{DEVICE}/driver/calibrate', Trigger)().message
        except rospy.ServiceException as error:
            return str(error)

    def recover(self):
        """Force on again, where that is possible; says why not."""
        if self.launch is None or self.launch.poll() is not None:
            self.launch = None  # the next load starts it anew
            return ''
        try:
            for name, kind in (('recover', Trigger), ('enable_force', SetBool)):
                call = rospy.ServiceProxy(f'/{DEVICE}/driver/{name}', kind)
                answer = call(True) if kind is SetBool else call()
                if name == 'enable_force' and not answer.success:
                    return answer.message
            self._wait(lambda: self.state.state == DeviceState.ENABLED, 'the force did not come on', 5)
        except (rospy.ServiceException, Refused) as error:
            return str(error)
        return ''

    # The hand.

    def lead(self, position):
        """The simulated hand pulls the grip there [m in the base]."""
        feedback = InteractiveMarkerFeedback()
        feedback.header.frame_id, feedback.client_id, feedback.marker_name = f'{DEVICE}_base', 'experiment', 'hand'
        feedback.event_type = InteractiveMarkerFeedback.POSE_UPDATE
        p = feedback.pose
        p.position.x, p.position.y, p.position.z = (float(v) for v in position)
        p.orientation.w = 1.0
        self.hand.publish(feedback)

    def distance_home(self):
        return float(np.linalg.norm(self.pose)) if self.pose is not None else float('inf')

    # What was recorded.

    def samples(self, bag, windows):
        """Samples of each window (begin, end in ROS time) of a bag with a recording per window, and the replay's mismatches, lost
        ticks and mean delay [s]."""
        sessions = session_data.read(bag, self.program)
        with self.lock:
            looks = np.array(self.statistics, dtype=float).reshape(-1, 3)
        out, mismatches, lost = [], 0, 0
        for session in sessions:
            mismatches += int(session.info['mismatches'])
            lost += int(session.table['lost_periods'].sum())
        for (begin, end), session in zip(windows, sessions[-len(windows):]):
            table = session.table
            inside = (table['unix_time'] >= begin) & (table['unix_time'] <= end)
            column = lambda name, t=table, i=inside: np.array(t[f'{DEVICE}.{name}'][i])  # noqa: E731
            three = lambda name: np.stack([column(f'{name}_{axis}') for axis in 'xyz'], axis=1)  # noqa: E731
            near = looks[(looks[:, 0] >= begin) & (looks[:, 0] <= end) & (looks[:, 1] > 0)]
            time_s = np.array(table['time'][inside])
            share = np.interp(np.array(table['unix_time'][inside]), near[:, 0], near[:, 2]) if len(near) else np.ones(len(time_s))
            out.append(Samples(time_s, three('position'), three('achieved_force'), column('in_contact') > 0,
                               np.nan_to_num(column('flags')).astype(np.uint32), share, column('fade')))
        return out, mismatches, lost

#!/usr/bin/env python3
"""The three nodelets in one manager: every topic of the design with its units, frames and rates; services."""
import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TwistStamped, Vector3, Wrench, WrenchStamped
from haptic_msgs.msg import Contacts, DeviceState, ScenePlan, StepReport, TickStatistics
from haptic_msgs.srv import StateFile
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from topic_probe import Probe
from visualization_msgs.msg import MarkerArray


def norm(v):
    return (v.x ** 2 + v.y ** 2 + v.z ** 2) ** 0.5


class Session(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("session_test")

    def test_pose_twist_wrench(self):
        pose = Probe("/spidar/pose", PoseStamped)
        twist = Probe("/spidar/twist", TwistStamped)
        wrench = Probe("/spidar/wrench", WrenchStamped)
        message = pose.wait(200)
        self.assertEqual(message.header.frame_id, "spidar_base")
        self.assertLess(abs((rospy.Time.now() - message.header.stamp).to_sec()), 60)  # another clock is off by years
        self.assertLess(norm(message.pose.position), 0.1)  # metres: millimetres would be tens
        q = message.pose.orientation
        self.assertAlmostEqual(q.x ** 2 + q.y ** 2 + q.z ** 2 + q.w ** 2, 1.0, places=9)
        self.assertEqual(twist.wait(10).header.frame_id, "spidar_base")
        self.assertLess(norm(twist.wait(10).twist.linear), 2.0)  # the hand moves at some cm/s
        self.assertEqual(wrench.wait(10).header.frame_id, "spidar_base")
        self.assertLess(norm(wrench.wait(10).wrench.force), 10.5)  # the device's clamp
        stamps = [m.header.stamp.to_sec() for m in pose.messages]
        self.assertTrue(all(b > a for a, b in zip(stamps, stamps[1:])), "stamps rise")
        # Every second tick of 1 ms; the median, for a machine that stalls now and then loses ticks.
        median = sorted(b - a for a, b in zip(stamps, stamps[1:]))[len(stamps) // 2]
        self.assertAlmostEqual(median, 1 / 500, delta=5e-4)

    def test_joint_states(self):
        message = Probe("/spidar/joint_states", JointState).wait(20)
        self.assertEqual(message.name, [f"string_{i}" for i in range(8)])
        for length, tension in zip(message.position, message.effort):
            self.assertTrue(0.03 < length < 0.3, f"{length} m")      # the frame's half diagonal is 0.114 m
            self.assertTrue(0.3 - 1e-9 <= tension <= 20 + 1e-9, f"{tension} N")  # the device file's bounds
        self.assertEqual(len(message.velocity), 8)

    def test_device_state(self):
        message = Probe("/spidar/state", DeviceState).wait(1, accept=lambda m: m.claimed)
        self.assertEqual((message.model, message.transport), ("SPIDAR-G6X3R", "twin"))
        self.assertEqual((message.dof, message.strings), (6, 8))
        self.assertEqual(message.state, DeviceState.ENABLED)

    def test_frames(self):
        frames = {}
        static = Probe("/tf_static", TFMessage)
        moving = Probe("/tf", TFMessage)

        def both_seen(_):
            for probe in (static, moving):
                for message in probe.messages:
                    for t in message.transforms:
                        frames[t.child_frame_id] = t.header.frame_id
            return {"spidar_base", "spidar_grip", "cube"} <= set(frames)

        moving.wait(1, accept=both_seen)
        self.assertEqual(frames["spidar_base"], "world")
        self.assertEqual(frames["spidar_grip"], "spidar_base")
        self.assertEqual(frames["cube"], "world")

    def test_world_topics(self):
        contacts = Probe("/contacts", Contacts).wait(3, accept=lambda m: len(m.contacts) > 0)
        self.assertEqual(contacts.header.frame_id, "world")
        contact = contacts.contacts[0]
        self.assertTrue(contact.link_a and contact.link_b)
        self.assertGreaterEqual(contact.normal_force, 0)
        report = Probe("/step_report", StepReport).wait(3)
        self.assertEqual(report.step_size, 0.001)
        self.assertTrue(report.finite)
        self.assertAlmostEqual(report.time, report.step * report.step_size, places=6)
        plan = Probe("/scene_plan", ScenePlan).wait(1)
        self.assertIn("cube", plan.links)
        self.assertEqual(plan.pointers, ["pointer"])

    def test_markers_come_when_somebody_looks(self):
        for topic, namespaces in (("/markers", {"bodies"}), ("/spidar/markers", {"frame", "strings", "grip"})):
            seen = set()

            def complete(message):
                seen.update(m.ns for m in message.markers)
                return namespaces <= seen

            Probe(topic, MarkerArray).wait(1, accept=complete)

    def test_statistics_and_diagnostics(self):
        statistics = Probe("/tick_statistics", TickStatistics)
        diagnostics = Probe("/diagnostics", DiagnosticArray)
        first = statistics.wait(1)
        last = statistics.wait(20)
        self.assertEqual(first.rate, 1000)
        self.assertGreater(last.ticks, first.ticks)
        self.assertLessEqual(last.tick_us_p50, last.tick_us_p99)
        self.assertLessEqual(last.tick_us_p99, last.tick_us_max)
        self.assertEqual(last.hands[0].device, "spidar")
        self.assertEqual(last.hands[0].pointer, "pointer")
        status = diagnostics.wait(3, accept=lambda m: any("loop" in s.name for s in m.status))
        keys = [v.key for s in status.status for v in s.values]
        self.assertIn("compute p99 [us]", keys)
        loop = [t for m, t in zip(diagnostics.messages, diagnostics.times) if any("loop" in s.name for s in m.status)]
        self.assertAlmostEqual((loop[-1] - loop[0]) / (len(loop) - 1), 1.0, delta=0.3)

    def test_wrench_command_is_refused_while_bridged(self):
        Probe("/spidar/state", DeviceState).wait(1, accept=lambda m: m.claimed)
        publisher = rospy.Publisher("/spidar/wrench_command", WrenchStamped, queue_size=1)
        wrench = Probe("/spidar/wrench", WrenchStamped)
        wrench.wait(10)
        wrench.clear()
        asked = -7.0  # sideways, down from the left: nothing in the scene pushes the hand like this
        for _ in range(50):
            publisher.publish(Header(stamp=rospy.Time.now(), frame_id="spidar_base"),
                              Wrench(force=Vector3(0, asked, 0)))
            rospy.sleep(0.01)
        self.assertGreater(min(m.wrench.force.y for m in wrench.messages), 0.5 * asked)

    def test_pause_save_restore_reset(self):
        pause = rospy.ServiceProxy("/simulation/pause", SetBool)
        save = rospy.ServiceProxy("/simulation/save", StateFile)
        restore = rospy.ServiceProxy("/simulation/restore", StateFile)
        reset = rospy.ServiceProxy("/simulation/reset", Trigger)
        for proxy in (pause, save, restore, reset):
            proxy.wait_for_service(10)
        self.assertTrue(pause(True).success)
        rospy.sleep(0.1)
        first, second = save(""), save("")
        self.assertTrue(first.success, first.message)
        self.assertEqual(first.hash, second.hash, "a paused world stands still")
        pause(False)
        rospy.sleep(0.2)
        moved = save("/tmp/haptic_session_test.state")
        self.assertTrue(moved.success, moved.message)
        self.assertNotEqual(moved.hash, first.hash)
        pause(True)
        rospy.sleep(0.1)
        back = restore("/tmp/haptic_session_test.state")
        os.remove("/tmp/haptic_session_test.state")
        self.assertTrue(back.success, back.message)
        self.assertEqual(back.hash, moved.hash)
        self.assertFalse(restore("/tmp/there_is_no_such.state").success)
        self.assertTrue(reset().success)
        pause(False)

    def test_device_services(self):
        enable = rospy.ServiceProxy("/spidar/driver/enable_force", SetBool)
        state = Probe("/spidar/state", DeviceState)
        enable.wait_for_service(10)
        self.assertTrue(enable(False).success)
        state.wait(1, accept=lambda m: m.state == DeviceState.READY)
        state.clear()
        self.assertTrue(enable(True).success)
        state.wait(1, accept=lambda m: m.state == DeviceState.ENABLED)
        self.assertTrue(rospy.ServiceProxy("/spidar/driver/recover", Trigger)().success)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "session", Session, sys.argv)

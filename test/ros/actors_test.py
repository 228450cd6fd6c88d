#!/usr/bin/env python3
"""What acts on bodies from outside: wrenches, poses and joints put while paused, gravity, motions by file and topic; recorded and replayed."""
import math
import os
import shutil
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rosbag
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, Twist, Vector3, Wrench
from haptic_msgs.msg import TickStatistics
from haptic_msgs.srv import ApplyWrench, SetBodyPose, SetGravity, SetJointPositions
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool
from topic_probe import Probe, load_stack, recorded, replay, unload_stack, wait_until

SCENE = os.path.join(os.path.dirname(os.path.realpath(__file__)), "actors.urdf")
WAY = Quaternion(0, 0, 0, 1)


class Actors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("actors_test")
        cls.folder = tempfile.mkdtemp()
        cls.bag = os.path.join(cls.folder, "session.bag")
        with recorded(cls.bag):
            stack = load_stack(bridge={"record": True}, scene=SCENE)
            cls.use_everything()
            unload_stack(stack)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    @classmethod
    def place(cls, link):
        """(x, y, z) of a link in the newest tf."""
        p = cls.tf.lookup_transform("world", link, rospy.Time(0), rospy.Duration(10)).transform.translation
        return p.x, p.y, p.z

    @classmethod
    def use_everything(cls):
        statistics = Probe("/tick_statistics", TickStatistics)
        states = Probe("/joint_states", JointState)
        cls.tf = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.tf)
        statistics.wait(1, timeout=40)
        cls.a = {}

        def call(name, kind, **values):
            rospy.wait_for_service("/simulation/" + name, 30)
            return rospy.ServiceProxy("/simulation/" + name, kind)(**values)

        def seen(what, done):
            """Waits until `done()`; the word of the test where it is not."""
            wait_until(what, done, 20)

        push = Wrench(Vector3(0, 0, 5), Vector3(0, 0, 0))
        before = cls.place("box")
        cls.a["push"] = call("apply_wrench", ApplyWrench, link="lid", frame="world", wrench=push, duration=0.1)
        seen("the box flies", lambda: cls.place("box")[2] > before[2] + 0.05)
        seen("and falls back", lambda: cls.place("box")[2] < before[2] + 0.01)
        cls.a["no link"] = call("apply_wrench", ApplyWrench, link="nothing", wrench=push, duration=0.1)
        cls.a["fixed"] = call("apply_wrench", ApplyWrench, link="floor", wrench=push, duration=0.1)
        cls.a["frame"] = call("apply_wrench", ApplyWrench, link="box", frame="map", wrench=push, duration=0.1)
        cls.a["nan"] = call("apply_wrench", ApplyWrench, link="box", wrench=Wrench(Vector3(math.nan, 0, 0), Vector3()), duration=1)
        cls.a["long"] = call("apply_wrench", ApplyWrench, link="box", wrench=push, duration=1e9)
        cls.a["hand"] = call("apply_wrench", ApplyWrench, link="pointer", wrench=push, duration=0.1)

        there = Pose(Point(0.2, 0.4, 0.3), Quaternion(0, 0, math.sin(0.2), math.cos(0.2)))
        cls.a["running"] = call("set_body_pose", SetBodyPose, link="box", pose=there)
        call("pause", SetBool, data=True)
        cls.a["put"] = call("set_body_pose", SetBodyPose, link="box", pose=there, twist=Twist(Vector3(0, 0, 0.1), Vector3(0, 0, 1)))
        cls.a["no turn"] = call("set_body_pose", SetBodyPose, link="box", pose=Pose())
        cls.a["put platform"] = call("set_body_pose", SetBodyPose, link="platform", pose=there)
        cls.a["joints"] = call("set_joint_positions", SetJointPositions, names=["hinge"], positions=[1.2])
        cls.a["limit"] = call("set_joint_positions", SetJointPositions, names=["hinge"], positions=[7])
        cls.a["no joint"] = call("set_joint_positions", SetJointPositions, names=["knee"], positions=[0])
        cls.a["lengths"] = call("set_joint_positions", SetJointPositions, names=["hinge"], positions=[])
        call("pause", SetBool, data=False)
        states.clear()
        cls.hinge = states.wait(1, timeout=20).position[0]
        seen("the box comes down where it was put", lambda: abs(cls.place("box")[0] - 0.2) < 0.02 and cls.place("box")[2] < 0.02)

        cls.a["gravity"] = call("set_gravity", SetGravity, gravity=Vector3(0, 0, 0.5))
        seen("the box rises", lambda: cls.place("box")[2] > 0.05)
        cls.a["down"] = call("set_gravity", SetGravity, gravity=Vector3(0, 0, -9.8))
        cls.a["much"] = call("set_gravity", SetGravity, gravity=Vector3(0, 0, 1e5))

        lift = rospy.Publisher("/lift_pose", PoseStamped, queue_size=1)
        seen("the lift listens", lambda: lift.get_num_connections() > 0)
        start = time.monotonic()
        while time.monotonic() - start < 2:
            up = 0.1 + 0.05 * min(1, (time.monotonic() - start) / 1.5)
            message = PoseStamped(pose=Pose(Point(0, -0.5, up), WAY))
            message.header.stamp, message.header.frame_id = rospy.Time.now(), "world"
            lift.publish(message)
            time.sleep(0.02)
        lift.publish(PoseStamped(pose=Pose(Point(math.nan, 0, 0), WAY)))
        seen("the crate is lifted", lambda: abs(cls.place("crate")[2] - 0.1749) < 2e-3)
        cls.lifted = cls.place("lift")
        seen("the belt carries its parcel", lambda: cls.place("parcel")[0] > -0.3)
        seen("the platform goes to and fro", lambda: cls.place("platform")[0] > 1.08)

    def refused(self, name, *words):
        self.assertFalse(self.a[name].success, name)
        self.assertNotIn("\n", self.a[name].message)
        for word in words:
            self.assertIn(word, self.a[name].message)

    def test_wrenches(self):
        self.assertTrue(self.a["push"].success, self.a["push"].message)
        self.refused("no link", "'nothing'", "there are:")
        self.refused("fixed", "floor is fixed")
        self.refused("frame", "'map'", "world or link")
        self.refused("nan", "not finite")
        self.refused("long", "86400 s")
        self.refused("hand", "pointer", "led")

    def test_bodies_and_joints_are_put_while_paused(self):
        self.refused("running", "pause it first")
        for name in ("put", "joints"):
            self.assertTrue(self.a[name].success, self.a[name].message)
        self.refused("no turn", "unit quaternion")
        self.refused("put platform", "led along a motion")
        self.refused("limit", "hinge", "-2")
        self.refused("no joint", "'knee'")
        self.refused("lengths", "1 joints and 0 positions")
        self.assertAlmostEqual(self.hinge, 1.2, delta=0.05)

    def test_gravity(self):
        for name in ("gravity", "down"):
            self.assertTrue(self.a[name].success, self.a[name].message)
        self.refused("much", "gravity", "at most 1000")

    def test_a_topic_leads_the_lift(self):
        self.assertAlmostEqual(self.lifted[2], 0.15, delta=2e-3)

    def test_replay(self):
        with rosbag.Bag(self.bag) as bag:
            kinds = {m.kind for _, m, _ in bag.read_messages("/recorded/events")}
        self.assertTrue({15, 16, 17, 18, 20} <= kinds, f"events of kinds {kinds}")
        figures = replay(self.bag)
        self.assertGreater(figures["replay.steps"], 2000)
        self.assertEqual(figures["replay.mismatches"], 0)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "actors", Actors, sys.argv)

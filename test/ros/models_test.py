#!/usr/bin/env python3
"""Models that come and go while the loop runs: ~spawn and ~delete, what topics say of them, refusals, recording and replay."""
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rosbag
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import Point, Pose, Quaternion, WrenchStamped
from haptic_msgs.msg import Contacts, ScenePlan, TickStatistics
from haptic_msgs.srv import Delete, Grab, Spawn, StateFile
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from topic_probe import Probe, load_nodelet, load_stack, program, recorded, replay, unload, unload_stack, wait_until
from visualization_msgs.msg import MarkerArray

SCENE = os.path.join(os.path.dirname(os.path.realpath(__file__)), "actors.urdf")
BOX = """<robot name="box" xmlns:haptic="https://haptic/urdf"><link name="body">
  <inertial><mass value="0.1"/><inertia ixx="1.5e-5" iyy="1.5e-5" izz="1.5e-5" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><geometry><box size="0.03 0.03 0.03"/></geometry></visual>
  <collision><geometry><box size="0.03 0.03 0.03"/></geometry></collision></link>
  <haptic:sensor name="felt" type="contact" link="body"/></robot>"""
ARM = """<robot name="arm"><link name="base"/><link name="lever">
  <inertial><origin xyz="0.1 0 0"/><mass value="0.2"/><inertia ixx="1e-4" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="lever"/><axis xyz="0 1 0"/></joint></robot>"""
FORMATS = """<robot name="%s%n"><link name="%s"><collision><geometry><mesh filename="no.stl"/></geometry></collision></link>
  <material name="%n"><color rgba="%s%s%n"/></material></robot>"""
WEIGHT = 0.1 * 9.8


def at(x, y, z):
    return Pose(Point(x, y, z), Quaternion())


class Models(unittest.TestCase):
    changes = 0

    @classmethod
    def setUpClass(cls):
        rospy.init_node("models_test")
        cls.folder = tempfile.mkdtemp()
        cls.bag, cls.second = (os.path.join(cls.folder, name) for name in ("session.bag", "second.bag"))
        with recorded(cls.bag):
            stack = load_stack(bridge={"record": True}, scene=SCENE)
            cls.use_everything()
            unload(stack.pop())
        with recorded(cls.second):
            cls.join_again(stack)
            unload_stack(stack)
        cls.unload_while_loading()

    def test_others_find_the_robot_where_ros_has_it(self):
        with open(SCENE, encoding="utf-8") as file:
            self.assertEqual(self.description, file.read())
        self.assertFalse(rospy.has_param("/robot_description"), "it goes with the simulation")

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
        contacts = Probe("/contacts", Contacts)
        markers = Probe("/markers", MarkerArray)
        plans = Probe("/scene_plan", ScenePlan)
        cls.tf = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.tf)
        statistics.wait(1, timeout=40)
        cls.a = {}
        cls.description = rospy.get_param("/robot_description", "")

        def call(service, kind, **values):
            rospy.wait_for_service("/simulation/" + service, 30)
            return rospy.ServiceProxy("/simulation/" + service, kind)(**values)

        def seen(what, done):
            wait_until(what, done, 20)

        def touching(*names):
            return lambda message: any({c.link_a, c.link_b} == set(names) for c in message.contacts)

        cls.a["box"] = call("spawn", Spawn, name="one", urdf=BOX, pose=at(0.5, 0.5, 0.06))
        seen("the box lies on the floor", lambda: cls.place("one/body")[2] < 0.0151)
        contacts.wait(1, 20, touching("one/body", "floor"))
        felt = Probe("/sensors/one/felt", WrenchStamped)
        cls.felt = felt.wait(1, 20, lambda m: abs(m.wrench.force.z - WEIGHT) < 1e-3).wrench.force.z
        markers.clear()
        contacts.clear()
        cls.a["second"] = call("spawn", Spawn, name="two", urdf=BOX, pose=at(0.5, 0.5, 0.08))
        seen("the second box stands on the first", lambda: cls.place("two/body")[2] < 0.0451)
        contacts.wait(1, 20, touching("one/body", "two/body"))
        cls.drawn = markers.wait(1, 20, lambda m: any(k.header.frame_id == "two/body" for k in m.markers))
        cls.a["arm"] = call("spawn", Spawn, name="arm_a", urdf=ARM, pose=at(0, 1.5, 0.5), fixed=True)
        cls.joints = states.wait(1, 20, lambda m: "arm_a/hinge" in m.name).name

        cls.a["taken"] = call("spawn", Spawn, name="one", urdf=BOX, pose=at(0, 0, 1))
        cls.a["unknown"] = call("spawn", Spawn, name="three", model="no_such_model", pose=at(0, 0, 1))
        cls.a["no package"] = call("spawn", Spawn, name="three", model="package://nowhere/a.urdf", pose=at(0, 0, 1))
        cls.a["no name"] = call("spawn", Spawn, name="", urdf=BOX)
        cls.a["bad"] = call("spawn", Spawn, name="three", urdf="<robot name='x'><link", pose=at(0, 0, 1))
        massless = BOX.replace(BOX[BOX.index("<inertial>"):BOX.index("<visual>")], "")
        cls.a["massless"] = call("spawn", Spawn, name="three", urdf=massless, pose=at(0, 0, 1))
        cls.a["no mesh"] = call("spawn", Spawn, name="three", urdf=FORMATS, pose=at(0, 0, 1), fixed=True)
        cls.a["no choice"] = call("spawn", Spawn, name="three", urdf=FORMATS, missing_meshes="ball", fixed=True)
        cls.a["hands"] = call("spawn", Spawn, name="three", model=SCENE, pose=at(0, 0, 3))
        cls.a["nan"] = call("spawn", Spawn, name="three", urdf=BOX, pose=at(0, 0, float("nan")))
        cls.a["param"] = call("spawn", Spawn, name="three", model="param:/nothing", pose=at(0, 0, 1))
        cls.a["formats"] = call("spawn", Spawn, name="odd", urdf=FORMATS, pose=at(0, 0, 5), fixed=True, missing_meshes="skip")
        call("delete", Delete, name="odd")
        cls.a["nothing"] = call("delete", Delete, name="four")
        cls.a["pointer"] = call("delete", Delete, name="pointer")
        cls.a["grab"] = call("grab", Grab, link="two/body")
        cls.a["held"] = call("delete", Delete, name="two")
        call("grab", Grab, link="")
        cls.a["lower"] = call("delete", Delete, name="one")
        seen("the upper box falls", lambda: cls.place("two/body")[2] < 0.0151)
        cls.a["scene's"] = call("delete", Delete, name="box")
        cls.a["slot"] = call("restore", StateFile)
        rospy.set_param("/models_test/robot", BOX)
        cls.a["param again"] = call("spawn", Spawn, name="one", model="param:/models_test/robot", pose=at(-0.5, 0.5, 0.02))
        contacts.wait(1, 20, touching("one/body", "floor"))
        cls.a["reset"] = call("reset", Trigger)
        seen("two falls from where it came", lambda: cls.place("two/body")[2] > 0.02)
        seen("and lies again", lambda: cls.place("two/body")[2] < 0.0151)
        cls.plan = plans.wait(1, 10, lambda m: "one/body" in m.links and "box" not in m.links)
        cls.missed = statistics.wait(1).missed_ticks
        time.sleep(0.5)

    @classmethod
    def join_again(cls, stack):
        """A bridge that finds other bodies than the scene's: its recording begins with them."""
        statistics = Probe("/tick_statistics", TickStatistics)
        stack.append(load_nodelet("haptic_bridge/BridgeNodelet", "/bridge", "/haptics", rate=1000, record=True))
        statistics.wait(3, 40)

    @classmethod
    def unload_while_loading(cls):
        """Whatever is being loaded, the nodelets go: `unload` bounds it."""
        stack = load_stack(scene=SCENE)
        going = threading.Event()

        def change():
            while not going.is_set():
                try:
                    rospy.ServiceProxy("/simulation/spawn", Spawn)(name="one", urdf=BOX, pose=at(0.3, 0.3, 0.5))
                    rospy.ServiceProxy("/simulation/delete", Delete)(name="one")
                    cls.changes += 1
                except (rospy.ServiceException, rospy.ROSException):
                    time.sleep(0.05)  # it is not there yet, or no longer

        rospy.wait_for_service("/simulation/spawn", 30)
        changing = threading.Thread(target=change, daemon=True)
        changing.start()
        wait_until("three changes", lambda: cls.changes >= 3, 20)
        unload_stack(stack)
        going.set()

    def test_nodelets_go_while_models_come(self):
        self.assertGreaterEqual(self.changes, 3)

    def refused(self, name, *words):
        self.assertFalse(self.a[name].success, name)
        self.assertNotIn("\n", self.a[name].message)
        for word in words:
            self.assertIn(word, self.a[name].message)

    def test_models_come_and_go(self):
        for name, links in (("box", "one/body"), ("second", "two/body"), ("arm", "arm_a/base, arm_a/lever"), ("lower", "one/body"),
                            ("scene's", "box, lid"), ("param again", "one/body"), ("formats", "odd/%s")):
            self.assertTrue(self.a[name].success, self.a[name].message)
            self.assertEqual(self.a[name].message, links)
        self.assertIn("hinge", self.joints)
        self.assertAlmostEqual(self.felt, WEIGHT, delta=1e-3)
        self.assertTrue(self.a["reset"].success, self.a["reset"].message)

    def test_refusals_are_one_line(self):
        self.refused("taken", "'one'", "taken")
        self.refused("unknown", "no_such_model", "neither a file nor a known scene")
        self.refused("no package", "package://nowhere/a.urdf")
        self.refused("no name", "name ''")
        self.refused("bad", "three.urdf")
        self.refused("massless", "three.urdf:1", "no <inertial>", "default_density: 1000")
        self.refused("no mesh", "three.urdf:1", "no.stl", "missing_meshes: box or skip")
        self.refused("no choice", "'ball' is unknown", "box")
        self.refused("hands", "pointer")
        self.refused("nan", "pose")
        self.refused("param", "no such parameter")
        self.refused("nothing", "'four'", "there are:")
        self.refused("pointer", "spidar")
        self.assertTrue(self.a["grab"].success, self.a["grab"].message)
        self.refused("held", "two/body", "is held by the hand of spidar", "let it go first")
        self.refused("slot", "nothing was saved")

    def test_plan_says_what_is_not_certified(self):
        self.assertIn("bodies have come or gone", self.plan.text)

    def test_replay(self):
        with rosbag.Bag(self.bag) as bag:
            changes = [m.tick for _, m, _ in bag.read_messages("/recorded/events") if m.kind == 19]
            starts = [m for _, m, _ in bag.read_messages("/recorded/session")]
        with rosbag.Bag(self.second) as bag:
            starts += [m for _, m, _ in bag.read_messages("/recorded/session")]
        self.assertEqual([len(start.bodies) > 0 for start in starts], [False, True])
        self.assertEqual(set(starts[1].links) ^ set(starts[0].links), {"box", "one/body", "two/body", "arm_a/base", "arm_a/lever"})
        self.assertEqual(len(changes), 8)
        for bag, least in ((self.bag, 1000), (self.second, 100)):
            figures = replay(bag)
            self.assertGreater(figures["replay.steps"], least)
            self.assertEqual(figures["replay.mismatches"], 0)

    def test_table_has_all_bodies(self):
        subprocess.run([program("penalty_sim", "session_table"), self.bag, self.folder, "--view"], check=True)
        with open(os.path.join(self.folder, "session_1.contacts.csv"), encoding="utf-8") as file:
            pairs = {tuple(line.split(",")[2:4]) for line in file}
        self.assertTrue({("one/body", "two/body"), ("two/body", "one/body")} & pairs)
        with open(os.path.join(self.folder, "session_1.npy"), "rb") as file:
            header = file.read(20000).decode("latin-1")
        for link in ("one/body", "two/body", "arm_a/lever", "box"):
            self.assertIn(f"body.{link}.position_x", header)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "models", Models, sys.argv)

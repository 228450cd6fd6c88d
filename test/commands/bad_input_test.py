#!/usr/bin/python3
"""Whatever a user gets wrong: one line that says what, exit code not 0, nothing that hangs or is left running."""
import os
import subprocess
import tempfile
import threading
import time
import unittest
import xmlrpc.server

from run_verb import Call, descendants

LIMIT_S = 110.0  # it takes 1 s; a machine that does something else may take long, and Call ends what hangs after 120 s
LINK = '<link name="{0}"><inertial><mass value="{1}"/><inertia ixx="{2}" iyy="{2}" izz="{2}" ixy="0" ixz="0" iyz="0"/>' \
       '</inertial><collision><geometry>{3}</geometry></collision></link>'
BOX = '<box size="0.1 0.1 0.1"/>'
FREE = '<joint name="free" type="floating"><parent link="world"/><child link="body"/></joint>'


def scene(link, joints=FREE):
    return f'<robot name="bad"><link name="world"/>{link}{joints}</robot>'


class BadInput(unittest.TestCase):
    def refuse(self, *arguments, says, **environment):
        call = Call(*arguments, **environment)
        self.assertEqual(call.left, [], f"left running by {arguments}")
        self.assertNotEqual(call.code, 0, arguments)
        self.assertLess(call.seconds, LIMIT_S, arguments)
        self.assertEqual(len(call.errors), 1, call.errors)
        for word in says:
            self.assertIn(word, call.errors[0])
        self.assertEqual(call.figures(), {})

    def test_unknown_names(self):
        self.refuse("demo", "--scene", "no_such_scene", says=["no_such_scene", "touch_cube"])
        self.refuse("demo", "--device", "no_such_device", says=["no_such_device", "spidar_g6x3r"])
        self.refuse("check", "touch_cube", "--device", "no_such_device", says=["no_such_device", "spidar_g6x3r"])
        self.refuse("bench", "no_such_benchmark", says=["no_such_benchmark"])

    def test_missing_files(self):
        self.refuse("demo", "--scene", "no/such/file.urdf", says=["no/such/file.urdf"])
        self.refuse("demo", "--device", "no/such/file.yaml", says=["no/such/file.yaml"])
        self.refuse("demo", "--record", "/no/such/folder/a.bag", says=["/no/such/folder"])

    def test_values(self):
        for rate in ("0", "-1", "nan", "fast", "1e3"):
            self.refuse("demo", "--rate", rate, says=["--rate", rate])
        for seconds in ("0", "-1", "inf", "soon"):
            self.refuse("demo", "--seconds", seconds, says=["--seconds", seconds])
        self.refuse("demo", "--scene", says=["--scene"])
        self.refuse("demo", "--speed", "1", says=["--speed"])
        self.refuse("demo", "--rviz", says=["DISPLAY"])

    def test_scenes(self):
        cases = {
            "empty": ("", []),
            "malformed": ("<robot name='a'><link", []),
            "not_a_robot": ("<sdf/>", []),
            "no_number": (scene(LINK.format("body", "much", 1e-3, BOX)), ["<mass>", "much"]),
            "mesh_not_found": (scene(LINK.format("body", 1, 1e-3, '<mesh filename="no_such.stl"/>')), ["no_such.stl"]),
        }
        with tempfile.TemporaryDirectory() as folder:
            for name, (text, words) in cases.items():
                path = os.path.join(folder, name + ".urdf")
                with open(path, "w", encoding="utf-8") as out:
                    out.write(text)
                self.refuse("demo", "--scene", path, "--seconds", "3", says=[name + ".urdf"] + words)

    def test_parameter_servers(self):
        self.refuse("demo", "--scene", "param:/robot_description", says=["param:/robot_description", "no parameter server answers at"],
                    ROS_MASTER_URI="http://127.0.0.1:1")
        with xmlrpc.server.SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as server:
            known = {"/number": 3, "/bad": "<robot name='bad'><link"}
            server.register_function(lambda _, name: (1, "", known[name]) if name in known else (-1, f"Parameter [{name}] is not set", 0),
                                     "getParam")
            threading.Thread(target=server.serve_forever, daemon=True).start()
            master = f"http://127.0.0.1:{server.server_address[1]}"
            self.refuse("demo", "--scene", "param:/nothing", says=["/nothing", "is not set"], ROS_MASTER_URI=master)
            self.refuse("demo", "--scene", "param:/number", says=["/number", "no text"], ROS_MASTER_URI=master)
            self.refuse("demo", "--scene", "param:/bad", "--seconds", "3", says=["bad.urdf"], ROS_MASTER_URI=master)
            server.shutdown()

    def test_a_folder_for_logs_that_cannot_be_written(self):
        self.refuse("demo", "--seconds", "3", says=["ROS_LOG_DIR", "/proc/nowhere"], ROS_LOG_DIR="/proc/nowhere")

    def test_check(self):
        self.refuse("check", "touch_cube", "--rate", "fast", says=["--rate", "fast"])
        self.refuse("check", "touch_cube", "--device", says=["--device"])

    def test_unknown_verb_shows_the_verbs(self):
        call = Call("dance")
        self.assertNotEqual(call.code, 0)
        self.assertIn("dance", call.errors[-1])
        self.assertTrue(any("demo" in line for line in call.errors))

    def test_the_search_for_left_processes_finds_one(self):
        marker = f"HAPTIC_TEST_CALL={os.getpid()}-self"
        child = subprocess.Popen(["sleep", "30"], env={**os.environ, "HAPTIC_TEST_CALL": marker.split("=")[1]})
        try:
            deadline = time.monotonic() + 5
            while not descendants(marker) and time.monotonic() < deadline:
                time.sleep(0.01)
            self.assertEqual(descendants(marker), [child.pid])
        finally:
            child.kill()
            child.wait()


if __name__ == "__main__":
    unittest.main()

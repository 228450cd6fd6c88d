// Meshes that bound no volume, that no decomposition takes, or that are not there; and files as exporters leave them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "haptic_core/base/word_hash.h"
#include "haptic_core/geometry/hulls/plane_decomposition.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/world/world.h"
#include "scene/mesh_cache.h"
#include "scene/text_file.h"
#include "scene/xml_file.h"
#include "temporary_files.h"

namespace haptic {
namespace degenerate_mesh_test {

/// Of the largest number: a cell's diagonal and a facet's width of Qhull, each of 16 steps of a float at most.
constexpr double kHullPrecision = (1.8 + 1) * 16 / (1 << 23);

std::string meshLink(const std::string& file, const std::string& name = "a", const std::string& beside = "") {
  return "<link name=\"" + name + "\"><inertial><origin xyz=\"0.1 0 0\" rpy=\"0 0 0.5\"/><mass value=\"2\"/><inertia ixx=\"0.01\" "
         "iyy=\"0.02\" izz=\"0.025\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>"
         "<collision><origin xyz=\"0 0 0.2\" rpy=\"0.3 0 0\"/><geometry><mesh filename=\"" + file +
         "\"/></geometry>" + beside + "</collision></link>\n";
}

/// A scene of one mesh, as written to `file`.
SceneDef loadMesh(const std::string& file, const std::string& text, const SceneOptions& options = {}) {
  const TemporaryFiles files;
  files.write(file, text);
  return loadScene(files.write("robot.urdf", robot(meshLink(file))), options);
}

const ConvexShape& only(const SceneDef& scene) { return *scene.world.articulations.at(0).links.at(0).collisions.at(0).shape; }

int drawnInItsColour(const SceneDef& scene) {
  int drawn = 0;
  for (const VisualDef& visual : scene.visuals) drawn += visual.colour == kReplacedColour;
  return drawn;
}

TEST(DegenerateMesh, AFlatOneIsASlab) {
  const SceneDef scene = loadMesh("plane.obj", "v -.02 -.02 1\nv .02 -.02 1\nv .02 .02 1\nv -.02 .02 1\nf 1 2 3\nf 1 3 4\n");
  EXPECT_TRUE(mentions(scene.replaced, "mesh plane.obj: is flat: a slab 1 mm thick in its place")) << sceneText(scene);
  EXPECT_EQ(scene.replaced.size(), 1u);
  EXPECT_EQ(drawnInItsColour(scene), 1);
  EXPECT_NEAR(only(scene).volume(), 0.04 * 0.04 * 1e-3, 1e-12);
  EXPECT_NEAR(only(scene).centre().z(), 1, 1e-7);  // float32
}

/// Tilted planes in float32, a line, a point: each has a solid that holds all its points.
TEST(DegenerateMesh, WhateverItIsASolidHoldsIt) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const int dimension : {2, 1, 0}) {
    for (int trial = 0; trial < 20; ++trial) {
      const Vector3 a = Vector3(u(random), u(random), u(random)), b(u(random), u(random), u(random)), o(u(random), u(random), u(random));
      std::string text;
      std::vector<Vector3> points;
      for (int i = 0; i < 12; ++i) {
        const Vector3 p = o + (dimension > 0 ? u(random) : 0) * a + (dimension > 1 ? u(random) : 0) * b;
        char line[99];
        std::snprintf(line, sizeof line, "v %.7g %.7g %.7g\n", p.x(), p.y(), p.z());
        text += line;
        points.push_back(p);
      }
      // A point's corners differ by names alone: three lines for one place.
      text += "f 1 2 3\nf 4 5 6\nf 7 8 9\nf 10 11 12\n";
      SceneDef scene;
      try {
        scene = loadMesh("m.obj", text);
      } catch (const SetupError& error) {
        EXPECT_EQ(dimension, 0) << error.what();  // a mesh of one point has no triangle
        continue;
      }
      ASSERT_EQ(scene.replaced.size(), 1u);
      EXPECT_GT(only(scene).volume(), 0);
      const ConvexPolyhedron& solid = *only(scene).polyhedron();
      for (const Vector3& p : points) {
        for (const auto& face : solid.faces()) EXPECT_LT(face.normal.dot(p) - face.offset, kHullPrecision * 3);
      }
    }
  }
}

/// Points of round bodies as float32: their hulls hold them to within steps of their numbers.
TEST(DegenerateMesh, HullsOfFloatsAreTakenByTheirPrecision) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(0, 1);
  for (const int kind : {0, 1, 2}) {
    for (const int count : {60, 300, 3000}) {
      for (int trial = 0; trial < 8; ++trial) {
        const Quaternion q = Quaternion(u(random), u(random), u(random), u(random)).normalized();
        std::vector<Vector3> points;
        const int around = static_cast<int>(std::sqrt(count));
        for (int i = 0; i < count; ++i) {
          const double phi = 2 * M_PI * (i % around) / around, t = (i / around) / static_cast<double>((count - 1) / around);
          const double s = 2 * M_PI * t;
          Vector3 p;
          if (kind == 0) {
            const double z = 2 * t - 1, r = std::sqrt(std::max(0.0, 1 - z * z));
            p = 0.03 * Vector3(r * std::cos(phi), r * std::sin(phi), z);
          } else if (kind == 1) {
            const double r = 0.03 * (t < 0.6 ? std::sqrt(u(random)) : 1);
            p = Vector3(r * std::cos(phi), r * std::sin(phi), 0.08 * (t < 0.3 ? 0 : t < 0.6 ? 1 : (t - 0.6) / 0.4));
          } else {
            p = Vector3((0.03 + 0.01 * std::cos(s)) * std::cos(phi), (0.03 + 0.01 * std::cos(s)) * std::sin(phi), 0.01 * std::sin(s));
          }
          p = q * p;
          points.push_back(Vector3(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())));
        }
        const ConvexPolyhedron hull = ConvexPolyhedron::hull(points);
        double outside = 0;
        for (const Vector3& p : points) {
          for (const auto& face : hull.faces()) outside = std::max(outside, face.normal.dot(p) - face.offset);
        }
        EXPECT_LT(outside, kHullPrecision * 0.09) << kind << " " << count;
      }
    }
  }
}

/// An open box and a bow tie that crosses itself are felt as their hull, or as pieces; nothing is refused.
TEST(DegenerateMesh, OpenAndSelfCrossingOnesLoad) {
  const std::string open =
      "v 0 0 0\nv .1 0 0\nv .1 .1 0\nv 0 .1 0\nv 0 0 .1\nv .1 0 .1\nv .1 .1 .1\nv 0 .1 .1\n"
      "f 1 3 2\nf 1 4 3\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
  const std::string tie = "v 0 0 0\nv .1 0 0\nv 0 .1 .02\nv .1 .1 0\nv .05 .05 .1\nf 1 2 3\nf 2 4 3\nf 1 4 5\nf 2 3 5\nf 5 1 2\n";
  for (const std::string& mesh : {open, tie}) {
    const SceneDef scene = loadMesh("m.obj", mesh);
    EXPECT_GT(only(scene).volume(), 0);
    EXPECT_EQ(scene.collisions_loaded, 1);
  }
}

TEST(DegenerateMesh, MissingFilesStopTogetherOrGetABoxOrAreLeftOut) {
  const std::string text = robot(meshLink("one.stl") + meshLink("package://no/two.stl", "b") + meshLink("three.dae", "c") +
                                 joint("j", "fixed", "a", "b") + joint("k", "fixed", "b", "c"));
  const std::string message = refusal(text);
  for (const char* word :
       {"3 meshes", "one.stl", "package://no/two.stl", "three.dae", "'a'", "'b'", "'c'", "--missing-meshes", "ROS_PACKAGE_PATH"}) {
    EXPECT_NE(message.find(word), std::string::npos) << word << " in " << message;
  }
  SceneOptions options;
  options.missing = missingMeshesNamed("skip");
  SceneDef scene = loadText(text, options);
  EXPECT_EQ(scene.collisions_loaded, 0);
  EXPECT_EQ(scene.replaced.size(), 3u);
  options.missing = missingMeshesNamed("box");
  scene = loadText(text, options);
  EXPECT_EQ(scene.collisions_loaded, 3);
  EXPECT_EQ(drawnInItsColour(scene), 3);
  // The box at the density of its mass has the moments of its link, where they are.
  const CollisionDef& box = scene.world.articulations[0].links[0].collisions[0];
  const MassProperties solid = box.shape->massProperties(2 / box.shape->volume());
  EXPECT_NEAR((box.X_LS * solid.com - Vector3(0.1, 0, 0)).norm(), 0, 1e-14);
  const Matrix3 R = rotationFromRpy(Vector3(0, 0, 0.5)), I = R * Vector3(0.01, 0.02, 0.025).asDiagonal() * R.transpose();
  EXPECT_NEAR((box.X_LS.R * solid.I_com * box.X_LS.R.transpose() - I).norm(), 0, 1e-14);
  EXPECT_THROW(missingMeshesNamed("ball"), SetupError);
}

/// An L, which is cut.
TriangleMesh ell() {
  TriangleMesh mesh;
  const double at[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (const double z : {0.0, 1.0}) {
    for (const auto& p : at) mesh.vertices.push_back(Vector3(p[0], p[1], z));
  }
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 4, 3}, {0, 5, 4}, {6, 7, 8}, {6, 8, 9}, {6, 9, 10}, {6, 10, 11}};
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    mesh.triangles.push_back({i, j, j + 6});
    mesh.triangles.push_back({i, j + 6, i + 6});
  }
  return mesh;
}

std::uint64_t bitsOf(const CutMesh& cut) {
  std::uint64_t hash = kHashStart;
  for (const auto& piece : cut.pieces) {
    for (const Vector3& v : piece->vertices()) hash = hashWords(hash, v.data(), sizeof v);
    for (const auto& face : piece->faces()) hash = hashWords(hash, face.normal.data(), sizeof face.normal);
  }
  return hash;
}

/// What the cache gives back has the bits of what was cut; another mesh, another tolerance, damage: nothing.
TEST(MeshCache, KeepsBitsByContentAndNothingDamaged) {
  const TemporaryFiles files;
  const char* before = std::getenv("XDG_CACHE_HOME");
  const std::string kept = before ? before : "";
  setenv("XDG_CACHE_HOME", files.folder().c_str(), 1);
  TriangleMesh mesh = ell();
  ConvexSettings settings;
  CutMesh cut;
  cut.pieces = convexPieces(mesh, settings, cut.report);
  ASSERT_EQ(cut.report.pieces, 2);
  const std::string path = cachePath(mesh, settings);
  EXPECT_FALSE(readCut(path, "a"));
  keepCut(path, cut);
  const auto again = readCut(path, "a");
  ASSERT_TRUE(again);
  EXPECT_EQ(bitsOf(*again), bitsOf(cut));
  EXPECT_EQ(again->report.hull_distance, cut.report.hull_distance);
  EXPECT_EQ(again->pieces[0]->name(), "a");
  mesh.vertices[3].x() += 1e-15;
  EXPECT_NE(cachePath(mesh, settings), path);
  settings.absolute_tolerance *= 2;
  EXPECT_NE(cachePath(ell(), settings), path);
  std::string bytes = readTextFile(path);
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_FALSE(readCut(path, "a"));
  std::ofstream(path, std::ios::binary) << bytes.substr(0, 40);
  EXPECT_FALSE(readCut(path, "a"));
  if (before) {
    setenv("XDG_CACHE_HOME", kept.c_str(), 1);
  } else {
    unsetenv("XDG_CACHE_HOME");
  }
}

/// A bound on the work ends the cutting, says so, and leaves pieces that hold the whole mesh.
TEST(MeshCache, WorkIsBoundedAndSaid) {
  const TriangleMesh mesh = ell();
  DecompositionSettings settings;
  settings.most_work = 0;
  int told = 0;
  settings.progress = [&told](int, double) { ++told; };
  DecompositionReport report;
  const auto pieces = cutIntoConvexPieces(mesh, settings, "ell", report);
  EXPECT_EQ(pieces.size(), 2u);  // one cut, then it looks
  EXPECT_GT(told, 1);
  settings.most_work = -1;
  DecompositionReport none;
  EXPECT_EQ(cutIntoConvexPieces(mesh, settings, "ell", none).size(), 1u);
  EXPECT_TRUE(none.unfinished);
  EXPECT_FALSE(report.unfinished);
}

std::string stl(const std::vector<std::array<float, 9>>& triangles) {
  std::string bytes(80, 'x');
  const std::uint32_t count = static_cast<std::uint32_t>(triangles.size());
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (const auto& corners : triangles) {
    bytes.append(12, '\0').append(reinterpret_cast<const char*>(corners.data()), 36).append(2, '\0');
  }
  return bytes;
}

TEST(OddFiles, TrailingBytesQuotedBlanksAndShortNumbers) {
  const std::vector<std::array<float, 9>> pyramid = {
      {0, 0, 0, 0, 1, 0, 1, 0, 0}, {0, 0, 0, 1, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 1, 0, 1, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  const TemporaryFiles files;
  const std::string path = files.write("a b.stl", stl(pyramid) + "made by hand");
  for (const std::string uri : {"file://" + files.folder() + "/a%20b.stl", std::string("a%20b.stl"), std::string("a b.stl")}) {
    const SceneDef scene = loadScene(files.write("robot.urdf", robot(meshLink(uri))));
    EXPECT_NEAR(only(scene).volume(), 1.0 / 6, 1e-12) << uri;
  }
  const SceneDef scene = loadMesh("m.obj", "v -.02 .5 1\nv .02 .5 1\nv 0 .52 1\nv 0 .51 1.02\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  EXPECT_NEAR(only(scene).aabb().lower.x(), -0.02, 1e-7);
  const SceneDef bare = loadMesh("m.obj", "v -1 -1 -1\nv nan 1 0\nv 1 1 0\nv 0 1 1\nv 1 0 1\nf 1 2 3\nf 1 3 4\nf 1 3 5\nf 3 4 5\n");
  EXPECT_TRUE(mentions(bare.replaced, "mesh m.obj: 1 of its triangles have a corner that is not finite and are left out"));
}

TEST(OddFiles, ANulByteIsReadOverAndSaid) {
  const std::string sound = robot(boxLink("a") + "\n<!-- x -->\n");
  std::string text = sound + std::string(1, '\0');
  const SceneDef scene = loadText(text);
  EXPECT_TRUE(mentions(scene.warnings, "robot.urdf:7: has 1 NUL byte in this line")) << sceneText(scene);
  EXPECT_NE(refusal(std::string("\x7f" "ELF\0\0", 6)).find("binary"), std::string::npos);
  EXPECT_NE(refusal(std::string("\xff\xfe<\0r\0", 6)).find("UTF-16"), std::string::npos);
}

TEST(OddFiles, OtherFormatsAreToldWhatToDo) {
  EXPECT_NE(refusal("<sdf version=\"1.6\"/>").find("SDF"), std::string::npos);
  EXPECT_NE(refusal("<mujoco model=\"a\"/>").find("MJCF"), std::string::npos);
}

TEST(OddFiles, APackageIsFoundByItsNameWithBlanks) {
  const TemporaryFiles files;
  files.write("ws/src/checkout/package.xml", "<package>\n  <name> my_robot\n </name></package>");
  files.write("ws/src/checkout/m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  const char* before = std::getenv("ROS_PACKAGE_PATH");
  const std::string kept = before ? before : "";
  setenv("ROS_PACKAGE_PATH", (files.folder() + "/ws/src").c_str(), 1);
  EXPECT_EQ(refusal(robot(meshLink("package://my_robot/m.obj"))), "");
  setenv("ROS_PACKAGE_PATH", kept.c_str(), 1);
}

/// A program called xacro on the path that writes its arguments into a robot, or fails.
TEST(OddFiles, XacroGoesThroughItsProgram) {
  const TemporaryFiles files;
  const std::string path = std::getenv("PATH") ? std::getenv("PATH") : "";
  const std::string text = robot("<xacro:arg name=\"n\" default=\"1\"/>" + boxLink("a"));
  setenv("PATH", files.folder().c_str(), 1);
  EXPECT_NE(refusal(text).find("no program xacro"), std::string::npos);
  const std::string program = files.write("xacro", "#!/bin/sh\n[ \"$2\" = bad:=1 ] && { echo 'warning: old' >&2; "
                                                   "printf '\\033[31mbad is unknown\\033[0m\\n"
                                                   "when processing file: a.xacro\\n' >&2; exit 2; }\n"
                                                   "echo \"<robot name='$2'><link name='a'/></robot>\"\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  SceneOptions options;
  options.xacro = {"n:=two words"};
  const SceneDef scene = loadText(text, options);
  EXPECT_EQ(scene.world.name, "n:=two words");
  EXPECT_NE(scene.text.find("n:=two words"), std::string::npos);
  options.xacro = {"bad:=1"};
  EXPECT_NE(refusal(text, options).find("xacro fails: bad is unknown, when processing file: a.xacro"), std::string::npos) << refusal(text,
      options);
  setenv("PATH", path.c_str(), 1);
}

/// A robot that came as text, as from the parameter server.
TEST(OddFiles, ATextStandsForAFile) {
  SceneOptions options;
  options.text = robot(boxLink("a") + boxLink("a"));
  try {
    loadScene("param:/robot_description", options);
    FAIL();
  } catch (const SetupError& error) {
    EXPECT_EQ(std::string(error.what()).find("param:/robot_description:4: link 'a'"), 0u) << error.what();
  }
  options.text = robot(boxLink("a"));
  const SceneDef scene = loadScene("param:/robot_description", options);
  EXPECT_EQ(scene.file, "param:/robot_description");
  EXPECT_EQ(scene.text, *options.text);
}

}  // namespace degenerate_mesh_test
}  // namespace haptic

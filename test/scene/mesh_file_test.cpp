// Files of meshes as programs leave them: what is odd and can be read is read, what cannot be is named as what it is.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>

#include "haptic_core/base/error.h"
#include "scene/mesh_file.h"
#include "scene/number_table.h"
#include "temporary_files.h"

namespace haptic {
namespace mesh_file_test {

/// A tetrahedron: 4 triangles, whose edges have lengths of 0.1 m and 0.1 √2 m.
const std::array<Vector3, 4> kCorners = {Vector3(0, 0, 0), Vector3(0.1, 0, 0), Vector3(0, 0.1, 0), Vector3(0, 0, 0.1)};
const std::array<std::array<int, 3>, 4> kTriangles = {{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};

std::string binaryStl(std::uint32_t told, const std::string& behind = "") {
  std::string stl(80, ' ');
  stl.append(reinterpret_cast<const char*>(&told), sizeof told);
  for (const auto& triangle : kTriangles) {
    float numbers[12] = {};
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 3; ++k) numbers[3 + 3 * c + k] = static_cast<float>(kCorners[triangle[c]][k]);
    }
    stl.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
    stl.append(2, '\0');
  }
  return stl + behind;
}

std::string textStl(bool capitals) {
  std::string stl = "solid t\n";
  for (const auto& triangle : kTriangles) {
    stl += "facet normal 0 0 0\nouter loop\n";
    for (const int c : triangle) {
      stl += "vertex " + std::to_string(kCorners[c].x()) + " " + std::to_string(kCorners[c].y()) + " " + std::to_string(kCorners[c].z())
          + "\n";
    }
    stl += "endloop\nendfacet\n";
  }
  stl += "endsolid t\n";
  for (char& c : stl) c = static_cast<char>(capitals ? std::toupper(static_cast<unsigned char>(c)) : c);
  return stl;
}

std::string obj() {
  std::string text;
  for (const Vector3& c : kCorners) text += "v " + std::to_string(c.x()) + " " + std::to_string(c.y()) + " " + std::to_string(c.z()) + "\n";
  for (const auto& t : kTriangles) text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2]
      + 1) + "\n";
  return text;
}

struct Read {
  TriangleMesh mesh;
  MeshOddities odd;
};

Read read(const std::string& name, const std::string& bytes) {
  const TemporaryFiles files;
  Read read;
  read.mesh = readMesh(files.write(name, bytes), Vector3::Ones(), "here", &read.odd);
  return read;
}

/// The signed volume of the four triangles is that of the tetrahedron, 0.1³/6: each corner of the file, and its order, is in it.
void expectTetrahedron(const Read& read) {
  EXPECT_EQ(read.mesh.triangles.size(), 4u);
  double volume = 0;
  for (const auto& t
      : read.mesh.triangles) volume += read.mesh.vertices[t[0]].dot(read.mesh.vertices[t[1]].cross(read.mesh.vertices[t[2]])) / 6;
  EXPECT_NEAR(volume, 1e-3 / 6, 1e-3 / 6 * 4 * 0x1p-23);  // three factors of a float, each rounded once, and a sum
}

TEST(MeshFile, WordsInCapitalsAndByteOrderMarks) {
  const std::string mark = "\xef\xbb\xbf";
  for (const bool capitals : {false, true}) {
    expectTetrahedron(read("a.stl", textStl(capitals)));
    expectTetrahedron(read("a.STL", mark + textStl(capitals)));
  }
  expectTetrahedron(read("a.obj", obj()));
  expectTetrahedron(read("a.obj", mark + obj()));
}

TEST(MeshFile, TablesAndRobotsWithByteOrderMarks) {
  const TemporaryFiles files;
  const NumberTable table = readNumberTable(files.write("a.csv", "\xef\xbb\xbftime,x\n0,1\n"), "time,x");
  EXPECT_EQ(table.columns[0], "time");
  EXPECT_TRUE(loadText("\xef\xbb\xbf" + robot(boxLink("a"))).warnings.empty());
}

TEST(MeshFile, ABinaryStlHasTheTrianglesThatAreThere) {
  expectTetrahedron(read("a.stl", binaryStl(4)));
  EXPECT_TRUE(read("a.stl", binaryStl(4)).odd.count.empty());
  for (const std::uint32_t told : {0u, 2u, 9u}) {
    const Read wrong = read("a.stl", binaryStl(told));
    expectTetrahedron(wrong);
    EXPECT_NE(wrong.odd.count.find("counts " + std::to_string(told) + " triangles and has 4"), std::string::npos) << wrong.odd.count;
  }
  // What programs append is no triangle: text, numbers of no size of the mesh, less than a triangle.
  std::string large(50, '\0');
  const float far = 1e9f;
  std::memcpy(large.data() + 12, &far, sizeof far);
  for (const std::string& behind : {std::string(100, 'A'), large, std::string(50, '\0'), std::string("end")}) {
    expectTetrahedron(read("a.stl", binaryStl(4, behind)));
    EXPECT_TRUE(read("a.stl", binaryStl(4, behind)).odd.count.empty());
  }
}

TEST(MeshFile, APointerOfGitLfsIsCalledOne) {
  const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";
  const TemporaryFiles files;
  for (const char* name : {"a.stl", "a.obj", "a.dae"}) {
    files.write(name, pointer);
    const std::string text = robot(std::string("<link name=\"a\"><collision><geometry><mesh filename=\"") + name
        + "\"/></geometry></collision></link>");
    try {
      loadScene(files.write("robot.urdf", text));
      FAIL() << name;
    } catch (const SetupError& error) {
      const std::string message = error.what();
      for (const char* word : {"1 mesh is not readable", "'a'", name, "a pointer of git-LFS", "git lfs pull", "--missing-meshes"}) {
        EXPECT_NE(message.find(word), std::string::npos) << word << " in " << message;
      }
      EXPECT_EQ(message.find("ROS_PACKAGE_PATH"), std::string::npos) << message;
    }
  }
  EXPECT_NE(refusal(pointer).find("a pointer of git-LFS"), std::string::npos);
}

TEST(MeshFile, ABrokenOneIsNamedByItsOwnName) {
  const std::string message = refusal(
      robot("<link name=\"a\"><collision><geometry><mesh filename=\"no.stl\"/></geometry></collision></link>"));
  EXPECT_NE(message.find("not found"), std::string::npos) << message;
  try {
    read("broken.stl", "nothing of use");
    FAIL();
  } catch (const SetupError& error) {
    EXPECT_EQ(std::string(error.what()).find("magic"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("broken.stl"), std::string::npos) << error.what();
  }
}

}  // namespace mesh_file_test
}  // namespace haptic

#include "scene/mesh_file.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <array>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

/// Joins bitwise equal vertices: an .stl repeats each of them in every triangle.
class VertexTable {
 public:
  explicit VertexTable(TriangleMesh& mesh) : mesh_(mesh) {}
  int index(const Vector3& p) {
    const auto [place, fresh] =
        table_.emplace(std::array<double, 3>{p.x(), p.y(), p.z()}, mesh_.vertices.size());
    if (fresh) mesh_.vertices.push_back(p);
    return place->second;
  }

 private:
  TriangleMesh& mesh_;
  std::map<std::array<double, 3>, int> table_;
};

/// Number of triangles that were left out.
int append(const aiMesh& part, const Vector3& scale, VertexTable& table, TriangleMesh& mesh) {
  // A mirrored scale turns the triangles inside out; the other order of corners turns them back.
  const bool mirrored = scale.prod() < 0;
  int dropped = 0;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices != 3) continue;
    std::array<Vector3, 3> corners;
    for (int c = 0; c < 3; ++c) {
      const aiVector3D& v = part.mVertices[face.mIndices[c]];
      corners[c] = Vector3(v.x, v.y, v.z).cwiseProduct(scale);
    }
    if (!corners[0].allFinite() || !corners[1].allFinite() || !corners[2].allFinite()) {
      ++dropped;
      continue;
    }
    std::array<int, 3> triangle;
    for (int c = 0; c < 3; ++c) triangle[c] = table.index(corners[c]);
    if (mirrored) std::swap(triangle[1], triangle[2]);
    if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]) {
      mesh.triangles.push_back(triangle);
    }
  }
  return dropped;
}

std::string endingOf(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

std::string bytesOf(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// A binary STL says how many triangles follow its head; what some programs append is no part of it.
void dropTrailingBytes(std::string& stl) {
  constexpr std::size_t kHead = 84, kTriangle = 50;
  std::uint32_t count = 0;
  if (stl.size() < kHead) return;
  std::memcpy(&count, stl.data() + 80, sizeof count);
  if (count > 0 && stl.size() > kHead + kTriangle * std::size_t{count}) stl.resize(kHead + kTriangle * std::size_t{count});
}

/// Assimp does not read numbers without a digit before their point.
std::string withDigits(const std::string& obj) {
  std::string text;
  text.reserve(obj.size() + obj.size() / 16);
  for (std::size_t i = 0; i < obj.size(); ++i) {
    const char before = i > 0 ? obj[i - 1] : ' ';
    const bool bare = obj[i] == '.' && i + 1 < obj.size() && obj[i + 1] >= '0' && obj[i + 1] <= '9';
    if (bare && (before == ' ' || before == '\t' || before == '-' || before == '+')) text += '0';
    text += obj[i];
  }
  return text;
}

constexpr unsigned kImportSteps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices;

const aiScene* read(Assimp::Importer& importer, const std::string& path) {
  const std::string ending = endingOf(path);
  if (ending != ".stl" && ending != ".obj") return importer.ReadFile(path, kImportSteps);
  std::string bytes = bytesOf(path);
  if (ending == ".obj") {
    bytes = withDigits(bytes);
  } else if (bytes.compare(0, 5, "solid") != 0 || bytes.find("facet") == std::string::npos) {
    dropTrailingBytes(bytes);
  }
  return importer.ReadFileFromMemory(bytes.data(), bytes.size(), kImportSteps, ending.c_str() + 1);
}

}  // namespace

TriangleMesh readMesh(const std::string& path, const Vector3& scale, const std::string& where, int* dropped) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // Points and lines bound no volume.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = read(importer, path);
  if (!scene) {
    std::string reason = importer.GetErrorString();
    for (char& c : reason) c = c == '\n' ? ' ' : c;
    throw SetupError(where, "mesh " + path + " cannot be read (" + reason + ")",
                     "export it again as .stl, .dae or .obj");
  }
  TriangleMesh mesh;
  VertexTable table(mesh);
  int left_out = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) left_out += append(*scene->mMeshes[m], scale, table, mesh);
  if (dropped) *dropped = left_out;
  if (mesh.triangles.empty()) throw SetupError(where, "mesh " + path + " has no triangle with finite corners", "export it again");
  return mesh;
}

}  // namespace haptic

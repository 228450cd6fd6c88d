#include "scene/mesh_file.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>

#include "haptic_core/base/error.h"
#include "scene/text_file.h"

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

/// Whether a text of STL, whatever the case of its words, stands there; binary files may begin with "solid" as well.
bool isTextStl(const std::string& lower) {
  const std::size_t word = lower.find_first_not_of(" \t\r\n");
  return word != std::string::npos && lower.compare(word, 5, "solid") == 0 && lower.find("facet") != std::string::npos;
}

/// A binary STL says how many triangles follow its head. Where whole triangles of its size follow beyond these, it is the count that is
/// wrong; other bytes are no part of it. A shorter file has the triangles that are there.
void mendBinaryStl(std::string& stl, MeshOddities& odd) {
  constexpr std::size_t kHead = 84, kTriangle = 50;
  if (stl.size() < kHead) return;
  std::uint32_t count = 0;
  std::memcpy(&count, stl.data() + 80, sizeof count);
  const std::size_t whole = (stl.size() - kHead) / kTriangle;
  const auto largest = [&](std::size_t begin, std::size_t end) {
    float most = 0;
    for (std::size_t t = begin; t < end; ++t) {
      float corners[9];
      std::memcpy(corners, stl.data() + kHead + kTriangle * t + 12, sizeof corners);
      for (const float c : corners) most = std::isfinite(c) ? std::max(most, std::abs(c)) : INFINITY;
    }
    return most;
  };
  std::size_t taken = std::min<std::size_t>(count, whole);
  constexpr float kOfSize = 10;  // corners of the rest, of the largest of those that are counted [1]
  const bool rest = whole > taken && (stl.size() - kHead) % kTriangle == 0;
  const float most = rest ? largest(taken, whole) : 0;
  if (rest && std::isfinite(most) && (taken == 0 || (most > 0 && most <= kOfSize * largest(0, taken)))) taken = whole;
  if (taken != count) {
    odd.count = " counts " + std::to_string(count) + " triangles and has " + std::to_string(taken) + ", which are taken";
    const auto mended = static_cast<std::uint32_t>(taken);
    std::memcpy(stl.data() + 80, &mended, sizeof mended);
  }
  stl.resize(kHead + kTriangle * taken);
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

const aiScene* read(Assimp::Importer& importer, const std::string& path, MeshOddities& odd) {
  constexpr std::size_t kMostBytes = std::size_t{2} << 30;
  const std::string ending = endingOf(path);
  std::string bytes = readFile(path, kMostBytes);
  if (ending != ".stl" && ending != ".obj") return importer.ReadFile(path, kImportSteps);
  if (ending == ".obj") {
    bytes = withDigits(withoutByteOrderMark(bytes));
  } else {
    std::string lower = withoutByteOrderMark(bytes);
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (isTextStl(lower)) {
      bytes = lower;
    } else {
      mendBinaryStl(bytes, odd);
    }
  }
  return importer.ReadFileFromMemory(bytes.data(), bytes.size(), kImportSteps, ending.c_str() + 1);
}

/// Assimp's words of what it does not read, with the file's name for its own of a file in memory.
std::string reasonOf(const Assimp::Importer& importer, const std::string& path) {
  std::string reason = importer.GetErrorString();
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  constexpr char kInMemory[] = "$$$___magic___$$$";
  for (std::size_t at = reason.find(kInMemory); at != std::string::npos; at = reason.find(kInMemory)) {
    const std::size_t end = reason.find_first_not_of(".abcdefghijklmnopqrstuvwxyz", at + sizeof kInMemory - 1);
    reason.replace(at, std::min(end, reason.size()) - at, std::filesystem::path(path).filename().string());
  }
  return reason;
}

}  // namespace

TriangleMesh readMesh(const std::string& path, const Vector3& scale, const std::string& where, MeshOddities* odd) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // Points and lines bound no volume.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  MeshOddities found;
  const aiScene* scene = nullptr;
  try {
    scene = read(importer, path, found);
  } catch (const SetupError& refused) {
    throw SetupError(where, std::string("mesh ") + refused.what(), "");
  }
  if (!scene) {
    throw SetupError(where, "mesh " + path + " cannot be read (" + reasonOf(importer, path) + ")", "export it again as .stl, .dae or .obj");
  }
  TriangleMesh mesh;
  VertexTable table(mesh);
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) found.dropped += append(*scene->mMeshes[m], scale, table, mesh);
  if (odd) *odd = found;
  if (mesh.triangles.empty()) throw SetupError(where, "mesh " + path + " has no triangle with finite corners", "export it again");
  return mesh;
}

}  // namespace haptic

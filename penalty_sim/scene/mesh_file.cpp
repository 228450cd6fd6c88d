#include "scene/mesh_file.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <array>
#include <assimp/Importer.hpp>
#include <filesystem>
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

void append(const aiMesh& part, const Vector3& scale, VertexTable& table, TriangleMesh& mesh) {
  // A mirrored scale turns the triangles inside out; the other order of corners turns them back.
  const bool mirrored = scale.prod() < 0;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices != 3) continue;
    std::array<int, 3> triangle;
    for (int c = 0; c < 3; ++c) {
      const aiVector3D& v = part.mVertices[face.mIndices[c]];
      triangle[c] = table.index(Vector3(v.x, v.y, v.z).cwiseProduct(scale));
    }
    if (mirrored) std::swap(triangle[1], triangle[2]);
    if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]) {
      mesh.triangles.push_back(triangle);
    }
  }
}

}  // namespace

TriangleMesh readMesh(const std::string& path, const Vector3& scale, const std::string& where) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // Points and lines bound no volume.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene =
      importer.ReadFile(path, aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices);
  if (!scene) {
    std::string reason = importer.GetErrorString();
    for (char& c : reason) c = c == '\n' ? ' ' : c;
    throw SetupError(where, "mesh " + path + " cannot be read (" + reason + ")",
                     "export it again as .stl, .dae or .obj");
  }
  TriangleMesh mesh;
  VertexTable table(mesh);
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) append(*scene->mMeshes[m], scale, table, mesh);
  if (mesh.triangles.empty()) throw SetupError(where, "mesh " + path + " has no triangle", "export it again");
  for (const Vector3& vertex : mesh.vertices) {
    if (!vertex.allFinite())
      throw SetupError(where, "mesh " + path + " has a vertex that is not finite", "export it again");
  }
  return mesh;
}

}  // namespace haptic

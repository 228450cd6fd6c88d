#include "scene/mesh_cache.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "haptic_core/base/error.h"
#include "haptic_core/base/packed_file.h"
#include "haptic_core/base/whole_file.h"
#include "haptic_core/geometry/shapes/shape_parts.h"

namespace haptic {
namespace {

/// Another number where the pieces of the same mesh are others: after a change of hulls or cuts.
constexpr char kFormat[] = "haptic mesh, cut: 2\n";

struct Kept {
  std::vector<ShapeParts> pieces;
  double hull_distance = 0, size = 0, mesh_volume = 0, pieces_volume = 0;
  bool unfinished = false, decomposed = false;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.pieces), visit(s.hull_distance), visit(s.size), visit(s.mesh_volume), visit(s.pieces_volume);
    visit(s.unfinished), visit(s.decomposed);
  }
};

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::string cachePath(const TriangleMesh& mesh, const ConvexSettings& settings) {
  const char *cache = std::getenv("XDG_CACHE_HOME"), *home = std::getenv("HOME");
  std::filesystem::path folder;
  if (cache && *cache) {
    folder = cache;
  } else if (home && *home) {
    folder = std::filesystem::path(home) / ".cache";
  } else {
    return {};
  }
  std::string bytes = kFormat;
  for (const Vector3& vertex : mesh.vertices) append(bytes, vertex.x()), append(bytes, vertex.y()), append(bytes, vertex.z());
  for (const auto& triangle : mesh.triangles) append(bytes, triangle);
  append(bytes, settings.relative_tolerance);
  append(bytes, settings.absolute_tolerance);
  append(bytes, settings.max_pieces);
  // Two hashes of 64 bits, from both ends: two meshes of one name do not come up.
  char name[48];
  const std::uint64_t forth = hashBytes(bytes), back = hashBytes(std::string(bytes.rbegin(), bytes.rend()));
  std::snprintf(name, sizeof name, "%016llx%016llx", static_cast<unsigned long long>(forth), static_cast<unsigned long long>(back));
  return (folder / "haptics" / "meshes" / name).string();
}

std::optional<CutMesh> readCut(const std::string& path, const std::string& name) {
  std::ifstream stream(path, std::ios::binary);
  if (path.empty() || !stream) return std::nullopt;
  try {
    const Kept kept = unpackFile<Kept>(kFormat, {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()}, path);
    CutMesh cut;
    for (const ShapeParts& parts : kept.pieces) {
      cut.pieces.push_back(std::make_shared<const ConvexPolyhedron>(parts.vertices, parts.loops, name));
    }
    cut.report = {kept.hull_distance, kept.size, kept.mesh_volume, kept.pieces_volume, static_cast<int>(cut.pieces.size()),
                  kept.unfinished, kept.decomposed};
    return cut;
  } catch (const SetupError&) {
    return std::nullopt;
  }
}

void keepCut(const std::string& path, const CutMesh& cut) {
  if (path.empty()) return;
  Kept kept;
  for (const auto& piece : cut.pieces) kept.pieces.push_back(partsOf(*piece));
  for (ShapeParts& parts : kept.pieces) parts.name.clear();
  kept.hull_distance = cut.report.hull_distance, kept.size = cut.report.size;
  kept.mesh_volume = cut.report.mesh_volume, kept.pieces_volume = cut.report.pieces_volume;
  kept.unfinished = cut.report.unfinished, kept.decomposed = cut.report.decomposed;
  std::error_code code;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), code);
  if (code) return;
  try {
    writeWholeFile(path, packFile(kFormat, kept));
  } catch (const SetupError&) {  // a full disk, a folder of somebody else: it is cut again next time
  }
}

}  // namespace haptic

#include "scene/mesh_shapes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

#include "haptic_core/base/symmetric_matrix.h"
#include "haptic_core/geometry/hulls/mesh_to_convex.h"
#include "scene/link_inertia.h"
#include "scene/mesh_cache.h"
#include "scene/mesh_file.h"
#include "scene/resource_path.h"
#include "scene/sound_shape.h"

namespace haptic {
namespace {

using Solid = std::shared_ptr<const ConvexPolyhedron>;

/// Pieces at most, by default and where a scene asks for a surface error: contact costs grow with the pieces in touch.
constexpr int kPieces = 32, kFinePieces = 256;

std::string inMillimetres(double metres) {
  std::ostringstream text;
  text.precision(3);
  text << (metres < 1e-9 ? 0 : 1e3 * metres) << " mm";  // rounding
  return text.str();
}

/// A solid box of the link's mass with the link's moments has these sides: along each principal axis a² = 6 (I' + I'' − I) / m.
/// Empty: the link has no mass or no moments.
std::vector<Vector3> boxOfInertia(const LinkInertia& inertia) {
  const PrincipalAxes principal = principalAxes(inertia.I_C);
  const Vector3 moments = principal.value;
  if (!(inertia.mass > 0) || !(moments[2] > 0)) return {};
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) {
    Vector3 corner;
    for (int k = 0; k < 3; ++k) {
      const double squared = 6 * (moments.sum() - 2 * moments[k]) / inertia.mass;
      corner[k] = (i >> k & 1 ? 0.5 : -0.5) * std::max(kSlabThickness, std::sqrt(std::max(0.0, squared)));
    }
    corners.push_back(inertia.p_LC + principal.axes * corner);
  }
  return corners;
}

/// What takes its time says so, a line a second.
class Progress {
 public:
  Progress(const std::function<void(const std::string&)>& tell, const std::string& what) : tell_(tell), what_(what) {}

  bool isSlow() const { return Clock::now() - start_ > std::chrono::milliseconds(100); }
  void at(int pieces, double distance) {
    const auto now = Clock::now();
    if (!tell_ || now - told_ < std::chrono::seconds(1)) return;
    told_ = now;
    tell_("cutting " + what_ + " into convex pieces: " + std::to_string(pieces) + ", " + inMillimetres(distance) + " from it so far");
  }

 private:
  using Clock = std::chrono::steady_clock;
  const std::function<void(const std::string&)>& tell_;
  std::string what_;
  Clock::time_point start_ = Clock::now(), told_ = start_;
};

/// From the cache, or cut and kept there when that took its time. Throws SetupError as convexPieces does.
CutMesh cutOrKept(const TriangleMesh& mesh, ConvexSettings settings, const std::function<void(const std::string&)>& tell) {
  const std::string path = cachePath(mesh, settings);
  if (auto kept = readCut(path, settings.name)) return *kept;
  Progress progress(tell, settings.name);
  settings.progress = [&progress](int pieces, double distance) { progress.at(pieces, distance); };
  CutMesh cut;
  cut.pieces = convexPieces(mesh, settings, cut.report);
  if (progress.isSlow()) keepCut(path, cut);
  return cut;
}

/// Pieces of a mesh that bounds a volume, or what stands for one that does not.
void cut(const TriangleMesh& mesh, const ConvexSettings& settings, const std::function<void(const std::string&)>& tell, ShapePieces& made,
         ConvexReport& report, std::string& said) {
  std::vector<Solid> pieces;
  std::string reason = "is flat";
  if (!isFlat(mesh.vertices)) {
    try {
      CutMesh done = cutOrKept(mesh, settings, tell);
      pieces = std::move(done.pieces), report = done.report;
    } catch (const SetupError& refused) {
      reason = "is refused (" + std::string(refused.what()).substr(settings.name.size() + 2) + ")";
    }
  }
  std::ostringstream text;
  if (pieces.empty()) {
    const SoundShape sound = soundShapeOf(mesh.vertices, settings.name);
    pieces = {sound.solid};
    text << sound.text;
    said = reason + ": " + sound.text + " in its place";
  } else {
    text << (report.decomposed ? std::to_string(report.pieces) + " convex pieces" : "hull") << ", " << inMillimetres(report.hull_distance)
         << " from the mesh at most";
  }
  int vertices = 0;
  for (const Solid& piece : pieces) vertices += piece->vertexCount();
  text << ", " << vertices << " vertices";
  made.pieces.assign(pieces.begin(), pieces.end());
  made.text = text.str();
}

}  // namespace

void measure(ShapePieces& shape) {
  Vector3 lower = Vector3::Constant(INFINITY), upper = -lower;
  for (const auto& piece : shape.pieces) {
    lower = lower.cwiseMin(piece->aabb().lower);
    upper = upper.cwiseMax(piece->aabb().upper);
  }
  shape.half_extent = 0.5 * (upper - lower).minCoeff();
}

MissingMeshes missingMeshesNamed(const std::string& name) {
  std::string known;
  for (const MissingMeshesName& row : kMissingMeshes) {
    if (name == row.name) return row.choice;
    known += std::string(known.empty() ? "" : ", ") + row.name;
  }
  throw SetupError("missing meshes", "'" + name + "' is unknown", "write one of " + known);
}

std::string meshPath(const RobotFile& robot, const std::string& where, const XmlElement& mesh) {
  const char* uri = mesh.Attribute("filename");
  if (!uri || !*uri) throw SetupError(where, "<mesh> has no filename", "give filename=\"package://...\"");
  return resolveResource(uri, robot.xml.path());
}

Vector3 meshScale(const RobotFile& robot, const XmlElement& mesh) {
  return readVector(robot.xml, mesh, "scale").value_or(Vector3::Ones());
}

ShapePieces MeshShapes::make(const RobotFile& robot, const LinkXml& link, const std::string& where, const XmlElement& collision,
                             double surface_error) {
  const XmlElement& mesh = *collision.FirstChildElement("geometry")->FirstChildElement();
  const std::string path = meshPath(robot, where, mesh);
  const Vector3 scale = meshScale(robot, mesh);
  if (path.empty()) {
    missing_.push_back(mesh.Attribute("filename") + (" (" + where + ")"));
    return standIn(robot, link, collision, "mesh " + std::string(mesh.Attribute("filename")) + " is not found");
  }
  std::ostringstream key;
  key.precision(17);
  key << path << " " << scale.transpose() << " " << surface_error;
  const auto known = made_.find(key.str());
  if (known != made_.end()) return known->second;
  TriangleMesh triangles;
  MeshOddities odd;
  try {
    triangles = readMesh(path, scale, where, &odd);
  } catch (const SetupError& unreadable) {
    unreadable_.push_back(unreadable.what());
    return standIn(robot, link, collision, std::string(unreadable.what()).substr(where.size() + 2));
  }
  ConvexSettings settings;
  settings.name = where + ": mesh " + path;
  settings.max_pieces = kPieces;
  if (surface_error > 0) {
    settings.absolute_tolerance = surface_error;
    settings.relative_tolerance = 0;
    settings.max_pieces = kFinePieces;
  }
  ConvexReport report;
  ShapePieces made;
  cut(triangles, settings, options_.progress, made, report, made.replaced);
  const std::string name = "mesh " + std::filesystem::path(path).filename().string();
  if (odd.dropped > 0) {
    made.replaced = std::to_string(odd.dropped) + " of its triangles have a corner that is not finite and are left out" +
                    (made.replaced.empty() ? "" : ", the rest " + made.replaced);
  }
  if (!made.replaced.empty()) made.replaced = name + ": " + made.replaced;
  made.text = name + ": " + made.text;
  measure(made);
  const double asked = surface_error > 0 ? surface_error : std::max(1e-3, 0.01 * report.size);
  if (report.hull_distance > asked) {
    made.to_mend = "the surface of " + name + " is felt up to " + inMillimetres(report.hull_distance) + " from where it is, " +
                  inMillimetres(asked) + " was asked" + (report.unfinished ? " (cutting took too much work)" : "") + "; " +
                  (surface_error > 0 ? "cut it into convex meshes"
                                     : "ask for less by <haptic:shape surface_error=\"0.001\"/> beside <geometry>");
  }
  if (!odd.count.empty()) made.to_mend = name + odd.count + (made.to_mend.empty() ? "" : "; " + made.to_mend);
  made_.emplace(key.str(), made);
  return made;
}

ShapePieces MeshShapes::standIn(const RobotFile& robot, const LinkXml& link, const XmlElement& collision, const std::string& reason) const {
  ShapePieces made;
  const std::vector<Vector3> corners_L = boxOfInertia(readInertia(robot, link));
  if (options_.missing != MissingMeshes::kBox || corners_L.empty()) {
    made.replaced = reason + ": it is left out" + (options_.missing == MissingMeshes::kBox ? ", for its link has no inertia of a box" : "");
    return made;
  }
  const Pose X_SL = readOrigin(robot.xml, collision).inverse();
  std::vector<Vector3> corners_S;
  for (const Vector3& corner : corners_L) corners_S.push_back(X_SL * corner);
  const SoundShape box = soundShapeOf(corners_S, robot.at(link));
  made.pieces = {box.solid};
  made.text = "a box with the moments of its link, for its mesh";
  made.replaced = reason + ": a box with the mass and the moments of its link in its place";
  measure(made);
  return made;
}

void MeshShapes::refuseMissing(const std::vector<std::string>& pictures) const {
  if (options_.missing != MissingMeshes::kStop || (missing_.empty() && unreadable_.empty())) return;
  std::string list;
  for (const auto& files : {missing_, unreadable_}) {
    for (const std::string& file : files) list += (list.empty() ? "" : ", ") + file;
  }
  const auto counted = [](std::size_t count, const std::string& what) {
    return std::to_string(count) + (count == 1 ? " mesh is " : " meshes are ") + what;
  };
  std::string where = missing_.empty() ? "" : counted(missing_.size(), "not found");
  if (!unreadable_.empty()) where += (where.empty() ? "" : ", ") + counted(unreadable_.size(), "not readable");
  if (!pictures.empty()) list += ", and " + std::to_string(pictures.size()) + " of visuals";
  // One of a package says most about how to come by it; what is there wants no other place.
  const auto of_package = std::find_if(missing_.begin(), missing_.end(), [](const std::string& file) { return file.rfind("package://",
      0) == 0; });
  const std::string remedy = missing_.empty() ? "" : remedyFor(of_package != missing_.end() ? *of_package : missing_.front()) + "; ";
  throw SetupError(where, list, remedy + "or load with " + options_.words.missing);
}

}  // namespace haptic

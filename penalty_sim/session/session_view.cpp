#include "session/session_view.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/world.h"
#include "scene/mesh_file.h"

namespace haptic {
namespace {

constexpr std::uint64_t kSamples = 60000;  // ticks with patches, at most: a minute at 1 kHz. More fill a disk and no screen
constexpr int kMostPatches = 64;           // of a tick, the strongest, as SceneMarkers has it: more arrows cannot be read

void put(YAML::Emitter& out, const Vector3& v) { out << v.x() << v.y() << v.z(); }

void put(YAML::Emitter& out, const char* key, const Vector3& v) {
  out << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginSeq;
  put(out, v);
  out << YAML::EndSeq;
}

/// x, y, z, then the quaternion's x, y, z, w.
void put(YAML::Emitter& out, const char* key, const Pose& X) {
  const Quaternion q(X.R);
  out << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginSeq;
  put(out, X.p);
  out << q.x() << q.y() << q.z() << q.w() << YAML::EndSeq;
}

/// Meshes of a scene, each once.
class Meshes {
 public:
  explicit Meshes(std::string& bytes) : bytes_(bytes) {}

  /// Index of a visual's mesh; −1: it cannot be read, which changes the picture only.
  int indexOf(const VisualDef& visual) {
    if (visual.shape == VisualShape::kTriangles) return indexOf(visual.corners);
    const auto key = visual.mesh_uri + " " + std::to_string(visual.size.x()) + " " +
                     std::to_string(visual.size.y()) + " " + std::to_string(visual.size.z());
    const auto [known, is_new] = index_.try_emplace(key, static_cast<int>(sizes_.size()));
    if (!is_new) return known->second;
    try {
      add(readMesh(visual.mesh_uri.substr(std::string("file://").size()), visual.size, visual.name));
    } catch (const SetupError&) {
      known->second = -1;
    }
    return known->second;
  }
  const std::vector<std::pair<std::size_t, std::size_t>>& sizes() const { return sizes_; }

 private:
  /// Of triangles that the scene has itself, three corners each.
  int indexOf(const std::vector<Vector3>& corners) {
    TriangleMesh mesh{corners, {}};
    for (int i = 0; i + 2 < static_cast<int>(corners.size()); i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
    add(mesh);
    return static_cast<int>(sizes_.size()) - 1;
  }
  void add(const TriangleMesh& mesh) {
    std::vector<float> vertices;
    for (const Vector3& v : mesh.vertices)
      for (int axis = 0; axis < 3; ++axis) vertices.push_back(static_cast<float>(v[axis]));
    std::vector<std::uint32_t> corners;
    for (const auto& triangle : mesh.triangles)
      for (const int corner : triangle) corners.push_back(static_cast<std::uint32_t>(corner));
    bytes_.append(reinterpret_cast<const char*>(vertices.data()), vertices.size() * sizeof(float));
    bytes_.append(reinterpret_cast<const char*>(corners.data()), corners.size() * sizeof(std::uint32_t));
    sizes_.emplace_back(mesh.vertices.size(), mesh.triangles.size());
  }

  std::string& bytes_;
  std::map<std::string, int> index_;
  std::vector<std::pair<std::size_t, std::size_t>> sizes_;  ///< vertices, triangles
};

void putDevice(YAML::Emitter& out, const std::string& name, const DeviceDef& def) {
  out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << name << YAML::Key << "grip_radius" << YAML::Value
      << def.grip_radius << YAML::Key << "strings" << YAML::Value << YAML::BeginSeq;
  for (const StringDef& string : def.strings) {
    out << YAML::BeginMap;
    put(out, "exit", string.p_BE);
    put(out, "knot", string.p_GK);
    put(out, "per_opening", string.dp_GK);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
}

}  // namespace

SessionView::SessionView(const RecordedSession& session, ReplayRun& run)
    : session_(session),
      run_(run),
      stride_((session.ticks.size() + kSamples - 1) / kSamples),
      last_base_(session.start.hands.size(), SIZE_MAX) {}

void SessionView::addTick() {
  const std::uint64_t tick = tick_++;
  // When a device is lost the hands after it move up: bases stay where they were.
  const bool all_there = static_cast<std::size_t>(run_.loop().handCount()) == last_base_.size();
  for (std::size_t hand = 0; all_there && hand < last_base_.size(); ++hand) {
    const WorkspaceSettings& now = run_.loop().hand(static_cast<int>(hand)).settings().workspace;
    const std::size_t last = last_base_[hand];
    if (last != SIZE_MAX && bases_[last].X_WB.p == now.X_WB.p && bases_[last].X_WB.R == now.X_WB.R &&
        bases_[last].scale == now.scale)
      continue;
    last_base_[hand] = bases_.size();
    bases_.push_back({tick, static_cast<int>(hand), now.X_WB, now.scale});
  }
  if (tick % stride_ != 0) return;
  const World& world = run_.world();
  std::vector<int> order(static_cast<std::size_t>(world.contactCount()));
  std::iota(order.begin(), order.end(), 0);
  if (order.size() > kMostPatches) {
    std::partial_sort(order.begin(), order.begin() + kMostPatches, order.end(),
                      [&](int a, int b) { return world.contact(a).normal_force > world.contact(b).normal_force; });
    order.resize(kMostPatches);
    std::sort(order.begin(), order.end());  // a patch keeps its place among those of its pair
  }
  for (const int i : order) {
    const ContactReport& c = world.contact(i);
    const Vector3 n = c.X_WP.R.col(2), &p = c.X_WP.p, &F = c.F_BP_W.force;
    const int a = run_.seen(c.link_a), b = run_.seen(c.link_b);
    for (const double number : {static_cast<double>(tick), static_cast<double>(a), static_cast<double>(b), p.x(), p.y(), p.z(), n.x(),
                                n.y(), n.z(), F.x(), F.y(), F.z(), c.area, c.normal_force, static_cast<double>(c.sticking)})
      patches_.push_back(static_cast<float>(number));
  }
}

std::string SessionView::text(std::string& mesh_bytes) const {
  YAML::Emitter out;
  out.SetDoublePrecision(9);
  out << YAML::BeginMap << YAML::Key << "patch_stride" << YAML::Value << stride_ << YAML::Key << "links" << YAML::Value
      << YAML::BeginSeq;
  for (const SeenLink& link : run_.links()) {
    out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << link.name << YAML::Key << "moves" << YAML::Value << link.moves;
    put(out, "pose", link.X_WL);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::Key << "visuals" << YAML::Value << YAML::BeginSeq;
  Meshes meshes(mesh_bytes);
  for (const auto& [link, visual] : run_.visuals()) {
    const bool is_mesh = visual.shape == VisualShape::kMesh || visual.shape == VisualShape::kTriangles;
    const int mesh = is_mesh ? meshes.indexOf(visual) : -1;
    if (is_mesh && mesh < 0) continue;
    out << YAML::BeginMap << YAML::Key << "link" << YAML::Value << link << YAML::Key
        << "shape" << YAML::Value << nameOf(visual.shape) << YAML::Key << "mesh" << YAML::Value << mesh;
    put(out, "size", visual.size);
    put(out, "pose", visual.X_LV);
    out << YAML::Key << "colour" << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (const float part : visual.colour) out << part;
    out << YAML::EndSeq << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::Key << "meshes" << YAML::Value << YAML::Flow << YAML::BeginSeq;
  for (const auto& [vertices, triangles] : meshes.sizes()) out << YAML::Flow << YAML::BeginSeq << vertices << triangles << YAML::EndSeq;
  out << YAML::EndSeq << YAML::Key << "devices" << YAML::Value << YAML::BeginSeq;
  for (std::size_t i = 0; i < session_.start.hands.size(); ++i) putDevice(out, session_.start.hands[i].device, run_.devices()[i]);
  out << YAML::EndSeq << YAML::Key << "bases" << YAML::Value << YAML::BeginSeq;
  for (const Base& base : bases_) {
    out << YAML::BeginMap << YAML::Key << "tick" << YAML::Value << base.tick << YAML::Key << "hand" << YAML::Value << base.hand
        << YAML::Key << "scale" << YAML::Value << base.scale;
    put(out, "pose", base.X_WB);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  return out.c_str();
}

}  // namespace haptic

/// From a file to a world: URDF (one robot or a scene with a `world` link) or a YAML list of models.
///
/// No ROS node, no master: everything here is plain C++ that the simulation node, `scene_check`, tests and
/// benchmarks share. Loading allocates, reads files and throws SetupError: one line that names file, line,
/// link or joint, and what to do. Nothing is dropped in silence: what is replaced, guessed or ignored stands
/// in `warnings` or `replaced`.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "haptic_core/loop/delay_line.h"
#include "haptic_core/loop/workspace_map.h"
#include "haptic_core/spidar/hand_path.h"
#include "haptic_core/world/definition.h"
#include "scene/load_report.h"
#include "scene/scene_options.h"

namespace haptic {

/// What a visual's geometry is.
enum class VisualShape : unsigned char { kBox, kCylinder, kSphere, kMesh, kTriangles };

/// Name by which session/view3d draws it. Files of meshes and triangles are both drawn from their corners.
constexpr const char* nameOf(VisualShape shape) {
  constexpr const char* kNames[] = {"box", "cylinder", "sphere", "mesh", "mesh"};
  return kNames[static_cast<int>(shape)];
}

/// Of what stands in for a shape that could not be as the file has it: no robot is painted so.
inline constexpr std::array<float, 4> kReplacedColour{0.9f, 0.1f, 0.75f, 1.0f};

/// What rviz draws for a link.
struct VisualDef {
  /// Indices in `world`.
  int articulation = -1, link = -1;
  std::string name;  ///< of the URDF link it stands in (before merging)
  /// Of the geometry.
  VisualShape shape = VisualShape::kBox;
  Vector3 size = Vector3::Ones();  ///< [m] full size in x, y, z (round shapes: diameters); a mesh's scale [1]
  std::string mesh_uri;            ///< file:// of a mesh
  std::vector<Vector3> corners;    ///< of triangles, three each [m], in the visual's frame
  Pose X_LV;                       ///< in the link's frame
  std::array<float, 4> colour{0.7f, 0.7f, 0.7f, 1.0f};  ///< r, g, b, a
  bool own_colours = false;  ///< a mesh without <material>: the file's colours hold

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.articulation), visit(s.link), visit(s.name), visit(s.shape), visit(s.size), visit(s.mesh_uri), visit(s.corners);
    visit(s.X_LV), visit(s.colour), visit(s.own_colours);
  }
};

/// A device of the scene and the pointer it moves.
struct HandDef {
  std::string device = "spidar";  ///< name that the device's driver goes by
  int pointer = -1;               ///< index in `world.pointers`
  WorkspaceSettings
      workspace;           ///< the grip's home is the pointer's initial pose unless the scene says otherwise
  double force_scale = 1;  ///< hand newtons per world newton
  AddedDelay delay;        ///< of the loop, beside the wire's
  HandPath path;           ///< of the scripted hand that moves a simulated device; never empty

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.device), visit(s.pointer), visit(s.workspace), visit(s.force_scale), visit(s.delay), visit(s.path);
  }
};

/// How one URDF collision became polyhedra, for listings.
struct CollisionReport {
  /// URDF link; shape, size and how it was approximated.
  std::string link, text;       ///< URDF link; shape, size, approximation
  ContactMaterial material;     ///< as the files give it; NaN: the world's default holds
  std::string material_source;  ///< element and line, or "default"
};

/// Two links that overlap before anything moves.
struct StartContact {
  std::string a, b;       ///< links
  double depth = 0;       ///< [m]
  bool filtered = false;  ///< they do not collide
};

/// Where the poses of a body come from that is told its motion one by one.
struct ToldMotion {
  int motion = -1;                   ///< index in WorldDef::motions
  std::string topic;                 ///< of geometry_msgs/PoseStamped; empty: it follows tf
  std::string frame;                 ///< of tf; empty: it follows the topic
  Pose X_FL;                         ///< the body's link in the frame that is told
};

/// A loaded scene: its world, hands, visuals, and what the loader had to say.
struct SceneDef : LoadReport {
  std::string file;  ///< absolute path, or the name that was given with SceneOptions::text
  std::string text;  ///< that was read: of the file, of xacro, or SceneOptions::text
  /// Of each model: the prefix of its names, and its URDF.
  std::vector<std::pair<std::string, std::string>> descriptions;
  /// For World.
  WorldDef world;
  /// Of all links.
  std::vector<VisualDef> visuals;
  /// One per device, in the order of the file.
  std::vector<HandDef> hands;
  /// Of bodies whose poses come from outside, in the order of the files.
  std::vector<ToldMotion> told_motions;
  /// One per collision element that became shapes.
  std::vector<CollisionReport> collisions;
  /// Deeper than kTouches, in the order of links.
  std::vector<StartContact> start_contacts;
  int collisions_tried = 0;           ///< <collision> elements in the files
  int collisions_loaded = 0;          ///< those that became shapes
  int joints = 0;                     ///< joint elements in the files, fixed ones included

  /// What runs and what is drawn; what the loader had to say of the file stays behind.
  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.world), visit(s.visuals), visit(s.hands);
  }
};

/// Loads a .urdf/.xml or .yaml/.yml file, or a scene by its name (looked up in `scene_folders`, then in
/// haptic_description/scenes on ROS_PACKAGE_PATH, then in urdf/scenes of this folder and those above it).
/// Throws SetupError.
SceneDef loadScene(const std::string& file_or_name, const SceneOptions& options = {});

struct ModelSettings;

/// Loads one URDF as loadScene does, for a world that runs: with its settings, and without a pointer that it does not have. The file's
/// own <haptic:scene> is left out, with a warning. Throws SetupError.
SceneDef loadModel(const std::string& file_or_name, const ModelSettings& model, const WorldSettings& running, SceneOptions options);

/// Initial pose of every link of one articulation: forward kinematics at the joints' initial positions.
std::vector<Pose> initialPoses(const ArticulationDef& articulation);

/// Several lines: models, links, joints, collisions with their effective contact values and sources, hands.
std::string sceneText(const SceneDef& scene);

}  // namespace haptic

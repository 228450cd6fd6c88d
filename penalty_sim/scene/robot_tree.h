/// A checked URDF as articulations of a world: fixed joints merged, floating ones made roots, shapes
/// attached.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "scene/collision_shapes.h"
#include "scene/contact_properties.h"
#include "scene/robot_file.h"
#include "scene/scene_file.h"

namespace haptic {

/// How one model enters the scene.
struct ModelSettings {
  std::string prefix;                    ///< before every link and joint name
  Pose X_WM;                             ///< where the model's root lies in the world
  bool floating = false;                 ///< root link on a floating joint; false: fixed
  bool floats_unless_world = false;      ///< likewise, where the file does not hang its bodies on the world itself
  std::map<std::string, double> joints;  ///< initial positions by joint name without prefix [rad] or [m]
  /// What drives do at the start.
  enum class Drive : unsigned char {
    kAsFile,  ///< hold a robot as published, leave the joints of a scene (world link) free
    kHold,    ///< joints with an effort limit > 0 hold their initial position
    kFree
  } drive = Drive::kAsFile;  ///< see Drive
};

/// Where a link or merged link of any model went.
struct FramePlace {
  /// Indices in the scene's world; -1: nowhere yet.
  int articulation = -1, link = -1;
  Pose X_LF;  ///< in that link's frame
};

/// A collision whose file gives no number of its stiffness: it says nothing, or rigid (stiffness_choice.h).
struct SilentCollision {
  int articulation = -1, link = -1;  ///< where it went
  std::size_t first = 0, count = 0;  ///< its pieces among the link's collisions
  std::size_t report = 0;            ///< of SceneDef::collisions
  double extent = 0;                 ///< least extent [m]
};

/// A link of a file, as probable_numbers.h judges it; all in the frame of the link L that it went into.
struct JudgedLink {
  std::string where;  ///< "file:line: link 'x'"
  int articulation = -1, link = -1;       ///< where it went
  std::vector<CollisionDef> collisions;   ///< its own
  LinkInertia inertia;                    ///< as the file gives it; mass 0: it does not
  std::vector<Vector3> joints;            ///< origins of its own frame and of the joints that hang on it [m]
};

/// A scene under construction, and what its parts need to know of each other.
struct LoadContext {
  /// `options` outlives this.
  explicit LoadContext(const SceneOptions& options) : shapes(options) {}

  /// What has been loaded so far.
  SceneDef scene;
  /// Shared by all models.
  CollisionShapes shapes;
  std::map<std::string, FramePlace> frames;      ///< by name with prefix
  std::map<std::string, LinkPart> parts;         ///< likewise: each link of a file alone, within the link it went into
  std::vector<std::vector<std::string>> places;  ///< per articulation and link: "file:line: link 'x'"
  GivenSolid solid;                              ///< of surfaces that do not say it themselves
  std::vector<SilentCollision> silent;           ///< whose stiffness is chosen once all is loaded
  std::vector<std::string> missing_pictures;     ///< files of visuals, each once
  std::vector<int> held;  ///< articulations whose joints hold their initial position
  std::vector<JudgedLink> judged;                   ///< all links of the files
  std::map<std::string, std::string> effort_places;  ///< "file:line: joint 'x'" by name with prefix, of those that say an effort
};

/// Appends the robot's articulations, visuals and adjacent-link filters. Throws SetupError.
void addRobot(const RobotFile& robot, const ModelSettings& settings, const SceneOptions& options,
              LoadContext& context);

}  // namespace haptic

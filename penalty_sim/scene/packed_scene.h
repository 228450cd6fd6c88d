/// A loaded scene, or a whole session in it, as one file without text: for programs that have no reader of URDF, as in a browser.
///
/// The fields are those of SceneDef and SessionStart (base/packed_file.h). Doubles are kept bit for bit: the world that is read runs as the
/// one that was written. What moves nothing, such as names of collisions and sources of materials, stays behind. A program whose structs
/// have other fields reads a world with another fingerprint and refuses the file.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "haptic_core/loop/session.h"
#include "haptic_core/spidar/device_def.h"
#include "scene/scene_file.h"

namespace haptic {

/// A scene to touch and the device to touch it with.
struct PackedScene {
  std::uint64_t fingerprint = 0;  ///< of the world (loop/session.h); set when it is packed
  SceneDef scene;                 ///< without the loader's listings
  DeviceDef device;               ///< of all its hands
  std::string about;              ///< for people: the certificate

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.fingerprint), visit(s.scene), visit(s.device), visit(s.about);
  }
};

/// A recorded session with its scene: what a SessionReplay takes, and what it should come to.
struct PackedSession {
  PackedScene scene;              ///< its device is that of the first hand
  SessionStart start;             ///< with the definitions of all devices
  std::vector<LoopEvent> events;  ///< in order
  std::vector<TickInput> ticks;   ///< consecutive
  std::vector<TickHash> hashes;   ///< by tick; `parts` 0: not recorded

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.scene), visit(s.start), visit(s.events), visit(s.ticks), visit(s.hashes);
  }
};

/// The bytes of a file. Throws SetupError for a shape that cannot be packed.
std::string packScene(const PackedScene& scene);
/// The scene again. `where` is for messages. Throws SetupError: no such file, of another version, cut or altered.
PackedScene unpackScene(const std::string& bytes, const std::string& where);
std::string packSession(const PackedSession& session);  ///< see packScene
PackedSession unpackSession(const std::string& bytes, const std::string& where);  ///< see unpackScene

inline constexpr double kDrawnStep = 1.0 / 16384;  ///< of drawn corners [m]: 61 µm; numbers of few bits, which compress
inline constexpr int kDrawnTriangles = 8000;       ///< of a scene; more are not worth a visitor's wait

/// Visuals of files become triangles of the scene, in steps of `step` [m], for whoever has no reader of meshes. Those that cannot be
/// read, and those of more than `most` triangles together, become the shapes that collide.
void drawWithoutFiles(SceneDef& scene, double step = kDrawnStep, int most = kDrawnTriangles);

}  // namespace haptic

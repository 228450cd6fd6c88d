#include "scene/packed_scene.h"

#include "haptic_core/base/packed_file.h"
#include "haptic_core/geometry/shapes/shape_parts.h"
#include "haptic_core/loop/session.h"

namespace haptic {
namespace {

/// Another number where the order of the parts is another.
constexpr char kSceneFormat[] = "haptic scene, packed: 6\n", kSessionFormat[] = "haptic session, packed: 7\n";

/// A program whose structs have other fields reads another world.
void check(const PackedScene& scene, const std::string& where) {
  if (fingerprint(scene.scene.world) == scene.fingerprint) return;
  throw SetupError(where, "was packed by another version", "pack it again, by this version");
}

}  // namespace

std::string packScene(const PackedScene& scene) {
  PackedScene packed = scene;
  packed.fingerprint = fingerprint(scene.scene.world);
  return packFile(kSceneFormat, packed);
}

PackedScene unpackScene(const std::string& bytes, const std::string& where) {
  PackedScene scene = unpackFile<PackedScene>(kSceneFormat, bytes, where);
  check(scene, where);
  return scene;
}

std::string packSession(const PackedSession& session) {
  PackedSession packed = session;
  packed.scene.fingerprint = fingerprint(session.scene.scene.world);
  return packFile(kSessionFormat, packed);
}

PackedSession unpackSession(const std::string& bytes, const std::string& where) {
  PackedSession session = unpackFile<PackedSession>(kSessionFormat, bytes, where);
  check(session.scene, where);
  if (session.hashes.size() == session.ticks.size()) return session;
  throw SetupError(where, "has " + std::to_string(session.hashes.size()) + " hashes of " + std::to_string(session.ticks.size()) + " ticks",
                   "pack it again");
}

}  // namespace haptic

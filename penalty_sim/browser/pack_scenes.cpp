// pack_scenes DEVICE OUT_FOLDER SCENE...: each scene with the device as OUT_FOLDER/NAME.scene, and `packed NAME BYTES` or `left out
// NAME: why` as a line. Exit code 1: nothing was packed.
//
// pack_scenes --run FILE STEPS: `NAME HASH MICROSECONDS`: World::hash() after STEPS steps of a packed scene's world, its hands on their
// paths, and the median of a step.
#include <algorithm>
#include <chrono>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "haptic_core/analysis/certificate.h"
#include "haptic_core/analysis/hand_certificate.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/world.h"
#include "scene/hand_on_path.h"
#include "scene/packed_scene.h"

namespace haptic {
namespace {

/// Certificate of a scene before anybody touches it, in one or two sentences.
std::string aboutScene(const SceneDef& scene, const DeviceDef& device) {
  std::ostringstream out;
  const Certificate certificate = certify(scene.world);
  double limit = INFINITY;
  for (const IslandCertificate& island : certificate.islands) limit = std::min(limit, island.limit);
  out << "Certificate: explicit steps are stable up to ";
  if (std::isfinite(limit)) {
    out << std::round(1e5 * limit) / 100 << " ms (this scene's step: " << 1e3 * certificate.step << " ms).";
  } else {
    out << "any length: at rest nothing touches.";
  }
  for (const HandDef& hand : scene.hands) {
    const HandMapping mapping{hand.workspace.scale, hand.force_scale, hand.delay.total()};
    const HandCertificate held = certifyHand(scene.world, hand.pointer, mapping, device);
    if (held.against.empty()) continue;
    out << " A relaxed hand holds up to " << std::round(held.held) << " N/m; " << held.pointer << " on " << held.against << " meets "
        << std::round(held.stiffness) << " N/m at " << held.press << " N.";
    break;
  }
  return out.str();
}

std::string contents(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

int packAll(const std::string& device_file, const std::filesystem::path& folder, char** first, char** last) {
  const DeviceDef device = loadDevice(device_file);
  int packed = 0;
  for (char** file = first; file != last; ++file) {
    const std::string name = std::filesystem::path(*file).stem().string();
    try {
      PackedScene scene{0, loadScene(*file), device, ""};
      scene.about = aboutScene(scene.scene, device);
      drawWithoutFiles(scene.scene);
      const std::string bytes = packScene(scene), path = (folder / (name + ".scene")).string();
      std::ofstream out(path, std::ios::binary);
      if (!(out << bytes).flush()) throw SetupError(path, "cannot be written", "is the disk full?");
      std::printf("packed %s %zu\n", name.c_str(), bytes.size());
      ++packed;
    } catch (const SetupError& error) {
      std::printf("left out %s: %s\n", name.c_str(), error.what());
    }
    std::fflush(stdout);
  }
  return packed > 0 ? 0 : 1;
}

int run(const std::string& file, int steps) {
  const SceneDef scene = unpackScene(contents(file), file).scene;
  World world(scene.world);
  std::vector<double> times;
  for (int i = 0; i < steps; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    followPaths(scene, world);
    world.step();
    times.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
  }
  std::nth_element(times.begin(), times.begin() + steps / 2, times.end());
  const std::string name = std::filesystem::path(file).stem();
  std::printf("%s %016" PRIx64 " %.3f\n", name.c_str(), world.hash(), times[static_cast<std::size_t>(steps / 2)]);
  return 0;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  try {
    if (argc == 4 && !std::strcmp(argv[1], "--run") && std::atoi(argv[3]) > 0) return haptic::run(argv[2], std::atoi(argv[3]));
    if (argc >= 4 && argv[1][0] != '-') return haptic::packAll(argv[1], argv[2], argv + 3, argv + argc);
  } catch (const haptic::SetupError& error) {
    std::fprintf(stderr, "pack_scenes: %s\n", error.what());
    return 1;
  }
  std::fputs("usage: pack_scenes DEVICE OUT_FOLDER SCENE...\n       pack_scenes --run FILE STEPS\n", stderr);
  return 2;
}

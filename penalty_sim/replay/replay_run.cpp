#include "replay/replay_run.h"

#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>

#include "haptic_core/base/error.h"
#include "haptic_core/spidar/device_def.h"

namespace haptic {
namespace {

/// A file with the recorded text, gone with this object.
class TextFile {
 public:
  TextFile(const std::string& text, const std::string& suffix) {
    std::string pattern = "/tmp/haptic_replay_XXXXXX" + suffix;
    const int file = mkstemps(pattern.data(), static_cast<int>(suffix.size()));
    if (file < 0) throw SetupError(pattern, "cannot be made", "free some space in /tmp");
    close(file);
    path_ = pattern;
    std::ofstream(path_, std::ios::binary) << text;
  }
  ~TextFile() { unlink(path_.c_str()); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string textOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string suffixOf(const std::string& path) {
  const std::size_t dot = path.find_last_of("./");
  return dot != std::string::npos && path[dot] == '.' ? path.substr(dot) : ".urdf";
}

/// From its own place while its text is the recorded one, so that meshes beside it are found; else from the text.
SceneDef loadRecordedScene(const RecordedSession& session, MissingMeshes missing) {
  SceneOptions options;
  options.default_density = session.default_density;
  options.step = session.start.step;
  options.missing = missing;
  const bool unchanged = textOf(session.scene_file) == session.scene_text && !session.scene_text.empty();
  SceneDef scene;
  if (unchanged) {
    scene = loadScene(session.scene_file, options);
  } else {
    const TextFile file(session.scene_text, suffixOf(session.scene_file));
    try {
      scene = loadScene(file.path(), options);
    } catch (const SetupError& error) {  // the name of the temporary file says nothing to a user
      throw SetupError("recorded scene " + session.scene + " (" + session.scene_file + ")", error.what(), "");
    }
  }
  if (session.same_bits && fingerprint(scene.world) != session.fingerprint) {
    throw SetupError("scene " + session.scene, "is not the one that was recorded: a mesh, a model or the loader has changed",
                     "check out the version of the recording (" + session.program + ", " + session.scene_file + ")");
  }
  return scene;
}

/// A recording does not say what its loader did about missing meshes; the fingerprint tells.
SceneDef loadRecordedScene(const RecordedSession& session) {
  std::exception_ptr first;
  for (const MissingMeshesName& row : kMissingMeshes) {
    try {
      return loadRecordedScene(session, row.choice);
    } catch (const SetupError&) {
      if (!first) first = std::current_exception();
    }
  }
  std::rethrow_exception(first);
}

std::vector<DeviceDef> recordedDevices(const RecordedSession& session) {
  std::vector<DeviceDef> devices;
  for (const std::string& text : session.device_texts) {
    const TextFile file(text, ".yaml");
    devices.push_back(loadDevice(file.path()));
  }
  return devices;
}

SessionStart completed(const RecordedSession& session, const std::vector<DeviceDef>& devices) {
  SessionStart start = session.start;
  for (std::size_t i = 0; i < start.hands.size(); ++i) start.hands[i].def = devices[i];
  return start;
}

}  // namespace

ReplayRun::ReplayRun(const RecordedSession& session)
    : session_(session), devices_(recordedDevices(session)), scene_(loadRecordedScene(session)) {
  replay_ = std::make_unique<SessionReplay>(scene_.world, completed(session, devices_));
  if (session.same_bits && replay_->world().hash() != session.world_hash) {
    throw SetupError("scene " + session.scene, "does not start in the recorded state", "use the build that recorded it: " + session.build);
  }
}

ReplayReport ReplayRun::run(const std::function<void(std::uint64_t)>& after_tick) {
  ReplayReport report;
  const auto begin = std::chrono::steady_clock::now();
  std::size_t event = 0;
  for (std::size_t t = 0; t < session_.ticks.size(); ++t) {
    const TickInput& input = session_.ticks[t];
    while (event < session_.events.size() && session_.events[event].tick <= input.tick) {
      replay_->apply(session_.events[event++].command);
    }
    hash_ = replay_->tick(input);
    const TickHash& recorded = session_.hashes[t];
    ++report.steps;
    if (recorded.parts > 0) {
      ++report.compared;
      if (!(hash_ == recorded) && report.mismatches++ == 0) {
        report.first_tick = input.tick;
        report.first_part = "the contacts' memory";
        for (int i = 0; i < std::min(hash_.parts, recorded.parts); ++i) {
          if (hash_.part[i] == recorded.part[i]) continue;
          report.first_part = replay_->partName(i);
          break;
        }
      }
    }
    if (after_tick) after_tick(input.tick);
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  report.simulated = static_cast<double>(report.steps) * session_.start.step;
  return report;
}

}  // namespace haptic

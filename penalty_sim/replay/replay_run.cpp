#include "replay/replay_run.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>

#include "haptic_core/base/error.h"
#include "haptic_core/spidar/device_def.h"
#include "haptic_core/world/model.h"
#include "scene/scene_bodies.h"

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
  if (!session.start.bodies.empty()) scene_ = withBodies(scene_, unpackBodies(session.start.bodies));
  foresee(scene_.world);
  for (const LoopEvent& event : session.events) {
    if (const auto* change = std::get_if<ChangeBodies>(&event.command.kind)) foresee(unpackBodies(*change->packed));
  }
  see();
}

/// The links of a definition that the world has or will have.
void ReplayRun::foresee(const WorldDef& def) {
  for (const ArticulationDef& articulation : def.articulations) {
    std::vector<char> moves;
    for (const LinkDef& link : articulation.links) {
      const bool carried = link.parent >= 0 && moves[static_cast<std::size_t>(link.parent)];
      moves.push_back(carried || link.joint.type != JointType::kFixed);
      const auto known = std::find_if(links_.begin(), links_.end(), [&](const SeenLink& seen) { return seen.name == link.name; });
      if (known == links_.end()) links_.push_back({link.name, moves.back() != 0, -1, Pose()});
    }
  }
}

/// The links that are there now, and what draws those that were not seen before.
void ReplayRun::see() {
  const World& world = replay_->world();
  std::vector<char> drawn(links_.size(), 0);
  for (const auto& [link, visual] : visuals_) drawn[static_cast<std::size_t>(link)] = 1;
  for (SeenLink& link : links_) link.now = -1;
  seen_.clear();
  for (int i = 0; i < world.linkCount(); ++i) {
    const auto known = std::find_if(links_.begin(), links_.end(), [&](const SeenLink& seen) { return seen.name == world.linkName(i); });
    known->now = i;
    seen_.push_back(static_cast<int>(known - links_.begin()));
  }
  for (const VisualDef& visual : scene_.visuals) {
    const int link = seen_[static_cast<std::size_t>(world.model().link(visual.articulation, visual.link))];
    if (!drawn[static_cast<std::size_t>(link)]) visuals_.emplace_back(link, visual);
  }
}

void ReplayRun::follow(const WorldDef& def) {
  scene_ = withBodies(scene_, def);
  see();
}

ReplayReport ReplayRun::run(const std::function<void(std::uint64_t)>& after_tick, const std::function<void()>& before_change) {
  ReplayReport report;
  const auto begin = std::chrono::steady_clock::now();
  std::size_t event = 0;
  for (std::size_t t = 0; t < session_.ticks.size(); ++t) {
    const TickInput& input = session_.ticks[t];
    while (event < session_.events.size() && session_.events[event].tick <= input.tick) {
      const LoopCommand& command = session_.events[event++].command;
      const auto* change = std::get_if<ChangeBodies>(&command.kind);
      if (change && before_change) before_change();
      for (SeenLink& link : links_) {
        if (change && link.now >= 0) link.X_WL = replay_->world().linkPose(link.now);
      }
      replay_->apply(command);
      if (change) follow(unpackBodies(*change->packed));
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
  for (SeenLink& link : links_) {
    if (link.now >= 0) link.X_WL = replay_->world().linkPose(link.now);
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  report.simulated = static_cast<double>(report.steps) * session_.start.step;
  return report;
}

}  // namespace haptic

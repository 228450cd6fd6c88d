// Runs a recorded session again, headless and as fast as it goes, or as topics for rviz at the recorded pace.
#include <penalty_sim/world_topics.h>
#include <ros/init.h>

#include <cctype>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <thread>

#include "haptic_core/base/build_info.h"
#include "haptic_core/base/error.h"
#include "haptic_core/loop/realtime.h"
#include "replay/replay_run.h"
#include "haptic_core/base/program_version.h"

namespace haptic {
namespace {

constexpr char kUsage[] = "usage: haptic_replay BAG [--topics [SPEED]]";

struct Options {
  std::string bag;
  double speed = 0;  ///< of recorded time, with topics; 0: headless, as fast as it goes
};

Options readOptions(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--topics") {
      options.speed = 1;
      if (i + 1 < argc && std::isdigit(static_cast<unsigned char>(argv[i + 1][0]))) options.speed = std::atof(argv[++i]);
      if (!(options.speed > 0)) throw SetupError("--topics", "is no speed", "give a factor > 0");
    } else if (word[0] == '-' || !options.bag.empty()) {
      throw SetupError(word, "is not understood", kUsage);
    } else {
      options.bag = word;
    }
  }
  if (options.bag.empty()) throw SetupError("haptic_replay", "no bag is given", kUsage);
  return options;
}

/// The replayed world as the simulation's topics.
class Shown {
 public:
  Shown(ReplayRun& run, double step, double speed)
      : run_(run),
        period_ns_(static_cast<std::int64_t>(1e9 * step / speed)),
        next_ns_(steadyNow()) {}

  void after() {
    next_ns_ += period_ns_;
    const std::int64_t ahead = next_ns_ - steadyNow();
    if (ahead > kNap) std::this_thread::sleep_for(std::chrono::nanoseconds(ahead));
    if (!stage_) stage_ = std::make_unique<Stage>(nh_, run_);
    stage_->port.noteTick(steadyNow());
    stage_->port.serve([](const LoopCommand&) {});  // what changes the world is in the recording
  }
  void beforeChange() { stage_.reset(); }  // it is of the bodies that there were

 private:
  static constexpr char kName[] = "replay";
  static constexpr std::int64_t kNap = 5000000;  // sleeping less than 5 ms at a time is not worth its jitter [ns]
  static SimulationParameters parameters() {
    SimulationParameters p;
    p.world_frame = "world";
    return p;
  }
  /// Of the bodies that there are.
  struct Stage {
    Stage(ros::NodeHandle& nh, ReplayRun& run)
        : port(run.world(), run.scene().world.name, {}, SceneMarkers::contactCapacity(run.world())),
          offer(PortTable::process(), kName, port, kName),
          lease(PortTable::process().claim<WorldPort>(kName, ClaimRank::kBridge, kName)),
          topics(nh, parameters(), run.scene(), port, offer) {}
    WorldPort port;
    PortOffer offer;
    PortLease<WorldPort> lease;
    WorldTopics topics;
  };
  ros::NodeHandle nh_;
  ReplayRun& run_;
  std::unique_ptr<Stage> stage_;
  std::int64_t period_ns_, next_ns_;
};

int main(int argc, char** argv) {
  const Options options = readOptions(argc, argv);
  const std::vector<RecordedSession> sessions = readSessions(options.bag);
  ReplayReport all;
  bool faulty = false;  // ticks that differ though the same build recorded them
  for (const RecordedSession& session : sessions) {
    if (!session.same_bits) {
      std::printf("recorded by %s (%s): its last bits are another build's than those of this %s (%s). The same inputs are replayed; "
                  "ticks that differ are no fault\n",
                  session.program.c_str(), session.build.c_str(), programVersion().c_str(), buildFlags().c_str());
    }
    ReplayRun run(session);
    std::unique_ptr<Shown> shown;
    if (options.speed > 0) shown = std::make_unique<Shown>(run, session.start.step, options.speed);
    const ReplayReport report = run.run([&](std::uint64_t) { if (shown) shown->after(); }, [&] { if (shown) shown->beforeChange(); });
    std::printf("scene %s, %zu hands: ticks %llu to %llu, %zu events, %llu compared\n", session.scene.c_str(),
                session.start.hands.size(), static_cast<unsigned long long>(session.start.first_tick),
                static_cast<unsigned long long>(session.ticks.back().tick), session.events.size(),
                static_cast<unsigned long long>(report.compared));
    if (report.mismatches > 0) {
      std::printf("first difference: tick %llu, %s\n", static_cast<unsigned long long>(report.first_tick), report.first_part.c_str());
    }
    faulty = faulty || (session.same_bits && report.mismatches > 0);
    all.steps += report.steps;
    all.compared += report.compared;
    all.mismatches += report.mismatches;
    all.seconds += report.seconds;
    all.simulated += report.simulated;
  }
  if (all.compared == 0) throw SetupError(options.bag, "holds no hashes to compare with", "record with ./run demo --record");
  std::printf("figure replay.steps %llu 1\nfigure replay.mismatches %llu 1\nfigure replay.speedup %.4g 1\n",
              static_cast<unsigned long long>(all.steps), static_cast<unsigned long long>(all.mismatches),
              all.seconds > 0 ? all.simulated / all.seconds : 0);
  return faulty ? 1 : 0;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  if (haptic::toldVersion(argc, argv, "haptic_replay")) return 0;
  try {
    for (int i = 1; i < argc; ++i) {
      if (std::strcmp(argv[i], "--topics") == 0) {
        ros::init(argc, argv, "replay", ros::init_options::NoSigintHandler);
        break;
      }
    }
    return haptic::main(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "replay: " << error.what() << "\n";
    return 2;
  }
}

/// `report_run --list`: the scenes, one JSON object per line.
/// `report_run SCENE exact`: the exact solution at the sample times.
/// `report_run --peers`: the peers' settings, likewise. `report_run --default`: METHOD of a world whose user chose nothing.
/// `report_run SCENE METHOD STEP_S[,STEP_S...] [K [FACETS]] [--budget CPU_S] [--limit CPU_S]`: a run of each step. SCENE is a name of
/// the list or a file; METHOD is MODEL-ATTEMPTS (volume-verlet, volume-implicit, volume-sdirk2, volume-automatic, point-...) or a peer of
/// that list. K [N/m³] and FACETS: 0 leaves the scene's own; K `rigid` (or inf) says so of all surfaces.
/// `--accuracy A`: of ours, that a step is asked for (world/definition.h).
/// `--general`: of ours, nothing is left out. `report_run --plan SCENE`: what is left out and why, and where explicit steps are stable.
/// `--limit`: a run that takes longer ends the process by SIGXCPU, and one that would take more than twice as long fails at once.
/// `--seconds T --samples N`: another duration and number of states (beyond the scene's own an exact solution may not hold).
/// SCENE may also be `stackN`, N cubes on one another, or `pyramidN`, a flat pyramid of N = r (r + 1)/2 cubes.
/// Prints for each run a line `run STEP`, lines `key value...`, one line `sample t E px py pz Lx Ly Lz hands bodies F... (p q w x y z,
/// omega, v)...` per sample time, and a line `end`. Exit code 2: wrong usage; a run that fails is a result, with exit code 0.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "../comparators/named_attempts.h"
#include "contactbench_scenes.h"
#include "haptic_core/analysis/certificate.h"
#include "haptic_core/base/cpu_time.h"
#include "haptic_core/base/error.h"
#include "run_case.h"

namespace {

using namespace haptic;
using namespace haptic::report;

std::vector<Scene> allScenes() {
  std::vector<Scene> scenes = motionScenes();
  for (const auto& more : {frictionScenes(), pileScenes(), movingScenes(), benchmarkScenes(), robotScenes()}) {
    scenes.insert(scenes.end(), more.begin(), more.end());
  }
  for (const RuledScene& ruled : contactbenchScenes()) scenes.push_back(ruled.scene);
  return scenes;
}

Scene sceneOf(const std::string& name) {
  const int cubes = name.rfind("stack", 0) == 0 ? std::atoi(name.c_str() + 5) : 0;
  if (cubes > 0 && cubes <= 500 && name == "stack" + std::to_string(cubes)) return stackScene(cubes);
  for (Scene& scene : allScenes()) {
    if (scene.name == name) return scene;
  }
  for (int rows = 1; rows <= 100 && name.rfind("pyramid", 0) == 0; ++rows) {
    if (name == "pyramid" + std::to_string(rows * (rows + 1) / 2)) return pyramidScene(rows);
  }
  if (name.find('.') == std::string::npos && name.find('/') == std::string::npos) {
    throw SetupError("scene '" + name + "'", "is not in the list", "see report_run --list, or give a file");
  }
  return fileScene(name);
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out + "\"";
}

void describe(const Scene& s) {
  std::printf("{\"name\": %s, \"title\": %s, \"parameters\": %s, \"reference\": %s, \"seconds\": %.17g, \"samples\": %d, "
              "\"bodies\": %zu, \"hands\": %zu, \"stiffness\": %.17g, \"stiffer_is_truer\": %s, \"round\": %s, "
              "\"not_for_peers\": %s, \"held\": %s, \"step\": %.17g, \"size\": %.17g, \"chaotic\": %s, "
              "\"smallest_step\": %.17g, \"benchmark\": %s, \"measures\": [",
              quoted(s.name).c_str(), quoted(s.title).c_str(), quoted(s.parameters).c_str(),
              quoted(s.reference).c_str(), s.seconds, s.samples, s.bodies.size(), s.hands.size(), s.stiffness,
              s.stiffer_is_truer ? "true" : "false", s.round ? "true" : "false", quoted(s.not_for_peers).c_str(),
              s.held ? "true" : "false", 1e-3, s.size, s.chaotic ? "true" : "false", s.smallest_step,
              quoted(s.benchmark).c_str());
  for (const Measure& m : s.measures) std::printf("%s%s", &m == s.measures.data() ? "" : ", ", quoted(m.name).c_str());
  std::printf("]}\n");
}

Method methodOf(const std::string& name) {
  Method method;
  for (const peers::NamedPeer& peer : peers::peerTable()) {
    if (name != peer.name) continue;
    method.peer = peer.settings;
    return method;
  }
  const std::size_t dash = name.find('-');
  const std::string model = name.substr(0, dash), rest = dash == std::string::npos ? "" : name.substr(dash + 1);
  for (const auto& ours : comparators::kNamedAttempts) {
    if (rest != ours.name || (model != "volume" && model != "point")) continue;
    if (model == "point" && !ours.comparator) continue;
    method.choice.attempts = ours.attempts;
    method.choice.comparator = model == "point" ? comparators::pointVerlet : ours.comparator;
    return method;
  }
  throw SetupError("method '" + name + "'", "is unknown", "see the head of report_run.cpp");
}

/// `most`: bodies that are printed.
void print(const std::vector<Sample>& samples, std::size_t most) {
  for (const Sample& s : samples) {
    std::printf("sample %.17g %.17g", s.time, s.energy);
    const auto put = [](const Vector3& v) { std::printf(" %.17g %.17g %.17g", v.x(), v.y(), v.z()); };
    put(s.momentum);
    put(s.angular_momentum);
    const std::size_t count = std::min(most, s.bodies.size());
    std::printf(" %zu %zu", s.hands.size(), count);
    for (const Wrench& F : s.hands) {
      put(F.torque);
      put(F.force);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const BodyState& b = s.bodies[i];
      const Quaternion q(b.X_WL.R);
      put(b.X_WL.p);
      std::printf(" %.17g %.17g %.17g %.17g", q.w(), q.x(), q.y(), q.z());
      put(b.V_WL.angular);
      put(b.V_WL.linear);
    }
    std::printf("\n");
  }
}

void print(const RunResult& r, std::size_t most) {
  std::printf("status %s\nreason %s\ntime_reached %.17g\nsteps %ld\nsetup_s %.9g\n", r.status.c_str(), r.reason.c_str(),
              r.time_reached, r.steps, r.setup_s);
  std::printf("cpu_s");
  for (const double t : r.cpu_s) std::printf(" %.9g", t);
  std::printf("\nstep_p50_s %.9g\nstep_p99_s %.9g\nstep_p999_s %.9g\nstep_max_s %.9g\nstep_touching_p50_s %.9g\n"
              "allocations %ld\niterations %ld\niterations_worst %d\nevaluations_worst %d\nunconverged %ld\nenergy_gain %.9g\n",
              r.step_p50, r.step_p99, r.step_p999, r.step_max, r.step_touching_p50, r.allocations, r.iterations, r.iterations_worst,
              r.evaluations_worst, r.unconverged, r.energy_gain);
  for (const auto& [name, value] : r.measures) std::printf("measure_%s %.17g\n", name.c_str(), value);
  print(r.samples, most);
}

/// SIGXCPU comes after `limit` [s] of CPU time more.
void endAfter(double limit) {
  rlimit cpu;
  if (getrlimit(RLIMIT_CPU, &cpu) != 0) return;
  cpu.rlim_cur = std::min(cpu.rlim_max, static_cast<rlim_t>(std::ceil(cpuSeconds() + limit)));
  setrlimit(RLIMIT_CPU, &cpu);
}

/// Nobody compares the motion of a chaotic scene.
std::size_t bodiesPrinted(const Scene& scene) {
  return scene.chaotic ? 1 : 32;
}

int tellPlan(const Scene& scene) {
  const WorldDef def = scene.make({});
  std::printf("%s%s", World(def).planText().c_str(), certify(def, 1.0).text().c_str());
  return 0;
}

int run(int argc, char** argv) {
  std::vector<std::string> words;
  double budget = 0.3;  // [s] of CPU time per run for repetitions
  double seconds = 0, accuracy = 0, limit = 0;
  int samples = 0;
  bool leave_out = true;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--budget") == 0 && i + 1 < argc) {
      budget = std::atof(argv[++i]);
    } else if (std::strcmp(argv[i], "--limit") == 0 && i + 1 < argc) {
      limit = std::atof(argv[++i]);
    } else if (std::strcmp(argv[i], "--accuracy") == 0 && i + 1 < argc) {
      accuracy = std::atof(argv[++i]);
      if (!(accuracy > 0)) throw SetupError("report_run", "accuracy '" + std::string(argv[i]) + "'", "give a number > 0");
    } else if (std::strcmp(argv[i], "--seconds") == 0 && i + 1 < argc) {
      seconds = std::atof(argv[++i]);
    } else if (std::strcmp(argv[i], "--general") == 0) {
      leave_out = false;
    } else if (std::strcmp(argv[i], "--samples") == 0 && i + 1 < argc) {
      samples = std::atoi(argv[++i]);
    } else {
      words.push_back(argv[i]);
    }
  }
  if (words.size() == 1 && words[0] == "--list") {
    for (const Scene& scene : allScenes()) describe(scene);
    return 0;
  }
  if (words.size() == 1 && words[0] == "--peers") {
    for (const peers::NamedPeer& p : peers::peerTable()) {
      std::printf("{\"name\": \"%s\", \"purpose\": \"%s\", \"meaning\": %s}\n", p.name, p.purpose, quoted(p.meaning).c_str());
    }
    return 0;
  }
  if (words.size() == 1 && words[0] == "--default") {
    for (const auto& ours : comparators::kNamedAttempts) {
      if (!ours.comparator && ours.attempts == WorldSettings{}.attempts) std::printf("volume-%s\n", ours.name);
    }
    return 0;
  }
  if (words.size() == 2 && words[0] == "--describe") {
    describe(sceneOf(words[1]));
    return 0;
  }
  if (words.size() == 2 && words[0] == "--plan") return tellPlan(sceneOf(words[1]));
  const auto chosen = [&] {
    Scene scene = sceneOf(words[0]);
    if (seconds > 0) scene.seconds = seconds;
    if (samples > 0) scene.samples = samples;
    return scene;
  };
  if (words.size() == 2 && words[1] == "exact") {
    const Scene scene = chosen();
    if (!scene.exact) throw SetupError("scene " + scene.name, "has no exact solution", "run a method with a small step");
    print(exactSamples(scene), bodiesPrinted(scene));
    return 0;
  }
  if (words.size() < 3 || words.size() > 5) {
    throw SetupError("report_run", "wrong usage", "see the head of report_run.cpp");
  }
  const Scene scene = chosen();
  Method method = methodOf(words[1]);
  if (accuracy > 0) method.choice.accuracy = accuracy;
  method.choice.leave_out = leave_out;
  if (words.size() > 3) {
    method.choice.rigid = words[3] == "rigid" || words[3] == "inf";
    if (!method.choice.rigid) method.choice.stiffness = std::atof(words[3].c_str());
  }
  if (words.size() > 4) method.choice.facets = std::atoi(words[4].c_str());
  std::vector<double> steps;
  std::istringstream list(words[2]);
  for (std::string word; std::getline(list, word, ',');) {
    steps.push_back(std::atof(word.c_str()));
    if (!(steps.back() > 0)) throw SetupError("report_run", "step '" + word + "'", "give seconds > 0");
  }
  for (const double step : steps) {
    method.choice.step = step;
    if (limit > 0) endAfter(limit);
    std::printf("run %.17g\n", step);
    print(runCase(scene, method, budget, limit), bodiesPrinted(scene));
    std::printf("end\n");
    std::fflush(stdout);  // a run that dies takes none of those before it along
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "report_run: %s\n", error.what());
    return 2;
  }
}

// Writes the sessions of a bag into a folder: NAME.npy, a row per tick; NAME.contacts.csv; NAME.yaml, what it
// is; and with --view what a picture needs (session_view.h). With --packed instead of all these NAME.session, which a browser replays
// (scene/packed_scene.h).
// `./run report BAG` and `./run export BAG` read them.
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <iostream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/program_version.h"
#include "scene/packed_scene.h"
#include "session/session_table.h"
#include "session/session_view.h"

namespace haptic {
namespace {

constexpr char kUsage[] = "usage: session_table BAG FOLDER [--view | --packed]";

std::ofstream opened(const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  if (!file) throw SetupError(path, "cannot be written", "give a folder that exists and has room");
  return file;
}

void closed(std::ofstream& file, const std::string& path) {
  file.close();
  if (!file) throw SetupError(path, "cannot be written to its end", "free some space on that disk");
}

/// The format of NumPy's `numpy.save`, version 2.0: a structured array, every field a little-endian double.
std::string npyHeader(const std::vector<std::string>& columns, std::size_t rows) {
  std::string header = "{'descr': [";
  for (std::string name : columns) {
    for (char& c : name) c = c == '\'' || c == '\\' ? '_' : c;
    header += "('" + name + "', '<f8'), ";
  }
  header += "], 'fortran_order': False, 'shape': (" + std::to_string(rows) + ",), }";
  constexpr std::size_t kPrefix = 12, kAlignment = 64;  // magic, version, four bytes of length
  header.append(kAlignment - (kPrefix + header.size() + 1) % kAlignment, ' ');
  header += '\n';
  const auto length = static_cast<std::uint32_t>(header.size());
  return std::string("\x93NUMPY\x02\x00", 8) +
         std::string(reinterpret_cast<const char*>(&length), sizeof length) + header;
}

void writeSpells(const std::string& path, const SessionTable& table, const std::vector<SeenLink>& links) {
  std::ofstream file = opened(path);
  file.precision(9);
  file << "begin,end,link_a,link_b,state,peak_force,peak_depth\n";
  for (const ContactSpell& spell : table.spells()) {
    file << spell.begin << ',' << spell.end << ',' << links[static_cast<std::size_t>(spell.link_a)].name << ','
         << links[static_cast<std::size_t>(spell.link_b)].name << ',' << (spell.sticking ? "stick" : "slip") << ','
         << spell.peak_force << ',' << spell.peak_depth << '\n';
  }
  closed(file, path);
}

/// Names of LoopCommand's kinds for people, in its order.
constexpr const char* kCommandNames[] = {"restore the world",
                                         "tune the world",
                                         "restore the device",
                                         "change a hand",
                                         "device lost",
                                         "calibrate, recover or switch the force",
                                         "pause",
                                         "clutch",
                                         "grab",
                                         "drive a joint",
                                         "one step",
                                         "adopt a calibration",
                                         "tune the device",
                                         "STOP",
                                         "hold the dead-man switch",
                                         "push a link",
                                         "put a body",
                                         "put joints",
                                         "lead a body",
                                         "change bodies",
                                         "set gravity"};
static_assert(std::size(kCommandNames) == std::variant_size_v<LoopCommand::Kind>);

void writeInfo(const std::string& path, const RecordedSession& session, const ReplayRun& run,
               const ReplayReport& report) {
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "scene" << YAML::Value << session.scene << YAML::Key << "scene_file"
      << YAML::Value << session.scene_file << YAML::Key << "program" << YAML::Value << session.program
      << YAML::Key << "build" << YAML::Value << session.build << YAML::Key << "rate" << YAML::Value
      << 1 / session.start.step << YAML::Key << "compared" << YAML::Value << report.compared << YAML::Key
      << "mismatches" << YAML::Value << report.mismatches << YAML::Key << "first_difference" << YAML::Value
      << report.first_part << YAML::Key << "first_difference_time" << YAML::Value
      << static_cast<double>(report.first_tick - std::min(report.first_tick, session.start.first_tick)) *
             session.start.step;
  out << YAML::Key << "hands" << YAML::Value << YAML::BeginSeq;
  for (std::size_t i = 0; i < session.start.hands.size(); ++i) {
    const DeviceDef& def = run.devices()[i];
    out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << session.start.hands[i].device << YAML::Key
        << "model" << YAML::Value << def.name << YAML::Key << "strings" << YAML::Value << def.strings.size()
        << YAML::Key << "dof" << YAML::Value << def.dof << YAML::Key << "max_force" << YAML::Value
        << def.max_force << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::Key << "events" << YAML::Value << YAML::BeginSeq;
  for (const LoopEvent& event : session.events) {
    out << YAML::Flow << YAML::BeginSeq
        << static_cast<double>(event.tick - std::min(event.tick, session.start.first_tick)) *
               session.start.step
        << kCommandNames[event.command.kind.index()] << event.command.hand << YAML::EndSeq;
  }
  out << YAML::EndSeq << YAML::EndMap;
  std::ofstream file = opened(path);
  file << out.c_str() << '\n';
  closed(file, path);
}

void writeView(const std::string& base, const SessionView& view) {
  std::string meshes;
  std::ofstream about = opened(base + ".view.yaml");
  about << view.text(meshes) << '\n';
  closed(about, base + ".view.yaml");
  std::ofstream file = opened(base + ".meshes.bin");
  file << meshes;
  closed(file, base + ".meshes.bin");
}

/// Scene, start, counts, commands and hashes, without anything that would have to be read from other files.
void writePacked(const std::string& path, const RecordedSession& session) {
  const ReplayRun run(session);
  const PackedScene scene{0, run.scene(), {}, "Recorded by " + session.program + "."};
  PackedSession packed{scene, session.start, session.events, session.ticks, session.hashes};
  for (std::size_t i = 0; i < packed.start.hands.size(); ++i) packed.start.hands[i].def = run.devices()[i];
  if (!run.devices().empty()) packed.scene.device = run.devices()[0];
  drawWithoutFiles(packed.scene.scene);
  std::ofstream file = opened(path);
  file << packSession(packed);
  closed(file, path);
}

int main(int argc, char** argv) {
  if (toldVersion(argc, argv, "session_table")) return 0;
  const std::string option = argc == 4 ? argv[3] : "";
  const bool viewed = option == "--view", packed = option == "--packed";
  if (argc != 3 && !viewed && !packed) throw SetupError("session_table", "wants a bag and a folder", kUsage);
  // Another build may differ in last bits: the column `same_bits` and `mismatches` tell.
  const std::vector<RecordedSession> sessions = readSessions(argv[1]);
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const std::string base = std::string(argv[2]) + "/session_" + std::to_string(i + 1);
    if (packed) {
      writePacked(base + ".session", sessions[i]);
      continue;
    }
    ReplayRun run(sessions[i]);
    SessionTable table(sessions[i], run);
    SessionView view(sessions[i], run);
    std::ofstream rows = opened(base + ".npy"), patches;
    if (viewed) patches = opened(base + ".patches.bin");
    rows << npyHeader(table.columns(), sessions[i].ticks.size());
    const ReplayReport report = run.run([&](std::uint64_t) {
      table.addTick();
      rows.write(reinterpret_cast<const char*>(table.row().data()),
                 static_cast<std::streamsize>(table.row().size() * sizeof(double)));
      if (!viewed) return;
      view.addTick();
      const std::vector<float> numbers = view.takePatches();
      patches.write(reinterpret_cast<const char*>(numbers.data()),
                    static_cast<std::streamsize>(numbers.size() * sizeof(float)));
    });
    closed(rows, base + ".npy");
    if (viewed) closed(patches, base + ".patches.bin"), writeView(base, view);
    table.finish();
    writeSpells(base + ".contacts.csv", table, run.links());
    writeInfo(base + ".yaml", sessions[i], run, report);
  }
  return 0;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  try {
    return haptic::main(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}

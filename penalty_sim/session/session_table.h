/// A recorded session as numbers for people's own analysis: one row per tick, one column per quantity.
///
/// The session runs again from its encoder counts (replay/replay_run.h), so every tick has every column,
/// whatever rate the topics had. SI units. Poses and wrenches of a hand are in its device's base, those of
/// bodies in the world.
#pragma once
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "replay/replay_run.h"

namespace haptic {

/// What a pair of links did between two changes: it stuck, or it slid.
struct ContactSpell {
  int link_a = -1, link_b = -1;  ///< of ReplayRun::links
  bool sticking = false;
  double begin = 0, end = 0;  ///< session time [s]
  double peak_force = 0;      ///< normal, of all contacts of the pair [N]
  double peak_depth = 0;      ///< [m]
};

class SessionTable {
 public:
  /// Lists the columns. `run` is the session's and has not run yet.
  SessionTable(const RecordedSession& session, ReplayRun& run);

  /// Makes the row of the tick that `run` has just made.
  void addTick();
  /// Ends the spells that last; after the last tick.
  void finish();

  const std::vector<std::string>& columns() const { return columns_; }
  const std::vector<double>& row() const { return row_; }  ///< of the last tick, a number per column
  const std::vector<ContactSpell>& spells() const { return spells_; }

 private:
  /// How the pointer's contacts hold: the worst of them.
  enum Touch { kNone = 0, kSticks = 1, kSlides = 2 };
  struct PairNow {
    bool sticking = true;
    double force = 0, depth = 0;
  };

  void nameHandColumns(const SessionStart::HandStart& hand, std::size_t strings);
  void put(double value) { row_.push_back(value); }
  void put(const Vector3& v) { put(v.x()), put(v.y()), put(v.z()); }
  void put(const Pose& X);
  void putHand(int hand, const TickInput& input);
  void putTouch(int pointer_link);
  void putWorld();
  double startedAsSeenFrom(std::size_t row);
  void followSpells(double time);
  void followLosses(std::uint64_t tick);
  void end(const std::pair<int, int>& pair, double time);

  const RecordedSession& session_;
  ReplayRun& run_;
  std::vector<std::string> columns_;
  std::vector<double> row_;
  std::size_t tick_ = 0;                 ///< index of the next row
  std::vector<std::size_t> bodies_;      ///< moving links whose poses are columns, of ReplayRun::links
  std::vector<std::size_t> hand_width_;  ///< columns of each recorded hand
  std::vector<int> present_;             ///< by recorded hand: its index in the loop; −1: lost
  std::size_t next_event_ = 0;
  std::map<std::pair<int, int>, ContactSpell> lasting_;
  std::vector<ContactSpell> spells_;
  double time_ = 0;
  std::size_t next_note_ = 0;                                  ///< of the clock, the first after this tick
  double started_ = std::numeric_limits<double>::quiet_NaN();  ///< as seen from there [s]
  std::uint64_t periods_ = 0;                                  ///< before this tick, those lost included
};

}  // namespace haptic

#include "session/session_table.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/loop/hand.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

void addNames(std::vector<std::string>& columns, const std::string& name, const char* parts) {
  for (const char* part = parts; *part; ++part) columns.push_back(name + "_" + *part);
}

}  // namespace

SessionTable::SessionTable(const RecordedSession& session, ReplayRun& run) : session_(session), run_(run) {
  for (const char* name : {"tick", "time", "unix_time", "lost_periods", "same_bits"})
    columns_.push_back(name);
  for (std::size_t i = 0; i < session.start.hands.size(); ++i) {
    present_.push_back(static_cast<int>(i));
    nameHandColumns(session.start.hands[i],
                    run.loop().hand(static_cast<int>(i)).device().def().strings.size());
  }
  for (std::size_t i = 0; i < run.links().size(); ++i) {
    const SeenLink& link = run.links()[i];
    if (!link.moves) continue;
    bodies_.push_back(i);
    addNames(columns_, "body." + link.name + ".position", "xyz");
    addNames(columns_, "body." + link.name + ".orientation", "xyzw");
  }
  for (const char* name : {"contacts", "kinetic", "potential", "elastic", "tangential", "damping", "friction",
                           "turning", "external", "balance", "step_flags", "stopped"}) {
    columns_.push_back(std::string("world.") + name);
  }
  row_.reserve(columns_.size());
}

void SessionTable::nameHandColumns(const SessionStart::HandStart& hand, std::size_t strings) {
  const std::size_t before = columns_.size();
  const std::string name = hand.device + ".";
  for (const char* state : {"state", "flags", "valid"}) columns_.push_back(name + state);
  addNames(columns_, name + "position", "xyz");
  addNames(columns_, name + "orientation", "xyzw");
  addNames(columns_, name + "linear", "xyz");
  addNames(columns_, name + "angular", "xyz");
  columns_.push_back(name + "opening");
  addNames(columns_, name + "pointer_position", "xyz");
  addNames(columns_, name + "pointer_orientation", "xyzw");
  for (const char* wrench : {"asked", "achieved"}) {
    addNames(columns_, name + wrench + "_force", "xyz");
    addNames(columns_, name + wrench + "_torque", "xyz");
  }
  for (const char* scalar : {"contact", "contact_force", "contact_depth", "in_contact", "clutched", "fade",
                             "pose_residual", "port_energy", "dissipated", "buttons"}) {
    columns_.push_back(name + scalar);
  }
  for (const char* each : {"tension_", "length_"}) {
    for (std::size_t s = 0; s < strings; ++s) columns_.push_back(name + each + std::to_string(s));
  }
  hand_width_.push_back(columns_.size() - before);
}

void SessionTable::put(const Pose& X) {
  const Quaternion q(X.R);
  put(X.p), put(q.x()), put(q.y()), put(q.z()), put(q.w());
}

void SessionTable::addTick() {
  const std::size_t row = tick_++;
  row_.clear();
  const TickInput& input = session_.ticks[row];
  followLosses(input.tick);
  time_ = static_cast<double>(row) * session_.start.step;
  periods_ += static_cast<std::uint64_t>(input.lost_periods) + (row > 0);
  put(static_cast<double>(input.tick)), put(time_),
      put(startedAsSeenFrom(row) + static_cast<double>(periods_) * session_.start.step);
  put(input.lost_periods);
  put(session_.hashes[row].parts > 0 ? session_.hashes[row] == run_.hash() : kNothing);
  for (std::size_t i = 0; i < present_.size(); ++i) {
    if (present_[i] >= 0) {
      putHand(present_[i], input);
    } else {
      row_.insert(row_.end(), hand_width_[i], kNothing);
    }
  }
  for (const std::size_t body : bodies_) {
    const int link = run_.links()[body].now;
    if (link >= 0) {
      put(run_.world().linkPose(link));
    } else {
      row_.insert(row_.end(), 7, kNothing);
    }
  }
  putWorld();
  followSpells(time_);
}

/// ROS's clock at the first tick [s]. A message is made up to 20 ms after its last tick, the fastest of a
/// second at once; a tick that is late shifts those after it by parts of a period, so the clock is read anew
/// every second.
double SessionTable::startedAsSeenFrom(std::size_t row) {
  constexpr std::size_t kAround = 30;  // messages before and after: half a second each
  const auto& clock = session_.clock;
  if (clock.empty()) return kNothing;
  while (next_note_ + 1 < clock.size() && clock[next_note_].ticks <= row) ++next_note_, started_ = kNothing;
  if (std::isnan(started_)) {
    const auto first =
        clock.begin() + static_cast<std::ptrdiff_t>(next_note_ - std::min(next_note_, kAround));
    const auto last =
        clock.begin() + static_cast<std::ptrdiff_t>(std::min(clock.size(), next_note_ + kAround + 1));
    started_ = std::min_element(first, last, [](const auto& a, const auto& b) {
                 return a.started < b.started;
               })->started;
  }
  return started_;
}

/// Hands move up when one before them is lost.
void SessionTable::followLosses(std::uint64_t tick) {
  for (; next_event_ < session_.events.size() && session_.events[next_event_].tick <= tick; ++next_event_) {
    const LoopCommand& command = session_.events[next_event_].command;
    if (!command.is<DropHand>()) continue;
    for (int& hand : present_) {
      if (hand == command.hand) {
        hand = -1;
      } else if (hand > command.hand) {
        --hand;
      }
    }
  }
}

void SessionTable::putHand(int index, const TickInput& input) {
  Hand& hand = run_.loop().hand(index);
  const HandReport& report = hand.report();
  const Spidar& device = hand.device();
  put(static_cast<double>(device.state())), put(report.device_flags), put(report.valid);
  if (report.valid) {
    put(report.X_BG), put(report.V_BG.linear), put(report.V_BG.angular);
  } else {
    row_.insert(row_.end(), 13, kNothing);  // no pose before calibration
  }
  put(device.def().dof == 7 ? report.opening : kNothing);
  put(report.X_WP);
  put(report.F_asked_B.force), put(report.F_asked_B.torque), put(report.F_achieved_B.force),
      put(report.F_achieved_B.torque);
  putTouch(run_.world().pointerLink(hand.pointer()));
  put(report.in_contact), put(report.clutched), put(report.fade), put(report.pose_residual);
  put(report.port_energy), put(report.dissipated), put(input.sample[static_cast<std::size_t>(index)].buttons);
  const int strings = static_cast<int>(device.def().strings.size());
  for (int s = 0; s < strings; ++s)
    put(s < static_cast<int>(report.tension.size()) ? report.tension[s] : kNothing);
  for (int s = 0; s < strings; ++s)
    put(s < static_cast<int>(report.length.size()) ? report.length[s] : kNothing);
}

void SessionTable::putTouch(int pointer_link) {
  Touch touch = kNone;
  double force = 0, depth = 0;
  const World& world = run_.world();
  for (int i = 0; i < world.contactCount(); ++i) {
    const ContactReport& contact = world.contact(i);
    if (contact.link_a != pointer_link && contact.link_b != pointer_link) continue;
    touch = touch == kSlides || !contact.sticking ? kSlides : kSticks;
    force += contact.normal_force;
    depth = std::max(depth, contact.depth);
  }
  put(touch), put(force), put(depth);
}

void SessionTable::putWorld() {
  const StepReport& step = run_.world().report();
  const EnergyLedger& energy = step.energy;
  put(run_.world().contactCount());
  put(energy.kinetic), put(energy.potential), put(energy.elastic), put(energy.tangential),
      put(energy.damping);
  put(energy.friction), put(energy.turning), put(energy.external), put(energy.balance()), put(step.flags),
      put(!step.finite);
}

void SessionTable::followSpells(double time) {
  std::map<std::pair<int, int>, PairNow> now;
  const World& world = run_.world();
  for (int i = 0; i < world.contactCount(); ++i) {
    const ContactReport& contact = world.contact(i);
    PairNow& pair = now[{run_.seen(contact.link_a), run_.seen(contact.link_b)}];
    pair.sticking = pair.sticking && contact.sticking;
    pair.force += contact.normal_force;
    pair.depth = std::max(pair.depth, contact.depth);
  }
  for (auto spell = lasting_.begin(); spell != lasting_.end();) {
    const auto pair = now.find(spell->first);
    const bool over = pair == now.end() || pair->second.sticking != spell->second.sticking;
    const auto next = std::next(spell);
    if (over) end(spell->first, time);
    spell = next;
  }
  for (const auto& [links, pair] : now) {
    ContactSpell& spell =
        lasting_.try_emplace(links, ContactSpell{links.first, links.second, pair.sticking, time})
            .first->second;
    spell.peak_force = std::max(spell.peak_force, pair.force);
    spell.peak_depth = std::max(spell.peak_depth, pair.depth);
  }
}

void SessionTable::end(const std::pair<int, int>& pair, double time) {
  const auto spell = lasting_.find(pair);
  spell->second.end = time;
  spells_.push_back(spell->second);
  lasting_.erase(spell);
}

void SessionTable::finish() {
  while (!lasting_.empty()) end(lasting_.begin()->first, time_ + session_.start.step);
  std::sort(spells_.begin(), spells_.end(),
            [](const ContactSpell& a, const ContactSpell& b) { return a.begin < b.begin; });
}

}  // namespace haptic

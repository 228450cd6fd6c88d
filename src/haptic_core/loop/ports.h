/// How the parts of one process lend each other a device or a world: one table, names, leases.
///
/// An owner *offers* a port under a name; a runner *claims* it and drives it by direct call. A claim is a lease:
/// to unload, the owner asks for it back (`PortOffer::withdraw`) and waits, bounded, until the runner has let go.
/// A shared_ptr would keep the object but not the code of an unloaded library.
/// While a runner has a port, its owner sends commands through the port's ring (PortOffer::send).
/// A runner of higher rank asks a lower one to make room: the bridge takes a device from the driver's own thread.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <variant>
#include <vector>

#include "haptic_core/base/command_ring.h"
#include "haptic_core/base/record_ring.h"
#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/loop/realtime.h"
#include "haptic_core/spidar/calibration.h"
#include "haptic_core/spidar/device_record.h"
#include "haptic_core/spidar/hand_path.h"

namespace haptic {

/// What every port has, beside a type Command and a ring of them, `commands`.
class Port {
 public:
  virtual ~Port() = default;
  /// Carries out the waiting commands of a port without a runner.
  virtual void serve() noexcept = 0;
};

/// A device between two ticks, copied for other threads.
struct DeviceCopy {
  /// Of its last tick.
  DeviceRecord record;
  /// As it is now: exits, lengths at count 0, residual of the pose.
  Calibration calibration;
};

/// What keeps the force of a device on: a hand on a switch. Without one, nothing is asked for.
struct DeadMan {
  bool used = false;                      ///< set by the owner before it offers the port
  int button = -1;                        ///< bit of the grip's buttons that must be pressed; -1: `held_until_ns` counts
  std::atomic<std::int64_t> held_until_ns{0};  ///< steady clock [ns]; a level that another thread sets

  /// (in realtime) The switch is held now.
  bool held(const DeviceSample& sample) const noexcept {
    if (button >= 0) return (sample.buttons >> button & 1u) != 0;
    return steadyNow() < held_until_ns.load(std::memory_order_relaxed);
  }
};

/// A device on offer. Everything is the owner's; the runner of the lease alone calls `device` and `transport`.
class DevicePort : public Port {
 public:
  /// Set-up: `record_capacity` ticks wait for the owner at most; device and transport must outlive the port.
  DevicePort(Spidar& device_in, Transport& transport_in, std::size_t record_capacity)
      : device(device_in), transport(transport_in), records(record_capacity) {}
  /// (in realtime) Tells the owner what this tick did; the runner calls it after `actuate`.
  void record(std::uint64_t tick, std::int64_t stamp_ns, const DeviceSample& sample) noexcept;

  /// Command: a copy of the device into the sender's storage. Allocates where that has no room.
  struct Copy {
    DeviceCopy* into;  ///< the sender's
  };
  /// Commands that other threads may send.
  using Command = std::variant<Tell, Copy>;
  /// (in realtime: one atomic load when nothing waits) The runner's, between an exchange and `sense`: gives `take` the requests
  /// of set-up and the commands since. A calibration is refused where this tick has no fresh counts of every board.
  template <class Take>
  void serve(const DeviceSample& sample, Take&& take) noexcept {
    const DeviceRequests at_start = device.takeRequests(sample);
    if (at_start.any()) take(LoopCommand{AskDevice{at_start}});
    if (dead_man.used && dead_man.held(sample) != device.held()) take(LoopCommand{HoldSwitch{!device.held()}});
    drain([&](const LoopCommand& command) {
      requireCounts(command, sample);
      take(command);
    });
  }
  void serve() noexcept override;

  /// The owner's.
  Spidar& device;
  /// The owner's: exchanges with the device.
  Transport& transport;
  DeadMan dead_man;                      ///< the owner's
  bool follows_script = false;           ///< a twin whose hand the scene may script; set by the owner before it offers the port
  RecordRing<DeviceRecord> records;      ///< runner → owner, for topics
  CommandRing<Command> commands;         ///< owner → runner

 private:
  template <class Take>
  void drain(Take&& take) noexcept {
    commands.drain([&](const Command& command) {
      if (const auto* copy = std::get_if<Copy>(&command)) copyTo(*copy->into);
      const auto* tell = std::get_if<Tell>(&command);
      for (std::size_t i = 0; tell && i < tell->count; ++i) take(tell->first[i]);
    });
  }
  void requireCounts(const LoopCommand& command, const DeviceSample& sample) const;
  void copyTo(DeviceCopy& copy) const;
};

/// The visible state of a world between two ticks, copied for drawing.
struct WorldSnapshot {
  std::int64_t stamp_ns = 0;             ///< steady clock
  double time = 0;                       ///< simulated [s]
  int bodies = 0;                        ///< of WorldPort::bodiesChanged() when it was sized; of another it is left as it is
  /// Of the last step.
  StepReport report;
  std::vector<Pose> pose;                ///< X_WL per link; sized at set-up
  std::vector<char> stands;              ///< per link: `World::stands`; sized at set-up
  std::vector<JointReading> joint;       ///< per joint; sized at set-up
  std::vector<ContactReport> contact;    ///< sized at set-up; the first `contacts` are valid
  std::vector<Vector3> slip;             ///< per contact: `slipOf` of contact_detail.h [m/s]
  std::vector<Wrench> pointer_wrench;    ///< per pointer, about the link's origin, in W
  /// Valid entries of `contact`.
  int contacts = 0;
};

/// A sample of a sensor on its way to a topic.
struct SensorSample {
  std::int64_t stamp_ns = 0;             ///< of the tick, steady clock
  int sensor = 0;                        ///< index in the world
  SensorReading reading;                 ///< see there
};

/// A world between two ticks, complete: for who runs its motion again (world/error_estimate.h).
struct WorldCopy {
  std::int64_t stamp_ns = 0;             ///< steady clock
  double time = 0;                       ///< simulated [s]
  int bodies = 0;                        ///< as in WorldSnapshot
  /// Of the last step.
  StepReport report;
  StageTimes stages;                     ///< mean over the steps since WorldPort::TimeStages [s]; NaN: none
  std::vector<double> state;             ///< World::save(); room for the greatest at set-up
  /// World::hash() of it.
  std::uint64_t hash = 0;
  /// That the state was reached with.
  WorldTuning tuning;
  std::vector<PointerBound> bounds;      ///< World::pointerBound(), by pointer; sized at set-up
};

/// Which device moves which pointer, and how the hand sees the world.
struct HandPlacement {
  std::string device;                    ///< name of the device's port, without leading slash
  /// Index in the world.
  int pointer = 0;
  /// Its initial ones.
  HandSettings settings;
  HandPath path;                         ///< for a twin that follows the scene's script; in the device's base
};

/// Where a world came from, for a recording to build it again.
struct SceneSource {
  /// Absolute path of the scene's file, and its text.
  std::string file, text;                ///< absolute path, and its contents
  double default_density = 0;            ///< [kg/m³], as given to the loader
  std::uint64_t fingerprint = 0;         ///< of the definition, see loop/session.h
};

/// Storage of a port that depends on the bodies of its world. The owner makes it for the next bodies; the runner swaps it, and the owner
/// frees the old one.
struct WorldRoom {
  std::shared_ptr<const WorldDef> definition;      ///< for who judges the scene; null: not known
  std::shared_ptr<std::vector<double>> bodies;     ///< ChangeBodies::packed; null: those of WorldPort::source
  std::vector<std::uint64_t> streamed;             ///< by sensor: step of the last sample that went out
};

/// A world on offer.
class WorldPort : public Port {
 public:
  /// Set-up: the world must outlive the port; snapshots hold up to `contact_capacity` contacts.
  WorldPort(World& world_in, std::string scene_name, std::vector<HandPlacement> placements, int contact_capacity);
  /// Command: commands to the world, and its state after them.
  struct Change {
    Tell tell;                               ///< to be taken in order
    std::uint64_t* hash;                     ///< of the sender: gets World::hash() after the last one; null: not wanted
  };
  /// Command: bodies come or go (ChangeBodies, with its NextWorld), and the port's room with them.
  struct Exchange {
    const LoopCommand* change;               ///< the sender's
    WorldRoom* room;                         ///< the sender's, for the new bodies; that of the old ones when it is answered
  };
  /// Command: World::rehearse, before an Exchange and in a tick of its own.
  struct Rehearse {
    NextWorld* next;                         ///< the sender's
    bool steps;                              ///< see there
  };
  /// Command: a copy for drawing into the sender's storage, which comes from `first_snapshot`.
  struct Look {
    WorldSnapshot* into;                     ///< the sender's
  };
  /// Command: a complete copy into the sender's storage, which comes from `first_copy`.
  struct Copy {
    WorldCopy* into;                         ///< the sender's
  };
  /// Command: steps are timed stage by stage from now on, or no longer.
  struct TimeStages {
    bool on;                                 ///< false: no longer
  };
  /// Command: every sample goes to `samples` from now on, or no longer.
  struct StreamSensors {
    bool on;                                 ///< false: no longer
  };
  /// Commands that other threads may send.
  using Command = std::variant<Change, Exchange, Rehearse, Look, Copy, TimeStages, StreamSensors>;
  /// (in realtime: one atomic load when nothing waits) The runner's, between two ticks: gives `take` the commands to the world,
  /// and does the rest itself. Copies do not allocate.
  template <class Take>
  void serve(Take&& take) noexcept {
    commands.drain([&](const Command& command) {
      if (const auto* change = std::get_if<Change>(&command)) {
        for (std::size_t i = 0; i < change->tell.count; ++i) takeBy(take, change->tell.first[i]);
        if (change->hash) *change->hash = world.hash();
      } else if (const auto* exchange = std::get_if<Exchange>(&command)) {
        take(*exchange->change);
        follow(*exchange->room);
      } else {
        answer(command);
      }
    });
  }
  void serve() noexcept override;
  /// (in realtime) The runner's, at the end of each tick, which began at `stamp_ns`.
  void noteTick(std::int64_t stamp_ns) noexcept;
  int bodiesChanged() const noexcept { return bodies_changed_; }  ///< how often bodies came or went; between two ticks
  /// packBodies() of the present bodies, between two ticks; null: as `source` says.
  const std::shared_ptr<std::vector<double>>& bodies() const noexcept { return room_.bodies; }
  const std::shared_ptr<const WorldDef>& definition() const noexcept { return room_.definition; }  ///< likewise: the world's definition
  void define(std::shared_ptr<const WorldDef> def) { room_.definition = std::move(def); }  ///< by the owner before it offers the port
  /// The owner's, after an Exchange: first_snapshot and first_copy for the bodies there are now, with stamp 0.
  void resize(int contact_capacity, std::size_t state_capacity);
  bool paused() const noexcept { return paused_; }  ///< the runner keeps the device alive, but does not step

  /// The owner's; the runner of the lease steps it.
  World& world;
  /// Name of the scene.
  const std::string scene;
  /// Which devices move which pointers.
  const std::vector<HandPlacement> hands;
  SceneSource source;                        ///< set by the owner before it offers the port
  WorldSnapshot first_snapshot;              ///< at set-up, with stamp 0; constant but for `resize`
  WorldCopy first_copy;                      ///< likewise
  CommandRing<Command> commands;             ///< owner → runner
  RecordRing<SensorSample> samples;          ///< runner → owner, while `StreamSensors` is on; a second of them at 1 kHz

 private:
  template <class Take>
  void takeBy(Take&& take, const LoopCommand& command) {
    if (needsPause(command) && !paused_) {
      throw SetupError(command.is<StepWorld>() ? "step" : "put", "the world is not paused", "pause it first");
    }
    if (command.is<ChangeBodies>()) throw SetupError("bodies", "come and go with the port's room", "send WorldPort::Exchange");
    take(command);
    if (const auto* pause = std::get_if<PauseWorld>(&command.kind)) paused_ = pause->on;
  }
  void follow(WorldRoom& room) noexcept;
  void answer(const Command& command) noexcept;
  void copyTo(WorldSnapshot& snapshot) const noexcept;
  void copyTo(WorldCopy& copy) const noexcept;
  void streamSensors() noexcept;

  std::int64_t stamp_ns_ = 0;                ///< of the last tick
  bool paused_ = false;                      ///< as told; changes between two ticks only
  bool timing_ = false;
  StageTimes stage_sum_;                     ///< of the steps since TimeStages [s]
  int steps_timed_ = 0;
  bool streams_ = false;
  WorldRoom room_;
  int bodies_changed_ = 0;
};

/// Kind of a port on offer.
enum class PortKind : unsigned char { kDevice, kWorld };
/// Who claims: the owner's own thread, or the bridge, for which an owner makes room.
enum class ClaimRank : unsigned char { kOwner, kBridge };

template <class T>
struct PortTraits;
/// Of a device.
template <>
struct PortTraits<DevicePort> {
  /// Its table.
  static constexpr PortKind kKind = PortKind::kDevice;
};
/// Of a world.
template <>
struct PortTraits<WorldPort> {
  /// Its table.
  static constexpr PortKind kKind = PortKind::kWorld;
};

/// How long an owner waits for its port, and a claimant of higher rank for its turn: longer than any exchange
/// (a silent UART gives up after 15 ms ten times) and shorter than a pause that a user takes for a hang.
inline constexpr std::chrono::milliseconds kPortPatience{1000};

class PortSlot;
bool portRecalled(const PortSlot& slot) noexcept;  ///< (in realtime) for PortLease
void releasePort(PortSlot& slot);                  ///< for PortLease

/// A runner's hold on a port. Movable; lets go when destroyed.
template <class T>
class PortLease {
 public:
  PortLease() = default;
  /// Used by PortTable::claim.
  PortLease(std::shared_ptr<PortSlot> slot, T* port) : slot_(std::move(slot)), port_(port) {}
  /// The other lease is empty afterwards.
  PortLease(PortLease&& other) noexcept { swap(other); }
  /// Lets its own port go first; the other lease is empty afterwards.
  PortLease& operator=(PortLease&& other) noexcept {
    PortLease(std::move(other)).swap(*this);
    return *this;
  }
  ~PortLease() { release(); }

  /// It holds a port.
  explicit operator bool() const { return port_ != nullptr; }
  /// The port; only while it holds one.
  T& operator*() const { return *port_; }
  /// The port; only while it holds one.
  T* operator->() const { return port_; }
  /// (in realtime) The owner, or a higher rank, wants it back: let go soon.
  bool recalled() const noexcept { return slot_ && portRecalled(*slot_); }
  /// Lets go at once; does nothing without a port.
  void release() {
    if (slot_) releasePort(*slot_);
    slot_.reset();
    port_ = nullptr;
  }

 private:
  void swap(PortLease& other) noexcept {
    std::swap(slot_, other.slot_);
    std::swap(port_, other.port_);
  }
  std::shared_ptr<PortSlot> slot_;
  T* port_ = nullptr;
};

/// The table of one process. Its functions may block; none is for a tick.
class PortTable {
 public:
  static PortTable& process();  ///< the one that all of the process share

  /// Takes the port, within `patience` when a lower rank must make room first. Empty when there is no such port,
  /// or it is held: `reason`, if given, says which. `holder` names the runner for others to read.
  template <class T>
  PortLease<T> claim(const std::string& name, ClaimRank rank, const std::string& holder,
                     std::string* reason = nullptr, std::chrono::milliseconds patience = kPortPatience) {
    auto slot = claimSlot(PortTraits<T>::kKind, name, rank, holder, reason, patience);
    T* port = slot ? static_cast<T*>(slotPort(*slot)) : nullptr;
    return PortLease<T>(std::move(slot), port);
  }
  /// Of all ports of a kind that are on offer.
  std::vector<std::string> names(PortKind kind) const;

  /// Used by PortOffer. Throws SetupError when the name is taken.
  std::shared_ptr<PortSlot> add(PortKind kind, const std::string& name, Port* port, const std::string& owner);
  /// Used by PortOffer; does not wait.
  void remove(const std::shared_ptr<PortSlot>& slot);

 private:
  std::shared_ptr<PortSlot> claimSlot(PortKind, const std::string& name, ClaimRank, const std::string& holder,
                                      std::string* reason, std::chrono::milliseconds patience);
  static Port* slotPort(PortSlot& slot);
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<PortSlot>> slots_;
};

/// An owner's offer. Ends with `withdraw`, at the latest in the destructor.
class PortOffer {
 public:
  PortOffer() = default;
  /// Throws SetupError when another owner offers the same name.
  template <class T>
  PortOffer(PortTable& table, const std::string& name, T& port, const std::string& owner)
      : table_(&table), slot_(table.add(PortTraits<T>::kKind, name, &port, owner)) {}
  /// The other offer is empty afterwards.
  PortOffer(PortOffer&& other) noexcept : table_(other.table_), slot_(std::move(other.slot_)) {}
  /// Withdraws its own port first; the other offer is empty afterwards.
  PortOffer& operator=(PortOffer&& other) noexcept;
  ~PortOffer() { withdraw(); }

  /// Asks for the port back and waits. True: no runner uses it, or will. False: the runner did not let go in time;
  /// the offer is gone, but the port must stay alive.
  bool withdraw(std::chrono::milliseconds patience = kPortPatience);
  std::string holder() const;            ///< name of the runner; empty: none
  /// The present runner has this rank.
  bool heldBy(ClaimRank rank) const;
  /// Has a command to the offered `port` carried out where it cannot overlap a tick: between two of the runner's, or here when
  /// the port has no runner. False: no runner took it in time, nothing was done and nothing will be. Throws the SetupError that
  /// refused it.
  template <class T>
  bool send(T& port, const typename T::Command& command, std::chrono::milliseconds patience = kPortPatience) {
    return slot_ && port.commands.send(command, patience, [this] { serveUnheld(); });
  }

 private:
  void serveUnheld();
  PortTable* table_ = nullptr;
  std::shared_ptr<PortSlot> slot_;
};

}  // namespace haptic

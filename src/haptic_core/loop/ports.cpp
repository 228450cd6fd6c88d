#include "haptic_core/loop/ports.h"

#include <algorithm>
#include <condition_variable>
#include <thread>

#include "haptic_core/base/error.h"
#include "haptic_core/world/contact_detail.h"
#include "haptic_core/world/step_history.h"
#include "haptic_core/world/work.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

WorldSnapshot emptySnapshot(const World& world, int contact_capacity) {
  WorldSnapshot snapshot;
  snapshot.pose.resize(world.linkCount());
  snapshot.stands.resize(world.linkCount());
  snapshot.joint.resize(world.jointCount());
  snapshot.contact.resize(contact_capacity);
  snapshot.slip.resize(contact_capacity);
  snapshot.pointer_wrench.resize(world.pointerCount());
  return snapshot;
}

WorldCopy emptyCopy(const World& world) {
  WorldCopy copy;
  copy.state.resize(world.history().latest().packedCapacity());
  copy.tuning = world.tuning();
  copy.bounds.resize(static_cast<std::size_t>(world.pointerCount()));
  return copy;
}

/// A second of every sensor at 1 kHz, with room for some that come later.
std::size_t sampleCapacity(const World& world) { return 1000 * static_cast<std::size_t>(4 + world.sensorCount()); }

const char* kindName(PortKind kind) { return kind == PortKind::kDevice ? "device" : "world"; }

}  // namespace

/// One line of the table. `mutex` guards everything but `recall`, which the runner reads in its loop.
class PortSlot {
 public:
  PortSlot(PortKind kind_in, std::string name_in, Port* port_in, std::string owner_in)
      : kind(kind_in), name(std::move(name_in)), owner(std::move(owner_in)), port(port_in) {}

  void release() {
    {
      std::lock_guard<std::mutex> lock(mutex);
      held = false;
      holder.clear();
      recall.store(withdrawn || waiting_bridges > 0, std::memory_order_release);
    }
    changed.notify_all();
  }

  /// Takes the slot for `rank`, making a lower rank let go. Empty string: taken; else why not.
  std::string take(ClaimRank by, const std::string& who, std::chrono::milliseconds patience) {
    std::unique_lock<std::mutex> lock(mutex);
    if (withdrawn) return "is being withdrawn";
    if (held && rank >= by) return "is held by " + holder;
    if (by == ClaimRank::kOwner && waiting_bridges > 0) return "is about to be taken by the bridge";
    if (held) {
      ++waiting_bridges;
      recall.store(true, std::memory_order_release);
      const bool free = changed.wait_for(lock, patience, [&] { return !held || withdrawn; });
      --waiting_bridges;
      if (withdrawn) return "is being withdrawn";
      if (!free) {
        recall.store(withdrawn || waiting_bridges > 0, std::memory_order_release);
        return "was not released by " + holder + " in time";
      }
      if (held) return "is held by " + holder;
    }
    held = true;
    rank = by;
    holder = who;
    recall.store(waiting_bridges > 0 && by == ClaimRank::kOwner, std::memory_order_release);
    return {};
  }

  bool withdraw(std::chrono::milliseconds patience) {
    std::unique_lock<std::mutex> lock(mutex);
    withdrawn = true;
    recall.store(true, std::memory_order_release);
    changed.notify_all();
    return changed.wait_for(lock, patience, [&] { return !held; });
  }

  void serveUnheld() {
    std::lock_guard<std::mutex> lock(mutex);  // keeps claimants out meanwhile
    if (!held) port->serve();
  }

  const PortKind kind;
  const std::string name, owner;
  Port* const port;
  std::mutex mutex;
  std::condition_variable changed;
  bool held = false, withdrawn = false;
  int waiting_bridges = 0;
  ClaimRank rank = ClaimRank::kOwner;
  std::string holder;
  std::atomic<bool> recall{false};
};

void DevicePort::record(std::uint64_t tick, std::int64_t stamp_ns, const DeviceSample& sample) noexcept {
  records.push(recordOf(device, tick, stamp_ns, sample));
}

/// Requests are refused: no tick follows now, and a later one must not carry them out.
void DevicePort::serve() noexcept {
  drain([this](const LoopCommand& command) {
    if (command.is<AskDevice>()) throw SetupError(device.def().name, "nobody runs the device", "start a bridge, or set ~alone");
    apply(command, device);
  });
}

void DevicePort::requireCounts(const LoopCommand& command, const DeviceSample& sample) const {
  const auto* ask = std::get_if<AskDevice>(&command.kind);
  if (!ask || !ask->requests.calibrate) return;
  if (device.stopped())
    throw SetupError(device.def().name, "the motors are off since STOP and the strings may be slack", "call recover first");
  if (bringsCounts(sample.status)) return;
  throw SetupError(device.def().name, "no fresh counts came of every board", "ask again");
}

void DevicePort::copyTo(DeviceCopy& copy) const {
  copy.record = recordOf(device, 0, 0, {});
  copy.calibration.p_BE.clear();
  for (const StringDef& string : device.def().strings) copy.calibration.p_BE.push_back(string.p_BE);
  copy.calibration.zero_length = device.zeroLengths();
  copy.calibration.residual = device.solution().residual;
}

WorldPort::WorldPort(World& world_in, std::string scene_name, std::vector<HandPlacement> placements, int contact_capacity)
    : world(world_in),
      scene(std::move(scene_name)),
      hands(std::move(placements)),
      first_snapshot(emptySnapshot(world_in, contact_capacity)),
      first_copy(emptyCopy(world_in)),
      samples(sampleCapacity(world_in)) {
  room_.streamed.assign(static_cast<std::size_t>(world_in.sensorCount()), 0);
  copyTo(first_snapshot);
}

void WorldPort::serve() noexcept {
  serve([this](const LoopCommand& command) { apply(command, world); });
}

void WorldPort::resize(int contact_capacity, std::size_t state_capacity) {
  first_snapshot = emptySnapshot(world, contact_capacity);
  first_copy.state.assign(state_capacity, 0);
  first_copy.stamp_ns = 0;
  first_snapshot.bodies = first_copy.bodies = bodies_changed_;
}

/// Who listens to sensors asks anew, by their new indices.
void WorldPort::follow(WorldRoom& room) noexcept {
  std::swap(room_, room);
  ++bodies_changed_;
  streams_ = false;
}

void WorldPort::answer(const Command& command) noexcept {
  if (const auto* rehearse = std::get_if<Rehearse>(&command)) world.rehearse(*rehearse->next, rehearse->steps);
  if (const auto* look = std::get_if<Look>(&command)) copyTo(*look->into);
  if (const auto* copy = std::get_if<Copy>(&command)) copyTo(*copy->into);
  if (const auto* stream = std::get_if<StreamSensors>(&command)) streams_ = stream->on;
  if (const auto* time = std::get_if<TimeStages>(&command)) {
    timing_ = time->on;
    world.measureStages(timing_);
    stage_sum_ = {0, 0, 0, 0, 0};
    steps_timed_ = 0;
  }
}

void WorldPort::noteTick(std::int64_t stamp_ns) noexcept {
  stamp_ns_ = stamp_ns;
  if (streams_) streamSensors();
  if (!timing_) return;
  const StageTimes& times = world.report().stages;
  stage_sum_ = {stage_sum_.search + times.search, stage_sum_.detection + times.detection, stage_sum_.volume + times.volume,
                stage_sum_.force + times.force, stage_sum_.motion + times.motion};
  ++steps_timed_;
}

/// Samples that were not there at the end of the last tick.
void WorldPort::streamSensors() noexcept {
  for (std::size_t i = 0; i < room_.streamed.size(); ++i) {
    const SensorReading& reading = world.sensorReading(static_cast<int>(i));
    if (reading.step == 0 || reading.step == room_.streamed[i]) continue;
    room_.streamed[i] = reading.step;
    samples.push({stamp_ns_, static_cast<int>(i), reading});
  }
}

void WorldPort::copyTo(WorldCopy& copy) const noexcept {
  if (copy.bodies != bodies_changed_) return;
  const double n = steps_timed_;  // 0/0: NaN, not measured
  copy.stamp_ns = stamp_ns_;
  copy.time = world.time();
  copy.report = world.report();
  copy.stages = {stage_sum_.search / n, stage_sum_.detection / n, stage_sum_.volume / n, stage_sum_.force / n,
                 stage_sum_.motion / n};
  world.history().latest().pack(copy.state);
  copy.hash = world.hash();
  copy.tuning = world.tuning();
  for (int i = 0; i < world.pointerCount(); ++i) copy.bounds[static_cast<std::size_t>(i)] = world.pointerBound(i);
}

void WorldPort::copyTo(WorldSnapshot& snapshot) const noexcept {
  if (snapshot.bodies != bodies_changed_) return;
  snapshot.stamp_ns = stamp_ns_;
  snapshot.time = world.time();
  snapshot.report = world.report();
  for (std::size_t i = 0; i < snapshot.pose.size(); ++i) {
    snapshot.pose[i] = world.linkPose(static_cast<int>(i));
    snapshot.stands[i] = world.stands(static_cast<int>(i));
  }
  for (std::size_t i = 0; i < snapshot.joint.size(); ++i) snapshot.joint[i] = world.joint(static_cast<int>(i));
  for (std::size_t i = 0; i < snapshot.pointer_wrench.size(); ++i) {
    snapshot.pointer_wrench[i] = world.pointerWrench(static_cast<int>(i));
  }
  snapshot.contacts = std::min<int>(world.contactCount(), static_cast<int>(snapshot.contact.size()));
  for (int i = 0; i < snapshot.contacts; ++i) {
    const ContactReport& contact = snapshot.contact[i] = world.contact(i);
    snapshot.slip[i] = slipOf(world.model(), contact, world.work().placement.link.data());
  }
}

bool portRecalled(const PortSlot& slot) noexcept { return slot.recall.load(std::memory_order_acquire); }

void releasePort(PortSlot& slot) { slot.release(); }

PortTable& PortTable::process() {
  static PortTable table;
  return table;
}

std::shared_ptr<PortSlot> PortTable::add(PortKind kind, const std::string& name, Port* port,
                                         const std::string& owner) {
  std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& slot : slots_) {
    if (slot->kind == kind && slot->name == name) {
      throw SetupError(owner, std::string("the ") + kindName(kind) + " port " + name + " is already offered by " +
                                  slot->owner, "run this one in another namespace");
    }
  }
  slots_.push_back(std::make_shared<PortSlot>(kind, name, port, owner));
  return slots_.back();
}

void PortTable::remove(const std::shared_ptr<PortSlot>& slot) {
  std::lock_guard<std::mutex> lock(mutex_);
  slots_.erase(std::remove(slots_.begin(), slots_.end(), slot), slots_.end());
}

std::vector<std::string> PortTable::names(PortKind kind) const {
  std::lock_guard<std::mutex> lock(mutex_);
  std::vector<std::string> result;
  for (const auto& slot : slots_) {
    if (slot->kind == kind) result.push_back(slot->name);
  }
  return result;
}

std::shared_ptr<PortSlot> PortTable::claimSlot(PortKind kind, const std::string& name, ClaimRank rank,
                                               const std::string& holder, std::string* reason,
                                               std::chrono::milliseconds patience) {
  std::shared_ptr<PortSlot> found;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    for (const auto& slot : slots_) {
      if (slot->kind == kind && slot->name == name) found = slot;
    }
  }
  const std::string refusal = found ? found->take(rank, holder, patience) : "is not offered in this process";
  if (refusal.empty()) return found;
  if (reason) *reason = std::string("the ") + kindName(kind) + " port " + name + " " + refusal;
  return nullptr;
}

Port* PortTable::slotPort(PortSlot& slot) { return slot.port; }

PortOffer& PortOffer::operator=(PortOffer&& other) noexcept {
  withdraw();
  table_ = other.table_;
  slot_ = std::move(other.slot_);
  return *this;
}

bool PortOffer::withdraw(std::chrono::milliseconds patience) {
  if (!slot_) return true;
  const bool free = slot_->withdraw(patience);
  table_->remove(slot_);
  slot_.reset();
  return free;
}

std::string PortOffer::holder() const {
  if (!slot_) return {};
  std::lock_guard<std::mutex> lock(slot_->mutex);
  return slot_->holder;
}

bool PortOffer::heldBy(ClaimRank rank) const {
  if (!slot_) return false;
  std::lock_guard<std::mutex> lock(slot_->mutex);
  return slot_->held && slot_->rank == rank;
}

void PortOffer::serveUnheld() { slot_->serveUnheld(); }

}  // namespace haptic

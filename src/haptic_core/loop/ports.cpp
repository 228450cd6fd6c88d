#include "haptic_core/loop/ports.h"

#include <algorithm>
#include <condition_variable>
#include <thread>

#include "haptic_core/base/error.h"
#include "haptic_core/world/step_history.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

/// How often a caller looks whether the runner has done its work. The runner signals by an atomic alone, because
/// waking a waiting thread would be a system call in its loop.
constexpr std::chrono::microseconds kPoll{500};

WorldSnapshot emptySnapshot(const World& world, int contact_capacity) {
  WorldSnapshot snapshot;
  snapshot.pose.resize(world.linkCount());
  snapshot.joint.resize(world.jointCount());
  snapshot.contact.resize(contact_capacity);
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

const char* kindName(PortKind kind) { return kind == PortKind::kDevice ? "device" : "world"; }

}  // namespace

bool BetweenTicks::serve() noexcept {
  if (state_.load(std::memory_order_acquire) != kWaiting) return false;
  int waiting = kWaiting;
  if (!state_.compare_exchange_strong(waiting, kRunning, std::memory_order_acq_rel)) return false;
  try {
    work_();
  } catch (...) {
    failure_ = std::current_exception();
  }
  state_.store(kDone, std::memory_order_release);
  return true;
}

bool BetweenTicks::call(const std::function<void()>& work, std::chrono::milliseconds patience,
                        const std::function<void()>& idle) {
  std::lock_guard<std::mutex> caller(callers_);
  const auto deadline = std::chrono::steady_clock::now() + patience;
  work_ = work;
  failure_ = nullptr;
  state_.store(kWaiting, std::memory_order_release);
  while (state_.load(std::memory_order_acquire) != kDone) {
    if (idle) idle();
    if (state_.load(std::memory_order_acquire) == kDone) break;
    int waiting = kWaiting;
    if (std::chrono::steady_clock::now() > deadline &&
        state_.compare_exchange_strong(waiting, kIdle, std::memory_order_acq_rel)) {
      return false;
    }
    std::this_thread::sleep_for(kPoll);
  }
  state_.store(kIdle, std::memory_order_release);
  work_ = nullptr;  // what it captured belongs to the caller's library
  const std::exception_ptr failure = failure_;
  failure_ = nullptr;
  if (failure) std::rethrow_exception(failure);
  return true;
}

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

  bool runBetweenTicks(const std::function<void()>& work, std::chrono::milliseconds patience) {
    return port->between_ticks.call(work, patience, [this] {
      std::lock_guard<std::mutex> lock(mutex);  // keeps claimants out while the work runs here
      if (!held) port->between_ticks.serve();
    });
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

WorldPort::WorldPort(World& world_in, std::string scene_name, std::vector<HandPlacement> placements,
                     int contact_capacity)
    : world(world_in),
      scene(std::move(scene_name)),
      hands(std::move(placements)),
      snapshot(emptySnapshot(world_in, contact_capacity)),
      copy(emptyCopy(world_in)),
      filled_(emptySnapshot(world_in, contact_capacity)),
      copied_(emptyCopy(world_in)) {
  takeSnapshot(0);
}

void WorldPort::take(const LoopCommand& command) {
  if (command.is<StepWorld>() && !paused_) throw SetupError("step", "the world is not paused", "pause it first");
  if (loop_) {
    loop_(command);
  } else {
    apply(command, world);
  }
  if (const auto* pause = std::get_if<PauseWorld>(&command.kind)) paused_ = pause->on;
}

void WorldPort::serveWatchers(std::int64_t stamp_ns) noexcept {
  timeStages();
  if (wants_snapshot.load(std::memory_order_relaxed) && wants_snapshot.exchange(false)) takeSnapshot(stamp_ns);
  if (wants_copy.load(std::memory_order_relaxed) && wants_copy.exchange(false)) takeCopy(stamp_ns);
}

void WorldPort::timeStages() noexcept {
  const bool asked = measures_stages.load(std::memory_order_relaxed);
  if (asked != timing_) {
    timing_ = asked;
    world.measureStages(asked);
    stage_sum_ = {0, 0, 0, 0, 0};
    steps_timed_ = 0;
  } else if (timing_) {
    const StageTimes& times = world.report().stages;
    stage_sum_ = {stage_sum_.search + times.search, stage_sum_.detection + times.detection, stage_sum_.volume + times.volume,
                  stage_sum_.force + times.force, stage_sum_.motion + times.motion};
    ++steps_timed_;
  }
}

void WorldPort::takeCopy(std::int64_t stamp_ns) noexcept {
  const double n = steps_timed_;  // 0/0: NaN, not measured
  copied_.stamp_ns = stamp_ns;
  copied_.time = world.time();
  copied_.report = world.report();
  copied_.stages = {stage_sum_.search / n, stage_sum_.detection / n, stage_sum_.volume / n, stage_sum_.force / n,
                    stage_sum_.motion / n};
  world.history().latest().pack(copied_.state);
  copied_.tuning = world.tuning();
  for (int i = 0; i < world.pointerCount(); ++i) copied_.bounds[static_cast<std::size_t>(i)] = world.pointerBound(i);
  copy.write(copied_);  // room for the greatest is there: the copy reuses the slot's storage
}

void WorldPort::takeSnapshot(std::int64_t stamp_ns) noexcept {
  filled_.stamp_ns = stamp_ns;
  filled_.time = world.time();
  filled_.report = world.report();
  for (std::size_t i = 0; i < filled_.pose.size(); ++i) filled_.pose[i] = world.linkPose(static_cast<int>(i));
  for (std::size_t i = 0; i < filled_.joint.size(); ++i) filled_.joint[i] = world.joint(static_cast<int>(i));
  for (std::size_t i = 0; i < filled_.pointer_wrench.size(); ++i) {
    filled_.pointer_wrench[i] = world.pointerWrench(static_cast<int>(i));
  }
  filled_.contacts = std::min<int>(world.contactCount(), static_cast<int>(filled_.contact.size()));
  for (int i = 0; i < filled_.contacts; ++i) filled_.contact[i] = world.contact(i);
  snapshot.write(filled_);  // equal sizes: the copy reuses the slot's storage
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

bool PortOffer::runBetweenTicks(const std::function<void()>& work, std::chrono::milliseconds patience) {
  return slot_ && slot_->runBetweenTicks(work, patience);
}

}  // namespace haptic

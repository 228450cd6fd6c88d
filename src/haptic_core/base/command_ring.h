/// A bounded ring of commands from any threads to the one thread that must not wait, each with its answer.
///
/// A sender waits for its answer and owns everything that its command points to: the reader copies, keeps and frees nothing.
#pragma once
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <optional>
#include <thread>
#include <type_traits>

#include "haptic_core/base/error.h"

namespace haptic {

/// A bounded ring of commands with answers: many senders, one reader at a time.
/// Senders take turns by a mutex that the reader never takes. The reader signals by an atomic alone, because waking a waiting
/// thread would be a system call in its loop; senders look every half millisecond.
template <class Command>
class CommandRing {
  static_assert(std::is_trivially_copyable_v<Command>, "the sender owns everything that a command refers to");

 public:
  /// Commands that wait at most; further senders wait for room. More would only lengthen the reader's longest turn.
  static constexpr std::size_t kCapacity = 16;

  /// (in realtime: one atomic load when nothing waits) The reader's: `take` carries out what waits, oldest first, at most one
  /// round. An exception of `take` refuses the command.
  template <class Take>
  void drain(Take&& take) noexcept {
    for (std::size_t i = 0; i < kCapacity; ++i) {
      Slot& slot = slots_[next_];
      State state = slot.state.load(std::memory_order_acquire);
      if (state == State::kFree || state == State::kAnswered) return;
      state = State::kWaiting;
      const bool mine = slot.state.compare_exchange_strong(state, State::kRunning, std::memory_order_acq_rel);
      if (mine) carryOut(slot, take);
      slot.state.store(mine ? State::kAnswered : State::kFree, std::memory_order_release);
      next_ = (next_ + 1) % kCapacity;
    }
  }

  /// Any other thread: has `command` carried out and waits. `idle` is called while it waits, for who may drain in the reader's
  /// place when there is none. False: no reader took it within `patience`, nothing was done and nothing will be. Throws the
  /// SetupError that refused it.
  template <class Idle>
  bool send(const Command& command, std::chrono::milliseconds patience, Idle&& idle) {
    constexpr std::chrono::microseconds kPoll{500};
    const auto deadline = std::chrono::steady_clock::now() + patience;
    Slot* slot = place(command);
    for (;; std::this_thread::sleep_for(kPoll)) {
      idle();
      if (!slot) slot = place(command);
      if (slot && slot->state.load(std::memory_order_acquire) == State::kAnswered) break;
      if (std::chrono::steady_clock::now() <= deadline) continue;
      State waiting = State::kWaiting;
      if (!slot || slot->state.compare_exchange_strong(waiting, State::kWithdrawn, std::memory_order_acq_rel)) return false;
    }
    const std::optional<SetupError> refusal = slot->refusal;
    slot->state.store(State::kFree, std::memory_order_release);
    if (refusal) throw SetupError(*refusal);
    return true;
  }

 private:
  /// Senders turn kFree to kWaiting, kWaiting to kWithdrawn and kAnswered to kFree; the reader all else.
  enum class State : int { kFree, kWaiting, kRunning, kAnswered, kWithdrawn };
  struct Slot {
    Command command{};
    std::optional<SetupError> refusal;
    std::atomic<State> state{State::kFree};
  };

  /// Null: the ring is full.
  Slot* place(const Command& command) {
    std::lock_guard<std::mutex> lock(senders_);
    Slot& slot = slots_[free_];
    if (slot.state.load(std::memory_order_acquire) != State::kFree) return nullptr;
    slot.command = command;
    slot.refusal.reset();
    slot.state.store(State::kWaiting, std::memory_order_release);
    free_ = (free_ + 1) % kCapacity;
    return &slot;
  }

  template <class Take>
  static void carryOut(Slot& slot, Take&& take) noexcept {
    try {
      take(slot.command);
    } catch (const SetupError& error) {
      slot.refusal = error;
    } catch (const std::exception& error) {
      slot.refusal.emplace("a command", error.what(), "");
    }
  }

  std::array<Slot, kCapacity> slots_;
  std::mutex senders_;
  std::size_t free_ = 0;  ///< the senders': where the next command goes
  std::size_t next_ = 0;  ///< the reader's: the oldest command
};

}  // namespace haptic

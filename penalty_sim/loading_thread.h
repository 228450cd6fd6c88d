/// Services that take long, in a thread of their own, so that the others are answered meanwhile.
#pragma once
#include <ros/callback_queue.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

namespace haptic {

/// Serves one queue of callbacks, and has parts of them done in the queue of the others.
class LoadingThread {
 public:
  /// `owner`: the queue of all else; outlives it.
  explicit LoadingThread(ros::CallbackQueueInterface& owner);
  ~LoadingThread();  ///< waits for the model that is being loaded

  /// From now on `there` throws where its work has not begun. Before the services of its queue are shut down, which waits for them.
  void stop() { stop_ = true; }

  ros::CallbackQueue& queue() { return queue_; }  ///< for the handle that advertises its services
  /// In its own thread: does `work` between two callbacks of the owner's queue, and waits. Throws what it throws, or SetupError: the
  /// thread is to end, and nothing was done.
  void there(const std::function<void()>& work);

 private:
  ros::CallbackQueueInterface& owner_;
  ros::CallbackQueue queue_;
  std::uint64_t there_id_ = 0;  ///< of its callbacks in the owner's queue
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace haptic

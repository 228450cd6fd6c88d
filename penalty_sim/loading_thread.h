/// Services that take long, in a thread of their own, so that the others are answered meanwhile.
#pragma once
#include <ros/callback_queue.h>

#include <atomic>
#include <functional>
#include <thread>

namespace haptic {

/// Serves one queue of callbacks, and has parts of them done in the queue of the others.
class LoadingThread {
 public:
  /// `owner`: the queue of all else; outlives it.
  explicit LoadingThread(ros::CallbackQueueInterface& owner);
  ~LoadingThread();  ///< waits for what is being loaded

  ros::CallbackQueue& queue() { return queue_; }  ///< for the handle that advertises its services
  /// In its own thread: does `work` between two callbacks of the owner's queue, and waits. Throws what it throws, or SetupError: the
  /// thread is to end, and nothing was done.
  void there(const std::function<void()>& work);

 private:
  ros::CallbackQueueInterface& owner_;
  ros::CallbackQueue queue_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace haptic

#include "penalty_sim/loading_thread.h"

#include <boost/make_shared.hpp>
#include <chrono>
#include <future>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

constexpr double kIdleLook = 0.1;                       // how often an idle thread looks whether it is to end [s]
constexpr std::chrono::milliseconds kWaitLook{20};  // and one that waits for the owner's queue

class Task : public ros::CallbackInterface {
 public:
  explicit Task(const std::function<void()>& work) : work_(work) {}
  CallResult call() override {
    if (take()) work_();
    return Success;
  }
  std::future<void> result() { return work_.get_future(); }
  /// Whether the caller is the first: its work is done once or, withdrawn, never.
  bool take() { return !taken_.exchange(true); }

 private:
  std::packaged_task<void()> work_;
  std::atomic<bool> taken_{false};
};

}  // namespace

LoadingThread::LoadingThread(ros::CallbackQueueInterface& owner)
    : owner_(owner), thread_([this] {
        while (!stop_) queue_.callAvailable(ros::WallDuration(kIdleLook));
      }) {
  there_id_ = reinterpret_cast<std::uint64_t>(this);
  // The queue knows an id only after its first callback is in, and drops one that is called before.
  owner_.addCallback(boost::make_shared<Task>([] {}), there_id_);
}

LoadingThread::~LoadingThread() {
  stop_ = true;
  queue_.disable();
  thread_.join();
}

void LoadingThread::there(const std::function<void()>& work) {
  const auto task = boost::make_shared<Task>(work);
  std::future<void> done = task->result();
  owner_.addCallback(task, there_id_);
  while (done.wait_for(kWaitLook) != std::future_status::ready) {
    if (stop_ && task->take()) throw SetupError("the simulation", "is being unloaded", "start it again");
  }
  done.get();
}

}  // namespace haptic

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
    work_();
    return Success;
  }
  std::future<void> result() { return work_.get_future(); }

 private:
  std::packaged_task<void()> work_;
};

}  // namespace

LoadingThread::LoadingThread(ros::CallbackQueueInterface& owner)
    : owner_(owner), thread_([this] {
        while (!stop_) queue_.callAvailable(ros::WallDuration(kIdleLook));
      }) {}

LoadingThread::~LoadingThread() {
  stop_ = true;
  queue_.disable();
  thread_.join();
}

void LoadingThread::there(const std::function<void()>& work) {
  const auto task = boost::make_shared<Task>(work);
  std::future<void> done = task->result();
  const auto id = reinterpret_cast<std::uint64_t>(this);
  owner_.addCallback(task, id);
  while (done.wait_for(kWaitLook) != std::future_status::ready) {
    if (!stop_) continue;
    owner_.removeByID(id);  // waits for one that is being called
    if (done.wait_for(std::chrono::seconds(0)) == std::future_status::ready) break;
    throw SetupError("the simulation", "is being unloaded", "start it again");
  }
  done.get();
}

}  // namespace haptic

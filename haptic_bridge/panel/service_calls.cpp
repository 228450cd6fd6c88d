#include "haptic_bridge/panel/service_calls.h"

#include <QRunnable>

namespace haptic {
namespace {

constexpr int kThreads = 4;  // as many calls as a user has under way at once

class Work : public QRunnable {
 public:
  explicit Work(std::function<void()> work) : work_(std::move(work)) {}
  void run() override { work_(); }

 private:
  std::function<void()> work_;
};

}  // namespace

ServiceCalls::ServiceCalls(QObject* parent) : QObject(parent), tell_([](const std::string&, bool) {}) {
  ordinary_.setMaxThreadCount(kThreads);
  stop_.setMaxThreadCount(2 * kThreads);
}

ServiceCalls::~ServiceCalls() {
  ordinary_.clear();
  ordinary_.waitForDone();
  stop_.waitForDone();
}

void ServiceCalls::start(Lane lane, std::function<void()> work) {
  (lane == Lane::kStop ? stop_ : ordinary_).start(new Work(std::move(work)));  // the pool deletes it
}

}  // namespace haptic

/// Service calls that do not hold up the window: they run in threads, their answers come back in the window's.
#pragma once
#include <ros/service.h>

#include <QMetaObject>
#include <QObject>
#include <QThreadPool>
#include <functional>
#include <string>

namespace haptic {

/// A device that is silent may take a second to answer: STOP has threads of its own and waits for nobody.
class ServiceCalls : public QObject {
 public:
  enum class Lane { kOrdinary, kStop };

  explicit ServiceCalls(QObject* parent);
  ~ServiceCalls() override;  ///< waits for what is under way

  /// Shows one line: `well` or not.
  using Tell = std::function<void(const std::string& line, bool well)>;
  void tellBy(Tell tell) { tell_ = std::move(tell); }
  void tell(const std::string& line, bool well) const { tell_(line, well); }

  /// Calls `service` and then `done(reached, response)` in the window's thread; tells when nobody answers.
  template <class Service>
  void call(const std::string& service, Service request,
            std::function<void(bool reached, const typename Service::Response&)> done, Lane lane = Lane::kOrdinary) {
    start(lane, [this, service, request, done]() mutable {
      const bool reached = ros::service::call(service, request);
      QMetaObject::invokeMethod(this, [this, service, request, done, reached] {
        if (!reached) tell_(service + " does not answer: is that node running, and does this machine reach it?", false);
        done(reached, request.response);
      });
    });
  }

  /// For services with `success` and `message`: tells what came of it.
  template <class Service>
  void ask(const std::string& what, const std::string& service, const Service& request) {
    call<Service>(service, request, [this, what](bool reached, const typename Service::Response& response) {
      if (!reached) return;
      const std::string outcome = response.success ? "done" : "refused";
      tell_(what + ": " + (response.message.empty() ? outcome : response.message), response.success != 0);
    });
  }

  /// Anything else that waits for the network.
  void start(Lane lane, std::function<void()> work);

 private:
  QThreadPool ordinary_, stop_;
  Tell tell_;
};

}  // namespace haptic

#include "spidar_driver/device_diagnostics.h"

#include <diagnostic_msgs/DiagnosticArray.h>

#include "spidar_driver/transport/link_report.h"

namespace haptic {
namespace {

using diagnostic_msgs::DiagnosticStatus;

template <class T>
void add(DiagnosticStatus& status, const char* key, T value) {
  diagnostic_msgs::KeyValue entry;
  entry.key = key;
  entry.value = std::to_string(value);
  status.values.push_back(entry);
}

void addWire(DiagnosticStatus& status, const LinkReport& wire) {
  add(status, "wire delay measured [us]", wire.delay_us);
  add(status, "wire delay spread at opening [us]", wire.jitter_us);
  add(status, "exchanges", wire.cycles);
  add(status, "answers lost", wire.lost);
  add(status, "answers late", wire.late);
  add(status, "answers doubled", wire.doubled);
  add(status, "counts refused", wire.refused_counts);
  add(status, "counters started anew", wire.restarts);
  add(status, "times the boards were taught anew", wire.retaught);
  add(status, "times the port was opened again", wire.reconnects);
  add(status, "foreign bytes", wire.foreign_bytes);
  add(status, "times the loop stood still", wire.stalls);
  add(status, "times the guard ended or stood still", wire.unguarded);
  add(status, "times the guard turned the motors off", wire.guard_stalls);
}

}  // namespace

DeviceDiagnostics::DeviceDiagnostics(ros::NodeHandle& nh, const std::string& name, const Transport& transport)
    : publisher_(nh.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 4)), name_(name), transport_(transport) {}

void DeviceDiagnostics::publish(const DeviceRecord& record, const std::string& message, bool well) const {
  diagnostic_msgs::DiagnosticArray array;
  array.header.stamp = ros::Time::now();
  array.status.resize(1);
  DiagnosticStatus& status = array.status[0];
  status.name = name_ + ": device";
  status.hardware_id = name_;
  status.message = std::string(stateName(record)) + ": " + message;
  status.level = record.state == DeviceState::kFault ? DiagnosticStatus::ERROR : well ? DiagnosticStatus::OK : DiagnosticStatus::WARN;
  add(status, "age of the counts on arrival, mean [s]", record.delay);
  add(status, "age of the counts [s]", record.counts_age);
  add(status, "share of answers lost", record.lost_share);
  add(status, "largest stable wall in a relaxed hand [N/m]", record.stable_stiffness);
  if (const auto* wire = dynamic_cast<const LinkReporter*>(&transport_)) addWire(status, wire->linkReport());
  publisher_.publish(array);
}

}  // namespace haptic

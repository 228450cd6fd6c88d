#include "spidar_driver/driver_nodelet.h"

#include <pluginlib/class_list_macros.hpp>

#include "haptic_core/base/error.h"
#include "haptic_core/spidar/device_twin.h"
#include "spidar_driver/device_answer.h"
#include "spidar_driver/transport/link_report.h"
#include "spidar_driver/transport/open_transport.h"

namespace haptic {
namespace {

/// Records that wait for the topics' thread: a quarter of a second, fifteen of its wake-ups.
std::size_t recordCapacity(double rate) { return static_cast<std::size_t>(0.25 * rate) + 16; }

}  // namespace

DriverNodelet::Device::Device(const DeviceDef& def, const SpidarSettings& settings, std::unique_ptr<Transport> wire,
                              double rate)
    : spidar(def, settings), transport(std::move(wire)), port(spidar, *transport, recordCapacity(rate)) {}

void DriverNodelet::onInit() {
  try {
    start();
  } catch (const SetupError& error) {
    NODELET_FATAL_STREAM(error.what());
    throw;  // the manager drops the nodelet, and who loaded it fails
  }
}

std::unique_ptr<Transport> DriverNodelet::openWire(DeviceDef def) const {
  TransportSettings settings;
  settings.port = parameters_.port;
  settings.rate_hz = parameters_.rate;
  settings.usb_unit = parameters_.usb_unit;
  if (parameters_.twin) def.transport = "twin";
  const bool own_script = parameters_.hand == DriverParameters::Hand::kScript && parameters_.script != "scene";
  if (own_script) settings.twin.path = handPath(parameters_.script);
  settings.twin.hand = parameters_.hand != DriverParameters::Hand::kNone;
  return openTransport(def, settings);
}

void DriverNodelet::start() {
  ros::NodeHandle& nh = getNodeHandle();
  ros::NodeHandle& priv = getPrivateNodeHandle();
  parameters_ = readParameters(nh, priv);
  StringVector zero_length;
  ProcessDoor& door = ProcessDoor::ofProcess();
  const DeviceDef def = withSavedCalibration(parameters_, loadDevice(parameters_.device_file), zero_length);
  SpidarSettings settings;
  settings.command_age_limit_s = parameters_.command_age_limit;
  settings.refuse_over_rate = !parameters_.twin;
  device_ = std::make_unique<Device>(def, settings, openWire(def), parameters_.rate);
  if (parameters_.rate > device_->transport->maxRateHz() * (1 + 1e-9)) {
    throw SetupError(priv.resolveName("rate"), "is " + std::to_string(parameters_.rate) + " Hz",
                     "the wire carries at most " + std::to_string(device_->transport->maxRateHz()) + " Hz");
  }
  if (zero_length.size() > 0) device_->spidar.restoreCalibration(zero_length);
  if (parameters_.calibrate_at_start) device_->spidar.calibrateAt(parameters_.jig_pose);
  device_->spidar.setForceEnabled(parameters_.enable_force);
  device_->port.follows_script =
      parameters_.twin && parameters_.hand == DriverParameters::Hand::kScript && parameters_.script == "scene";

  if (parameters_.dead_man.kind == DeadManParameters::Switch::kGrip && def.transport == "uart" && !parameters_.twin)
    throw SetupError(priv.resolveName("dead_man"), "is 'grip', and motor boards have no buttons on the grip",
                     "take a pedal or joystick: 'joy'");
  dead_man_ = std::make_unique<DeadManSwitch>(nh, parameters_.dead_man, device_->port);
  offer_ = PortOffer(PortTable::process(), parameters_.name, device_->port, getName());
  stop_ = std::make_unique<EmergencyStop>(priv, parameters_.name, device_->port, offer_);
  calibration_ = std::make_unique<GripCalibration>(priv, parameters_, def, device_->port, offer_);
  input_ = std::make_unique<WrenchInput>(nh, parameters_.name + "_base", def.dof == 7, [this] { return whyNoCommand(); });
  topics_ = std::make_unique<DeviceTopics>(
      nh, parameters_, device_->port, [this](haptic_msgs::DeviceState& state, bool well) { completeState(state, well); },
      [this](const DeviceRecord& record) { calibration_->see(record); });
  if (parameters_.hand == DriverParameters::Hand::kMarker) {
    auto* twin = dynamic_cast<DeviceTwin*>(device_->transport.get());
    hand_ = std::make_unique<HandMarker>(nh, parameters_.name + "_base", def.grip_radius, [twin](const Pose& X_BG) {
      twin->setHandTarget({{X_BG, 0.0}, true});
    });
  }
  recover_ = priv.advertiseService("recover", &DriverNodelet::onRecover, this);
  door.openToAll(priv.resolveName("enable_force"));  // whoever asks for less force is heard
  enable_force_ = priv.advertiseService("enable_force", &DriverNodelet::onEnableForce, this);
  master_ = std::make_unique<MasterWatch>();
  if (parameters_.end_with_parent) parent_ = std::make_unique<ParentWatch>([this] { stopAtParentsEnd(); });
  if (parameters_.alone) {
    thread_ = std::make_unique<DeviceThread>(parameters_.name, parameters_.rate, parameters_.realtime, *input_);
  }
}

DriverNodelet::~DriverNodelet() {
  parent_.reset();
  master_.reset();
  dead_man_.reset();
  recover_.shutdown();
  enable_force_.shutdown();
  hand_.reset();
  thread_.reset();
  input_.reset();
  topics_.reset();
  stop_.reset();
  calibration_.reset();  // and with it the last user of the offer
  const bool free = offer_.withdraw();
  if (!device_) return;
  device_->transport->zeroDrive();
  if (!free) {
    NODELET_ERROR_STREAM(parameters_.name << " was not given back in time; its memory is kept");
    static_cast<void>(device_.release());  // the runner may still use it
  }
}

std::string DriverNodelet::whyNoCommand() const {
  if (offer_.heldBy(ClaimRank::kBridge)) return "the real-time loop holds the device";
  if (!parameters_.twin && ros::Time::isSimTime()) return "/use_sim_time is set: a replayed bag must not drive motors";
  if (offer_.holder().empty()) return "nobody runs the device (~alone is false and no bridge holds it)";
  return {};
}

void DriverNodelet::completeState(haptic_msgs::DeviceState& state, bool well) const {
  state.transport = parameters_.twin ? "twin" : device_->spidar.def().transport;
  const std::string note = calibration_->note();
  if (well && !note.empty()) state.message = note;
  state.max_rate = device_->transport->maxRateHz();
  if (const auto* wire = dynamic_cast<const LinkReporter*>(device_->transport.get())) state.wire = wire->trouble();
  state.stop_socket = stop_ ? stop_->socket() : "";
  state.claimed = offer_.heldBy(ClaimRank::kBridge);
}

/// Current off before anything else; what follows may take seconds.
void DriverNodelet::stopAtParentsEnd() {
  const LoopCommand command{StopDevice{}};
  offer_.send(device_->port, Tell{&command}, std::chrono::milliseconds(100));
}

bool DriverNodelet::onRecover(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  const DeviceAnswer answer = askDevice(device_->port, offer_, {false, true, -1, {}});
  response.success = answer.done && answer.after.record.state != DeviceState::kFault && !answer.after.record.link_lost;
  response.message = answer.message;
  return true;
}

bool DriverNodelet::onEnableForce(ros::ServiceEvent<std_srvs::SetBool::Request, std_srvs::SetBool::Response>& event) {
  const bool on = event.getRequest().data;
  std_srvs::SetBool::Response& response = event.getResponse();
  if (on) response.message = ProcessDoor::ofProcess().refuse(event.getConnectionHeader());
  if (!response.message.empty()) return true;
  const DeviceAnswer answer = askDevice(device_->port, offer_, {false, false, on ? 1 : 0, {}});
  const DeviceState state = answer.after.record.state;
  const bool presents = state == DeviceState::kEnabled || state == DeviceState::kReduced;
  response.success = answer.done && presents == on;
  response.message = answer.message;
  const bool waits_for_hand = answer.done && state == DeviceState::kReady && !answer.after.record.held;
  response.success = response.success || (on && waits_for_hand);
  // What could not be switched on now must not come on later, when the pose is found or the fault is gone.
  if (on && answer.done && !presents && !waits_for_hand) askDevice(device_->port, offer_, {false, false, 0, {}});
  return true;
}

}  // namespace haptic

PLUGINLIB_EXPORT_CLASS(haptic::DriverNodelet, nodelet::Nodelet)

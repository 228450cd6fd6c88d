#include "browser/touch.h"

namespace haptic {
namespace {

/// Share of the frame's half size that the grip may be led to: beyond it strings go slack or the tensions reach their ends.
constexpr double kReach = 0.75;

HandSettings settingsOf(const HandDef& hand) {
  HandSettings settings;
  settings.workspace = hand.workspace;
  settings.force_scale = hand.force_scale;
  settings.delay = hand.delay;
  return settings;
}

}  // namespace

Touch::Touch(PackedScene packed) : packed_(std::move(packed)), world_(packed_.scene.world), estimator_(packed_.scene.world) {
  for (const HandDef& hand : packed_.scene.hands) {
    TwinSettings settings;
    settings.period = world_.settings().step;
    settings.path = hand.path;
    devices_.push_back(std::make_unique<Device>(packed_.device, settings));
    drawn_.push_back({hand.device, hand.workspace, packed_.device});
    Device& device = *devices_.back();
    loop_.attach(device.spidar, hand.pointer, settingsOf(hand));
    device.spidar.calibrateAtHome();
    device.spidar.setForceEnabled(true);
  }
}

void Touch::tick() noexcept {
  TickInput input;
  input.hands = loop_.handCount();
  for (int i = 0; i < input.hands; ++i) input.sample[i] = devices_[static_cast<std::size_t>(i)]->twin.exchange(loop_.drive(i));
  loop_.tick(input, world_.settings().step);
}

void Touch::aim(int hand, const Vector3& p_W) noexcept {
  if (hand < 0 || hand >= loop_.handCount() || !p_W.allFinite()) return;
  Device& device = *devices_[static_cast<std::size_t>(hand)];
  const WorkspaceSettings& workspace = packed_.scene.hands[static_cast<std::size_t>(hand)].workspace;
  Vector3 half = Vector3::Zero(), p_BG = workspace.X_WB.R.transpose() * (p_W - workspace.X_WB.p) / workspace.scale;
  for (const StringDef& string : packed_.device.strings) half = half.cwiseMax(string.p_BE.cwiseAbs());
  p_BG = p_BG.cwiseMax(-kReach * half).cwiseMin(kReach * half);
  device.target_W = workspace.X_WB.p + workspace.X_WB.R * (workspace.scale * p_BG);
  device.led = true;
  device.twin.setHandTarget({{Pose(Matrix3::Identity(), p_BG), 0.0}, true});
}

void Touch::letGo(int hand) noexcept {
  if (hand < 0 || hand >= loop_.handCount()) return;
  devices_[static_cast<std::size_t>(hand)]->led = false;
  devices_[static_cast<std::size_t>(hand)]->twin.setHandTarget({});
}

Vector3 Touch::aimed(int hand) const {
  const Device& device = *devices_.at(static_cast<std::size_t>(hand));
  if (device.led) return device.target_W;
  const WorkspaceSettings& workspace = packed_.scene.hands[static_cast<std::size_t>(hand)].workspace;
  return workspace.X_WB.p + workspace.X_WB.R * (workspace.scale * device.twin.pose().X_BG.p);
}

bool Touch::led(int hand) const { return devices_.at(static_cast<std::size_t>(hand))->led; }

void Touch::tune(double stiffness, double friction) {
  WorldTuning tuning = world_.tuning();
  tuning.stiffness_scale = stiffness;
  tuning.friction_scale = friction;
  loop_.take({TuneWorld{tuning}, 0});
}

ErrorEstimate Touch::estimate() {
  std::vector<PointerBound> bounds;
  for (int i = 0; i < world_.pointerCount(); ++i) bounds.push_back(world_.pointerBound(i));
  return estimator_.estimate(world_.save(), world_.tuning(), bounds);
}

Again::Again(PackedSession session) : session_(std::move(session)), replay_(session_.scene.scene.world, session_.start) {
  for (const SessionStart::HandStart& hand : session_.start.hands) drawn_.push_back({hand.device, hand.settings.workspace, hand.def});
}

void Again::tick() noexcept {
  if (done_ >= ticks()) return;
  const auto next = static_cast<std::size_t>(done_);
  try {
    while (event_ < session_.events.size() && session_.events[event_].tick <= session_.ticks[next].tick) {
      replay_.apply(session_.events[event_].command);
      ++event_;
    }
  } catch (const std::exception&) {
    session_.ticks.resize(next);
    return;
  }
  const TickHash& hash = replay_.tick(session_.ticks[next]);
  const TickHash& recorded = session_.hashes[next];
  ++done_;
  if (recorded.parts == 0) return;
  ++compared_;
  same_ += hash == recorded;
}

}  // namespace haptic

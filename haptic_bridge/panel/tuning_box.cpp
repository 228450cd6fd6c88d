#include "haptic_bridge/panel/tuning_box.h"

#include <dynamic_reconfigure/Reconfigure.h>

#include <QPushButton>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace haptic {
namespace {

constexpr char kSet[] = "bridge/set_parameters";
constexpr int kCouplingScene = 0, kCouplingVirtual = 2;  // of cfg/Loop.cfg
constexpr double kAlike = 1e-9;                          // relative: what was set came back

std::string format(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

void addDouble(dynamic_reconfigure::Config& config, const std::string& name, double value) {
  config.doubles.emplace_back();
  config.doubles.back().name = name;
  config.doubles.back().value = value;
}

void addInt(dynamic_reconfigure::Config& config, const std::string& name, int value) {
  config.ints.emplace_back();
  config.ints.back().name = name;
  config.ints.back().value = value;
}

const double* valueOf(const dynamic_reconfigure::Config& config, const std::string& name) {
  for (const auto& entry : config.doubles) {
    if (entry.name == name) return &entry.value;
  }
  return nullptr;
}

}  // namespace

TuningBox::TuningBox(ServiceCalls& calls, QWidget* parent) : QGroupBox("Feel (green: stable in a relaxed hand)", parent), calls_(calls) {
  setObjectName("tuning");
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(4, 4, 4, 4);
  column->setSpacing(1);
  const auto times_scene = [](double value) { return format("%.2f × scene", value); };
  stiffness_ = add("stiffness_scale", "Stiffness", {0.01, 10, true}, times_scene);
  friction_ = add("friction_scale", "Friction", {0, 3, false}, times_scene);
  limit_ = add("limit_share", "Force limit", {0.05, 1, false}, [this](double share) {
    return max_force_ > 0 ? format("%.1f N", share * max_force_) : format("%.0f %%", 100 * share);
  });
  coupling_ = add("coupling_stiffness", "Coupling", {10, 1e5, true}, [this](double k) {
    return scene_coupling_ ? "as the scene" : format("%.2f N/mm", 1e-3 * k);
  });
  coupling_->onChange([this](double k) {
    scene_coupling_ = false;
    dynamic_reconfigure::Config config;
    addInt(config, "coupling", kCouplingVirtual);
    addDouble(config, "coupling_stiffness", k);
    set("coupling", config);
  });
  auto* as_scene = new QPushButton("As the scene says", this);
  as_scene->setObjectName("As the scene says");
  as_scene->setToolTip("Stiffness, friction, limit and coupling of the files");
  layout()->addWidget(as_scene);
  connect(as_scene, &QPushButton::clicked, this, [this] {
    dynamic_reconfigure::Config config;
    for (const char* name : {"stiffness_scale", "friction_scale", "limit_share"}) addDouble(config, name, 1);
    addDouble(config, "coupling_stiffness", -1);
    addInt(config, "coupling", kCouplingScene);
    set("as the scene says", config);
  });
  limit_->markSafe(1, "the clamp of the device's file; never exceeded");
  friction_->markSafe(3, "friction takes energy: no value of this range is unstable");
  parameters_ = nh_.subscribe<dynamic_reconfigure::Config>(
      "bridge/parameter_updates", 2, [this](const dynamic_reconfigure::Config::ConstPtr& m) { show(*m); });
  limits_ = nh_.subscribe<haptic_msgs::HandLimits>(
      "hand_limits", 2, [this](const haptic_msgs::HandLimits::ConstPtr& m) { show(*m); });
}

TuningSlider* TuningBox::add(const char* parameter, const char* title, const SliderScale& scale,
                             std::function<std::string(double)> text) {
  auto* slider = new TuningSlider(parameter, title, scale, std::move(text), this);
  layout()->addWidget(slider);
  const std::string name = parameter, what = title;
  slider->onChange([this, name, what](double value) {
    dynamic_reconfigure::Config config;
    addDouble(config, name, value);
    set(what, config);
  });
  return slider;
}

/// The bridge puts a refused value back and says why on /rosout, which the panel shows.
void TuningBox::set(const std::string& what, const dynamic_reconfigure::Config& config) {
  dynamic_reconfigure::Reconfigure request;
  request.request.config = config;
  calls_.call<dynamic_reconfigure::Reconfigure>(
      kSet, request, [this, what, config](bool reached, const dynamic_reconfigure::Reconfigure::Response& response) {
        if (!reached) return;
        bool taken = true;
        for (const auto& asked : config.doubles) {
          const double* is = valueOf(response.config, asked.name);
          taken = taken && is && std::fabs(*is - asked.value) <= kAlike * std::fabs(asked.value);
        }
        calls_.tell(what + (taken ? ": set" : ": refused, the value from before holds"), taken);
        show(response.config);
      });
}

void TuningBox::show(const dynamic_reconfigure::Config& config) {
  const auto show_in = [&](TuningSlider* slider, const char* name) {
    if (const double* value = valueOf(config, name)) slider->show(*value);
  };
  show_in(stiffness_, "stiffness_scale");
  show_in(friction_, "friction_scale");
  show_in(limit_, "limit_share");
  const double* coupling = valueOf(config, "coupling_stiffness");
  if (!coupling) return;
  scene_coupling_ = *coupling <= 0;
  coupling_->show(*coupling);
}

void TuningBox::show(const haptic_msgs::HandLimits& limits) {
  double scale = INFINITY, wall = INFINITY, force = INFINITY;
  std::string why;
  for (std::size_t i = 0; i < limits.devices.size(); ++i) {  // of several hands the weakest counts
    scale = std::min(scale, limits.stiffness_scale[i]);
    wall = std::min(wall, limits.wall[i]);
    force = std::min(force, limits.max_force[i]);
    why += limits.text[i];
  }
  if (limits.devices.empty()) return;
  max_force_ = force;
  stiffness_->markSafe(scale, why);
  coupling_->markSafe(wall, why);
  limit_->markSafe(1, "the clamp of the device's file; never exceeded");
}

}  // namespace haptic

#include "haptic_bridge/panel/history_strips.h"

#include <QVBoxLayout>
#include <cmath>

namespace haptic {
namespace {

double now() { return ros::SteadyTime::now().toSec(); }  // of this window: a replay's clock may stand, and a system's is set

double norm(const geometry_msgs::Vector3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

constexpr int kGiven = 1, kAsked = 2, kAskedOther = 3, kGivenOther = 4;  // of HistoryStrip::colours

}  // namespace

HistoryStrips::HistoryStrips(QWidget* parent) : QGroupBox("The last 10 s", parent) {
  setObjectName("strips");
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(4, 4, 4, 4);
  column->setSpacing(2);
  force_ = add("Force", "N", 0.5);
  tick_ = add("Tick", "us", 10);
  energy_ = add("Energy", "mJ", 0.01);
  error_ = add("Error", "", 0.01);
  statistics_ = nh_.subscribe<haptic_msgs::TickStatistics>(
      "tick_statistics", 10, [this](const haptic_msgs::TickStatistics::ConstPtr& m) { show(*m); });
  live_ = nh_.subscribe<haptic_msgs::LiveReport>("live_report", 5,
                                                 [this](const haptic_msgs::LiveReport::ConstPtr& m) { show(*m); });
}

HistoryStrip* HistoryStrips::add(const char* title, const char* unit, double least_span) {
  auto* strip = new HistoryStrip(title, unit, least_span, this);
  layout()->addWidget(strip);
  return strip;
}

void HistoryStrips::show(const haptic_msgs::TickStatistics& m) {
  const double t = now();
  for (std::size_t i = 0; i < m.hands.size(); ++i) {
    const std::string whose = m.hands.size() > 1 ? m.hands[i].device + " " : "";
    force_->add(whose + "asked", t, norm(m.hands[i].asked.force), i == 0 ? kAsked : kAskedOther);
    force_->add(whose + "given", t, norm(m.hands[i].achieved.force), i == 0 ? kGiven : kGivenOther);
  }
  tick_->setLimit(1e6 / m.rate, "period");
  tick_->add("median", t, m.tick_us_p50, kAskedOther);
  tick_->add("worst", t, m.tick_us_max, kGiven);
}

void HistoryStrips::show(const haptic_msgs::LiveReport& m) {
  const double t = now();
  if (!balanced_ || m.step < last_step_) first_balance_ = m.energy_balance, balanced_ = true, energy_->clear();
  last_step_ = m.step;
  energy_->add("balance since the start", t, 1e3 * (m.energy_balance - first_balance_), kGiven);
  double force = 0;
  for (const double error : m.force_error) force = std::max(force, error);
  error_->add("position um", t, 1e6 * m.position_error, kGiven);
  error_->add("force mN", t, 1e3 * force, kAskedOther);
}

}  // namespace haptic

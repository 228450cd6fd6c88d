#include "haptic_bridge/panel/state_row.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr int kRefresh = 100;  // [ms]
const char* const kBetween = "   ·   ";

double steadyTime() { return ros::SteadyTime::now().toSec(); }

std::string join(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : kBetween) + text;
  return all;
}

}  // namespace

StateRow::StateRow(QWidget* parent) : QToolBar("State", parent), row_(new QLabel(this)) {
  setObjectName("state_row");
  setMovable(false);
  row_->setObjectName("row");
  row_->setWordWrap(true);
  row_->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Preferred);
  row_->setMinimumWidth(1);  // a long text breaks, and does not widen the window
  row_->setFixedHeight(2 * row_->fontMetrics().lineSpacing() + 10);  // two lines: the picture below does not jump under the mouse
  addWidget(row_);
  connect(&timer_, &QTimer::timeout, this, [this] { refresh(); });
  timer_.start(kRefresh);
}

void StateRow::subscribe() {
  ros::NodeHandle nh;
  using Plan = const ros::MessageEvent<haptic_msgs::ScenePlan const>&;  // tells who publishes it
  subscribers_ = {
      nh.subscribe<haptic_msgs::TickStatistics>("tick_statistics", 10,
                                                [this](const haptic_msgs::TickStatistics::ConstPtr& m) { hear(*m); }),
      nh.subscribe<haptic_msgs::StepReport>("step_report", 10, [this](const haptic_msgs::StepReport::ConstPtr& m) { hear(*m); }),
      nh.subscribe<haptic_msgs::ScenePlan, Plan>("scene_plan", 2,
                                                 [this](Plan plan) { hear(*plan.getMessage(), plan.getPublisherName()); })};
}

void StateRow::hear(const haptic_msgs::TickStatistics& loop) { say("loop", tell(loop, pointers_)); }

void StateRow::hear(const haptic_msgs::StepReport& step) { say("step", tell(step)); }

void StateRow::hear(const haptic_msgs::ScenePlan& plan, const std::string& publisher) {
  pointers_ = plan.pointers;
  std::vector<Told> told;
  const std::string node = publisher.substr(publisher.rfind('/') + 1);
  if (node == "replay") told.push_back(toldOfReplay());
  told.push_back({Weight::kCalm, plan.scene});
  say("scene", told);
}

void StateRow::say(const std::string& source, const std::vector<Told>& told) {
  present_[source] = told;
  for (const Told& one : told) {
    if (one.weight != Weight::kCalm) banners_[source][one.text] = {one.weight, steadyTime()};
  }
}

void StateRow::refresh() {
  Weight weight = Weight::kCalm;
  std::vector<std::pair<Weight, std::string>> banners;
  std::vector<std::string> calm;
  for (const auto& [source, told] : present_) {
    for (const Told& one : told) {
      if (one.weight == Weight::kCalm) calm.push_back(one.text);
      if (one.weight != Weight::kCalm) banners_[source][one.text].second = steadyTime();
    }
  }
  for (auto& [source, said] : banners_) {
    for (auto it = said.begin(); it != said.end();) {
      if (steadyTime() - it->second.second > kStays) {
        it = said.erase(it);
        continue;
      }
      banners.emplace_back(it->second.first, it->first);
      weight = std::max(weight, it->second.first);
      ++it;
    }
  }
  std::stable_sort(banners.begin(), banners.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> texts;
  for (const auto& banner : banners) texts.push_back(banner.second);
  row_->setText(QString::fromStdString(texts.empty() ? join(calm) : join(texts)));
  row_->setToolTip(QString::fromStdString(join(calm)));
  row_->setStyleSheet(texts.empty() ? "padding: 4px;"
                                    : QString("padding: 4px; font-weight: bold; color: white; background: %1;").arg(groundOf(weight)));
}

}  // namespace haptic

#include "haptic_bridge/panel/tuning_slider.h"

#include <QHBoxLayout>
#include <QPainter>
#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_bridge/panel/history_strip.h"

namespace haptic {
namespace {

constexpr int kPositions = 1000;   // finer than a screen's pixels
constexpr int kQuiet = 150;        // [ms]
constexpr int kBarHeight = 4;      // [pixels]

}  // namespace

double SliderScale::valueAt(double share) const {
  if (logarithmic) return lowest * std::pow(highest / lowest, share);
  return lowest + share * (highest - lowest);
}

double SliderScale::shareOf(double value) const {
  const double inside = std::min(highest, std::max(lowest, value));
  if (logarithmic) return std::log(inside / lowest) / std::log(highest / lowest);
  return (inside - lowest) / (highest - lowest);
}

/// The slider itself, with a bar below it: green where it is safe, red beyond.
class TuningSlider::Bar : public QSlider {
 public:
  explicit Bar(QWidget* parent) : QSlider(Qt::Horizontal, parent) {
    setRange(0, kPositions);
    setMinimumHeight(24);
  }
  double safe_share = 1;

 protected:
  void paintEvent(QPaintEvent* event) override {
    QSlider::paintEvent(event);
    QPainter painter(this);
    const int half_handle = 6, left = half_handle, width = this->width() - 2 * half_handle;
    const int border = left + static_cast<int>(std::lround(safe_share * width)), top = height() - kBarHeight;
    painter.fillRect(left, top, border - left, kBarHeight, QColor("#2e9e44"));
    painter.fillRect(border, top, left + width - border, kBarHeight, QColor("#d32f2f"));
  }
};

TuningSlider::TuningSlider(const std::string& name, const std::string& title, const SliderScale& scale,
                           std::function<std::string(double)> text, QWidget* parent)
    : QWidget(parent), scale_(scale), text_(std::move(text)), label_(new QLabel(this)), bar_(new Bar(this)), safe_(scale.highest) {
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  auto* head = new QLabel(QString::fromStdString(title), this);
  head->setFixedWidth(head->fontMetrics().horizontalAdvance("Force limit  "));
  label_->setFixedWidth(label_->fontMetrics().horizontalAdvance("unsafe 00.00 × scene"));
  bar_->setObjectName(QString::fromStdString(name));
  label_->setObjectName(QString::fromStdString(name + "_text"));
  row->addWidget(head);
  row->addWidget(bar_, 1);
  row->addWidget(label_);
  quiet_.setSingleShot(true);
  connect(&quiet_, &QTimer::timeout, this, [this] { changed_(value()); });
  connect(bar_, &QSlider::valueChanged, this, [this] {
    showText();
    if (!shows_) quiet_.start(kQuiet);
  });
  showText();
}

double TuningSlider::value() const { return scale_.valueAt(static_cast<double>(bar_->value()) / kPositions); }

void TuningSlider::show(double value) {
  if (bar_->isSliderDown() || quiet_.isActive()) return;
  shows_ = true;
  bar_->setValue(static_cast<int>(std::lround(scale_.shareOf(value) * kPositions)));
  shows_ = false;
  showText();
}

void TuningSlider::markSafe(double highest, const std::string& why) {
  safe_ = std::isnan(highest) ? scale_.highest : highest;
  bar_->safe_share = safe_ < scale_.lowest ? 0 : scale_.shareOf(safe_);
  bar_->setToolTip(QString::fromStdString(why));
  bar_->update();
  showText();
}

void TuningSlider::showText() {
  const bool safe = value() <= safe_ * (1 + 1e-6) + std::numeric_limits<double>::min();
  label_->setText(QString::fromStdString((safe ? "" : "unsafe ") + text_(value())));
  QPalette ink = palette();
  if (!safe) ink.setColor(QPalette::WindowText, HistoryStrip::colours(ink.color(QPalette::Window).lightness() < 128)[0]);
  label_->setPalette(ink);
}

}  // namespace haptic

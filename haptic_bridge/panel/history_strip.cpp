#include "haptic_bridge/panel/history_strip.h"

#include <QPainter>
#include <QPainterPath>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr double kSeconds = 10;  // that a strip shows
constexpr int kHeight = 58;      // [pixels]: four of them, and the rest, fit a screen of 1000

}  // namespace

HistoryStrip::HistoryStrip(const std::string& title, const std::string& unit, double least_span, QWidget* parent)
    : QWidget(parent), title_(title), unit_(unit), least_span_(least_span), limit_(std::numeric_limits<double>::quiet_NaN()) {
  setMinimumHeight(kHeight);
  setObjectName(QString::fromStdString("strip_" + title));
  setToolTip("the last ten seconds");
}

void HistoryStrip::add(const std::string& series, double time_s, double value, const QColor& colour) {
  Series& s = series_[series];
  s.colour = colour;
  s.samples.push_back({time_s, value});
  newest_ = time_s;
  forget(time_s);
  update();
}

void HistoryStrip::setLimit(double value, const std::string& name) {
  limit_ = value;
  limit_name_ = name;
}

void HistoryStrip::clear() {
  series_.clear();
  newest_ = 0;
}

void HistoryStrip::forget(double now) {
  for (auto& [name, series] : series_) {
    while (!series.samples.empty() && series.samples.front().time < now - kSeconds) series.samples.pop_front();
  }
}

void HistoryStrip::range(double& low, double& high) const {
  low = high = std::isfinite(limit_) ? limit_ : 0;
  low = std::min(low, 0.0);
  for (const auto& [name, series] : series_) {
    for (const Sample& sample : series.samples) {
      if (std::isfinite(sample.value)) low = std::min(low, sample.value), high = std::max(high, sample.value);
    }
  }
  if (high - low < least_span_) high = low + least_span_;
  high += 0.1 * (high - low);
}

void HistoryStrip::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.fillRect(rect(), palette().base());
  const int line = fontMetrics().height(), top = line + 3, left = 2, width = this->width() - 4, height = this->height() - top - 3;
  double low = 0, high = 1;
  range(low, high);
  const auto x = [&](double time) { return left + width * (1 - (newest_ - time) / kSeconds); };
  const auto y = [&](double value) { return top + height * (1 - (value - low) / (high - low)); };
  painter.setPen(palette().color(QPalette::Mid));
  painter.drawLine(QPointF(left, y(0)), QPointF(left + width, y(0)));
  if (std::isfinite(limit_)) {
    painter.setPen(QPen(QColor("#d32f2f"), 1, Qt::DashLine));
    painter.drawLine(QPointF(left, y(limit_)), QPointF(left + width, y(limit_)));
  }
  painter.setPen(palette().color(QPalette::Text));
  double at = left + 2;
  const auto write = [&](const QString& text, const QColor& colour) {
    painter.setPen(colour);
    painter.drawText(QPointF(at, line - 3), text);
    at += fontMetrics().horizontalAdvance(text + "  ");
  };
  write(QString::fromStdString(title_), palette().color(QPalette::Text));
  for (const auto& [name, series] : series_) {
    const double now = series.samples.empty() ? NAN : series.samples.back().value;
    const bool rounding = std::fabs(now) < 1e-3 * least_span_;
    write(QString::fromStdString(name) + (std::isfinite(now) ? " " + QString::number(rounding ? 0 : now, 'g', 3) : QString(" –")),
          series.colour);
  }
  write(QString::fromStdString(unit_), palette().color(QPalette::Text));
  if (std::isfinite(limit_)) write(QString::fromStdString(limit_name_) + " " + QString::number(limit_, 'g', 6), QColor("#d32f2f"));
  for (const auto& [name, series] : series_) {
    QPainterPath path;
    bool drawing = false;
    for (const Sample& sample : series.samples) {
      const bool finite = std::isfinite(sample.value);
      if (finite && drawing) path.lineTo(x(sample.time), y(sample.value));
      if (finite && !drawing) path.moveTo(x(sample.time), y(sample.value));
      drawing = finite;
    }
    painter.setPen(QPen(series.colour, 1.5));
    painter.drawPath(path);
  }
}

}  // namespace haptic

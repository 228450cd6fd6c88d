#include "haptic_bridge/panel/history_strip.h"

#include <QPainter>
#include <QPainterPath>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr double kSeconds = 10;  // that a strip shows
constexpr int kGap = 3;          // [pixels]
constexpr int kHeight = 58;      // [pixels]: four of them, and the rest, fit a screen of 1000

}  // namespace

HistoryStrip::HistoryStrip(const std::string& title, const std::string& unit, double least_span, QWidget* parent)
    : QWidget(parent), title_(title), unit_(unit), least_span_(least_span), limit_(std::numeric_limits<double>::quiet_NaN()) {
  setMinimumHeight(kHeight);
  setObjectName(QString::fromStdString("strip_" + title));
  setToolTip("The last ten seconds; at the right, the values at the top and at the bottom");
}

void HistoryStrip::add(const std::string& series, double time_s, double value, int colour) {
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

const std::array<QColor, 5>& HistoryStrip::colours(bool dark) {
  static const std::array<QColor, 5> kOnLight{"#b3123f", "#0072b2", "#a34a00", "#00704f", "#8f3f86"};
  static const std::array<QColor, 5> kOnDark{"#ff7a9c", "#56b4e9", "#ff8c42", "#2fc79a", "#e39ac6"};
  return dark ? kOnDark : kOnLight;
}

QColor HistoryStrip::colourOf(int colour) const {
  const bool dark = palette().color(QPalette::Base).lightness() < 128;
  return colours(dark)[static_cast<std::size_t>(colour)];
}

/// Lines at zero and at the limit; at the right the numbers of the bottom and of the top.
void HistoryStrip::drawScale(QPainter& painter, const QRectF& plot, double low, double high) const {
  const auto y = [&](double value) { return plot.bottom() - plot.height() * (value - low) / (high - low); };
  painter.setPen(palette().color(QPalette::Mid));
  painter.drawLine(QPointF(plot.left(), y(0)), QPointF(plot.right(), y(0)));
  if (std::isfinite(limit_)) {
    painter.setPen(QPen(colourOf(0), 1, Qt::DashLine));
    painter.drawLine(QPointF(plot.left(), y(limit_)), QPointF(plot.right(), y(limit_)));
  }
  painter.setPen(palette().color(QPalette::Text));
  const QRectF beside(plot.right() + kGap, plot.top() - kGap, width() - plot.right() - kGap, plot.height() + 2 * kGap);
  painter.drawText(beside, Qt::AlignLeft | Qt::AlignTop, QString::number(high, 'g', 2));
  painter.drawText(beside, Qt::AlignLeft | Qt::AlignBottom, QString::number(low, 'g', 2));
}

/// Title, series with their last values, unit and limit, in the colours of their curves.
void HistoryStrip::drawWords(QPainter& painter, int line) const {
  double at = 4;
  const auto write = [&](const QString& text, const QColor& colour) {
    painter.setPen(colour);
    painter.drawText(QPointF(at, line - 3), text);
    at += fontMetrics().horizontalAdvance(text + "  ");
  };
  const QColor ink = palette().color(QPalette::Text);
  write(QString::fromStdString(title_), ink);
  for (const auto& [name, series] : series_) {
    const double now = series.samples.empty() ? NAN : series.samples.back().value;
    const bool rounding = std::fabs(now) < 1e-3 * least_span_;
    write(QString::fromStdString(name) + (std::isfinite(now) ? " " + QString::number(rounding ? 0 : now, 'g', 3) : QString(" –")),
          colourOf(series.colour));
  }
  write(QString::fromStdString(unit_), ink);
  if (std::isfinite(limit_)) write(QString::fromStdString(limit_name_) + " " + QString::number(limit_, 'g', 6), colourOf(0));
}

void HistoryStrip::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.fillRect(rect(), palette().base());
  const int line = fontMetrics().height(), scale = fontMetrics().horizontalAdvance("-8.8e-88") + kGap;
  const QRectF plot(2, line + 3, width() - 4 - scale, height() - line - 6);
  double low = 0, high = 1;
  range(low, high);
  drawScale(painter, plot, low, high);
  drawWords(painter, line);
  for (const auto& [name, series] : series_) {
    QPainterPath path;
    bool drawing = false;
    for (const Sample& sample : series.samples) {
      const QPointF at(plot.right() - plot.width() * (newest_ - sample.time) / kSeconds,
                       plot.bottom() - plot.height() * (sample.value - low) / (high - low));
      const bool finite = std::isfinite(sample.value);
      if (finite && drawing) path.lineTo(at);
      if (finite && !drawing) path.moveTo(at);
      drawing = finite;
    }
    painter.setPen(QPen(colourOf(series.colour), 1.5));
    painter.drawPath(path);
  }
}

}  // namespace haptic

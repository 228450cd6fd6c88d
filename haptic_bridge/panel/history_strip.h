/// A strip chart: the last ten seconds of a few values.
#pragma once
#include <QColor>
#include <QRectF>
#include <QWidget>
#include <array>
#include <deque>
#include <map>
#include <string>

class QPainter;

namespace haptic {

class HistoryStrip : public QWidget {
 public:
  /// `least_span`: the scale is never finer than that, so that rounding does not look like an event.
  HistoryStrip(const std::string& title, const std::string& unit, double least_span, QWidget* parent);

  void add(const std::string& series, double time_s, double value, int colour);  ///< `colour`: one of colours(); NaN: a gap
  void setLimit(double value, const std::string& name);    ///< a line that should not be crossed
  void clear();

  /// Of the series, in words and curves, for a light and for a dark ground: a contrast of 4.5 and more. The first: of the limit.
  static const std::array<QColor, 5>& colours(bool dark);

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  struct Sample {
    double time, value;
  };
  struct Series {
    std::deque<Sample> samples;
    int colour = 0;
  };
  void forget(double now);
  void range(double& low, double& high) const;
  void drawScale(QPainter& painter, const QRectF& plot, double low, double high) const;
  void drawWords(QPainter& painter, int line) const;
  QColor colourOf(int colour) const;

  std::string title_, unit_, limit_name_;
  double least_span_, limit_, newest_ = 0;
  std::map<std::string, Series> series_;
};

}  // namespace haptic

/// A strip chart: the last ten seconds of a few values.
#pragma once
#include <QColor>
#include <QWidget>
#include <deque>
#include <map>
#include <string>

namespace haptic {

class HistoryStrip : public QWidget {
 public:
  /// `least_span`: the scale is never finer than that, so that rounding does not look like an event.
  HistoryStrip(const std::string& title, const std::string& unit, double least_span, QWidget* parent);

  void add(const std::string& series, double time_s, double value, const QColor& colour);  ///< NaN: a gap
  void setLimit(double value, const std::string& name);    ///< a line that should not be crossed
  void clear();

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  struct Sample {
    double time, value;
  };
  struct Series {
    std::deque<Sample> samples;
    QColor colour;
  };
  void forget(double now);
  void range(double& low, double& high) const;

  std::string title_, unit_, limit_name_;
  double least_span_, limit_, newest_ = 0;
  std::map<std::string, Series> series_;
};

}  // namespace haptic

/// A slider over a physical value, with the range marked in which a relaxed hand is stable.
#pragma once
#include <QLabel>
#include <QSlider>
#include <QTimer>
#include <QWidget>
#include <functional>
#include <string>

namespace haptic {

/// Proportional scale, or logarithmic where a value spans decades.
struct SliderScale {
  double lowest = 0, highest = 1;
  bool logarithmic = false;

  double valueAt(double share) const;   ///< share of the way, 0 to 1
  double shareOf(double value) const;
};

class TuningSlider : public QWidget {
 public:
  /// `text` writes a value for people.
  TuningSlider(const std::string& name, const std::string& title, const SliderScale& scale,
               std::function<std::string(double)> text, QWidget* parent);

  void onChange(std::function<void(double)> changed) { changed_ = std::move(changed); }
  void show(double value);              ///< somebody else's; does not interrupt a hand that drags
  void markSafe(double highest, const std::string& why);  ///< green up to there, red beyond

 private:
  class Bar;
  void showText();
  double value() const;

  SliderScale scale_;
  std::function<std::string(double)> text_;
  std::function<void(double)> changed_ = [](double) {};
  QLabel* label_;
  Bar* bar_;
  QTimer quiet_;                        ///< the loop is told once the hand rests for a moment
  double safe_;
  bool shows_ = false;                  ///< the slider is moved by `show`
};

}  // namespace haptic

/// Somebody in front of rviz: a display of its own, the window, and hands that move its mouse and press its keys.
#pragma once
#include <QWidget>
#include <functional>
#include <memory>
#include <string>

class QApplication;
namespace rviz {
class VisualizationFrame;
}

/// An X server without a screen (Xvfb), for as long as it lives.
class VirtualDisplay {
 public:
  VirtualDisplay();
  ~VirtualDisplay();

 private:
  int pid_ = -1;
};

class PanelUser {
 public:
  PanelUser(QApplication& application, const std::string& config);
  ~PanelUser();

  /// Lets the window live until `condition` holds. False after a minute: it hangs.
  bool waitFor(const std::function<bool()>& condition);

  /// What the shipped configuration put into the window; null: it did not.
  QWidget* panel() const;
  template <class T = QWidget>
  T* find(const std::string& name) const {
    return panel() ? panel()->findChild<T*>(QString::fromStdString(name)) : nullptr;
  }

  // By events of the X server, as a mouse and a keyboard make them.
  void click(const std::string& widget);
  void press(const std::string& key);
  void type(const std::string& text);
  void drag(const std::string& slider, double from_share, double to_share);

  bool shows(const std::string& part_of_line) const;  ///< one of the lines at the bottom
  void forgetLines();
  std::string view() const;  ///< class of the current camera
  std::string viewFrame() const;  ///< that it moves with
  void picture(const std::string& file);

 private:
  void input(const std::string& words);
  void bringIntoView(QWidget& widget);

  std::unique_ptr<rviz::VisualizationFrame> frame_;
};

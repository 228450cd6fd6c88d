/// Ends this process when the one that started it has ended, by whatever signal.
#pragma once
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace haptic {

/// roslaunch ends its nodes when it is asked to end; killed, it leaves them running, with force on. A descriptor of the parent
/// process tells its end at once and for certain; PR_SET_PDEATHSIG would tell the end of the thread that forked.
/// Asked to end (SIGHUP, SIGINT, SIGTERM), roslaunch takes up to half a second until it asks its nodes; its log says at once that it ends,
/// and is read for that word alone. Without such a log the current goes when roslaunch asks.
/// What else the parent started (its master, recorders, viewers) is asked to end too; a process that does not is killed, as by roslaunch:
/// a loader of nodelets that still waits for its manager hears no SIGINT.
class ParentWatch {
 public:
  /// `ended` is called in a thread of its own once the parent has ended: it takes the current away. Then the process is asked to
  /// end, and ends within kPatienceSeconds whatever hangs.
  explicit ParentWatch(std::function<void()> ended);
  ~ParentWatch();

  static constexpr unsigned kPatienceSeconds = 3;           ///< of this process, which holds the force
  static constexpr int kSiblingsPatienceMs = 15000;         ///< of the others, to close recordings: that of roslaunch

 private:
  void run();
  void noteSiblings();
  void endSiblings();
  void followLog();
  bool logSaysTheEnd();

  std::function<void()> ended_;
  int parent_ = -1, quit_ = -1;  ///< a pidfd and an eventfd
  int log_ = -1, log_changed_ = -1;  ///< the parent's log and an inotify; -1: it has none
  std::string log_tail_;             ///< its last bytes: a word may come in two pieces
  long parent_id_ = 0;
  std::vector<int> siblings_;    ///< pidfds: a number of a process that has ended may be another's by now
  std::vector<long> sibling_ids_;
  std::thread thread_;
};

}  // namespace haptic

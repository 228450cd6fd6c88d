/// Instructions that a piece of work executes, counted by valgrind's callgrind: unlike a time, the same on a
/// busy machine. A program counts itself: it starts itself again under callgrind with arguments that lead to
/// countedPass(), and reads what was collected there.
#pragma once
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "figure.h"

extern "C" {
/// Callgrind collects between entry and return of this function only; its name is the option's, so no clone may replace it.
__attribute__((noipa, used)) inline void haptic_counted_pass(void (*work)(void*), void* context) {
  work(context);
  __asm__ volatile("" ::: "memory");  // no tail call: the return must be this function's
}
}

namespace haptic::bench {

/// Runs `work()` where callgrind counts.
template <class Work>
void countedPass(Work work) {
  haptic_counted_pass([](void* w) { (*static_cast<Work*>(w))(); }, &work);
}

/// Instructions collected by `arguments` of this very program; NaN, with one line said once, without
/// valgrind.
inline double instructionsOf(const std::string& arguments) {
  static const bool have_valgrind = [] {
    const bool found = std::system("command -v valgrind >/dev/null 2>&1") == 0;
    if (!found) std::printf("no valgrind here: instruction counts are left out (apt-get install valgrind)\n");
    return found;
  }();
  if (!have_valgrind) return std::nan("");
  char self[4096] = {};
  if (!realpath("/proc/self/exe", self)) return std::nan("");
  const std::string command = std::string("valgrind --tool=callgrind --callgrind-out-file=/dev/null ") +
                              "--toggle-collect=haptic_counted_pass '" + self + "' " + arguments + " 2>&1";
  std::FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return std::nan("");
  double collected = std::nan("");
  char line[512];
  while (std::fgets(line, sizeof line, pipe)) {
    long long count = 0;
    const char* found = std::strstr(line, "Collected : ");
    if (found && std::sscanf(found, "Collected : %lld", &count) == 1) collected = static_cast<double>(count);
  }
  const int code = pclose(pipe);
  if (code != 0) std::printf("callgrind failed (code %d) on: %s\n", code, arguments.c_str());
  return code == 0 ? collected : std::nan("");
}

/// Prints a count as a figure unless there is none.
inline void instructionFigure(const std::string& name, double count) {
  if (std::isfinite(count)) figure(name, count, "instructions");
}

}  // namespace haptic::bench

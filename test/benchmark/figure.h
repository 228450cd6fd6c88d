/// Lines that machines read: `figure NAME VALUE UNIT`, one per line, one value per name.
#pragma once
#include <algorithm>
#include <cmath>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

namespace haptic::bench {

inline void figure(const std::string& name, double value, const char* unit) {  ///< prints one figure
  std::printf("figure %s %.10g %s\n", name.c_str(), value, unit);
  std::fflush(stdout);
}

inline double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// Seconds that one call of `work` takes: median over `repetitions` of the mean over `calls`.
template <class Work>
double secondsPerCall(Work&& work, int calls, int repetitions = 9) {
  std::vector<double> seconds;
  for (int r = 0; r < repetitions; ++r) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < calls; ++i) work(i);
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / calls);
  }
  return median(seconds);
}

}  // namespace haptic::bench

/// A block on a platform that is led up and down: the normal force of each step beside a motion that this project does not integrate.
#include <algorithm>
#include <cstdio>
#include <vector>

#include "../scenes/shaken.h"
#include "figure.h"
#include "step_figures.h"

namespace haptic::bench {
namespace {

using scenes::Shaken;

constexpr int kSteps = 2000, kFrom = 1000;  // errors count from the first second on: the start has no last step

double worst(const std::vector<double>& is, const std::vector<double>& should) {
  double most = 0;
  for (int i = kFrom; i < kSteps; ++i) most = std::max(most, Shaken::errorOf(is[i], should[i]));
  return most;
}

}  // namespace

void runShaken() {
  double most = 0, most_landing = 0, most_of_end = 0;
  for (const double k : {1e6, 1e8, 1e10}) {
    for (const double frequency : {2.0, 5.0, 11.0}) {
      for (const double share : {0.5, 0.98}) {
        const Shaken shaken{k, frequency, share};
        const Shaken::Forces should = shaken.exact(kSteps);
        World world(shaken.scene(stepSettings()));
        std::vector<double> is;
        for (int i = 0; i < kSteps; ++i) is.push_back(shaken.step(i, world));
        const bool lands = *std::min_element(should.end.begin() + kFrom, should.end.end()) <= 0;  // it leaves the platform
        const double of_mean = worst(is, should.mean), of_end = worst(is, should.end);
        std::printf("shaken: k %.0e, %2.0f Hz, %.2f g: %.5f of N, beside the force at the end %.5f%s\n", k, frequency, share, of_mean,
                    of_end, lands ? ", leaves and lands" : "");
        most = std::max(most, of_mean);
        if (lands) most_landing = std::max(most_landing, of_mean);
        if (!lands) most_of_end = std::max(most_of_end, of_end);
      }
    }
  }
  figure("shaken.force_err_max_rel", most, "1");
  figure("shaken.force_err_landing_max_rel", most_landing, "1");
  figure("shaken.force_err_of_end_max_rel", most_of_end, "1");
}

}  // namespace haptic::bench

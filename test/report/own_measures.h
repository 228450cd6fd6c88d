/// Errors that need no reference motion, for scenes in which no motion is the right one.
#pragma once
#include <algorithm>
#include <cmath>

#include "report_scene.h"

namespace haptic::report {

/// Largest rise of the mechanical energy above its least value so far [J]: nothing in a scene without hands
/// gives any.
inline Measure energyGain() {
  return {"energy_gain", [](const std::vector<Sample>& samples) {
            double least = samples[0].energy, gain = 0;
            for (const Sample& s : samples) {
              gain = std::max(gain, s.energy - least);
              least = std::min(least, s.energy);
            }
            return gain;
          }};
}

/// Mean over time of (E − E(0))² [J²]: SimBenchmark's measure of an elastic scene.
inline Measure energySquared() {
  return {"energy_squared", [](const std::vector<Sample>& samples) {
            double sum = 0;
            for (const Sample& s : samples) sum += std::pow(s.energy - samples[0].energy, 2);
            return sum / static_cast<double>(samples.size() - 1);
          }};
}

/// Largest change of a conserved vector over time.
inline Measure drift(const std::string& name, Vector3 Sample::*vector) {
  return {name, [vector](const std::vector<Sample>& samples) {
            double most = 0;
            for (const Sample& s : samples) most = std::max(most, (s.*vector - samples[0].*vector).norm());
            return most;
          }};
}

/// Largest over time of a value of one sample.
inline Measure worst(const std::string& name, std::function<double(const Sample&)> at) {
  return {name, [at](const std::vector<Sample>& samples) {
            double most = 0;
            for (std::size_t i = 1; i < samples.size(); ++i) most = std::max(most, at(samples[i]));
            return most;
          }};
}

/// Mean over time of a value of one sample.
inline Measure mean(const std::string& name, std::function<double(const Sample&)> at) {
  return {name, [at](const std::vector<Sample>& samples) {
            double sum = 0;
            for (std::size_t i = 1; i < samples.size(); ++i) sum += at(samples[i]);
            return sum / static_cast<double>(samples.size() - 1);
          }};
}

}  // namespace haptic::report

/// The parts of the benchmark of contacts.
#pragma once
#include "contact_scenes.h"

namespace haptic::bench {

/// Prints `contact.volume_err_c`, `contact.volume_err_c_far` and `contact.normal_err_rad_max`.
void measureAccuracy();

/// Prints `contact.false_empty`, `contact.wrong_volume`, `contact.failures`, `contact.allocations`.
void runHardCases();

/// Prints `contact.fuzz_execs`.
void runFuzz();

}  // namespace haptic::bench

/// Files made wrong in one number, and files that are right.
#pragma once

namespace haptic::bench {

/// 200 files that a seeded script made wrong in one number each: whether `check` names link or joint and tag. What an oracle of its own
/// holds for sound is counted apart, and listed.
void measureOddNumbers();

/// Lines under "to mend" and replaced numbers of files as they are published, listed; those of numbers are counted by file.
void measureFalseAlarms();

}  // namespace haptic::bench

#include "haptic_core/base/parse_numbers.h"

#include <charconv>
#include <cmath>

namespace haptic {
namespace {

constexpr char kSpace[] = " \t\r\n";

}  // namespace

std::optional<std::vector<double>> parseNumbers(const std::string& text) {
  std::vector<double> numbers;
  std::size_t begin = text.find_first_not_of(kSpace);
  while (begin != std::string::npos) {
    std::size_t end = text.find_first_of(kSpace, begin);
    if (end == std::string::npos) end = text.size();
    const std::size_t first = text[begin] == '+' ? begin + 1 : begin;
    double value = 0;
    const auto result = std::from_chars(text.data() + first, text.data() + end, value);
    const bool complete = result.ptr == text.data() + end && first < end;
    if (!complete || (result.ec != std::errc() && result.ec != std::errc::result_out_of_range))
      return std::nullopt;
    // Out of range is a denormal (0 is right to 1e-308) or too large (infinite, which the caller refuses).
    if (result.ec == std::errc::result_out_of_range) {
      value = text.substr(first, end - first).find("e-") != std::string::npos ? 0.0 : INFINITY;
    }
    numbers.push_back(value);
    begin = text.find_first_not_of(kSpace, end);
  }
  return numbers;
}

}  // namespace haptic

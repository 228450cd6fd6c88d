#include "spidar_driver/authority/host_names.h"

#include <iterator>
#include <system_error>
#include <thread>
#include <utility>

#include "spidar_driver/authority/addresses.h"

namespace haptic {
namespace {

constexpr std::size_t kLongestName = 253;  // [byte] of a host's name (RFC 1035, 2.3.4); what is longer is none
/// How long an answer is good before it is asked for again. Longer: a host that has moved is found late. Shorter: more questions.
constexpr std::chrono::seconds kGood{60};
constexpr int kAtOnce = 8;                 // look-ups; each has a thread, for up to a minute where nobody answers
constexpr std::size_t kNames = 256;        // names kept; a program that makes up names takes no more memory than this

}  // namespace

std::optional<std::vector<std::string>> HostNames::addressesOf(const std::string& host) {
  using Addresses = std::vector<std::string>;
  if (isAddress(host)) return Addresses{host};
  if (host.empty() || host.size() > kLongestName) return Addresses{};
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = names_.find(host);
  const bool kept = found != names_.end();
  if (kept && !found->second.asking && now < found->second.good_until) return found->second.addresses;
  if (!kept && names_.size() >= kNames) {
    for (auto name = names_.begin(); name != names_.end();) name = name->second.asking ? std::next(name) : names_.erase(name);
  }
  Name& name = names_[host];
  if (!name.asking) {
    if (asking_ >= kAtOnce) return Addresses{};
    try {
      std::thread([this, host] { lookUp(host); }).detach();
    } catch (const std::system_error&) {
      return Addresses{};
    }
    name.asking = true;
    ++asking_;
  }
  if (!name.addresses.empty()) return name.addresses;  // the old answer, until there is another
  return std::nullopt;
}

void HostNames::lookUp(const std::string& host) {
  std::vector<std::string> addresses = haptic::addressesOf(host);
  const std::lock_guard<std::mutex> lock(mutex_);
  Name& name = names_[host];
  if (!addresses.empty()) name.addresses = std::move(addresses);  // else a name server was out for a while
  name.good_until = std::chrono::steady_clock::now() + kGood;
  name.asking = false;
  --asking_;
}

}  // namespace haptic

#include "haptic_core/loop/command.h"

#include <array>

#include "haptic_core/base/error.h"
#include "haptic_core/base/fields.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

template <class T>
T recordFrom(const std::vector<double>& numbers, const char* what) {
  T record;
  const std::size_t size = countFields(record);
  if (numbers.size() != size) {
    throw SetupError(what, "has " + std::to_string(numbers.size()) + " numbers instead of " + std::to_string(size),
                     "use a recording of this version");
  }
  const double* next = numbers.data();
  readFields(record, next);
  return record;
}

/// What a recording's numbers say. The first three have no fixed length: what they restore judges it.
template <class T>
LoopCommand::Kind kindFrom(const std::vector<double>& numbers) {
  T kind;
  if constexpr (std::is_same_v<T, RestoreWorld>) {
    kind.state = numbers;
  } else if constexpr (std::is_same_v<T, RestoreDevice>) {
    kind.memory = numbers;
  } else if constexpr (std::is_same_v<T, TuneWorld>) {
    kind.tuning = WorldTuning::fromNumbers(numbers);
  } else {
    kind = recordFrom<T>(numbers, "a command");
  }
  return kind;
}

template <std::size_t... kIndex>
LoopCommand::Kind kindAt(std::size_t index, const std::vector<double>& numbers, std::index_sequence<kIndex...>) {
  using Reader = LoopCommand::Kind (*)(const std::vector<double>&);
  constexpr std::array<Reader, sizeof...(kIndex)> kReaders = {&kindFrom<std::variant_alternative_t<kIndex, LoopCommand::Kind>>...};
  return kReaders[index](numbers);
}

}  // namespace

void apply(const LoopCommand& command, World& world) {
  if (const auto* restore = std::get_if<RestoreWorld>(&command.kind)) world.restore(restore->state);
  if (const auto* tune = std::get_if<TuneWorld>(&command.kind)) world.tune(tune->tuning);
  if (const auto* grab = std::get_if<GrabLink>(&command.kind)) {
    const int pointers = world.pointerCount(), links = world.linkCount();
    if (grab->pointer < 0 || grab->pointer >= pointers || grab->link < 0 || grab->link >= links) {
      throw SetupError("grab", "names pointer " + std::to_string(grab->pointer) + " and link " + std::to_string(grab->link),
                       "the scene has " + std::to_string(pointers) + " and " + std::to_string(links));
    }
    world.grab(grab->pointer, grab->link);
  }
  if (const auto* drive = std::get_if<DriveJoint>(&command.kind)) world.setJointCommand(drive->joint, drive->command);
  if (command.is<StepWorld>()) world.step();
}

std::vector<double> numbersOf(const LoopCommand& command) {
  std::vector<double> numbers;
  std::visit([&](const auto& kind) { appendFields(kind, numbers); }, command.kind);
  return numbers;
}

std::vector<double> numbersOf(const HandSettings& settings) {
  std::vector<double> numbers;
  appendFields(settings, numbers);
  return numbers;
}

HandSettings handSettingsFrom(const std::vector<double>& numbers) {
  return recordFrom<HandSettings>(numbers, "settings of a hand");
}

LoopCommand commandFrom(std::size_t kind, int hand, const std::vector<double>& numbers) {
  constexpr std::size_t kKinds = std::variant_size_v<LoopCommand::Kind>;
  if (kind >= kKinds) {
    throw SetupError("a recording", "has a command of the unknown kind " + std::to_string(kind), "use the version that recorded it");
  }
  return {kindAt(kind, numbers, std::make_index_sequence<kKinds>()), hand};
}

}  // namespace haptic

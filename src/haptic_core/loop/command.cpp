#include "haptic_core/loop/command.h"

#include <array>
#include <cstring>

#include "haptic_core/base/error.h"
#include "haptic_core/base/fields.h"
#include "haptic_core/base/packed_file.h"
#include "haptic_core/geometry/shapes/shape_parts.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

template <class T>
T recordFrom(const std::vector<double>& numbers, const char* what) {
  T record;
  std::vector<double> defaults;
  appendFields(record, defaults);
  const std::size_t size = defaults.size();
  if (numbers.size() != size) {
    throw SetupError(what, "has " + std::to_string(numbers.size()) + " numbers instead of " + std::to_string(size),
                     "use a recording of this version");
  }
  const double* next = numbers.data();
  readFields(record, next);
  return record;
}

/// The command that a recording's numbers stand for. The first six kinds have no fixed length: the restored object checks it.
template <class T>
LoopCommand::Kind kindFrom(const std::vector<double>& numbers) {
  T kind;
  if constexpr (std::is_same_v<T, RestoreWorld>) {
    kind.state = numbers;
  } else if constexpr (std::is_same_v<T, RestoreDevice>) {
    kind.memory = numbers;
  } else if constexpr (std::is_same_v<T, AdoptCalibration>) {
    kind.strings = numbers;
  } else if constexpr (std::is_same_v<T, TuneWorld>) {
    kind.tuning = WorldTuning::fromNumbers(numbers);
  } else if constexpr (std::is_same_v<T, ChangeBodies>) {
    *kind.packed = numbers;
  } else if constexpr (std::is_same_v<T, PutJoints>) {
    if (numbers.size() % 2 != 0) throw SetupError("a command", "puts joints by an odd number of numbers", "record again");
    for (std::size_t i = 0; i < numbers.size(); i += 2) kind.positions.emplace_back(static_cast<int>(numbers[i]), numbers[i + 1]);
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

/// Another number where the order of the parts is another.
constexpr char kBodiesFormat[] = "haptic bodies, packed: 2\n";

/// Contents of a ChangeBodies.
struct PackedBodies {
  WorldDef def;
  std::vector<int> kept;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.def.name), visit(s.def), visit(s.kept);
  }
};

}  // namespace

std::vector<double> packBodies(const WorldDef& def, const std::vector<int>& kept) {
  const std::string bytes = packFile(kBodiesFormat, PackedBodies{def, kept});
  std::vector<double> numbers(1 + (bytes.size() + sizeof(double) - 1) / sizeof(double));
  numbers[0] = static_cast<double>(bytes.size());
  std::memcpy(numbers.data() + 1, bytes.data(), bytes.size());
  return numbers;
}

namespace {

PackedBodies unpacked(const std::vector<double>& numbers) {
  const double most = numbers.empty() ? -1 : static_cast<double>((numbers.size() - 1) * sizeof(double));
  if (!(most >= 0 && numbers[0] >= 0 && numbers[0] <= most)) throw SetupError("change of bodies", "is cut", "record it again");
  std::string bytes(static_cast<std::size_t>(numbers[0]), '\0');
  std::memcpy(bytes.data(), numbers.data() + 1, bytes.size());
  return unpackFile<PackedBodies>(kBodiesFormat, bytes, "change of bodies");
}

}  // namespace

WorldDef unpackBodies(const std::vector<double>& packed) { return unpacked(packed).def; }

std::vector<std::string> linkNames(const WorldDef& def) {
  std::vector<std::string> names;
  for (const ArticulationDef& articulation : def.articulations) {
    for (const LinkDef& link : articulation.links) names.push_back(link.name);
  }
  return names;
}

std::shared_ptr<NextWorld> nextWorld(const ChangeBodies& change, const World& running) {
  if (change.next) return change.next;
  const PackedBodies bodies = unpacked(*change.packed);
  return std::make_shared<NextWorld>(running, bodies.def, bodies.kept);
}

void apply(const LoopCommand& command, World& world) {
  if (const auto* change = std::get_if<ChangeBodies>(&command.kind)) {
    const std::shared_ptr<NextWorld> next = nextWorld(*change, world);
    next->refuseHeld(world);
    if (!world.exchange(*next)) {
      throw SetupError("change of bodies", "was made of another world", "make it of the one that runs");
    }
  }
  if (const auto* restore = std::get_if<RestoreWorld>(&command.kind)) world.restore(restore->state);
  if (const auto* tune = std::get_if<TuneWorld>(&command.kind)) world.tune(tune->tuning);
  if (const auto* set = std::get_if<SetGravity>(&command.kind)) {
    WorldTuning tuning = world.tuning();
    tuning.gravity = set->gravity;
    world.tune(tuning);
  }
  if (const auto* grab = std::get_if<GrabLink>(&command.kind)) {
    const int pointers = world.pointerCount(), links = world.linkCount();
    if (grab->pointer < 0 || grab->pointer >= pointers || grab->link < 0 || grab->link >= links) {
      throw SetupError("grab", "names pointer " + std::to_string(grab->pointer) + " and link " + std::to_string(grab->link),
                       "the scene has " + std::to_string(pointers) + " and " + std::to_string(links));
    }
    world.grab(grab->pointer, grab->link);
  }
  if (const auto* drive = std::get_if<DriveJoint>(&command.kind)) world.setJointCommand(drive->joint, drive->command);
  if (const auto* apply = std::get_if<ApplyWrench>(&command.kind)) world.applyWrench(apply->link, apply->wrench, apply->seconds);
  if (const auto* put = std::get_if<PutBody>(&command.kind)) world.setBodyPose(put->link, put->X_WL, put->V_WL);
  if (const auto* put = std::get_if<PutJoints>(&command.kind)) world.setJointPositions(put->positions);
  const auto* lead = std::get_if<LeadBody>(&command.kind);
  if (lead && !world.followBody(lead->motion, lead->to, lead->seconds)) {
    throw SetupError("motion " + std::to_string(lead->motion), "is not there, follows a path, or the pose is not finite",
                     "tell poses to a motion that the scene leaves to topic or tf");
  }
  if (command.is<StepWorld>()) world.step();
}

void apply(const LoopCommand& command, Spidar& device) {
  if (const auto* restore = std::get_if<RestoreDevice>(&command.kind)) device.restore(restore->memory);
  if (const auto* asking = std::get_if<AskDevice>(&command.kind)) device.ask(asking->requests);
  if (command.is<StopDevice>()) device.stop();
  if (const auto* hold = std::get_if<HoldSwitch>(&command.kind)) device.hold(hold->held);
  if (const auto* tune = std::get_if<TuneDevice>(&command.kind)) device.tune({tune->lambda, tune->max_force, tune->max_torque});
  if (const auto* adopt = std::get_if<AdoptCalibration>(&command.kind)) {
    const std::size_t n = device.def().strings.size();
    if (adopt->strings.size() != 4 * n) {
      throw SetupError(device.def().name, "gets a calibration of " + std::to_string(adopt->strings.size()) + " numbers instead of " +
                                              std::to_string(4 * n), "calibrate this device");
    }
    Calibration calibration;
    calibration.zero_length.resize(static_cast<Eigen::Index>(n));
    for (std::size_t i = 0; i < n; ++i) {
      const double* string = adopt->strings.data() + 4 * i;
      calibration.p_BE.emplace_back(string[0], string[1], string[2]);
      calibration.zero_length[static_cast<Eigen::Index>(i)] = string[3];
    }
    device.adopt(calibration, device.solution().pose);
  }
}

AdoptCalibration adoptionOf(const Calibration& calibration) {
  AdoptCalibration adopt;
  for (std::size_t i = 0; i < calibration.p_BE.size(); ++i) {
    for (const double number : {calibration.p_BE[i].x(), calibration.p_BE[i].y(), calibration.p_BE[i].z(),
                                calibration.zero_length[static_cast<Eigen::Index>(i)]}) {
      adopt.strings.push_back(number);
    }
  }
  return adopt;
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

// spidar_latency: how fast can this machine and this wire close a loop? All currents stay at zero.
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "haptic_core/base/error.h"
#include "haptic_core/base/program_version.h"
#include "spidar_driver/emulator/pty_line.h"
#include "spidar_driver/emulator/twin_plant.h"
#include "spidar_driver/latency/tick_timing.h"
#include "spidar_driver/transport/link_report.h"
#include "spidar_driver/transport/open_transport.h"
#include "spidar_driver/transport/serial_port.h"

namespace haptic {
namespace {

constexpr char kUsage[] =
    "usage: spidar_latency --device FILE [--port P] [--transport T] [--seconds N] [--emulate]\n"
    "  --device FILE  device description; its transport is used\n"
    "  --port P       serial port; without it the first one with the device's boards\n"
    "  --transport T  another than the device's: twin measures the machine alone\n"
    "  --seconds N    per rate (3)\n"
    "  --emulate      boards on a pseudo-terminal of this process, with the time a 2 Mbaud wire takes\n"
    "No current flows. Ends with figures latency.*; exit code 1 when not even 1 kHz is possible.\n";

constexpr double kRates[] = {1000, 2000, 5000};  // [Hz]
constexpr int kPriority = 60;                    // SCHED_FIFO, above the adapter's interrupt thread (50)
// Of fewer ticks than a hundred the 99th percentile is the maximum; an hour at 5 kHz keeps 300 MB of times.
constexpr double kLeastSeconds = 0.1, kMostSeconds = 3600;

struct Options {
  std::string device, port, transport;
  double seconds = 3;
  bool emulate = false, help = false;
};

Options parse(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--emulate") {
      o.emulate = true;
    } else if (name == "--help" || name == "-h") {
      o.help = true;
    } else if (i + 1 < argc && name == "--device") {
      o.device = argv[++i];
    } else if (i + 1 < argc && name == "--port") {
      o.port = argv[++i];
    } else if (i + 1 < argc && name == "--transport") {
      o.transport = argv[++i];
    } else if (i + 1 < argc && name == "--seconds") {
      o.seconds = std::atof(argv[++i]);
    } else {
      throw SetupError(name, "unknown option, or its value is missing", "see --help");
    }
  }
  if (o.device.empty() && !o.help)
    throw SetupError("--device", "is missing", "give a device description, see --help");
  if (!o.help && !(o.seconds >= kLeastSeconds && o.seconds <= kMostSeconds))
    throw SetupError("--seconds", "is not a time from 0.1 s to an hour", "give seconds per rate, such as 3");
  return o;
}

/// Boards of the device on a pseudo-terminal.
struct EmulatedBoards {
  explicit EmulatedBoards(const DeviceDef& device) : plant(device, {}), bus(plant) {
    int id = 1;
    for (const std::string& model : device.boards) bus.addBoard(model, id++);
    line = std::make_unique<PtyLine>(bus, "", true);
    thread = std::make_unique<PtyThread>(*line);
  }
  TwinPlant plant;
  BoardBusEmulator bus;
  std::unique_ptr<PtyLine> line;
  std::unique_ptr<PtyThread> thread;
};

/// Exchanges at absolute deadlines; a tick that is a period late moves the deadlines, without a burst.
TickTiming measure(const DeviceDef& device, TransportSettings settings, double rate_hz, double seconds) {
  settings.rate_hz = rate_hz;
  const std::unique_ptr<Transport> transport = openTransport(device, settings);
  TickTiming timing;
  timing.rate_hz = rate_hz;
  timing.ticks = static_cast<long>(seconds * rate_hz);
  timing.round_trip_us.reserve(static_cast<std::size_t>(timing.ticks));
  timing.lateness_us.reserve(static_cast<std::size_t>(timing.ticks));
  const auto period = static_cast<std::int64_t>(1e9 / rate_hz);
  std::int64_t deadline = steadyNanoseconds() + period;
  for (long k = 0; k < timing.ticks; ++k, deadline += period) {
    const timespec instant{static_cast<time_t>(deadline / 1000000000),
                           static_cast<long>(deadline % 1000000000)};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &instant, nullptr);
    const std::int64_t start = steadyNanoseconds();
    const DeviceSample sample = transport->exchange({});
    timing.round_trip_us.push_back(1e-3 * static_cast<double>(steadyNanoseconds() - start));
    timing.lateness_us.push_back(1e-3 * static_cast<double>(start - deadline));
    timing.missed += start - deadline > period;
    timing.stale += sample.age_ticks > 0;
    if (start - deadline > period) deadline = start;
  }
  return timing;
}

void report(const TickTiming& t) {
  std::printf(
      "%5.0f Hz  round trip p50 %6.0f p99 %6.0f max %6.0f us   late p50 %5.0f p99 %5.0f max %6.0f us   "
      "missed %ld  stale %ld of %ld   %s\n",
      t.rate_hz, percentile(t.round_trip_us, 0.5), percentile(t.round_trip_us, 0.99),
      percentile(t.round_trip_us, 1), percentile(t.lateness_us, 0.5), percentile(t.lateness_us, 0.99),
      percentile(t.lateness_us, 1), t.missed, t.stale, t.ticks, toString(verdictOf(t)));
}

void figures(const TickTiming& t) {
  const int khz = static_cast<int>(t.rate_hz / 1000);
  const auto line = [khz](const char* name, double value, const char* unit) {
    std::printf("figure latency.%s_%dkhz %.6g %s\n", name, khz, value, unit);
  };
  line("round_trip_us_p50", percentile(t.round_trip_us, 0.5), "us");
  line("round_trip_us_p99", percentile(t.round_trip_us, 0.99), "us");
  line("round_trip_us_max", percentile(t.round_trip_us, 1), "us");
  line("jitter_us_p99", percentile(t.lateness_us, 0.99), "us");
  line("jitter_us_max", percentile(t.lateness_us, 1), "us");
  line("missed", static_cast<double>(t.missed), "1");
  line("stale", static_cast<double>(t.stale), "1");
  line("verdict", 2 - static_cast<int>(verdictOf(t)), "2 good, 1 marginal, 0 no");
}

int run(int argc, char** argv) {
  const Options options = parse(argc, argv);
  if (options.help) return std::fputs(kUsage, stdout), 0;
  DeviceDef device = loadDevice(options.device);
  if (!options.transport.empty()) device.transport = options.transport;
  // First, so that the thread of emulated boards inherits it.
  const bool locked = ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  const sched_param priority{kPriority};
  const bool first_in_line = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority) == 0;
  std::unique_ptr<EmulatedBoards> emulated;
  TransportSettings settings;
  settings.port = options.port;
  if (options.emulate) {
    if (device.transport != "uart")
      throw SetupError("--emulate", "emulates UART boards only", "leave it out");
    emulated = std::make_unique<EmulatedBoards>(device);
    settings.port = emulated->line->path();
  }
  TimingSetup setup = examineMachine(settings.port);
  setup.memory_locked = locked;
  setup.realtime_priority = first_in_line;
  double max_rate = 0, wire_delay_us = -1;
  {
    const std::unique_ptr<Transport> transport = openTransport(device, settings);
    const auto* reporter = dynamic_cast<LinkReporter*>(transport.get());
    // The twin answers at whatever rate it is asked.
    max_rate = device.transport == "twin" ? 1e9 : transport->maxRateHz();
    if (reporter) wire_delay_us = reporter->linkReport().delay_us;
    std::printf("%s: %s\n", device.name.c_str(), reporter ? reporter->describe().c_str() : "twin, no wire");
  }
  std::printf("real-time priority %s, memory %s, kernel %s, latency timer %s\n",
              setup.realtime_priority ? "yes" : "no", setup.memory_locked ? "locked" : "not locked",
              setup.realtime_kernel ? "PREEMPT_RT" : "standard",
              setup.latency_timer_ms < 0 ? "none" : (std::to_string(setup.latency_timer_ms) + " ms").c_str());
  std::vector<TickTiming> runs;
  for (const double rate : kRates) {
    if (rate > max_rate) {
      std::printf("%5.0f Hz  no: the wire carries at most %.0f Hz\n", rate, max_rate);
      continue;
    }
    runs.push_back(measure(device, settings, rate, options.seconds));
    report(runs.back());
  }
  for (const std::string& line : advice(setup, runs)) std::printf("to do: %s\n", line.c_str());
  for (const TickTiming& t : runs) figures(t);
  std::printf("figure latency.max_rate_hz %.6g Hz\n", max_rate);
  if (wire_delay_us >= 0) std::printf("figure latency.wire_delay_us %.6g us\n", wire_delay_us);
  return runs.empty() || verdictOf(runs.front()) == Verdict::kNo ? 1 : 0;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  if (haptic::toldVersion(argc, argv, "spidar_latency")) return 0;
  try {
    return haptic::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "spidar_latency: %s\n", error.what());
    return 1;
  }
}

/// A system's clock that a test sets: preloaded into a process, it adds the seconds in the file HAPTIC_SET_CLOCK (a double) to what the
/// process is told of the time of day, and takes them from the times of day until which it waits.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <cstdlib>

namespace {

/// Where the test writes; zero where there is no file.
const volatile double& ahead() {
  static const volatile double none = 0;
  static const volatile double* const told = [] {
    const char* path = std::getenv("HAPTIC_SET_CLOCK");
    const int file = path ? ::open(path, O_RDONLY | O_CLOEXEC) : -1;
    void* page = file < 0 ? MAP_FAILED : ::mmap(nullptr, sizeof(double), PROT_READ, MAP_SHARED, file, 0);
    if (file >= 0) ::close(file);
    return page == MAP_FAILED ? &none : static_cast<const volatile double*>(page);
  }();
  return *told;
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

timespec moved(const timespec& t, double seconds) {
  timespec other = t;
  other.tv_sec += static_cast<time_t>(seconds);  // whole seconds
  return other;
}

bool isTimeOfDay(clockid_t clock) { return clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE; }

/// A condition's clock is not to be asked for; times since the machine's start are those of less than thirty years.
constexpr time_t kThirtyYears = 946'684'800;

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* now) {
  static auto* const real = next<int(clockid_t, timespec*)>("clock_gettime");
  const int result = real(clock, now);
  if (result == 0 && isTimeOfDay(clock)) *now = moved(*now, ahead());
  return result;
}

int gettimeofday(timeval* now, void* zone) noexcept {
  static auto* const real = next<int(timeval*, void*)>("gettimeofday");
  const int result = real(now, zone);
  if (result == 0) now->tv_sec += static_cast<time_t>(ahead());
  return result;
}

time_t time(time_t* out) noexcept {
  timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (out) *out = now.tv_sec;
  return now.tv_sec;
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex, const timespec* until) {
  static auto* const real = next<int(pthread_cond_t*, pthread_mutex_t*, const timespec*)>("pthread_cond_timedwait");
  const timespec meant = until->tv_sec > kThirtyYears ? moved(*until, -ahead()) : *until;
  return real(condition, mutex, &meant);
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock, const timespec* until) {
  static auto* const real = next<int(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*)>("pthread_cond_clockwait");
  const timespec meant = isTimeOfDay(clock) ? moved(*until, -ahead()) : *until;
  return real(condition, mutex, clock, &meant);
}
}

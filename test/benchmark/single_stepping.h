/// Instructions that a piece of work executes, counted one by one: a child process runs it under ptrace's single step.
/// Exact and repeatable on a busy machine and for any instruction set, without tools or privileges (instruction_count.h asks
/// valgrind, for long pieces of work); costs about 5 us an instruction.
#pragma once
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <utility>

namespace haptic::bench {

namespace counting {

/// From the child's second stop by SIGSTOP to its third, work and two system calls; -1: ptrace is not allowed here.
template <class Work>
long between(Work&& work) {
  const pid_t child = fork();
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(1);
    const pid_t self = getpid();
    kill(self, SIGSTOP);
    work();
    kill(self, SIGSTOP);
    _exit(0);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child || !WIFSTOPPED(status)) return -1;
  long count = 0;
  for (;; ++count) {
    if (ptrace(PTRACE_SINGLESTEP, child, nullptr, nullptr) != 0) break;
    if (waitpid(child, &status, 0) != child || !WIFSTOPPED(status)) return -1;
    if (WSTOPSIG(status) == SIGSTOP) break;
  }
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  return count;
}

}  // namespace counting

/// Instructions of one call of `work` in user space (a repeated string instruction counts each repetition). The child
/// works on a copy of the memory: nothing that `work` changes is seen here. -1: ptrace is not allowed.
template <class Work>
long singleStepped(Work&& work) {
  const long empty = counting::between([] {}), all = counting::between(std::forward<Work>(work));
  return empty < 0 || all < 0 ? -1 : all - empty;
}

}  // namespace haptic::bench

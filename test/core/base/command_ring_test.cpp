// Commands from many threads to one, each with its answer: order, a full ring, refusal, withdrawal. Run under ThreadSanitizer
// by ./run test --sanitize thread.
#include "haptic_core/base/command_ring.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace haptic {
namespace command_ring_test {

using std::chrono::milliseconds;
constexpr milliseconds kLong{20000};

struct Command {
  int sender = 0, number = 0;
};
using Ring = CommandRing<Command>;
constexpr int kCapacity = static_cast<int>(Ring::kCapacity);

void nothing() {}

/// Drains in a thread of its own until it ends; what `take` gets may only be read afterwards.
template <class Take>
struct Reader {
  Reader(Ring& ring, Take take) : thread([this, &ring, take] { while (!ended) ring.drain(take), std::this_thread::yield(); }) {}
  ~Reader() { ended = true, thread.join(); }
  std::atomic<bool> ended{false};
  std::thread thread;
};

TEST(CommandRing, AnswersWithWhatRefused) {
  Ring ring;
  const auto take = [](const Command& command) {
    if (command.number == 1) throw SetupError("a number", "is 1", "give another");
    if (command.number == 2) throw std::out_of_range("a list ends earlier");
  };
  const auto send = [&](int number) { return ring.send({0, number}, kLong, [&] { ring.drain(take); }); };
  const auto refusal = [&](int number) -> std::string {
    try {
      send(number);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "";
  };
  for (int round = 0; round < 2 * kCapacity; ++round) {  // every slot, after every kind of answer
    EXPECT_EQ(refusal(1), "a number: is 1; give another");
    EXPECT_TRUE(send(3));
    EXPECT_EQ(refusal(2), "a command: a list ends earlier");
    EXPECT_TRUE(send(4));
    EXPECT_TRUE(send(5));
  }
}

TEST(CommandRing, WhatWasWithdrawnIsNeverCarriedOut) {
  Ring ring;
  int taken = 0;
  const auto take = [&](const Command&) { ++taken; };
  for (int i = 0; i < kCapacity + 3; ++i) EXPECT_FALSE(ring.send({0, i}, milliseconds(1), nothing)) << "also when full of such";
  ring.drain(take);
  EXPECT_EQ(taken, 0);
  for (int i = 0; i < kCapacity + 3; ++i) EXPECT_TRUE(ring.send({0, i}, kLong, [&] { ring.drain(take); }));
  EXPECT_EQ(taken, kCapacity + 3);
}

TEST(CommandRing, KeepsOrderAndTurnsAwayWhatFindsNoRoom) {
  Ring ring;
  std::vector<std::thread> senders;
  for (int i = 0; i < kCapacity; ++i) {
    std::atomic<bool> placed{false};
    senders.emplace_back([&ring, i, &placed_out = placed] {
      bool told = false;
      EXPECT_TRUE(ring.send({0, i}, kLong, [&] {
        if (!told) told = placed_out = true;  // called after the command found its place
      }));
    });
    while (!placed) std::this_thread::yield();
  }
  EXPECT_FALSE(ring.send({0, 99}, milliseconds(5), nothing)) << "no room";
  std::vector<int> order;
  ring.drain([&](const Command& command) { order.push_back(command.number); });
  for (std::thread& sender : senders) sender.join();
  ASSERT_EQ(order.size(), Ring::kCapacity);
  for (int i = 0; i < kCapacity; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
}

// Who is answered sends anew at once: a reader that went on while something waits would never come to its tick.
TEST(CommandRing, ATurnOfTheReaderIsBounded) {
  constexpr int kEach = 4;
  Ring ring;
  std::atomic<int> placed{0}, ended{0};
  std::vector<std::thread> senders;
  for (int i = 0; i < kCapacity; ++i) {
    senders.emplace_back([&] {
      for (int n = 0; n < kEach; ++n) {
        bool told = false;
        EXPECT_TRUE(ring.send({}, kLong, [&] { placed += !told, told = true; }));
      }
      ++ended;
    });
  }
  while (placed < kCapacity) std::this_thread::yield();
  int taken = 0;
  const auto slowly = [&](const Command&) {
    ++taken;
    std::this_thread::sleep_for(milliseconds(2));  // the senders look every half
  };
  ring.drain(slowly);
  EXPECT_EQ(taken, kCapacity);
  while (ended < kCapacity) ring.drain([&](const Command&) { ++taken; });
  for (std::thread& sender : senders) sender.join();
  EXPECT_EQ(taken, kEach * kCapacity);
}

TEST(CommandRing, EachSenderIsServedInItsOrder) {
  constexpr int kSenders = 4, kEach = 200;
  Ring ring;
  std::vector<int> last(kSenders, -1);
  int taken = 0;
  {
    Reader reader(ring, [&](const Command& command) {
      EXPECT_EQ(command.number, last[static_cast<std::size_t>(command.sender)] + 1);
      last[static_cast<std::size_t>(command.sender)] = command.number;
      ++taken;
    });
    std::vector<std::thread> senders;
    for (int s = 0; s < kSenders; ++s) {
      senders.emplace_back([&ring, s] {
        for (int i = 0; i < kEach; ++i) EXPECT_TRUE(ring.send({s, i}, kLong, nothing));
      });
    }
    for (std::thread& sender : senders) sender.join();
  }
  EXPECT_EQ(taken, kSenders * kEach);
}

// Patience that ends while the reader looks: whatever the answer is, it is true.
TEST(CommandRing, TheAnswerIsTrueWhenPatienceEndsMeanwhile) {
  constexpr int kSenders = 4, kEach = 300;
  Ring ring;
  int taken = 0;
  std::atomic<int> done{0};
  {
    Reader reader(ring, [&](const Command&) { ++taken; });
    std::vector<std::thread> senders;
    for (int s = 0; s < kSenders; ++s) {
      senders.emplace_back([&] {
        for (int i = 0; i < kEach; ++i) done += ring.send({}, milliseconds(i % 2), nothing);
      });
    }
    for (std::thread& sender : senders) sender.join();
  }
  EXPECT_EQ(taken, done);
}

}  // namespace command_ring_test
}  // namespace haptic

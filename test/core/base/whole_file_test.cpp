// A file is written whole or not at all. What the disk has no room for leaves the file of before.
#include "haptic_core/base/whole_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "haptic_core/base/error.h"

namespace haptic {
namespace whole_file_test {

std::string read(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

struct Folder {
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
  const std::string path = ::testing::TempDir() + "whole file ö " + std::to_string(::getpid());
};

/// A limit on the size of files acts as a disk that is full.
class NoRoom {
 public:
  explicit NoRoom(rlim_t bytes) : before_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &limit_);
    const rlimit small{bytes, limit_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~NoRoom() {
    ::setrlimit(RLIMIT_FSIZE, &limit_);
    std::signal(SIGXFSZ, before_);
  }

 private:
  rlimit limit_{};
  void (*before_)(int);
};

TEST(WholeFile, HoldsTheTextAndNothingElseIsLeft) {
  const Folder folder;
  const std::string path = folder.path + "/a b.yaml";
  for (const std::string& text : {std::string("one\n"), std::string(1 << 20, 'x'), std::string()}) {
    writeWholeFile(path, text);
    EXPECT_EQ(read(path), text);
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), 1);
}

TEST(WholeFile, IsWrittenThroughALink) {
  const Folder folder;
  writeWholeFile(folder.path + "/file", "1");
  std::filesystem::create_symlink(folder.path + "/file", folder.path + "/link");
  writeWholeFile(folder.path + "/link", "2");
  EXPECT_EQ(read(folder.path + "/file"), "2");
  EXPECT_TRUE(std::filesystem::is_symlink(folder.path + "/link"));
}

TEST(WholeFile, KeepsTheFileOfBeforeWhenThereIsNoRoom) {
  const Folder folder;
  const std::string path = folder.path + "/kept.yaml";
  writeWholeFile(path, "of before");
  {
    const NoRoom room(4096);
    EXPECT_THROW(writeWholeFile(path, std::string(10000, 'x')), SetupError);
  }
  EXPECT_EQ(read(path), "of before");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), 1);
  EXPECT_THROW(writeWholeFile(folder.path + "/none/a", "x"), SetupError);
  EXPECT_THROW(writeWholeFile("/dev/full", "x"), SetupError);
  EXPECT_FALSE(std::filesystem::is_regular_file("/dev/full"));
  std::filesystem::create_directory(folder.path + "/folder");
  EXPECT_THROW(writeWholeFile(folder.path + "/folder", "x"), SetupError);
}

}  // namespace whole_file_test
}  // namespace haptic

// Strict reading of YAML: every complaint names file, line and key, and nothing passes unseen.
#include "haptic_core/base/yaml_map.h"

#include <gtest/gtest.h>

#include <limits>

namespace haptic {
namespace yaml_map_test {

const char kText[] = "mass: 2\nturn: [1, 2.5, -3]\nword: steel\nlight: true\nsteep: .inf\nlist: [a, b]\ntext: 1 2 3\n";
const std::set<std::string> kKnown = {"mass", "turn", "word", "light", "steep", "list", "text", "absent"};

YamlMap read(const std::set<std::string>& known = kKnown) { return YamlMap("file.yaml", YAML::Load(kText), "body", known); }

template <class Read>
std::string complaint(Read&& read) {
  try {
    read();
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

TEST(YamlMap, ReadsWhatIsWritten) {
  const YamlMap map = read();
  EXPECT_EQ(map.number("mass", 7), 2);
  EXPECT_EQ(map.vector("turn"), Vector3(1, 2.5, -3));
  EXPECT_EQ(map.vector("text"), Vector3(1, 2, 3));
  EXPECT_EQ(map.text("word"), "steel");
  EXPECT_TRUE(map.flag("light", false));
  EXPECT_EQ(map.number("absent", 7, 8), 7) << "what a caller takes otherwise is the caller's";
  EXPECT_EQ(map.vector("absent"), Vector3(0, 0, 0));
  EXPECT_EQ(map.text("absent", "wood"), "wood");
}

TEST(YamlMap, ComplainsWithFileLineAndKey) {
  const YamlMap map = read();
  const struct {
    std::string said;
    std::vector<std::string> words;
  } cases[] = {
      {complaint([&] { map.number("turn", 0); }), {"file.yaml:2", "body", "turn", "3 numbers"}},
      {complaint([&] { map.number("steep", 0); }), {"file.yaml:5", "finite"}},
      {complaint([&] { map.number("word", 0); }), {"file.yaml:3", "numbers"}},
      {complaint([&] { map.number("mass", 0, 3); }), {"file.yaml:1", "is 2", "at least 3"}},
      {complaint([&] { map.number("mass", 0, 0, 1); }), {"file.yaml:1", "is 2", "0 to 1"}},
      {complaint([&] { map.vector("turn", 2); }), {"file.yaml:2", "holds 2.5", "up to 2"}},
      {complaint([] { YamlMap("file.yaml", YAML::Load("mass: 1\nword: x\nmass: 1"), "body", kKnown); }),
       {"file.yaml:3", "'mass' stands twice"}},
      {complaint([&] { map.vector("mass"); }), {"file.yaml:1", "1 numbers"}},
      {complaint([&] { map.text("list"); }), {"file.yaml:6", "single"}},
      {complaint([&] { map.flag("word", true); }), {"file.yaml:3", "true or false"}},
      {complaint([&] { map.require("absent", "mass [kg]"); }), {"file.yaml:1", "absent", "mass [kg]"}},
      {complaint([&] { read({"mass"}); }), {"file.yaml:2", "'turn'", "known: mass"}},
      {complaint([&] { YamlMap("file.yaml", map["list"], "list", {}); }), {"file.yaml:6", "mapping"}},
      {complaint([&] { loadYaml("/no/such.yaml"); }), {"/no/such.yaml", "cannot be read"}},
  };
  for (const auto& bad : cases) {
    for (const std::string& word : bad.words) EXPECT_NE(bad.said.find(word), std::string::npos) << word << ": " << bad.said;
  }
}

}  // namespace yaml_map_test
}  // namespace haptic

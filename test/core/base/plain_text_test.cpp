/// Texts of strangers: valid UTF-8 in one line, whatever bytes come in.
#include "haptic_core/base/plain_text.h"

#include <gtest/gtest.h>
#include <iconv.h>

#include <random>

#include "haptic_core/base/error.h"

namespace haptic {
namespace plain_text_test {

/// iconv is the judge.
bool isUtf8(std::string text) {
  const iconv_t judge = iconv_open("UTF-32", "UTF-8");
  std::string out(4 * text.size() + 4, ' ');
  char *from = text.data(), *to = out.data();
  std::size_t left = text.size(), room = out.size();
  const bool valid = iconv(judge, &from, &left, &to, &room) != static_cast<std::size_t>(-1);
  iconv_close(judge);
  return valid;
}

TEST(PlainText, LeavesWhatIsUtf8) {
  const std::string text = "kg/m³ — 手 🤖 %s\t\"/'";
  EXPECT_EQ(validUtf8(text + "\n"), text + "\n");
  EXPECT_EQ(plainText("kg/m³ — 手 🤖"), "kg/m³ — 手 🤖");
}

TEST(PlainText, ReadsOtherBytesAsLatin1) {
  EXPECT_EQ(validUtf8("M\xfcller"), "Müller");
  EXPECT_EQ(validUtf8("\xc3"), "Ã");                          // a character that ends early
  EXPECT_EQ(validUtf8("\xed\xa0\x80"), "í\xc2\xa0\xc2\x80");  // a surrogate
  EXPECT_EQ(validUtf8("\xc0\xaf"), "À¯");                     // not the shortest form of '/'
}

TEST(PlainText, HasOneLine) {
  EXPECT_EQ(plainText("a\nb\rc\x01"
                      "d\x7f"
                      "e\xc2\x85"
                      "f\xe2\x80\xa8"
                      "g\xe2\x80\xa9h\x85i"),
            "a b c d e f g h i");
}

TEST(PlainText, IsValidForRandomBytes) {
  std::mt19937 random(1);
  for (int i = 0; i < 4000; ++i) {
    std::string text;
    for (int n = static_cast<int>(random() % 12); n >= 0; --n)
      text += static_cast<char>(random() % 4 ? 0x80 + random() % 128 : random());
    const std::string valid = validUtf8(text), plain = plainText(text);
    ASSERT_TRUE(isUtf8(valid));
    ASSERT_TRUE(isUtf8(plain));
    ASSERT_EQ(validUtf8(valid), valid);
    ASSERT_EQ(plainText(plain), plain);
    if (isUtf8(text)) {
      ASSERT_EQ(valid, text);
    }
  }
}

TEST(PlainText, MessagesOfAnyTextKeepTheirEnds) {
  std::string text;
  for (int i = 0; i < 50000; ++i) text += "手";  // three bytes each: the cut does not fall between two of them
  const std::string message = SetupError("file.urdf:3", text, "shorten it").what();
  EXPECT_LT(message.size(), SetupError::kLongest + 10);
  EXPECT_EQ(message.rfind("file.urdf:3: ", 0), 0u);
  EXPECT_EQ(message.substr(message.size() - 12), "; shorten it");
  EXPECT_TRUE(isUtf8(message));
}

}  // namespace plain_text_test
}  // namespace haptic

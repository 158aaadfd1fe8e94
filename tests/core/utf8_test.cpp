// What a user relies on: text that is no UTF-8 is recognised, wherever it comes from.

#include "core/utf8.h"

#include <string>

#include <gtest/gtest.h>

#include "core/error.h"

namespace lcpbench::utf8_test {
namespace {

TEST(Utf8Test, SequencesOfEveryLengthAreWhole) {
  const std::string text = "a\u00b5\u2192\U0001F600";
  EXPECT_EQ(utf8_length(text, 0), 1U);
  EXPECT_EQ(utf8_length(text, 1), 2U);
  EXPECT_EQ(utf8_length(text, 3), 3U);
  EXPECT_EQ(utf8_length(text, 6), 4U);
  EXPECT_EQ(utf8_length(text, 2), 0U);  // in the middle of one
}

TEST(Utf8Test, MalformedSequencesHaveNoLength) {
  for (const char* bad : {"\x80", "\xc1\xbf", "\xc2", "\xc2z", "\xe0\x9f\xbf", "\xe2\x86", "\xed\xa0\x80",
                          "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff"}) {
    EXPECT_EQ(utf8_length(bad, 0), 0U) << ::testing::PrintToString(bad);
  }
  EXPECT_EQ(utf8_length("\xed\x9f\xbf", 0), 3U);      // the last before the surrogates
  EXPECT_EQ(utf8_length("\xf4\x8f\xbf\xbf", 0), 4U);  // U+10FFFF
}

TEST(Utf8Test, PrintableTextCommandsNoTerminal) {
  EXPECT_EQ(printable("\x1b[2J\r\n\t\x7f"), "?[2J????");
  EXPECT_EQ(printable("line\n\x1b", "\n"), "line\n?");
  EXPECT_EQ(printable("\u0080\u009b31m\u00a0\u00b5"), "??31m\u00a0\u00b5");  // the controls that are two bytes long
  EXPECT_EQ(printable("a\xff\xc2"), "a??");
  EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a?b");
}

TEST(Utf8Test, WhatCannotBeSeenIsEscapedAsInJson) {
  EXPECT_EQ(printable("box\u202egnp.\u200b"), "box\\u202egnp.\\u200b");
  EXPECT_EQ(printable("\ufeff\u2066a\u2069\u2028\u00ad"), "\\ufeff\\u2066a\\u2069\\u2028\\u00ad");
  EXPECT_EQ(printable("\U000E0041"), "\\udb40\\udc41");
  EXPECT_EQ(printable(printable("\u202e")), "\\u202e");
  EXPECT_EQ(printable("d\u00e9j\u00e0 \u2192 \u03bc \u4e16 \U0001F600"),
            "d\u00e9j\u00e0 \u2192 \u03bc \u4e16 \U0001F600");
  EXPECT_EQ(visible("\u202e\n\xff", "\\\\"), "\\\\u202e\n\xff");  // a page shows what it reads
}

TEST(Utf8Test, ErrorsCommandNoTerminal) { EXPECT_STREQ(InputError("a\u009b31m\n\xff").what(), "a?31m??"); }

TEST(Utf8Test, OneBadByteMakesATextNoUtf8) {
  EXPECT_TRUE(is_utf8(""));
  EXPECT_TRUE(is_utf8("d\u00e9j\u00e0 \U0001F600"));
  EXPECT_FALSE(is_utf8("d\xff"));
  EXPECT_FALSE(is_utf8("d\xc3"));
}

}  // namespace
}  // namespace lcpbench::utf8_test

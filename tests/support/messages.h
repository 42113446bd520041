// What the tools say: tests name a message by its key in tests/messages.txt.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace pvol {

/// How many lines of the text are the message of this key. A `*` in the message stands for
/// anything; the first ones stand for what is `filled` in.
[[nodiscard]] int times_said(const std::string& text, const std::string& key,
                             const std::vector<std::string>& filled = {});

/// Whether any line is. The text is recorded for tests/accept_messages.
[[nodiscard]] ::testing::AssertionResult says(const std::string& text, const std::string& key,
                                              const std::vector<std::string>& filled = {});

}  // namespace pvol

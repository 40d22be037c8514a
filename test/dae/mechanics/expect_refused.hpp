// That a call throws InvalidInput which names `argument` and says `text`.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include <mfs/error.hpp>

namespace mfs::test {

template <class Call>
void expect_refused(const std::string& argument, const std::string& text, Call call) {
  try {
    call();
    ADD_FAILURE() << "nothing was thrown: " << text;
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.argument(), argument);
    EXPECT_THAT(error.what(), testing::HasSubstr(text));
  }
}

}  // namespace mfs::test

// Blocks put together, against the sums that they stand for.
#include "dae/integrator/composition.hpp"

#include <gtest/gtest.h>

namespace mfs::dae {
namespace {

// Columns of the second term go to others, in no order, two of them to one.
TEST(Composition, RowsAscendWhateverTheOrderOfColumns) {
  const Pattern block{2, 3, {0, 3, 5}, {0, 1, 2, 0, 2}};
  const Composition composition(5, {{&block, 1, {0, 1, 2}}, {&block, 1, {4, 1, 1}}}, 2);
  const Pattern& pattern = composition.pattern();
  EXPECT_EQ(pattern.row_start, (std::vector<int>{0, 0, 4, 8, 8, 8}));
  EXPECT_EQ(pattern.column, (RawVector<int>{0, 1, 2, 4, 0, 1, 2, 4}));

  const std::vector<double> first{1, 2, 3, 4, 5}, second{10, 20, 30, 40, 50};
  std::vector<double> values(pattern.entries());
  composition.compose({{first.data(), 1.0}, {second.data(), 2.0}}, values.data());
  EXPECT_EQ(values, (std::vector<double>{1, 2 + 40 + 60, 3, 20, 4, 100, 5, 80}));
}

}  // namespace
}  // namespace mfs::dae

#include "facetsort/order/method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace facetsort {
namespace {

TEST(Method, NamesAreDistinctAndKnown) {
  std::set<std::string_view> names;
  for (const Method method : all_methods()) {
    EXPECT_TRUE(names.insert(method_name(method)).second);
    EXPECT_EQ(method_from_name(method_name(method)), method);
  }
  EXPECT_EQ(names.size(), 9u);
  EXPECT_EQ(depth_key_methods().size(), 6u);
  EXPECT_TRUE(std::none_of(depth_key_methods().begin(), depth_key_methods().end(), is_exact));
  EXPECT_EQ(std::count_if(all_methods().begin(), all_methods().end(), is_exact), 3);
}

TEST(Method, KnowsTheAliasAndNothingElse) {
  EXPECT_EQ(method_from_name("parametric_centre"), Method::centroid_depth);
  EXPECT_FALSE(method_from_name("").has_value());
  EXPECT_FALSE(method_from_name("centroid").has_value());
  EXPECT_FALSE(method_from_name("Centroid_Distance").has_value());
}

}  // namespace
}  // namespace facetsort

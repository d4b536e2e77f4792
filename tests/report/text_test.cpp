#include <gtest/gtest.h>

#include "facetsort/report/html.h"
#include "facetsort/report/number_text.h"

namespace facetsort {
namespace {

TEST(Html, EscapesWhatHasAMeaning) {
  EXPECT_EQ(html_escape("<a href=\"x\">'&'</a>"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
  EXPECT_EQ(html_escape("&lt;"), "&amp;lt;");
  EXPECT_EQ(html_escape("caf\xc3\xa9\n"), "caf\xc3\xa9\n");
  EXPECT_EQ(html_escape("\x1b"), "\xef\xbf\xbd");
}

TEST(Url, EncodesAllButTheUnreserved) {
  EXPECT_EQ(url_path("pictures/a-b_c.1~.png"), "pictures/a-b_c.1~.png");
  EXPECT_EQ(url_path("a b:c?d#e%f\"g&h"), "a%20b%3Ac%3Fd%23e%25f%22g%26h");
  EXPECT_EQ(url_path("\xc3\xa9"), "%C3%A9");
}

TEST(NumberText, PercentKeepsZeroAndAllApart) {
  EXPECT_EQ(percent_text(0), "0");
  EXPECT_EQ(percent_text(1e-9), "<0.0001");
  EXPECT_EQ(percent_text(0.000082), "0.0082");
  EXPECT_EQ(percent_text(0.0463), "4.63");
  EXPECT_EQ(percent_text(0.543), "54.3");
  EXPECT_EQ(percent_text(0.09996), "10.0");
  EXPECT_EQ(percent_text(0.99999), ">99.9");
  EXPECT_EQ(percent_text(1), "100");
}

TEST(NumberText, Milliseconds) {
  EXPECT_EQ(milliseconds_text(0), "0");
  EXPECT_EQ(milliseconds_text(0.0002), "<0.001");
  EXPECT_EQ(milliseconds_text(0.1234), "0.123");
  EXPECT_EQ(milliseconds_text(4.6251), "4.63");
  EXPECT_EQ(milliseconds_text(1240.4), "1240");
}

TEST(NumberText, BytesAndCounts) {
  EXPECT_EQ(bytes_text(0), "0 B");
  EXPECT_EQ(bytes_text(1023), "1023 B");
  EXPECT_EQ(bytes_text(3482), "3.4 KiB");
  EXPECT_EQ(bytes_text(std::size_t{5} << 30), "5.0 GiB");
  EXPECT_EQ(count_text(0), "0");
  EXPECT_EQ(count_text(999), "999");
  EXPECT_EQ(count_text(70580), "70,580");
  EXPECT_EQ(count_text(1234567), "1,234,567");
}

TEST(NumberText, LargestDouble) {
  EXPECT_EQ(fixed_text(1.7976931348623157e308, 2).size(), 312u);
}

}  // namespace
}  // namespace facetsort

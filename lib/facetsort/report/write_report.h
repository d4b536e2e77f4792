// results.json, results.csv and index.html of a comparison.
#pragma once

#include <filesystem>
#include <iosfwd>

#include "facetsort/base/status.h"
#include "facetsort/report/row.h"

namespace facetsort {

// Each file is written under a temporary name and renamed. The page needs no network and refers to the pictures by
// their relative paths; its plots are drawn by gnuplot (found on PATH when called) as SVG inside the page.
Status write_json(const std::filesystem::path& path, const Comparison& comparison);
Status write_csv(const std::filesystem::path& path, const Comparison& comparison);
Status write_page(const std::filesystem::path& path, const Comparison& comparison);

// A table of mesh against strategy (mean inverted and wrong rates, median milliseconds) for a terminal.
void print_summary(std::ostream& out, const Comparison& comparison);

}  // namespace facetsort
